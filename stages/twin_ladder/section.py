"""Mid-stance of the twin: the state in numbers, split into motion in the plane and out of it.

At mid-stance the standing pair is normal to the ground. Place along and across the slope do not matter, and pairs are
named by role, so that a step maps the section onto itself where both pairs are alike. A slope with a plane of symmetry
keeps the two kinds of motion apart to first order: ten numbers in the plane, those of the planar model's section, and
nine out of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.planar.section import NoLimitCycle
from stages.twin.machine.contact import COUNT, HINGE, PITCH, ROLL, SLIDE, YAW, X, Y, Z
from stages.twin.machine.machine import Machine
from stages.twin.machine.tree import SpatialTree
from stages.twin.parameters import Settings
from stages.twin.walking.record import Record
from stages.twin.walking.simulate import Start, simulate_twin

#: Units of the numbers out of the plane.
SIDE_UNITS = ("rad", "rad", "m", "m", "m/s", "rad/s", "rad/s", "m/s", "m/s")


@dataclass(frozen=True)
class SectionState:
    """A mid-stance by role of the pairs.

    plane (10,): hip y; swing angle; lengths of stance and swing legs; hip velocity x, y; rates of both angles and of
    both lengths. side (9,): yaw; roll; half the length difference left less right of stance and swing legs; hip
    velocity z; rates of yaw, roll and the differences. Lengths are means of a pair, from hip to foot bottom.
    """

    plane: np.ndarray
    side: np.ndarray


@dataclass(frozen=True)
class Step:
    """One step: the mid-stance it ends with, its duration [s], the hip's advance [m], the solver's steps and record."""

    end: SectionState
    duration: float
    length: float
    solver_steps: int
    record: Record


def section_state(q: np.ndarray, v: np.ndarray, stance: int, length: np.ndarray) -> SectionState:
    """Numbers of a mid-stance on pair `stance` from coordinates and rates (11,) and unloaded leg lengths (4,)."""
    legs, rates = length - q[list(SLIDE)], -v[list(SLIDE)]
    angle, turning = (row[[PITCH, PITCH]] + [0.0, row[HINGE]] for row in (q, v))
    order = [stance, 1 - stance]
    mean, half = legs.reshape(2, 2).mean(axis=1)[order], (0.5 * (legs[::2] - legs[1::2]))[order]
    mean_rate, half_rate = rates.reshape(2, 2).mean(axis=1)[order], (0.5 * (rates[::2] - rates[1::2]))[order]
    plane = [q[Y], angle[1 - stance], *mean, v[X], v[Y], *turning[order], *mean_rate]
    side = [q[YAW], q[ROLL], *half, v[Z], v[YAW], v[ROLL], *half_rate]
    return SectionState(np.array(plane), np.array(side))


def start_from(state: SectionState, stance: int, length: np.ndarray) -> Start:
    """The inverse of `section_state`, at x = z = 0, the swinging pair out of play."""
    q, v = np.zeros(COUNT), np.zeros(COUNT)
    y, swing, *lengths = state.plane[:4]
    forward, upward, *rates = state.plane[4:]
    q[Y], q[YAW], q[ROLL] = y, state.side[0], state.side[1]
    v[X], v[Y], v[Z], v[YAW], v[ROLL] = forward, upward, *state.side[4:7]
    angles, turning = np.array([0.0, swing]), np.array(rates[:2])
    if stance == 1:
        angles, turning = angles[::-1], turning[::-1]
    q[PITCH], q[HINGE] = angles[0], angles[1] - angles[0]
    v[PITCH], v[HINGE] = turning[0], turning[1] - turning[0]
    for role, pair in enumerate((stance, 1 - stance)):
        for side, sign in enumerate((1.0, -1.0)):
            leg = 2 * pair + side
            q[SLIDE[leg]] = length[leg] - lengths[role] - sign * state.side[2 + role]
            v[SLIDE[leg]] = -rates[2 + role] - sign * state.side[7 + role]
    return Start(q, v, (stance == 0, stance == 1))


StepMap = Callable[[SectionState, int], Step]


def step_map(machine: Machine, slope: Slope, contact: ContactLaw, settings: Settings) -> StepMap:
    """A function that takes a step from a mid-stance on a pair to the next on the other; it raises NoLimitCycle."""
    tree = SpatialTree(machine, slope, contact)

    def take(state: SectionState, stance: int) -> Step:
        start = start_from(state, stance, machine.length)
        record = simulate_twin(machine, slope, contact, start, settings, steps=1, tree=tree)
        if not record.completed:
            raise NoLimitCycle(record.reason or record.outcome)
        return _mid_stance(record, 1 - stance, machine.length)

    return take


def _mid_stance(record: Record, stance: int, length: np.ndarray) -> Step:
    """The end of a record, brought to the moment in which the new standing pair is normal to the ground."""

    def lean(place: np.ndarray) -> Any:
        return place[..., PITCH] + (place[..., HINGE] if stance else 0.0)

    ahead = np.flatnonzero(lean(record.position) > 0.0)
    if not len(ahead) or ahead[-1] + 1 == len(record.time):
        raise NoLimitCycle("the step does not end in mid-stance")
    before = int(ahead[-1])  # the solver may take a step more than asked
    at, span = record.after(before), record.time[before : before + 2]
    moment = float(brentq(lambda time: float(lean(at(time)[0])), *span, xtol=1e-15, rtol=8.9e-16))
    q, v = (rows[0] for rows in record.at(np.array([moment])))
    return Step(section_state(q, v, stance, length), moment, float(q[X]), before + 1, record)
