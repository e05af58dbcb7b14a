"""How well the ingest reads the synthetic campaign, leg by leg too. Its truth is known: the method is tested."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.biped.between_steps import running_integral
from stages.biped.quantity import quantity
from stages.calibration.result import HALF_WIDTH
from stages.campaign.result import Result as Campaign, RunTruth, SensorTruth
from stages.comparison.tables import Table
from stages.imu.result import Result as Ingested, Run, SensorSignals
from stages.imu.strikes.step_times import HeelStrikes, step_frequency

#: For Table 1's robot; others have their own time.
EDGE_S = 0.1  # left out at both ends of a walk: there the low pass still holds the push or the end
BEFORE_S = 1.0  # before the first strike: until then the robot stands, however it is pushed


@dataclass(frozen=True)
class LegScore:
    """Errors of the leg's motion, and what the ingest said of them; times in the order of `TIMES`."""

    angle: np.ndarray = quantity("rad", "rms error of the leg angle through each walk, shape (r,)")
    step_run: np.ndarray = quantity("1", "number of the run of each step, shape (k,)")
    step: np.ndarray = quantity("1", "error of each step length, relative, shape (k,)")
    step_said: np.ndarray = quantity("1", "standard error the ingest gives it, relative, shape (k,)")
    way: np.ndarray = quantity("m", "the hip's way from the first strike to the last, shape (r,)")
    twice: np.ndarray = quantity("m", "error of that way by two integrations of the acceleration, shape (r,)")
    times: np.ndarray = quantity("s", "error of times by leg, shape (r, 5)")
    times_said: np.ndarray = quantity("s", "standard errors the ingest gives them, shape (r, 5)")

    def rows(self) -> list[tuple[str, float, float, float]]:
        """A row a quantity: name with unit, rms error, rms of what is said, share of 95 % intervals that hold."""
        angles = self.angle[np.isfinite(self.angle)]
        found = [("leg angle deg", float(np.degrees(np.sqrt(np.mean(angles**2)))), float("nan"), float("nan"))]
        found.append(_row("step length %", self.step, self.step_said, 100.0))
        columns = zip(TIMES, self.times.T, self.times_said.T)
        return found + [_row(f"{name} ms", error, said, 1e3) for name, error, said in columns]


TIMES = ("outer step", "double stance", "inner stance", "inner swing", "outer stance")


def _row(name: str, error: np.ndarray, said: np.ndarray, scale: float) -> tuple[str, float, float, float]:
    known = np.isfinite(error) & np.isfinite(said)
    if not known.any():
        return name, float("nan"), float("nan"), float("nan")
    rms, stated = (scale * float(np.sqrt(np.mean(one[known] ** 2))) for one in (error, said))
    return name, rms, stated, float(np.mean(np.abs(error) <= HALF_WIDTH * said, where=known))


def score_legs(
    runs: Iterable[tuple[Run, RunTruth, float]], skipped: int, gravity: float, quick: float = 1.0
) -> LegScore:
    """Score of runs with their truth and what true time must be shifted by to the run's own times [s]."""
    scores = [_score_leg(run, truth, shift, skipped, gravity, quick) for run, truth, shift in runs]
    angle, step, step_said, way, twice, times, times_said = zip(*scores, strict=True)
    number, steps = np.repeat(np.arange(len(step)), [len(one) for one in step]), map(np.concatenate, (step, step_said))
    return LegScore(np.array(angle), number, *steps, *map(np.array, (way, twice, times, times_said)))


def _score_leg(
    run: Run, truth: RunTruth, shift: float, skipped: int, gravity: float, quick: float
) -> tuple[float, np.ndarray, np.ndarray, float, float, np.ndarray, tuple[float, ...]]:
    """Of one run: angle, steps and their standard errors, way, way by acceleration, times and their standard errors."""
    leg, said = run.leg, run.leg.times
    at = leg.time - shift
    walking = (at > EDGE_S / quick) & (at < truth.leg.time[-1] - EDGE_S / quick)
    off = leg.angle - np.interp(at, truth.leg.time, truth.leg.angle)
    strikes, places = truth.heel_strike_time + shift, truth.leg.hip_at_strike[:, 0]
    start, end = (np.abs(strikes - each[:, None]).argmin(axis=1) for each in (leg.stance_start, leg.stance_end))
    true, way = places[end] - places[start], float(np.ptp(places[[0, -1]]))
    found = said.outer_step, said.double_stance, said.inner_stance, said.inner_swing, said.outer_stance
    return (
        float(np.sqrt(np.mean(off[walking] ** 2))) if walking.any() else float("nan"),
        leg.step_length / true - 1,
        leg.step_length_error / true,
        way,
        way_by_acceleration(run, strikes[[0, -1]], gravity, quick) - way,
        np.array(found) - true_times(truth, skipped),
        (said.step_error, said.double_stance_error, said.inner_error, said.inner_error, said.outer_error),
    )


def way_by_acceleration(run: Run, strikes: np.ndarray, gravity: float, quick: float) -> float:
    """Way of the hip along the slope [m] between two strikes [s], by integrating its acceleration twice from the stand.

    The specific force is turned by the leg's angle, gravity added, its holes drawn over, and what is left of it in the
    still stand taken off. NaN without a hip sensor.
    """
    time, sensed = run.hip.time, run.hip.specific_force
    known = np.isfinite(sensed).all(axis=1) & (time <= strikes[-1]) if len(time) else np.zeros(0, dtype=bool)
    if known.sum() < 2:
        return float("nan")
    at, angle = time[known], np.interp(time[known], run.leg.time, run.leg.angle)
    down = gravity * np.sin(np.radians(run.report.slope_deg))
    along = np.cos(angle) * sensed[known, 0] - np.sin(angle) * sensed[known, 1] + down
    still = at < strikes[0] - BEFORE_S / quick
    along = np.where(still, 0.0, along - (along[still].mean() if still.any() else 0.0))
    speed = running_integral(along, at)
    return float(np.diff(np.interp(strikes, at, running_integral(speed, at)))[0])


def true_times(truth: RunTruth, skipped: int) -> np.ndarray:
    """The true means (5,) [s] in the order of `TIMES`, of the strikes after the first `skipped`."""
    strikes, legs = truth.heel_strike_time[skipped:], truth.heel_strike_leg[skipped:]
    step = np.diff(strikes)
    inner, outer = (float(step[legs[1:] == leg].mean()) for leg in (0, 1))
    double = []
    for leg in (0, 1):
        lifts = truth.leg.toe_off_time[truth.leg.toe_off_leg == leg]
        landed = strikes[legs != leg]
        after = np.searchsorted(lifts, landed)
        double.append(float(np.mean(lifts[after[after < len(lifts)]] - landed[after < len(lifts)])))
    return np.array([outer, double[0], outer + double[0], inner - double[0], inner + double[1]])


STRIKE_TOLERANCE = 0.010  # s, within which a heel strike of Table 1's robot counts as found


@dataclass(frozen=True)
class IngestScore:
    """The ingest's answer for every run against the synthetic truth; one entry a run, shape (r,)."""

    clock_error: np.ndarray = quantity("s", "rms error of the sample times less their mean, the worse sensor")
    clock_delay: np.ndarray = quantity("s", "mean error of the hip's sample times: radio's delay less the low pass's")
    frame_angle: np.ndarray = quantity("deg", "angle of the frame to the true one, the worse sensor")
    recall: np.ndarray = quantity("1", "share of the true heel strikes found within 10 ms, as of Table 1's robot")
    precision: np.ndarray = quantity("1", "share of the heel strikes found that are true ones")
    strike_error: np.ndarray = quantity("s", "rms error of the heel strikes found, less the clock's delay")
    legs_right: np.ndarray = quantity("1", "whether the leg of every strike found is the true one")
    frequency_error: np.ndarray = quantity("1", "relative error of the step frequency")
    leg: LegScore = quantity("-", "leg angle, step lengths and times by leg")

    def leg_table(self) -> Table:
        """Errors of the leg's motion beside what is said of them: (title, columns, rows)."""
        rows: list[tuple[str, ...]] = [
            (name, f"{rms:.3g}", "" if said != said else f"{said:.3g}", "" if held != held else f"{100 * held:.0f}")
            for name, rms, said, held in self.leg.rows()
        ]
        columns = ("quantity", "rms error", "standard error said", "95 % intervals that hold, %")
        return f"Leg motion against the truth of {len(self.recall)} synthetic runs", columns, rows

    def table(self) -> Table:
        """Mean over the runs and the worst of them: (title, columns, rows)."""

        def row(name: str, values: np.ndarray, scale: float = 1.0, least: bool = False) -> tuple[str, ...]:
            sized = scale * np.abs(values)
            return name, f"{sized.mean():.3g}", f"{(sized.min() if least else sized.max()):.3g}"

        rows = [
            row("clock error ms", self.clock_error, 1e3),
            row("frame angle deg", self.frame_angle),
            row("recall of heel strikes", self.recall, least=True),
            row("precision of heel strikes", self.precision, least=True),
            row("heel strike error ms", self.strike_error, 1e3),
            row("step frequency error %", self.frequency_error, 100),
        ]
        title = f"Ingest against the truth of {len(self.recall)} synthetic runs"
        return title, ("measure", "mean", "worst"), rows


def score_ingest(
    campaign: Campaign, imu: Ingested, skipped: int, gravity: float, quick: float = 1.0
) -> IngestScore | None:
    """Score of all accepted runs; None unless each is a run of this campaign. `skipped` strikes have no frequency.

    The robot is so `quick` as Table 1's.
    """
    truths = {truth.name: truth for truth in campaign.runs}
    if any(run.report.name not in truths or run.report.origin != campaign.origin for run in imu.runs):
        return None
    scores = [_score_run(run, truths[run.report.name], skipped, quick) for run in imu.runs]
    columns: list[Any] = [np.array(column) for column in zip(*scores, strict=True)]
    known = [(run, truths[run.report.name]) for run in imu.runs]
    columns.append(score_legs(((run, truth, shift_of(run, truth)) for run, truth in known), skipped, gravity, quick))
    return IngestScore(*columns)


def shift_of(run: Run, truth: RunTruth) -> float:
    """What is added to true time to have a run's own [s]: its clock, and the radio's mean delay."""
    signals, sensor = next(
        (one, true) for one, true in ((run.hip, truth.hip), (run.foot, truth.foot)) if len(one.time)
    )
    delay = float(np.mean(_time_errors(run.start - truth.clock_start, signals, sensor)))
    return delay + sensor.low_pass_delay - run.start + truth.clock_start


def _score_run(
    run: Run, truth: RunTruth, skipped: int, quick: float
) -> tuple[float, float, float, float, float, float, bool, float]:
    from stages.imu.trial.body import angle_between  # here: who reads a score computes none

    sensors = [(run.hip, truth.hip), (run.foot, truth.foot)]
    seen = [(signals, sensor) for signals, sensor in sensors if len(signals.time)]
    errors = [_time_errors(run.start - truth.clock_start, signals, sensor) for signals, sensor in seen]
    delay = float(np.mean(errors[0]))
    # A signal's time is that of its sample less the low pass's delay, so only the radio's delays the strikes.
    at = run.heel_strike_time - shift_of(run, truth)
    nearest = np.abs(at[:, None] - truth.heel_strike_time).argmin(axis=1)
    error = at - truth.heel_strike_time[nearest]
    hit = np.abs(error) <= STRIKE_TOLERANCE / quick
    found = len(set(nearest[hit].tolist()))
    exact, _ = step_frequency(HeelStrikes(truth.heel_strike_time[skipped:], truth.heel_strike_leg[skipped:]))
    return (
        max(float(np.std(one)) for one in errors),
        delay,
        max(angle_between(signals.rotation, sensor.rotation.T) for signals, sensor in seen),
        found / len(truth.heel_strike_time),
        found / len(at),
        float(np.sqrt(np.mean(error[hit] ** 2))) if hit.any() else float("nan"),
        bool((run.heel_strike_leg == truth.heel_strike_leg[nearest])[hit].all()),
        run.report.step_frequency / exact - 1,
    )


def _time_errors(shift: float, signals: SensorSignals, truth: SensorTruth) -> np.ndarray:
    """Time of each sample on the phone's clock less `shift`, minus the true time at which it was sampled (n,) [s]."""
    true = dict(zip(zip(truth.packet.tolist(), truth.position.tolist()), truth.sample_time.tolist()))
    keys = zip(signals.packet.astype(int).tolist(), signals.position.astype(int).tolist())
    return np.asarray(signals.time + shift - np.array([true[key] for key in keys]))
