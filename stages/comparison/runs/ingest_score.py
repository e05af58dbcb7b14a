"""How well the ingest reads the synthetic campaign, whose truth is known: a test of the method, not of the model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.biped.quantity import quantity
from stages.campaign.result import Result as Campaign
from stages.campaign.result import RunTruth, SensorTruth
from stages.comparison.runs.leg_score import LegScore, score_legs
from stages.comparison.tables import Table
from stages.imu.result import Result as Ingested
from stages.imu.result import Run, SensorSignals
from stages.imu.strikes.landings import HeelStrikes
from stages.imu.strikes.step_frequency import step_frequency
from stages.imu.trial.frames import angle_between

STRIKE_TOLERANCE = 0.010  # s, within which a heel strike of Table 1's robot counts as found


@dataclass(frozen=True)
class IngestScore:
    """The ingest's answer for every run against the synthetic truth; one entry a run, shape (r,)."""

    clock_error: np.ndarray = quantity("s", "rms error of the sample times less their mean, the worse sensor")
    clock_delay: np.ndarray = quantity("s", "mean error of the hip's sample times: radio's delay less the low pass's")
    frame_angle: np.ndarray = quantity("deg", "angle of the frame to the true one, the worse sensor")
    recall: np.ndarray = quantity("1", "share of the true heel strikes found within 10 ms")
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
    exact = step_frequency(HeelStrikes(truth.heel_strike_time[skipped:], truth.heel_strike_leg[skipped:]))
    return (
        max(float(np.std(one)) for one in errors),
        delay,
        max(angle_between(signals.rotation, sensor.rotation.T) for signals, sensor in seen),
        found / len(truth.heel_strike_time),
        found / len(at),
        float(np.sqrt(np.mean(error[hit] ** 2))) if hit.any() else float("nan"),
        bool((run.heel_strike_leg == truth.heel_strike_leg[nearest])[hit].all()),
        run.report.step_frequency / exact.value - 1,
    )


def _time_errors(shift: float, signals: SensorSignals, truth: SensorTruth) -> np.ndarray:
    """Time of each sample on the phone's clock less `shift`, minus the true time at which it was sampled (n,) [s]."""
    true = dict(zip(zip(truth.packet.tolist(), truth.position.tolist()), truth.sample_time.tolist()))
    keys = zip(signals.packet.astype(int).tolist(), signals.position.astype(int).tolist())
    return np.asarray(signals.time + shift - np.array([true[key] for key in keys]))
