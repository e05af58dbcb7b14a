"""Text of the equations of motion, and of their derivatives by the walker's numbers, as compiled functions.

Terms are in their short form, with common subexpressions taken out. sympy's own `simplify` takes minutes and multiplies
the leg lengths out. What shortens these terms is known: lengths measured from the foot's centre and from the mass
centre, and sums of angles.

Each derivative by numbers is two functions. The first gives the derivatives of a term by the numbers that it holds, at
a point; zeros are left out. The second turns them into the change for given changes of the numbers, which come as a
walker of their own.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import NamedTuple

import sympy as sp
from sympy.printing.pycode import pycode

from stages.analytic.model import derivation as d

#: L_1 - r, L_2 - l and l - r: hip above the stance foot's centre, swing mass below the hip, mass above foot centre.
ARM, REACH, OFFSET = sp.symbols("A B c", real=True)
SIN_SUM, COS_SUM = sp.symbols("S C", real=True)
TOTAL = sp.Symbol("W", positive=True)
def moving(design: d.Design) -> sp.Expr:
    """The masses beside the hip's that move with the hip."""
    return design.swing.m + design.stance.m_f + design.swing.m_f


def shortened(expression: sp.Expr, design: d.Design = d.TABLE_1) -> sp.Expr:
    """The same value in terms of ARM, REACH, OFFSET and of S = sin(theta + psi), C = cos(theta + psi)."""
    sin1, cos1, sin2, cos2 = sp.sin(d.theta), sp.cos(d.theta), sp.sin(d.psi), sp.cos(d.psi)
    # leg lengths in the spring forces stay as they are, where the natural length is subtracted from them
    springs = {d.L1 - design.stance.L_nat: sp.Symbol("stretch_1"), d.L2 - design.swing.L_nat: sp.Symbol("stretch_2")}
    result = expression.subs(springs)
    result = sp.expand(result.subs({d.L1: d.r + ARM, d.L2: design.swing.l + REACH}).subs(d.l, d.r + OFFSET))
    result = sp.expand(result.subs({sin1**2: 1 - cos1**2, sin2**2: 1 - cos2**2}))
    result = sp.expand(result.subs(sin1 * sin2, cos1 * cos2 - COS_SUM))
    result = sp.expand(result.subs(sin1 * cos2, SIN_SUM - cos1 * sin2))
    result = sp.expand(result.subs(d.M, TOTAL - moving(design)))
    return sp.collect(result, [TOTAL, d.m]).subs({symbol: length for length, symbol in springs.items()})


def in_symbols_of_table_1(expression: sp.Expr) -> sp.Expr:
    """A shortened expression with the original symbols put back, sums of angles and masses kept together."""
    return expression.subs({
        ARM: d.L1 - d.r, REACH: d.L2 - d.l, OFFSET: d.l - d.r, TOTAL: d.M + d.m,
        SIN_SUM: sp.sin(d.theta + d.psi), COS_SUM: sp.cos(d.theta + d.psi)})


def for_code(expression: sp.Expr, design: d.Design) -> sp.Expr:
    """A shortened expression with the original symbols put back, in sines and cosines of the two angles only."""
    sin1, cos1, sin2, cos2 = sp.sin(d.theta), sp.cos(d.theta), sp.sin(d.psi), sp.cos(d.psi)
    return expression.subs({SIN_SUM: sin1 * cos2 + cos1 * sin2, COS_SUM: cos1 * cos2 - sin1 * sin2}).subs({
        ARM: d.L1 - d.r, REACH: d.L2 - design.swing.l, OFFSET: d.l - d.r, TOTAL: d.M + moving(design)})


def literal(expression: sp.Expr) -> str:
    """Python source of an expression; an integer on its own becomes a float, so that all outputs have one type."""
    source: str = pycode(expression, fully_qualified_modules=False)
    return f"{source}.0" if expression.is_Integer else source


def kind_of(name: str, design: d.Design) -> str:
    """The type of the walker's numbers that a generated function takes, whose name begins with the kind of legs."""
    return ("" if design is d.TABLE_1 else "Detailed") + ("Rigid" if name.startswith("rigid") else "Compliant")


def function_source(
    name: str, arguments: Sequence[sp.Symbol], outputs: Sequence[sp.Expr], doc: str, kind: str = "",
    design: d.Design = d.TABLE_1,
) -> str:  # fmt: skip
    """Source of one compiled function of the walker's numbers: common subexpressions, return a tuple.

    `kind` is the type of these numbers, by default the one that the name and the design say.
    """
    shared, reduced = sp.cse(list(outputs), symbols=sp.numbered_symbols("u"), order="none")
    used = set().union(*(expression.free_symbols for expression in outputs)) if outputs else set()
    kind = kind or kind_of(name, design)
    lines = ["@compiled", f"def {name}({', '.join(f'{name}: float' for name in arguments)}, p: {kind}) -> Numbers:",
             f'    """{doc}"""']
    symbols = [name for name, symbol in design.parameters.items() if symbol in used]
    if symbols:
        lines += [f"    {', '.join(symbols)} = {', '.join(f'p.{symbol}' for symbol in symbols)}"]
    lines += [f"    {symbol} = {literal(value)}" for symbol, value in shared]
    comma = "," if len(reduced) == 1 else ""
    lines += ["    return (" + ",\n            ".join(map(literal, reduced)) + f"{comma})"]
    return "\n".join(lines) + "\n"


@cache
def compact(expression: sp.Expr, design: d.Design = d.TABLE_1) -> sp.Expr:
    """The short form of a term."""
    return for_code(shortened(expression, design), design)


#: Head of a module of terms, or of their derivatives.
HEADER = '''"""Made of stages/analytic/model/derivation.py by sympy.

{what} Angles in rad, slope frame; any consistent units.
"""

from math import cos, sin

from stages.analytic.compiled import Numbers, compiled
from stages.analytic.model.kinds import {detailed}Compliant, {detailed}Rigid
'''
TERMS = "Terms of M qdd + C qd = Q + Pi lambda as compiled functions of scalars and of the walker's numbers `p`."
DERIVATIVES = "Derivatives of these terms by the walker's numbers, and their changes for changes `d` of these numbers."


class Parts(NamedTuple):
    """The equations of one choice of coordinates as their text needs them: with M qdd and Q - C qd in short form.

    `ground` is Pi lambda, and `constrained` the constraints of the second foot at acceleration level.
    """

    q: list[sp.Symbol]
    qd: list[sp.Symbol]
    qdd: list[sp.Symbol]
    multipliers: list[sp.Symbol]
    mass: sp.Matrix
    inertia: sp.Matrix
    force: sp.Matrix
    ground: sp.Matrix
    bias: sp.Matrix
    constrained: sp.Matrix
    handover: sp.Matrix


@cache
def parts(legs: str, design: d.Design) -> Parts:
    """The parts of the equations for `legs` "compliant" or "rigid", which have no second foot on the ground."""
    equations, short = d.derive(legs, design), partial(compact, design=design)
    rates, jacobian = equations.rates, equations.constraint_jacobian
    mass = equations.mass.applyfunc(short)
    multipliers = [d.lambda1, d.lambda2] if legs == "compliant" else []
    bias = d.time_derivative(jacobian, equations.coordinates, rates).T * rates
    return Parts(
        list(equations.coordinates), list(rates), list(equations.accelerations), multipliers, mass,
        mass * equations.accelerations, (equations.applied_force - equations.coriolis * rates).applyfunc(short),
        jacobian * sp.Matrix(multipliers) if multipliers else sp.zeros(len(rates), 1), bias,
        jacobian.T * equations.accelerations + bias, d.handover_matrix(equations))


def terms_source(design: d.Design = d.TABLE_1) -> str:
    """The text of all terms of a design: mass matrix and forces, reaction, energies, impact, second foot's constraints.
    """
    functions = []
    for legs in ("compliant", "rigid"):
        equations, part = d.derive(legs, design), parts(legs, design)
        q, qd, qdd, n = part.q, part.qd, part.qdd, len(part.q)
        upper = [part.mass[i, j] for i in range(n) for j in range(i, n)]
        rows = [
            (f"{legs}_terms", q + qd, [*upper, *part.force], "Upper triangle of M by rows, then Q - C qd."),
            (f"{legs}_residual_jacobian", q + qd + qdd, (part.inertia - part.force).jacobian(q + qd),
             f"d(M qdd + C qd - Q)/d(q, qd) at given qdd, by rows, ({n}, {2 * n})."),
            (f"{legs}_reaction", q + qd + qdd, d.ground_reaction(equations),
             "Force of the ground on both feet together: tangential, normal [N]."),
            (f"{legs}_energy", q + qd, d.energies(equations),
             "Kinetic and potential energy [J], x = 0 at the stance foot's centre for theta = 0."),
            (f"{legs}_inertia_jacobian", q + qdd, part.inertia.jacobian(q + qd),
             f"d(M qdd)/d(q, qd) at given qdd, by rows, ({n}, {2 * n})."),
            (f"{legs}_handover", q, part.handover, f"Handover matrix by rows, ({n}, {n})."),
            (f"{legs}_handover_jacobian", q + qd, (part.handover * equations.rates).jacobian(q),
             f"d(handover qd)/dq at given qd, by rows, ({n}, {n})."),
        ]  # fmt: skip
        if legs == "compliant":
            rows += [
                ("contact_terms", q + qd, [*equations.constraint_jacobian.T, *part.bias],
                 "Pi^T by rows (2, 4), then dPi^T/dt qd."),
                ("contact_force_jacobian", q + part.multipliers, part.ground.jacobian(q),
                 "d(Pi lambda)/dq at given lambda, by rows, (4, 4)."),
                ("contact_acceleration_jacobian", q + qd + qdd, part.constrained.jacobian(q + qd),
                 "d(Pi^T qdd + dPi^T/dt qd)/d(q, qd) at given qdd, by rows, (2, 8)."),
            ]  # fmt: skip
        functions += [function_source(*row, design=design) for row in rows]
    return module_source(TERMS, design, functions)


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


def derivatives_source(design: d.Design = d.TABLE_1) -> str:
    """The text of all derivatives of a design's terms; the constraints' at velocity level with qd for qdd, no rates."""
    functions = []
    for legs in ("compliant", "rigid"):
        equations, part = d.derive(legs, design), parts(legs, design)
        q, qd, qdd, held = part.q, part.qd, part.qdd, " - Pi lambda" if part.multipliers else ""
        rows = [
            (f"{legs}_residual", q + qd + qdd + part.multipliers, part.inertia - part.force - part.ground,
             f"M qdd + C qd - Q{held}"),
            (f"{legs}_impulse", q + qdd + part.multipliers, part.inertia - part.ground, f"M qdd{held}"),
            (f"{legs}_handover", q + qd, part.handover * equations.rates, "the momenta handed over at heel strike"),
            (f"{legs}_clearance", q, equations.constraint[:1, :], "the height of the swing foot"),
        ]  # fmt: skip
        if legs == "compliant":
            rows += [("contact_acceleration", q + qd + qdd, part.constrained, "Pi^T qdd + dPi^T/dt qd")]
        functions += [text for row in rows for text in pair(*row, design=design)]
    return module_source(DERIVATIVES, design, functions)


def module_source(what: str, design: d.Design, functions: Sequence[str]) -> str:
    """The text of a module of functions."""
    detailed = "" if design is d.TABLE_1 else "Detailed"
    return "\n\n".join([HEADER.format(what=what, detailed=detailed), *functions])


#: What makes the text of each module of equations.
SOURCES: dict[str, Callable[[], str]] = {
    "plain_terms": terms_source, "detailed_terms": partial(terms_source, d.DETAILED),
    "plain_derivatives": derivatives_source, "detailed_derivatives": partial(derivatives_source, d.DETAILED)}
