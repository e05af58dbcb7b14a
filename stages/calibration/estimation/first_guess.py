"""Where a run begins, from the times of its heel strikes alone: what the fit's first horizon starts from.

A push by hand moves the first mid-stance by a tenth of a second, which is more than a fit on a growing horizon gets
over. The step durations after it show the push: the drawing's walker is started after the first strike with other
angles and rates, and the start whose steps last as long as those measured is followed to its mid-stance.
"""

import contextlib
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import poincare_map
from stages.analytic.model.kinds import natural_lengths
from stages.analytic.model.walker import Vector, Walker
from stages.calibration.observation.measured_run import STRETCHES, Layout, mid_stance

#: Steps that are looked at, and tolerance of a walk whose strikes are compared with times known to milliseconds.
STEPS, COARSE = 5, 1e-6
#: Shares by which angle and rate after the first strike may be off, and how finely they are looked at, again and again
#: about the best.
WIDEST, POINTS, FINER, ROUNDS = 0.24, 9, 3.0, 4
#: Where a first guess leads nowhere, one parameter is tried these times as large.
SHARES = (0.8, 1.25)
#: What squares of durations may be off [s^2] for no reason.
ROUND_OFF = 1e-14


class Begun(NamedTuple):
    """A start: section coordinates after the first strike, dimensionless, and the shares by which its angle and rate
    are others than the gait's; by how much longer its steps last than the walker's own, and the mean square of what
    durations are off [s^2]."""

    z: Vector
    shares: tuple[float, float] = (0.0, 0.0)
    slower: float = 1.0
    misfit: float = np.inf


def first_guess(design: DesignPoint, strikes: Vector, first_leg: int, layout: Layout) -> Vector:
    """The unknowns (k,) of a run: its start from the heel strikes (s,) [s], all else as `layout` has it.

    Leg `first_leg` lands at the first strike. Where no start walks so far as there are strikes, the gait's own.
    """
    walker = design.walker().on(first_leg)
    durations = np.diff(strikes)[:STEPS]
    unknowns = layout.middle.copy()
    if len(durations) < 2:
        return unknowns
    best, width = Begun(layout.strike), WIDEST
    for _ in range(ROUNDS):
        best = _better(walker, layout.strike, durations, best, width)
        width /= FINER
    if best.misfit == np.inf:
        return unknowns
    try:
        state, since = mid_stance(walker, best.z, COARSE)
    except StepFailed:
        return unknowns
    state = state * walker.scales()[1:]
    for place, name in enumerate(layout.names[: layout.free]):
        if name in STRETCHES:
            state[place] -= walker.length * natural_lengths(walker.p)[STRETCHES.index(name)]
    unknowns[: layout.free] = state
    unknowns[layout.place("mid_stance")] = since * walker.time * best.slower
    return unknowns


def other_guesses(design: DesignPoint, names: Sequence[str], strikes: Vector) -> list[DesignPoint]:
    """Designs with one of the parameters `names` changed, by how near their gaits' steps come to those measured between
    heel strikes (s,) [s]."""
    measured = float(np.median(np.diff(strikes)))
    found: list[tuple[float, int, DesignPoint]] = []
    for name in (one for one in names if design.value(one) != 0.0):
        for share in SHARES:
            there = _scaled(design, name, share)
            if not there.is_legal():
                continue
            with contextlib.suppress(NoGait):
                walker, point = find_gait(there.biped, there.slope, COARSE)
                period = walker.time * float(np.mean([step.period for step in point.steps]))
                found.append((abs(math.log(period / measured)), len(found), there))
    return [there for _, _, there in sorted(found, key=lambda one: one[:2])]


def _scaled(design: DesignPoint, name: str, share: float) -> DesignPoint:
    """The design with a parameter of both legs so many times as large."""
    other = name.replace("biped.", "biped.other_")
    both = (name, other) if getattr(design.biped, other.partition(".")[2], None) is not None else (name,)
    return design.with_values({each: share * design.value(each) for each in both})


def _better(walker: Walker, z: Vector, durations: Vector, best: Begun, width: float) -> Begun:
    """The best start about the shares of a `best` one, if it is better, of those that walk as far as durations go."""
    rate, (about_angle, about_speed) = 1 if walker.rigid else 3, best.shares
    shifts = sorted(np.linspace(-width, width, POINTS).tolist(), key=abs)  # one that fits soon spares others their walk
    for angle in about_angle + np.array(shifts):
        for speed in about_speed + np.array(shifts):
            start = z.copy()
            start[0] *= 1.0 + angle
            start[rate] *= 1.0 + speed
            try:
                lasted = walker.time * _durations(walker, start, durations, best.misfit)
            except StepFailed:
                continue
            slower = float(durations @ lasted / (lasted @ lasted))
            misfit = float(((durations - slower * lasted) ** 2).mean())
            if misfit < best.misfit:
                best = Begun(start, (angle, speed), slower, misfit)
    return best


def _durations(walker: Walker, z: Vector, wanted: Vector, misfit: float) -> Vector:
    """How long the steps from `z` last, dimensionless.

    Raises StepFailed, also where the first ones are farther off than a `misfit` of all `wanted` [s] allows.
    """
    found = np.empty(len(wanted))
    for number in range(len(wanted)):
        step = poincare_map(walker, z, COARSE)
        found[number], z, walker = step.period, step.z, walker.exchanged
        begun, measured = found[: number + 1], wanted[: number + 1]
        left = float(measured @ measured - (measured @ begun) ** 2 / (begun @ begun))
        if left > misfit * len(wanted) + ROUND_OFF:
            raise StepFailed("steps last otherwise")
    return found
