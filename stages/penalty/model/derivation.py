"""The equations of motion of a hip that is free in the plane and of one leg that hangs from it, derived by sympy.

The machine is the hip and two such legs. They meet in the hip's two coordinates only, so that a leg's part of the mass
matrix and of the forces is derived once and serves both: M = diag(M, M) for the hip, plus each leg's part. Springs,
dampers and friction between the legs act on their angles, see `stages.penalty.motion.hip`.

Coordinates of a part, q = (x, y, phi, L): the hip in the slope frame, the leg's angle, positive with the foot ahead,
and its length from the hip to the bottom of the foot. The ground pushes with N along the normal and with F along the
slope at the foot's radius, so that the power of F is F times the slip: its moment about the disc's centre is r F.
With rigid legs L has no equation; see `stages.penalty.motion.accelerations`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import sympy as sp

from stages.analytic.model.derivation import Leg, g_x, g_y, time_derivative

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
