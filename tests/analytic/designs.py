"""Designs the tests walk with."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from stages.analytic import run as stage
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import FixedPoint, fixed_point
from stages.analytic.gait.search_starts import lengths_after_heel_strike
from stages.analytic.model.kinds import Kind
from stages.analytic.model.walker import Vector, Walker, build_walker
from stages.analytic.parameters import Parameters
from stages.analytic.phases.guards import foot_clearance
from stages.analytic.phases.section import section_state
from stages.analytic.result import Result
from stages.biped.design import Biped
from stages.biped.rubber import Rubber
from stages.ground.slope import Friction, Slope
from tests.study import SLOPE, TABLE_1

TABLE_1_RIGID = dataclasses.replace(TABLE_1, legs="rigid")
#: Every parameter at work: leg inertia too.
HEAVY_LEGS = dataclasses.replace(TABLE_1, leg_inertia=2e-3)
FRICTION = Friction(static_friction=1.1, dynamic_friction=1.0)
RUBBER = Rubber(foot_width=0.02, outsole_arc=0.112, outsole_density=1100.0)


def changed(design: Biped, **values: object) -> Biped:
    """The design with some parameters replaced."""
    return dataclasses.replace(design, **values)  # type: ignore[arg-type]


def walker_of(design: Biped = TABLE_1, slope_deg: float = 2.0) -> Walker:
    """The dimensionless walker of a design on Earth."""
    return build_walker(design, Slope(slope_deg=slope_deg, gravity=9.81))


@cache
def found_gait(design: Biped, friction: Friction | None = None) -> tuple[Walker, FixedPoint]:
    """Walker and most stable gait of a design on SLOPE, at tolerance 1e-12, searched for once for all tests.

    With friction it is the gait beside that of rolling feet. Whoever writes into its arrays takes a copy.
    """
    if friction is not None:
        return gait_beside(design, np.append(found_gait(design)[1].z, [0.0, 0.0]), friction)
    return gait_beside(design, find_gait(design, SLOPE, 1e-8)[1].z)


def gait_beside(
    design: Biped, near: Vector, friction: Friction | None = None, tolerance: float = 1e-12
) -> tuple[Walker, FixedPoint]:
    """Walker and gait of a design on SLOPE by Newton's method from another's coordinates: a tenth of a search."""
    walker = build_walker(design, SLOPE, friction)
    point = fixed_point(walker, near, tolerance)
    assert point is not None
    return walker, point


def stiff_gait(design: Biped, tolerance: float) -> tuple[Walker, FixedPoint]:
    """Walker and gait of a design with stiff legs on SLOPE: beside that of rigid ones."""
    lengths = lengths_after_heel_strike(build_walker(design, SLOPE).p)
    return gait_beside(design, np.array([-0.2772, *lengths, 0.475, -0.2057]), tolerance=tolerance)


def run_alone(parameters: Parameters) -> Result:
    """The stage's result but for the gaits of neighbouring designs, which take two thirds of its time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stage, "vary_design", lambda *_: ())
        patch.setattr(stage, "outsole_effect", lambda *_: None)
        return stage.run(parameters)


def random_states(walker: Walker, count: int, seed: int = 0) -> np.ndarray:
    """Unconstrained states in the range a gait passes through, shape (count, size)."""
    rng = np.random.default_rng(seed)
    if walker.rigid:
        return rng.uniform([-0.5, -0.6, -1.0, -2.0], [0.5, 0.6, 1.0, 2.0], (count, 4))
    low = [-0.5, 0.95, -0.6, 0.95, -1.0, -0.3, -2.0, -0.3]
    high = [0.5, 1.05, 0.6, 1.05, 1.0, 0.3, 2.0, 0.3]
    return rng.uniform(low, high, (count, 8))


def double_stance_states(walker: Walker, count: int, seed: int = 0) -> np.ndarray:
    """States of a compliant walker that keep the trailing foot on the ground and rolling, shape (count, 8)."""
    rng = np.random.default_rng(seed)
    low, high = [-0.45, 0.985, 0.99, 0.1, -0.3], [-0.25, 1.01, 1.01, 0.8, 0.1]
    return np.array([section_state(z, walker.p) for z in rng.uniform(low, high, (count, 5))])


def clearance(y: Vector, p: Kind) -> tuple[float, float, float]:
    """Height of the swing foot above the ground, its rate, and its advance on the stance foot."""
    return foot_clearance(y, p, y, y.size // 2)
