"""Friction of the ground on a foot, by the chosen law: F_T = mu(v) F_N against the slip."""

from __future__ import annotations

from typing import Any

from stages.ground.contact_law import ContactLaw
from stages.ground.coulomb import coulomb_coefficient
from stages.ground.operations import ARRAYS, Operations
from stages.ground.stribeck import stribeck_coefficient


def frictionless(law: ContactLaw, slip: Any, ops: Operations = ARRAYS) -> Any:
    """No friction at any slip velocity."""
    return 0.0 * slip


FRICTIONS = {"stribeck": stribeck_coefficient, "coulomb": coulomb_coefficient, "none": frictionless}

#: Slip speed [m/s] added in quadrature where a slip direction is needed, so that no slip has a direction too.
SMALLEST_SLIP = 1e-12


def friction_coefficient(law: ContactLaw, slip: Any, ops: Operations = ARRAYS) -> Any:
    """Signed friction coefficient, odd in the slip velocity [m/s]; the force on the foot is -mu(slip) F_N."""
    return FRICTIONS[law.friction](law, slip, ops)


def friction_slope(law: ContactLaw, slip_x: Any, slip_z: Any, ops: Operations = ARRAYS) -> Any:
    """mu(|v|) / |v| [s/m] of a slip with two components [m/s]: the force on the foot is -slope F_N (slip_x, slip_z)."""
    speed = ops.sqrt(slip_x * slip_x + slip_z * slip_z + SMALLEST_SLIP**2)
    return friction_coefficient(law, speed, ops) / speed
