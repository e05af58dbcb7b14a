"""The equations of motion of the biped, derived by sympy: eqs. (1)-(8) of the paper.

Coordinates q = (theta, L_1, psi, L_2), eq. (1). The stance foot rolls without slip; its centre is at x_0 for theta = 0.
Everything follows from the positions of three masses: hip, stance leg, swing leg. Rigid legs are the same
equations with both lengths held at their natural value, so q = (theta, psi).
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

theta, L1, psi, L2 = sp.symbols("theta L_1 psi L_2", real=True)
dtheta, dL1, dpsi, dL2 = sp.symbols("dtheta dL_1 dpsi dL_2", real=True)
ddtheta, ddL1, ddpsi, ddL2 = sp.symbols("ddtheta ddL_1 ddpsi ddL_2", real=True)
lambda1, lambda2 = sp.symbols("lambda_1 lambda_2", real=True)

M, m, L_nat, r, l, k, b, inertia = sp.symbols("M m L_nat r l k b I", nonnegative=True)  # noqa: E741 - symbols of Table 1
g_x, g_y = sp.symbols("g_x g_y", real=True)

#: The parameters by the names they have in `kinds`; gravity in the slope frame, g (sin a, -cos a).
PARAMETERS = {symbol.name: symbol for symbol in (M, m, L_nat, r, l, k, b, inertia, g_x, g_y)}


@dataclass(frozen=True)
class Equations:
    """The terms of eq. (6), M(q) qdd + C(q, qd) qd + K(q) + Pi lambda = 0, for one choice of coordinates.

    `mass` M (n, n) and `coriolis` C (n, n); `applied_force` (n, 1): gravity, springs and dampers, the paper's -K
    with the dampers added; `constraint` (2, 1) and `constraint_jacobian` Pi (n, 2), eqs. (3)-(5). The sign here is
    M qdd + C qd = applied_force + Pi lambda, so that lambda is the force of the ground on the second foot:
    lambda_1 normal, lambda_2 friction.
    """

    coordinates: sp.Matrix
    rates: sp.Matrix
    accelerations: sp.Matrix
    mass: sp.Matrix
    coriolis: sp.Matrix
    applied_force: sp.Matrix
    constraint: sp.Matrix
    constraint_jacobian: sp.Matrix
    masses: tuple[tuple[sp.Expr, sp.Matrix], ...]


def hip_position() -> sp.Matrix:
    """Hip in the slope frame with x_0 = 0, eq. (7)."""
    return sp.Matrix([r * theta + (L1 - r) * sp.sin(theta), r + (L1 - r) * sp.cos(theta)])


def mass_points() -> tuple[tuple[sp.Expr, sp.Matrix], ...]:
    """(mass, position) of hip, stance leg and swing leg."""
    hip = hip_position()
    stance = sp.Matrix([r * theta + (l - r) * sp.sin(theta), r + (l - r) * sp.cos(theta)])
    swing = hip + (L2 - l) * sp.Matrix([sp.sin(psi), -sp.cos(psi)])
    return (M, hip), (m, stance), (m, swing)


def foot_constraints() -> sp.Matrix:
    """Velocity-integrable forms of eqs. (3) and (4) for the second foot: height of its centre above r, and its roll.

    Both are positive outwards: normal gap -s_1 of eq. (3) seen from the foot, and the travel of the foot's
    lowest material point, whose rate is the slip velocity.
    """
    clearance = (L1 - r) * sp.cos(theta) - (L2 - r) * sp.cos(psi)
    roll = r * theta + (L1 - r) * sp.sin(theta) + (L2 - r) * sp.sin(psi) + r * psi
    return sp.Matrix([clearance, roll])


def time_derivative(matrix: sp.Matrix, q: sp.Matrix, qd: sp.Matrix) -> sp.Matrix:
    """Rate of a matrix that depends on the coordinates only."""
    rate = sp.zeros(*matrix.shape)
    for coordinate, speed in zip(q, qd, strict=True):
        rate += matrix.diff(coordinate) * speed
    return rate


def derive(legs: str = "compliant") -> Equations:
    """Derive the equations for `legs` "compliant", q = (theta, L_1, psi, L_2), or "rigid", q = (theta, psi)."""
    if legs == "compliant":
        q, qd, qdd = (sp.Matrix(names) for names in (
            [theta, L1, psi, L2], [dtheta, dL1, dpsi, dL2], [ddtheta, ddL1, ddpsi, ddL2]))
        lengths = {}
    else:
        q, qd, qdd = sp.Matrix([theta, psi]), sp.Matrix([dtheta, dpsi]), sp.Matrix([ddtheta, ddpsi])
        lengths = {L1: L_nat, L2: L_nat}
    points = tuple((mass, position.subs(lengths)) for mass, position in mass_points())
    gravity = sp.Matrix([g_x, g_y])
    size = len(q)
    mass_matrix, coriolis, applied = sp.zeros(size, size), sp.zeros(size, size), sp.zeros(size, 1)
    for mass, position in points:
        jacobian = position.jacobian(q)
        mass_matrix += mass * jacobian.T * jacobian
        coriolis += mass * jacobian.T * time_derivative(jacobian, q, qd)
        applied += mass * jacobian.T * gravity
    for angle in (theta, psi):
        index = list(q).index(angle)
        mass_matrix[index, index] += inertia
    if legs == "compliant":
        for length, rate in ((L1, dL1), (L2, dL2)):
            applied[list(q).index(length)] += -k * (length - L_nat) - b * rate
    constraint = foot_constraints().subs(lengths)
    return Equations(q, qd, qdd, mass_matrix, coriolis, applied, constraint, constraint.jacobian(q).T, points)


def energies(equations: Equations) -> tuple[sp.Expr, sp.Expr]:
    """Kinetic and potential energy (gravity from x = y = 0 of the stance foot, springs from their natural length)."""
    kinetic = (equations.rates.T * equations.mass * equations.rates)[0] / 2
    potential = -sum(mass * (g_x * position[0] + g_y * position[1]) for mass, position in equations.masses)
    if L1 in list(equations.coordinates):
        potential += k * (L1 - L_nat) ** 2 / 2 + k * (L2 - L_nat) ** 2 / 2
    return kinetic, potential


def ground_reaction(equations: Equations) -> sp.Matrix:
    """Force of the ground on both feet together, (tangential, normal): rate of momentum minus weight."""
    total = sp.zeros(2, 1)
    for mass, position in equations.masses:
        jacobian = position.jacobian(equations.coordinates)
        acceleration = jacobian * equations.accelerations + time_derivative(
            jacobian, equations.coordinates, equations.rates) * equations.rates
        total += mass * (acceleration - sp.Matrix([g_x, g_y]))
    return total


def handover_matrix(equations: Equations) -> sp.Matrix:
    """Rows: momenta of the next step's coordinates per unit velocity before heel strike, (n, n).

    The new stance foot is the old swing foot, theta+ = -psi, psi+ = -theta. The impulse acts at its contact point
    only, so the momenta of all motions that keep it rolling are conserved: M(q+) qd+ = handover(q-) qd-.
    """
    renamed = {theta: -psi, psi: -theta, L1: L2, L2: L1}
    q = equations.coordinates
    before = [(mass, position.jacobian(q)) for mass, position in equations.masses]
    after = [(mass, position.jacobian(q).subs(renamed, simultaneous=True)) for mass, position in equations.masses]
    order = (0, 2, 1)  # the legs' masses change roles
    result = sp.zeros(len(q), len(q))
    for index, other in enumerate(order):
        result += before[index][0] * after[other][1].T * before[index][1]
    names = list(q)
    result[names.index(theta), names.index(psi)] -= inertia
    result[names.index(psi), names.index(theta)] -= inertia
    return result
