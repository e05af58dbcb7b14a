"""The constraint model at a point, beside its readable path: another integrator on equations solved another way.

And what a gait says of itself: its derivatives by the parameters, and the estimate of its error.
"""

import dataclasses
from contextlib import suppress
from functools import lru_cache

import numpy as np

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import FixedPoint, Step, fixed_point, iterate, poincare_map
from stages.analytic.gait.search_starts import lengths_after_heel_strike
from stages.analytic.integration import readable
from stages.analytic.model.kinds import Rigid
from stages.analytic.model.stiffness import attainable_tolerance, axial_rates
from stages.analytic.model.walker import Vector, Walker, build_walker
from stages.analytic.phases.section import section_coordinates
from stages.analytic.walk.error_estimate import estimate_errors
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.biped.accuracy.estimate import walk_differences
from stages.biped.design import Biped
from stages.extremes.parameters import COULOMB, DETAILED, FAILED, REFUSED, RIGHT, UNCONFIRMED, WRONG, Parameters
from stages.extremes.points import Point
from stages.extremes.result import Finding, judged
from stages.ground.slope import Friction, Slope

REFERENCE_TOLERANCE, TIGHTEST = 1e-9, 1e-12
#: A rerun's tolerance differs from the answer's by this factor at least; it is looser where round-off of the springs'
#: forces attains no tighter one, and the difference then bounds the answer's error from above.
FACTOR, TIGHTER, LOOSER = 10.0, "tighter tolerance", "looser tolerance"
#: Axial rate, in 1 / pendulum time, up to which the explicit reference is quick; beyond, it is implicit, if the motion
#: decays within so many of its radians.
EXPLICIT_RATE, RINGING = 150.0, 10.0
#: Parameters whose derivatives are compared with differences, and the shares of them that these are taken over.
COMPARED, SHARES = ("ground.slope_deg", "biped.foot_mass", "biped.leg_length"), (2e-3, 1e-3)
EXACT = 1e-13
#: Steps and sampling rate, in leg lengths' pendulum times, of the walk whose error is estimated.
STEPS, RATE = 3, 400.0
#: An estimate is to be within this factor of the truth; truths below this, in leg lengths, are round-off.
WITHIN, ROUND_OFF = 2.0, 1e-13
TOO_LONG = "on stiff legs walks that are so much more exact take too long"


class NoReference(Exception):
    """The rerun that would confirm an answer ended early."""


def gait(usual: Parameters, here: Parameters, point: Point) -> Finding:
    """The gait a user is given: its distance, by Newton's correction, from the fixed point of the reference's map.

    Raises NoGait, BeyondModel, NoReference.
    """
    tolerance, limit = here.analytic.tolerance, usual.settings.right_within
    limited = {COULOMB: here.friction, DETAILED: here.analytic.limited(here.friction)}
    friction = limited.get(point.engine)
    walker, found = find_gait(here.biped, here.slope, tolerance, friction)
    try:
        audit = abs(report_gait(walker, found, tolerance, here.friction.coefficients.static_friction).energy.residual)
    except StepFailed as reason:
        return Finding(FAILED, reason=f"the gait is found but not recorded: {reason}")
    try:
        reference, after, duration = reference_gait(walker, found, attainable_tolerance(walker.p, tolerance))
        error = distance(found, after, duration)
        if walker.alternates:
            error = max(error, from_the_other_leg(here, friction, walker, found))
    except StepFailed as reason:
        return judged(np.inf, audit, tolerance, limit, f"the reference finds no step: {reason}")
    return by_reference(judged(error, audit, tolerance, limit, reference))


def by_reference(finding: Finding) -> Finding:
    """The finding, but that a looser rerun contradicts nothing: its own error may be the difference."""
    if finding.status == WRONG and finding.reference == LOOSER:
        why = "a rerun ten times looser differs, and round-off of the springs' forces allows no tighter one"
        return dataclasses.replace(finding, status=UNCONFIRMED, reason=why)
    return finding


def distance(point: FixedPoint, after: Vector, duration: float) -> float:
    """How far a gait is from the fixed point of another map, and its mean period from that map's, to first order.

    That map leads from the gait's coordinates to `after` in `duration`, over all steps of the gait. Of a section with
    columns of zeros (a trailing foot at rest) only the moving coordinates count.
    """
    matrix = np.eye(after.size) - point.monodromy_matrix
    correction = np.linalg.lstsq(matrix, after - point.z, rcond=None)[0]
    return float(max(np.abs(correction).max(), abs(duration / len(point.steps) - point.period)))


def reference_gait(walker: Walker, point: FixedPoint, used: float) -> tuple[str, Vector, float]:
    """Name of the reference, where its steps lead from the gait's coordinates, and their duration.

    Raises as `reference_step` does.
    """
    z, duration, names = point.z, 0.0, []
    for _ in point.steps:
        name, step = reference_step(walker, z, used)
        z, duration, walker = step.z, duration + step.period, walker.exchanged
        names.append(name)
    return (LOOSER if LOOSER in names else names[0]), z, duration


def from_the_other_leg(here: Parameters, friction: Friction | None, walker: Walker, point: FixedPoint) -> float:
    """Distance of a gait from that of the same machine whose legs are called the other way round.

    That machine is measured by its own first leg, and takes the gait's second step first. Raises StepFailed.
    """
    other = build_walker(here.biped.exchanged, here.slope, friction)
    start = section_coordinates(point.steps[0].state * walker.scales() / other.scales(), other.p)
    steps, derivative = iterate(other, start, len(point.steps), here.analytic.tolerance)
    clock = walker.time / other.time
    taken = dataclasses.replace(point, z=start, monodromy_matrix=derivative,
                                steps=tuple(dataclasses.replace(step, period=step.period * clock)
                                            for step in point.steps))
    return distance(taken, steps[-1].z, sum(step.period for step in steps))


def reference_step(walker: Walker, z: Vector, used: float) -> tuple[str, Step]:
    """Name of the reference and its step from `z`: SciPy on the readable equations where it can follow the legs.

    Raises StepFailed if the reference finds no step, NoReference if the rerun does not. Legs that ring fast and long,
    limited friction and friction at the hip, which the readable path does not know, are checked by a rerun at another
    tolerance than that `used` for the answer; the energy audit then is what is independent.
    """
    rate, decay = (0.0, 0.0) if isinstance(walker.p, Rigid) else axial_rates(walker.p)
    readable_path = walker.rolls and not walker.timed and walker.p.tau_h == 0.0
    if readable_path and (rate <= EXPLICIT_RATE or decay * RINGING >= rate):
        method = "DOP853" if rate <= EXPLICIT_RATE else "Radau"
        with suppress(readable.TooSlow):
            return f"readable, {method}", readable.take_step(walker, z, REFERENCE_TOLERANCE, method)
    tightest = attainable_tolerance(walker.p, TIGHTEST)
    name, tolerance = (TIGHTER, tightest) if tightest * FACTOR <= used else (LOOSER, used * FACTOR)
    try:
        return name, poincare_map(walker, z, tolerance)
    except StepFailed as reason:
        raise NoReference(f"the rerun: {reason}") from None


@lru_cache(maxsize=64)
def usual_gait(biped: Biped, slope: Slope, friction: Friction | None = None) -> tuple[Walker, FixedPoint]:
    """A design's gait at a tight tolerance. Raises NoGait."""
    return find_gait(biped, slope, 1e-10, friction)


def one_step(usual: Parameters, here: Parameters, point: Point) -> Finding:
    """One step of a design from where the usual design's step starts, its legs loaded as this one's are.

    Raises NoGait, NoReference.
    """
    tolerance, limit = here.analytic.tolerance, usual.settings.right_within
    walker = build_walker(here.biped, here.slope)
    z = usual_gait(usual.biped, usual.slope)[1].z.copy()
    if not isinstance(walker.p, Rigid):
        z[1:3] = lengths_after_heel_strike(walker.p)
    try:
        step = poincare_map(walker, z, tolerance)
    except StepFailed as reason:
        return Finding(FAILED, reason=str(reason))
    try:
        reference, other = reference_step(walker, z, tolerance)
    except StepFailed as reason:
        return judged(np.inf, np.nan, tolerance, limit, f"the reference finds no step: {reason}")
    error = float(max(np.abs(step.z - other.z).max(), abs(step.period - other.period)))
    return by_reference(judged(error, np.nan, tolerance, limit, reference))


def march(usual: Parameters, here: Parameters, point: Point) -> Finding:
    """Many steps in a row from the gait: the largest distance from it, over which a drift would grow. Raises NoGait."""
    tolerance = here.analytic.tolerance
    walker, found = usual_gait(here.biped, here.slope)
    if tolerance > 1e-10:
        found = fixed_point(walker, found.z, tolerance) or found
    z, farthest, around = found.z, 0.0, len(found.steps)
    for number in range(0, int(point.value), around):
        try:
            standing = walker
            for _ in range(around):
                z, standing = poincare_map(standing, z, tolerance).z, standing.exchanged
        except StepFailed as reason:
            return Finding(FAILED, reason=f"step {number + 1}: {reason}")
        farthest = max(farthest, float(np.abs(z - found.z).max()))
    change = float(np.abs(iterate(walker, z, around, tolerance)[0][-1].z - z).max())
    finding = judged(farthest, np.nan, tolerance, usual.settings.right_within, "the gait it started from")
    return dataclasses.replace(finding, reason=f"the last step moves it by {change:.1e}")


def derivatives(usual: Parameters, here: Parameters, point: Point) -> Finding:
    """Elasticities of the period against differences of gaits of changed designs, extrapolated. Raises NoGait."""
    tolerance, limit = here.analytic.tolerance, usual.settings.right_within
    walker, found = find_gait(here.biped, here.slope, tolerance)
    if walker.stiff:
        return Finding(UNCONFIRMED, reason=TOO_LONG)
    design, tight = DesignPoint(here.biped, here.slope), attainable_tolerance(walker.p, EXACT)
    try:
        answers = gait_derivatives(design, found, COMPARED, tolerance).elasticities()["period_s"]
    except (StepFailed, np.linalg.LinAlgError) as reason:
        return Finding(REFUSED, reason=f"no derivatives: {reason}")
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


def estimate(usual: Parameters, here: Parameters, point: Point) -> Finding:
    """The estimated error of the hip's path against that to a walk at the tightest tolerance. Raises NoGait."""
    tolerance = here.analytic.tolerance
    walker, found = find_gait(here.biped, here.slope, tolerance)
    if walker.stiff:
        return Finding(UNCONFIRMED, reason=TOO_LONG)
    said = estimate_errors(walker, found, STEPS, tolerance)
    if not said.given:
        return Finding(REFUSED, reason=said.checked)
    tight = attainable_tolerance(walker.p, EXACT)
    exact = fixed_point(walker, found.z, tight)
    if exact is None or tight > tolerance / 50.0:
        return Finding(UNCONFIRMED, reason="no walk is so much more exact that it could decide")
    walks = [walk_from_mid_stance(walker, one.z, STEPS, requested, RATE / walker.time)[0]
             for one, requested in ((found, tolerance), (exact, tight))]  # fmt: skip
    true = walk_differences(*walks)["hip_position_m"]
    ratio = said.hip_position / true if true > 0.0 else np.inf
    reference, error = f"tolerance {tight:.0e}", abs(said.hip_position - true) / walker.length
    if 1.0 / WITHIN <= ratio <= WITHIN or max(true, said.hip_position) <= ROUND_OFF * walker.length:
        return Finding(RIGHT, error, reference=reference)
    return Finding(WRONG, error, reference=reference, reason=f"the estimate is {ratio:.2g} times the true error")
