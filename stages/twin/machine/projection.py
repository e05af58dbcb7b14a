"""The twin seen from the side: the planar biped that its bill of parts makes.

Each pair of legs is two bodies: the frame above the springs and the two feet below them, which move as one. What lies
along the hip axis drops out: a plane sees masses, mass centres and moments about z. Frames swing with the legs, so the
hip itself keeps only the mass of a frame that is a point on its axis. `with_numbers_of` undoes the projection: the twin
with the numbers of a planar biped.

The twin of a design in detail: the machine of its plain design, changed by what each detail adds.

The bill of parts is drawn for a plain design: equal legs, a hip mass, nothing at the hip's joint. What a detail adds to
that design is added to the machine: legs that differ differ by as much, a frame is joined to the bill's.
"""

import dataclasses

import numpy as np

from stages.biped.design import Biped, Leg, require_own_strikes
from stages.twin.machine.machine import AS_DRAWN, FRAME_BODY, ROD, Body, Build, Machine, build, join
from stages.twin.parameters import Settings


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
    return Biped(
        legs=kind, hip_mass=hip, hip_damping=machine.bearing_friction, hip_stiffness=machine.hip_stiffness,
        hip_rest_angle=machine.hip_rest_angle, hip_friction=machine.hip_friction,
        hip_gravity_mass=hip + machine.hip_weight if machine.hip_weight else None, **first, **differing)


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


def with_numbers_of(machine: Machine, biped: Biped) -> Machine:
    """`machine` with masses, mass centres, moments, springs, lengths, radii and hip changed: it moves as `biped`.

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
        bearing_friction=biped.hip_damping, hip_stiffness=biped.hip_stiffness, hip_rest_angle=biped.hip_rest_angle,
        hip_friction=biped.hip_friction, hip_weight=biped.weighed_hip - biped.hip_mass, drawn_lengths=biped.leg_lengths)


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
    """A tensor of inertia with another moment about the hip axis: by a rod along the leg more, or all of it less."""
    more = about_hip_axis - inertia[2, 2]
    return np.asarray(inertia + more * ROD if more >= 0.0 else inertia * (about_hip_axis / inertia[2, 2]))


#: What a leg carries above its spring: mass, and where its centre is.
FRAME = ("frame_mass", "frame_com", "frame_offset", "frame_inertia")


def machine_of(biped: Biped, settings: Settings, departure: Build = AS_DRAWN) -> Machine:
    """The machine of any design whose feet land by themselves; what details add departs by nothing.

    Raises ValueError as `build` does, BeyondModel.
    """
    require_own_strikes(biped, "the twin")
    plain = biped.plain()
    machine = build(plain, settings, departure)
    if not biped.detailed:
        return machine
    drawn = project(machine)
    first, other = (dataclasses.asdict(added(drawn.leg(index), biped.leg(index), plain.leg(index))) for index in (0, 1))
    weighed = None if biped.hip_gravity_mass is None else drawn.hip_mass + biped.weighed_hip - biped.hip_mass
    wanted = dataclasses.replace(
        biped, hip_mass=drawn.hip_mass, hip_damping=drawn.hip_damping + biped.hip_damping, hip_gravity_mass=weighed,
        **first, **{f"other_{name}": value for name, value in other.items()})  # fmt: skip
    return dataclasses.replace(with_numbers_of(machine, wanted), drawn_lengths=biped.leg_lengths)


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
