"""Extremes of a gait's forces and clearance, beside an integration by SciPy of the readable equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from stages.analytic.gait.gait_report import record_steps
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.integration.readable import accelerations, clearance
from stages.analytic.phases.succession import in_contact
from stages.analytic.walk.recording import in_single_stance
from stages.analytic.walk.validity import assess
from stages.biped.design import Biped
from stages.ground.slope import Slope


def arm(length, angle):
    """Acceleration of the end of an arm (length and angle with both derivatives) along (sin, cos) of its angle."""
    (long, rate, change), (turned, spin, turning) = length, angle
    along, across = change - long * spin**2, 2 * rate * spin + long * turning
    sine, cosine = np.sin(turned), np.cos(turned)
    return np.array([along * sine + across * cosine, along * cosine - across * sine])


def forces(walker, y, both):
    """Tangential and normal force on the leading and on the trailing foot, by Newton's law for three masses."""
    p, half = walker.p, y.size // 2
    change, second = accelerations(walker, y, both)
    q, v, a = y[:half], y[half:], change
    if walker.rigid:
        q, v, a = ([one[0], fixed, one[1], fixed] for one, fixed in ((q, p.L_nat), (v, 0.0), (a, 0.0)))
    (theta, first, psi, other) = zip(q, v, a, strict=True)
    rolling = np.array([p.r * theta[2], 0.0])
    hip = rolling + arm((first[0] - p.r, *first[1:]), theta)
    stance = rolling + arm((p.l - p.r, 0.0, 0.0), theta)
    swing = hip - arm((other[0] - p.l, *other[1:]), tuple(-one for one in psi))
    weight = np.array([p.g_x, p.g_y])
    total = p.M * (hip - weight) + p.m * (stance - weight) + p.m * (swing - weight)
    trailing = np.array([second[1], second[0]])
    return np.concatenate([total - trailing, trailing])


def largest(solution, end, quantity):
    times = np.linspace(0.0, end, 2001)
    values = np.array([quantity(solution(time)) for time in times])
    top = int(np.argmax(values))
    bounds = times[max(top - 1, 0)], times[min(top + 1, 2000)]
    found = minimize_scalar(lambda time: -quantity(solution(time)), bounds=bounds, method="bounded",
                            options={"xatol": 1e-12})
    return max(values[top], -found.fun)


def own(walker, segments):
    """The extremes, in the terms of `Validity`."""
    found = {}
    for segment in segments:
        both, start = in_contact(segment.phase), segment.states[0]
        if not (both or in_single_stance(segment)):
            continue

        def rates(_, y, both=both):
            return np.concatenate([y[y.size // 2 :], accelerations(walker, y, both)[0]])

        solution = solve_ivp(rates, (0.0, segment.duration), start, method="DOP853", rtol=1e-13, atol=1e-13,
                             dense_output=True, max_step=0.01).sol
        quantities = {"stance": lambda y, both=both: -forces(walker, y, both)[1]}
        if both:
            quantities["trailing"] = lambda y: -forces(walker, y, True)[3]
        else:
            quantities["friction"] = lambda y: abs(np.divide(*forces(walker, y, False)[:2]))
            quantities["scuff"] = lambda y: -clearance(walker, y)
        for name, quantity in quantities.items():
            value = largest(solution, segment.duration, quantity)
            found[name] = max(found.get(name, -np.inf), value)
    return found


#: Length [m], gravity [m/s^2], stiffness in that of Table 1 relative to weight and length, and the legs.
WALKERS = {
    "Table 1": (0.333, 9.81, 1.0, "compliant"), "soft": (0.333, 9.81, 0.6, "compliant"),
    "stiff": (0.333, 9.81, 3.0, "compliant"), "large": (1.2, 9.81, 0.8, "compliant"),
    "small, on the Moon": (0.15, 1.62, 1.5, "compliant"), "rigid": (0.333, 9.81, 1.0, "rigid"),
}  # fmt: skip


def design(length, gravity, stiffness, legs):
    grown, heavier = length / 0.333, gravity / 9.81
    stiff, damped = 2800.0 * stiffness * heavier / grown, 58.35 * np.sqrt(stiffness * heavier / grown)
    sizes = (grown * size for size in (0.333, 0.083, 0.1))
    return Biped(legs, 0.316, 0.335, *sizes, stiff, damped, 0.0), Slope(2.0, gravity)


@pytest.mark.slow
@pytest.mark.parametrize("name", WALKERS)
def test_extremes_are_those_of_another_integration(name):
    """Forces by Newton's law, events of the same duration; to 1e-10 of the weight, of one and of the leg's length."""
    walker, point = find_gait(*design(*WALKERS[name]), 1e-12)
    segments = record_steps(walker, point, 1e-12)
    report, known = assess(walker, segments, 1.1), own(walker, segments)
    assert report.least_normal_force_stance / walker.force == pytest.approx(-known["stance"], abs=1e-10)
    assert report.friction_single_stance == pytest.approx(known["friction"], abs=1e-10)
    assert report.deepest_scuff / walker.length == pytest.approx(max(known["scuff"], 0.0), abs=1e-10)
    if not walker.rigid:
        assert report.least_normal_force_trailing / walker.force == pytest.approx(-known["trailing"], abs=1e-10)
