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
from stages.analytic.walk.recording import Segment, is_last, record, rise
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
class PutDown:
    """Where feet come to stand that are put down at a given time, and the slope of the path that they walk so."""

    rise_m: np.ndarray = quantity(
        "m", "height over the other foot's ground at which each foot is put down", dimensions=("step",))
    slope_walked_deg: float = quantity("deg", "slope of the way from foot to foot, downhill positive")


def put_down(walker: Walker, segments: list[Segment], advance: float) -> PutDown | None:
    """Where the feet come to stand in steps that advance by `advance` leg lengths; None where they land themselves."""
    if not walker.timed:
        return None
    rises = np.array([rise(walker, segment) for segment in segments if is_last(segment)])
    slope = np.arctan2(walker.p.g_x, -walker.p.g_y) - np.arctan2(rises.sum(), advance)
    return PutDown(rises * walker.length, float(np.degrees(slope)))


@dataclass(frozen=True)
class GaitReport:
    """One gait, with the segments of its steps that it was read from, heel strike to heel strike."""

    gait: Gait
    energy: EnergyAudit
    validity: Validity
    segments: list[Segment]
    limp: Limp | None
    put_down: PutDown | None = None


def record_steps(walker: Walker, point: FixedPoint, tolerance: float) -> list[Segment]:
    """The segments of the gait's steps, from heel strike to heel strike."""
    start = section_state(point.z, walker.p)
    return record(walker, start, len(point.steps), tolerance)


def report_gait(walker: Walker, point: FixedPoint, tolerance: float, friction: float) -> GaitReport:
    """Measures, audit and validity of a gait on ground with this static friction."""
    segments = record_steps(walker, point, tolerance)
    advance = sum(step_lengths(walker, point))
    return GaitReport(
        describe(walker, point), audit(walker, segments, advance), assess(walker, segments, friction), segments,
        limp_of(walker, point), put_down(walker, segments, advance))
