"""The biped's design parameters: Table 1 of the paper, what a detailed design adds to it, and the numbers of a leg."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import MISSING, asdict, dataclass, fields, replace
from typing import ClassVar

from stages.biped.quantity import Bound, Broken, broken, parameter


@dataclass(frozen=True)
class Leg:
    """The numbers of one leg under their names in `Biped`, SI units.

    Below the spring: `foot_mass` at `foot_com` above the foot's bottom and `foot_offset` forward of the leg's line,
    with `leg_inertia` about it. Above: `frame_mass` at `frame_com` below the hip and `frame_offset` forward, with
    `frame_inertia`. The foot's centre is on the leg's line.
    """

    foot_mass: float
    leg_length: float
    foot_radius: float
    foot_com: float
    stiffness: float
    damping: float
    leg_inertia: float
    foot_offset: float
    frame_mass: float
    frame_com: float
    frame_offset: float
    frame_inertia: float


def leg_rules(leg: Leg, prefix: str, given: Collection[str] = ()) -> Iterator[Broken]:
    """Rules between a leg's values; a key to blame is one of those that are `given`, if not all are."""

    def to_blame(*names: str) -> str:
        return prefix + next(name for name in names if not given or name in given)

    def at_fault(*names: str) -> bool:
        return not given or bool({*names} & {*given})

    for name in ("foot_radius", "foot_com"):
        if getattr(leg, name) >= leg.leg_length and at_fault(name, "leg_length"):
            key = to_blame(name, "leg_length")
            limit = (f"< {prefix if 'leg_length' in given else ''}leg_length = {leg.leg_length:g} m"
                     if key.endswith(name) else f"> {name} = {getattr(leg, name):g} m")
            yield Broken(key, limit)
    if leg.frame_mass == 0:
        for name in ("frame_com", "frame_offset"):
            if getattr(leg, name) != 0 and at_fault(name):
                yield Broken(prefix + name, "0 m without frame_mass")


def _alike(key: str, description: str, unit: str, symbol: str, bound: Bound | None = None) -> float | None:
    """A number of the other leg, which is that of the first leg where it is not given."""
    field: float | None = parameter(
        unit, f"{description} of the other leg, where it differs from {key}", symbol=symbol, bound=bound, default=None)
    return field


@dataclass(frozen=True)
class Biped:
    """Hip mass and two legs with an axial spring and damper, a round foot and a foot mass; and what a design adds.

    Lengths run along the leg from the hip to the bottom of the foot. The foot mass sits below the spring. A detailed
    design adds a frame to each leg, which swings with it above the spring, a hip with spring, damper and friction, a
    counterweight, and numbers of the other leg that differ from those of the first. What it does not give is not there.

    The first leg is leg 0 of a `Walk`, which stands at the start. Offsets are positive forward, for a leg that stands
    upright. A hip's torque acts on the angle between the legs, leg angle 0 minus leg angle 1.
    """

    FILE: ClassVar[str] = "biped"
    #: Said where a key is tried that no design has.
    BEYOND: ClassVar[str] = (
        "a design is two legs without knees, each with one round foot; other feet, knees, and more than two pairs of "
        "legs cannot be described")

    legs: str = parameter("-", "axial degree of freedom of the legs", choices=("compliant", "rigid"))
    hip_mass: float = parameter("kg", "mass lumped at the hip", symbol="M", bound=Bound(minimum=0))
    foot_mass: float = parameter("kg", "mass of one leg, at foot_com", symbol="m", bound=Bound(above=0))
    leg_length: float = parameter(
        "m", "natural leg length, hip to bottom of foot", symbol="L_nat", bound=Bound(above=0)
    )
    foot_radius: float = parameter("m", "radius of the round foot", symbol="r", bound=Bound(minimum=0))
    foot_com: float = parameter(
        "m", "height of the leg's mass above the foot's bottom", symbol="l", bound=Bound(minimum=0)
    )
    stiffness: float = parameter("N/m", "axial stiffness of a leg", symbol="k", bound=Bound(above=0))
    damping: float = parameter("N s/m", "axial damping of a leg", symbol="b", bound=Bound(minimum=0))
    leg_inertia: float = parameter(
        "kg m^2", "inertia of a leg about its mass centre", symbol="I", bound=Bound(minimum=0)
    )

    foot_offset: float = parameter("m", "the leg's mass forward of the leg's line", symbol="e", default=0.0)
    frame_mass: float = parameter(
        "kg", "mass above the spring that swings with a leg", symbol="m_f", bound=Bound(minimum=0), default=0.0)
    frame_com: float = parameter("m", "frame's mass centre below the hip along the leg", symbol="l_f", default=0.0)
    frame_offset: float = parameter(
        "m", "frame's mass centre forward of the leg's line", symbol="e_f", default=0.0)
    frame_inertia: float = parameter(
        "kg m^2", "inertia of a frame about its mass centre", symbol="I_f", bound=Bound(minimum=0), default=0.0)

    hip_stiffness: float = parameter(
        "N m/rad", "stiffness of the hip between the legs", symbol="k_h", bound=Bound(minimum=0), default=0.0)
    hip_damping: float = parameter(
        "N m s/rad", "viscous friction of the hip between the legs", symbol="b_h", bound=Bound(minimum=0), default=0.0)
    hip_friction: float = parameter(
        "N m", "Coulomb friction torque of the hip between the legs", symbol="tau_h", bound=Bound(minimum=0),
        default=0.0)
    hip_rest_angle: float = parameter(
        "rad", "leg angle 0 minus leg angle 1 at which the hip's spring is relaxed", symbol="phi_h",
        bound=Bound(above=-3.2, below=3.2), default=0.0)
    hip_gravity_mass: float | None = parameter(
        "kg", "the hip's mass for gravity, where a counterweight makes it differ from hip_mass", symbol="M_g",
        default=None)

    feet_retract: bool = parameter(
        "-", "whether a foot retracts while it swings, so that it touches nothing", default=False)
    strike_time: float | None = parameter(
        "s", "time of a step at which a foot that retracts is put down, wherever it is then; without it, it lands by "
        "itself", symbol="T", bound=Bound(above=0, maximum=10), default=None)

    other_foot_mass: float | None = _alike("foot_mass", "mass", "kg", "m_2", Bound(above=0))
    other_leg_length: float | None = _alike("leg_length", "natural length", "m", "L_nat_2", Bound(above=0))
    other_foot_radius: float | None = _alike("foot_radius", "foot's radius", "m", "r_2", Bound(minimum=0))
    other_foot_com: float | None = _alike("foot_com", "height of the mass", "m", "l_2", Bound(minimum=0))
    other_stiffness: float | None = _alike("stiffness", "axial stiffness", "N/m", "k_2", Bound(above=0))
    other_damping: float | None = _alike("damping", "axial damping", "N s/m", "b_2", Bound(minimum=0))
    other_leg_inertia: float | None = _alike("leg_inertia", "inertia", "kg m^2", "I_2", Bound(minimum=0))
    other_foot_offset: float | None = _alike("foot_offset", "mass off the line", "m", "e_2")
    other_frame_mass: float | None = _alike("frame_mass", "frame's mass", "kg", "m_f_2", Bound(minimum=0))
    other_frame_com: float | None = _alike("frame_com", "frame's mass centre", "m", "l_f_2")
    other_frame_offset: float | None = _alike("frame_offset", "frame's mass off the line", "m", "e_f_2")
    other_frame_inertia: float | None = _alike("frame_inertia", "frame's inertia", "kg m^2", "I_f_2", Bound(minimum=0))

    def leg(self, index: int) -> Leg:
        """The numbers of leg 0, the first, or of leg 1, the other."""
        names = [field.name for field in fields(Leg)]
        first = {name: getattr(self, name) for name in names}
        if index == 0:
            return Leg(**first)
        given = {name: getattr(self, f"other_{name}") for name in names}
        return Leg(**{name: first[name] if value is None else value for name, value in given.items()})

    def number(self, key: str) -> float:
        """A number of the design; of one that is not given, what it then is."""
        value = getattr(self, key)
        if value is None and key == "strike_time":
            return float("nan")
        if value is None:
            value = self.hip_mass if key == "hip_gravity_mass" else getattr(self, key.removeprefix("other_"))
        return float(value)

    @property
    def details(self) -> tuple[str, ...]:
        """The keys of a detailed design that are given a value other than "not there", in the file's order."""
        return tuple(
            field.name for field in fields(self)
            if field.default is not MISSING and getattr(self, field.name) != field.default)

    @property
    def detailed(self) -> bool:
        """Whether anything is there beside Table 1's numbers."""
        return bool(self.details)

    @property
    def alike(self) -> bool:
        """Whether the biped is the same when its legs are exchanged, so that a gait repeats after one step."""
        return self.leg(0) == self.leg(1) and (self.hip_stiffness == 0 or self.hip_rest_angle == 0)

    @property
    def steps_a_cycle(self) -> int:
        """Steps after which a gait repeats: two where the legs differ."""
        return 1 if self.alike else 2

    @property
    def exchanged(self) -> Biped:
        """The same machine with its legs exchanged: the other leg is called the first."""
        if self.alike:
            return self
        first, other = asdict(self.leg(0)), asdict(self.leg(1))
        others = {f"other_{name}": value for name, value in first.items()
                  if getattr(self, f"other_{name}") is not None}  # fmt: skip
        return replace(self, **other, **others, hip_rest_angle=-self.hip_rest_angle)

    @property
    def weighed_hip(self) -> float:
        """The hip's mass for gravity [kg]."""
        return self.hip_mass if self.hip_gravity_mass is None else self.hip_gravity_mass

    @property
    def weighed_mass(self) -> float:
        """Mass of the whole machine for gravity [kg]."""
        return self.total_mass if self.hip_gravity_mass is None else self.total_mass - self.hip_mass + self.weighed_hip

    @property
    def foot_radii(self) -> tuple[float, float]:
        """Radius of each leg's foot [m]."""
        return self.foot_radius, self.leg(1).foot_radius

    @property
    def leg_lengths(self) -> tuple[float, float]:
        """Natural length of each leg [m]."""
        return self.leg_length, self.leg(1).leg_length

    def plain(self, index: int = 0) -> Biped:
        """The design without its details, of two legs that have the numbers of one."""
        leg = vars(self.leg(index))
        return Biped(**{
            field.name: leg.get(field.name, getattr(self, field.name)) for field in fields(self)
            if field.name not in DETAILS})  # fmt: skip

    def broken_rules(self) -> Iterator[Broken]:
        """Rules between the values: the foot and the mass lie below the hip; compliant legs carry mass everywhere."""
        yield from leg_rules(self.leg(0), "")
        given = [field.name for field in fields(Leg) if getattr(self, f"other_{field.name}") is not None]
        if given:
            yield from leg_rules(self.leg(1), "other_", given)
        frames, timed = self.leg(0).frame_mass + self.leg(1).frame_mass, self.strike_time is not None
        yield from broken(
            (self.legs == "compliant" and self.hip_mass + frames <= 0, "hip_mass",
             "> 0 kg with compliant legs (a massless hip between two springs has no equation of motion)"),
            (self.hip_rest_angle != 0 and self.hip_stiffness == 0, "hip_rest_angle",
             "0 rad without hip_stiffness (no spring is there to rest)"),
            (timed and not self.feet_retract, "strike_time",
             "none without feet_retract: true (a foot retracts until it is put down)"),
            (timed and self.legs != "rigid", "strike_time",
             "none with compliant legs (rigid legs can be put down at any time)"),
            (timed and self.hip_friction > 0, "strike_time", "none with hip_friction (not known together)"))

    @property
    def total_mass(self) -> float:
        """Mass of the whole machine [kg]."""
        legs = 2 * self.foot_mass if self.other_foot_mass is None else self.foot_mass + self.other_foot_mass
        other = self.frame_mass if self.other_frame_mass is None else self.other_frame_mass
        return self.hip_mass + legs + (self.frame_mass + other)


#: The keys that a detailed design may add.
DETAILS = frozenset(field.name for field in fields(Biped) if field.default is not MISSING)


class BeyondModel(ValueError):
    """A design has a detail that a model does not know; the message says which, and which model knows it."""


def require_own_strikes(biped: Biped, model: str) -> None:
    """A model whose feet land by themselves goes no further with others. Raises BeyondModel."""
    if biped.strike_time is not None:
        raise BeyondModel(f"{model} does not know strike_time; only the constraint model's gaits do")
