"""Forces of the ground on the four feet, compiled: generalized forces on the tree's coordinates.

Each foot is a cylinder whose axis is parallel to the hip axis. It touches the ground with its two end circles; the
lowest point of each is a contact point with a quarter of a leg pair's law, so that roll and yaw are resisted by where
the feet stand. A cylinder's lowest line lies along -b, where b is the frame's upright axis before pitch.

The laws are the texts of `stages.ground`. One call from Exudyn costs about 6 us where eight connectors cost 60 us.
"""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from struct import Struct
from typing import Any, cast

import numba
import numpy as np

from stages.ground.compiled import COMPILED, compiled_slope, kept_with_ground
from stages.ground.contact_law import ContactLaw
from stages.ground.laws import PointLaw

compiled = kept_with_ground(Path(__file__).parent)

# Rows of the coordinate vector
X, Y, Z, YAW, ROLL, PITCH, HINGE = 0, 1, 2, 3, 4, 5, 8
SLIDE = (6, 7, 9, 10)
COUNT = 11
#: Rows that a machine with rigid legs has: in its tree there are no slides. Everywhere else its slides stay zero.
RIGID_ROWS = (0, 1, 2, 3, 4, 5, 8)


def point_law(contact: ContactLaw) -> PointLaw:
    """The law of one contact point as the compiled functions take it; `contact` is that of a leg pair, 4 points."""
    return contact.shared_by(4).numbers


@compiled
def feet_forces(
    q: np.ndarray, v: np.ndarray, ground: np.ndarray, feet: np.ndarray, law: PointLaw
) -> tuple[np.ndarray, np.ndarray, float]:
    """Generalized forces (11,), force on each foot (4, 3) [N], and the power of all of them [W].

    q, v: coordinates and rates; ground (4,): whether it acts on each pair, and its heights under them; feet:
    `Machine.feet`.
    """
    total = np.zeros(11)
    force = np.zeros((4, 3))
    power = 0.0
    sy, cy, sr, cr = math.sin(q[3]), math.cos(q[3]), math.sin(q[4]), math.cos(q[4])
    b0, b1, b2 = sr * sy, cr, sr * cy  # upright axis before pitch; forward axis (cy, 0, -sy)
    a0, a1, a2 = cr * sy, -sr, cr * cy  # hip axis
    for leg in range(4):
        if ground[leg // 2] == 0.0:
            continue
        hip = q[1] - ground[2 + leg // 2]
        slide = 6 + leg + leg // 2
        angle, spin = q[5], v[5]
        if leg > 1:
            angle += q[8]
            spin += v[8]
        lane, radius, length, half = feet[leg, 0], feet[leg, 1], feet[leg, 2], feet[leg, 3]
        reach = length - radius - q[slide]
        sine, cosine = math.sin(angle), math.cos(angle)
        middle = hip - reach * cosine * cr - radius * cr - lane * sr
        if middle > half * abs(sr):
            continue
        u0, u1, u2 = -sine * cy + cosine * b0, cosine * b1, sine * sy + cosine * b2  # up the leg
        w0, w1, w2 = v[4] * cy + spin * a0, v[3] + spin * a1, -v[4] * sy + spin * a2
        for edge in range(2):
            across = lane + half if edge == 0 else lane - half
            d0 = -reach * u0 - radius * b0 + across * a0  # from the hip to the contact point
            d1 = -reach * u1 - radius * b1 + across * a1
            d2 = -reach * u2 - radius * b2 + across * a2
            depth = -(hip + d1)
            if depth <= 0.0:
                continue
            s0 = v[0] + w1 * d2 - w2 * d1 + v[slide] * u0
            s1 = v[1] + w2 * d0 - w0 * d2 + v[slide] * u1
            s2 = v[2] + w0 * d1 - w1 * d0 + v[slide] * u2
            f1 = law.normal.force(depth, -s1, COMPILED)
            drag = f1 * compiled_slope(law, s0, s2, COMPILED)
            f0, f2 = -drag * s0, -drag * s2
            m0, m1, m2 = d1 * f2 - d2 * f1, d2 * f0 - d0 * f2, d0 * f1 - d1 * f0
            about_hip_axis = a0 * m0 + a1 * m1 + a2 * m2
            total[0] += f0
            total[1] += f1
            total[2] += f2
            total[3] += m1
            total[4] += cy * m0 - sy * m2
            total[5] += about_hip_axis
            if leg > 1:
                total[8] += about_hip_axis
            total[slide] += u0 * f0 + u1 * f1 + u2 * f2
            force[leg, 0] += f0
            force[leg, 1] += f1
            force[leg, 2] += f2
            power += f0 * s0 + f1 * s1 + f2 * s2
    return total, force, power


@compiled
def generalized_force(work: np.ndarray, law: PointLaw) -> None:
    """The generalized forces of `feet_forces` for the solver, which come last in `work` (53,).

    Before them: coordinates, rates, the ground as there, and `Machine.feet` row by row. One array for
    all costs less than to hand over three, which takes as long as the forces.
    """
    force = feet_forces(work[:11], work[11:22], work[22:26], work[26:42].reshape((4, 4)), law)[0]
    for row in range(11):
        work[42 + row] = force[row]


@compiled
def rigid_generalized_force(work: np.ndarray, law: PointLaw) -> None:
    """The same for rigid legs: coordinates, rates and generalized forces are those of `RIGID_ROWS`, work (41,)."""
    place, motion = np.zeros(11), np.zeros(11)
    for row in range(7):
        wide = row if row < 6 else 8
        place[wide], motion[wide] = work[row], work[7 + row]
    force = feet_forces(place, motion, work[14:18], work[18:34].reshape((4, 4)), law)[0]
    for row in range(7):
        work[34 + row] = force[row if row < 6 else 8]


def solver_force(
    feet: np.ndarray, law: PointLaw, rigid: bool
) -> tuple[Callable[[Sequence[float], Sequence[float]], memoryview], np.ndarray]:
    """`generalized_force` of coordinates and rates, and the array (4,) that says on which pairs the ground acts,
    and its heights under them.

    The answer is the same view each time, whose items Exudyn takes for less than those of an array. The compiled
    function is found once: numba's search by type would take twice the call.
    """
    rows = len(RIGID_ROWS) if rigid else COUNT
    work = np.concatenate([np.zeros(2 * rows), [1.0, 1.0, 0.0, 0.0], feet.ravel(), np.zeros(rows)])
    view, put = work.data, Struct(f"{2 * rows}d").pack_into
    total = view[-rows:]
    force = found(rigid_generalized_force if rigid else generalized_force, work, law)

    def answer(q: Sequence[float], v: Sequence[float]) -> memoryview:
        put(view, 0, *q, *v)
        force(work, law)
        return total

    return answer, work[2 * rows : 2 * rows + 4]


def found(function: Callable[..., Any], *arguments: object) -> Callable[..., Any]:
    """The compiled function for arguments of such types, as numba's own search for it takes longer than some calls."""
    function(*arguments)
    dispatcher, typeof = cast(Any, function), cast(Any, numba.typeof)
    one: Callable[..., Any] = dispatcher.get_overload(tuple(typeof(argument) for argument in arguments))
    return one


@compiled
def feet_places(q: np.ndarray, feet: np.ndarray) -> np.ndarray:
    """Of each foot x of its middle, height of its lowest point above the ground and z of its middle, (4, 3) [m]."""
    places = np.zeros((4, 3))
    sy, cy, sr, cr = math.sin(q[3]), math.cos(q[3]), math.sin(q[4]), math.cos(q[4])
    for leg in range(4):
        angle = q[5] + (q[8] if leg > 1 else 0.0)
        reach = feet[leg, 2] - feet[leg, 1] - q[6 + leg + leg // 2]
        sine, cosine = math.sin(angle), math.cos(angle)
        places[leg, 0] = q[0] + reach * (sine * cy - cosine * sr * sy) + feet[leg, 0] * cr * sy
        places[leg, 1] = q[1] - reach * cosine * cr - feet[leg, 1] * cr - feet[leg, 0] * sr - feet[leg, 3] * abs(sr)
        places[leg, 2] = q[2] - reach * (sine * sy + cosine * sr * cy) + feet[leg, 0] * cr * cy
    return places


@compiled
def clearances(q: np.ndarray, feet: np.ndarray) -> tuple[tuple[float, float], tuple[float, float]]:
    """Lowest point of each pair above the ground [m], and the mean x of its feet's centres [m]."""
    places = feet_places(q, feet)
    lowest = min(places[0, 1], places[1, 1]), min(places[2, 1], places[3, 1])
    return lowest, (0.5 * places[0, 0] + 0.5 * places[1, 0], 0.5 * places[2, 0] + 0.5 * places[3, 0])


@compiled
def along(
    q: np.ndarray, v: np.ndarray, ground: np.ndarray, feet: np.ndarray, law: PointLaw
) -> tuple[np.ndarray, np.ndarray]:
    """`feet_forces` for rows of states: force (n, 4, 3) [N] and power (n,) [W]."""
    n = len(q)
    force = np.zeros((n, 4, 3))
    power = np.zeros(n)
    for i in range(n):
        _, feet_force, power[i] = feet_forces(q[i], v[i], ground[i], feet, law)
        for leg in range(4):  # element by element: assigning arrays costs the compiler seconds
            for axis in range(3):
                force[i, leg, axis] = feet_force[leg, axis]
    return force, power


@compiled
def clearances_along(q: np.ndarray, feet: np.ndarray) -> np.ndarray:
    """Lowest point of each pair above the ground for rows of states, (n, 2) [m]."""
    lowest = np.zeros((len(q), 2))
    for i in range(len(q)):
        found = clearances(q[i], feet)[0]
        lowest[i, 0], lowest[i, 1] = found[0], found[1]
    return lowest
