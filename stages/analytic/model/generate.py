"""Text of the equations of motion as compiled functions: in their short form, common subexpressions taken out."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import sympy as sp

from stages.analytic.model import derivation as d
from stages.analytic.model.generate_derivatives import derivatives_source
from stages.analytic.model.generated_source import compact, function_source

HEADER = '''"""Made of stages/analytic/model/derivation.py by sympy.

Terms of M qdd + C qd = Q + Pi lambda as compiled functions of scalars and of the walker's numbers `p`. Angles in rad,
slope frame; any consistent units.
"""

from math import cos, sin

from stages.analytic.compiled import Numbers, compiled
from stages.analytic.model.kinds import Compliant, Rigid
'''
DETAILED_HEADER = HEADER.replace("Compliant, Rigid", "DetailedCompliant, DetailedRigid")


def stance_functions(equations: d.Equations, prefix: str) -> list[str]:
    """Mass matrix and forces, their Jacobian, ground reaction and energies, for one choice of coordinates."""
    q, qd, qdd = (list(vector) for vector in (equations.coordinates, equations.rates, equations.accelerations))
    size, design = len(q), equations.design
    short = partial(compact, design=design)
    mass = equations.mass.applyfunc(short)
    force = (equations.applied_force - equations.coriolis * equations.rates).applyfunc(short)
    upper = [mass[i, j] for i in range(size) for j in range(i, size)]
    residual = mass * equations.accelerations - force
    functions = [
        (f"{prefix}_terms", q + qd, [*upper, *force], "Upper triangle of M by rows, then Q - C qd."),
        (f"{prefix}_residual_jacobian", q + qd + qdd, list(residual.jacobian(q + qd)),
         f"d(M qdd + C qd - Q)/d(q, qd) at given qdd, by rows, ({size}, {2 * size})."),
        (f"{prefix}_reaction", q + qd + qdd, list(d.ground_reaction(equations)),
         "Force of the ground on both feet together: tangential, normal [N]."),
        (f"{prefix}_energy", q + qd, list(d.energies(equations)),
         "Kinetic and potential energy [J], x = 0 at the stance foot's centre for theta = 0."),
        (f"{prefix}_inertia_jacobian", q + qdd, list((mass * equations.accelerations).jacobian(q + qd)),
         f"d(M qdd)/d(q, qd) at given qdd, by rows, ({size}, {2 * size})."),
    ]  # fmt: skip
    return [function_source(*function, design=design) for function in functions]


def contact_functions(equations: d.Equations) -> list[str]:
    """Constraints of the second foot, eqs. (3)-(5), and what their derivatives need."""
    q, qd, qdd = (list(vector) for vector in (equations.coordinates, equations.rates, equations.accelerations))
    jacobian = equations.constraint_jacobian
    bias = d.time_derivative(jacobian, equations.coordinates, equations.rates).T * equations.rates
    multipliers = sp.Matrix([d.lambda1, d.lambda2])
    by_multiplier = (jacobian * multipliers).jacobian(q)
    by_state = (jacobian.T * equations.accelerations + bias).jacobian(q + qd)
    functions = (
        ("contact_terms", q + qd, [*jacobian.T, *bias], "Pi^T by rows (2, 4), then dPi^T/dt qd."),
        ("contact_force_jacobian", q + list(multipliers), list(by_multiplier),
         "d(Pi lambda)/dq at given lambda, by rows, (4, 4)."),
        ("contact_acceleration_jacobian", q + qd + qdd, list(by_state),
         "d(Pi^T qdd + dPi^T/dt qd)/d(q, qd) at given qdd, by rows, (2, 8)."),
    )  # fmt: skip
    return [function_source(*function, design=equations.design) for function in functions]


def impact_functions(equations: d.Equations, prefix: str) -> list[str]:
    """Momentum handed over at heel strike, for one choice of coordinates."""
    q, qd = list(equations.coordinates), list(equations.rates)
    momentum, shape = d.handover_matrix(equations), f"({len(q)}, {len(q)})"
    functions = (
        (f"{prefix}_handover", q, list(momentum), f"Handover matrix by rows, {shape}."),
        (f"{prefix}_handover_jacobian", q + qd, list((momentum * equations.rates).jacobian(q)),
         f"d(handover qd)/dq at given qd, by rows, {shape}."),
    )  # fmt: skip
    return [function_source(*function, design=equations.design) for function in functions]


def module_source(design: d.Design = d.TABLE_1) -> str:
    """The text of all terms of a design."""
    compliant, rigid = d.derive("compliant", design), d.derive("rigid", design)
    functions = [*stance_functions(compliant, "compliant"), *contact_functions(compliant),
                 *impact_functions(compliant, "compliant"), *stance_functions(rigid, "rigid"),
                 *impact_functions(rigid, "rigid")]
    return "\n\n".join([HEADER if design is d.TABLE_1 else DETAILED_HEADER, *functions])


#: What makes the text of each module of equations.
SOURCES: dict[str, Callable[[], str]] = {
    "plain_terms": module_source, "detailed_terms": partial(module_source, d.DETAILED),
    "plain_derivatives": derivatives_source, "detailed_derivatives": partial(derivatives_source, d.DETAILED)}
