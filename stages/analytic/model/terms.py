"""The derived terms of the equations of motion by the kind of walker: plain ones of Table 1, or detailed ones.

And their derivatives by the walker's numbers: NAME_by(..., p) are those of a term, and NAME_change(by, d) is its change
for a change `d` of the numbers.
"""

from collections.abc import Callable
from typing import Any

from stages.analytic.compiled import ByKind, Numbers, compiled
from stages.analytic.model.elimination import coupled_factor, factor
from stages.analytic.model.kinds import Detailed, Plain, PlainCompliant
from stages.analytic.model.made import EXCHANGED, ROWS, OfSets, of_each, sets

TERMS, DERIVATIVES = sets("terms"), sets("derivatives")


def term(name: str) -> Callable[..., Numbers]:
    """The derived function `name` of the kind of `p`."""
    return OfSets(name, TERMS)


def pair(name: str) -> tuple[Callable[..., Numbers], Callable[..., Numbers]]:
    """NAME_by of the kind of `p`, NAME_change of the kind of `d`."""
    return OfSets(f"{name}_by", DERIVATIVES), OfSets(f"{name}_change", DERIVATIVES)


compliant_terms, rigid_terms = term("compliant_terms"), term("rigid_terms")
compliant_residual_jacobian = term("compliant_residual_jacobian")
rigid_residual_jacobian = term("rigid_residual_jacobian")
compliant_reaction, rigid_reaction = term("compliant_reaction"), term("rigid_reaction")
compliant_energy, rigid_energy = term("compliant_energy"), term("rigid_energy")
contact_terms, contact_force_jacobian = term("contact_terms"), term("contact_force_jacobian")
contact_acceleration_jacobian = term("contact_acceleration_jacobian")
compliant_handover, rigid_handover = term("compliant_handover"), term("rigid_handover")
compliant_handover_jacobian = term("compliant_handover_jacobian")
rigid_handover_jacobian = term("rigid_handover_jacobian")
#: d(M qdd)/d(q, qd) at given qdd, by rows, of (4, 8) and (2, 4).
compliant_inertia_jacobian = term("compliant_inertia_jacobian")
rigid_inertia_jacobian = term("rigid_inertia_jacobian")

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


@compiled
def plain_factors(t: Numbers, p: PlainCompliant) -> Numbers:
    """`mass_factors` of plain legs: psi and L_2 are polar coordinates of one mass, m34 = 0."""
    return factor(t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7], t[9])


@compiled
def detailed_factors(t: Numbers, p: Detailed) -> Any:
    """`mass_factors` of detailed legs."""
    return coupled_factor(t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7], t[8], t[9])


#: Factors of the mass matrix, whose upper triangle `compliant_terms` gives first, for `elimination.solve`:
#: mass_factors(t, p).
mass_factors: Callable[..., Any] = ByKind({Plain: plain_factors, Detailed: detailed_factors})


@compiled
def the_same(p: Plain) -> Plain:
    """`exchanged` of legs that are alike."""
    return p


#: The walker after heel strike: the legs change roles, and their numbers with them. exchanged(p).
exchanged: Callable[..., Any] = ByKind({Plain: the_same, **of_each("exchanged", EXCHANGED)})


@compiled
def as_stance_leg(p: Plain) -> tuple[float, float, float]:
    """`swing_leg` of legs that are alike."""
    return p.r, p.L_nat, p.l


@compiled
def other_leg(p: Detailed) -> tuple[float, float, float]:
    """`swing_leg` of detailed legs."""
    return p.r_2, p.L_nat_2, p.l_2


#: The swing leg's radius of the foot, natural length, and height of its mass above the foot's bottom: swing_leg(p).
swing_leg: Callable[..., tuple[float, float, float]] = ByKind({Plain: as_stance_leg, Detailed: other_leg})
