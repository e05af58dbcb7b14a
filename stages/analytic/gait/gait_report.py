"""A gait with all that is said of it: its measures, its energy audit, and whether the model's assumptions hold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.analytic.gait.gait_search import describe, step_lengths
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.walker import Walker
from stages.analytic.phases.section import section_state
from stages.analytic.result import EnergyAudit, Validity
from stages.analytic.walk.energy import audit
from stages.analytic.walk.recording import Segment, record
from stages.analytic.walk.validity import assess
from stages.biped.gait import Gait
from stages.biped.quantity import quantity


@dataclass(frozen=True)
class Limp:
    """How a gait of legs that differ limps: its two steps, first that in which the first leg stands."""

    period_s: np.ndarray = quantity("s", "duration of each of the two steps", dimensions=("step",))
    step_length_m: np.ndarray = quantity("m", "length of each of the two steps", dimensions=("step",))
    limp: float = quantity("1", "difference of their durations, as part of the mean; zero does not limp")


def limp_of(walker: Walker, point: FixedPoint) -> Limp | None:
    """How a gait limps; None where the legs are alike."""
    if not walker.alternates:
        return None
    periods = np.array([step.period for step in point.steps]) * walker.time
    lengths = np.array(step_lengths(walker, point)) * walker.length
    return Limp(periods, lengths, float(np.ptp(periods) / periods.mean()))


@dataclass(frozen=True)
class GaitReport:
    """One gait, with the segments of its steps that it was read from, heel strike to heel strike."""

    gait: Gait
    energy: EnergyAudit
    validity: Validity
    segments: list[Segment]
    limp: Limp | None


def record_steps(walker: Walker, point: FixedPoint, tolerance: float) -> list[Segment]:
    """The segments of the gait's steps, from heel strike to heel strike."""
    start = section_state(point.z, walker.p)
    return record(walker, start, len(point.steps), tolerance)


def report_gait(walker: Walker, point: FixedPoint, tolerance: float, friction: float) -> GaitReport:
    """Measures, audit and validity of a gait on ground with this static friction."""
    segments = record_steps(walker, point, tolerance)
    energy = audit(walker, segments, sum(step_lengths(walker, point)))
    return GaitReport(describe(walker, point), energy, assess(walker, segments, friction), segments,
                      limp_of(walker, point))
