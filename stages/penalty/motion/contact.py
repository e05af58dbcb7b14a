"""The force of the ground on a foot, and its derivatives, by the contact laws of `stages.ground`."""

from __future__ import annotations

from stages.ground.compiled import COMPILED, TANGENTS, compiled_coefficient
from stages.ground.laws import PointLaw
from stages.penalty.compiled import compiled

#: Imaginary step by which a law is differentiated: its square is lost beside anything but zero.
STEP = 1e-40


@compiled
def foot_force(acts: bool, depth: float, rate: float, slip: float, law: PointLaw) -> tuple[float, float]:
    """Normal force and friction [N] at a penetration [m], its rate and the slip [m/s]; none where no ground acts."""
    if not acts or depth <= 0.0:
        return 0.0, 0.0
    normal = law.normal.force(depth, rate, COMPILED)
    return normal, -compiled_coefficient(law, slip, COMPILED) * normal


@compiled
def force_slopes(
    acts: bool, depth: float, rate: float, slip: float, law: PointLaw
) -> tuple[float, float, float, float]:
    """Derivatives of the normal force by penetration and rate, of friction by the slip, and friction over normal force.

    By a complex step, so that the law's one text gives its derivatives too.
    """
    if not acts or depth <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    by_depth = law.normal.force(complex(depth, STEP), complex(rate, 0.0), TANGENTS)
    by_rate = law.normal.force(complex(depth, 0.0), complex(rate, STEP), TANGENTS)
    coefficient = compiled_coefficient(law, complex(slip, STEP), TANGENTS)
    slope = -(coefficient.imag / STEP) * by_depth.real
    return by_depth.imag / STEP, by_rate.imag / STEP, slope, -coefficient.real
