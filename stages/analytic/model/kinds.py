"""The numbers of a walker, in a type that says how long its state is and which terms its equations have.

Compiled code takes them as `p`, requests them by the paper's symbols, `p.r`, and is compiled for the type. All are
dimensionless: total mass, leg length and pendulum time are one. What a walker does not have is a number that leaves it
out: no friction at the hip, no limit to that at the feet, no time at which a step ends. On even ground h_ahead and
h_behind are zero: heights, above the ground under the stance foot, of that where the swing foot lands, and of that
which it leaves. A foot lands from x_ahead of the stance foot on, where its block begins.

The numbers of a detailed design have types of their own. Those of the stance leg have the names of Table 1's walker,
those of the swing leg end in _2; `derivation.Leg` says what they are. The legs change roles from step to step, and so
do their numbers (`terms.exchanged`).
"""

from functools import cache
from math import inf
from typing import NamedTuple

import numpy as np

#: Legs that pass each other bring the feet together up to round-off; farther ahead [leg lengths] a foot lands.
PASSING = 1e-9
#: Numbers of the ground.
GROUND = ("h_ahead", "h_behind", "x_ahead")


class PlainRigid(NamedTuple):
    """Table 1's walker with legs of fixed length: the trailing foot leaves the ground at heel strike.

    Hips with friction resist with the torque tau_h; feet that retract are put down at the time T of a step.
    """

    M: float
    m: float
    L_nat: float
    r: float
    l: float  # noqa: E741
    I: float  # noqa: E741
    g_x: float
    g_y: float
    T: float = inf
    tau_h: float = 0.0
    h_ahead: float = 0.0
    h_behind: float = 0.0
    x_ahead: float = PASSING


class PlainCompliant(NamedTuple):
    """Table 1's walker: compliant legs.

    The trailing foot has friction mu_s at rest and mu_d in motion, so that it may slip and rise; without limits it
    rolls, whatever friction that takes.
    """

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
    mu_s: float = inf
    mu_d: float = inf
    tau_h: float = 0.0
    h_ahead: float = 0.0
    h_behind: float = 0.0
    x_ahead: float = PASSING


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
    T: float = inf
    tau_h: float = 0.0
    h_ahead: float = 0.0
    h_behind: float = 0.0
    x_ahead: float = PASSING


class DetailedCompliant(NamedTuple):
    """`PlainCompliant` with frames, hip and legs of their own."""

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
    mu_s: float = inf
    mu_d: float = inf
    tau_h: float = 0.0
    h_ahead: float = 0.0
    h_behind: float = 0.0
    x_ahead: float = PASSING


class StiffPlain(PlainCompliant):
    """`PlainCompliant` with legs that are stiff to an explicit integrator."""

    __slots__ = ()


class StiffDetailed(DetailedCompliant):
    """`DetailedCompliant` with legs that are stiff to an explicit integrator."""

    __slots__ = ()


#: Places of friction's numbers at the foot, and at the hip, of the time of a step, and of the ground's heights, in
#: every type that has them.
MU_S, TAU_H, T_END, H_AHEAD, H_BEHIND = -6, -4, -5, -3, -2

Plain = PlainRigid | PlainCompliant
Detailed = DetailedRigid | DetailedCompliant
Rigid = PlainRigid | DetailedRigid
Compliant = PlainCompliant | DetailedCompliant
Stiff = StiffPlain | StiffDetailed
Kind = Rigid | Compliant


class Directions(NamedTuple):
    """Directions of a walker's numbers that the last variations of a state are tangents along.

    `rows` (n, fields of `p`): how its numbers move with each of the last n variations. `delays` (columns,): by how much
    every variation delays the events so far, which integration adds up.
    """

    rows: np.ndarray
    delays: np.ndarray


def directions(rows: np.ndarray, columns: int) -> Directions:
    """The directions `rows` (n, fields) of the last n of the `columns` variations that are carried."""
    return Directions(np.ascontiguousarray(rows, dtype=float), np.zeros(columns))


def present(p: Kind) -> list[str]:
    """Names of the numbers that a walker has: friction at hip and feet, and the time of its steps, if it has them."""
    absent = {*GROUND, *(name for name in ("mu_s", "mu_d", "T") if getattr(p, name, inf) == inf)}
    return [name for name in p._fields if name not in absent and (name != "tau_h" or p.tau_h > 0.0)]


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
