"""Energy audit of one step: gravity's work against what dampers and impacts take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.analytic import equations as eq
from stages.analytic.flow import DOUBLE_STANCE
from stages.analytic.recording import Segment, states_at
from stages.analytic.transitions import heel_strike_reset
from stages.analytic.walker import Walker
from stages.biped.quantity import quantity

#: Gauss-Legendre nodes between two integrator steps; the damper power is smooth there.
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True)
class EnergyAudit:
    """Energies of one step of a periodic gait [J]; `residual` is what does not close, relative to gravity's work."""

    gravity_work: float = quantity("J", "work of gravity over one step", symbol="W_g")
    damper_loss: float = quantity("J", "energy taken by the leg dampers over one step")
    impact_loss: float = quantity("J", "kinetic energy lost at heel strike")
    residual: float = quantity("1", "(work - losses) / work; zero if the audit closes")


def energy(walker: Walker, y: np.ndarray) -> tuple[float, float]:
    """Kinetic and potential energy of a state, dimensionless, with x = 0 at the stance foot."""
    kinetic, potential = (eq.rigid_energy if walker.rigid else eq.compliant_energy)(*y[: walker.size], walker.p)
    return kinetic, potential


def damper_loss(walker: Walker, segment: Segment) -> float:
    """Integral of b (dL_1^2 + dL_2^2) over a segment, dimensionless."""
    if walker.rigid:
        return 0.0
    edges = np.append(segment.times, segment.duration)
    middle, half = (edges[1:] + edges[:-1]) / 2, (edges[1:] - edges[:-1]) / 2
    times = (middle[:, None] + half[:, None] * POINTS).ravel()
    states = states_at(segment.phase, segment.times, segment.states, times, walker.p)
    power = walker.p[6] * (states[:, 5] ** 2 + states[:, 7] ** 2)
    return float((power.reshape(-1, POINTS.size) * WEIGHTS * half[:, None]).sum())


def audit(walker: Walker, segments: list[Segment], advance: float) -> EnergyAudit:
    """Audit of the segments of one periodic step that advances by `advance` leg lengths."""
    work = walker.p[8] * advance  # all mass moves down the slope by one step; heights above it repeat
    dampers = sum(damper_loss(walker, segment) for segment in segments)
    impact = 0.0
    for segment in segments:
        if segment.phase == DOUBLE_STANCE:
            continue
        after = segment.end.copy()
        heel_strike_reset(segment.phase, after, walker.p)
        impact += energy(walker, segment.end)[0] - energy(walker, after)[0]
    unit = walker.energy
    return EnergyAudit(work * unit, dampers * unit, impact * unit, (work - dampers - impact) / work if work else 0.0)
