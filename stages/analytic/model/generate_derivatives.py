"""Text of the derivatives of the equations of motion by the walker's numbers.

Each term gets two functions. The first gives its derivatives by the numbers that it holds, at a point; zeros are left
out. The second turns them into the change for given changes of the numbers, which come as a walker of their own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import sympy as sp

from stages.analytic.model import derivation as d
from stages.analytic.model.generated_source import compact, function_source, kind_of

HEADER = '''"""Made of stages/analytic/model/derivation.py by sympy.

Derivatives of the equations of motion by the walker's numbers, and their changes for changes `d` of these numbers.
"""

from math import cos, sin

from stages.analytic.compiled import Numbers, compiled
from stages.analytic.model.kinds import Compliant, Rigid
'''

DETAILED_HEADER = HEADER.replace("Compliant, Rigid", "DetailedCompliant, DetailedRigid")


def by_numbers(outputs: Sequence[sp.Expr], changes: Mapping[str, sp.Symbol]) -> tuple[list[sp.Expr], list[str]]:
    """Derivatives of terms by numbers, without zeros, and the source of each term's change for their `changes`."""
    derivatives: list[sp.Expr] = []
    sums = []
    for output in outputs:
        products, held = [], output.free_symbols
        for change, symbol in changes.items():
            if symbol in held and sp.expand(derivative := sp.diff(output, symbol)) != 0:
                products.append(f"by[{len(derivatives)}] * {change}")
                derivatives.append(derivative)
        sums.append(" + ".join(products) or "0.0")
    return derivatives, sums


def pair(
    name: str, arguments: Sequence[sp.Symbol], outputs: Sequence[sp.Expr], doc: str, design: d.Design
) -> list[str]:  # fmt: skip
    """Both functions of one term; `name` begins with the kind of legs."""
    kind = kind_of(name, design)
    derivatives, sums = by_numbers(outputs, {f"d.{each}": symbol for each, symbol in design.parameters.items()})
    lines = ["@compiled", f"def {name}_change(by: Numbers, d: {kind}) -> Numbers:",
             f'    """Change of {doc}, from `{name}_by`."""',
             "    return (" + ",\n            ".join(sums) + ("," if len(sums) == 1 else "") + ")"]
    first = function_source(
        f"{name}_by", arguments, derivatives, f"Derivatives of {doc}, by rows, without zeros.", design=design)
    return [first, "\n".join(lines) + "\n"]


def legs_functions(legs: str, design: d.Design) -> list[str]:
    """The terms of one choice of coordinates."""
    equations, short = d.derive(legs, design), partial(compact, design=design)
    q, qd, qdd = (list(vector) for vector in (equations.coordinates, equations.rates, equations.accelerations))
    mass = equations.mass.applyfunc(short) * equations.accelerations
    force = (equations.applied_force - equations.coriolis * equations.rates).applyfunc(short)
    clearance = equations.constraint[0]
    handover = d.handover_matrix(equations) * equations.rates
    ground, multipliers, hold = sp.zeros(len(q), 1), [], ""
    if legs == "compliant":
        multipliers, hold = [d.lambda1, d.lambda2], " - Pi lambda"
        ground = equations.constraint_jacobian * sp.Matrix(multipliers)
    return [
        *pair(f"{legs}_residual", q + qd + qdd + multipliers, list(mass - force - ground),
              f"M qdd + C qd - Q{hold}", design),
        *pair(f"{legs}_impulse", q + qdd + multipliers, list(mass - ground), f"M qdd{hold}", design),
        *pair(f"{legs}_handover", q + qd, list(handover), "the momenta handed over at heel strike",
              design),
        *pair(f"{legs}_clearance", q, [clearance], "the height of the swing foot", design),
    ]


def contact_functions(design: d.Design) -> list[str]:
    """The constraints of the second foot, at acceleration level; at velocity level with qd for qdd and no rates."""
    equations = d.derive("compliant", design)
    q, qd, qdd = (list(vector) for vector in (equations.coordinates, equations.rates, equations.accelerations))
    jacobian = equations.constraint_jacobian
    bias = d.time_derivative(jacobian, equations.coordinates, equations.rates).T * equations.rates
    constrained = jacobian.T * equations.accelerations + bias
    return pair("contact_acceleration", q + qd + qdd, list(constrained), "Pi^T qdd + dPi^T/dt qd",
                design)


def derivatives_source(design: d.Design = d.TABLE_1) -> str:
    """The text of all derivatives of a design's terms."""
    functions = [*legs_functions("compliant", design), *contact_functions(design), *legs_functions("rigid", design)]
    return "\n\n".join([HEADER if design is d.TABLE_1 else DETAILED_HEADER, *functions])
