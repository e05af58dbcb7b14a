"""The path from the constraint model to the penalty model, one effect at a time, and the limits on it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.flow import RIGID, SINGLE_STANCE
from stages.analytic.walk.recording import Segment, crossing_state, is_last, record
from stages.analytic.walk.sampling import signals_at
from stages.biped.design import Biped
from stages.biped.gait import StanceState
from stages.error_budget.convergence import Convergence, Shares
from stages.error_budget.effects import CONTACT, switched
from stages.error_budget.split import telescoped
from stages.ground.contact_law import ContactLaw
from stages.ground.friction_coefficients import Friction
from stages.ground.slope import Slope
from stages.planar.trajectory import Trajectory


class ConstraintWalk:
    """Two steps of the constraint model from a mid-stance state, by default that of a gait, whose period is told."""

    def __init__(self, walker: Walker, point: FixedPoint, tolerance: float, start: Vector | None = None) -> None:
        self.walker, self.point = walker, point
        self.start = crossing_state(walker, point.z, tolerance) if start is None else start
        phase = RIGID if walker.rigid else SINGLE_STANCE
        self.segments: list[Segment] = record(walker, self.start, 2, tolerance, phase)

    @property
    def mid_stance(self) -> StanceState:
        """State at the start."""
        return self.walker.stance_state(self.start)

    @property
    def period(self) -> float:
        """Step period of the gait [s]."""
        return float(self.point.steps[0].period * self.walker.time)

    @property
    def heel_strikes(self) -> np.ndarray:
        """Times of both heel strikes [s]."""
        ends = [segment.start + segment.duration for segment in self.segments if is_last(segment)]
        return np.array(ends) * self.walker.time

    @property
    def standing_force(self) -> float:
        """Normal force on the standing foot at the start [N]."""
        return float(signals_at(self.walker, self.segments[:1], np.zeros(1))["ground_reaction"][0, 0, 1])

    def hip(self, time: np.ndarray) -> np.ndarray:
        """Hip at times [s] from the start, (n, 4); at heel strike the velocity after it."""
        order, last = np.argsort(time, kind="stable"), self.segments[-1]
        at = np.minimum(time[order] / self.walker.time, last.start + last.duration)
        found = signals_at(self.walker, self.segments, at)
        rows = np.column_stack([found["hip_position"], found["hip_velocity"]])
        return np.asarray(rows[np.argsort(order)])


def constraint_gait(
    biped: Biped, slope: Slope, tolerance: float, friction: Friction | None = None
) -> ConstraintWalk:
    """The gait. Raises NoGait or StepFailed."""
    return ConstraintWalk(*find_gait(biped, slope, tolerance, friction), tolerance)


def penalty_hip(trajectory: Trajectory, time: np.ndarray) -> np.ndarray:
    """Hip of a run of the penalty model at times [s], (n, 4)."""
    position, velocity = trajectory.at(time)
    return np.column_stack([position[:, :2], velocity[:, :2]])


#: What a model gives, as an array of one shape: the hip's curves, or a cycle's scalars beside them.
Outcome = np.ndarray
#: Effects that are on where others are in their limit.
LIMITS: tuple[frozenset[str], ...] = (frozenset(), *(frozenset({effect}) for effect in CONTACT))


class Limits:
    """The penalty model with some effects on and the others in their limit; every node is computed once.

    `outcome` walks with a contact law at a tolerance; `share` is the part left of an effect that is off.
    """

    def __init__(
        self,
        law: ContactLaw,
        share: float,
        outcome: Callable[[ContactLaw, float], Outcome],
        tolerance: float,
        limit_tolerance: float,
    ) -> None:
        self.law, self.share, self.outcome = law, share, outcome
        self.tolerance, self.limit_tolerance = tolerance, limit_tolerance
        self.shares: dict[frozenset[str], Shares] = {}
        self.whole: Outcome | None = None

    def at(self, on: frozenset[str]) -> Outcome:
        """Outcome with the effects `on`, the others in their limit."""
        if on == frozenset(CONTACT):
            if self.whole is None:
                self.whole = self.outcome(self.law, self.tolerance)
            return self.whole
        if on not in self.shares:
            self.shares[on] = Shares(
                *(self.outcome(switched(self.law, on, part * self.share), self.limit_tolerance) for part in (4, 2, 1))
            )
        return self.shares[on].limit

    def convergence(self, curves: Callable[[Outcome], Outcome], compared: np.ndarray) -> Convergence:
        """How the limits were approached; `curves` takes the hip (n, 4) out of an outcome."""
        shares = [Shares(*(curves(outcome) for outcome in self.shares[on])) for on in LIMITS]
        return Convergence.of(self.share, shares, compared)


def contributions(
    constraint: Outcome, fine: Outcome, coulomb: Outcome, limits: Limits, fine_penalty: Outcome
) -> tuple[np.ndarray, np.ndarray]:
    """Contributions in the order of `EFFECTS` (6, ...), and how they depend on which effect of contact is first (...).

    The path: constraint model; integrated finely; with Coulomb friction at the trailing foot; penalty model with both
    effects of contact in their limits; each switched on; integrated as it is. `fine_penalty` has both on. The effects
    of contact have the mean over both orders; what comes second is half the difference, see `Split`.
    """
    neither, creep, impact = (limits.at(on) for on in LIMITS)
    whole = limits.at(frozenset(CONTACT))
    first, last = (telescoped([neither, node, fine_penalty]) for node in (creep, impact))
    steps = telescoped([constraint, fine, coulomb, neither])
    mean = 0.5 * (first + last[::-1])
    return np.concatenate([steps, mean, [whole - fine_penalty]]), 0.5 * (first[0] - last[1])
