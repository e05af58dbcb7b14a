"""Short forms of the derived terms, for the printed formulas and for the generated code.

sympy's own `simplify` takes minutes and multiplies the leg lengths out. What shortens these terms is known: lengths
measured from the foot's centre and from the mass centre, and sums of angles.
"""

from __future__ import annotations

import sympy as sp

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


def for_code(expression: sp.Expr, design: d.Design = d.TABLE_1) -> sp.Expr:
    """A shortened expression with the original symbols put back, in sines and cosines of the two angles only."""
    sin1, cos1, sin2, cos2 = sp.sin(d.theta), sp.cos(d.theta), sp.sin(d.psi), sp.cos(d.psi)
    return expression.subs({SIN_SUM: sin1 * cos2 + cos1 * sin2, COS_SUM: cos1 * cos2 - sin1 * sin2}).subs({
        ARM: d.L1 - d.r, REACH: d.L2 - design.swing.l, OFFSET: d.l - d.r, TOTAL: d.M + moving(design)})
