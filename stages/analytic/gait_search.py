"""Finds the gaits of a design from no guess.

Starts are laid on a grid over stance angle and stance rate just after heel strike. Some are walked forward, which
leads to stable gaits; all of them start Newton's method, which finds unstable ones as well.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.poincare import FixedPoint, fixed_point, poincare_map
from stages.analytic.walker import Vector, Walker, build_walker
from stages.biped.design import Biped
from stages.biped.gait import Gait
from stages.ground.slope import Slope

#: Documented range of the search: stance angle at heel strike [rad] and stance rate [sqrt(g/L)].
ANGLES = np.linspace(0.05, 0.60, 12)
RATES = np.linspace(0.05, 1.2, 24)
SCAN_TOLERANCE = 1e-5
SCAN_STEPS = 8
#: Two fixed points closer than this are one.
DISTINCT = 1e-6


def start_coordinates(walker: Walker, angle: float, rate: float) -> Vector:
    """Section coordinates of a plausible start: the hip moves across the new stance leg, the springs carry weight.

    The new stance leg is stretched by the foot that hung on it; the trailing leg is pressed by the body's weight.
    The hip's velocity, across the trailing leg before, has the part -rate sin(2 angle) along the new one.
    """
    if walker.rigid:
        return np.array([-angle, rate, rate * np.cos(2 * angle) - rate])
    hip, foot, stiffness = walker.p[0], walker.p[1], walker.p[5]
    landing_rate = -rate * np.sin(2 * angle) * hip / (hip + foot)
    return np.array([-angle, 1 + foot / stiffness, 1 - (hip + foot) / (2 * stiffness), rate, landing_rate])


def starts(walker: Walker) -> Iterator[Vector]:
    """All starts of the search."""
    for angle in ANGLES:
        for rate in RATES:
            yield start_coordinates(walker, float(angle), float(rate))


def walk_forward(walker: Walker, z: Vector, steps: int) -> list[Vector]:
    """Section coordinates of up to `steps` steps from `z`, as far as the walker gets."""
    reached = []
    for _ in range(steps):
        try:
            z = poincare_map(walker, z, SCAN_TOLERANCE).z
        except StepFailed:
            break
        reached.append(z)
    return reached


def is_new(found: list[FixedPoint], candidate: FixedPoint) -> bool:
    """Whether `candidate` is none of the fixed points found."""
    return all(np.abs(known.z - candidate.z).max() > DISTINCT for known in found)


def is_walking(point: FixedPoint) -> bool:
    """Whether a fixed point moves forward: the stance leg starts behind upright and every step takes time."""
    return bool(point.z[0] < -1e-4) and all(step.period > 1e-3 for step in point.steps)


def by_stability(point: FixedPoint) -> float:
    """Largest multiplier in magnitude."""
    return float(np.abs(point.floquet_multipliers).max())


def find_gaits(walker: Walker, tolerance: float, *, unstable: bool) -> list[FixedPoint]:
    """Fixed points of the step map, most stable first; the unstable ones too if asked for."""
    found: list[FixedPoint] = []
    trails = [(z, walk_forward(walker, z, SCAN_STEPS)) for z in starts(walker)]
    guesses = [trail[-1] for _, trail in trails if len(trail) == SCAN_STEPS]
    if unstable:
        guesses += [trail[min(1, len(trail) - 1)] for _, trail in trails if trail]
    tried: list[Vector] = []
    for guess in guesses:
        if any(np.abs(guess - other).max() < 1e-3 for other in tried):
            continue
        tried.append(guess)
        point = fixed_point(walker, guess, tolerance)
        if point is not None and is_walking(point) and is_new(found, point):
            found.append(point)
    return sorted(found, key=by_stability)


def why_no_gait(walker: Walker) -> str:
    """Reason why the search found nothing."""
    range_searched = (
        f"stance angle {ANGLES[0]:g} to {ANGLES[-1]:g} rad and stance rate {RATES[0]:g} to {RATES[-1]:g} sqrt(g/L)"
    )
    if walker.p[8] <= 0.0:
        return "no periodic gait: on level ground gravity does no work, and every heel strike loses energy"
    survived = [len(walk_forward(walker, z, SCAN_STEPS)) for z in starts(walker)]
    return (
        f"no periodic gait in the range searched ({range_searched}): of {len(survived)} starts the longest walk "
        f"made {max(survived)} steps, and Newton's method converged from none"
    )


def describe(walker: Walker, point: FixedPoint) -> Gait:
    """The gait in SI units under the names the command line prints."""
    step = point.steps[0]
    period = step.period * walker.time
    length = step_length(walker, point) * walker.length
    multipliers = point.floquet_multipliers
    return Gait(
        period_s=period,
        step_frequency_hz=1 / period,
        step_length_m=length,
        speed_m_s=length / period,
        double_stance_s=step.double_stance * walker.time,
        floquet_multipliers=np.column_stack([multipliers.real, multipliers.imag]),
        stable=bool(np.abs(multipliers).max() < 1),
        fixed_point=walker.stance_state(step.state),
    )


def step_length(walker: Walker, point: FixedPoint) -> float:
    """Advance of the hip over one step, in leg lengths: the distance of the feet's contact points at heel strike.

    The stance foot rolls by r (theta_end - theta_start) and the body passes to the other foot; over a periodic step
    the advance of the hip equals the distance between the two feet's centres plus the rolling from centre to centre.
    """
    theta, psi = point.z[0], point.steps[-1].state[1 if walker.rigid else 2]
    stance, swing = (1.0, 1.0) if walker.rigid else (point.z[1], point.z[2])
    radius = walker.p[3]
    return float(-(stance - radius) * np.sin(theta) - (swing - radius) * np.sin(psi) - radius * (theta + psi))


def find_gait(biped: Biped, slope: Slope, tolerance: float) -> tuple[Walker, FixedPoint]:
    """The design's most stable gait of period one, stable or not.

    Raises NoGait with the reason if there is none in the range searched.
    """
    walker = build_walker(biped, slope)
    found = find_gaits(walker, tolerance, unstable=False)
    if not found or by_stability(found[0]) >= 1:
        found = find_gaits(walker, tolerance, unstable=True)
    if not found:
        raise NoGait(why_no_gait(walker))
    return walker, found[0]
