"""Ways to walk with penalty contact: the planar model compiled or in Exudyn, by minimal coordinates or joints, and the
spatial twin at several tolerances, its ground compiled or made of connectors.
"""

from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import Any

import numpy as np

from stages.analytic.errors import StepFailed
from stages.biped.design import Biped
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.parameters import Settings
from stages.multibody.walking.cycle import SectionWalker
from stages.multibody.walking.walk import build, simulate
from stages.penalty.walk import Settings as CompiledSettings
from stages.planar.limit_cycle import gait_near
from stages.planar.run import LimitCycle, PlanarState, Run
from stages.planar.sampling import find_events, peaks
from stages.planar.section import mid_stance_after, section_scales, section_state
from stages.planar.signals import GROUND_REACTION
from stages.studies.walks import Upright
from stages.tradeoff.way import Walked, Way, grid
from stages.twin.machine.contact import X, Y
from stages.twin.machine.projection import machine_of
from stages.twin.machine.tree import SpatialTree
from stages.twin.parameters import Settings as TwinSettings
from stages.twin.walking.record import Record, find_events as find_spatial_events, peak_force
from stages.twin.walking.simulate import rolling_start, simulate_twin

PENALTY = "penalty model"
TREE, JOINTS, COMPILED = "Exudyn tree, DOPRI5", "Exudyn joints", "compiled"
#: Moments between two steps of the compiled walker at which it keeps the ground's force.
BETWEEN = 3
#: Difference along the leading eigenvector, in the section's scales, and the tolerance of the gait it belongs to.
ALONG, GAIT_TOLERANCE = 5e-4, 1e-9
TWIN, SPACE, CONNECTORS = "twin", "Exudyn tree in space, DOPRI5", "Exudyn tree in space, DOPRI5, eight connectors"


@dataclass(frozen=True)
class Scene:
    """A model on ground with one contact law: where its walks begin, and settings of how they are integrated."""

    model: str
    upright: Upright
    contact: ContactLaw
    planar: Settings
    twin: TwinSettings
    steps: int

    @property
    def ground(self) -> tuple[Biped, Slope, ContactLaw]:
        """The biped, and what it walks on."""
        return self.upright.biped, self.upright.slope, self.contact

    @property
    def state(self) -> PlanarState:
        """The mid-stance in the plane."""
        return self.upright.start(self.contact)

    @cached_property
    def gait(self) -> tuple[LimitCycle, np.ndarray, np.ndarray]:
        """The gait at mid-stance, and its leading right and left eigenvectors with w v = 1."""
        solver = replace(
            self.planar, scene="ideal", assembly="tree", tolerance=GAIT_TOLERANCE, largest_step=2e-3)
        cycle = gait_near(SectionWalker(*self.ground, self.state, solver, ALONG), self.state)
        right, left = leading_pair(cycle.monodromy_matrix)
        return cycle, right, left


def leading_pair(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Right and left eigenvector (n,) of the eigenvalue largest in magnitude, which must be real, with w v = 1."""
    values, vectors = np.linalg.eig(matrix)
    index = int(np.argmax(np.abs(values)))
    if abs(values[index].imag) > 1e-9:
        raise StepFailed("the leading multiplier is complex")
    right, left = vectors[:, index].real, np.linalg.inv(vectors)[index].real
    return right, left / (left @ right)


def tree_way(at: Scene, tolerance: float, largest_step: float, *, multiplier: bool = False, mark: str = "") -> Way:
    """Minimal coordinates with the adaptive explicit solver."""
    setting: dict[str, Any] = {"tolerance": tolerance, "largest_step": largest_step}
    return way(at, TREE, replace(at.planar, assembly="tree", **setting), setting, multiplier, mark)


def joints_way(at: Scene, solver: str, rolling: float, impact: float, *, multiplier: bool = False,
               mark: str = "") -> Way:
    """Bodies and joints with fixed implicit steps, finer around heel strike, as in the paper's script."""
    setting: dict[str, Any] = {"rolling_step": rolling, "impact_step": impact}
    settings = replace(at.planar, assembly="joints", implicit_solver=solver, **setting)
    return way(at, f"{JOINTS}, {solver.replace('_', ' ')}", settings, setting, multiplier, mark)


def penalty_way(at: Scene, tolerance: float, *, multiplier: bool = False) -> Way:
    """The compiled penalty walker, with the exact derivative of its own step."""
    settings = CompiledSettings(tolerance, BETWEEN)

    def integrate() -> Run:
        bare = replace(settings, between=0)
        return finished(at.upright.walk(at.contact, bare, steps=at.steps, signals=()))

    def walk() -> Walked:
        return measured(at, finished(
            at.upright.walk(at.contact, settings, steps=at.steps, signals=(GROUND_REACTION,))))  # fmt: skip

    def leading() -> float:
        found = gait_near(at.upright.stepper(at.contact, settings), at.state)
        return float(np.hypot(*found.floquet_multipliers[0]))

    return Way(at.model, COMPILED, {"tolerance": tolerance}, integrate, walk, leading if multiplier else None)


def finished(run: Run) -> Run:
    """The run, if it got to its end. Raises StepFailed."""
    if not run.completed:
        raise StepFailed(run.message or run.outcome)
    return run


def measured(at: Scene, run: Run) -> Walked:
    """What is compared of a run."""
    radii = at.upright.biped.foot_radii
    strikes = find_events(run.trajectory, radii).heel_strike_time
    hip = run.trajectory.at(grid(float(run.trajectory.time[-1])))[0][:, :2]
    ends = run.trajectory.time[[0, -1]].tolist()
    peak = float(peaks(run.trajectory, at.contact, radii, *ends)[0].max())
    return Walked(hip, float(strikes[-1]), float(strikes[-1] - strikes[-2]), peak, run.evaluations / at.steps)


def way(at: Scene, name: str, settings: Settings, setting: dict[str, Any], multiplier: bool, mark: str) -> Way:
    """A way whose assembly is built once, so that a second walk costs integration only."""
    settings = replace(settings, scene="ideal")
    built = cache(partial(build, *at.ground, settings))

    def run(state: PlanarState, steps: int) -> Run:
        return finished(simulate(*at.ground, state, settings, steps=steps, assembly=built()))

    integrate = partial(run, at.state, at.steps)

    def walk() -> Walked:
        return measured(at, integrate())

    def leading() -> float:
        """w (P(z + e v) - P(z - e v)) / 2e: exact to second order in what the eigenvectors are off."""
        cycle, right, left = at.gait
        size = ALONG / float(np.abs(right / section_scales(at.upright.biped, at.upright.slope)).max())
        ends = [mid_stance_after(run(section_state(cycle.section_state + sign * size * right, at.state), 1)).numbers
                for sign in (1.0, -1.0)]
        return abs(float(left @ (ends[0] - ends[1]) / (2 * size)))

    return Way(at.model, name, setting, integrate, walk, leading if multiplier else None, mark)


def twin_way(at: Scene, tolerance: float, largest_step: float, kind: type[SpatialTree] = SpatialTree,
             mark: str = "") -> Way:
    """The twin at one tolerance and largest step [s]. Raises ValueError if its parts do not add up to the design."""
    settings = replace(at.twin, tolerance=tolerance, largest_step=largest_step)
    machine, ground = machine_of(at.upright.biped, at.twin), (at.upright.slope, at.contact)
    start = rolling_start(machine, at.contact, at.upright.mid_stance, at.upright.standing_force)
    built = cache(partial(kind, machine, *ground))

    def integrate() -> Record:
        return simulate_twin(machine, *ground, start, settings, steps=at.steps, tree=built())

    def walk() -> Walked:
        record = integrate()
        if not record.completed:
            raise StepFailed(record.reason or record.outcome)
        strikes = find_spatial_events(record).heel_strike_time
        hip = record.at(grid(float(record.time[-1])))[0][:, [X, Y]]
        peak, cost = peak_force(record), record.evaluations / at.steps
        return Walked(hip, float(strikes[-1]), float(strikes[-1] - strikes[-2]), peak, cost)

    name = SPACE if kind is SpatialTree else CONNECTORS
    return Way(at.model, name, {"tolerance": tolerance, "largest_step": largest_step}, integrate, walk, None, mark)
