"""How stiff a walker is: the rate of its fastest axial motion, and what that does to cost and accuracy."""

from __future__ import annotations

import numpy as np

from stages.analytic.walker import Walker


def reduced_mass(walker: Walker) -> float:
    """Mass that a leg's spring feels at least: hip and foot against each other, dimensionless."""
    hip, foot = walker.p[0], walker.p[1]
    return hip * foot / (hip + foot)


def fastest_rate(walker: Walker) -> float:
    """Magnitude of the fastest eigenvalue of a leg's spring and damper, in 1 / pendulum time; 0 for rigid legs."""
    if walker.rigid:
        return 0.0
    mass, stiffness, damping = reduced_mass(walker), walker.p[5], walker.p[6]
    half = damping / (2 * mass)
    squared = half**2 - stiffness / mass
    return float(half + np.sqrt(squared)) if squared > 0 else float(np.sqrt(stiffness / mass))


def attainable_tolerance(walker: Walker, tolerance: float) -> float:
    """The tolerance, or the round-off of the spring forces over one integration step where that is larger."""
    if walker.rigid:
        return tolerance
    noise = 32 * np.finfo(float).eps * walker.p[5] / (reduced_mass(walker) * fastest_rate(walker))
    return max(tolerance, float(noise))
