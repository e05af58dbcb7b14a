"""The twin with the numbers of a planar biped: what undoes the projection."""

from __future__ import annotations

import dataclasses

import numpy as np

from stages.biped.design import Biped, Leg
from stages.twin.machine.bill import Body, join
from stages.twin.machine.machine import FRAME_BODY, Machine
from stages.twin.machine.projection import project


def with_numbers_of(machine: Machine, biped: Biped) -> Machine:
    """`machine` with masses, mass centres, moments, springs, lengths and radii changed so that it moves as `biped`.

    Where things sit along the hip axis stays as it is, and left and right change alike. A hip mass hangs on the axis,
    half at each frame.
    """
    now, bodies = project(machine), list(machine.bodies)
    lengths, radii = machine.length.copy(), machine.radius.copy()
    stiffness, damping = machine.stiffness.copy(), machine.damping.copy()
    for pair in (0, 1):
        have, wanted, legs, first = now.leg(pair), biped.leg(pair), slice(2 * pair, 2 * pair + 2), FRAME_BODY[pair]
        bodies[first] = _frame(bodies[first], wanted, 0.5 * biped.hip_mass)
        for number in (first + 1, first + 2):
            bodies[number] = _foot(bodies[number], have, wanted)
        lengths[legs] += wanted.leg_length - have.leg_length
        radii[legs] += wanted.foot_radius - have.foot_radius
        stiffness[legs] *= wanted.stiffness / have.stiffness
        damping[legs] *= wanted.damping / have.damping if have.damping else 1.0
    return dataclasses.replace(
        machine, bodies=tuple(bodies), length=lengths, radius=radii, stiffness=stiffness, damping=damping,
        bearing_friction=biped.hip_damping)


def _frame(body: Body, wanted: Leg, on_axis: float) -> Body:
    """A frame as wanted, with a point mass [kg] on the hip axis."""
    across = body.centre[2]
    hung = Body(wanted.frame_mass, np.array([wanted.frame_offset, -wanted.frame_com, across]),
                _turning(body.inertia, wanted.frame_inertia))
    return join([hung, Body(on_axis, np.array([0.0, 0.0, across]), np.zeros((3, 3)))]) if on_axis else hung


def _foot(body: Body, have: Leg, wanted: Leg) -> Body:
    """One of a pair's two feet, so that the pair turns from `have` into `wanted`."""
    share = wanted.foot_mass / have.foot_mass
    below = (wanted.foot_com - wanted.leg_length) - (have.foot_com - have.leg_length)
    more = 0.5 * (wanted.leg_inertia - share * have.leg_inertia)
    moved = body.centre + np.array([wanted.foot_offset - have.foot_offset, below, 0.0])
    return Body(share * body.mass, moved, _turning(share * body.inertia, share * body.inertia[2, 2] + more))


def _turning(inertia: np.ndarray, about_hip_axis: float) -> np.ndarray:
    """A tensor of inertia with another moment about the hip axis."""
    changed = inertia.copy()
    changed[2, 2] = about_hip_axis
    return changed
