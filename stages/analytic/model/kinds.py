"""The numbers of a walker, in a type that says what kind of walker it is.

Compiled code takes them as `p`, asks for them by the paper's symbols, `p.r`, and is compiled for the type: what a kind
does not need is not compiled for it. A plain one is Table 1's biped, and has no more than that. All are dimensionless:
total mass, leg length and pendulum time are one.

The numbers of a detailed design have types of their own. Those of the stance leg have the names of Table 1's walker,
those of the swing leg end in _2; `derivation.Leg` says what they are. The legs change roles from step to step, and so
do their numbers (`terms.exchanged`).
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, NamedTuple


class PlainRigid(NamedTuple):
    """Legs of fixed length: the trailing foot leaves the ground at heel strike, no double stance."""

    M: float
    m: float
    L_nat: float
    r: float
    l: float  # noqa: E741
    I: float  # noqa: E741
    g_x: float
    g_y: float


class PlainRolling(NamedTuple):
    """Compliant legs; a foot on the ground rolls, whatever friction that takes."""

    M: float
    m: float
    L_nat: float
    r: float
    l: float  # noqa: E741
    k: float
    b: float
    I: float  # noqa: E741
    g_x: float
    g_y: float


class PlainLimited(NamedTuple):
    """Compliant legs; the trailing foot has friction mu_s at rest and mu_d in motion, so that it may slip and rise."""

    M: float
    m: float
    L_nat: float
    r: float
    l: float  # noqa: E741
    k: float
    b: float
    I: float  # noqa: E741
    g_x: float
    g_y: float
    mu_s: float
    mu_d: float


class StiffRolling(PlainRolling):
    """A rolling walker whose legs are stiff to an explicit integrator."""

    __slots__ = ()


class StiffLimited(PlainLimited):
    """A walker with limited friction whose legs are stiff to an explicit integrator."""

    __slots__ = ()


class DetailedRigid(NamedTuple):
    """`PlainRigid` with frames, hip and legs of their own."""

    M: float
    M_g: float
    m: float
    L_nat: float
    r: float
    l: float  # noqa: E741
    I: float  # noqa: E741
    e: float
    m_f: float
    l_f: float
    e_f: float
    I_f: float
    m_2: float
    L_nat_2: float
    r_2: float
    l_2: float
    I_2: float
    e_2: float
    m_f_2: float
    l_f_2: float
    e_f_2: float
    I_f_2: float
    k_h: float
    b_h: float
    phi_h: float
    g_x: float
    g_y: float


class DetailedRolling(NamedTuple):
    """`PlainRolling` with frames, hip and legs of their own."""

    M: float
    M_g: float
    m: float
    L_nat: float
    r: float
    l: float  # noqa: E741
    k: float
    b: float
    I: float  # noqa: E741
    e: float
    m_f: float
    l_f: float
    e_f: float
    I_f: float
    m_2: float
    L_nat_2: float
    r_2: float
    l_2: float
    k_2: float
    b_2: float
    I_2: float
    e_2: float
    m_f_2: float
    l_f_2: float
    e_f_2: float
    I_f_2: float
    k_h: float
    b_h: float
    phi_h: float
    g_x: float
    g_y: float


#: Numbers that kinds have beside those of another: friction's torque at the hip, coefficients of friction at the foot,
#: the time of the step.
TORQUE, COEFFICIENTS, TIME = ("tau_h",), ("mu_s", "mu_d"), ("T",)

if TYPE_CHECKING:
    from typing_extensions import Self

    class Extended:
        """Takes the numbers of another kind and more."""

        def __new__(cls, *numbers: float) -> Self: ...

    class RubbingRigid(Extended, DetailedRigid):
        """`DetailedRigid` with Coulomb friction of torque tau_h at the hip."""

        tau_h: float

    class TimedRigid(Extended, DetailedRigid):
        """`DetailedRigid` with feet that retract and are put down at the time T of a step, wherever they are then."""

        T: float

    class RubbingRolling(Extended, DetailedRolling):
        """`DetailedRolling` with Coulomb friction of torque tau_h at the hip."""

        tau_h: float

    class DetailedLimited(Extended, DetailedRolling):
        """`PlainLimited` with frames, hip and legs of their own."""

        mu_s: float
        mu_d: float

else:  # a subclass of a NamedTuple adds no fields

    def extended(name: str, kind: type, more: tuple[str, ...]) -> type:
        """A kind with the numbers of another one and more."""
        return NamedTuple(name, [(each, float) for each in (*kind._fields, *more)])

    RubbingRigid = extended("RubbingRigid", DetailedRigid, TORQUE)
    TimedRigid = extended("TimedRigid", DetailedRigid, TIME)
    RubbingRolling = extended("RubbingRolling", DetailedRolling, TORQUE)
    DetailedLimited = extended("DetailedLimited", DetailedRolling, COEFFICIENTS)


class StiffDetailedRolling(DetailedRolling):
    """A rolling walker whose legs are stiff to an explicit integrator."""

    __slots__ = ()


class StiffDetailedLimited(DetailedLimited):
    """A walker with limited friction whose legs are stiff to an explicit integrator."""

    __slots__ = ()


DetailedCompliant = DetailedRolling | RubbingRolling | DetailedLimited
Detailed = DetailedRigid | RubbingRigid | TimedRigid | DetailedCompliant
PlainCompliant = PlainRolling | PlainLimited
Plain = PlainRigid | PlainCompliant
#: Kinds by what their feet and legs do, whether plain or detailed.
Rigid = PlainRigid | DetailedRigid | RubbingRigid | TimedRigid
Rolling = PlainRolling | DetailedRolling | RubbingRolling
Limited = PlainLimited | DetailedLimited
Compliant = Rolling | Limited
Stiff = StiffRolling | StiffLimited | StiffDetailedRolling | StiffDetailedLimited
#: Kinds with Coulomb friction at the hip, and without it.
Rubbing = RubbingRigid | RubbingRolling
SmoothRigid = PlainRigid | DetailedRigid
SmoothRolling = PlainRolling | DetailedRolling
Smooth = SmoothRigid | SmoothRolling | Limited
Kind = Smooth | Rubbing | TimedRigid


def with_legs_exchanged(p: Kind) -> Kind:
    """The walker in its next step: the legs change roles, and their numbers with them."""
    if isinstance(p, Plain):
        return p
    order, hinge = exchange(p._fields)
    values = [p[place] for place in order]
    values[hinge] = -values[hinge]
    exchanged: Kind = type(p)(*values)
    return exchanged


@cache
def exchange(names: tuple[str, ...]) -> tuple[list[int], int]:
    """Of each number of a detailed kind, by `names`, its place among those of the step before, and the place of
    `phi_h`, which changes its sign."""
    partners = [f"{name}_2" if f"{name}_2" in names else name.removesuffix("_2") for name in names]
    return [names.index(partner) for partner in partners], names.index("phi_h")


def radii(p: Kind) -> tuple[float, float]:
    """Radii of stance and swing foot."""
    return (p.r, p.r_2) if isinstance(p, Detailed) else (p.r, p.r)


def natural_lengths(p: Kind) -> tuple[float, float]:
    """Natural lengths of stance and swing leg."""
    return (p.L_nat, p.L_nat_2) if isinstance(p, Detailed) else (p.L_nat, p.L_nat)


def heights_of_mass(p: Kind) -> tuple[float, float]:
    """Heights of the masses of stance and swing leg above the bottoms of their feet."""
    return (p.l, p.l_2) if isinstance(p, Detailed) else (p.l, p.l)
