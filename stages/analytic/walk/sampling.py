"""Turns a recorded walk into the signals of `Walk`: hip motion, legs, ground reactions, virtual sensors."""

from collections.abc import Callable

import numpy as np

from stages.analytic.compiled import ByKind, Four, compiled
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import Compliant, Kind, Rigid, heights_of_mass, natural_lengths
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.motion import accelerations, in_contact
from stages.analytic.walk.recording import Segment, crossing, in_single_stance, states_at, walk_on
from stages.biped.between_steps import uniform_times
from stages.biped.kinematics import (
    Coordinate,
    Motion,
    constant,
    hip_motion,
    shifted,
    specific_force,
    stance_mass_motion,
    swing_point_motion,
)
from stages.biped.walk import StanceState, Walk

#: Columns of `accelerations_and_forces`: qdd (4), stance foot's force (tangential, normal), swing foot's force.
COLUMNS = 8


@compiled
def rigid_reaction(y: Vector, qdd: Four, p: Rigid) -> tuple[float, float]:
    """`reaction` of rigid legs."""
    tangential, normal = eq.rigid_reaction(y[0], y[1], y[2], y[3], qdd[0], qdd[2], p)
    return tangential, normal


@compiled
def compliant_reaction(y: Vector, qdd: Four, p: Compliant) -> tuple[float, float]:
    """`reaction` of compliant legs."""
    tangential, normal = eq.compliant_reaction(
        y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], qdd[0], qdd[1], qdd[2], qdd[3], p)
    return tangential, normal


#: Force of the ground on both feet, tangential and normal: reaction(y, qdd, p).
reaction: Callable[..., tuple[float, float]] = ByKind({Rigid: rigid_reaction, Compliant: compliant_reaction})


@compiled
def accelerations_and_forces(phase: int, states: np.ndarray, p: Kind) -> np.ndarray:
    """Accelerations and both feet's ground reactions at states of one phase, shape (n, 8)."""
    rows = np.zeros((states.shape[0], COLUMNS))
    for i in range(states.shape[0]):
        qdd, loads = accelerations(phase, states[i], p)
        tangential, normal = reaction(states[i], qdd, p)
        rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3] = qdd
        rows[i, 4], rows[i, 5], rows[i, 6], rows[i, 7] = tangential - loads[1], normal - loads[0], loads[1], loads[0]
    return rows


def coordinates(walker: Walker, states: np.ndarray, rows: np.ndarray) -> tuple[Coordinate, ...]:
    """theta, L_1, psi, L_2 with their rates, dimensionless."""
    if walker.rigid:
        theta = Coordinate(states[:, 0], states[:, 2], rows[:, 0])
        psi = Coordinate(states[:, 1], states[:, 3], rows[:, 2])
        stance, swing = (constant(length, theta) for length in natural_lengths(walker.p))
        return theta, stance, psi, swing
    return tuple(Coordinate(states[:, i], states[:, 4 + i], rows[:, i]) for i in range(4))


def sample_segment(walker: Walker, segment: Segment, times: np.ndarray) -> dict[str, np.ndarray]:
    """Dimensionless signals of one segment at `times` since its start, keyed by the fields of `Walk`.

    `walker` is the one in whose step leg 0 stands.
    """
    walker = walker.on(segment.stance_leg)
    states = states_at(segment.phase, segment.times, segment.states, times, walker.p)
    rows = accelerations_and_forces(segment.phase, states, walker.p)
    theta, stance_length, psi, swing_length = coordinates(walker, states, rows)
    radius, com = walker.p.r, heights_of_mass(walker.p)[segment.stance_leg]
    origin = np.full(times.size, segment.origin)
    hip = hip_motion(theta, stance_length, radius, origin)
    if segment.height != 0.0:
        hip.position[..., 1] += segment.height
    foot: Motion
    if segment.stance_leg == 0:
        foot = stance_mass_motion(theta, com, radius, origin)
        angle, rate = -theta.value, -theta.rate
    else:
        foot = swing_point_motion(hip, psi, shifted(swing_length, com))
        angle, rate = psi.value, psi.rate
    gravity = (walker.p.g_x, walker.p.g_y)
    order = [0, 1] if segment.stance_leg == 0 else [1, 0]
    return {
        "hip_position": hip.position,
        "hip_velocity": hip.velocity,
        "leg_angle": np.stack([-theta.value, psi.value], axis=-1)[:, order],
        "leg_rate": np.stack([-theta.rate, psi.rate], axis=-1)[:, order],
        "leg_length": np.stack([stance_length.value, swing_length.value], axis=-1)[:, order],
        "leg_length_rate": np.stack([stance_length.rate, swing_length.rate], axis=-1)[:, order],
        "ground_reaction": rows[:, 4:8].reshape(-1, 2, 2)[:, order],
        "hip_specific_force": specific_force(hip.acceleration, angle, gravity),
        "hip_angular_velocity": rate,
        "foot_specific_force": specific_force(foot.acceleration, angle, gravity),
        "foot_angular_velocity": rate,
    }


def signal_scales(walker: Walker) -> dict[str, float]:
    """SI value of one dimensionless unit of each signal."""
    length, time = walker.length, walker.time
    return {
        "hip_position": length, "hip_velocity": length / time, "leg_angle": 1.0, "leg_rate": 1 / time,
        "leg_length": length, "leg_length_rate": length / time, "ground_reaction": walker.force,
        "hip_specific_force": length / time**2, "hip_angular_velocity": 1 / time,
        "foot_specific_force": length / time**2, "foot_angular_velocity": 1 / time,
    }


def signals_at(walker: Walker, segments: list[Segment], times: np.ndarray) -> dict[str, np.ndarray]:
    """Signals in SI units at rising `times` (n,), dimensionless, of a walk, keyed by the fields of `Walk`; at the
    start of a segment as they are in it.
    """
    first = [0, *np.searchsorted(times, [segment.start for segment in segments[1:]]), len(times)]
    pieces = [sample_segment(walker, segment, times[begin:end] - segment.start)
              for segment, begin, end in zip(segments, first, first[1:], strict=False)]
    return {name: scale * np.concatenate([piece[name] for piece in pieces])
            for name, scale in signal_scales(walker).items()}


def sample_walk(walker: Walker, segments: list[Segment], sampling_rate: float) -> Walk:
    """The walk in SI units at even times, `sampling_rate` [Hz], from its first segment's start to the last end."""
    end = segments[-1].start + segments[-1].duration
    times = uniform_times(end * walker.time, sampling_rate) / walker.time
    signals = signals_at(walker, segments, times)
    strikes = [s for s in segments if s.last]
    lifts = lift_offs(segments) if not walker.rigid else [(s.start + s.duration, s.stance_leg) for s in strikes]
    return Walk(
        time=times * walker.time,
        **signals,
        heel_strike_time=np.array([(s.start + s.duration) * walker.time for s in strikes]),
        heel_strike_leg=np.array([1 - s.stance_leg for s in strikes]),
        toe_off_time=np.array([time * walker.time for time, _ in lifts]),
        toe_off_leg=np.array([leg for _, leg in lifts]),
    )


def walk_from_mid_stance(
    walker: Walker, z: Vector, steps: int, tolerance: float, sampling_rate: float
) -> tuple[Walk, StanceState]:
    """The walk from mid-stance on the step from section coordinates `z`, over `steps` whole steps and the begun one, as
    `sample_walk` gives it, and its state at the start in SI units.

    Raises StepFailed if the walker does not vault over its stance leg or does not get to the end.
    """
    upright, elapsed = crossing(walker, z, tolerance)
    segments = walk_on(walker, upright, steps, tolerance, elapsed)
    return sample_walk(walker, segments, sampling_rate), walker.stance_state(upright)


def lift_offs(segments: list[Segment]) -> list[tuple[float, int]]:
    """Dimensionless time at which the trailing foot leaves the ground for good in each step, and its leg.

    That is the end of the last phase with both feet on the ground, or heel strike where there is none.
    """
    lifts: list[tuple[float, int]] = []
    latest = None if in_single_stance(segments[0]) else segments[0].start
    for segment in segments:
        if in_contact(segment.phase):
            latest = segment.start + segment.duration
        elif segment.last:
            if latest is not None:
                lifts.append((latest, 1 - segment.stance_leg))
            latest = segment.start + segment.duration
    return lifts
