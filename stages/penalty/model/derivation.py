"""The equations of motion of a hip that is free in the plane and of one leg that hangs from it, derived by sympy.

The machine is the hip and two such legs. They meet in the hip's two coordinates only, so that a leg's part of the mass
matrix and of the forces is derived once and serves both: M = diag(M, M) for the hip, plus each leg's part.

Coordinates of a part, q = (x, y, phi, L): the hip in the slope frame, the leg's angle, positive with the foot ahead,
and its length from the hip to the bottom of the foot. The ground pushes with N along the normal and with F along the
slope at the foot's radius, so that the power of F is F times the slip: its moment about the disc's centre is r F.
With rigid legs L has no equation; see `stages.penalty.motion.accelerations`.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from stages.analytic.model.derivation import L_nat, b, g_x, g_y, inertia, k, l, m, r, time_derivative

x, y, phi, L = sp.symbols("x y phi L", real=True)
dx, dy, dphi, dL = sp.symbols("dx dy dphi dL", real=True)
ddx, ddy, ddphi, ddL = sp.symbols("ddx ddy ddphi ddL", real=True)
N, F = sp.symbols("N F", real=True)
#: L - l: the leg's mass below the hip.
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


def derive() -> LegPart:
    """Lagrange's equations of the leg's mass, d/dt dT/dqd - dT/dq = Q, by the Jacobian of its position."""
    along = sp.Matrix([sp.sin(phi), -sp.cos(phi)])
    hip = sp.Matrix([x, y])
    position, centre = hip + (L - l) * along, hip + (L - r) * along
    jacobian = position.jacobian(COORDINATES)
    mass = m * jacobian.T * jacobian
    mass[2, 2] += inertia
    turning = m * jacobian.T * time_derivative(jacobian, COORDINATES, RATES) * RATES
    force = m * jacobian.T * sp.Matrix([g_x, g_y]) - turning
    depth, travel = sp.Matrix([r - centre[1]]), sp.Matrix([centre[0] + r * phi])
    contact = sp.Matrix.vstack(depth, depth.jacobian(COORDINATES) * RATES, travel.jacobian(COORDINATES) * RATES)
    push = F * travel.jacobian(COORDINATES).T - N * depth.jacobian(COORDINATES).T
    force = force.applyfunc(shortened)
    force[3] -= k * (L - L_nat) + b * dL
    return LegPart(mass.applyfunc(shortened), force, contact, push)


def shortened(term: sp.Expr) -> sp.Expr:
    """The same value with the leg's length measured from its mass centre, and without squares of both functions."""
    expanded = sp.expand(term.subs(L, l + ARM))
    return sp.expand(expanded.subs(sp.sin(phi) ** 2, 1 - sp.cos(phi) ** 2)).subs(ARM, L - l)
