"""The budget between converged cycles, at equal phase over one stride from heel strike."""

from __future__ import annotations

import numpy as np

from stages.error_budget.effects import CONTACT
from stages.error_budget.errors import NotWalked
from stages.error_budget.hip import ConstraintWalk, constraint_gait, penalty_hip
from stages.error_budget.parameters import Parameters
from stages.error_budget.path import Limits, contributions
from stages.error_budget.split import Split
from stages.ground.contact_law import ContactLaw
from stages.ground.normal_force import static_penetration
from stages.multibody.assembly.state import rolling_state
from stages.multibody.parameters import Settings
from stages.multibody.walking.events import find_events
from stages.multibody.walking.plane_cycle import find_cycle, plane_multipliers
from stages.multibody.walking.section import SCALES, NoLimitCycle, SectionStep, mid_stance_after, section_numbers
from stages.multibody.walking.section import section_state as state_of
from stages.multibody.walking.trajectory import Trajectory
from stages.multibody.walking.walk import build, simulate

#: Scalars of a cycle: step period [s], step length [m], the positive and the negative of its two largest multipliers.
SCALARS = ("step period", "step length", "leading multiplier", "second multiplier")


class Cycles:
    """Cycles of all models as one array each: the hip over a stride (4 n values), then the `SCALARS`."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters, settings = parameters, parameters.settings
        self.phase = np.linspace(0.0, 1.0, settings.points)
        self.rolling = constraint_gait(parameters.biped, parameters.slope, settings.constraint_fine_tolerance)
        friction = parameters.contact.coefficients
        self.coulomb = constraint_gait(parameters.biped, parameters.slope, settings.constraint_fine_tolerance, friction)
        self.guess: tuple[np.ndarray, ContactLaw] | None = None
        self.derivative: np.ndarray | None = None

    def flat(self, hip: np.ndarray, period: float, length: float, multipliers: np.ndarray) -> np.ndarray:
        """One array of the hip over a step (n, 4) as it is at twice the phase, and the scalars."""
        return np.concatenate([hip.ravel(), [period, length], multipliers])

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
        return self.flat(hip, walk.period, length, np.sort(walk.point.floquet_multipliers[:2].real)[::-1])

    def penalty(self, law: ContactLaw, tolerance: float) -> np.ndarray:
        """The penalty model's cycle, searched from the last one found. Raises NotWalked."""
        p, settings = self.parameters, self.parameters.settings
        solver = Settings.of_one_step(tolerance, settings.largest_step)
        machine = build(p.biped, p.slope, law, solver, signals=())
        force = self.coulomb.standing_force
        start = rolling_state(p.biped, law, self.coulomb.mid_stance, force)
        trajectories: list[Trajectory] = []

        def walk(numbers: np.ndarray) -> SectionStep:
            run = simulate(p.biped, p.slope, law, state_of(numbers, start), solver, steps=1, assembly=machine)
            trajectories[:] = [run.trajectory]
            return mid_stance_after(run)

        if self.guess is None:
            guess = section_numbers(start) / SCALES
        else:
            guess = self.guess[0].copy()
            guess[0] += (static_penetration(self.guess[1], force) - static_penetration(law, force)) / SCALES[0]
        try:
            cycle = find_cycle(walk, guess, settings.residual, settings.perturbation, self.derivative)
            on_cycle = trajectories[0]
            multipliers, self.derivative = plane_multipliers(walk, cycle, settings.perturbation)
        except NoLimitCycle as reason:
            raise NotWalked(f"on a cycle: {reason}") from None
        self.guess = cycle.state, law
        hip = self.folded(on_cycle, cycle.step.duration, cycle.step.length)
        return self.flat(hip, cycle.step.duration, cycle.step.length, multipliers)

    def folded(self, trajectory: Trajectory, period: float, length: float) -> np.ndarray:
        """The hip over a stride from heel strike, from a step of a cycle from mid-stance to mid-stance, (n, 4)."""
        strike = float(find_events(trajectory, self.parameters.biped.foot_radius).heel_strike_time[0])
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


def cycle_budget(parameters: Parameters) -> tuple[np.ndarray, Split, np.ndarray, np.ndarray]:
    """Phases (n,), the budget of the hip, that of the `SCALARS` (7 contributions, 4) and the constraint model's (4,).

    Raises NotWalked, NoGait, StepFailed.
    """
    cycles, settings, law = Cycles(parameters), parameters.settings, parameters.contact
    limits = Limits(law, settings.cycle_share, cycles.penalty, settings.penalty_tolerance, settings.limit_tolerance)
    for count in range(len(CONTACT) + 1):  # along the path, so that each search starts close to its cycle
        limits.at(frozenset(CONTACT[:count]))
    fine_penalty = cycles.penalty(law, settings.penalty_fine_tolerance)
    coarse = constraint_gait(parameters.biped, parameters.slope, settings.constraint_tolerance)
    start = cycles.constraint(coarse)
    parts = contributions(
        start, cycles.constraint(cycles.rolling), cycles.constraint(cycles.coulomb), limits, fine_penalty, CONTACT
    )
    count = len(SCALARS)
    split = Split(parts[:, :-count].reshape(len(parts), -1, 4), cycles.compared())
    return cycles.phase, split, parts[:, -count:], start[-count:]
