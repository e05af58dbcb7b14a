"""The generated terms of the equations of motion by the kind of walker: plain ones of Table 1, or detailed ones."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stages.analytic.compiled import ByKind, Numbers, compiled
from stages.analytic.model import detailed_equations, equations
from stages.analytic.model.elimination import coupled_factor, factor
from stages.analytic.model.kinds import (
    Detailed,
    DetailedLimited,
    DetailedRigid,
    DetailedRolling,
    Plain,
    PlainCompliant,
    PlainRigid,
    PlainRolling,
    RubbingRigid,
    RubbingRolling,
    StiffDetailedLimited,
    StiffDetailedRolling,
    TimedRigid,
)


def of_kinds(name: str) -> Callable[..., Numbers]:
    """The generated function `name` of the kind of `p`."""
    return ByKind({Plain: getattr(equations, name), Detailed: getattr(detailed_equations, name)})


compliant_terms, rigid_terms = of_kinds("compliant_terms"), of_kinds("rigid_terms")
compliant_residual_jacobian = of_kinds("compliant_residual_jacobian")
rigid_residual_jacobian = of_kinds("rigid_residual_jacobian")
compliant_reaction, rigid_reaction = of_kinds("compliant_reaction"), of_kinds("rigid_reaction")
compliant_energy, rigid_energy = of_kinds("compliant_energy"), of_kinds("rigid_energy")
contact_terms, contact_force_jacobian = of_kinds("contact_terms"), of_kinds("contact_force_jacobian")
contact_acceleration_jacobian = of_kinds("contact_acceleration_jacobian")
compliant_handover, rigid_handover = of_kinds("compliant_handover"), of_kinds("rigid_handover")
compliant_handover_jacobian = of_kinds("compliant_handover_jacobian")
rigid_handover_jacobian = of_kinds("rigid_handover_jacobian")


@compiled
def plain_inertia(
    theta: float, L_1: float, psi: float, L_2: float, ddtheta: float, ddL_1: float, ddpsi: float, ddL_2: float,
    p: PlainCompliant,
) -> Numbers:  # fmt: skip
    """`compliant_inertia_jacobian` of plain legs: springs, dampers and gravity are off."""
    at_rest = PlainRolling(p.M, p.m, p.L_nat, p.r, p.l, 0.0, 0.0, p.I, 0.0, 0.0)
    return equations.compliant_residual_jacobian(
        theta, L_1, psi, L_2, 0.0, 0.0, 0.0, 0.0, ddtheta, ddL_1, ddpsi, ddL_2, at_rest)


@compiled
def plain_rigid_inertia(theta: float, psi: float, ddtheta: float, ddpsi: float, p: PlainRigid) -> Numbers:
    """`rigid_inertia_jacobian` of plain legs: gravity is off."""
    without_forces = PlainRigid(p.M, p.m, p.L_nat, p.r, p.l, p.I, 0.0, 0.0)
    return equations.rigid_residual_jacobian(theta, psi, 0.0, 0.0, ddtheta, ddpsi, without_forces)


#: d(M qdd)/d(q, qd) at given qdd, by rows, of (4, 8) and (2, 4).
compliant_inertia_jacobian: Callable[..., Numbers] = ByKind({
    Plain: plain_inertia, Detailed: detailed_equations.compliant_inertia_jacobian})
rigid_inertia_jacobian: Callable[..., Numbers] = ByKind({
    Plain: plain_rigid_inertia, Detailed: detailed_equations.rigid_inertia_jacobian})


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
exchanged: Callable[..., Any] = ByKind({
    Plain: the_same, DetailedRigid: detailed_equations.exchanged_rigid,
    RubbingRigid: detailed_equations.exchanged_rubbing, RubbingRolling: detailed_equations.exchanged_rubbing_rolling,
    TimedRigid: detailed_equations.exchanged_timed,
    StiffDetailedRolling: detailed_equations.exchanged_stiff_rolling,
    StiffDetailedLimited: detailed_equations.exchanged_stiff_limited,
    DetailedRolling: detailed_equations.exchanged_rolling, DetailedLimited: detailed_equations.exchanged_limited})
