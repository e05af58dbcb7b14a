"""Analytic stage: the gait of the constraint model and a walk on it.

Inputs: none. Settings: params/analytic.yaml, the rubber of twin.yaml. Output: `Result`, eqs. (1)-(8) of the paper.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.derivatives.numbers import sensitive_names
from stages.analytic.derivatives.uncertainty import elasticities_of, uncertainties_of
from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_report import GaitReport, report_gait
from stages.analytic.gait.gait_search import describe, find_gait
from stages.analytic.gait.poincare import FixedPoint, fixed_point
from stages.analytic.integration.integrator import STAGES, take_step
from stages.analytic.model.kinds import Rigid
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.parameters import Parameters, Settings
from stages.analytic.phases.guards import foot_clearance
from stages.analytic.phases.motion import DOUBLE_STANCE, contact_directions, flow, in_contact
from stages.analytic.result import (
    Elasticities,
    NumericalError,
    OutsoleEffect,
    Result,
    Uncertainty,
    Variation,
    WithoutImpact,
)
from stages.analytic.walk.error_estimate import estimate_errors, not_given
from stages.analytic.walk.recording import Segment, constraint_drift
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.biped.accuracy.estimate import to_accuracy, walk_differences
from stages.biped.accuracy.tolerances import FINEST, scaled
from stages.biped.design import Biped
from stages.biped.processes import Progress, ignore
from stages.biped.rubber import FEET, Rubber, soled
from stages.biped.walk import StanceState, Walk

STEPS = 100


def without_impact(walker: Walker, segments: list[Segment]) -> WithoutImpact:
    """From the segments of a gait's steps, heel strike to heel strike: the last landing foot before and after."""
    single, begun = segments[-1], max((n + 1 for n, one in enumerate(segments[:-1]) if one.last), default=0)
    p = walker.on(single.stance_leg).p
    duration = sum(segment.duration for segment in segments[begun:] if in_contact(segment.phase))
    if isinstance(p, Rigid):
        return WithoutImpact(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    state, new, stages = single.end.copy(), np.empty(walker.size), np.empty((STAGES, walker.size))

    def landing_foot(y: np.ndarray) -> tuple[float, float, float]:
        clearance, rate, _ = foot_clearance(y, p, y, 4)
        return float(np.dot(contact_directions(y, p)[1], y[4:8])), -float(rate), -float(clearance)

    slip, descent, _ = landing_foot(state)
    for _ in range(STEPS):  # far below a hundredth of the legs' own period: exact to round-off without error control
        flow(DOUBLE_STANCE, state, p, stages[0])
        take_step(DOUBLE_STANCE, state, duration / STEPS, p, stages, new)
        state, new = new, state
    slip_then, descent_then, depth = landing_foot(state)
    speed = walker.length / walker.time
    return WithoutImpact(
        duration=duration * walker.time,
        slip_at_landing=slip * speed,
        descent_at_landing=descent * speed,
        slip_at_end=slip_then * speed,
        descent_at_end=descent_then * speed,
        depth_at_end=depth * walker.length,
    )


#: An error estimate is taken that many times: it is right to a part of itself, see `walk.error_estimate.OFF`.
MARGIN = 1.5


class Solved(NamedTuple):
    """The gait at one tolerance, and a walk on it."""

    point: FixedPoint
    report: GaitReport
    upright: StanceState
    walk: Walk
    error: NumericalError


def run(parameters: Parameters, inputs: None = None, progress: Progress = ignore) -> Result:
    """Find the gait, audit it and record a walk.

    Raises NoGait if the design has no gait, StepFailed if the recorded walk does not get to its end, NotMet if an
    accuracy is requested that the finest tolerance does not keep.
    """
    settings = parameters.settings
    progress(0.0, "looking for gaits")
    design = DesignPoint(parameters.biped, parameters.slope, parameters.limited_friction)
    walker, found = find_gait(design.biped, design.slope, settings.tolerance, design.friction)
    progress(0.6, "recording the walk")
    def solved_with(at: Settings) -> Solved:
        as_found = at.tolerance == parameters.settings.tolerance and at.integrator == "compiled"
        point = found if as_found else solve(walker, found.z, at)
        return solved(walker, point, parameters.friction.coefficients.static_friction, at)

    settings, kept, errors = to_accuracy(
        settings.accuracy, settings, solved_with, partial(finer, walker), differences)
    point, report, upright, walk, error = kept
    progress(0.8, "derivatives by the parameters")
    elasticities, uncertainties = answers(parameters, design, point, settings.tolerance)
    near = partial(neighbour, design, point.z, settings.tolerance)
    return Result(
        gait=report.gait,
        limp=report.limp,
        mid_stance=upright,
        residual=point.residual,
        monodromy_matrix=point.monodromy_matrix,
        energy=report.energy,
        constraint_drift=constraint_drift(walker, report.segments),
        variations=vary_design(near, design.biped),
        elasticities=elasticities,
        uncertainties=uncertainties,
        outsole=outsole_effect(near, design.biped, parameters.rubber, settings.outsole),
        without_impact=without_impact(walker, report.segments),
        validity=report.validity,
        walk=walk,
        numerical_error=error,
        errors=errors,
    )


def answers(
    parameters: Parameters, design: DesignPoint, point: FixedPoint, tolerance: float
) -> tuple[tuple[Elasticities, ...], tuple[Uncertainty, ...]]:
    """How the gait answers to its parameters, and what their digits leave open; nothing where it has no derivatives."""
    try:
        varied = gait_derivatives(design, point, sensitive_names(design, parameters.half_widths), tolerance)
    except (StepFailed, np.linalg.LinAlgError):  # a step at the edge of the walkable, a gait on a fold
        return (), ()
    return elasticities_of(varied, parameters.half_widths), uncertainties_of(
        design, varied, parameters.half_widths, correlations=parameters.correlations)


def solve(walker: Walker, z: Vector, settings: Settings) -> FixedPoint:
    """The gait found near `z`, at the settings' tolerance. Raises NoGait."""
    if settings.integrator == "scipy":
        from stages.analytic.integration.readable import (
            refine,  # its SymPy takes longer to load than the whole compiled search
        )

        return refine(walker, z, settings.tolerance)
    point = fixed_point(walker, z, settings.tolerance)
    if point is None:
        raise NoGait(f"the gait found is lost at a tolerance of {settings.tolerance:g}")
    return point


def solved(walker: Walker, point: FixedPoint, friction: float, settings: Settings) -> Solved:
    """The gait with its measures on ground with this static friction, and a walk on it. Raises StepFailed."""
    tolerance = settings.tolerance
    walk, upright = walk_from_mid_stance(walker, point.z, settings.steps, tolerance, settings.sampling_rate_hz)
    if settings.integrator == "scipy":
        error = not_given("the gait is SciPy's, the estimate is of compiled steps")
    else:
        error = estimate_errors(walker, point, settings.steps, tolerance)
    return Solved(point, report_gait(walker, point, tolerance, friction), upright, walk, error)


def finer(walker: Walker, settings: Settings, by: float) -> Settings | None:
    """So many times the tolerance; None at round-off, or at the finest that the parameter files allow.

    Nor is it looser than the level's: that saves a third of a millisecond a step, and a gait that is not stable falls.
    """
    tolerance = max(scaled(settings.tolerance, by), FINEST, attainable_tolerance(walker.p, 0.0))
    return None if tolerance >= settings.tolerance else replace(settings, tolerance=tolerance)


def differences(one: Solved, other: Solved) -> dict[str, float]:
    """Errors of `other`, by the names of `Accuracy`: what it differs by from `one`, which is coarser, or, where it has
    error estimates, these and a margin.
    """
    leading = [solved.report.gait.largest_multiplier for solved in (one, other)]
    found = walk_differences(one.walk, other.walk)
    period = abs(one.report.gait.period_s - other.report.gait.period_s)
    found |= {"period_s": max(period, found.get("period_s", 0.0)), "multiplier": abs(leading[0] - leading[1])}
    if other.error.given:
        found["hip_position_m"] = MARGIN * other.error.hip_position
        found["period_s"] = MARGIN * max(other.error.step_duration, abs(np.nan_to_num(other.error.period)))
    return found


#: Parameters that are changed alone, and by what share.
DESIGN = ("hip_mass", "foot_mass", "leg_length", "foot_radius", "foot_com", "stiffness", "damping")
CHANGE = 0.05


def neighbour(design: DesignPoint, z: Vector, tolerance: float, biped: Biped) -> tuple[float, float]:
    """Largest multiplier and step frequency [Hz] of the gait of a biped near that of `design`, whose own gait has
    section coordinates `z`; NaN if there is none."""
    walker = replace(design, biped=biped).walker()
    point = fixed_point(walker, z, tolerance)
    if point is None:
        return np.nan, np.nan
    gait = describe(walker, point)
    return gait.largest_multiplier, gait.step_frequency_hz


#: Largest multiplier and step frequency [Hz] of a biped near the design.
Near = Callable[[Biped], tuple[float, float]]


def vary_design(near: Near, biped: Biped) -> tuple[Variation, ...]:
    """The gait with each parameter of the design's biped lowered and raised by `CHANGE`, the others fixed."""
    variations = []
    for name in DESIGN if biped.legs == "compliant" else DESIGN[:-2]:  # rigid legs have no stiffness and damping
        beside = (replace(biped, **{name: getattr(biped, name) * factor}) for factor in (1 - CHANGE, 1 + CHANGE))
        (below, slower), (above, faster) = map(near, beside)
        variations.append(Variation(name, CHANGE, below, above, slower, faster))
    return tuple(variations)


#: Steps of the secant method: the frequency is nearly linear in the mass, each leaves less than a hundredth.
ROUNDS = 4


def outsole_effect(near: Near, biped: Biped, rubber: Rubber, thickness: float) -> OutsoleEffect:
    """The gait with `thickness` [m] of rubber under the feet of the design's biped."""
    mass = FEET * rubber.mass(biped.foot_radius, thickness)

    def frequency(of_rubber: float) -> float:
        return near(soled(biped, rubber, thickness, of_rubber))[1]

    usual = near(biped)[1]
    alone, weighed = frequency(0.0), frequency(mass)
    turning = zero_of(lambda of_rubber: frequency(of_rubber) - usual, (0.0, alone - usual), (mass, weighed - usual))
    return OutsoleEffect(thickness, mass, alone, weighed, turning)


def zero_of(change: Callable[[float], float], first: tuple[float, float], second: tuple[float, float]) -> float:
    """Where a nearly linear function of a mass [kg] is zero, from two masses with its values; NaN below no mass."""
    for _ in range(ROUNDS):
        if second[1] == first[1]:
            break
        root = second[0] - second[1] * (second[0] - first[0]) / (second[1] - first[1])
        if not root > 0.0:
            return math.nan
        first, second = second, (root, change(root))
    return second[0]
