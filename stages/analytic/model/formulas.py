"""Prints the equations of motion as formulas: `python -m stages.analytic.model.formulas` writes docs/equations.md."""

from pathlib import Path

import sympy as sp

from stages.analytic.model import derivation as d
from stages.analytic.model.generate import in_symbols_of_table_1, shortened

DOTTED = {
    d.dtheta: r"\dot{\theta}", d.dL1: r"\dot{L}_1", d.dpsi: r"\dot{\psi}", d.dL2: r"\dot{L}_2", d.L_nat: r"L_{nat}",
}
INTRODUCTION = """# Equations of motion

This page has the equations of motion of the constraint model, in the symbols of [model.md](model.md). It is printed by
`python -m stages.analytic.model.formulas`; the compiled code comes from the same `stages/analytic/model/derivation.py`.

The state is $q = (\\theta, L_1, \\psi, L_2)$, eq. (1). Eq. (6) reads, with the sign convention used here,

$$M(q)\\,\\ddot{q} + C(q, \\dot{q})\\,\\dot{q} + K(q, \\dot{q}) = p\\,\\Pi\\,\\lambda$$

with $p = 0$ in single stance and $p = 1$ in double stance. $\\lambda_1$ is the normal force and $\\lambda_2$ the
friction force of the ground on the second foot. Gravity in the slope frame is $(g_x, g_y) = g\\,(\\sin a, -\\cos a)$.
$I$ is the inertia of a leg about its mass centre, zero in the paper.
"""


def tidy(expression: sp.Expr) -> sp.Expr:
    """The expression as it is printed."""
    if expression.free_symbols & {d.L1, d.L2} or d.L_nat not in expression.free_symbols:
        return in_symbols_of_table_1(shortened(expression))
    return in_symbols_of_table_1(shortened(expression.subs(d.L_nat, d.L1))).subs(d.L1, d.L_nat)


def printed(expression: sp.Expr) -> str:
    """LaTeX of an expression with dots for rates."""
    source: str = sp.latex(expression, symbol_names=DOTTED)
    return source


def entries(name: str, matrix: sp.Matrix, *, symmetric: bool = False) -> list[str]:
    """The entries of a matrix that are not zero, one formula each."""
    lines = []
    for i in range(matrix.rows):
        for j in range(i if symmetric else 0, matrix.cols):
            value = tidy(matrix[i, j])
            if value != 0:
                index = f"{i + 1}" if matrix.cols == 1 else f"{i + 1}{j + 1}"
                mirrored = f" = {name}_{{{j + 1}{i + 1}}}" if symmetric and i != j else ""
                lines.append(f"$${name}_{{{index}}}{mirrored} = {printed(value)}$$\n")
    return lines


def document() -> str:
    """The whole of docs/equations.md."""
    equations = d.derive("compliant")
    rigid = d.derive("rigid")
    parts = [
        INTRODUCTION,
        "## Hip, eq. (7)\n",
        f"$$x_{{hip}} = x_0 + {printed(d.hip_position()[0])}, \\qquad y_{{hip}} = {printed(d.hip_position()[1])}$$\n",
        "## Mass matrix\n",
        "Symmetric; entries not listed are zero.\n", *entries("M", equations.mass, symmetric=True),
        "## Centrifugal and Coriolis matrix\n",
        r"$\dot{M} - 2C$ is skew. Entries not listed are zero." + "\n", *entries("C", equations.coriolis),
        "## Gravity, springs and dampers\n",
        "The paper's $K$ with its dampers written out.\n", *entries("K", -equations.applied_force),
        "## Constraints of double stance, eqs. (3) to (5)\n",
        "Height of the second foot's centre above $r$, and the travel of its contact point, whose rate is the slip"
        " velocity.\n",
        *(f"$$s_{i + 1} = {printed(equations.constraint[i])}$$\n" for i in range(2)),
        "Their Jacobian; eq. (5) with its misprinted \"$= 0$\" left out:\n",
        f"$$\\Pi = {printed(equations.constraint_jacobian)}$$\n",
        "## Rigid legs\n",
        "Both lengths held at $L_{nat}$, $q = (\\theta, \\psi)$: rows and columns 1 and 3 of $M$ and $C$, entries 1 and"
        " 3 of $K$.\n",
        "At heel strike the momenta of the next step's motions are kept, $M(q^+)\\,\\dot{q}^+ = H(q^-)\\,\\dot{q}^-$"
        " with $\\theta^+ = -\\psi$, $\\psi^+ = -\\theta$:\n", *entries("H", d.handover_matrix(rigid)),
    ]
    return "\n".join(parts).rstrip() + "\n"


if __name__ == "__main__":
    (Path(__file__).parents[3] / "docs/equations.md").write_text(document(), encoding="utf-8")
