"""The force of the ground on a foot, and its derivatives, by the contact laws of `stages.ground`."""

from __future__ import annotations

import numpy as np

from stages.ground.compiled import COMPILED, TANGENTS, compiled_coefficient
from stages.ground.laws import PointLaw
from stages.penalty.compiled import compiled

#: Imaginary step by which a law is differentiated: its square is lost beside anything but zero.
STEP = 1e-40
#: What `force_slopes` gives.
Slopes = tuple[float, float, float, float]


@compiled
def foot_force(acts: bool, depth: float, rate: float, slip: float, law: PointLaw) -> tuple[float, float]:
    """Normal force and friction [N] at a penetration [m], its rate and the slip [m/s]; none where no ground acts."""
    if not acts or depth <= 0.0:
        return 0.0, 0.0
    normal = law.normal.force(depth, rate, COMPILED)
    return normal, -compiled_coefficient(law, slip, COMPILED) * normal


@compiled
def force_slopes(acts: bool, depth: float, rate: float, slip: float, law: PointLaw) -> Slopes:
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


@compiled
def law_change(
    acts: bool, depth: float, rate: float, slip: float, law: PointLaw, numbers: np.ndarray
) -> tuple[float, float]:
    """Change of the normal force, and of friction beside that, at an unchanged state.

    `numbers`: those of the law, with their changes times `STEP` as imaginary parts.
    """
    if not acts or depth <= 0.0:
        return 0.0, 0.0
    normal, friction = law.normal.like(numbers, 0), law.friction.like(numbers, len(law.normal))
    force = normal.force(complex(depth, 0.0), complex(rate, 0.0), TANGENTS)
    varied = PointLaw(normal, friction, numbers[len(law.normal) + len(law.friction)])
    coefficient = compiled_coefficient(varied, complex(slip, 0.0), TANGENTS)
    return force.imag / STEP, -(coefficient.imag / STEP) * force.real
