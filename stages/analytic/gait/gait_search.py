"""Finds the gaits of a design from no guess.

A damped Newton's method with exact derivatives runs from many starts, so that unstable gaits are found as well as
stable ones. Stiff walkers are reached from the rigid ones and by raising stiffness and damping in stages.
"""

import dataclasses
from collections.abc import Iterator
from contextlib import suppress
from copy import deepcopy
from functools import lru_cache
from itertools import islice
from typing import Any

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.continuation import TURNING_POINT, continue_gait
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.poincare import (
    FEW_STARTS,
    SEARCH_TOLERANCE,
    FixedPoint,
    by_stability,
    converge,
    fixed_point,
    is_new,
    is_walking,
    poincare_map,
)
from stages.analytic.gait.search_starts import (
    ANGLES,
    GRID_RATE,
    LONG_WALK,
    RATES,
    SCAN_STEPS,
    WIDE_ANGLES,
    WIDE_RATES,
    is_elsewhere,
    is_quick,
    is_searched,
    landed,
    lengths_after_heel_strike,
    ranked_starts,
    walked_on,
)
from stages.analytic.model.kinds import (
    Compliant,
    Detailed,
    DetailedRigid,
    PlainRigid,
    Rigid,
    radii,
)
from stages.analytic.model.stiffness import attainable_tolerance, fastest_rate, judged
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.guards import foot_clearance
from stages.analytic.phases.section import section_state
from stages.biped.design import Biped
from stages.biped.quantity import count_of
from stages.biped.walk import Gait
from stages.ground.slope import Friction, Slope

#: Where a gait is looked for: parameters, and factors on the design's value of each.
ELSEWHERE = {"ground.slope_deg": (0.5, 2.0, 0.25, 4.0), "biped.stiffness": (2.0, 4.0, 16.0),
             "biped.damping": (0.5, 0.25, 2.0, 4.0)}  # fmt: skip
#: A family is followed by so many gaits at most, this far apart.
MOST_GAITS, APART = 80, 0.15


@lru_cache(maxsize=64)
def from_neighbours(design: DesignPoint, tolerance: float) -> FixedPoint | list[str]:
    """The design's gait that a neighbour's leads to, or else in words how far each family followed gets, up to a first
    fold. It is kept, as several models may search for the same gait in vain."""
    followed: list[str] = []
    for name, neighbour, point in neighbours(design):
        start, wanted = neighbour.value(name), design.value(name)
        try:
            branch = continue_gait(
                neighbour, name, (min(start, wanted), max(start, wanted)), point.z, SEARCH_TOLERANCE,
                upward=wanted > start, largest_step=APART, most_points=MOST_GAITS, until_fold=True)
        except StepFailed:
            continue
        last = branch.points[-1]
        found = fixed_point(design.walker(), last.z, tolerance) if last.value == wanted else None
        if found is not None and is_walking(found):
            return found
        folds = [point.value for kind, point in branch.special if kind == TURNING_POINT]
        values = [*folds, *(point.value for point in branch.points)]
        end, unit = min(values, key=lambda value: abs(value - wanted)), design.unit(name)
        what = f"turns back at {end:.6g} {unit}, a fold" if end in folds else f"is lost at {end:.6g} {unit}"
        begun = f"{name} = {branch.points[0].value:.4g} {unit}"
        followed.append(f"the gait at {begun}, followed towards the design, {what}")
        if end in folds:
            break
    return followed


def neighbours(design: DesignPoint) -> Iterator[tuple[str, DesignPoint, FixedPoint]]:
    """For each parameter, the nearest value tried at which the design has a gait, with that gait."""
    for name, factors in ELSEWHERE.items():
        if name == "ground.slope_deg" or design.biped.legs != "rigid":
            beside = (design.with_value(name, factor * design.value(name)) for factor in factors)
            found = ((each, first_gait(each.walker())) for each in beside if each.is_legal())
            yield from islice(((name, each, point) for each, point in found if point is not None), 1)


def first_gait(walker: Walker) -> FixedPoint | None:
    """The first gait that Newton's method reaches from a few starts on a coarse grid; None where that costs much."""
    starts = ranked_starts(walker, thinned=2)[0][:FEW_STARTS] if is_searched(walker.p) else ()
    found = (fixed_point(walker, start, SEARCH_TOLERANCE) for start in starts)
    return next((point for point in found if point is not None and is_walking(point)), None)


#: Largest share by which the time of a step is changed at once.
TIME_SHARE = 0.01
#: Factor from one stage of stiffness to the next.
STAGE = 3.0


def softer(p: Compliant, rate: float) -> Compliant:
    """The walker with springs and dampers weakened, same damping ratio, to a fastest axial rate of `rate`."""
    factor = rate / fastest_rate(p)
    other = {"k_2": p.k_2 * factor**2, "b_2": p.b_2 * factor} if isinstance(p, Detailed) else {}
    return judged(p._replace(k=p.k * factor**2, b=p.b * factor, **other))


def stiffen(walker: Walker, p: Compliant, gaits: list[FixedPoint], rate: float) -> list[FixedPoint]:
    """The gaits of `softer(p, rate)` followed in stages to the walker itself, as far as Newton's method leads."""
    while gaits and rate < fastest_rate(p):
        before = np.array(lengths_after_heel_strike(softer(p, rate)))
        rate = min(rate * STAGE, fastest_rate(p))
        stage = softer(p, rate)
        starts = [point.z.copy() for point in gaits]
        for z in starts:
            z[1:3] += np.array(lengths_after_heel_strike(stage)) - before
        gaits = converge(dataclasses.replace(walker, p=stage), starts, SEARCH_TOLERANCE, unstable=True)
    return gaits


def rigid_landings(walker: Walker, p: Compliant) -> list[Vector]:
    """Landings of the gaits of the same biped with rigid legs."""
    numbers = p._asdict()
    kind: Any = DetailedRigid if isinstance(p, Detailed) else PlainRigid
    rigid = dataclasses.replace(walker, p=kind(*(numbers[name] for name in kind._fields[:-5])))
    starts: list[Vector] = []
    for point in converge(rigid, ranked_starts(rigid)[0], SEARCH_TOLERANCE, unstable=True):
        with suppress(StepFailed):
            starts.append(landed(p, rigid, point))
    return starts


def sources(walker: Walker, *, quick: bool) -> Iterator[list[Vector]]:
    """Lists of starts for Newton's method, the quickest to get and most promising first.

    A `quick` search, which ends at a stable gait, looks for one from a few starts on a coarse grid before.
    """
    p = walker.p
    if isinstance(p, Compliant) and not is_quick(p):
        yield rigid_landings(walker, p)
    if is_searched(p):
        tried = list(ranked_starts(walker, thinned=2)[0][:FEW_STARTS]) if quick else []
        yield tried
        yield [z for z in ranked_starts(walker)[0] if is_elsewhere(walker, z, tried)]
        yield walked_on(walker)
    elif isinstance(p, Compliant):  # softer springs' gaits, followed to its own as far as Newton's method leads
        soft = dataclasses.replace(walker, p=softer(p, GRID_RATE))
        gaits = converge(soft, ranked_starts(soft)[0], SEARCH_TOLERANCE, unstable=True)
        yield [point.z for point in stiffen(walker, p, gaits, GRID_RATE)]


def find_gaits(walker: Walker, tolerance: float, *, unstable: bool) -> list[FixedPoint]:
    """Fixed points of the step map, most stable first; with `unstable` the search goes on after a stable one.

    What was found is kept; each caller gets arrays of its own.
    """
    return deepcopy(gaits_kept(walker, tolerance, unstable))


@lru_cache(maxsize=64)
def gaits_kept(walker: Walker, tolerance: float, unstable: bool) -> list[FixedPoint]:
    """What `find_gaits` finds."""
    found: list[FixedPoint] = []
    if walker.p.g_x <= 0.0:
        return found
    if isinstance(walker.p, Rigid) and walker.timed:
        return timed_gaits(walker, walker.p, tolerance)
    tolerance = attainable_tolerance(walker.p, tolerance)
    met: list[Vector] = []
    for starts in sources(walker, quick=not unstable):
        reached = converge(walker, starts, tolerance, unstable=unstable, met=met)
        found += [point for point in reached if is_new(found, point)]
        if not unstable and any(by_stability(point) < 1 for point in found):
            break
    return sorted(found, key=by_stability)


def timed_gaits(walker: Walker, p: Rigid, tolerance: float) -> list[FixedPoint]:
    """Gaits of feet that are put down at a given time: followed from those of feet that land by themselves."""
    landing = dataclasses.replace(walker, p=p._replace(T=np.inf))
    found: list[FixedPoint] = []
    for point in find_gaits(landing, SEARCH_TOLERANCE, unstable=True):
        here: FixedPoint | None = None
        z, parts = section_state(point.z, landing.p), max(1, int(np.ceil(abs(p.T / point.period - 1.0) / TIME_SHARE)))
        for part in range(1, parts + 1):
            time = point.period + (p.T - point.period) * part / parts
            there = dataclasses.replace(walker, p=p._replace(T=time if part < parts else p.T))
            here = fixed_point(there, z, tolerance)
            if here is None:
                break
            z = here.z
        if here is not None and is_new(found, here):
            found.append(here)
    return sorted(found, key=by_stability)


def why_no_gait(walker: Walker) -> str:
    """Reason why the search found nothing."""
    if walker.p.g_x <= 0.0:
        return "no periodic gait: on level ground gravity does no work, and every heel strike loses energy"
    if not walker.rolls and (reason := why_no_step(walker)):
        return f"no periodic gait found: from the gait of the same biped with rolling feet, {reason}"
    if walker.timed:
        return ("no periodic gait found with steps of this time: from the gaits of the same biped whose feet land by "
                "themselves, if it has some, none leads there")
    rigid = "" if is_quick(walker.p) else "the gaits of the same biped with rigid legs lead to none"
    if not is_searched(walker.p):
        return (f"no periodic gait found: the legs are too stiff for a search on a grid; {rigid}, and neither do those "
                "with softer springs")  # fmt: skip
    where = f"stance angle {ANGLES[0]:g} to {ANGLES[-1]:g} rad, stance rate {RATES[0]:g} to {RATES[-1]:g} sqrt(g/L)"
    _, longest = ranked_starts(walker)
    steps = f"at least {SCAN_STEPS} steps" if longest >= SCAN_STEPS else count_of(longest, "step")
    return (
        f"no periodic gait in the range searched ({where}): of {ANGLES.size * RATES.size} starts the longest walk made "
        f"{steps}, and Newton's method converged from none; of {WIDE_ANGLES.size * WIDE_RATES.size} walks from "
        f"up to {WIDE_ANGLES[-1]:g} rad and {WIDE_RATES[-1]:g} sqrt(g/L) none settled in {LONG_WALK} steps"
        + (f"; {rigid}" if rigid else ""))


def why_no_step(walker: Walker) -> str:
    """Why a walker with limited friction makes no step from the gait of the same biped with rolling feet, if so."""
    p: Any = walker.p
    rolling = dataclasses.replace(walker, p=p._replace(mu_s=np.inf, mu_d=np.inf))
    for point in find_gaits(rolling, SEARCH_TOLERANCE, unstable=False)[:1]:
        try:
            poincare_map(walker, np.append(point.z, [0.0, 0.0]), SEARCH_TOLERANCE)
        except StepFailed as reason:
            return str(reason)
    return ""


def describe(walker: Walker, point: FixedPoint) -> Gait:
    """The gait in SI units under the names the command line prints."""
    period = point.period * walker.time
    length = step_length(walker, point) * walker.length
    double = sum(step.double_stance for step in point.steps) / len(point.steps)
    multipliers = point.floquet_multipliers
    return Gait(
        period_s=period,
        step_frequency_hz=1 / period,
        step_length_m=length,
        speed_m_s=length / period,
        double_stance_s=double * walker.time,
        floquet_multipliers=np.column_stack([multipliers.real, multipliers.imag]),
        steps=len(point.steps),
        stable=bool(np.abs(multipliers).max() < 1),
        fixed_point=walker.stance_state(point.steps[-1].state),
    )


def step_lengths(walker: Walker, point: FixedPoint) -> list[float]:
    """Advance of the hip over each step, in leg lengths: the distance of the feet's contact points at heel strike.

    The stance foot rolls by r (theta_end - theta_start) and the body passes to the other foot; over a periodic step
    the advance of the hip equals the distance between the two feet's centres plus the rolling from centre to centre.
    Where the legs differ that holds for a stride, and a step leads from one foot's contact point to the other's, each
    where it is with its leg upright.
    """
    lengths, angle = [], 1 if walker.rigid else 2
    for step, apart in zip(point.steps, feet_apart(walker, point), strict=True):
        walker = walker.exchanged
        theta, psi, p = step.state[0], step.state[angle], walker.p
        lengths.append(float(apart - p.r * (theta + psi) - (radii(p)[1] - p.r) * psi))
    return lengths


def feet_apart(walker: Walker, point: FixedPoint) -> list[float]:
    """How far ahead of the other each step's foot lands, in leg lengths."""
    apart = []
    for step in point.steps:
        walker = walker.exchanged
        apart.append(-float(foot_clearance(step.state, walker.p, step.state, 0)[2]))
    return apart


def step_length(walker: Walker, point: FixedPoint) -> float:
    """Advance of the hip over one step of a gait, the mean of its steps, in leg lengths."""
    lengths = step_lengths(walker, point)
    return sum(lengths) / len(lengths)


def find_gait(
    biped: Biped, slope: Slope, tolerance: float, friction: Friction | None = None
) -> tuple[Walker, FixedPoint]:
    """The design's most stable gait of period one, stable or not; with `friction` the trailing foot may slip and rise.

    Raises NoGait with the reason if there is none in the range searched.
    """
    design = DesignPoint(biped, slope, friction)
    walker = design.walker()
    found = search(design, walker, tolerance)
    if isinstance(found, FixedPoint):
        return walker, found
    raise NoGait("; ".join([why_no_gait(walker), *found]))


def gait_near(design: DesignPoint, near: Vector, tolerance: float) -> tuple[Walker, FixedPoint]:
    """The stable gait that Newton's method reaches from section coordinates of a similar design's; else `find_gait`."""
    walker = design.walker()
    if near.size == walker.section_size:
        found = fixed_point(walker, near, attainable_tolerance(walker.p, tolerance))
        if found is not None and by_stability(found) < 1:
            return walker, found
    return find_gait(design.biped, design.slope, tolerance, design.friction)


def search(design: DesignPoint, walker: Walker, tolerance: float) -> FixedPoint | list[str]:
    """The design's most stable gait, or how far the gaits of its neighbours could be followed towards it."""
    found = find_gaits(walker, tolerance, unstable=False)
    if found:
        return found[0]
    if walker.timed:
        return []
    if design.slope.angle <= 0.0:
        return []
    return deepcopy(from_neighbours(design, attainable_tolerance(walker.p, tolerance)))
