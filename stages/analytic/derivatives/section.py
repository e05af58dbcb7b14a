"""The section just after heel strike for changes of the walker's numbers: states from coordinates, and back."""

from __future__ import annotations

from collections.abc import Callable
from math import sin

import numpy as np

from stages.analytic.compiled import ByKind, compiled
from stages.analytic.derivatives.equations import terms as ep
from stages.analytic.derivatives.response import change_of, clearance_change, contact_rate_change
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot
from stages.analytic.model.kinds import DetailedRigid, PlainRigid, RubbingRigid, TimedRigid
from stages.analytic.model.varied import Varied, VariedCompliant, VariedLimited, VariedRigidLegs
from stages.analytic.model.walker import Vector
from stages.analytic.phases.flow import contact_directions, row4_times
from stages.analytic.phases.section import entries_of, limited_coordinates


@compiled
def no_trailing_change(y: Vector, p: PlainRigid | TimedRigid, d: PlainRigid | TimedRigid) -> float:
    """`trailing_angle_change` where states on the section are the coordinates."""
    return 0.0


@compiled
def detailed_trailing_angle_change(y: Vector, p: DetailedRigid, d: DetailedRigid) -> float:
    """`trailing_angle_change` of legs that may differ: the clearance stays zero."""
    change: float = ep.rigid_clearance_change(ep.rigid_clearance_by(y[0], y[1], p), d)[0]
    return -change / ((p.L_nat_2 - p.r_2) * sin(y[1]))


#: Change of the trailing leg's angle for a change of the numbers, both legs rigid: trailing_angle_change(y, p, d).
trailing_angle_change: Callable[..., float] = ByKind({
    PlainRigid | TimedRigid: no_trailing_change, DetailedRigid | RubbingRigid: detailed_trailing_angle_change})


@compiled
def rigid_section_change(y: Vector, p: VariedRigidLegs) -> Vector:
    """`section_change` of rigid legs."""
    changes = np.zeros(4 * p.along.shape[0])
    for row in range(p.along.shape[0]):
        changes[4 * row + 1] = trailing_angle_change(y, p.plain, change_of(p, row))
    return changes


@compiled
def compliant_section_change(y: Vector, p: VariedCompliant) -> Vector:
    """`section_change` of compliant legs: the clearance fixes dpsi, then both constraint rates two rates."""
    normal, roll, _, _ = contact_directions(y, p.plain)
    rates = (y[4], y[5], y[6], y[7])
    by_state = eq.contact_acceleration_jacobian(
        y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, y[4], y[5], y[6], y[7], p.plain)
    inverse = 1.0 / (normal[2] * roll[3] - normal[3] * roll[2])
    changes = np.zeros(8 * p.along.shape[0])
    for row in range(p.along.shape[0]):
        s, d = 8 * row, change_of(p, row)
        changes[s + 2] = -clearance_change(y, p.plain, d) / normal[2]
        contact = contact_rate_change(y, rates, p.plain, d)
        f1 = -contact[0] - row4_times(by_state[0:4], changes, s)
        f2 = -contact[1] - row4_times(by_state[8:12], changes, s)
        changes[s + 6] = inverse * (f1 * roll[3] - normal[3] * f2)
        changes[s + 7] = inverse * (normal[2] * f2 - roll[2] * f1)
    return changes


#: Change of the state y on the section at given section coordinates, rows of `along` one after another:
#: section_change(y, p).
section_change: Callable[..., Vector] = ByKind({
    VariedRigidLegs: rigid_section_change, VariedCompliant: compliant_section_change})


@compiled
def limited_speed_changes(y: Vector, p: VariedLimited, changes: np.ndarray) -> None:
    """Write the changes of the trailing foot's two speeds into rows 5 and 6 of `coordinate_changes`."""
    plain = eq.exchanged(p.plain)
    normal, roll, _, _ = contact_directions(y, plain)
    rates = (y[4], y[5], y[6], y[7])
    by_state = eq.contact_acceleration_jacobian(
        y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, y[4], y[5], y[6], y[7], plain)
    z, rows = limited_coordinates(y, plain), p.along.shape[0]
    for row in range(rows):
        s = y.size - 8 * (rows - row)
        contact = contact_rate_change(y, rates, plain, eq.exchanged(change_of(p, row)))
        moved = (y[s + 4], y[s + 5], y[s + 6], y[s + 7])
        if z[5] > 0.0:
            changes[5, row] = dot(normal, moved) + row4_times(by_state[0:4], y, s) + contact[0]
        if z[5] > 0.0 or z[6] != 0.0:
            changes[6, row] = dot(roll, moved) + row4_times(by_state[8:12], y, s) + contact[1]


def coordinate_changes(y: Vector, p: Varied) -> np.ndarray:
    """Changes (j, n) of the section coordinates from the last n variations of the state in y, at the end of a step."""
    size, entries = 4 if isinstance(p, VariedRigidLegs) else 8, entries_of(p.plain)
    rows = p.along.shape[0]
    moved = y[y.size - size * rows :].reshape(rows, size)
    changes = np.zeros((7 if isinstance(p, VariedLimited) else len(entries), rows))
    changes[: len(entries)] = moved[:, entries].T
    if isinstance(p, VariedLimited):
        limited_speed_changes(y, p, changes)
    return changes
