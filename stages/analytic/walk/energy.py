"""Energy audit of all steps of a gait: gravity's work against what dampers, sliding and impacts take."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from stages.analytic.compiled import Numbers
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import Detailed, Kind, Limited, Rigid, RubbingRigid, RubbingRolling
from stages.analytic.model.walker import Walker
from stages.analytic.phases.coulomb_guard import slip_speed
from stages.analytic.phases.flow import DOUBLE_STANCE, HIP_STICKS
from stages.analytic.phases.hip_friction import sign_of
from stages.analytic.phases.succession import in_contact, succeed
from stages.analytic.result import EnergyAudit
from stages.analytic.walk.recording import Segment, is_last, states_at
from stages.analytic.walk.sampling import accelerations_and_forces

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
    if isinstance(p, Rigid):
        rate = states[:, 2] + states[:, 3]
        rubbed = p.tau_h * np.abs(rate) if isinstance(p, RubbingRigid) and phase != HIP_STICKS else 0.0
        return np.asarray(p.b_h * rate**2 + rubbed)
    rate = states[:, 4] + states[:, 6]
    rubbed = p.tau_h * np.abs(rate) if isinstance(p, RubbingRolling) and sign_of(phase) != 0 else 0.0
    return np.asarray(p.b * states[:, 5] ** 2 + p.b_2 * states[:, 7] ** 2 + p.b_h * rate**2 + rubbed)


def weight_of(p: Kind) -> float:
    """All that gravity pulls at, in total masses: less than one with a counterweight."""
    return 1.0 + (p.M_g - p.M) if isinstance(p, Detailed) else 1.0


def friction_loss(walker: Walker, segment: Segment) -> float:
    """Integral of -lambda_2 times the slip velocity over a segment in which the trailing foot slides, dimensionless."""
    p = walker.p
    if not isinstance(p, Limited) or segment.phase == DOUBLE_STANCE or not in_contact(segment.phase):
        return 0.0

    def power(states: np.ndarray) -> np.ndarray:
        friction = accelerations_and_forces(segment.phase, states, p)[:, 6]
        slip = np.array([slip_speed(y, p)[1] for y in states])
        return np.asarray(-friction * slip)

    return quadrature(walker, segment, power)


def audit(walker: Walker, segments: list[Segment], advance: float) -> EnergyAudit:
    """Audit of the segments of all steps of a gait that advances by `advance` leg lengths in them, the mean step's."""
    work = walker.p.g_x * advance * weight_of(walker.p)  # all moves down the slope by so much; heights above it repeat
    dampers = sum(damper_loss(walker.on(segment.stance_leg), segment) for segment in segments)
    sliding = sum(friction_loss(walker.on(segment.stance_leg), segment) for segment in segments)
    impact = 0.0
    for segment in segments:
        if in_contact(segment.phase):
            continue
        after, standing = segment.end.copy(), walker.on(segment.stance_leg)
        succeed(segment.phase, after, standing.p)
        landed = standing.exchanged if is_last(segment) else standing
        impact += energy(standing, segment.end)[0] - energy(landed, after)[0]
    unit = walker.energy / sum(map(is_last, segments))
    rest = work - dampers - impact - sliding
    return EnergyAudit(work * unit, dampers * unit, impact * unit, sliding * unit, rest / work if work else 0.0)
