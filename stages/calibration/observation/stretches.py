"""A walk as stretches between its events, with exact derivatives by where it starts and by the design.

Every derivative is total: of the state at a fixed time since its stretch began, and of that beginning. So events move
with what is varied, and nothing is differentiated across a jump.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from stages.analytic.derivatives.gait import exchanged_rows
from stages.analytic.errors import StepFailed
from stages.analytic.gait.poincare import STEP_LIMIT_OF_A_PHASE, TIME_LIMIT_OF_A_PHASE, require_landing
from stages.analytic.integration.integrator import STAGES, error_norm, step_factor, take_step
from stages.analytic.integration.phase import (
    CHATTER,
    EVENT,
    FIRST_LENGTH,
    MOST_PHASES,
    WEDGED,
    integrate,
    shift_to_event,
)
from stages.analytic.model.kinds import Directions, directions
from stages.analytic.model.stiffness import attainable_tolerance, fastest_rate
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.guards import FEET, HIP
from stages.analytic.phases.motion import flow, in_contact
from stages.analytic.phases.succession import ends_step, of_hip, single_stance, succeed
from stages.calibration.compiled import compiled

#: Nodes of a panel (Gauss), length of the first panel in times of the legs' fastest motion, growth from one to the
#: next, and the longest one in pendulum times.
NODES, FIRST, GROWTH, LONGEST = 6, 1.2, 2.0, 0.35
#: Panels of a walker without springs are all of the longest kind.
POINTS = np.polynomial.legendre.leggauss(NODES)[0]


def panel_edges(duration: float, fastest: float) -> Vector:
    """Edges (p + 1,) of the panels of a stretch, from 0 to `duration`; `fastest` rate of the springs, 0 for none."""
    length = min(FIRST / fastest, LONGEST) if fastest > 0.0 else LONGEST
    edges = [0.0]
    while edges[-1] < duration:
        edges.append(edges[-1] + length)
        length = min(length * GROWTH, LONGEST)
    return np.array(edges) * (duration / edges[-1])


def panel_nodes(edges: Vector) -> Vector:
    """The nodes of all panels, rising, shape (p * NODES,)."""
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    return np.asarray((middle[:, None] + half[:, None] * POINTS).ravel())


#: The matrix (NODES, NODES) from values at the nodes to coefficients of powers of s in [-1, 1], lowest first.
TO_POWERS = np.linalg.inv(np.vander(POINTS, increasing=True))

#: The matrix (2 NODES, 2 NODES) to such coefficients from values at the nodes and then rates by s there (Hermite).
HERMITE = np.linalg.inv(np.vstack([
    np.vander(POINTS, 2 * NODES, increasing=True),
    np.arange(2 * NODES) * np.vander(POINTS, 2 * NODES, increasing=True) / POINTS[:, None]]))
#: Exponents of s in the derivatives of its powers, by their orders, and the factors before them.
ORDERS = np.arange(6.0)
EXPONENTS = np.maximum(np.arange(2 * NODES) - ORDERS[:, None], 0.0)
FACTORS = np.cumprod(np.vstack([np.ones(2 * NODES), np.maximum(np.arange(2 * NODES) - ORDERS[:-1, None], 0.0)]), axis=0)

#: Two times closer than this are one.
SAME = 1e-13


@compiled
def march(
    phase: int, y: Vector, p: Any, numbers: Directions, tolerance: float, times: Vector, states: np.ndarray,
    rates: np.ndarray,
) -> bool:  # fmt: skip
    """Carry `y`, state and variations, through the rising `times` (n,) since now; False where no step is short enough.

    What it is there and its rates are left in `states` and `rates` (n, y.size).
    """
    size = y.size
    stages, new = np.empty((STAGES, size)), np.empty(size)
    time, h = 0.0, 0.02
    flow(phase, y, p, stages[0], numbers)
    for i in range(times.size):
        while times[i] - time > SAME:
            left = times[i] - time
            step = min(h, left)
            take_step(phase, y, step, p, stages, new, numbers)
            error = error_norm(y, new, step, p, stages, tolerance)
            if not error <= 1.0:  # written so that NaN is refused
                h = step * (step_factor(error) if error == error else 0.1)
                if h < SAME:
                    return False
                continue
            time = times[i] if step == left else time + step
            for j in range(size):
                y[j] = new[j]
            flow(phase, y, p, stages[0], numbers)
            h = max(h, step * step_factor(error)) if step < h else step * step_factor(error)
        for j in range(size):
            states[i, j] = y[j]
            rates[i, j] = stages[0, j]
    return True


@compiled
def arrive(phase: int, y: Vector, p: Any, numbers: Directions) -> None:
    """Variations at a fixed time of a state `y` at its phase's event become variations at the event, in place."""
    event, rates = y.copy(), np.empty(y.size)
    flow(phase, event, p, rates, numbers)
    shift_to_event(phase, y, p, event, rates, HIP if of_hip(phase, event, p) else FEET, numbers)


NO_NODES = np.empty((0, 10))


@dataclass(frozen=True)
class Stretch:
    """One phase of a walk, dimensionless. Last axes hold a value, then its derivatives by c columns.

    It starts at `start` (1 + c,) since the walk's first state and lasts `duration` (1 + c,), with leg `stance_leg`
    (0 or 1) standing. `edges` (p + 1,) bound its panels, since its start. `states` and `rates` (n, size, 1 + c) are y
    and dy/dt in the panels' n nodes, derived at fixed times. `begin` and `end` (size, 1 + c) are the states after and
    before the events, which move with them. `ends_step`: that is a heel strike. In `double` stance both feet bear.
    """

    stance_leg: int
    start: Vector
    duration: Vector
    edges: Vector
    states: np.ndarray
    rates: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    ends_step: bool
    double: bool

    def at(self, since: float | Vector, orders: int = 3) -> np.ndarray:
        """State, rate and further derivatives, (..., orders, size, 1 + c), derived at fixed times (...) since the
        stretch began. More than a panel before or after it they stay as they are there, as powers have no end.
        """
        since = np.clip(since, 2 * self.edges[0] - self.edges[1], 2 * self.edges[-1] - self.edges[-2])
        panel = np.clip(np.searchsorted(self.edges, since, "right") - 1, 0, len(self.edges) - 2)
        begin, half = self.edges[panel], 0.5 * (self.edges[panel + 1] - self.edges[panel])
        powers = ((since - begin) / half - 1.0)[..., None, None] ** EXPONENTS[:orders] * FACTORS[:orders]
        weights = powers @ HERMITE * half[..., None, None] ** -ORDERS[:orders, None]
        weights[..., NODES:] *= half[..., None, None]
        nodes = panel[..., None] * NODES + np.arange(NODES)
        known = np.concatenate([self.states[nodes], self.rates[nodes]], axis=-3)
        found = weights @ known.reshape(*known.shape[:-2], -1)
        return np.asarray(found.reshape(*found.shape[:-1], *self.states.shape[1:]))

    def upright(self) -> float | None:
        """When its stance leg passes through the normal of the slope, forwards, since it began; None if it does not."""
        theta = self.states[:, 0, 0]
        if not theta[0] < 0.0 < theta[-1]:
            return None
        panel = int(np.argmax(theta > 0.0)) // NODES
        return float(brentq(lambda since: self.at(since)[0, 0, 0], self.edges[max(panel - 1, 0)],
                            self.edges[panel + 1], xtol=1e-14))  # fmt: skip


def walk_stretches(
    walker: Walker, begin: Vector, along: np.ndarray, tolerance: float, first_leg: int
) -> Iterator[Stretch]:
    """The stretches of a walk from mid-stance on, one after another without end.

    It begins in single stance on leg `first_leg` with the state `begin` (size,), or upright, (size - 1,), without
    theta, which is zero. There what springs do fades soon; just after a heel strike it would move the next events too,
    and a fit could not separate it from the strike's time. Columns: the entries of `begin`, then the changes of the
    walker's numbers `along` (n, fields of `walker.p`), in whose own step leg 0 stands. Raises StepFailed like
    `poincare_map`.
    """
    if walker.timed:
        raise StepFailed("the walk of a calibration knows no strike at a given time")
    tolerance = attainable_tolerance(walker.p, tolerance)
    size, free = walker.size, len(begin)
    rows = along, exchanged_rows(walker, along)  # of the walker on either leg
    p, numbers = walker.on(first_leg).p, directions(rows[first_leg], free + len(along))
    variations = np.zeros((free + len(along), size))
    variations[range(free), range(size - free, size)] = 1.0
    y = np.concatenate([np.zeros(size - free), begin, variations.ravel()])
    start, leg, phases = 0.0, first_leg, 0
    fastest = fastest_rate(walker.p)
    phase, decided = int(single_stance(y[:size], p)), True
    while True:
        phases += 1
        if not decided or phases > MOST_PHASES:
            require_landing(walker, y, WEDGED if not decided else CHATTER, phase)
        event, end, before = y[:size].copy(), y.copy(), numbers.delays.copy()
        status, duration, _, _, _ = integrate(
            phase, event, p, tolerance, TIME_LIMIT_OF_A_PHASE, STEP_LIMIT_OF_A_PHASE, FIRST_LENGTH, NO_NODES,
            None)
        if status != EVENT:
            require_landing(walker, event, status, phase)
        lands = bool(ends_step(phase, event, p))
        if duration > 0.0:  # a trailing foot may leave at once
            edges = panel_edges(duration, fastest)
            times = panel_nodes(edges)
            states, rates = np.empty((times.size + 1, y.size)), np.empty((times.size + 1, y.size))
            if not march(phase, end, p, numbers, tolerance, np.append(times, duration), states, rates):
                raise StepFailed("no integration step is short enough")
            end[:size] = event
            arrive(phase, end, p, numbers)
            yield Stretch(
                leg, np.append(start, before), np.append(duration, numbers.delays - before), edges,
                _columns(states[:-1], size), _columns(rates[:-1], size), _columns(y, size)[0], _columns(end, size)[0],
                lands, bool(in_contact(phase)))
        start += duration
        y, ended = end, phase
        phase, decided = succeed(phase, y, p, numbers)
        if lands:
            leg, phases = 1 - leg, 0
            require_landing(walker, y, EVENT, ended)
            p, numbers = walker.on(leg).p, Directions(directions(rows[leg], 0).rows, numbers.delays)


def _columns(rows: np.ndarray, size: int) -> np.ndarray:
    """Rows that hold a state and its variations one after another, as (n, size, 1 + c)."""
    return rows.reshape(-1, rows.shape[-1] // size, size).transpose(0, 2, 1).copy()
