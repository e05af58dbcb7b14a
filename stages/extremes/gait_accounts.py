"""What a gait says of itself at a point: its derivatives by the parameters, and the estimate of its error."""

from __future__ import annotations

import numpy as np

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import FixedPoint, fixed_point
from stages.analytic.model.kinds import Stiff
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.walker import Walker
from stages.analytic.walk.error_estimate import estimate_errors
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.biped.accuracy.estimate import walk_differences
from stages.biped.walk import Walk
from stages.extremes.engines import DERIVATIVES
from stages.extremes.parameters import Parameters
from stages.extremes.points import Point
from stages.extremes.verdict import RIGHT, UNCONFIRMED, WRONG, Finding, refused

SECTIONS = ("biped", "slope", "friction", "analytic")
#: Parameters whose derivatives are compared with differences, and the shares of them that these are taken over.
COMPARED, SHARES = ("ground.slope_deg", "biped.foot_mass", "biped.leg_length"), (2e-3, 1e-3)
EXACT = 1e-13
#: Steps and sampling rate, in leg lengths' pendulum times, of the walk whose error is estimated.
STEPS, RATE = 3, 400.0
#: An estimate is to be within this factor of the truth; truths below this, in leg lengths, are round-off.
FACTOR, ROUND_OFF = 2.0, 1e-13


def evaluate(parameters: Parameters, point: Point) -> Finding:
    """The verdict on a gait's derivatives or on its error estimate."""
    here = parameters.changed(point.changes)
    if reason := here.refusal(SECTIONS):
        return refused(reason)
    tolerance = here.analytic.tolerance
    try:
        walker, found = find_gait(here.biped, here.slope, tolerance)
    except NoGait as reason:
        return refused(str(reason))
    if isinstance(walker.p, Stiff):
        return Finding(UNCONFIRMED, reason="on stiff legs walks that are so much more exact take too long")
    if point.engine == DERIVATIVES:
        return derivatives(DesignPoint(here.biped, here.slope), found, tolerance, parameters.settings.right_within)
    return estimate(walker, found, tolerance)


def derivatives(design: DesignPoint, found: FixedPoint, tolerance: float, limit: float) -> Finding:
    """Elasticities of the period against differences of gaits of changed designs, extrapolated."""
    tight = attainable_tolerance(design.walker().p, EXACT)
    try:
        answers = gait_derivatives(design, found, COMPARED, tolerance).elasticities()["period_s"]
    except (StepFailed, np.linalg.LinAlgError) as reason:
        return refused(f"no derivatives: {reason}")
    errors = []
    for name, answer in zip(COMPARED, answers, strict=True):
        wide, narrow = (difference(design, found, name, share, tight) for share in SHARES)
        expected = narrow + (narrow - wide) / 3.0
        if not abs(expected - narrow) <= limit * (1.0 + abs(narrow)):
            return Finding(UNCONFIRMED, reason=f"differences over shares of {name} do not settle")
        errors.append(abs(answer - expected) / (1.0 + abs(expected)))
    error = float(max(errors))
    if error <= max(limit, 100.0 * tolerance):
        return Finding(RIGHT, error, reference="differences, extrapolated")
    return Finding(WRONG, error, reference="differences, extrapolated", reason="the differences are other ones")


def difference(design: DesignPoint, found: FixedPoint, name: str, share: float, tolerance: float) -> float:
    """d ln period / d ln parameter by gaits at that share more and less of it; NaN if one is lost."""
    logarithms = []
    for factor in (1.0 + share, 1.0 - share):
        walker = design.with_value(name, factor * design.value(name)).walker()
        moved = fixed_point(walker, found.z, tolerance)
        if moved is None:
            return np.nan
        logarithms.append(np.log(moved.period * walker.time))
    return float((logarithms[0] - logarithms[1]) / (np.log1p(share) - np.log1p(-share)))


def estimate(walker: Walker, found: FixedPoint, tolerance: float) -> Finding:
    """The estimated error of the hip's path against that to a walk at the tightest tolerance."""
    said = estimate_errors(walker, found, STEPS, tolerance)
    if not said.given:
        return refused(said.checked)
    tight = attainable_tolerance(walker.p, EXACT)
    exact = fixed_point(walker, found.z, tight)
    if exact is None or tight > tolerance / 50.0:
        return Finding(UNCONFIRMED, reason="no walk is so much more exact that it could tell")
    true = walk_differences(walked(walker, found, tolerance), walked(walker, exact, tight))["hip_position_m"]
    ratio = said.hip_position / true if true > 0.0 else np.inf
    reference, error = f"tolerance {tight:.0e}", abs(said.hip_position - true) / walker.length
    if 1.0 / FACTOR <= ratio <= FACTOR or max(true, said.hip_position) <= ROUND_OFF * walker.length:
        return Finding(RIGHT, error, reference=reference)
    return Finding(WRONG, error, reference=reference, reason=f"the estimate is {ratio:.2g} times the true error")


def walked(walker: Walker, point: FixedPoint, tolerance: float) -> Walk:
    """The walk whose error is estimated."""
    return walk_from_mid_stance(walker, point.z, STEPS, tolerance, RATE / walker.time)[0]
