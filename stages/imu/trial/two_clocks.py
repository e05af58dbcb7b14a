"""Two sensors on one clock: by their stamps, and where those do not tell, by their motion alone.

Hip and foot ride on one leg and turn as one. Stamps come first: the foot's lag is looked for within half a step of
them. Where the two then do not turn as one, or each is dated by its own clock, all of both recordings is laid over each
other: the stand, the push and the transient after it are there once, where the walk repeats itself.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import fftconvolve
from scipy.special import fdtri

from stages.imu.judgement.evidence import agreement_of
from stages.imu.parameters import Limits, Settings
from stages.imu.strikes.heel_strikes import step_period
from stages.imu.trial.body import LATERAL, MOVING, PLACES, BodySensor, common_grid, on_grid

PASSES = 3  # of least squares: from half a row of the grid to its rounding
COVERED = 0.5  # of one sensor's motion: less of it, laid over the other's, is no ground to bring them together
ROUND_OFF = 1e-12  # of the rates' squares
AS_GOOD = 0.99  # level of the test whether another lag leaves more than noise does


@dataclass(frozen=True)
class Together:
    """The sensors with the foot's times on the hip's clock.

    `lag` is what was taken off the foot's stamps [s], for clocks of their own what was left of it at last, with its
    standard error where the leg moves; `at_edge` whether more than half a step would be needed; `other_lag` by how
    much later [s] the foot would fit as well, NaN where nowhere.
    """

    sensors: dict[str, BodySensor]
    lag: float = math.nan
    lag_error: float = math.nan
    at_edge: bool = False
    other_lag: float = math.nan


def have_own_clocks(sensors: Mapping[str, BodySensor]) -> bool:
    """Whether there are two sensors and each is dated by its own clock."""
    return len(sensors) == 2 and all(sensor.trace.clock.stamp == "device" for sensor in sensors.values())


def brought_together(sensors: dict[str, BodySensor], settings: Settings, limits: Limits) -> Together:
    """The sensors on one clock; as they are where one is alone."""
    if len(sensors) < 2:
        return Together(sensors)
    own = have_own_clocks(sensors)
    near = Together(sensors) if own else _by_stamps(sensors, settings)
    if not own and _alike(near.sensors, settings) >= limits.usual_agreement:
        return near
    apart, other = _whole(sensors, settings)
    far = replace(_by_stamps(_later(sensors, -apart), settings, own), other_lag=other)
    if own:
        return far
    if not _alike(far.sensors, settings) >= limits.agreement_by_motion:
        return near
    return replace(far, lag=apart + far.lag)


def _later(sensors: Mapping[str, BodySensor], by: float | np.ndarray) -> dict[str, BodySensor]:
    foot = sensors["foot"]
    return {"hip": sensors["hip"], "foot": replace(foot, time=foot.time + by)}


def _rates(sensors: dict[str, BodySensor], settings: Settings) -> tuple[np.ndarray, ...]:
    """Times (n,) [s] that both cover, and the lateral rates of hip and foot."""
    grid = common_grid(sensors, settings)
    return grid, *(on_grid(sensors[place], grid, settings)[:, 3 + LATERAL] for place in PLACES)


def _alike(sensors: dict[str, BodySensor], settings: Settings) -> float:
    """Signed squared correlation of their lateral rates; NaN where they share too little."""
    return agreement_of(*_rates(sensors, settings)[1:])[0]


def _by_stamps(sensors: dict[str, BodySensor], settings: Settings, drifting: bool = False) -> Together:
    """The foot's lag within half a step, taken off; of clocks that are `drifting` apart, that as well.

    Least difference of the two rates, one of which may be turned round, to a row of the grid; where that is no end of
    the search, by least squares from there. The error takes what is left of a step as one piece of evidence. Rows count
    where both have samples: a line drawn through a hole is not what the leg did.
    """
    dt = 1 / settings.grid_rate_hz
    _, hip, foot = _rates(sensors, settings)
    if len(hip) < 3 * settings.grid_rate_hz:
        return Together(sensors, 0.0)
    period = _period(hip, foot, dt, (settings.slowest_step_hz, settings.fastest_step_hz))
    if not math.isfinite(period):
        return Together(sensors, 0.0)
    reach = max(2, int(0.5 * period / dt))
    lags, inner = np.arange(-reach, reach + 1), slice(reach, len(hip) - reach)
    best = int(np.argmin([_difference(hip[inner], np.roll(foot, -lag)[inner]) for lag in lags]))
    lag, spread = float(lags[best] * dt), math.nan
    sensors = _later(sensors, -lag)
    if not 0 < best < len(lags) - 1:
        return Together(sensors, lag, at_edge=True)
    for _ in range(PASSES):
        time, hip, foot = _rates(sensors, settings)
        changing, middle = np.gradient(foot, dt), time.mean()
        both = np.isfinite(hip) & np.isfinite(foot) & np.isfinite(changing)
        if not both.any():
            return Together(sensors, lag)
        time, hip, foot, changing = (one[both] for one in (time, hip, foot, changing))
        columns = np.column_stack((changing, changing * (time - middle)))[:, : 1 + drifting]
        more = np.linalg.lstsq(columns, hip - foot, rcond=None)[0]
        growth = more[1] if drifting and abs(more[1]) < settings.rate_tolerance else 0.0
        sensors = _later(sensors, -more[0] - growth * (sensors["foot"].time - middle))
        lag += float(more[0])
        of_steps = np.bincount(((time - time[0]) / period).astype(int), (hip - foot - columns @ more) * changing)
        spread = math.sqrt(float(of_steps @ of_steps)) / float(changing @ changing)
    return Together(sensors, lag, spread)


def _difference(hip: np.ndarray, foot: np.ndarray) -> float:
    """Mean square of two rates' difference, one of which may be turned round, where both are there; else infinite."""
    both = np.isfinite(hip) & np.isfinite(foot)
    hip, foot = hip[both], foot[both]
    return min(float(np.mean((hip - foot) ** 2)), float(np.mean((hip + foot) ** 2))) if both.any() else math.inf


def _whole(sensors: Mapping[str, BodySensor], settings: Settings) -> tuple[float, float]:
    """How much later the foot's stamps are by the whole of both recordings [s], and `Together.other_lag`."""
    dt = 1 / settings.grid_rate_hz
    grids = {place: common_grid({place: sensors[place]}, settings) for place in PLACES}
    hip, foot = (on_grid(sensors[place], grid, settings)[:, 3 + LATERAL] for place, grid in grids.items())
    rows, more = whole_lag(hip, foot, dt, (settings.slowest_step_hz, settings.fastest_step_hz))
    return float(grids["foot"][0] - grids["hip"][0]) - rows * dt, more * dt if more else math.nan


def whole_lag(hip: np.ndarray, foot: np.ndarray, dt: float, step_band_hz: tuple[float, float]) -> tuple[int, int]:
    """Rows by which the foot's rate (m,) must be moved to lie on the hip's (n,), by the whole of both, and by how many
    more it would lie there as well; 0 for none.

    Least difference of the two over their size where both have samples, of all lags at which that is most of the
    motion of one. Another, half a step away or more, is as good where it leaves no more than chance may leave in so
    many steps (F test).
    """
    shift = np.arange(len(hip) + len(foot) - 1) - (len(foot) - 1)  # row k of the hip beside row k - shift of the foot
    hip_there, foot_there = np.isfinite(hip), np.isfinite(foot)
    period, (hip, foot) = _period(hip, foot, dt, step_band_hz), map(np.nan_to_num, (hip, foot))
    of_hip, of_foot = fftconvolve(hip**2, foot_there[::-1]), fftconvolve(hip_there, foot[::-1] ** 2)
    if not (of_hip.max() > 0 and of_foot.max() > 0 and math.isfinite(period)):
        return 0, 0
    covered = np.maximum(of_hip / of_hip.max(), of_foot / of_foot.max()) >= COVERED
    product = fftconvolve(hip, foot[::-1])
    left = np.where(covered, 1 - 2 * product / np.maximum(of_hip + of_foot, 1e-300), np.inf)
    best = int(np.argmin(left))
    other = int(np.argmin(np.where(np.abs(shift - shift[best]) > 0.5 * period / dt, left, np.inf)))
    steps = max(1.0, np.count_nonzero(np.abs(hip) > MOVING * np.abs(hip).max()) * dt / period)
    as_good = left[other] <= fdtri(steps, steps, AS_GOOD) * max(left[best], ROUND_OFF)
    return int(shift[best]), int(shift[other] - shift[best]) if as_good else 0


def _period(hip: np.ndarray, foot: np.ndarray, dt: float, step_band_hz: tuple[float, float]) -> float:
    """Duration of a step [s] by the one of two rates that has the fewer holes."""
    return step_period(min(hip, foot, key=lambda one: np.count_nonzero(np.isnan(one))), dt, step_band_hz)


def overlap_of(first: BodySensor, second: BodySensor) -> float:
    """Share of the longer motion that both cover, from where each begins to turn to where it ends."""
    spans = []
    for sensor in (first, second):
        size = np.abs(np.nan_to_num(sensor.rate[:, LATERAL]))
        moving = sensor.time[size > MOVING * size.max()]
        spans.append((moving[0], moving[-1]) if len(moving) else (sensor.time[0], sensor.time[-1]))
    (a, b), (c, d) = spans
    return float(max(0.0, min(b, d) - max(a, c)) / max(b - a, d - c, 1e-9))
