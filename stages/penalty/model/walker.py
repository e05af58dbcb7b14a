"""The numbers of a penalty walker, in the type for which its equations are compiled, dimensionless in a walk; and the
derived functions of a leg's numbers.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from stages.analytic.compiled import Numbers
from stages.analytic.model.made import EQUATIONS, Made, OfSets, derived
from stages.biped.accuracy.scales import SI, Scales
from stages.biped.design import Biped
from stages.biped.machine_code import Kept, sympy_version
from stages.ground.contact_law import ContactLaw
from stages.ground.laws import PointLaw
from stages.penalty.compiled import FOLDER, compiled

#: Columns of a state: x and y of the hip, angles of leg 0 and 1, their lengths, and the rates of all six.
X, Y, ANGLE, LENGTH, RATES, SIZE = 0, 1, 2, 4, 6, 12
#: Their units.
UNITS = (*["m"] * 2, *["rad"] * 2, *["m"] * 2, *["m/s"] * 2, *["rad/s"] * 2, *["m/s"] * 2)


class LegNumbers(NamedTuple):
    """One leg, by the symbols of `stages.biped.design`, and gravity, which acts on its parts."""

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
    g_x: float
    g_y: float


class PlainLeg(LegNumbers):
    """A leg as Table 1 has it, without offset and frame: its equations are shorter."""


class Penalty(NamedTuple):
    """A walker: the hip's mass, and for gravity, both legs, the hip's spring, damper, rest angle and friction; 0 for
    rigid legs, else 1; the height of the hip under which the walker has fallen [m]; heights of the blocks under leg 0
    and 1, and how far ahead of the foot that stands each begins [m]; the contact law.

    The types of legs and law are part of this one: others are other machine code.
    """

    M: float
    M_g: float
    first: LegNumbers
    other: LegNumbers
    k_h: float
    b_h: float
    phi_h: float
    tau_h: float
    slide: float
    fallen: float
    h_0: float
    h_1: float
    x_0: float
    x_1: float
    law: PointLaw


def build_penalty(
    biped: Biped, gravity: tuple[Any, Any], contact: ContactLaw, fallen: float, scales: Scales = SI
) -> Penalty:
    """The walker of a design under gravity in the slope frame [m/s^2], in `scales`, on even ground; `fallen` in leg
    lengths.

    A number with a small imaginary part carries it on (complex step).
    """
    biped, contact, pull = scales.measure(biped), scales.measure(contact), scales.size("m/s^2")
    gravity = gravity[0] / pull, gravity[1] / pull
    return Penalty(
        M=1.0 * biped.hip_mass, M_g=1.0 * biped.weighed_hip,
        first=leg_numbers(biped, 0, gravity), other=leg_numbers(biped, 1, gravity),
        k_h=1.0 * biped.hip_stiffness, b_h=1.0 * biped.hip_damping, phi_h=1.0 * biped.hip_rest_angle,
        tau_h=1.0 * biped.hip_friction, slide=0.0 if biped.legs == "rigid" else 1.0,
        fallen=fallen * biped.leg_length, h_0=0.0, h_1=0.0, x_0=0.0, x_1=0.0, law=contact.numbers,
    )  # fmt: skip


def leg_numbers(biped: Biped, index: int, gravity: tuple[Any, Any]) -> LegNumbers:
    """One leg of a design."""
    leg, rigid, kind = biped.leg(index), biped.legs == "rigid", LegNumbers if biped.detailed else PlainLeg
    return kind(
        m=1.0 * leg.foot_mass, L_nat=1.0 * leg.leg_length, r=1.0 * leg.foot_radius, l=1.0 * leg.foot_com,
        k=0.0 if rigid else 1.0 * leg.stiffness, b=0.0 if rigid else 1.0 * leg.damping, I=1.0 * leg.leg_inertia,
        e=1.0 * leg.foot_offset, m_f=1.0 * leg.frame_mass, l_f=1.0 * leg.frame_com, e_f=1.0 * leg.frame_offset,
        I_f=1.0 * leg.frame_inertia, g_x=gravity[0], g_y=gravity[1],
    )  # fmt: skip


def natural_lengths(p: Penalty) -> tuple[float, float]:
    """Natural lengths of both legs [m]."""
    return p.first.L_nat, p.other.L_nat


@compiled
def leg_of(p: Penalty, leg: int) -> LegNumbers:
    """The numbers of a leg."""
    return p.first if leg == 0 else p.other


LEGS = Kept(f"legs-{sympy_version()}", FOLDER / "model", by=EQUATIONS.stamp)


def by_sympy(name: str) -> Callable[[], str]:
    """What makes the text of the functions of a kind of leg."""
    from stages.penalty.model.derivation import KINDS, module_source

    return partial(module_source, KINDS[name])


#: The derived functions of a leg's numbers, by the kind of leg.
SETS = {kinds: Made(f"{__name__}.{name}", partial(derived, LEGS, name, by_sympy))
        for kinds, name in ((PlainLeg, "plain"), (LegNumbers, "detailed"))}  # fmt: skip
leg_terms: Callable[..., Numbers] = OfSets("leg_terms", SETS)
leg_jacobian: Callable[..., Numbers] = OfSets("leg_jacobian", SETS)
leg_by: Callable[..., Numbers] = OfSets("leg_by", SETS)
leg_change: Callable[..., Numbers] = OfSets("leg_change", SETS)


class Directions(NamedTuple):
    """Directions of a walker's numbers that the last n variations of a state are tangents along.

    `rows` (n, numbers before the law): how these move with each of them.
    `laws` (n, numbers of the law): these numbers, with their changes as imaginary parts (`contact.STEP`); `of_law` (n,)
    whether they change at all. `delays` (columns,): by how much every variation delays the events so far.
    """

    rows: np.ndarray
    laws: np.ndarray
    of_law: np.ndarray
    delays: np.ndarray
