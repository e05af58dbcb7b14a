"""The twin of a design in detail: the machine of its plain design, changed by what each detail adds.

The bill of parts is drawn for a plain design: equal legs, a hip mass, nothing at the hip's joint. What a detail adds to
that design is added to the machine: legs that differ differ by as much, a frame is joined to the bill's.
"""

from __future__ import annotations

import dataclasses
from typing import Any

from stages.biped.design import DETAILS, Biped, Leg, require_own_strikes
from stages.twin.machine.machine import Machine, build
from stages.twin.machine.projection import project, with_numbers_of
from stages.twin.parameters import Settings

PLAIN: dict[str, Any] = {field.name: field.default for field in dataclasses.fields(Biped) if field.name in DETAILS}
#: What a leg carries above its spring: mass, and where its centre is.
FRAME = ("frame_mass", "frame_com", "frame_offset", "frame_inertia")


def machine_of(biped: Biped, settings: Settings) -> Machine:
    """The machine of any design whose feet land by themselves. Raises ValueError as `build` does, BeyondModel."""
    require_own_strikes(biped, "the twin")
    plain = dataclasses.replace(biped, **PLAIN)
    machine = build(plain, settings)
    if not biped.detailed:
        return machine
    drawn = project(machine)
    first, other = (dataclasses.asdict(added(drawn.leg(index), biped.leg(index), plain.leg(index))) for index in (0, 1))
    wanted = Biped(
        legs=biped.legs, hip_mass=drawn.hip_mass, hip_damping=drawn.hip_damping + biped.hip_damping, **first,
        **{f"other_{name}": value for name, value in other.items()})  # fmt: skip
    return dataclasses.replace(
        with_numbers_of(machine, wanted), hip_stiffness=biped.hip_stiffness, hip_rest_angle=biped.hip_rest_angle,
        hip_friction=biped.hip_friction, hip_weight=biped.weighed_hip - biped.hip_mass)  # fmt: skip


def added(drawn: Leg, wanted: Leg, plain: Leg) -> Leg:
    """A leg as drawn for the plain design, with what the wanted one has more or less; frames are joined."""
    sums = {name: getattr(drawn, name) + getattr(wanted, name) - getattr(plain, name) for name in vars(drawn)}
    mass = drawn.frame_mass + wanted.frame_mass
    if not mass:
        return Leg(**sums)
    down, ahead = (
        (drawn.frame_mass * getattr(drawn, name) + wanted.frame_mass * getattr(wanted, name)) / mass
        for name in ("frame_com", "frame_offset"))  # fmt: skip
    turning = sum(
        frame.frame_inertia + frame.frame_mass * ((frame.frame_com - down) ** 2 + (frame.frame_offset - ahead) ** 2)
        for frame in (drawn, wanted))  # fmt: skip
    return Leg(**sums | dict(zip(FRAME, (mass, down, ahead, turning), strict=True)))
