"""The step map once more, written to be read: sympy's terms through numpy, SciPy's integrator, SciPy's events.

Selected by `integrator: scipy` in params/analytic.yaml. It shares the derivation with the compiled path and nothing
else: no generated code, no written-out elimination, no variational equations, no event search. It is some hundred
times slower, and a test holds both paths to the same step.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp

from stages.analytic.errors import StepFailed
from stages.analytic.gait.poincare import TIME_LIMIT_OF_A_PHASE, FixedPoint, Step
from stages.analytic.model import derivation as d
from stages.analytic.model.kinds import (
    PASSING,
    Detailed,
    DetailedCompliant,
    DetailedRigid,
    PlainCompliant,
    PlainRigid,
    Rigid,
    natural_lengths,
    radii,
)
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.section import section_coordinates, section_state

#: Evaluations of the equations of motion after which a phase is given up, some hundred times those of a usual phase.
MOST_EVALUATIONS = 100_000
#: The scuffing foot leaves the ground again within this time [pendulum times] where a located strike is no strike.
STRIDE_ON = 1e-6
#: So often at most; a usual step has one or two.
MOST_SCUFFS = 50


class TooSlow(StepFailed):
    """SciPy needs more evaluations for a phase than it is granted."""


@dataclass(frozen=True)
class Terms:
    """The terms of eq. (6) as functions of a state y = (q, qd) and the parameters p."""

    mass: Callable[..., np.ndarray]
    force: Callable[..., np.ndarray]
    constraint: Callable[..., np.ndarray]
    constraint_jacobian: Callable[..., np.ndarray]
    constraint_bias: Callable[..., np.ndarray]
    handover: Callable[..., np.ndarray]


@lru_cache(maxsize=4)
def terms(legs: str, detailed: bool = False) -> Terms:
    """Terms for `legs` "compliant" or "rigid", of Table 1 or of a detailed design, straight from the derivation."""
    design = d.DETAILED if detailed else d.TABLE_1
    equations = d.derive(legs, design)
    q, qd, jacobian = equations.coordinates, equations.rates, equations.constraint_jacobian
    bias = d.time_derivative(jacobian, q, qd).T * qd
    force = equations.applied_force - equations.coriolis * qd
    kinds: tuple[Any, Any] = (DetailedRigid, DetailedCompliant) if detailed else (PlainRigid, PlainCompliant)
    fields = kinds[0 if legs == "rigid" else 1]._fields
    names = [name for name in fields if name in design.parameters]  # no term holds friction
    arguments = [[*q, *qd], [design.parameters[name] for name in names]]

    def function(matrix: sp.Matrix) -> Callable[..., np.ndarray]:
        compute: Callable[..., np.ndarray] = sp.lambdify(arguments, matrix, "numpy", cse=True, docstring_limit=0)
        return lambda y, p: compute(y, p[: len(names)])

    return Terms(function(equations.mass), function(force), function(equations.constraint), function(jacobian),
                 function(bias), function(d.handover_matrix(equations)))


def terms_of(walker: Walker) -> Terms:
    """The terms of a walker's kind."""
    return terms("rigid" if walker.rigid else "compliant", isinstance(walker.p, Detailed))


def held(mass: np.ndarray, pi: np.ndarray) -> np.ndarray:
    """The matrix (6, 6) of motion with both feet held: mass (4, 4), constraint forces and constraints (4, 2)."""
    matrix = np.zeros((6, 6))
    matrix[:4, :4], matrix[:4, 4:], matrix[4:, :4] = mass, -pi, pi.T
    return matrix


def accelerations(walker: Walker, y: Vector, both_feet: bool) -> tuple[Vector, Vector]:
    """qdd and, with both feet on the ground, the forces lambda on the second one: eq. (6) solved as it stands."""
    t = terms_of(walker)
    mass, force = t.mass(y, walker.p), t.force(y, walker.p).ravel()
    if not both_feet:
        return np.linalg.solve(mass, force), np.zeros(2)
    pi, bias = t.constraint_jacobian(y, walker.p), t.constraint_bias(y, walker.p).ravel()
    solution = np.linalg.solve(held(mass, pi), np.concatenate([force, -bias]))
    return solution[:4], solution[4:]


def clearance(walker: Walker, y: Vector) -> float:
    """Height of the swing foot above the ground, eq. (3)."""
    t = terms_of(walker)
    return float(t.constraint(y, walker.p)[0, 0])


def advance(walker: Walker, y: Vector) -> float:
    """Distance of the second foot's centre ahead of the stance foot's."""
    own, other = natural_lengths(walker.p)
    theta, stance, psi, swing = (y[0], own, y[1], other) if walker.rigid else y[:4]
    radius, second = radii(walker.p)
    return float((stance - radius) * np.sin(theta) + (swing - second) * np.sin(psi))


def integrate(
    walker: Walker, y: Vector, event: Callable[[float, Vector], float], both_feet: bool, tolerance: float,
    method: str = "DOP853",
) -> tuple[float, Vector]:
    """Time and state when `event` falls through zero. Raises StepFailed if it does not in time, TooSlow if that takes
    too many evaluations.
    """
    half, evaluations = y.size // 2, 0

    def rates(_: float, state: Vector) -> Vector:
        nonlocal evaluations
        evaluations += 1
        if evaluations > MOST_EVALUATIONS:
            raise TooSlow(f"{method} needs more than {MOST_EVALUATIONS} evaluations for a phase")
        return np.concatenate([state[half:], accelerations(walker, state, both_feet)[0]])

    event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
    solution: Any = solve_ivp(
        rates, (0.0, TIME_LIMIT_OF_A_PHASE), y, method=method, rtol=max(tolerance, 3e-14), atol=tolerance,
        events=event, max_step=0.1)
    if not solution.t_events[0].size:
        raise StepFailed("the phase does not end")
    return float(solution.t_events[0][0]), solution.y_events[0][0]


def double_stance(walker: Walker, y: Vector, tolerance: float, method: str = "DOP853") -> tuple[float, Vector]:
    """From heel strike to toe-off, where the trailing foot's normal force falls to zero."""
    if accelerations(walker, y, True)[1][0] <= 0:
        return 0.0, y
    return integrate(
        walker, y, lambda _, state: float(accelerations(walker, state, True)[1][0]), True, tolerance, method)


def single_stance(walker: Walker, y: Vector, tolerance: float, method: str = "DOP853") -> tuple[float, Vector]:
    """From toe-off to heel strike: clearance falls through zero ahead of the stance foot; elsewhere it is scuffing."""
    time = 0.0
    for _ in range(MOST_SCUFFS):
        more, y = integrate(walker, y, lambda _, state: clearance(walker, state), False, tolerance, method)
        time += more
        if advance(walker, y) > (PASSING if walker.rigid else 0.0):
            return time, y
        half = y.size // 2
        qdd, _ = accelerations(walker, y, False)
        y = np.concatenate([y[:half] + STRIDE_ON * y[half:] + STRIDE_ON**2 / 2 * qdd, y[half:] + STRIDE_ON * qdd])
        time += STRIDE_ON
    raise StepFailed("the swing foot scuffs without end")


def heel_strike(walker: Walker, y: Vector) -> Vector:
    """State after the plastic impact, legs renamed: theta+ = -psi, psi+ = -theta, L_1 and L_2 swap."""
    t = terms_of(walker)
    if walker.rigid:
        q = -y[1::-1]
        after = np.concatenate([q, np.zeros(2)])
        return np.concatenate([q, np.linalg.solve(t.mass(after, walker.exchanged.p), t.handover(y, walker.p) @ y[2:])])
    mass, pi = t.mass(y, walker.p), t.constraint_jacobian(y, walker.p)
    qd = np.linalg.solve(held(mass, pi), np.concatenate([mass @ y[4:], np.zeros(2)]))[:4]
    return np.array([-y[2], y[3], -y[0], y[1], -qd[2], qd[3], -qd[0], qd[1]])


def take_step(walker: Walker, z: Vector, tolerance: float, method: str = "DOP853") -> Step:
    """Image of section coordinates `z` after one step, like `poincare_map`. Raises StepFailed if there is none.

    `method` is one of `scipy.integrate.solve_ivp`; stiff legs need "Radau".
    """
    y = section_state(np.asarray(z, dtype=float), walker.p)
    double = 0.0
    if not walker.rigid:
        double, y = double_stance(walker, y, tolerance, method)
    single, y = single_stance(walker, y, tolerance, method)
    y = heel_strike(walker, y)
    return Step(section_coordinates(y, walker.exchanged.p), y, double + single, double, 0)


def derivative(walker: Walker, z: Vector, tolerance: float) -> np.ndarray:
    """Derivative of the step map by central differences; lengths get a step on the scale of the springs' deflection."""
    h = np.full(z.size, 1e-4)
    if not isinstance(walker.p, Rigid):
        h[1:3] = min(1e-4, 1e-3 / walker.p.k)
    columns = [
        (take_step(walker, z + e, tolerance).z - take_step(walker, z - e, tolerance).z) / (2 * e.sum())
        for e in np.diag(h)
    ]
    return np.column_stack(columns)


def refine(walker: Walker, z: Vector, tolerance: float, iterations: int = 6) -> FixedPoint:
    """The gait next to `z` by Newton's method on this map, its multipliers by central differences.

    Raises StepFailed if it does not converge.
    """
    best: FixedPoint | None = None
    for _ in range(iterations):
        step = take_step(walker, z, tolerance)
        residual = float(np.abs(step.z - z).max())
        if best is not None and residual >= best.residual:
            break
        matrix = derivative(walker, z, tolerance)
        best = FixedPoint(z, (step,), matrix, residual)
        z = z + np.linalg.solve(np.eye(z.size) - matrix, step.z - z)
    if best is None or best.residual > max(1e-8, 100 * tolerance):
        raise StepFailed("Newton's method on the SciPy path does not close the gait")
    return best
