"""The generated derivatives by the walker's numbers by its kind: plain ones of Table 1, or detailed ones.

NAME_by(..., p) are the derivatives of a term; NAME_change(by, d) is its change for a change `d` of the numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from stages.analytic.compiled import ByKind, Numbers, compiled
from stages.analytic.derivatives.equations import detailed, plain
from stages.analytic.model.kinds import (
    Detailed,
    DetailedLimited,
    DetailedRigid,
    DetailedRolling,
    Plain,
    PlainLimited,
    PlainRigid,
    PlainRolling,
    RubbingRigid,
    RubbingRolling,
)


def by_numbers(name: str) -> Callable[..., Numbers]:
    """NAME_by of the kind of `p`."""
    return ByKind({Plain: getattr(plain, f"{name}_by"), Detailed: getattr(detailed, f"{name}_by")})


def change_for(name: str) -> Callable[..., Numbers]:
    """NAME_change of the kind of `d`."""
    choices = {Plain: getattr(plain, f"{name}_change"), Detailed: getattr(detailed, f"{name}_change")}
    return ByKind(choices, by="d")


compliant_residual_by, compliant_residual_change = by_numbers("compliant_residual"), change_for("compliant_residual")
compliant_impulse_by, compliant_impulse_change = by_numbers("compliant_impulse"), change_for("compliant_impulse")
compliant_handover_by, compliant_handover_change = by_numbers("compliant_handover"), change_for("compliant_handover")
compliant_clearance_by = by_numbers("compliant_clearance")
compliant_clearance_change = change_for("compliant_clearance")
contact_acceleration_by = by_numbers("contact_acceleration")
contact_acceleration_change = change_for("contact_acceleration")
rigid_residual_by, rigid_residual_change = by_numbers("rigid_residual"), change_for("rigid_residual")
rigid_impulse_by, rigid_impulse_change = by_numbers("rigid_impulse"), change_for("rigid_impulse")
rigid_handover_by, rigid_handover_change = by_numbers("rigid_handover"), change_for("rigid_handover")
rigid_clearance_by, rigid_clearance_change = by_numbers("rigid_clearance"), change_for("rigid_clearance")


@compiled
def rigid_row(p: PlainRigid, a: np.ndarray, row: int) -> PlainRigid:
    """`row_as` of rigid legs."""
    return PlainRigid(a[row, 0], a[row, 1], a[row, 2], a[row, 3], a[row, 4], a[row, 5], a[row, 6], a[row, 7])


@compiled
def rolling_row(p: PlainRolling, a: np.ndarray, row: int) -> PlainRolling:
    """`row_as` of rolling feet."""
    return PlainRolling(
        a[row, 0], a[row, 1], a[row, 2], a[row, 3], a[row, 4], a[row, 5], a[row, 6], a[row, 7], a[row, 8], a[row, 9])


@compiled
def limited_row(p: PlainLimited, a: np.ndarray, row: int) -> PlainLimited:
    """`row_as` with limited friction."""
    return PlainLimited(
        a[row, 0], a[row, 1], a[row, 2], a[row, 3], a[row, 4], a[row, 5], a[row, 6], a[row, 7], a[row, 8], a[row, 9],
        a[row, 10], a[row, 11])


#: A row of changes `a` (n, fields) as a walker of the kind of `p`, in which they have names: row_as(p, a, row).
row_as: Callable[..., Any] = ByKind({
    PlainRigid: rigid_row, PlainRolling: rolling_row, PlainLimited: limited_row,
    DetailedRigid: detailed.rigid_row, RubbingRigid: detailed.rubbing_row, DetailedRolling: detailed.rolling_row,
    DetailedLimited: detailed.limited_row, RubbingRolling: detailed.rubbing_rolling_row})
