"""The numbers of a penalty walker, in the type for which its equations are compiled: dimensionless in a walk."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from stages.biped.accuracy.scales import SI, Scales
from stages.biped.design import Biped
from stages.ground.contact_law import ContactLaw
from stages.ground.laws import PointLaw

#: Columns of a state: x and y of the hip, angles of leg 0 and 1, their lengths, and the rates of all six.
X, Y, ANGLE, LENGTH, RATES, SIZE = 0, 1, 2, 4, 6, 12
#: Their units.
UNITS = (*["m"] * 2, *["rad"] * 2, *["m"] * 2, *["m/s"] * 2, *["rad/s"] * 2, *["m/s"] * 2)


class Penalty(NamedTuple):
    """Table 1's walker: the paper's symbols; one over the mass that moves along a leg, 0 for rigid legs; the height of
    the hip under which the walker has fallen [m]; heights of the blocks under leg 0 and 1, and how far ahead of the
    foot that stands a block begins [m]; the contact law.

    The law's own type is part of this one: another law is other machine code.
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
    slide: float
    fallen: float
    h_0: float
    h_1: float
    x_ahead: float
    law: PointLaw


class LegNumbers(NamedTuple):
    """One leg of a detailed walker, by the symbols of `stages.biped.design`, and gravity, which its parts feel."""

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


class DetailedPenalty(NamedTuple):
    """A detailed walker: the hip's mass, and for gravity, both legs, the hip's spring, damper, rest angle and friction.

    `slide` is 0 for rigid legs, else 1.
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
    x_ahead: float
    law: PointLaw


Walker = Penalty | DetailedPenalty


def build_penalty(
    biped: Biped, gravity: tuple[Any, Any], contact: ContactLaw, fallen: float, scales: Scales = SI
) -> Walker:
    """The walker of a design under gravity in the slope frame [m/s^2], in `scales`, on even ground; `fallen` in leg
    lengths.

    A number with a small imaginary part carries it on (complex step).
    """
    biped, contact, pull = scales.measure(biped), scales.measure(contact), scales.size("m/s^2")
    gravity = gravity[0] / pull, gravity[1] / pull
    rigid, height = biped.legs == "rigid", fallen * biped.leg_length
    if biped.detailed:
        return DetailedPenalty(
            M=1.0 * biped.hip_mass, M_g=1.0 * biped.weighed_hip,
            first=leg_numbers(biped, 0, gravity), other=leg_numbers(biped, 1, gravity),
            k_h=1.0 * biped.hip_stiffness, b_h=1.0 * biped.hip_damping, phi_h=1.0 * biped.hip_rest_angle,
            tau_h=1.0 * biped.hip_friction, slide=0.0 if rigid else 1.0, fallen=height, h_0=0.0, h_1=0.0, x_ahead=0.0,
            law=contact.numbers,
        )  # fmt: skip
    return Penalty(
        M=1.0 * biped.hip_mass,
        m=1.0 * biped.foot_mass,
        L_nat=1.0 * biped.leg_length,
        r=1.0 * biped.foot_radius,
        l=1.0 * biped.foot_com,
        k=0.0 if rigid else 1.0 * biped.stiffness,
        b=0.0 if rigid else 1.0 * biped.damping,
        I=1.0 * biped.leg_inertia,
        g_x=gravity[0],
        g_y=gravity[1],
        slide=0.0 if rigid else 1.0 / biped.foot_mass,
        fallen=height,
        h_0=0.0,
        h_1=0.0,
        x_ahead=0.0,
        law=contact.numbers,
    )


def leg_numbers(biped: Biped, index: int, gravity: tuple[Any, Any]) -> LegNumbers:
    """One leg of a detailed design."""
    leg, rigid = biped.leg(index), biped.legs == "rigid"
    return LegNumbers(
        m=1.0 * leg.foot_mass, L_nat=1.0 * leg.leg_length, r=1.0 * leg.foot_radius, l=1.0 * leg.foot_com,
        k=0.0 if rigid else 1.0 * leg.stiffness, b=0.0 if rigid else 1.0 * leg.damping, I=1.0 * leg.leg_inertia,
        e=1.0 * leg.foot_offset, m_f=1.0 * leg.frame_mass, l_f=1.0 * leg.frame_com, e_f=1.0 * leg.frame_offset,
        I_f=1.0 * leg.frame_inertia, g_x=gravity[0], g_y=gravity[1],
    )  # fmt: skip


def natural_lengths(p: Walker) -> tuple[float, float]:
    """Natural lengths of both legs [m]."""
    return (p.L_nat, p.L_nat) if isinstance(p, Penalty) else (p.first.L_nat, p.other.L_nat)


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
