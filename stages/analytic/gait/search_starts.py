"""Where the search for gaits starts.

Most starts lie on a grid over stance angle and stance rate just after heel strike. A walker with stiff springs or
dampers takes many integration steps; its legs hardly move along themselves, so it starts from the gaits of the same
biped with rigid legs. A light foot makes the rates fast, but no stiff legs: where these lead nowhere the grid follows.
"""

from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.poincare import FixedPoint, repeated
from stages.analytic.model.kinds import (
    Compliant,
    Detailed,
    Kind,
    Rigid,
    Stiff,
    natural_lengths,
    with_legs_exchanged,
)
from stages.analytic.model.stiffness import STIFF_RATE, axial_rates, fastest_rate
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.impact import heel_strike_reset
from stages.analytic.phases.motion import RIGID
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record

#: Documented range of the search: stance angle at heel strike [rad] and stance rate [sqrt(g/L)].
ANGLES = np.linspace(0.05, 0.60, 12)
RATES = np.linspace(0.05, 1.2, 24)
SCAN_TOLERANCE = 1e-5
#: Fastest axial rate, in 1 / pendulum time, up to which a grid is quicker than a detour over rigid legs.
GRID_RATE = 400.0
SCAN_STEPS = 3
#: Stiff springs ring for long if they do not decay within so many of their radians.
RINGING = 10.0
#: Walks that are to settle on a stable gait: their range, wider and with fewer starts, and their steps.
WIDE_ANGLES, WIDE_RATES, LONG_WALK = np.linspace(0.02, 1.0, 15), np.linspace(0.05, 2.0, 20), 60
#: Starts closer than this in angle and rate lead to the same gait.
SAME_START = 0.01
STEP_TIME = 2.6


def is_quick(p: Kind) -> bool:
    """Whether a grid of starts is the quickest search."""
    return isinstance(p, Rigid) or fastest_rate(p) <= GRID_RATE


def is_searched(p: Kind) -> bool:
    """Whether a step costs so little that a grid of starts is walked: springs are slow, or implicit steps pass them,
    which they do not where springs ring for long.
    """
    if isinstance(p, Rigid) or fastest_rate(p) <= STIFF_RATE:
        return True
    rate, decay = axial_rates(p)
    return isinstance(p, Stiff) and decay * RINGING >= rate


def lengths_after_heel_strike(p: Compliant) -> tuple[float, float]:
    """Lengths of the new stance leg and of the trailing leg just after heel strike.

    Fast springs are at rest under their load: the foot that hung on the leg, the weight that stood on it. Dampers
    that take longer than a step keep both legs at their mean load.
    """
    if isinstance(p, Detailed):
        weight = p.M_g + p.m_f + p.m_f_2
        return (p.L_nat + settled_stretch(weight, p.k, p.b, p.m / p.k),
                p.L_nat_2 + settled_stretch(weight, p.k_2, p.b_2, -(weight + p.m_2) / (2 * p.k_2)))
    mean = 1 - p.M / (2 * p.k)
    settled = 1.0 if p.b == 0 else 1 - float(np.exp(-STEP_TIME * p.k / p.b))
    landing, trailing = 1 + p.m / p.k, 1 - (p.M + p.m) / (2 * p.k)
    return mean + settled * (landing - mean), mean + settled * (trailing - mean)


def settled_stretch(weight: float, stiffness: float, damping: float, end: float) -> float:
    """Stretch of a spring that goes from its mean under a weight that both legs carry in turn to its `end`."""
    mean = -weight / (2 * stiffness)
    settled = 1.0 if damping == 0 else 1 - float(np.exp(-STEP_TIME * stiffness / damping))
    return mean + settled * (end - mean)


def start_coordinates(walker: Walker, angle: float, rate: float) -> Vector:
    """Section coordinates of a plausible start: the hip moves across the new stance leg, the springs carry weight.

    The hip's velocity, across the trailing leg before, has the part -rate sin(2 angle) along the new one. On rigid
    legs `rate` is that before the impact, at which the leading leg hangs still.
    """
    p = walker.p
    if isinstance(p, Rigid):
        y = np.array([angle, angle, rate, 0.0])
        heel_strike_reset(y, walker.exchanged.p)
        return np.asarray(y[[0, 2, 3]])
    across = -rate * np.sin(2 * angle) * p.M / (p.M + p.m)  # what little frames add is Newton's to find
    return np.array([-angle, *lengths_after_heel_strike(p), rate, across, *at_rest(p)])


def at_rest(p: Compliant) -> list[float]:
    """The section coordinates that show how a trailing foot moves which friction may not hold: it does not."""
    return [0.0, 0.0] if p.mu_s < np.inf else []


def grid(walker: Walker, angles: Vector = ANGLES, rates: Vector = RATES) -> Iterator[Vector]:
    """All starts on a grid."""
    for angle in angles:
        for rate in rates:
            yield start_coordinates(walker, float(angle), float(rate))


def walk_forward(walker: Walker, z: Vector) -> list[Vector]:
    """Section coordinates after each of `SCAN_STEPS` steps from `z`, strides if they alternate, as far as it gets."""
    reached = []
    with suppress(StepFailed):
        for _ in range(SCAN_STEPS):
            z = repeated(walker, z, walker.gait_steps, SCAN_TOLERANCE)
            reached.append(z)
    return reached


def angle_and_rate(walker: Walker, z: Vector) -> Vector:
    """The two coordinates the grid lies over."""
    return z[[0, 1]] if walker.rigid else z[[0, 3]]


def is_elsewhere(walker: Walker, z: Vector, starts: list[Vector]) -> bool:
    """Whether a start leads to another gait than `starts`, as far as one can tell: it is not close to them."""
    return all(np.abs(angle_and_rate(walker, z - other)).max() > SAME_START for other in starts)


@lru_cache(maxsize=16)
def ranked_starts(walker: Walker, thinned: int = 1) -> tuple[tuple[Vector, ...], int]:
    """Starts on the grid, `thinned` or not, and their images, those that move least in one step first.

    And how many steps the longest walk made. Kept for the reason why there is no gait.
    """
    pairs: list[tuple[float, Vector]] = []
    longest = 0
    for z in grid(walker, ANGLES[::thinned], RATES[::thinned]):
        trail = walk_forward(walker, z)
        longest = max(longest, len(trail))
        for before, after in zip([z, *trail], trail, strict=False):
            if before[0] < 0.0:
                pairs.append((float(np.abs(angle_and_rate(walker, after - before)).max()), before))
    chosen: list[Vector] = []
    for _, z in sorted(pairs, key=lambda pair: pair[0]):
        if is_elsewhere(walker, z, chosen):
            chosen.append(z)
    return tuple(chosen), longest


def walked_on(walker: Walker) -> list[Vector]:
    """Where long walks from a wide grid end that do not fall: a stable gait draws them in."""
    ends: list[Vector] = []
    for z in grid(walker, WIDE_ANGLES, WIDE_RATES):
        for _ in range(LONG_WALK // SCAN_STEPS):
            trail = walk_forward(walker, z)
            if len(trail) < SCAN_STEPS or any(np.abs(trail[-1] - other).max() < SAME_START for other in ends):
                break
            z = trail[-1]
        else:
            ends.append(z)
    return [z for z in ends if z[0] < 0.0]


def landed(p: Compliant, rigid: Walker, point: FixedPoint) -> Vector:
    """Section coordinates of a compliant walker that lands as the rigid gait does, springs at rest."""
    start, last = section_state(point.z, rigid.p), rigid
    for step in point.steps[:-1]:
        start, last = step.state, last.exchanged
    theta, psi, dtheta, dpsi = record(last, start, 1, SCAN_TOLERANCE, RIGID)[-1].end.tolist()
    swing, stance = natural_lengths(p)  # before heel strike the other leg stands
    y = np.array([theta, stance, psi, swing, dtheta, 0.0, dpsi, 0.0])
    heel_strike_reset(y, with_legs_exchanged(p))
    return np.array([y[0], *lengths_after_heel_strike(p), y[4], y[5], *at_rest(p)])
