"""What the sensors of a run say of the walk: heel strikes, the leg's motion, and its strides laid over each other.

Leg angle, step length and hip path come from one integration: the lateral rate, and the foot that rolls. Integrating
the acceleration twice drifts with the square of time; the rate less its bias at rest, integrated once, does not. While
the inner leg stands, its foot rolls without slip, so with theta = -phi the hip is at

    x = r theta + (L - r) sin theta,    y = r + (L - r) cos theta

from where the leg would stand upright (paper, eq. 3). Over the other leg's stance nothing carries the sensors' leg, and
nothing is said.
"""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stages.biped.walk import SENSOR_SIGNALS
from stages.imu.clock.clock import resample
from stages.imu.parameters import Drawing, Parameters, Settings, filter_delay
from stages.imu.result import Ensemble, LegMotion, StepTimes
from stages.imu.strikes.heel_strikes import NO_STRIKES, find_heel_strikes, mean_and_variance
from stages.imu.strikes.impact_onset import Samples, at_onsets, lift_after
from stages.imu.strikes.step_times import OUTER, UNKNOWN, HeelStrikes, stances_of, step_times
from stages.imu.trial.body import FORWARD, LATERAL, PLACES, UP, BodySensor, GridSignals, common_grid, on_grid

PATH_POINTS = 51
#: For Table 1's robot; others have their own time.
ROUNDED_S = 0.012  # how far a low pass rounds the corner of a landing off
CONTINUED_S = 0.08  # from how far inside the angle is continued to a landing
FEWEST_POINTS = 8
#: Rate of the runs of which errors in time were measured, and the power of a longer period with which they grow: steps
#: of twenty runs were off by 0.7 ms rms at 100 Hz, by 2.1 ms at 50 Hz and by 7.9 ms at 40 Hz.
RATE_HZ, COARSER = 100.0, 2.5
FEWEST_SHOWN = 0.1  # of the strikes, that an error grows by
#: A foot's sensor alone shows its own foot let go, and not the outer leg's landing, a double stance before: of six runs
#: steps were off by 6 ms and lengths by 4.5 to 9.4 mm, which is 0.6 to 1.4 of the standard errors that follow.
LET_GO_S = 0.006


def strikes_of(
    sensors: Mapping[str, BodySensor], settings: Settings, quick: float = 1.0
) -> tuple[HeelStrikes, float]:
    """Heel strikes of the run, and the corner of the low pass they show [Hz], NaN if they show none.

    From the hip sensor, which seldom clips, with the help of the foot's, which turns with it in its holes; else from
    the foot's. A reading at full scale is a blow like others: rigid legs give many. They are found in the time of a
    robot that is so `quick` as Table 1's, for which windows were chosen.
    """
    present = [place for place in PLACES if place in sensors]
    if not present:
        return NO_STRIKES, math.nan
    first, *rest = present
    # Between the points of a coarser grid a blow would be lost.
    finest = max(settings.grid_rate_hz, sensors[first].trace.rate_hz)
    grid = common_grid({first: sensors[first]}, replace(settings, grid_rate_hz=finest))
    values = on_grid(sensors[first].saturated, grid, settings)
    beside = [on_grid(sensors[place].saturated, grid, settings)[:, [FORWARD, UP, 3 + LATERAL]] for place in rest]
    others, rate = [values[:, [3 + LATERAL]], *beside], values[:, 3 + LATERAL]
    for one in beside:
        rate = np.where(np.isfinite(rate), rate, one[:, -1])
    band = (settings.slowest_step_hz / quick, settings.fastest_step_hz / quick)
    found = find_heel_strikes(quick * grid, values[:, [FORWARD, UP]], rate, np.hstack(others), band)
    begun, corner = at_onsets(found, samples_of(sensors[first], [FORWARD, UP], quick), settings.skipped_steps)
    return HeelStrikes(begun.time / quick, begun.leg), corner * quick


def samples_of(sensor: BodySensor, axes: list[int], quick: float) -> Samples:
    """The sensor's samples of the force on these axes, in the time of a robot that is so `quick` as Table 1's.

    Where an axis of the sensor clips, all that it has a part in may lie beyond.
    """
    trace, taken = sensor.trace, filter_delay(sensor.trace.indexed.recording.device.bandwidth_hz)
    outward = np.where(np.isnan(trace.specific_force), np.sign(trace.readings), 0.0) @ sensor.frame.rotation.T
    return Samples(quick * sensor.time, sensor.saturated.force[:, axes], np.sign(outward[:, axes]),
                   trace.rate_hz / quick, quick * taken)  # fmt: skip


def hip_at(angle: np.ndarray, drawing: Drawing) -> np.ndarray:
    """Hip (..., 2) [m] along and above the slope, from where a leg at these angles (...) [rad] would stand upright."""
    theta, r = -angle, drawing.foot_radius
    above = drawing.leg_length - r
    return np.stack([r * theta + above * np.sin(theta), r + above * np.cos(theta)], axis=-1)


def stance_angle(time: np.ndarray, angle: np.ndarray, start: float, end: float) -> np.ndarray:
    """The angle [rad] at `PATH_POINTS` even times from one landing to the next, as if nothing were beside.

    A landing changes the rate at once, and a sensor's low pass rounds that corner off: what is near to a landing is
    continued, by a cubic, from the stance's inside.
    """
    at = np.linspace(start, end, PATH_POINTS)
    found = np.asarray(np.interp(at, time, angle))
    for landing, inward in ((start, 1.0), (end, -1.0)):
        depth = inward * (time - landing)
        inside, near = (depth >= ROUNDED_S) & (depth <= CONTINUED_S), inward * (at - landing) < ROUNDED_S
        if inside.sum() >= FEWEST_POINTS and 0.5 * (end - start) > CONTINUED_S:
            cubic = np.polynomial.Polynomial.fit(depth[inside], angle[inside], 3)
            found[near] = cubic(inward * (at[near] - landing))
    return found


def leg_motion(
    time: np.ndarray,
    angle: np.ndarray,
    rest_angle: float,
    bias_error: float,
    confirmed: tuple[float, float],
    strikes: HeelStrikes,
    times: StepTimes,
    drawing: Drawing,
    quick: float = 1.0,
    late: float = 0.0,
) -> LegMotion:
    """The motion of the leg from its angle (m,) on an even grid (m,) [s].

    The angle's error is that of the stand, of the gyroscopes' gain on what was turned since, of the bias,
    `bias_error` [rad/s], on the time since the grid began, and of how `late` [s] the angle may be. A step's is that of
    the gain, of the leg's length, of when each leg's impacts begin and of both landings' own times, and what rolling on
    a compliant leg departs from a rigid one; those of gain and length are `confirmed`, relative. The robot is so
    `quick` as Table 1's.
    """
    gain, of_length = confirmed
    since = time - time[0] if len(time) else time
    stand = math.radians(drawing.stand_error_deg)
    delayed = late * np.gradient(angle, time)
    error = np.sqrt(stand**2 + (gain * (angle - rest_angle)) ** 2 + (bias_error * since) ** 2 + delayed**2)
    start, end = stances_of(strikes)
    inside = (start >= time[0]) & (end <= time[-1]) if len(time) else np.zeros(len(start), dtype=bool)
    start, end = start[inside], end[inside]
    swept = [stance_angle(quick * time, angle, quick * one, quick * other) for one, other in zip(start, end)]
    path = hip_at(np.array(swept).reshape(-1, PATH_POINTS), drawing)
    length = path[:, -1, 0] - path[:, 0, 0]
    share = math.sqrt(gain**2 + of_length**2 + drawing.rolling_error**2)
    apart = (end - start) / (PATH_POINTS - 1)
    ends = (path[:, [1, -1], 0] - path[:, [0, -2], 0]) / apart[:, None]  # speeds at both landings
    landed = math.hypot(drawing.onset_error_s, drawing.strike_scatter_s)
    said = np.sqrt((share * length) ** 2 + landed**2 * (ends**2).sum(axis=1))
    path[:, :, 0] -= path[:, :1, 0]
    drawn = of_length * length
    return LegMotion(time, angle, error, start, end, length, said, drawn, path, times)


def leg_of(
    sensors: Mapping[str, BodySensor], common: GridSignals, strikes: HeelStrikes, corner_hz: float,
    confirmed: tuple[float, float], drawing: Drawing, parameters: Parameters,
) -> LegMotion:
    """The leg's motion from the rates of all sensors, where several see it from their mean; toe-off from the foot's.

    The drawing has errors of when things happen as `at_slowest` gives them. A low pass that is not declared delays the
    angle, by what strikes show of it, where it delays no strike.
    """
    quick, none = parameters.quick, np.empty(0)
    if len(common.time) < 2:
        return LegMotion(none, none, none, none, none, none, none, none, np.empty((0, PATH_POINTS, 2)), UNKNOWN)
    errors = [sensor.bias_error() for sensor in sensors.values()]
    declared = [sensor.trace.indexed.recording.device.bandwidth_hz is not None for sensor in sensors.values()]
    late, lift = filter_delay(corner_hz) * (1 - np.mean(declared)), math.nan
    if "foot" in sensors:
        landed = quick * strikes.time[strikes.leg == OUTER]
        lift = lift_after(landed, samples_of(sensors["foot"], [UP], quick), corner_hz / quick) / quick
    return leg_motion(
        common.time,
        np.mean(list(common.angle.values()), axis=0),
        math.radians(parameters.settings.rest_leg_angle_deg),
        math.sqrt(sum(error**2 for error in errors)) / len(errors),
        confirmed,
        strikes,
        step_times(strikes, lift, drawing),
        drawing,
        quick,
        float(np.nan_to_num(late)),
    )


def at_slowest(sensors: Mapping[str, BodySensor], parameters: Parameters, hidden: float) -> Drawing:
    """The drawing with errors of when things happen as they are at the slowest sensor's rate, with so many (1) of the
    strikes `hidden` in holes, and of sensors without a hip's."""
    rates = [sensor.trace.indexed.recording.device.rate_hz for sensor in sensors.values()]
    found = in_time(parameters.drawing, parameters.quick, min(rates, default=RATE_HZ), hidden)
    least = 0.0 if "hip" in sensors else LET_GO_S / parameters.quick
    return replace(found, onset_error_s=max(found.onset_error_s, least))


def in_time(drawing: Drawing, quick: float, rate_hz: float, hidden: float = 0.0) -> Drawing:
    """The errors of when things happen as they are at this rate, of a robot that is so `quick` as Table 1's: they were
    measured for that one, at 100 Hz. They are of a mean over strikes, of which `hidden` (1) show nothing of it.
    """
    by = max(RATE_HZ * quick / rate_hz, 1.0) ** COARSER / quick / math.sqrt(max(1.0 - hidden, FEWEST_SHOWN))
    return replace(drawing, onset_error_s=by * drawing.onset_error_s, strike_scatter_s=by * drawing.strike_scatter_s,
                   toe_off_error_s=by * drawing.toe_off_error_s)  # fmt: skip


def register(time: np.ndarray, signals: np.ndarray, bounds: np.ndarray, points: int, longest_step: float) -> np.ndarray:
    """Signals (n, k) at times (n,) cut into strides (s, 2) and stretched to `points` phases: (s, points, k).

    Holes longer than `longest_step` [s] stay NaN. Each column has its own holes.
    """
    phase = np.linspace(0.0, 1.0, points)
    grid = bounds[:, :1] + (bounds[:, 1:] - bounds[:, :1]) * phase
    columns = [resample(time, signals[:, [i]], grid.ravel(), longest_step)[:, 0] for i in range(signals.shape[1])]
    return np.stack(columns, axis=-1).reshape(len(bounds), points, signals.shape[1])


def registered(sensors: Mapping[str, BodySensor], bounds: np.ndarray, settings: Settings) -> np.ndarray:
    """Signals of all strides (s, p, 6) in the order of `SENSOR_SIGNALS`; NaN for a sensor that is missing."""
    strides = np.full((len(bounds), settings.phase_points, len(SENSOR_SIGNALS)), np.nan)
    for first, place in ((0, "hip"), (3, "foot")):
        if place in sensors and len(bounds):
            sensor = sensors[place]
            signals = np.column_stack((sensor.force[:, [FORWARD, UP]], sensor.rate[:, LATERAL]))
            strides[:, :, first : first + 3] = register(
                sensor.time, signals, bounds, settings.phase_points, sensor.longest_step(settings)
            )
    return strides


def ensemble_of(strides: np.ndarray) -> Ensemble:
    """The ensemble of strides (s, p, k). A phase no stride covers is NaN; the spread needs two strides."""
    count, mean, variance = mean_and_variance(strides)
    known, seen = np.isfinite(strides), count > 0
    return Ensemble(
        phase=np.linspace(0.0, 1.0, strides.shape[1]),
        mean=mean,
        spread=np.sqrt(variance),
        lower=np.where(seen, np.where(known, strides, np.inf).min(axis=0, initial=np.inf), np.nan),
        upper=np.where(seen, np.where(known, strides, -np.inf).max(axis=0, initial=-np.inf), np.nan),
        count=count,
    )
