"""The budget between converged cycles, at equal phase over one stride from heel strike."""

from __future__ import annotations

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.engines.walks import Machine
from stages.error_budget.convergence import Convergence
from stages.error_budget.effects import CONTACT
from stages.error_budget.errors import NotWalked
from stages.error_budget.parameters import Parameters
from stages.error_budget.path import LIMITS, ConstraintWalk, Limits, constraint_gait, contributions, penalty_hip
from stages.error_budget.split import Split
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import static_penetration
from stages.penalty.settings import Settings
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import simulate
from stages.planar.events import find_events
from stages.planar.limit_cycle import fixed_point
from stages.planar.section import NoLimitCycle, section_numbers, section_state
from stages.planar.state import rolling_state
from stages.planar.trajectory import Trajectory


class OneStep:
    """The scene of all walks: the constraint model's mid-stance state and the times of its step."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters, settings = parameters, parameters.settings
        self.constraint = constraint_gait(parameters.biped, parameters.slope, parameters.constraint_tolerance)
        self.time = np.linspace(0.0, self.constraint.period, settings.points)
        self.strikes = [float(self.constraint.heel_strikes[0])]

    def coarse_or_fine(self, tolerance: float, coulomb: bool = False) -> np.ndarray:
        """The constraint model's hip from the common state at a tolerance, (n, 4); `coulomb`: the foot may slip."""
        p, gait = self.parameters, self.constraint
        design = DesignPoint(p.biped, p.slope, p.contact.coefficients if coulomb else None)
        walk = ConstraintWalk(design.walker(), gait.point, tolerance, gait.start)
        self.strikes.append(float(walk.heel_strikes[0]))
        return walk.hip(self.time)

    def penalty(self, law: ContactLaw, tolerance: float) -> np.ndarray:
        """The penalty model's hip from the common state, (n, 4). Raises NotWalked."""
        p = self.parameters
        start = rolling_state(p.biped, law, self.constraint.mid_stance, self.constraint.standing_force)
        run = simulate(
            p.biped, p.slope, law, start, Settings(tolerance), duration=float(self.time[-1]), signals=())
        strikes = find_events(run.trajectory, p.biped.foot_radii).heel_strike_time
        if not run.completed or not len(strikes):
            raise NotWalked(f"over one step: {run.message or run.outcome}")
        self.strikes.append(float(strikes[0]))
        return penalty_hip(run.trajectory, self.time)

    def exudyn(self, law: ContactLaw, tolerance: float) -> np.ndarray:
        """The same of Exudyn's model. Raises NotWalked."""
        start = rolling_state(self.parameters.biped, law, self.constraint.mid_stance, self.constraint.standing_force)
        run = self.machine(law).exudyn(start, tolerance, 1, float(self.time[-1]))
        if not run.completed:
            raise NotWalked(f"over one step, in Exudyn: {run.message or run.outcome}")
        return penalty_hip(run.trajectory, self.time)

    def machine(self, law: ContactLaw) -> Machine:
        """The biped on this ground, for both engines."""
        p = self.parameters
        return Machine(p.biped, p.slope, law, p.checked_tolerance)

    def compared(self) -> np.ndarray:
        """Times outside the span in which only some of the models have had their impact, (n,)."""
        end = max(self.strikes) + self.parameters.settings.impact_window
        return (self.time < min(self.strikes)) | (self.time > end)


def step_budget(scene: OneStep) -> tuple[np.ndarray, Split, Convergence, np.ndarray]:
    """Times (n,), the budget, how its limits converge, and the hip's largest integration error at the paper's
    tolerances, of the constraint model and of Exudyn's (2, 4). Raises NotWalked, NoGait, StepFailed.
    """
    parameters, settings, law = scene.parameters, scene.parameters.settings, scene.parameters.contact
    limits = Limits(law, settings.step_share, scene.penalty, parameters.penalty_tolerance, settings.limit_tolerance)
    coarse = scene.coarse_or_fine(parameters.constraint_tolerance)
    fine = scene.coarse_or_fine(settings.constraint_fine_tolerance)
    coulomb = scene.coarse_or_fine(settings.constraint_fine_tolerance, coulomb=True)
    fine_penalty = scene.penalty(law, settings.penalty_fine_tolerance)
    paper = (
        scene.coarse_or_fine(settings.paper_constraint_tolerance) - fine,
        scene.exudyn(law, settings.paper_penalty_tolerance) - fine_penalty,
    )
    parts, interaction = contributions(coarse, fine, coulomb, limits, fine_penalty)
    compared = scene.compared()
    largest = np.array(
        [[*np.abs(curve[:, :2]).max(axis=0), *np.abs(curve[compared, 2:]).max(axis=0)] for curve in paper]
    )
    convergence = limits.convergence(lambda outcome: outcome, compared)
    return scene.time, Split(parts, interaction, compared), convergence, largest


#: Scalars of a cycle, in s and m.
SCALARS = ("step period", "step length")


class Cycles:
    """Cycles of all models as one array each: the hip over a stride (4 n values), then the `SCALARS`."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters, settings = parameters, parameters.settings
        self.phase = np.linspace(0.0, 1.0, settings.points)
        self.rolling = constraint_gait(parameters.biped, parameters.slope, settings.constraint_fine_tolerance)
        friction = parameters.contact.coefficients
        self.coulomb = constraint_gait(parameters.biped, parameters.slope, settings.constraint_fine_tolerance, friction)
        self.found: list[tuple[ContactLaw, np.ndarray]] = []
        self.derivative: np.ndarray | None = None

    def flat(self, hip: np.ndarray, period: float, length: float) -> np.ndarray:
        """One array of the hip over a step (n, 4) as it is at twice the phase, and the scalars."""
        return np.concatenate([hip.ravel(), [period, length]])

    def stride(self, length: float) -> tuple[np.ndarray, np.ndarray]:
        """Fraction of the step at each phase of the stride, and how far the hip has come by the steps before [m]."""
        second = self.phase >= 0.5
        return 2.0 * self.phase - second, length * second

    def constraint(self, walk: ConstraintWalk) -> np.ndarray:
        """The constraint model's cycle."""
        first, second = walk.heel_strikes
        ends = walk.hip(np.array([first, second]))
        length = float(ends[1, 0] - ends[0, 0])
        share, passed = self.stride(length)
        hip = walk.hip(first + share * walk.period)
        hip[:, 0] += passed - ends[0, 0]
        return self.flat(hip, walk.period, length)

    def penalty(self, law: ContactLaw, tolerance: float) -> np.ndarray:
        """The penalty model's cycle, searched from that of the law most like it. Raises NotWalked."""
        p, solver = self.parameters, Settings(tolerance)
        force = self.coulomb.standing_force
        start = rolling_state(p.biped, law, self.coulomb.mid_stance, force)
        stepper = PenaltyStepper(p.biped, p.slope, law, start, solver)
        guess = section_numbers(start)
        if self.found:
            near, known = min(self.found, key=lambda other: _distance(other[0], law))
            guess = known.copy()
            guess[0] += static_penetration(near, force) - static_penetration(law, force)
        try:
            cycle = fixed_point(stepper, guess, self.derivative)
        except NoLimitCycle as reason:
            raise NotWalked(f"on a cycle: {reason}") from None
        self.derivative = cycle.derivative
        self.found.append((law, cycle.numbers))
        run = simulate(p.biped, p.slope, law, section_state(cycle.numbers, start), solver, steps=1, signals=())
        hip = self.folded(run.trajectory, cycle.step.duration, cycle.step.length)
        return self.flat(hip, cycle.step.duration, cycle.step.length)

    def folded(self, trajectory: Trajectory, period: float, length: float) -> np.ndarray:
        """The hip over a stride from heel strike, from a step of a cycle from mid-stance to mid-stance, (n, 4)."""
        strike = float(find_events(trajectory, self.parameters.biped.foot_radii).heel_strike_time[0])
        share, passed = self.stride(length)
        time = strike + share * period
        later = time >= period
        hip = penalty_hip(trajectory, np.where(later, time - period, time))
        hip[:, 0] += passed + length * later - penalty_hip(trajectory, np.array([strike]))[0, 0]
        return hip

    def compared(self) -> np.ndarray:
        """Phases more than the impact's window after a heel strike, and not in the instant of one, (n,)."""
        since = self.stride(0.0)[0] * self.rolling.period
        return (since > self.parameters.settings.impact_window) & (self.phase < 1.0)


def _distance(one: ContactLaw, other: ContactLaw) -> float:
    """How unlike two laws are in stiffness and stiction velocity."""
    ratios = one.contact_stiffness / other.contact_stiffness, one.stiction_velocity / other.stiction_velocity
    return float(np.abs(np.log(ratios)).sum())


def cycle_budget(
    parameters: Parameters, coarse: ConstraintWalk
) -> tuple[np.ndarray, Split, np.ndarray, np.ndarray, Convergence, np.ndarray]:
    """Phases (n,), the budget of the hip, that of the `SCALARS` (6, 2) with their interaction (2,), how the limits of
    the hip converge, and the constraint model's scalars (2,). `coarse` is its gait at its usual tolerance.

    Raises NotWalked, NoGait, StepFailed.
    """
    cycles, settings, law = Cycles(parameters), parameters.settings, parameters.contact
    limits = Limits(law, settings.cycle_share, cycles.penalty, parameters.penalty_tolerance, settings.limit_tolerance)
    for on in LIMITS:  # the nodes first, so that each search starts close to its cycle
        limits.at(on)
    limits.at(frozenset(CONTACT))
    fine_penalty = cycles.penalty(law, settings.penalty_fine_tolerance)
    start = cycles.constraint(coarse)
    rolling, coulomb = cycles.constraint(cycles.rolling), cycles.constraint(cycles.coulomb)
    parts, interaction = contributions(start, rolling, coulomb, limits, fine_penalty)
    count, compared = len(SCALARS), cycles.compared()

    def hip(outcome: np.ndarray) -> np.ndarray:
        return outcome[..., :-count].reshape(*outcome.shape[:-1], -1, 4)

    split = Split(hip(parts), hip(interaction), compared)
    convergence = limits.convergence(hip, compared)
    return cycles.phase, split, parts[:, -count:], interaction[-count:], convergence, start[-count:]
