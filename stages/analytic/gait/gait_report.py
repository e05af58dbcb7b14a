"""A gait with all that is said of it: its measures, its energy audit, and whether the model's assumptions hold."""

from __future__ import annotations

from dataclasses import dataclass

from stages.analytic.gait.gait_search import describe, step_lengths
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.walker import Walker
from stages.analytic.phases.section import section_state
from stages.analytic.walk.energy import EnergyAudit, audit
from stages.analytic.walk.recording import Segment, record
from stages.analytic.walk.validity import Validity, assess
from stages.biped.gait import Gait


@dataclass(frozen=True)
class GaitReport:
    """One gait, with the segments of its steps that it was read from, heel strike to heel strike."""

    gait: Gait
    energy: EnergyAudit
    validity: Validity
    segments: list[Segment]


def record_steps(walker: Walker, point: FixedPoint, tolerance: float) -> list[Segment]:
    """The segments of the gait's steps, from heel strike to heel strike."""
    start = section_state(point.z, walker.p)
    return record(walker, start, len(point.steps), tolerance)


def report_gait(walker: Walker, point: FixedPoint, tolerance: float, friction: float) -> GaitReport:
    """Measures, audit and validity of a gait on ground with this static friction."""
    segments = record_steps(walker, point, tolerance)
    energy = audit(walker, segments, sum(step_lengths(walker, point)))
    return GaitReport(describe(walker, point), energy, assess(walker, segments, friction), segments)
