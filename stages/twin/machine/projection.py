"""The twin seen from the side: the planar biped that its bill of parts makes.

Each pair of legs is two bodies: the frame above the springs and the two feet below them, which move as one. What lies
along the hip axis drops out: a plane sees masses, mass centres and moments about z. Frames swing with the legs, so the
hip itself keeps only the mass of a frame that is a point on its axis.
"""

from __future__ import annotations

import dataclasses

from stages.biped.design import Biped, Leg
from stages.twin.machine.bill import join
from stages.twin.machine.machine import FRAME_BODY, Machine


def project(machine: Machine) -> Biped:
    """The planar biped that moves as `machine` does while that neither rolls nor yaws; its first leg is the inner pair.

    Exact where the left and the right leg of each pair are alike. Otherwise the pair is what it is on average: sums of
    mass, stiffness and damping, means of lengths and radii.
    """
    hip, legs = 0.0, []
    for pair in (0, 1):
        leg = _leg(machine, pair)
        if leg.frame_com == leg.frame_offset == leg.frame_inertia == 0.0:
            hip += leg.frame_mass
            leg = dataclasses.replace(leg, frame_mass=0.0)
        legs.append(dataclasses.asdict(leg))
    first, other = legs
    differing = {f"other_{name}": value for name, value in other.items() if value != first[name]}
    kind = "rigid" if machine.rigid else "compliant"
    return Biped(legs=kind, hip_mass=hip, hip_damping=machine.bearing_friction, **first, **differing)


def _leg(machine: Machine, pair: int) -> Leg:
    """A pair of legs as one leg. A foot's place in the bill is that on unloaded springs."""
    legs, first = slice(2 * pair, 2 * pair + 2), FRAME_BODY[pair]
    frame, feet = machine.bodies[first], join(machine.bodies[first + 1 : first + 3])
    length = float(machine.length[legs].mean())
    return Leg(
        foot_mass=feet.mass,
        leg_length=length,
        foot_radius=float(machine.radius[legs].mean()),
        foot_com=length + float(feet.centre[1]),
        stiffness=float(machine.stiffness[legs].sum()),
        damping=float(machine.damping[legs].sum()),
        leg_inertia=float(feet.inertia[2, 2]),
        foot_offset=float(feet.centre[0]),
        frame_mass=frame.mass,
        frame_com=0.0 - float(frame.centre[1]),
        frame_offset=float(frame.centre[0]),
        frame_inertia=float(frame.inertia[2, 2]),
    )
