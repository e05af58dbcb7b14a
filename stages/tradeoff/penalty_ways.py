"""Ways to walk the planar penalty model in Exudyn: minimal coordinates or joints, several solvers, several grounds."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from stages.biped.design import Biped
from stages.biped.gait import StanceState
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.parameters import Settings
from stages.multibody.walking.limit_cycle import limit_cycle
from stages.multibody.walking.walk import build, simulate
from stages.planar.events import find_events
from stages.planar.limit_cycle import LimitCycle
from stages.planar.run import Run
from stages.planar.section import SCALES, mid_stance_after, section_state
from stages.planar.state import PlanarState, rolling_state
from stages.tradeoff.way import Walked, Way, WayFailed, grid

PENALTY = "penalty model"
TREE, JOINTS = "Exudyn tree, DOPRI5", "Exudyn joints"
#: Rate evaluations of an accepted step of DOPRI5; the joints' implicit steps count one each.
STAGES = 6
#: Difference along the leading eigenvector, in the section's scales, and the tolerance of the gait it belongs to.
ALONG, GAIT_TOLERANCE = 5e-4, 1e-9


@dataclass(frozen=True)
class Scene:
    """The biped on one ground, its mid-stance, and how far it walks."""

    model: str
    biped: Biped
    slope: Slope
    contact: ContactLaw
    settings: Settings
    state: PlanarState
    steps: int

    @cached_property
    def gait(self) -> tuple[LimitCycle, np.ndarray, np.ndarray]:
        """The gait at mid-stance, and its leading right and left eigenvectors with w v = 1."""
        solver = dataclasses.replace(self.settings, assembly="tree", tolerance=GAIT_TOLERANCE, largest_step=2e-3)
        cycle = limit_cycle(self.biped, self.slope, self.contact, self.state, solver, 1e-6, ALONG)
        right, left = leading_pair(cycle.monodromy_matrix)
        return cycle, right, left


def scene(model: str, biped: Biped, slope: Slope, contact: ContactLaw, settings: Settings, start: StanceState,
          force: float, steps: int) -> Scene:
    """The scene that starts from the constraint model's mid-stance, pressed into this ground by `force` [N]."""
    plain = dataclasses.replace(settings, scene="ideal")
    return Scene(model, biped, slope, contact, plain, rolling_state(biped, contact, start, force), steps)


def leading_pair(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Right and left eigenvector (n,) of the eigenvalue largest in magnitude, which must be real, with w v = 1."""
    values, vectors = np.linalg.eig(matrix)
    index = int(np.argmax(np.abs(values)))
    if abs(values[index].imag) > 1e-9:
        raise WayFailed("the leading multiplier is complex")
    right, left = vectors[:, index].real, np.linalg.inv(vectors)[index].real
    return right, left / (left @ right)


def tree_way(at: Scene, tolerance: float, largest_step: float, *, multiplier: bool = False, mark: str = "") -> Way:
    """Minimal coordinates with the adaptive explicit solver."""
    settings = dataclasses.replace(at.settings, assembly="tree", tolerance=tolerance, largest_step=largest_step)
    return way(at, TREE, settings, {"tolerance": tolerance, "largest_step": largest_step}, STAGES, multiplier, mark)


def joints_way(at: Scene, solver: str, rolling: float, impact: float, *, multiplier: bool = False,
               mark: str = "") -> Way:
    """Bodies and joints with fixed implicit steps, finer around heel strike, as in the paper's script."""
    settings = dataclasses.replace(
        at.settings, assembly="joints", implicit_solver=solver, rolling_step=rolling, impact_step=impact)
    setting = {"rolling_step": rolling, "impact_step": impact}
    return way(at, f"{JOINTS}, {solver.replace('_', ' ')}", settings, setting, 1, multiplier, mark)


def way(at: Scene, name: str, settings: Settings, setting: dict[str, Any], stages: int, multiplier: bool,
        mark: str) -> Way:
    """A way whose assembly is built once, so that a second walk costs integration only."""
    built: list[Any] = []

    def run(state: PlanarState, steps: int) -> Run:
        if not built:
            built.append(build(at.biped, at.slope, at.contact, settings))
        done = simulate(at.biped, at.slope, at.contact, state, settings, steps=steps, assembly=built[0])
        if not done.completed:
            raise WayFailed(done.message or done.outcome)
        return done

    def integrate() -> Run:
        return run(at.state, at.steps)

    def walk() -> Walked:
        done = integrate()
        strikes = find_events(done.trajectory, at.biped.foot_radius).heel_strike_time
        hip = done.trajectory.at(grid(float(done.trajectory.time[-1])))[0][:, :2]
        peak = float(done.trajectory.ground_reaction[:, :, 1].max())
        cost = stages * done.solver_steps / at.steps
        return Walked(hip, float(strikes[-1]), float(strikes[-1] - strikes[-2]), peak, cost)

    def leading() -> float:
        """w (P(z + e v) - P(z - e v)) / 2e: exact to second order in what the eigenvectors are off."""
        cycle, right, left = at.gait
        size = ALONG / float(np.abs(right / SCALES).max())
        ends = [mid_stance_after(run(section_state(cycle.section_state + sign * size * right, at.state), 1)).numbers
                for sign in (1.0, -1.0)]
        return abs(float(left @ (ends[0] - ends[1]) / (2 * size)))

    return Way(at.model, name, setting, integrate, walk, leading if multiplier else None, mark)
