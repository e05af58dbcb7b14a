"""The equations of motion of a hip that is free in the plane and of one leg that hangs from it, derived by sympy.

The machine is the hip and two such legs. They meet in the hip's two coordinates only, so that a leg's part of the mass
matrix and of the forces is derived once and serves both: M = diag(M, M) for the hip, plus each leg's part. Springs,
dampers and friction between the legs act on their angles, see `stages.penalty.motion.accelerations`.

Coordinates of a part, q = (x, y, phi, L): the hip in the slope frame, the leg's angle, positive with the foot ahead,
and its length from the hip to the bottom of the foot. The ground pushes with N along the normal and with F along the
slope at the foot's radius, so that the power of F is F times the slip: its moment about the disc's centre is r F.
With rigid legs L has no equation; see `stages.penalty.motion.accelerations`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import sympy as sp

from stages.analytic.model import derivation as analytic
from stages.analytic.model.derivation import Leg, g_x, g_y, time_derivative
from stages.analytic.model.generate import by_numbers, function_source
from stages.penalty.model.walker import LegNumbers, PlainLeg

x, y, phi, L = sp.symbols("x y phi L", real=True)
dx, dy, dphi, dL = sp.symbols("dx dy dphi dL", real=True)
ddx, ddy, ddphi, ddL = sp.symbols("ddx ddy ddphi ddL", real=True)
N, F = sp.symbols("N F", real=True)
#: L - l: the foot's mass below the hip.
ARM = sp.Symbol("A", real=True)

COORDINATES = sp.Matrix([x, y, phi, L])
RATES = sp.Matrix([dx, dy, dphi, dL])
ACCELERATIONS = sp.Matrix([ddx, ddy, ddphi, ddL])


@dataclass(frozen=True)
class LegPart:
    """What one leg adds to M qdd + C qd = Q, and how its foot touches the ground.

    `mass` (4, 4); `force` (4, 1), Q - C qd of gravity, spring and damper; `contact` (3, 1): penetration [m], its rate
    and the slip velocity [m/s]; `push` (4, 1): the generalized force of N and F.
    """

    mass: sp.Matrix
    force: sp.Matrix
    contact: sp.Matrix
    push: sp.Matrix


def derive(leg: Leg) -> LegPart:
    """Lagrange's equations of the leg's masses, d/dt dT/dqd - dT/dq = Q, by the Jacobians of their positions."""
    along, across = sp.Matrix([sp.sin(phi), -sp.cos(phi)]), sp.Matrix([sp.cos(phi), sp.sin(phi)])
    hip = sp.Matrix([x, y])
    r, centre = leg.r, hip + (L - leg.r) * along
    mass, force = sp.zeros(4, 4), sp.zeros(4, 1)
    mass[2, 2] = leg.I + leg.I_f
    foot, frame = hip + (L - leg.l) * along + leg.e * across, hip + leg.l_f * along + leg.e_f * across
    for weight, position in ((leg.m, foot), (leg.m_f, frame)):
        jacobian = position.jacobian(COORDINATES)
        turning = time_derivative(jacobian, COORDINATES, RATES) * RATES
        mass += weight * jacobian.T * jacobian
        force += weight * jacobian.T * (sp.Matrix([g_x, g_y]) - turning)
    depth, travel = sp.Matrix([r - centre[1]]), sp.Matrix([centre[0] + r * phi])
    contact = sp.Matrix.vstack(depth, depth.jacobian(COORDINATES) * RATES, travel.jacobian(COORDINATES) * RATES)
    push = F * travel.jacobian(COORDINATES).T - N * depth.jacobian(COORDINATES).T
    force = force.applyfunc(partial(shortened, leg))
    force[3] -= leg.k * (L - leg.L_nat) + leg.b * dL
    return LegPart(mass.applyfunc(partial(shortened, leg)), force, contact, push)


def shortened(leg: Leg, term: sp.Expr) -> sp.Expr:
    """The same value with the leg's length measured from its mass centre, and without squares of both functions."""
    expanded = sp.expand(term.subs(L, leg.l + ARM))
    return sp.expand(expanded.subs(sp.sin(phi) ** 2, 1 - sp.cos(phi) ** 2)).subs(ARM, L - leg.l)


#: Text of one leg's part of the equations of motion, and of its derivatives, as compiled functions.
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
    "plain": Kind(analytic.OF_TABLE_1, analytic.TABLE_1, PlainLeg),
    "detailed": Kind(analytic.STANCE, analytic.DETAILED, LegNumbers),
}


def module_source(kind: Kind) -> str:
    """The text for a kind of leg."""
    part = derive(kind.leg)
    own = [phi, L, dphi, dL]
    given = [*own, ddx, ddy, ddphi, ddL, N, F]
    coupling = [part.mass[row, column] for row in (0, 1) for column in (2, 3)]
    levers = [part.push[row].coeff(force) for force in (N, F) for row in (2, 3)]
    terms = [*coupling, part.mass[2, 2], *part.force, *part.contact, *levers, part.mass[2, 3]]
    residual = part.force - part.mass * ACCELERATIONS + part.push
    by_state = [*residual.jacobian(own), *part.contact[1:, 0].jacobian([phi, L])]
    functions = [
        kind.function("leg_terms", [y, phi, L, dx, dy, dphi, dL], terms,
                      "M of (x, phi), (x, L), (y, phi), (y, L) and (phi, phi); Q - C qd (4,); penetration, its rate "
                      "and the slip;\n    what N and F do to phi and L: N phi, N L, F phi, F L; M of (phi, L)."),
        kind.function("leg_jacobian", given, by_state,
                      "d(Q - C qd - M qdd + push)/d(phi, L, dphi, dL) at given qdd, N and F, by rows, (4, 4);\n    "
                      "d(rate of penetration, slip)/d(phi, L), (2, 2)."),
        *change_functions(kind, given, [*residual, *part.contact]),
    ]  # fmt: skip
    assert part.mass[3, 3] == kind.leg.m and part.mass[0, 0] == part.mass[1, 1] == kind.leg.m + kind.leg.m_f
    assert part.push[0] == F and part.push[1] == N and sp.diff(part.contact[0], y) == -1
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
