"""The equations of motion of the biped, derived by sympy: eqs. (1)-(8) of the paper.

Coordinates q = (theta, L_1, psi, L_2), eq. (1). The stance foot rolls without slip; its centre is at x_0 for theta = 0.
Everything follows from the positions of a few masses: hip, stance leg, swing leg, and of a detailed design the frames
that swing with the legs above their springs. Rigid legs are the same equations with both lengths held at their natural
values, so q = (theta, psi).
"""

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import sympy as sp

theta, L1, psi, L2 = sp.symbols("theta L_1 psi L_2", real=True)
dtheta, dL1, dpsi, dL2 = sp.symbols("dtheta dL_1 dpsi dL_2", real=True)
ddtheta, ddL1, ddpsi, ddL2 = sp.symbols("ddtheta ddL_1 ddpsi ddL_2", real=True)
lambda1, lambda2 = sp.symbols("lambda_1 lambda_2", real=True)

M, m, L_nat, r, l, k, b, inertia = sp.symbols("M m L_nat r l k b I", nonnegative=True)  # noqa: E741 - symbols of Table 1
g_x, g_y = sp.symbols("g_x g_y", real=True)
M_g, k_h, b_h, phi_h = sp.symbols("M_g k_h b_h phi_h", real=True)


class Leg(NamedTuple):
    """Symbols of one leg. Below its spring: mass m at height l above the foot's bottom and e forward, inertia I;
    above: mass m_f at l_f below the hip and e_f forward, inertia I_f.
    """

    m: sp.Expr
    L_nat: sp.Expr
    r: sp.Expr
    l: sp.Expr  # noqa: E741
    k: sp.Expr
    b: sp.Expr
    I: sp.Expr  # noqa: E741
    e: sp.Expr
    m_f: sp.Expr
    l_f: sp.Expr
    e_f: sp.Expr
    I_f: sp.Expr


@dataclass(frozen=True, eq=False)
class Design:
    """Symbols of a design: stance and swing leg, and the hip.

    The hip has mass M, for gravity `hip_weight`; a spring of stiffness `hip_k` that is relaxed where theta + psi is
    `hip_rest`, and viscous friction `hip_b`. `parameters` are the symbols by the names they have in `kinds`.
    """

    stance: Leg
    swing: Leg
    hip_weight: sp.Expr
    hip_k: sp.Expr
    hip_b: sp.Expr
    hip_rest: sp.Expr
    parameters: dict[str, sp.Symbol]


def named(symbols: tuple[sp.Symbol, ...]) -> dict[str, sp.Symbol]:
    """Symbols by their names."""
    return {symbol.name: symbol for symbol in symbols}


ZERO = sp.Integer(0)
OF_TABLE_1 = Leg(m, L_nat, r, l, k, b, inertia, ZERO, ZERO, ZERO, ZERO, ZERO)
#: Table 1: two equal legs and a free hip; gravity in the slope frame, g (sin a, -cos a).
TABLE_1 = Design(OF_TABLE_1, OF_TABLE_1, M, ZERO, ZERO, ZERO, named((M, m, L_nat, r, l, k, b, inertia, g_x, g_y)))
STANCE = OF_TABLE_1._replace(**named(sp.symbols("e m_f l_f e_f I_f", real=True)))
SWING = Leg(*(sp.Symbol(f"{symbol}_2", real=True) for symbol in STANCE))
#: All that a detailed design has, each leg with numbers of its own; those of the swing leg end in _2.
DETAILED = Design(STANCE, SWING, M_g, k_h, b_h, phi_h, named((M, M_g, *STANCE, *SWING, k_h, b_h, phi_h, g_x, g_y)))


class Body(NamedTuple):
    """A mass, what it weighs in masses, where it is, and its inertia about its centre with the angle it turns by."""

    mass: sp.Expr
    weight: sp.Expr
    position: sp.Matrix
    inertia: sp.Expr
    angle: sp.Symbol


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
    bodies: tuple[Body, ...]
    design: Design


def hip_position() -> sp.Matrix:
    """Hip in the slope frame with x_0 = 0, eq. (7)."""
    return sp.Matrix([r * theta + (L1 - r) * sp.sin(theta), r + (L1 - r) * sp.cos(theta)])


def bodies_of(design: Design) -> tuple[Body, ...]:
    """Hip, stance leg and swing leg, and in the same order the frames above their springs if the design has some."""
    stance, swing, hip = design.stance, design.swing, hip_position()
    along_stance, across_stance = sp.Matrix([sp.sin(theta), sp.cos(theta)]), sp.Matrix([sp.cos(theta), -sp.sin(theta)])
    along_swing, across_swing = sp.Matrix([sp.sin(psi), -sp.cos(psi)]), sp.Matrix([sp.cos(psi), sp.sin(psi)])
    foot = sp.Matrix([r * theta, r])
    found = [
        Body(M, design.hip_weight, hip, ZERO, theta),
        Body(stance.m, stance.m, foot + (stance.l - r) * along_stance + stance.e * across_stance, stance.I, theta),
        Body(swing.m, swing.m, hip + (L2 - swing.l) * along_swing + swing.e * across_swing, swing.I, psi),
    ]
    if stance.m_f != 0:
        found += [
            Body(stance.m_f, stance.m_f, hip - stance.l_f * along_stance + stance.e_f * across_stance, stance.I_f,
                 theta),
            Body(swing.m_f, swing.m_f, hip + swing.l_f * along_swing + swing.e_f * across_swing, swing.I_f, psi),
        ]  # fmt: skip
    return tuple(found)


def foot_constraints(design: Design) -> sp.Matrix:
    """Velocity-integrable forms of eqs. (3) and (4) for the second foot: its height above the ground, and its roll.

    Both are positive outwards: normal gap -s_1 of eq. (3) seen from the foot, and the travel of the foot's
    lowest material point, whose rate is the slip velocity.
    """
    radius = design.swing.r
    clearance = (L1 - r) * sp.cos(theta) - (L2 - radius) * sp.cos(psi) + (r - radius)
    roll = r * theta + (L1 - r) * sp.sin(theta) + (L2 - radius) * sp.sin(psi) + radius * psi
    return sp.Matrix([clearance, roll])


def time_derivative(matrix: sp.Matrix, q: sp.Matrix, qd: sp.Matrix) -> sp.Matrix:
    """Rate of a matrix that depends on the coordinates only."""
    rate = sp.zeros(*matrix.shape)
    for coordinate, speed in zip(q, qd, strict=True):
        rate += matrix.diff(coordinate) * speed
    return rate


@cache
def derive(legs: str = "compliant", design: Design = TABLE_1) -> Equations:
    """Derive the equations for `legs` "compliant", q = (theta, L_1, psi, L_2), or "rigid", q = (theta, psi)."""
    stance, swing = design.stance, design.swing
    if legs == "compliant":
        q, qd, qdd = (sp.Matrix(names) for names in (
            [theta, L1, psi, L2], [dtheta, dL1, dpsi, dL2], [ddtheta, ddL1, ddpsi, ddL2]))
        lengths = {}
    else:
        q, qd, qdd = sp.Matrix([theta, psi]), sp.Matrix([dtheta, dpsi]), sp.Matrix([ddtheta, ddpsi])
        lengths = {L1: stance.L_nat, L2: swing.L_nat}
    bodies = tuple(body._replace(position=body.position.subs(lengths)) for body in bodies_of(design))
    gravity = sp.Matrix([g_x, g_y])
    size = len(q)
    mass_matrix, coriolis, applied = sp.zeros(size, size), sp.zeros(size, size), sp.zeros(size, 1)
    for body in bodies:
        jacobian = body.position.jacobian(q)
        mass_matrix += body.mass * jacobian.T * jacobian
        coriolis += body.mass * jacobian.T * time_derivative(jacobian, q, qd)
        applied += body.weight * jacobian.T * gravity
        index = list(q).index(body.angle)
        mass_matrix[index, index] += body.inertia
    torque = -design.hip_k * (theta + psi - design.hip_rest) - design.hip_b * (dtheta + dpsi)
    for angle in (theta, psi):
        applied[list(q).index(angle)] += torque
    if legs == "compliant":
        for length, rate, leg in ((L1, dL1, stance), (L2, dL2, swing)):
            applied[list(q).index(length)] += -leg.k * (length - leg.L_nat) - leg.b * rate
    constraint = foot_constraints(design).subs(lengths)
    return Equations(q, qd, qdd, mass_matrix, coriolis, applied, constraint, constraint.jacobian(q).T, bodies, design)


def energies(equations: Equations) -> tuple[sp.Expr, sp.Expr]:
    """Kinetic and potential energy (gravity from x = y = 0 of the stance foot, springs from where they are relaxed)."""
    design = equations.design
    kinetic = (equations.rates.T * equations.mass * equations.rates)[0] / 2
    potential = -sum(body.weight * (g_x * body.position[0] + g_y * body.position[1]) for body in equations.bodies)
    if L1 in list(equations.coordinates):
        potential += sum(leg.k * (length - leg.L_nat) ** 2 / 2
                         for length, leg in ((L1, design.stance), (L2, design.swing)))  # fmt: skip
    return kinetic, potential + design.hip_k * (theta + psi - design.hip_rest) ** 2 / 2


def ground_reaction(equations: Equations) -> sp.Matrix:
    """Force of the ground on both feet together, (tangential, normal): rate of momentum minus weight."""
    total, gravity = sp.zeros(2, 1), sp.Matrix([g_x, g_y])
    for body in equations.bodies:
        jacobian = body.position.jacobian(equations.coordinates)
        acceleration = jacobian * equations.accelerations + time_derivative(
            jacobian, equations.coordinates, equations.rates) * equations.rates
        total += body.mass * (acceleration - gravity) + (body.mass - body.weight) * gravity
    return total


def handover_matrix(equations: Equations) -> sp.Matrix:
    """Rows: momenta of the next step's coordinates per unit velocity before heel strike, (n, n).

    The new stance foot is the old swing foot, theta+ = -psi, psi+ = -theta. The impulse acts at its contact point
    only, so the momenta of all motions that keep it rolling are conserved: M(q+) qd+ = handover(q-) qd-.
    """
    stance, swing, q = equations.design.stance, equations.design.swing, equations.coordinates
    renamed = {theta: -psi, psi: -theta, L1: L2, L2: L1}
    if stance != swing:  # the legs' numbers change roles as well
        renamed |= dict(zip((*stance, *swing), (*swing, *stance), strict=True))
    before = [body.position.jacobian(q) for body in equations.bodies]
    after = [body.position.jacobian(q).subs(renamed, simultaneous=True) for body in equations.bodies]
    order = (0, 2, 1, 4, 3)  # the legs' masses change roles
    result = sp.zeros(len(q), len(q))
    for index, body in enumerate(equations.bodies):
        result += body.mass * after[order[index]].T * before[index]
    names = list(q)
    for body in equations.bodies:
        new = psi if body.angle == theta else theta
        result[names.index(new), names.index(body.angle)] -= body.inertia
    return result
