"""The constraint model at a point, beside its readable path: another integrator on equations solved another way."""

from __future__ import annotations

import dataclasses
from contextlib import suppress
from functools import lru_cache

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import (
    FixedPoint,
    Step,
    fixed_point,
    iterate,
    poincare_map,
)
from stages.analytic.gait.search_starts import lengths_after_heel_strike
from stages.analytic.integration import readable
from stages.analytic.model.kinds import Rigid, Rubbing
from stages.analytic.model.stiffness import attainable_tolerance, axial_rates
from stages.analytic.model.walker import Vector, Walker, build_walker
from stages.analytic.phases.section import section_coordinates
from stages.biped.design import BeyondModel, Biped
from stages.extremes.engines import COULOMB, DETAILED, MARCH, STEP
from stages.extremes.parameters import Parameters
from stages.extremes.points import Point
from stages.extremes.verdict import UNCONFIRMED, WRONG, Finding, failed, judged, refused
from stages.ground.friction_coefficients import Friction
from stages.ground.slope import Slope

SECTIONS = ("biped", "slope", "friction", "analytic")
REFERENCE_TOLERANCE, TIGHTEST = 1e-9, 1e-12
#: A rerun's tolerance differs from the answer's by this factor at least; it is looser where round-off of the springs'
#: forces attains no tighter one, and the difference then bounds the answer's error from above.
FACTOR, TIGHTER, LOOSER = 10.0, "tighter tolerance", "looser tolerance"
#: Axial rate, in 1 / pendulum time, up to which the explicit reference is quick; beyond, it is implicit, if the motion
#: decays within so many of its radians.
EXPLICIT_RATE, RINGING = 150.0, 10.0


class NoReference(Exception):
    """The rerun that would confirm an answer ended early."""


def evaluate(parameters: Parameters, point: Point) -> Finding:
    """The verdict on a gait, a step, or a walk of many steps."""
    here = parameters.changed(point.changes)
    if reason := here.refusal(SECTIONS):
        return refused(reason)
    limit = parameters.settings.right_within
    try:
        if point.engine == STEP:
            return one_step(parameters, here, limit)
        if point.engine == MARCH:
            return march(here, int(point.value), limit)
        if point.engine == DETAILED:
            return gait(here, here.analytic.limited(here.friction), limit)
        return gait(here, here.friction if point.engine == COULOMB else None, limit)
    except NoReference as reason:
        return Finding(UNCONFIRMED, reason=str(reason))


def gait(here: Parameters, friction: Friction | None, limit: float) -> Finding:
    """The gait a user is given: its distance, by Newton's correction, from the fixed point of the reference's map."""
    tolerance = here.analytic.tolerance
    try:
        walker, point = find_gait(here.biped, here.slope, tolerance, friction)
    except (NoGait, BeyondModel) as reason:
        return refused(str(reason))
    try:
        audit = abs(report_gait(walker, point, tolerance, here.friction.static_friction).energy.residual)
    except StepFailed as reason:
        return failed(f"the gait is found but not recorded: {reason}")
    try:
        reference, after, duration = reference_gait(walker, point, attainable_tolerance(walker.p, tolerance))
        error = distance(point, after, duration)
        if walker.alternates:
            error = max(error, from_the_other_leg(here, friction, walker, point))
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
    readable_path = walker.rolls and not isinstance(walker.p, Rubbing)
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


def one_step(usual: Parameters, here: Parameters, limit: float) -> Finding:
    """One step of a design from where the usual design's step starts, its legs loaded as this one's are."""
    walker = build_walker(here.biped, here.slope)
    z = usual_gait(usual.biped, usual.slope)[1].z.copy()
    if not isinstance(walker.p, Rigid):
        z[1:3] = lengths_after_heel_strike(walker.p)
    try:
        step = poincare_map(walker, z, here.analytic.tolerance)
    except StepFailed as reason:
        return failed(str(reason))
    try:
        reference, other = reference_step(walker, z, here.analytic.tolerance)
    except StepFailed as reason:
        return judged(np.inf, np.nan, here.analytic.tolerance, limit, f"the reference finds no step: {reason}")
    error = float(max(np.abs(step.z - other.z).max(), abs(step.period - other.period)))
    return by_reference(judged(error, np.nan, here.analytic.tolerance, limit, reference))


def march(here: Parameters, steps: int, limit: float) -> Finding:
    """Many steps in a row from the gait: the largest distance from it, over which a drift would grow."""
    tolerance = here.analytic.tolerance
    walker, point = usual_gait(here.biped, here.slope)
    if tolerance > 1e-10:
        point = fixed_point(walker, point.z, tolerance) or point
    z, farthest = point.z, 0.0
    around = len(point.steps)
    for number in range(0, steps, around):
        try:
            standing = walker
            for _ in range(around):
                z, standing = poincare_map(standing, z, tolerance).z, standing.exchanged
        except StepFailed as reason:
            return failed(f"step {number + 1}: {reason}")
        farthest = max(farthest, float(np.abs(z - point.z).max()))
    change = float(np.abs(iterate(walker, z, around, tolerance)[0][-1].z - z).max())
    finding = judged(farthest, np.nan, tolerance, limit, "the gait it started from")
    return dataclasses.replace(finding, reason=f"the last step moves it by {change:.1e}")
