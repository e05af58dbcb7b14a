"""How stiff a walker is: the rate of its fastest axial motion, and what that costs the integrator and accuracy."""

from math import sqrt
from typing import Any, TypeVar

import numpy as np

from stages.analytic.model.kinds import (
    Compliant,
    Detailed,
    DetailedCompliant,
    Kind,
    PlainCompliant,
    Rigid,
    StiffDetailed,
    StiffPlain,
)

K = TypeVar("K", bound=Kind)
#: Steps are implicit where the legs' axial motion is faster than the first and decays faster than the second, both in
#: 1 / pendulum time: there they cost less than explicit ones. Measured by benchmarks/stiff_legs.py.
STIFF_RATE, STIFF_DECAY = 1500.0, 400.0


def axes(p: Compliant) -> tuple[tuple[float, float, float, float], ...]:
    """Masses above and below a spring, its stiffness and damping: of both legs where they may differ."""
    if isinstance(p, Detailed):
        return (p.M + p.m_f, p.m, p.k, p.b), (p.M + p.m_f_2, p.m_2, p.k_2, p.b_2)
    return ((p.M, p.m, p.k, p.b),)


def axial_rates(p: Compliant) -> tuple[float, float]:
    """Magnitude of the fastest eigenvalue of a leg's spring and damper and its decay rate, in 1 / pendulum time.

    Foot and hip move against each other with the reduced mass of the two, the smallest that a leg's axis sees.
    """
    rates = []
    for hip, foot, stiffness, damping in axes(p):
        inverse_mass = 1.0 / hip + 1.0 / foot
        half, square = 0.5 * damping * inverse_mass, stiffness * inverse_mass
        fast = half + sqrt(half * half - square) if half * half > square else sqrt(square)
        rates.append((fast, fast if half * half > square else half))
    return max(rates)


def judged(p: K) -> K:
    """The walker in the type for stiff legs or in the other, as its legs are.

    They are where their axial motion is fast, and damped enough to die out: a fast motion that hardly decays has to be
    followed through all its swings, which explicit steps do at less cost. The events of a hip that rubs are located by
    explicit steps.
    """
    if isinstance(p, Rigid):
        return p
    rate, decay = axial_rates(p)
    soft, stiff = (DetailedCompliant, StiffDetailed) if isinstance(p, Detailed) else (PlainCompliant, StiffPlain)
    kind: Any = stiff if rate > STIFF_RATE and decay > STIFF_DECAY and p.tau_h == 0.0 else soft
    return kind(*p)  # type: ignore[no-any-return]


def fastest_rate(p: Kind) -> float:
    """Magnitude of the fastest eigenvalue of a leg's spring and damper, in 1 / pendulum time; 0 for rigid legs."""
    return 0.0 if isinstance(p, Rigid) else axial_rates(p)[0]


def attainable_tolerance(p: Kind, tolerance: float) -> float:
    """The tolerance, or the round-off of the spring forces over one integration step where that is larger."""
    if isinstance(p, Rigid):
        return tolerance
    fastest = fastest_rate(p)
    noise = max(32 * np.finfo(float).eps * stiffness * (hip + foot) / (hip * foot * fastest)
                for hip, foot, stiffness, _ in axes(p))  # fmt: skip
    return max(tolerance, float(noise))
