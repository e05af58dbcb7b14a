"""A gait with all that is said of it: its measures, its energy audit, and whether the model's assumptions hold."""

from __future__ import annotations

from dataclasses import dataclass

from stages.analytic.gait.gait_search import describe, step_length
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.walker import Walker
from stages.analytic.phases.section import section_state
from stages.analytic.walk.energy import EnergyAudit, audit
from stages.analytic.walk.recording import Segment, record
from stages.analytic.walk.validity import Validity, assess
from stages.biped.gait import Gait


@dataclass(frozen=True)
class GaitReport:
    """One gait of one step, with the segments it was read from, heel strike to heel strike."""

    gait: Gait
    energy: EnergyAudit
    validity: Validity
    segments: list[Segment]


def record_step(walker: Walker, point: FixedPoint, tolerance: float) -> list[Segment]:
    """The segments of the gait's step, from heel strike to heel strike."""
    start = section_state(point.z, walker.p)
    return record(walker, start, 1, tolerance)


def report_gait(walker: Walker, point: FixedPoint, tolerance: float, friction: float) -> GaitReport:
    """Measures, audit and validity of a gait of one step on ground with this static friction."""
    segments = record_step(walker, point, tolerance)
    energy = audit(walker, segments, step_length(walker, point))
    return GaitReport(describe(walker, point), energy, assess(walker, segments, friction), segments)
