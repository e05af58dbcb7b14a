"""The numbers of a penalty walker, in the type for which its equations are compiled; SI units."""

from __future__ import annotations

from typing import NamedTuple

from stages.biped.design import Biped, require_plain
from stages.ground.contact_law import ContactLaw
from stages.ground.laws import PointLaw
from stages.ground.slope import Slope

#: Columns of a state: x and y of the hip, angles of leg 0 and 1, their lengths, and the rates of all six.
X, Y, ANGLE, LENGTH, RATES, SIZE = 0, 1, 2, 4, 6, 12


class Penalty(NamedTuple):
    """The paper's symbols; one over the mass that moves along a leg, 0 for rigid legs; the height of the
    hip under which the walker has fallen [m]; the contact law.

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
    law: PointLaw


def build_penalty(biped: Biped, slope: Slope, contact: ContactLaw, fallen: float) -> Penalty:
    """The walker of a design on its ground; `fallen` in leg lengths. Raises BeyondModel.

    A number of the design with a small imaginary part carries it on (complex step).
    """
    require_plain(biped, "the compiled penalty model")
    rigid, gravity = biped.legs == "rigid", slope.gravity_vector
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
        fallen=fallen * biped.leg_length,
        law=contact.numbers,
    )
