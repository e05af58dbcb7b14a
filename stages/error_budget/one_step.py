"""The budget over one step that all models start from the same mid-stance state."""

from __future__ import annotations

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.engines.walks import Machine
from stages.error_budget.convergence import Convergence
from stages.error_budget.errors import NotWalked
from stages.error_budget.parameters import Parameters
from stages.error_budget.path import ConstraintWalk, Limits, constraint_gait, contributions, penalty_hip
from stages.error_budget.split import Split
from stages.ground.contact_law import ContactLaw
from stages.penalty.settings import Settings
from stages.penalty.walk import simulate
from stages.planar.events import find_events
from stages.planar.state import rolling_state


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
