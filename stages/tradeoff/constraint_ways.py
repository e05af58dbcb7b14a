"""Ways to walk the constraint model: compiled code and SciPy's integrators, rolling or with limited friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import fixed_point, iterate, multipliers_of, poincare_map
from stages.analytic.model.walker import Vector, Walker, build_walker
from stages.analytic.phases.flow import DOUBLE_STANCE, SINGLE_STANCE
from stages.analytic.phases.section import section_coordinates, section_state
from stages.analytic.phases.succession import succeed
from stages.analytic.walk.recording import Segment, crossing_state, is_last, record
from stages.analytic.walk.sampling import sample_walk
from stages.analytic.walk.validity import FEET, NORMAL, Phase
from stages.biped.design import Biped
from stages.biped.gait import StanceState
from stages.ground.friction_coefficients import Friction
from stages.ground.slope import Slope
from stages.tradeoff.scipy_walk import Rates, compiled_rates, walk_by_scipy
from stages.tradeoff.way import GRID_HZ, Walked, Way, WayFailed

ROLLING, COULOMB = "constraint model, rolling", "constraint model, coulomb"
DETAILED = "detailed constraint model"
#: Steps of the differences for SciPy's multiplier at a tight tolerance: lengths change less than springs do.
DIFFERENCE = np.array([3e-5, 3e-6, 3e-6, 3e-5, 3e-5])
#: Those of them that rigid legs have: an angle and two rates.
ANGLES = [0, 3, 4]
SETTLING_STEPS = 12


@dataclass(frozen=True)
class Scene:
    """The walker, the mid-stance all walk from, the gait's section coordinates, and the number of steps."""

    model: str
    walker: Walker
    upright: Vector
    gait: Vector
    steps: int


def scene(biped: Biped, slope: Slope, friction: Friction | None, upright: StanceState, steps: int) -> Scene:
    """The scene of one kind of trailing foot; its gait is found by walking on from the mid-stance given.

    Raises WayFailed if no gait is found.
    """
    walker = build_walker(biped, slope, friction)
    y = walker.from_stance(upright)
    try:
        after = record(walker, y, SETTLING_STEPS, 1e-12, SINGLE_STANCE)[-1].end
        succeed(SINGLE_STANCE, after, walker.p)
        point = fixed_point(walker, section_coordinates(after, walker.p), 1e-14)
    except StepFailed as reason:
        raise WayFailed(str(reason)) from None
    if point is None:
        raise WayFailed("Newton's method finds no gait next to the mid-stance given")
    return Scene(ROLLING if friction is None else COULOMB, walker, y, point.z, steps)


def detailed_scene(biped: Biped, slope: Slope, steps: int) -> Scene:
    """The scene of a detailed design with rolling feet, from mid-stance of its own gait. Raises WayFailed."""
    try:
        walker, point = find_gait(biped, slope, 1e-13)
        return Scene(DETAILED, walker, crossing_state(walker, point.z, 1e-13), point.z, steps)
    except (NoGait, StepFailed) as reason:
        raise WayFailed(str(reason)) from None


def compiled_way(at: Scene, tolerance: float, mark: str = "") -> Way:
    """The compiled integrator of order 8 at a tolerance, with exact multipliers."""

    def integrate() -> list[Segment]:
        return record(at.walker, at.upright, at.steps, tolerance, SINGLE_STANCE)

    def walk() -> Walked:
        try:
            segments = integrate()
            step = poincare_map(at.walker, at.gait, tolerance)
        except StepFailed as reason:
            raise WayFailed(str(reason)) from None
        return measured(at.walker, segments, step.evaluations)

    def multiplier() -> float:
        _, derivative = iterate(at.walker, at.gait, at.walker.gait_steps, tolerance)
        return float(np.abs(multipliers_of(derivative))[0])

    return Way(at.model, "compiled", {"tolerance": tolerance}, integrate, walk, multiplier, mark)


def scipy_way(
    at: Scene, name: str, methods: Mapping[int, str], tolerance: float, rates: Rates = compiled_rates, *,
    multiplier: bool = False, mark: str = "",
) -> Way:  # fmt: skip
    """SciPy's integrators; if asked, where the foot rolls, with a multiplier by central differences."""
    walk_from = partial(walk_by_scipy, at.walker, methods=methods, tolerance=tolerance, rates=rates)

    def integrate() -> tuple[list[Segment], Vector, int]:
        return walk_from(at.upright, at.steps)

    def walk() -> Walked:
        segments, _, evaluations = integrate()
        return measured(at.walker, segments, evaluations / at.steps)

    def step(z: Vector) -> Vector:
        _, end, _ = walk_from(section_state(z, at.walker.p), 1, phase=None)
        return np.asarray(section_coordinates(end, at.walker.p))

    def by_differences() -> float:
        columns = [(step(at.gait + change) - step(at.gait - change)) / (2 * change.sum())
                   for change in np.diag(DIFFERENCE[ANGLES] if at.walker.rigid else DIFFERENCE)]
        return float(np.abs(multipliers_of(np.column_stack(columns)))[0])

    measures = by_differences if multiplier and at.walker.rolls else None
    return Way(at.model, name, {"tolerance": tolerance}, integrate, walk, measures, mark)


def everywhere(method: str) -> dict[int, str]:
    """One method of SciPy for all phases."""
    return {SINGLE_STANCE: method, DOUBLE_STANCE: method}


def measured(walker: Walker, segments: list[Segment], cost: float) -> Walked:
    """What is compared of a walk."""
    walk = sample_walk(walker, segments, GRID_HZ)
    strikes = walk.heel_strike_time
    return Walked(walk.hip_position[: int(strikes[-1] * GRID_HZ)], float(strikes[-1]), float(strikes[-1] - strikes[-2]),
                  peak_force(walker, segments), float(cost))


def peak_force(walker: Walker, segments: list[Segment]) -> float:
    """Largest normal force on a foot [N]."""
    phases = [Phase(walker.on(segment.stance_leg), segment) for segment in segments
              if not (is_last(segment) and segment is segments[0])]

    def normal(_: np.ndarray, f: np.ndarray, foot: slice) -> np.ndarray:
        return np.asarray(f[:, foot][:, NORMAL])

    return max(phase.largest(partial(normal, foot=foot))[1] for phase in phases for foot in FEET) * walker.force
