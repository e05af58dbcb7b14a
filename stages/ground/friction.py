"""Forces of the ground on a foot by the chosen laws, the elementary functions they are written in, and where ground is.

A law is a formula over a few operations, so that its one text serves floats, numpy arrays, the symbols of a multibody
program (`stages.multibody.assembly.contact`) and machine code (`stages.ground.compiled`): each kind of number has its
own table. Symbols are evaluated without sharing common terms: a formula should therefore mention a costly term once.

Friction is F_T = mu(v) F_N against the slip. It is regularised alike for every law: up to the stiction velocity the
foot creeps, with a cubic from no friction at rest to the law's coefficient. So it is odd, continuous and finite at rest
whatever the law. With stepping blocks each leg has its own lane of them; its foot swings through the gaps in it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from stages.ground.contact_law import ContactLaw
from stages.ground.laws import PointLaw

#: Slip speed [m/s] added in quadrature where a slip direction is needed, so that no slip has a direction too.
SMALLEST_SLIP = 1e-12


class Operations(NamedTuple):
    """Elementary functions on one kind of number."""

    sign: Callable[[Any], Any]
    absolute: Callable[[Any], Any]
    round: Callable[[Any], Any]
    power: Callable[[Any, float], Any]
    minimum: Callable[[Any, float], Any]
    maximum: Callable[[Any, float], Any]
    #: STEP(x, 0, 0, width, height) of Adams: height s^2 (3 - 2 s) with s = x / width, 0 below and height above.
    step: Callable[[Any, float, Any], Any]
    #: (x, width, height): STEP(x, -width, -height, width, height), odd, and flat at both ends.
    rise: Callable[[Any, float, Any], Any]
    #: (x, width, height): rise / x, for x >= 0.
    creep: Callable[[Any, float, Any], Any]
    #: Length of a vector with two components, no less than is needed to divide by it.
    length: Callable[[Any, Any], Any]


def with_single_terms(
    sin: Callable[[Any], Any], asin: Callable[[Any], Any], sqrt: Callable[[Any], Any], **others: Any
) -> Operations:
    """Operations whose steps mention their argument once: the cubic (3 u - u^3) / 2 is sin(3 asin(u / 2))."""
    minimum, maximum = others["minimum"], others["maximum"]

    def cubic(u: Any) -> Any:
        return sin(3.0 * asin(0.5 * maximum(minimum(u, 1.0), -1.0)))

    def rise(x: Any, width: float, height: Any) -> Any:
        return height * cubic(x * (1.0 / width))

    return Operations(
        step=lambda x, width, height: height * (0.5 + 0.5 * cubic(2.0 * (x * (1.0 / width)) - 1.0)),
        rise=rise,
        creep=lambda x, width, height: rise(x, width, height) / x,
        length=lambda x, z: sqrt(x * x + z * z + SMALLEST_SLIP**2),
        **others,
    )


def _sign(x: float) -> float:
    return float((x > 0) - (x < 0))


SCALARS = with_single_terms(
    math.sin, math.asin, math.sqrt, sign=_sign, absolute=abs, round=round, power=math.pow, minimum=min, maximum=max
)
ARRAYS = with_single_terms(
    np.sin, np.arcsin, np.sqrt, sign=np.sign, absolute=np.abs, round=np.round, power=np.power, minimum=np.minimum,
    maximum=np.maximum,
)  # fmt: skip


def normal_force(law: ContactLaw, penetration: Any, rate: Any, ops: Operations = ARRAYS) -> Any:
    """Normal force [N], never negative, zero out of contact; penetration [m] positive in contact, its rate [m/s]."""
    return law.numbers.normal.force(penetration, rate, ops)


def static_penetration(law: ContactLaw, force: float) -> float:
    """Penetration [m] at which the ground carries `force` [N] at rest: (F_N / k_c)^(1/e), the same for every law."""
    return float((force / law.stiffness_si) ** (1.0 / law.contact_exponent))


def friction_coefficient(law: ContactLaw, slip: Any, ops: Operations = ARRAYS) -> Any:
    """Signed friction coefficient, odd in the slip velocity [m/s]; the force on the foot is -mu(slip) F_N."""
    return signed_coefficient(law.numbers, slip, ops)


def signed_coefficient(law: PointLaw, slip: Any, ops: Operations) -> Any:
    """`friction_coefficient` of a law in numbers."""
    return ops.rise(slip, law.stiction_velocity, law.friction.coefficient(ops.absolute(slip), ops))


def friction_slope(law: PointLaw, slip_x: Any, slip_z: Any, ops: Operations) -> Any:
    """mu(|v|) / |v| [s/m] of a slip with two components [m/s]: the force on the foot is -slope F_N (slip_x, slip_z)."""
    speed = ops.length(slip_x, slip_z)
    return ops.creep(speed, law.stiction_velocity, law.friction.coefficient(speed, ops))


@dataclass(frozen=True)
class Lane:
    """Equal blocks in a row under one leg: ground exists from centre - length/2 to centre + length/2 of each [m]."""

    first: float
    spacing: float
    length: float

    def presence(self, x: Any, ops: Operations = ARRAYS) -> Any:
        """1 over a block and 0 between blocks, at a position x [m] along the slope."""
        offset = x - self.first
        nearest = self.spacing * ops.round(offset * (1.0 / self.spacing))
        return 0.5 + 0.5 * ops.sign(0.5 * self.length - ops.absolute(offset - nearest))


def lanes(step_length: float, block_length: float) -> tuple[Lane, Lane]:
    """Lanes of leg 0, which stands at x = 0, and of leg 1, one step ahead; blocks two steps apart."""
    return Lane(0.0, 2.0 * step_length, block_length), Lane(step_length, 2.0 * step_length, block_length)
