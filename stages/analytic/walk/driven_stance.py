"""Single stance of rigid legs with a torque at the hip given over time, and Coulomb friction there.

The torque acts on the angle between the legs, theta + psi, and is linear between its samples. Friction of torque tau
opposes the rate of that angle; where the rate comes to zero the hip sticks while less than tau holds it. Nothing is
asked of the swing foot: it is drawn in, or passes where there is no ground.

Carried along: variations of the start, and of the walker's numbers, the torque and the friction. Where the hip's
friction turns round or begins to stick, the rates jump and so do they (saltation); where it lets go the rates do not.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.derivatives.equations import terms as ep
from stages.analytic.derivatives.numbers import changes_of
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.integration.dop853_tableau import A, B
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import Rigid
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.flow import rigid_acceleration, row4_times
from stages.analytic.phases.hip_friction import AT_REST, holding_torque

#: How the hip moves: it sticks, or slips with the sign of the rate of theta + psi.
STICKS = 0
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
    y: Vector, p: Rigid, slip: int, torque: float, friction: float, along: np.ndarray, torque_along: Vector,
    friction_along: Vector, rates: Vector,
) -> None:  # fmt: skip
    """Rates of the state and its variations; the last of these go with rows of `along` (m, fields).

    `torque_along` and `friction_along` (m,) are the changes of torque and friction in these rows.
    """
    qdd, inverse = rigid_acceleration(y, p)
    each1, each2 = inverse[0] + inverse[1], inverse[1] + inverse[2]
    total = torque - slip * friction
    if slip == STICKS:
        total = -(qdd[0] + qdd[1]) / (each1 + each2)
    a1, a2 = qdd[0] + each1 * total, qdd[1] + each2 * total
    rates[0], rates[1], rates[2], rates[3] = y[2], y[3], a1, a2
    jacobian = eq.rigid_residual_jacobian(y[0], y[1], y[2], y[3], a1, a2, p)
    by = ep.rigid_residual_by(y[0], y[1], y[2], y[3], a1, a2, p)
    first = y.size - 4 * along.shape[0]
    for start in range(4, y.size, 4):
        f1, f2 = -row4_times(jacobian[0:4], y, start), -row4_times(jacobian[4:8], y, start)
        if start >= first:
            row = (start - first) // 4
            change = ep.rigid_residual_change(by, ep.row_as(p, along, row))
            push = torque_along[row] - slip * friction_along[row]
            f1, f2 = f1 - change[0] + push, f2 - change[1] + push
        d1, d2 = inverse[0] * f1 + inverse[1] * f2, inverse[1] * f1 + inverse[2] * f2
        if slip == STICKS:
            held = -(d1 + d2) / (each1 + each2)
            d1, d2 = d1 + each1 * held, d2 + each2 * held
        rates[start], rates[start + 1], rates[start + 2], rates[start + 3] = y[start + 2], y[start + 3], d1, d2


@compiled
def advance(
    y: Vector, p: Rigid, slip: int, h: float, torque: tuple[float, float], friction: float, along: np.ndarray,
    torque_along: np.ndarray, friction_along: Vector, stages: np.ndarray, new: Vector,
) -> None:  # fmt: skip
    """One step of DOP853 of length `h` into `new`; the torque is `torque` (value, slope) over it.

    `torque_along` (2, m) are changes of both in the rows of `along`.
    """
    for stage in range(12):
        for n in range(y.size):
            total = 0.0
            for before in range(stage):
                total += A[stage, before] * stages[before, n]
            new[n] = y[n] + h * total
        time = NODES[stage] * h
        driven_rates(new, p, slip, torque[0] + torque[1] * time, friction, along,
                     torque_along[0] + torque_along[1] * time, friction_along, stages[stage])
    for n in range(y.size):
        total = 0.0
        for before in range(12):
            total += B[before] * stages[before, n]
        new[n] = y[n] + h * total


@compiled
def next_slip(y: Vector, p: Rigid, torque: float, friction: float, slip: int) -> int:
    """How a hip whose legs do not move against each other goes on: it sticks, or begins to slip."""
    needed, _ = holding_torque(y, p, torque)
    if abs(needed) < friction:
        return STICKS
    if needed == 0.0:
        return slip
    return -1 if needed > 0.0 else 1


@compiled
def overstepped(y: Vector, p: Rigid, slip: int, torque: float, friction: float) -> float:
    """Positive while the hip goes on as it does: its rate in the direction of slip, or what friction has left."""
    if slip == STICKS:
        return friction - abs(holding_torque(y, p, torque)[0])
    return float(slip * (y[2] + y[3]))


@compiled
def located(
    y: Vector, p: Rigid, slip: int, h: float, torque: tuple[float, float], friction: float, along: np.ndarray,
    torque_along: np.ndarray, friction_along: Vector, stages: np.ndarray, new: Vector,
) -> float:  # fmt: skip
    """Length of the step from `y` after which the hip no longer goes on as it does; leaves the state there in `new`.

    False position, with a bisection every third time.
    """
    low, high = 0.0, h
    g_low = max(overstepped(y, p, slip, torque[0], friction), 0.0)
    g_high = overstepped(new, p, slip, torque[0] + torque[1] * h, friction)
    length = h
    for turn in range(80):
        length = low + (high - low) * g_low / (g_low - g_high) if g_low > 0.0 and turn % 3 < 2 else 0.5 * (low + high)
        advance(y, p, slip, length, torque, friction, along, torque_along, friction_along, stages, new)
        g = overstepped(new, p, slip, torque[0] + torque[1] * length, friction)
        if g >= 0.0:
            low, g_low = length, g
        else:
            high, g_high = length, g
        if high - low <= 1e-15 + 1e-14 * h or abs(g) <= 1e-15:
            break
    return length


@compiled
def drive(
    start: Vector, p: Rigid, interval: float, torque: Vector, friction: float, along: np.ndarray,
    torque_along: np.ndarray, friction_along: Vector, states: np.ndarray,
) -> int:  # fmt: skip
    """Write state and variations at the samples of `torque` (n,) into `states` (n, size), the first of them `start`.

    `torque_along` (m, n), `friction_along` (m,): changes with the rows of `along` (m, fields). Returns the number of
    samples reached: fewer than n where the hip's friction chatters.
    """
    size, rows = start.size, along.shape[0]
    stages, new, before, after = np.empty((12, size)), np.empty(size), np.empty(size), np.empty(size)
    y, changes = start.copy(), np.empty((2, rows))
    parts = int(np.ceil(interval / LONGEST))
    slip = 1 if y[2] + y[3] > 0.0 else -1
    if abs(y[2] + y[3]) <= AT_REST:
        slip = next_slip(y, p, torque[0], friction, slip)
    states[0] = y
    for sample in range(torque.size - 1):
        slope = (torque[sample + 1] - torque[sample]) / interval
        for part in range(parts):
            done, whole, turns = 0.0, interval / parts, 0
            while done < whole:
                at = part * whole + done
                value = torque[sample] + slope * at
                for row in range(rows):
                    changes[1, row] = (torque_along[row, sample + 1] - torque_along[row, sample]) / interval
                    changes[0, row] = torque_along[row, sample] + changes[1, row] * at
                h = whole - done
                advance(y, p, slip, h, (value, slope), friction, along, changes, friction_along, stages, new)
                left = overstepped(new, p, slip, value + slope * h, friction)
                if left >= -AT_REST or friction == 0.0:
                    y[:] = new
                    break
                if turns == TURNS:
                    return sample + 1
                turns += 1
                h = located(y, p, slip, h, (value, slope), friction, along, changes, friction_along, stages, new)
                done += h
                there = value + slope * h
                y[:] = new
                was = slip
                if was == STICKS:
                    slip = -1 if holding_torque(y, p, there)[0] > 0.0 else 1
                else:  # the rates jump, so variations at a fixed time do
                    slip = next_slip(y, p, there, friction, -slip)
                    now = changes[0] + changes[1] * h
                    driven_rates(y, p, was, there, friction, along, now, friction_along, before)
                    driven_rates(y, p, slip, there, friction, along, now, friction_along, after)
                    closing = before[2] + before[3]
                    for column in range(4, size, 4):
                        delay = -(y[column + 2] + y[column + 3]) / closing
                        for n in range(4):
                            y[column + n] += (before[n] - after[n]) * delay
        states[sample + 1] = y
    return torque.size


@dataclass(frozen=True)
class DrivenStance:
    """A driven single stance at the samples of its torque, SI units.

    `states` (n, 4): stance angle (hip ahead positive), swing angle (foot ahead positive) and their rates [rad, rad/s].
    `by_start` (n, 4, 4): derivatives by the first of them. `along` (n, 4, m): by the parameters, in their units, then
    by the sizes of the torques asked for. Fewer rows than samples where the hip's friction chatters.
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
    numbers: Any = walker.p
    directions = np.zeros((0, len(torque))) if torques is None else np.asarray(torques)
    unit, scales, friction = walker.energy, walker.scales(), design.biped.hip_friction
    count = len(names) + len(directions)
    along, rubs = np.zeros((count, by_names.shape[1])), np.zeros(count)
    along[: len(names)] = by_names
    rubs[: len(names)] = [1.0 / unit if name == RUBS else 0.0 for name in names]
    driven = np.concatenate([np.zeros((len(names), len(torque))), directions / unit])
    first = np.concatenate([np.asarray(start) / scales, np.eye(4).ravel(), np.zeros(4 * count)])
    states = np.empty((len(torque), first.size))
    reached = drive(first, numbers, interval / walker.time, np.asarray(torque) / unit, friction / unit, along, driven,
                    rubs, states)
    found = states[:reached].reshape(reached, -1, 4)
    by_start = found[:, 1:5].transpose(0, 2, 1) * scales[:, None] / scales
    return DrivenStance(found[:, 0] * scales, by_start, found[:, 5:].transpose(0, 2, 1) * scales[:, None])


@functools.lru_cache(maxsize=4)  # the steps of a recording are those of one design, with either leg standing
def _without_friction(design: DesignPoint, names: tuple[str, ...]) -> tuple[Walker, np.ndarray]:
    """Walker of a design whose hip does not rub, and how its numbers change with the parameters, (m, fields)."""
    smooth = dataclasses.replace(design, biped=dataclasses.replace(design.biped, hip_friction=0.0), detailed=True)
    changes = changes_of(smooth, [name for name in names if name != RUBS])
    walker, rows = smooth.walker(), iter(changes.along / changes.scales[:, None])
    return walker, np.array([np.zeros(len(walker.p)) if name == RUBS else next(rows) for name in names]).reshape(
        len(names), len(walker.p))
