"""Rates of the state in each phase, and of the variations carried with it.

The state is y = (q, qd), followed by any number of variations dy, each as long as the state. Phases:
rigid single stance, q = (theta, psi); compliant single and double stance, q = (theta, L_1, psi, L_2).
In double stance the trailing foot's constraints hold at acceleration level; given a consistent start they only drift.
Where friction is limited (see `coulomb`) the trailing foot may also slide, forward or back, which leaves the constraint
of its height alone, or hover: in the air behind the other foot, and to come down again. A hip with Coulomb friction
rubs, forward or back, or sticks (`hip_friction`, `compliant_hip`).
"""

from __future__ import annotations

from collections.abc import Callable

from stages.analytic.compiled import ByKind, Constrained, Four, Jacobians, Numbers, compiled, inlined
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot, factor_constrained, solve, solve_constrained
from stages.analytic.model.kinds import Compliant, Limited, Rigid, SmoothRigid, SmoothRolling, TimedRigid
from stages.analytic.model.walker import Vector

RIGID, SINGLE_STANCE, DOUBLE_STANCE = 0, 1, 2
SLIDING_FORWARD, SLIDING_BACK, HOVERING = 3, 4, 5
RUBS_FORWARD, RUBS_BACK, HIP_STICKS = 6, 7, 8
#: What is added to the phase of a hip that rubs or sticks while both feet of compliant legs are on the ground.
ON_BOTH = 3


@compiled
def rigid_acceleration(y: Vector, p: Rigid) -> tuple[tuple[float, float], tuple[float, float, float]]:
    """qdd of rigid single stance and the inverse of its mass matrix (i11, i12, i22)."""
    m11, m12, m22, f1, f2 = eq.rigid_terms(y[0], y[1], y[2], y[3], p)
    inverse = 1.0 / (m11 * m22 - m12 * m12)
    i11, i12, i22 = m22 * inverse, -m12 * inverse, m11 * inverse
    return (i11 * f1 + i12 * f2, i12 * f1 + i22 * f2), (i11, i12, i22)


@compiled
def single_acceleration(y: Vector, p: Compliant) -> tuple[Four, Numbers]:
    """qdd of compliant single stance and the factors of its mass matrix."""
    t = eq.compliant_terms(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
    factors = eq.mass_factors(t, p)
    return solve(factors, t[10], t[11], t[12], t[13]), factors


@compiled
def contact_directions(y: Vector, p: Compliant) -> tuple[Four, Four, float, float]:
    """Pi^T by rows and -dPi^T/dt qd: the acceleration the constraints ask for."""
    c = eq.contact_terms(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
    return (c[0], c[1], c[2], c[3]), (c[4], c[5], c[6], c[7]), -c[8], -c[9]


@compiled
def double_acceleration(y: Vector, p: Compliant) -> tuple[Four, tuple[float, float], Numbers, Constrained, Four, Four]:
    """qdd and lambda of double stance, with the factors that solve the same system again."""
    free, factors = single_acceleration(y, p)
    normal, roll, target1, target2 = contact_directions(y, p)
    constrained = factor_constrained(factors, normal, roll)
    qdd, force = solve_constrained(factors, constrained, normal, roll, free, target1, target2)
    return qdd, force, factors, constrained, normal, roll


@compiled
def row4_times(row: Numbers, dy: Vector, start: int) -> float:
    """A row of four times what is stored from `start`. Written out: a loop over a tuple compiles to a long switch."""
    total: float = row[0] * dy[start] + row[1] * dy[start + 1] + row[2] * dy[start + 2] + row[3] * dy[start + 3]
    return total


@compiled
def row8_times(row: Numbers, dy: Vector, start: int) -> float:
    """A row of eight times the variation stored from `start`."""
    total: float = (
        row[0] * dy[start] + row[1] * dy[start + 1] + row[2] * dy[start + 2] + row[3] * dy[start + 3]
        + row[4] * dy[start + 4] + row[5] * dy[start + 5] + row[6] * dy[start + 6] + row[7] * dy[start + 7]
    )  # fmt: skip
    return total


@compiled
def double_jacobians(y: Vector, qdd: Four, force: tuple[float, float], p: Compliant) -> Jacobians:
    """What `double_variation` needs at a point, the same for every variation."""
    by_state = eq.compliant_residual_jacobian(
        y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], qdd[0], qdd[1], qdd[2], qdd[3], p)
    by_force = eq.contact_force_jacobian(y[0], y[1], y[2], y[3], force[0], force[1], p)
    by_contact = eq.contact_acceleration_jacobian(
        y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], qdd[0], qdd[1], qdd[2], qdd[3], p)
    return by_state, by_force, by_contact


@inlined
def force_variation(jacobians: Jacobians, dy: Vector, start: int) -> Four:
    """Variation of Q - C qd - M qdd + Pi lambda at unchanged qdd and lambda, for the variation stored from `start`."""
    by_state, by_force, _ = jacobians
    return (
        row4_times(by_force[0:4], dy, start) - row8_times(by_state[0:8], dy, start),
        row4_times(by_force[4:8], dy, start) - row8_times(by_state[8:16], dy, start),
        row4_times(by_force[8:12], dy, start) - row8_times(by_state[16:24], dy, start),
        row4_times(by_force[12:16], dy, start) - row8_times(by_state[24:32], dy, start),
    )


@inlined
def free_variation(jacobians: Jacobians, factors: Numbers, dy: Vector, start: int) -> Four:
    """Variation of qdd at unchanged lambda for the variation of the state stored from `start`."""
    f1, f2, f3, f4 = force_variation(jacobians, dy, start)
    return solve(factors, f1, f2, f3, f4)


@compiled
def double_variation(
    jacobians: Jacobians, system: tuple[Numbers, Constrained, Four, Four], dy: Vector, start: int
) -> tuple[Four, tuple[float, float]]:
    """Variations of qdd and lambda in double stance for the variation of the state stored from `start`."""
    _, _, by_contact = jacobians
    factors, constrained, normal, roll = system
    free = free_variation(jacobians, factors, dy, start)
    return solve_constrained(
        factors, constrained, normal, roll, free,
        -row8_times(by_contact[0:8], dy, start), -row8_times(by_contact[8:16], dy, start))


@compiled
def rigid_rates(phase: int, y: Vector, p: Rigid, rates: Vector) -> None:
    """Rates of state and variations, rigid single stance."""
    qdd, inverse = rigid_acceleration(y, p)
    rates[0], rates[1], rates[2], rates[3] = y[2], y[3], qdd[0], qdd[1]
    if y.size > 4:
        jacobian = eq.rigid_residual_jacobian(y[0], y[1], y[2], y[3], qdd[0], qdd[1], p)
        for start in range(4, y.size, 4):
            f1 = -row4_times(jacobian[0:4], y, start)
            f2 = -row4_times(jacobian[4:8], y, start)
            rates[start], rates[start + 1] = y[start + 2], y[start + 3]
            rates[start + 2] = inverse[0] * f1 + inverse[1] * f2
            rates[start + 3] = inverse[1] * f1 + inverse[2] * f2


@compiled
def store(rates: Vector, y: Vector, start: int, qdd: Four) -> None:
    """Rates of one 8-vector (q, qd) stored from `start`."""
    for i in range(4):
        rates[start + i] = y[start + 4 + i]
    rates[start + 4], rates[start + 5], rates[start + 6], rates[start + 7] = qdd


@inlined
def single_rates(y: Vector, p: Compliant, rates: Vector) -> None:
    """Rates of state and variations, compliant single stance."""
    qdd, factors = single_acceleration(y, p)
    store(rates, y, 0, qdd)
    if y.size > 8:
        jacobian = eq.compliant_residual_jacobian(
            y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], qdd[0], qdd[1], qdd[2], qdd[3], p)
        for start in range(8, y.size, 8):
            store(rates, y, start, solve(
                factors, -row8_times(jacobian[0:8], y, start), -row8_times(jacobian[8:16], y, start),
                -row8_times(jacobian[16:24], y, start), -row8_times(jacobian[24:32], y, start)))


@inlined
def double_rates(y: Vector, p: Compliant, rates: Vector) -> None:
    """Rates of state and variations, compliant double stance."""
    qdd, force, factors, constrained, normal, roll = double_acceleration(y, p)
    store(rates, y, 0, qdd)
    if y.size > 8:
        jacobians = double_jacobians(y, qdd, force, p)
        for start in range(8, y.size, 8):
            change, _ = double_variation(jacobians, (factors, constrained, normal, roll), y, start)
            store(rates, y, start, change)


@compiled
def push_of(factors: Numbers, normal: Four, roll: Four, ratio: float) -> tuple[Four, float]:
    """A force with normal part one and friction `ratio`: what it accelerates, and that along the normal.

    The latter is the inverse of the contact's effective mass; friction can turn its sign (Painleve's paradox).
    """
    push = solve(factors, normal[0] + ratio * roll[0], normal[1] + ratio * roll[1],
                 normal[2] + ratio * roll[2], normal[3] + ratio * roll[3])
    return push, dot(normal, push)


@compiled
def sliding_acceleration(
    phase: int, y: Vector, p: Limited
) -> tuple[Four, tuple[float, float], Numbers, Four, float, Four]:
    """qdd and lambda while the trailing foot slides, lambda_2 = -mu_d sign(slip) lambda_1, and what solves it again."""
    ratio = -p.mu_d if phase == SLIDING_FORWARD else p.mu_d
    free, factors = single_acceleration(y, p)
    normal, roll, target, _ = contact_directions(y, p)
    push, mobility = push_of(factors, normal, roll, ratio)
    force = (target - dot(normal, free)) / mobility
    qdd = (free[0] + push[0] * force, free[1] + push[1] * force, free[2] + push[2] * force, free[3] + push[3] * force)
    return qdd, (force, ratio * force), factors, push, mobility, normal


@compiled
def sliding_variation(
    jacobians: Jacobians, system: tuple[Numbers, Four, float, Four], dy: Vector, start: int
) -> tuple[Four, float]:
    """Variations of qdd and lambda_1 of a sliding foot for the variation of the state stored from `start`."""
    factors, push, mobility, normal = system
    free = free_variation(jacobians, factors, dy, start)
    force = (-row8_times(jacobians[2][0:8], dy, start) - dot(normal, free)) / mobility
    return (free[0] + push[0] * force, free[1] + push[1] * force,
            free[2] + push[2] * force, free[3] + push[3] * force), force


@inlined
def sliding_rates(phase: int, y: Vector, p: Limited, rates: Vector) -> None:
    """Rates of state and variations, trailing foot sliding."""
    qdd, force, factors, push, mobility, normal = sliding_acceleration(phase, y, p)
    store(rates, y, 0, qdd)
    if y.size > 8:
        jacobians = double_jacobians(y, qdd, force, p)
        for start in range(8, y.size, 8):
            change, _ = sliding_variation(jacobians, (factors, push, mobility, normal), y, start)
            store(rates, y, start, change)


@inlined
def rolling_rates(phase: int, y: Vector, p: Compliant, rates: Vector) -> None:
    """Rates of state and variations, compliant legs with feet that roll or are in the air."""
    if phase == DOUBLE_STANCE:
        double_rates(y, p, rates)
    else:
        single_rates(y, p, rates)


@compiled
def limited_rates(phase: int, y: Vector, p: Limited, rates: Vector) -> None:
    """Rates of state and variations, the trailing foot's friction limited."""
    if phase in (SLIDING_FORWARD, SLIDING_BACK):
        sliding_rates(phase, y, p, rates)
    else:
        rolling_rates(phase, y, p, rates)


#: Write dy/dt of the phase into `rates`: flow(phase, y, p, rates). Friction at the hip adds its own (`hip_friction`).
flow: Callable[..., None] = ByKind({
    SmoothRigid | TimedRigid: rigid_rates, SmoothRolling: rolling_rates, Limited: limited_rates})
