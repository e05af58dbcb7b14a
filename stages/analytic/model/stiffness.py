"""How stiff a walker is: the rate of its fastest axial motion, and what that asks of the integrator and of accuracy."""

from __future__ import annotations

from math import sqrt

import numpy as np

from stages.analytic.model.kinds import Compliant, Kind, Limited, Rigid, Rolling, StiffLimited, StiffRolling

#: Steps are implicit where the legs' axial motion is faster than the first and decays faster than the second, both in
#: 1 / pendulum time: there they cost less than explicit ones. Measured by benchmarks/stiff_legs.py.
STIFF_RATE, STIFF_DECAY = 1500.0, 400.0


def axial_rates(p: Compliant) -> tuple[float, float]:
    """Magnitude of the fastest eigenvalue of a leg's spring and damper and its decay rate, in 1 / pendulum time.

    Foot and hip move against each other with the reduced mass of the two, the smallest that a leg's axis sees.
    """
    inverse_mass = 1.0 / p.M + 1.0 / p.m
    half, square = 0.5 * p.b * inverse_mass, p.k * inverse_mass
    if half * half > square:
        rate = half + sqrt(half * half - square)
        return rate, rate
    return sqrt(square), half


def compliant(values: tuple[float, ...]) -> Compliant:
    """The walker with the given values of the fields of `Rolling` or `Limited`, in a stiff kind if its legs are stiff.

    That is, their axial motion is fast, and damped enough to die out: a fast motion that hardly decays has to be
    followed through all its swings, which explicit steps do at less cost.
    """
    soft, stiff = (Rolling, StiffRolling) if len(values) == len(Rolling._fields) else (Limited, StiffLimited)
    p: Compliant = soft(*values)
    rate, decay = axial_rates(p)
    return stiff(*values) if rate > STIFF_RATE and decay > STIFF_DECAY else p


def fastest_rate(p: Kind) -> float:
    """Magnitude of the fastest eigenvalue of a leg's spring and damper, in 1 / pendulum time; 0 for rigid legs."""
    return 0.0 if isinstance(p, Rigid) else axial_rates(p)[0]


def attainable_tolerance(p: Kind, tolerance: float) -> float:
    """The tolerance, or the round-off of the spring forces over one integration step where that is larger."""
    if isinstance(p, Rigid):
        return tolerance
    noise = 32 * np.finfo(float).eps * p.k * (p.M + p.m) / (p.M * p.m * fastest_rate(p))
    return max(tolerance, float(noise))
