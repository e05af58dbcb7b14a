"""How well the ingest reads the leg's motion of synthetic runs: angle, steps and times by leg against the truth."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stages.biped.between_steps import running_integral
from stages.biped.quantity import quantity
from stages.calibration.result import HALF_WIDTH
from stages.campaign.result import RunTruth
from stages.imu.result import Run

#: For Table 1's robot; others have their own time.
EDGE_S = 0.1  # left out at both ends of a walk: there the low pass still feels the push or the end
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
    rms, told = (scale * float(np.sqrt(np.mean(one[known] ** 2))) for one in (error, said))
    return name, rms, told, float(np.mean(np.abs(error) <= HALF_WIDTH * said, where=known))


def score_legs(
    runs: Iterable[tuple[Run, RunTruth, float]], skipped: int, gravity: float, quick: float = 1.0
) -> LegScore:
    """Score of runs with their truth and what true time must be shifted by to the run's own times [s]."""
    angle, number, step, step_said, times, times_said = [], [], [], [], [], []
    way, twice = [], []
    for place, (run, truth, shift) in enumerate(runs):
        leg = run.leg
        at = leg.time - shift
        walking = (at > EDGE_S / quick) & (at < truth.leg.time[-1] - EDGE_S / quick)
        off = leg.angle - np.interp(at, truth.leg.time, truth.leg.angle)
        angle.append(float(np.sqrt(np.mean(off[walking] ** 2))) if walking.any() else float("nan"))
        strikes = truth.heel_strike_time + shift
        ends = [np.abs(strikes - each[:, None]).argmin(axis=1) for each in (leg.stance_start, leg.stance_end)]
        true = truth.leg.hip_at_strike[ends[1], 0] - truth.leg.hip_at_strike[ends[0], 0]
        number += [place] * len(true)
        step += list(leg.step_length / true - 1)
        step_said += list(leg.step_length_error / true)
        way.append(float(np.ptp(truth.leg.hip_at_strike[[0, -1], 0])))
        twice.append(way_by_acceleration(run, strikes[[0, -1]], gravity, quick) - way[-1])
        said = leg.times
        found = (said.outer_step, said.double_stance, said.inner_stance, said.inner_swing, said.outer_stance)
        times.append(np.array(found) - true_times(truth, skipped))
        inner = said.inner_error
        times_said.append([said.step_error, said.double_stance_error, inner, inner, said.outer_error])
    flat = (np.array(one) for one in (angle, number, step, step_said, way, twice))
    return LegScore(*flat, *(np.array(one).reshape(-1, len(TIMES)) for one in (times, times_said)))


def way_by_acceleration(run: Run, strikes: np.ndarray, gravity: float, quick: float) -> float:
    """Way of the hip along the slope [m] between two strikes [s], by integrating its acceleration twice from the stand.

    The specific force is turned by the leg's angle, gravity added, its holes drawn over, and what is left of it in the
    still stand taken off. NaN without a hip sensor.
    """
    time, felt = run.hip.time, run.hip.specific_force
    known = np.isfinite(felt).all(axis=1) & (time <= strikes[-1]) if len(time) else np.zeros(0, dtype=bool)
    if known.sum() < 2:
        return float("nan")
    at, angle = time[known], np.interp(time[known], run.leg.time, run.leg.angle)
    down = gravity * np.sin(np.radians(run.report.slope_deg))
    along = np.cos(angle) * felt[known, 0] - np.sin(angle) * felt[known, 1] + down
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
