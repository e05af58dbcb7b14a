"""On which feet the ground acts, when that changes, and what else is awaited of a step.

The rule is that of `stages.multibody.walking.watch`, with its moments located instead of seen at the next solver
step: the ground ceases to act on a foot once it is in the air behind the other foot and swings forward, and acts again
once the foot is in the air ahead of the other. Both happen in the air, so no force jumps. A foot on which the ground
acts is awaited until it touches it, its heel strike.

A phase is a negative number, -1 - (status of leg 0 + 3 status of leg 1 + 9 end), so that none is one of the constraint
walkers'. `end` is 1 or 2 while the step ends in the mid-stance of leg 0 or 1.

The force of the ground on a foot, and its derivatives, by the contact laws of `stages.ground`.
"""

from math import cos, sin

import numpy as np

from stages.ground.compiled import COMPILED, TANGENTS, compiled_coefficient
from stages.ground.laws import PointLaw
from stages.penalty.compiled import compiled
from stages.penalty.model.walker import Penalty, leg_of

Vector = np.ndarray
Change = tuple[float, float]
#: Status of a leg: out of play; in play, not landed yet; landed.
OUT, AWAITED, LANDED = 0, 1, 2
#: A foot is in the air when it is this far above the ground, in leg lengths: more than round-off of the moment located.
AIR = 1e-9


@compiled
def phase_of(first: int, second: int, end: int) -> int:
    """The phase with these statuses of leg 0 and 1 and the end that is awaited."""
    return -1 - (first + 3 * second + 9 * end)


@compiled
def status_of(phase: int, leg: int) -> int:
    """Status of a leg in a phase."""
    code = -1 - phase
    return code % 3 if leg == 0 else code // 3 % 3


@compiled
def end_of(phase: int) -> int:
    """The end that is awaited in a phase: 0 for none."""
    return (-1 - phase) // 9


@compiled
def acts_on(phase: int, leg: int) -> bool:
    """Whether the ground acts on a leg's foot."""
    return status_of(phase, leg) != OUT


@compiled
def block_under(p: Penalty, leg: int) -> float:
    """Height of the block under a foot [m]."""
    return p.h_0 if leg == 0 else p.h_1


@compiled
def height(y: Vector, p: Penalty, leg: int, dy: Vector, start: int) -> Change:
    """Height of a foot's lowest point above its ground [m], and its change for that of the state in `dy` from `start`.
    """
    radius = leg_of(p, leg).r
    reach, sine, cosine = y[4 + leg] - radius, sin(y[2 + leg]), cos(y[2 + leg])
    change = dy[start + 1] + reach * sine * dy[start + 2 + leg] - cosine * dy[start + 4 + leg]
    return y[1] - block_under(p, leg) - reach * cosine - radius, change


@compiled
def place(y: Vector, p: Penalty, leg: int, dy: Vector, start: int) -> Change:
    """How far a foot's centre is ahead of the hip [m], and its change."""
    reach, sine, cosine = y[4 + leg] - leg_of(p, leg).r, sin(y[2 + leg]), cos(y[2 + leg])
    return reach * sine, reach * cosine * dy[start + 2 + leg] + sine * dy[start + 4 + leg]


@compiled
def leg_guard(phase: int, y: Vector, p: Penalty, leg: int, dy: Vector, start: int) -> Change:
    """A number that falls through zero when the leg's status changes, and its change."""
    status = status_of(phase, leg)
    above, rise = height(y, p, leg, dy, start)
    clear = above - AIR * leg_of(p, leg).L_nat
    own, other = place(y, p, leg, dy, start), place(y, p, 1 - leg, dy, start)
    ahead, gain = own[0] - other[0], own[1] - other[1]
    if status == OUT:  # until it is above its block, and ahead
        begins = p.x_0 if leg == 0 else p.x_1
        return (-clear, -rise) if clear < ahead - begins else (begins - ahead, -gain)
    value, change = -clear, -rise  # until it is above, behind, and swings forward
    if ahead > value:
        value, change = ahead, gain
    if -y[8 + leg] > value:
        value, change = -y[8 + leg], -dy[start + 8 + leg]
    if status == AWAITED and above < value:
        return above, rise
    return value, change


@compiled
def end_guard(phase: int, y: Vector, dy: Vector, start: int) -> Change:
    """A number that falls through zero at the end that is awaited, and its change: the angle of the standing leg."""
    end = end_of(phase)
    return (np.inf, 0.0) if end == 0 else (y[1 + end], dy[start + 1 + end])


@compiled
def penalty_guard(phase: int, y: Vector, p: Penalty, dy: Vector, start: int) -> tuple[float, float, bool]:
    """`guard` of the engine: what falls through zero next."""
    value, change = end_guard(phase, y, dy, start)
    for leg in range(2):
        own, rate = leg_guard(phase, y, p, leg, dy, start)
        if own < value:
            value, change = own, rate
    return value, change, True


@compiled
def due(phase: int, y: Vector, p: Penalty) -> tuple[int, float]:
    """Whose guard is lowest, leg 0, leg 1 or the end (2), and its value."""
    who, value = 2, end_guard(phase, y, y, 0)[0]
    for leg in range(2):
        own = leg_guard(phase, y, p, leg, y, 0)[0]
        if own < value:
            who, value = leg, own
    return who, value


@compiled
def status_after(phase: int, y: Vector, p: Penalty, leg: int) -> int:
    """The status of a leg whose guard has fallen through zero."""
    status = status_of(phase, leg)
    if status == OUT:
        return AWAITED
    above = height(y, p, leg, y, 0)[0]
    ahead = place(y, p, leg, y, 0)[0] - place(y, p, 1 - leg, y, 0)[0]
    leaving = max(AIR * leg_of(p, leg).L_nat - above, ahead, -y[8 + leg])
    return LANDED if status == AWAITED and above < leaving else OUT


#: Imaginary step by which a law is differentiated: its square is lost beside anything but zero.
STEP = 1e-40
#: What `force_slopes` gives.
Slopes = tuple[float, float, float, float]


@compiled
def foot_force(acts: bool, depth: float, rate: float, slip: float, law: PointLaw) -> tuple[float, float]:
    """Normal force and friction [N] at a penetration [m], its rate and the slip [m/s]; none where no ground acts."""
    if not acts or depth <= 0.0:
        return 0.0, 0.0
    normal = law.normal.force(depth, rate, COMPILED)
    return normal, -compiled_coefficient(law, slip, COMPILED) * normal


@compiled
def force_slopes(acts: bool, depth: float, rate: float, slip: float, law: PointLaw) -> Slopes:
    """Derivatives of the normal force by penetration and rate, of friction by the slip, and friction over normal force.

    By a complex step, so that the law's one text gives its derivatives too.
    """
    if not acts or depth <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    by_depth = law.normal.force(complex(depth, STEP), complex(rate, 0.0), TANGENTS)
    by_rate = law.normal.force(complex(depth, 0.0), complex(rate, STEP), TANGENTS)
    coefficient = compiled_coefficient(law, complex(slip, STEP), TANGENTS)
    slope = -(coefficient.imag / STEP) * by_depth.real
    return by_depth.imag / STEP, by_rate.imag / STEP, slope, -coefficient.real


@compiled
def law_change(
    acts: bool, depth: float, rate: float, slip: float, law: PointLaw, numbers: np.ndarray
) -> tuple[float, float]:
    """Change of the normal force, and of friction beside that, at an unchanged state.

    `numbers`: those of the law, with their changes times `STEP` as imaginary parts.
    """
    if not acts or depth <= 0.0:
        return 0.0, 0.0
    normal, friction = law.normal.like(numbers, 0), law.friction.like(numbers, len(law.normal))
    force = normal.force(complex(depth, 0.0), complex(rate, 0.0), TANGENTS)
    varied = PointLaw(normal, friction, numbers[len(law.normal) + len(law.friction)])
    coefficient = compiled_coefficient(varied, complex(slip, 0.0), TANGENTS)
    return force.imag / STEP, -(coefficient.imag / STEP) * force.real
