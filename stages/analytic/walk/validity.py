"""Whether a gait of the constraint model keeps the assumptions the model makes.

The constraints are two-sided and stick at any force; ground is one-sided and slips. The report says by how much a
gait relies on forces that the ground could not give. With limited friction that is left to ask of the leading foot
alone, which rolls whatever it takes.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from stages.analytic.compiled import Numbers
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import Kind, Rigid, natural_lengths, radii
from stages.analytic.model.walker import Walker
from stages.analytic.phases.impact import heel_strike_reset, land, strike, trailing_impulse
from stages.analytic.phases.motion import in_contact
from stages.analytic.result import ROUND_OFF, Validity
from stages.analytic.walk.recording import Segment, in_single_stance, states_at
from stages.analytic.walk.sampling import accelerations_and_forces
from stages.biped.between_steps import largest, quadrature, spans_above

#: Times at which a phase is looked at first, in each of the integrator's steps.
SAMPLES_PER_STEP = 6
#: With more steps than this the steps themselves are dense enough.
ENOUGH_STEPS = 2000
#: A foot is loaded above this part of its largest normal force.
LOADED = 0.1
#: What round-off leaves of a force, in the walker's weight, where a foot is let go of.
NO_FORCE = 1e-13
#: Columns of the forces on the leading and on the trailing foot.
FEET = (slice(0, 2), slice(2, 4))
TANGENTIAL, NORMAL = 0, 1

#: A number at each of some states (n, size) with the forces (n, 4) on both feet.
Quantity = Callable[[np.ndarray, np.ndarray], np.ndarray]


#: Numbers of which the lowest is the worst, and those of which the highest is.
LOWEST = ("least_normal_force_stance", "least_normal_force_trailing", "impulse_normal_trailing", "feet_push_only")
HIGHEST = ("friction_single_stance", "friction_double_stance_loaded", "time_outside_cone", "impulse_outside_cone",
           "impulse_friction_landing", "impulse_friction_trailing")  # fmt: skip


def friction_used(forces: np.ndarray) -> float:
    """Largest |tangential| / normal of forces (n, 2); infinite where the ground would pull, 0 without force."""
    loaded = forces[np.abs(forces).max(axis=1) > 1e-12]
    if not loaded.size:
        return 0.0
    if (loaded[:, 1] <= 0).any():
        return float("inf")
    return float((np.abs(loaded[:, 0]) / loaded[:, 1]).max())


def dense_times(segment: Segment) -> np.ndarray:
    """Times of several points between the integrator's steps, and of the segment's end."""
    edges = np.append(segment.times, segment.duration)
    if len(segment.times) > ENOUGH_STEPS:
        return edges
    fractions = np.linspace(0, 1, SAMPLES_PER_STEP, endpoint=False)
    return np.append(edges[:-1, None] + np.diff(edges)[:, None] * fractions, segment.duration)


def dense_states(walker: Walker, segment: Segment) -> np.ndarray:
    """States of a segment at several points between the integrator's steps, and at its end."""
    times = dense_times(segment)[:-1]
    return np.vstack([states_at(segment.phase, segment.times, segment.states, times, walker.p), segment.end])


@dataclass(frozen=True)
class Phase:
    """A segment's solution: at any times since its start, and as it is at many of them."""

    walker: Walker
    segment: Segment

    @cached_property
    def times(self) -> np.ndarray:
        return dense_times(self.segment)

    @cached_property
    def dense(self) -> tuple[np.ndarray, np.ndarray]:
        """States and forces at `times`."""
        return self._with_forces(dense_states(self.walker, self.segment))

    def at(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States (n, size) and forces (n, 4) at rising times (n,)."""
        segment = self.segment
        return self._with_forces(
            states_at(segment.phase, segment.times, segment.states, np.ascontiguousarray(times), self.walker.p))

    def _with_forces(self, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return states, accelerations_and_forces(self.segment.phase, states, self.walker.p)[:, 4:8]

    def of(self, quantity: Quantity, times: np.ndarray) -> np.ndarray:
        """A quantity at rising times (n,)."""
        return quantity(*self.at(times))

    def largest(self, quantity: Quantity, span: tuple[float, float] | None = None) -> tuple[float, float]:
        """When and how large a quantity is at most, in the whole phase or in a span of it, ends included."""
        times, found = self.times, self.dense
        if span is not None:
            times = np.concatenate([span[:1], times[(times > span[0]) & (times < span[1])], span[1:]])
            found = self.at(times)
        return largest(times, quantity(*found), partial(self.of, quantity))

    def above(self, quantity: Quantity) -> list[tuple[float, float]]:
        """The spans in which a quantity is above zero."""
        return spans_above(self.times, quantity(*self.dense), partial(self.of, quantity))


def momentum(y: np.ndarray, p: Kind) -> np.ndarray:
    """Momentum (tangential, normal) of the whole walker, or its jump if the rates in `y` jump by what they are.

    It is what the ground's reaction to inertia alone, springs, dampers and gravity off, takes to bring the rates about.
    """
    inertia = p._replace(**dict.fromkeys({"k", "b", "g_x", "g_y"}.intersection(p._fields), 0.0))
    terms: Callable[..., Numbers] = eq.rigid_reaction if isinstance(p, Rigid) else eq.compliant_reaction
    half = y.size // 2
    return np.array(terms(*y[:half], *np.zeros(half), *y[half:], inertia))


def impulses(walker: Walker, before: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Impulses (tangential, normal) on the landing and on the trailing foot at heel strike, dimensionless.

    Momentum before and after is each in the names of its own step. What the trailing foot does not bear of its change,
    the landing foot does.
    """
    p, after = walker.p, before.copy()
    landed: Any = walker.exchanged.p
    if isinstance(p, Rigid):
        heel_strike_reset(after, p)
        return momentum(after, landed) - momentum(before, p), np.zeros(2)
    land(after, p)
    _, impulse, *_ = trailing_impulse(after, landed)
    strike(after, landed)
    trailing = np.array([impulse[1], impulse[0]])
    return momentum(after, landed) - momentum(before, p) - trailing, trailing


def load(_: np.ndarray, forces: np.ndarray, foot: slice, side: float = 1.0, least: float = 0.0) -> np.ndarray:
    """Normal force on a foot above `least`, or with `side` -1 its opposite."""
    return np.asarray(side * forces[:, foot][:, NORMAL] - least)


def least_normal(phases: list[Phase], foot: slice) -> float:
    """Least normal force on a foot in some phases, infinite without any."""
    return -max((phase.largest(partial(load, foot=foot, side=-1.0))[1] for phase in phases), default=-np.inf)


def most_friction(phase: Phase, foot: slice, span: tuple[float, float] | None = None) -> float:
    """`friction_used` by a foot in a phase, or in a span of it in which its normal force stays above zero."""
    sampled = friction_used(phase.dense[1][:, foot]) if span is None else 0.0
    if not np.isfinite(sampled) or (span is None and sampled == 0.0):
        return sampled

    def used(_: np.ndarray, f: np.ndarray, side: float) -> np.ndarray:
        return np.asarray(side * f[:, foot][:, TANGENTIAL] / f[:, foot][:, NORMAL])

    return max(phase.largest(partial(used, side=side), span)[1] for side in (1.0, -1.0))


def most_friction_loaded(phases: list[Phase], foot: slice) -> float:
    """The same while the foot's normal force is above the `LOADED` part of its largest in these phases."""
    least = LOADED * max((phase.largest(partial(load, foot=foot))[1] for phase in phases), default=0.0)
    if not least > 0.0:
        return 0.0
    return max((most_friction(phase, foot, span) for phase in phases
                for span in phase.above(partial(load, foot=foot, least=least))), default=0.0)  # fmt: skip


def outside_the_cone(phases: list[Phase], friction: float) -> tuple[float, float]:
    """Parts of the time and of the tangential impulse in which the trailing foot needs more than `friction`."""
    time = impulse = outside_time = outside_impulse = 0.0
    for phase in phases:
        edges = np.append(phase.segment.times, phase.segment.duration)

        def pushed(start: float, end: float, phase: Phase = phase, edges: np.ndarray = edges) -> float:
            times, weights = quadrature(edges, start, end)
            return float(weights @ np.abs(phase.at(times)[1][:, FEET[1]][:, TANGENTIAL]))

        def beyond(_: np.ndarray, forces: np.ndarray) -> np.ndarray:
            tangential, normal = forces[:, FEET[1]].T
            return np.asarray(np.abs(tangential) - friction * (1.0 + ROUND_OFF) * normal - NO_FORCE)

        time, impulse = time + edges[-1], impulse + pushed(0.0, edges[-1])
        for start, end in phase.above(beyond):
            outside_time, outside_impulse = outside_time + end - start, outside_impulse + pushed(start, end)
    return (float(outside_time / time), outside_impulse / impulse) if impulse > 0.0 else (0.0, 0.0)


def assess(walker: Walker, segments: list[Segment], friction: float) -> Validity:
    """Report on the segments of a gait's steps, from heel strike to heel strike, on ground with this static friction.

    Of several steps, the worst of each.
    """
    ends = [index + 1 for index, segment in enumerate(segments) if segment.last]
    steps = [segments[start:end] for start, end in zip([0, *ends], ends, strict=False)]
    return worst([assess_step(walker.on(step[0].stance_leg), step, friction) for step in steps])


def worst(steps: list[Validity]) -> Validity:
    """The worst of each number over some steps."""
    if len(steps) == 1:
        return steps[0]
    deepest = max(steps, key=lambda step: step.deepest_scuff)
    lowest = {name: min(getattr(step, name) for step in steps) for name in LOWEST}
    highest = {name: max(getattr(step, name) for step in steps) for name in HIGHEST}
    return replace(deepest, **lowest, **highest)


def assess_step(walker: Walker, segments: list[Segment], friction: float) -> Validity:
    """`assess` of one step; `walker` is the one in it."""
    alone = [Phase(walker, segment) for segment in segments if in_single_stance(segment)]
    before = [Phase(walker, segment) for segment in segments[: -len(alone)]]
    pressed = [phase for phase in before if in_contact(phase.segment.phase) and phase.segment.duration > 0.0]
    time_outside, impulse_outside = outside_the_cone(pressed, friction)
    landing, trailing = impulses(walker, segments[-1].end)
    p = walker.p
    lengths, radius = natural_lengths(p), radii(p)[1]

    def depth(states: np.ndarray, _: np.ndarray) -> np.ndarray:
        stance, psi, swing = (lengths[0], states[:, 1], lengths[1]) if walker.rigid else states[:, 1:4].T
        return np.asarray((swing - radius) * np.cos(psi) - (stance - p.r) * np.cos(states[:, 0]) - (p.r - radius))

    deepest, (when, scuff) = max(((phase, phase.largest(depth)) for phase in alone), key=lambda found: found[1][1])
    least = min(least_normal(alone, FEET[0]), least_normal(before, FEET[0]))
    unit, scuff = walker.force, 0.0 if walker.retracts else max(scuff, 0.0) * walker.length
    return Validity(
        least_normal_force_stance=least * unit,
        least_normal_force_trailing=least_normal(pressed, FEET[1]) * unit if pressed else 0.0,
        friction_single_stance=max(most_friction(phase, FEET[0]) for phase in alone),
        friction_double_stance_loaded=max(most_friction_loaded(pressed, foot) for foot in FEET),
        friction_there_is=friction,
        time_outside_cone=time_outside,
        impulse_outside_cone=impulse_outside,
        impulse_friction_landing=friction_used(landing[None, :]),
        impulse_friction_trailing=friction_used(trailing[None, :]),
        impulse_normal_trailing=float(trailing[1] * walker.mass * walker.length / walker.time),
        deepest_scuff=scuff,
        deepest_scuff_angle=float(deepest.at(np.array([when]))[0][0, 0]) if scuff else float("nan"),
        feet_push_only=bool(min(least, landing[1]) >= -1e-9 and trailing[1] >= -1e-9),
    )
