"""Published gaits of walkers with a hip spring: the simplest walking model with push-off, on level ground.

A. D. Kuo, "Energetics of actively powered locomotion using the simplest walking model", J. Biomech. Eng. 124 (2002):
legs without mass but for a vanishing one at the feet, a spring between them, and an impulse along the trailing leg just
before heel strike. Its published transition stands here; the swing between two of them is ours, with its guard, its
variations and the shift to heel strike. The spring per foot mass, length and gravity is Kuo's number.
"""

import numpy as np
import pytest

from stages.analytic.integration.phase import EVENT, NO_NODES, integrate
from stages.analytic.model.walker import build_walker
from stages.analytic.phases.motion import RIGID
from stages.biped.design import Biped
from stages.ground.slope import Slope

LEVEL = Slope(slope_deg=0.0, gravity=1.0)
#: Foot masses in hip masses; what is published is the limit, and the gaits tend to it in proportion.
FEET = (1e-6, 5e-7)
#: Kuo's coordinates (q1, q2, u1, u2) from (theta, psi) and rates: anticlockwise, the swing leg's from the stance leg.
TO_KUO = np.array([[-1.0, 0.0, 0.0, 0.0], [-1.0, -1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 0.0, -1.0, -1.0]])
#: Where the step starts, by q1, u1 and u2: the other foot is on the ground, q2 = 2 q1.
START = np.array([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


def swing(spring, foot, x):
    """Duration of the swing from `x`, state before heel strike and its derivatives (4, 3), in Kuo's coordinates."""
    biped = Biped(legs="rigid", hip_mass=1.0, foot_mass=foot, leg_length=1.0, foot_radius=0.0, foot_com=0.0,
                  stiffness=1.0, damping=0.0, leg_inertia=0.0, hip_stiffness=spring * foot)  # fmt: skip
    walker, back = build_walker(biped, LEVEL, detailed=True), np.linalg.inv(TO_KUO)
    y = np.concatenate([back @ x, (back @ START).T.ravel()])
    status, duration, *_ = integrate(RIGID, y, walker.p, 1e-13, 30.0, 100_000, 0.02, NO_NODES)
    assert status == EVENT
    return duration * walker.time, TO_KUO @ y[:4], TO_KUO @ y[4:].reshape(3, 4).T


def transition(x, push):
    """Kuo's push-off and heel strike: (q1, u1, u2) after them, and their derivatives (3, 4)."""
    q, u, (c, s) = x[0], x[2], (np.cos(2 * x[0]), np.sin(2 * x[0]))
    rate, by_q, by_u = c * u + s * push, -2 * s * u + 2 * c * push, c
    after = np.array([-q, rate, (1 - c) * rate])
    return after, np.array([[-1.0, 0, 0, 0], [by_q, 0, by_u, 0], [2 * s * rate + (1 - c) * by_q, 0, (1 - c) * by_u, 0]])


def step(spring, push, foot, z):
    """The step map from z = (q1, u1, u2), its duration and its derivative (3, 3)."""
    duration, before, moved = swing(spring, foot, START @ z)
    after, jump = transition(before, push)
    return after, duration, jump @ moved


def gait(spring, push, foot, z):
    """Fixed point near z, duration of a step and multipliers, largest first."""
    for _ in range(12):
        after, duration, derivative = step(spring, push, foot, z)
        z = z + np.linalg.solve(np.eye(3) - derivative, after - z)
    values = np.linalg.eigvals(derivative).astype(complex)
    return z, duration, values[np.lexsort((-values.imag, -np.abs(values).round(9)))]


def in_the_limit(spring, push, z):
    """`gait` with feet of no mass, by extrapolation."""
    coarse, fine = (gait(spring, push, foot, z) for foot in FEET)
    return [2 * b - a for a, b in zip(coarse, fine, strict=True)]


@pytest.mark.parametrize(("push", "spring", "xstar"), [
    (0.1877, 2.5127, (0.355461, 0.710921, -0.505623, -0.122482)),
    (0.001, 0.125, (0.030701, 0.061402, -0.0325631, -6.13654e-05)),
    (0.04, 0.0, (0.194589, 0.389178, -0.202961, -0.0151771)),
])
def test_kuos_own_gaits_are_gaits_here(push, spring, xstar):
    """walksw2.m of github.com/kuo-lab/simplelocomotionmodel, to the digits printed there."""
    x = np.array(xstar)
    z, duration, _ = in_the_limit(spring, push, x[[0, 2, 3]])
    assert x[1] == pytest.approx(2 * x[0], abs=2e-6)
    assert z == pytest.approx(x[[0, 2, 3]], abs=1e-5)  # push and spring are printed to four digits
    if spring == 2.5127:  # "gives equivalent of speed 1.25 m/s, 1.8 Hz" with legs of one metre
        assert 2 * np.sin(z[0]) / duration == pytest.approx(1.25 / np.sqrt(9.81), abs=1e-3)
        assert np.sqrt(9.81) / duration == pytest.approx(1.8, abs=5e-4)
    if spring == 0.0:
        assert 2 * np.sin(z[0]) / duration == pytest.approx(0.1, abs=2e-3)


@pytest.mark.parametrize(("label", "period", "first", "second"), [
    (0.080, 3.454891, 0.94388957, 0.55236275),
    (0.142, 3.455584, 0.72032848 + 0.02799613j, 0.72032848 - 0.02799613j),
    (0.402, 3.461298, 0.44038400 + 0.55346980j, 0.44038400 - 0.55346980j),
    (0.800, 3.460015, -0.34677392 + 0.54419253j, -0.34677392 - 0.54419253j),
])
def test_multipliers_with_a_hip_spring_are_the_published_ones(label, period, first, second):
    """Hip spring .16: validate_core.m of github.com/KurayamaT/slow-walking-mechanics-reproducibility, by differences.

    The push-off that a gait is labelled with is 1.04 a tan a, a = arcsin(label / 2).
    """
    half = np.arcsin(label / 2)
    rate = -1.04 * half
    _, duration, multipliers = in_the_limit(0.16, -rate * np.tan(half), [half, rate, (1 - np.cos(2 * half)) * rate])
    assert duration == pytest.approx(period, abs=1e-6)
    assert multipliers[:2] == pytest.approx([first, second], abs=2e-7)
    assert abs(multipliers[2]) < 1e-9
