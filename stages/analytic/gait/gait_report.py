"""A gait with all that is said of it: its measures, its energy audit, and whether the model's assumptions hold."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from stages.analytic.compiled import Numbers
from stages.analytic.gait.gait_search import describe, feet_apart, step_lengths
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import Detailed, Kind, Rigid
from stages.analytic.model.walker import Walker
from stages.analytic.phases.guards import contact_rates
from stages.analytic.phases.motion import PHASES, RUB, SLIDE, in_contact
from stages.analytic.phases.section import section_state
from stages.analytic.phases.succession import succeed
from stages.analytic.result import EnergyAudit, Validity
from stages.analytic.walk.recording import Segment, record, rise, states_at
from stages.analytic.walk.sampling import accelerations_and_forces
from stages.analytic.walk.validity import assess
from stages.biped.quantity import quantity
from stages.biped.walk import Gait, Limp


def limp_of(walker: Walker, point: FixedPoint) -> Limp:
    """How a gait limps; legs that are alike make the same step twice."""
    periods = np.resize([step.period * walker.time for step in point.steps], 2)
    lengths, apart = (np.resize(each, 2) * walker.length for each in (
        step_lengths(walker, point), feet_apart(walker, point)))  # fmt: skip
    return Limp(periods, lengths, apart, float(np.ptp(periods) / periods.mean()))


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
    rises = np.array([rise(walker, segment) for segment in segments if segment.last])
    slope = np.arctan2(walker.p.g_x, -walker.p.g_y) - np.arctan2(rises.sum(), advance)
    return PutDown(rises * walker.length, float(np.degrees(slope)))


@dataclass(frozen=True)
class GaitReport:
    """One gait, with the segments of its steps that it was read from, heel strike to heel strike."""

    gait: Gait
    energy: EnergyAudit
    validity: Validity
    segments: list[Segment]
    limp: Limp
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


#: Gauss-Legendre nodes between two integrator steps; the damper power is smooth there.
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(8)


def energy(walker: Walker, y: np.ndarray) -> tuple[float, float]:
    """Kinetic and potential energy of a state, dimensionless, with x = 0 at the stance foot."""
    terms: Callable[..., Numbers] = eq.rigid_energy if walker.rigid else eq.compliant_energy
    kinetic, potential = terms(*y[: walker.size], walker.p)
    return kinetic, potential


def quadrature(walker: Walker, segment: Segment, power: Callable[[np.ndarray], np.ndarray]) -> float:
    """Integral over a segment of a function of its states (n, size) -> (n,); `walker` is the one in its step."""
    edges = np.append(segment.times, segment.duration)
    middle, half = (edges[1:] + edges[:-1]) / 2, (edges[1:] - edges[:-1]) / 2
    times = (middle[:, None] + half[:, None] * POINTS).ravel()
    states = states_at(segment.phase, segment.times, segment.states, times, walker.p)
    return float((power(states).reshape(-1, POINTS.size) * WEIGHTS * half[:, None]).sum())


def damper_loss(walker: Walker, segment: Segment) -> float:
    """Integral of b (dL_1^2 + dL_2^2) over a segment, and of the power that a hip's friction takes, dimensionless."""
    p = walker.p
    if isinstance(p, Detailed):
        return quadrature(walker, segment, partial(detailed_power, p, segment.phase))
    if isinstance(p, Rigid):
        return 0.0
    return quadrature(walker, segment, lambda states: p.b * (states[:, 5] ** 2 + states[:, 7] ** 2))


def detailed_power(p: Detailed, phase: int, states: np.ndarray) -> np.ndarray:
    """Power (n,) that the dampers of detailed legs and the hip's friction take at states (n, size)."""
    rate = states[:, 2] + states[:, 3] if isinstance(p, Rigid) else states[:, 4] + states[:, 6]
    hip = p.b_h * rate**2 + p.tau_h * np.abs(PHASES[phase, RUB] * rate)
    return np.asarray(hip if isinstance(p, Rigid) else p.b * states[:, 5] ** 2 + p.b_2 * states[:, 7] ** 2 + hip)


def weight_of(p: Kind) -> float:
    """All that gravity pulls at, in total masses: less than one with a counterweight."""
    return 1.0 + (p.M_g - p.M) if isinstance(p, Detailed) else 1.0


def friction_loss(walker: Walker, segment: Segment) -> float:
    """Integral of -lambda_2 times the slip velocity over a segment in which the trailing foot slides, dimensionless."""
    p: Any = walker.p
    if PHASES[segment.phase, SLIDE] == 0:
        return 0.0

    def power(states: np.ndarray) -> np.ndarray:
        friction = accelerations_and_forces(segment.phase, states, p)[:, 6]
        slip = np.array([contact_rates(y, p)[1] for y in states])
        return np.asarray(-friction * slip)

    return quadrature(walker, segment, power)


def audit(walker: Walker, segments: list[Segment], advance: float) -> EnergyAudit:
    """Audit of the segments of all steps of a gait that advances by `advance` leg lengths in them, the mean step's."""
    work = walker.p.g_x * advance * weight_of(walker.p)  # all moves down the slope by so much; heights above it repeat
    if walker.timed:  # but for feet that are put down above it or below
        work += walker.p.g_y * weight_of(walker.p) * sum(rise(walker, each) for each in segments if each.last)
    dampers = sum(damper_loss(walker.on(segment.stance_leg), segment) for segment in segments)
    sliding = sum(friction_loss(walker.on(segment.stance_leg), segment) for segment in segments)
    impact = 0.0
    for segment in segments:
        if in_contact(segment.phase):
            continue
        after, standing = segment.end.copy(), walker.on(segment.stance_leg)
        succeed(segment.phase, after, standing.p, None)
        landed = standing.exchanged if segment.last else standing
        impact += energy(standing, segment.end)[0] - energy(landed, after)[0]
    unit = walker.energy / sum(each.last for each in segments)
    rest = work - dampers - impact - sliding
    return EnergyAudit(work * unit, dampers * unit, impact * unit, sliding * unit, rest / work if work else 0.0)
