"""Text of one leg's part of the equations of motion, and of its derivatives, as compiled functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from stages.analytic.model import derivation as analytic
from stages.analytic.model.generate import by_numbers, function_source
from stages.penalty.model import derivation as d
from stages.penalty.model.walker import LegNumbers, Penalty

HEADER = '''"""Made of stages/penalty/model/derivation.py by sympy.

One leg's part of M qdd + C qd = Q as compiled functions of scalars and of the leg's numbers `p`, and its derivatives
by these. Angles in rad, slope frame; any consistent units.
"""

from math import cos, sin

import numpy as np

from stages.analytic.compiled import Numbers
from stages.penalty.compiled import compiled
from stages.penalty.model.walker import KIND
'''


@dataclass(frozen=True)
class Kind:
    """Symbols of a leg, the design that names them, and the type that holds its numbers."""

    leg: analytic.Leg
    design: analytic.Design
    numbers: Any

    def function(self, name: str, arguments: Sequence[sp.Symbol], outputs: Sequence[sp.Expr], doc: str) -> str:
        """Source of a function of a leg's numbers."""
        return function_source(name, arguments, outputs, doc, self.numbers.__name__, self.design)


KINDS = {
    "plain": Kind(analytic.OF_TABLE_1, analytic.TABLE_1, Penalty),
    "detailed": Kind(analytic.STANCE, analytic.DETAILED, LegNumbers),
}


def module_source(kind: Kind) -> str:
    """The text for a kind of leg."""
    part = d.derive(kind.leg)
    own = [d.phi, d.L, d.dphi, d.dL]
    given = [*own, d.ddx, d.ddy, d.ddphi, d.ddL, d.N, d.F]
    coupling = [part.mass[row, column] for row in (0, 1) for column in (2, 3)]
    levers = [part.push[row].coeff(force) for force in (d.N, d.F) for row in (2, 3)]
    terms = [*coupling, part.mass[2, 2], *part.force, *part.contact, *levers, part.mass[2, 3]]
    residual = part.force - part.mass * d.ACCELERATIONS + part.push
    by_state = [*residual.jacobian(own), *part.contact[1:, 0].jacobian([d.phi, d.L])]
    functions = [
        kind.function("leg_terms", [d.y, d.phi, d.L, d.dx, d.dy, d.dphi, d.dL], terms,
                      "M of (x, phi), (x, L), (y, phi), (y, L) and (phi, phi); Q - C qd (4,); penetration, its rate "
                      "and the slip;\n    what N and F do to phi and L: N phi, N L, F phi, F L; M of (phi, L)."),
        kind.function("leg_jacobian", given, by_state,
                      "d(Q - C qd - M qdd + push)/d(phi, L, dphi, dL) at given qdd, N and F, by rows, (4, 4);\n    "
                      "d(rate of penetration, slip)/d(phi, L), (2, 2)."),
        *change_functions(kind, given, [*residual, *part.contact]),
    ]  # fmt: skip
    assert part.mass[3, 3] == kind.leg.m and part.mass[0, 0] == part.mass[1, 1] == kind.leg.m + kind.leg.m_f
    assert part.push[0] == d.F and part.push[1] == d.N and sp.diff(part.contact[0], d.y) == -1
    return "\n\n".join([HEADER.replace("KIND", kind.numbers.__name__), *functions])


def change_functions(kind: Kind, given: Sequence[sp.Symbol], outputs: Sequence[sp.Expr]) -> list[str]:
    """Two functions: derivatives of a leg's part by its numbers, and its change for a row of their changes."""
    parameters, fields = kind.design.parameters, kind.numbers._fields
    derivatives, sums = by_numbers(outputs, {
        f"a[row, start + {place}]": parameters[name] for place, name in enumerate(fields) if name in parameters})
    what = "Q - C qd - M qdd + push at given qdd, N and F, (4,), then of penetration, its rate and the slip"
    lines = ["@compiled", "def leg_change(by: Numbers, a: np.ndarray, row: int, start: int, p: "
             f"{kind.numbers.__name__}) -> Numbers:",
             f'    """Change of {what},\n    from `leg_by`, for changes of the leg\'s numbers in `a` from `start`."""',
             "    return (" + ",\n            ".join(sums) + ")"]  # fmt: skip
    return [
        kind.function("leg_by", given, derivatives, f"Derivatives of {what}, by the numbers,\n    by rows, without "
                      "zeros."),
        "\n".join(lines) + "\n",
    ]  # fmt: skip
