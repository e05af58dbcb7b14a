"""Single stance of rigid legs with a torque at the hip given over time, and Coulomb friction there.

The torque acts on the angle between the legs, theta + psi, and is linear between its samples. Friction of torque tau
opposes the rate of that angle; where the rate comes to zero the hip sticks while less than tau holds it. Nothing is
asked of the swing foot: it is drawn in, or passes where there is no ground.

Carried along: variations of the start, and of the walker's numbers, the torque and the friction. Where the hip's
friction turns round or begins to stick, the rates jump and so do they (saltation); where it lets go the rates do not.
"""

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.derivatives.numbers import changes_of
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.integration.dop853_tableau import A, B
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import TAU_H, Rigid
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.motion import (
    HIP_STICKS,
    PHASES,
    RUB,
    RUBS_BACK,
    RUBS_FORWARD,
    rigid_along,
    rigid_motion,
    rigid_tangent,
)
from stages.analytic.phases.succession import HIP_AT_REST

#: Longest integration step, in pendulum times: its error is below 1e-13 at the rates of a walk.
LONGEST = 0.05
#: How often a hip may stick, slip or turn round within one step.
TURNS = 50
#: The parameter that is no number of the walker's.
RUBS = "biped.hip_friction"
#: Times of the stages, as parts of a step.
NODES = A.sum(axis=1)


@compiled
def driven_rates(
    y: Vector, p: Rigid, phase: int, torque: float, rows: np.ndarray, torque_along: Vector, rates: Vector
) -> None:
    """Rates of the state and its variations; the last of these go with the directions `rows` (m, fields).

    `torque_along` (m,) are the tangents of the torque along them.
    """
    qdd, inverse = rigid_motion(phase, y, p, torque)
    rates[0], rates[1], rates[2], rates[3] = y[2], y[3], qdd[0], qdd[1]
    jacobian = eq.rigid_residual_jacobian(y[0], y[1], y[2], y[3], qdd[0], qdd[1], p)
    by = eq.rigid_residual_by(y[0], y[1], y[2], y[3], qdd[0], qdd[1], p)
    first = y.size - 4 * rows.shape[0]
    for start in range(4, y.size, 4):
        added = (0.0, 0.0, 0.0)
        if start >= first:
            row = (start - first) // 4
            f1, f2, friction = rigid_along(phase, by, eq.row_as(p, rows, row))
            added = (f1 - torque_along[row], f2 - torque_along[row], friction)
        rates[start], rates[start + 1] = y[start + 2], y[start + 3]
        rates[start + 2], rates[start + 3], _ = rigid_tangent(phase, inverse, jacobian, y, start, added)


@compiled
def advance(
    y: Vector, p: Rigid, phase: int, h: float, torque: tuple[float, float], rows: np.ndarray, torque_along: np.ndarray,
    stages: np.ndarray, new: Vector,
) -> None:  # fmt: skip
    """One step of DOP853 of length `h` into `new`; the torque is `torque` (value, slope) over it.

    `torque_along` (2, m) are the tangents of both along the directions `rows`.
    """
    for stage in range(12):
        for n in range(y.size):
            total = 0.0
            for before in range(stage):
                total += A[stage, before] * stages[before, n]
            new[n] = y[n] + h * total
        time = NODES[stage] * h
        driven_rates(new, p, phase, torque[0] + torque[1] * time, rows, torque_along[0] + torque_along[1] * time,
                     stages[stage])
    for n in range(y.size):
        total = 0.0
        for before in range(12):
            total += B[before] * stages[before, n]
        new[n] = y[n] + h * total


@compiled
def next_phase(y: Vector, p: Rigid, torque: float, phase: int) -> int:
    """How a hip whose legs do not move against each other goes on: it sticks, or begins to rub."""
    needed = rigid_motion(HIP_STICKS, y, p, torque)[0][2]
    if abs(needed) < p.tau_h:
        return HIP_STICKS
    if needed == 0.0:
        return phase
    return RUBS_BACK if needed > 0.0 else RUBS_FORWARD


@compiled
def overstepped(y: Vector, p: Rigid, phase: int, torque: float) -> float:
    """Positive while the hip goes on as it does: its rate in the direction of slip, or what friction has left."""
    if phase == HIP_STICKS:
        return p.tau_h - abs(rigid_motion(phase, y, p, torque)[0][2])
    return float(PHASES[phase, RUB] * (y[2] + y[3]))


@compiled
def located(
    y: Vector, p: Rigid, phase: int, h: float, torque: tuple[float, float], rows: np.ndarray, torque_along: np.ndarray,
    stages: np.ndarray, new: Vector,
) -> float:  # fmt: skip
    """Length of the step from `y` after which the hip no longer goes on as it does; leaves the state there in `new`.

    False position, with a bisection every third time.
    """
    low, high = 0.0, h
    g_low = max(overstepped(y, p, phase, torque[0]), 0.0)
    g_high = overstepped(new, p, phase, torque[0] + torque[1] * h)
    length = h
    for turn in range(80):
        length = low + (high - low) * g_low / (g_low - g_high) if g_low > 0.0 and turn % 3 < 2 else 0.5 * (low + high)
        advance(y, p, phase, length, torque, rows, torque_along, stages, new)
        g = overstepped(new, p, phase, torque[0] + torque[1] * length)
        if g >= 0.0:
            low, g_low = length, g
        else:
            high, g_high = length, g
        if high - low <= 1e-15 + 1e-14 * h or abs(g) <= 1e-15:
            break
    return length


@compiled
def switched(y: Vector, p: Rigid, phase: int, torque: float, rows: np.ndarray, torque_along: Vector) -> int:
    """The phase once the hip's friction turns round, sticks or lets go at `y`, whose variations at a fixed time jump.

    Where it lets go the rates do not jump, and so nothing does.
    """
    if phase == HIP_STICKS:
        return RUBS_BACK if rigid_motion(phase, y, p, torque)[0][2] > 0.0 else RUBS_FORWARD
    then = next_phase(y, p, torque, RUBS_BACK if phase == RUBS_FORWARD else RUBS_FORWARD)
    before, after = np.empty(y.size), np.empty(y.size)
    driven_rates(y, p, phase, torque, rows, torque_along, before)
    driven_rates(y, p, then, torque, rows, torque_along, after)
    for column in range(4, y.size, 4):
        delay = -(y[column + 2] + y[column + 3]) / (before[2] + before[3])
        for n in range(4):
            y[column + n] += (before[n] - after[n]) * delay
    return then


@compiled
def drive(
    start: Vector, p: Rigid, interval: float, torque: Vector, rows: np.ndarray, torque_along: np.ndarray,
    states: np.ndarray,
) -> int:  # fmt: skip
    """Write state and variations at the samples of `torque` (n,) into `states` (n, size), the first of them `start`.

    `torque_along` (m, n): tangents along the directions `rows` (m, fields). Returns the number of samples reached:
    fewer than n where the hip's friction chatters.
    """
    size, count = start.size, rows.shape[0]
    stages, new = np.empty((12, size)), np.empty(size)
    y, changes = start.copy(), np.empty((2, count))
    parts = int(np.ceil(interval / LONGEST))
    phase = RUBS_FORWARD if y[2] + y[3] > 0.0 else RUBS_BACK
    if abs(y[2] + y[3]) <= HIP_AT_REST:
        phase = next_phase(y, p, torque[0], phase)
    states[0] = y
    for sample in range(torque.size - 1):
        slope = (torque[sample + 1] - torque[sample]) / interval
        for part in range(parts):
            done, whole, turns = 0.0, interval / parts, 0
            while done < whole:
                at = part * whole + done
                value = torque[sample] + slope * at
                for row in range(count):
                    changes[1, row] = (torque_along[row, sample + 1] - torque_along[row, sample]) / interval
                    changes[0, row] = torque_along[row, sample] + changes[1, row] * at
                h = whole - done
                advance(y, p, phase, h, (value, slope), rows, changes, stages, new)
                left = overstepped(new, p, phase, value + slope * h)
                if left >= -HIP_AT_REST or p.tau_h == 0.0:
                    y[:] = new
                    break
                if turns == TURNS:
                    return sample + 1
                turns += 1
                h = located(y, p, phase, h, (value, slope), rows, changes, stages, new)
                done += h
                there = value + slope * h
                y[:] = new
                phase = switched(y, p, phase, there, rows, changes[0] + changes[1] * h)
        states[sample + 1] = y
    return torque.size


@dataclass(frozen=True)
class DrivenStance:
    """A driven single stance at the samples of its torque, SI units.

    `states` (n, 4): stance angle (hip ahead positive), swing angle (foot ahead positive) and their rates [rad, rad/s].
    `by_start` (n, 4, 4): derivatives by the first of them. `along` (n, 4, m): by the parameters, in their units, then
    by the sizes of the torques requested. Fewer rows than samples where the hip's friction chatters.
    """

    states: np.ndarray
    by_start: np.ndarray
    along: np.ndarray


def driven_stance(
    design: DesignPoint, start: Vector, interval: float, torque: Vector, names: Sequence[str] = (),
    torques: np.ndarray | None = None,
) -> DrivenStance:  # fmt: skip
    """Single stance of a design with rigid legs, leg 0 standing, from the state `start` (4,), SI units.

    `torque` (n,) are samples every `interval` seconds of the hip's torque on the angle between the legs, stance angle
    plus swing angle. Derivatives are taken by the parameters `names` ("biped.hip_friction" among them) and by the size
    of each of the torques (k, n), so that a torque constant times a signal has a derivative. The ground is the
    design's slope, level at 0 degrees. For leg 1 standing exchange the legs of the biped.

    Raises KeyError for a name that the motion does not depend on, ValueError for compliant legs.
    """
    if design.biped.legs != "rigid":
        raise ValueError("biped.legs = compliant: a driven single stance has rigid legs")
    walker, by_names = _without_friction(design, tuple(names))
    directions = np.zeros((0, len(torque))) if torques is None else np.asarray(torques)
    unit, scales = walker.energy, walker.scales()
    p: Any = walker.p._replace(tau_h=design.biped.hip_friction / unit)
    count = len(names) + len(directions)
    rows = np.zeros((count, by_names.shape[1]))
    rows[: len(names)] = by_names
    rows[: len(names), TAU_H] = [1.0 / unit if name == RUBS else 0.0 for name in names]
    driven = np.concatenate([np.zeros((len(names), len(torque))), directions / unit])
    first = np.concatenate([np.asarray(start) / scales, np.eye(4).ravel(), np.zeros(4 * count)])
    states = np.empty((len(torque), first.size))
    reached = drive(first, p, interval / walker.time, np.asarray(torque) / unit, rows, driven, states)
    found = states[:reached].reshape(reached, -1, 4)
    by_start = found[:, 1:5].transpose(0, 2, 1) * scales[:, None] / scales
    return DrivenStance(found[:, 0] * scales, by_start, found[:, 5:].transpose(0, 2, 1) * scales[:, None])


@functools.lru_cache(maxsize=4)  # the steps of a recording are those of one design, with either leg standing
def _without_friction(design: DesignPoint, names: tuple[str, ...]) -> tuple[Walker, np.ndarray]:
    """Walker of a design whose hip does not rub, and how its numbers change with the parameters, (m, fields)."""
    smooth = replace(design, biped=replace(design.biped, hip_friction=0.0), detailed=True)
    changes = changes_of(smooth, [name for name in names if name != RUBS])
    walker, rows = smooth.walker(), iter(changes.along / changes.scales[:, None])
    return walker, np.array([np.zeros(len(walker.p)) if name == RUBS else next(rows) for name in names]).reshape(
        len(names), len(walker.p))
