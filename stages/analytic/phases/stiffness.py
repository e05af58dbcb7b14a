"""How stiff a walker is: the rate of its fastest axial motion, and what that asks of the integrator and of accuracy."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np

from stages.analytic.compiled import Numbers, compiled
from stages.analytic.model.walker import Walker

#: Steps are implicit where the legs' axial motion is faster than the first and decays faster than the second, both in
#: 1 / pendulum time: there they cost less than explicit ones. Measured by benchmarks/stiff_legs.py.
STIFF_RATE, STIFF_DECAY = 1500.0, 400.0


@compiled
def axial_rates(p: Numbers) -> tuple[float, float]:
    """Magnitude of the fastest eigenvalue of a leg's spring and damper and its decay rate, in 1 / pendulum time.

    Foot and hip move against each other with the reduced mass of the two, the smallest that a leg's axis sees.
    """
    inverse_mass = 1.0 / p[0] + 1.0 / p[1]
    half, square = 0.5 * p[6] * inverse_mass, p[5] * inverse_mass
    if half * half > square:
        rate = half + sqrt(half * half - square)
        return rate, rate
    return sqrt(square), half


@compiled
def takes_implicit_steps(rigid: bool, p: Numbers) -> bool:
    """Whether the legs are stiff to an explicit integrator: their axial motion is fast, and damped enough to die out.

    A fast motion that hardly decays has to be followed through all its swings, which explicit steps do at less cost.
    """
    if rigid:
        return False
    rate, decay = axial_rates(p)
    return rate > STIFF_RATE and decay > STIFF_DECAY


def fastest_rate(walker: Walker) -> float:
    """Magnitude of the fastest eigenvalue of a leg's spring and damper, in 1 / pendulum time; 0 for rigid legs."""
    if walker.rigid:
        return 0.0
    compiled_function: Any = axial_rates
    rate, _ = compiled_function.py_func(walker.p)  # once a search: not worth loading machine code
    return float(rate)


def attainable_tolerance(walker: Walker, tolerance: float) -> float:
    """The tolerance, or the round-off of the spring forces over one integration step where that is larger."""
    if walker.rigid:
        return tolerance
    hip, foot = walker.p[0], walker.p[1]
    noise = 32 * np.finfo(float).eps * walker.p[5] * (hip + foot) / (hip * foot * fastest_rate(walker))
    return max(tolerance, float(noise))
