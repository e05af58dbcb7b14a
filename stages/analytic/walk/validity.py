"""Whether a gait of the constraint model keeps the assumptions the model makes.

The constraints are two-sided and stick at any force; ground is one-sided and slips. The report says by how much a
gait relies on forces that the ground could not give. With limited friction that is left to ask of the leading foot
alone, which rolls whatever it takes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from stages.analytic.compiled import Numbers
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import Kind, Limited, Rigid, natural_lengths, radii
from stages.analytic.model.walker import Walker
from stages.analytic.phases.coulomb_impact import land, strike, trailing_impulse
from stages.analytic.phases.succession import in_contact
from stages.analytic.phases.transitions import heel_strike_reset, landing_impulse
from stages.analytic.result import ROUND_OFF, Validity
from stages.analytic.walk.recording import Segment, in_single_stance, is_last, states_at
from stages.analytic.walk.sampling import accelerations_and_forces

SAMPLES_PER_STEP = 6
#: With more steps than this the steps themselves are dense enough.
ENOUGH_STEPS = 2000
#: A foot is loaded above this part of its largest normal force. Points of a phase by which shares of it are told.
LOADED, POINTS = 0.1, 2000
#: Columns of the forces on the leading and on the trailing foot.
FEET = (slice(0, 2), slice(2, 4))


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


def dense_states(walker: Walker, segment: Segment) -> np.ndarray:
    """States of a segment at several points between the integrator's steps, and at its end."""
    if len(segment.times) > ENOUGH_STEPS:
        return np.vstack([segment.states, segment.end])
    edges = np.append(segment.times, segment.duration)
    fractions = np.linspace(0, 1, SAMPLES_PER_STEP, endpoint=False)
    times = (edges[:-1, None] + (edges[1:] - edges[:-1])[:, None] * fractions).ravel()
    return np.vstack([states_at(segment.phase, segment.times, segment.states, times, walker.p), segment.end])


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
    if isinstance(p, Limited):
        land(after, p)
        _, _, impulse, *_ = trailing_impulse(after, landed)
        strike(after, landed)
        trailing = np.array([impulse[1], impulse[0]])
        return momentum(after, landed) - momentum(before, p) - trailing, trailing
    velocities, impulse, *_ = landing_impulse(before, p)
    after[4:] = np.asarray(velocities) - before[4:]
    landing = np.array([impulse[1], impulse[0]])
    return landing, momentum(after, p) - landing


def loaded(forces: np.ndarray) -> np.ndarray:
    """The forces (n, 2) whose normal part is above the `LOADED` part of the largest."""
    return np.asarray(forces[forces[:, 1] > LOADED * forces[:, 1].max(initial=0.0)])


def in_double_stance(walker: Walker, segments: list[Segment]) -> tuple[np.ndarray, np.ndarray]:
    """Evenly over each phase with both feet down: the time for which a row stands (n,), forces on both feet (n, 4).

    Dimensionless; columns are tangential and normal on the leading foot, then on the trailing one.
    """
    spans, forces = [np.zeros(0)], [np.zeros((0, 4))]
    for segment in segments:
        if in_contact(segment.phase):
            times = segment.duration * (np.arange(POINTS) + 0.5) / POINTS
            states = states_at(segment.phase, segment.times, segment.states, times, walker.p)
            spans.append(np.full(POINTS, segment.duration / POINTS))
            forces.append(accelerations_and_forces(segment.phase, states, walker.p)[:, 4:8])
    return np.concatenate(spans), np.concatenate(forces)


def outside_the_cone(spans: np.ndarray, forces: np.ndarray, friction: float) -> tuple[float, float]:
    """Parts of the time (n,) and of the tangential impulse in which forces (n, 2) need more than `friction`."""
    tangential, normal = np.abs(forces).T
    outside, impulse = tangential > friction * (1.0 + ROUND_OFF) * normal, tangential * spans
    if not impulse.sum() > 0.0:
        return 0.0, 0.0
    return float(outside @ spans / spans.sum()), float(outside @ impulse / impulse.sum())


def assess(walker: Walker, segments: list[Segment], friction: float) -> Validity:
    """Report on the segments of a gait's steps, from heel strike to heel strike, on ground with this static friction.

    Of several steps, the worst of each.
    """
    ends = [index + 1 for index, segment in enumerate(segments) if is_last(segment)]
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
    swings = [segment for segment in segments if in_single_stance(segment)]
    dense = [dense_states(walker, segment) for segment in swings]
    states = np.concatenate(dense)
    alone = np.concatenate([accelerations_and_forces(segment.phase, each, walker.p)[:, 4:6]
                            for segment, each in zip(swings, dense, strict=True)])  # fmt: skip
    before = segments[: -len(swings)]
    together = [
        accelerations_and_forces(segment.phase, dense_states(walker, segment), walker.p)[:, 4:8]
        for segment in before
    ]
    both = np.concatenate(together) if together else np.zeros((0, 4))
    pressed = [rows for rows, segment in zip(together, before, strict=True) if in_contact(segment.phase)]
    trailing_force = np.concatenate(pressed)[:, 2:] if pressed else np.zeros((0, 2))
    spans, evenly = in_double_stance(walker, before)
    time_outside, impulse_outside = outside_the_cone(spans, evenly[:, 2:], friction)
    landing, trailing = impulses(walker, segments[-1].end)
    p = walker.p
    lengths, radius = natural_lengths(p), radii(p)[1]
    stance, psi, swing = (lengths[0], states[:, 1], lengths[1]) if walker.rigid else states[:, 1:4].T
    clearance = (stance - p.r) * np.cos(states[:, 0]) - (swing - radius) * np.cos(psi) + (p.r - radius)
    lowest = int(np.argmin(clearance))
    unit = walker.force
    return Validity(
        least_normal_force_stance=float(min(alone[:, 1].min(), both[:, 1].min(initial=np.inf)) * unit),
        least_normal_force_trailing=float(trailing_force[:, 1].min() * unit) if trailing_force.size else 0.0,
        friction_single_stance=friction_used(alone),
        friction_double_stance_loaded=max(friction_used(loaded(evenly[:, foot])) for foot in FEET),
        friction_there_is=friction,
        time_outside_cone=time_outside,
        impulse_outside_cone=impulse_outside,
        impulse_friction_landing=friction_used(landing[None, :]),
        impulse_friction_trailing=friction_used(trailing[None, :]),
        impulse_normal_trailing=float(trailing[1] * walker.mass * walker.length / walker.time),
        deepest_scuff=float(max(-clearance[lowest], 0.0) * walker.length),
        deepest_scuff_angle=float(states[lowest, 0]),
        feet_push_only=bool(
            min(alone[:, 1].min(), both[:, 1].min(initial=0.0), landing[1]) >= -1e-9 and trailing[1] >= -1e-9
        ),
    )
