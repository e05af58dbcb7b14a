"""The derivatives of the equations by the walker's numbers by its kind: plain ones of Table 1, or detailed ones.

NAME_by(..., p) are the derivatives of a term; NAME_change(by, d) is its change for a change `d` of the numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stages.analytic.compiled import ByKind, Numbers
from stages.analytic.model.made import OfSets, sets
from stages.analytic.model.written_out import ROWS, of_each

TERMS = sets(__name__, "derivatives")


def pair(name: str) -> tuple[Callable[..., Numbers], Callable[..., Numbers]]:
    """NAME_by of the kind of `p`, NAME_change of the kind of `d`."""
    return OfSets(f"{name}_by", TERMS), OfSets(f"{name}_change", TERMS)


compliant_residual_by, compliant_residual_change = pair("compliant_residual")
compliant_impulse_by, compliant_impulse_change = pair("compliant_impulse")
compliant_handover_by, compliant_handover_change = pair("compliant_handover")
compliant_clearance_by, compliant_clearance_change = pair("compliant_clearance")
contact_acceleration_by, contact_acceleration_change = pair("contact_acceleration")
rigid_residual_by, rigid_residual_change = pair("rigid_residual")
rigid_impulse_by, rigid_impulse_change = pair("rigid_impulse")
rigid_handover_by, rigid_handover_change = pair("rigid_handover")
rigid_clearance_by, rigid_clearance_change = pair("rigid_clearance")
#: A row of changes `a` (n, fields) as a walker of the kind of `p`, in which they have names: row_as(p, a, row).
row_as: Callable[..., Any] = ByKind(of_each("row", ROWS))
