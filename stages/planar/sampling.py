"""What is read of a recorded run between the solver's steps: heel strikes and toe-offs, peaks, signals of `Walk`."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import nan

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from stages.biped.accuracy.scales import scales_of
from stages.biped.between_steps import largest, refined_times
from stages.biped.design import Biped
from stages.biped.kinematics import specific_force
from stages.biped.walk import Walk
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import normal_force
from stages.ground.slope import Slope
from stages.planar.run import Recorded, Trajectory, foot_kinematics


@dataclass(frozen=True)
class Events:
    """Times [s] and legs (in the twin: pairs of legs) of heel strikes and toe-offs."""

    heel_strike_time: np.ndarray
    heel_strike_leg: np.ndarray
    toe_off_time: np.ndarray
    toe_off_leg: np.ndarray


def find_events(trajectory: Trajectory, radii: tuple[float, float]) -> Events:
    """Heel strikes and toe-offs of both feet, of these radii [m]."""
    rows = trajectory.position, trajectory.velocity
    depth = np.column_stack([foot_kinematics(*rows, leg, radii[leg])[0] for leg in (0, 1)])

    def depth_at(position: np.ndarray, velocity: np.ndarray, leg: int) -> float:
        return float(foot_kinematics(position, velocity, leg, radii[leg])[0])

    return located(trajectory, depth, depth_at)


def located(
    run: Recorded, depth: np.ndarray, depth_at: Callable[[np.ndarray, np.ndarray, int], float], within: float = 1e-15
) -> Events:
    """First touch-down and last lift-off of each leg between two moments at which it went out of play.

    `depth` (n, 2) [m] of its lowest point under level ground, `depth_at` the same of a leg from
    coordinates and rates (k,). A foot that bounces at heel strike counts once. A leg still on the ground at the end has
    no toe-off yet. Times are found `within` so many seconds.
    """
    touch_downs: list[tuple[float, int]] = []
    lift_offs: list[tuple[float, int]] = []
    depth = depth + run.under(run.time)
    for leg in (0, 1):
        for start, end, ended in _episodes(run, leg):
            inside = np.flatnonzero((run.time >= start) & (run.time <= end))
            touching = depth[inside, leg] > 0.0
            if not touching.any():
                continue
            first, last = inside[np.argmax(touching)], inside[len(inside) - 1 - np.argmax(touching[::-1])]
            if first > inside[0]:
                touch_downs.append((_crossing(run, depth_at, leg, first - 1, within), leg))
            if ended and last < inside[-1]:
                lift_offs.append((_crossing(run, depth_at, leg, last, within), leg))
    columns = []
    for events in (sorted(touch_downs), sorted(lift_offs)):
        columns += [np.array([time for time, _ in events]), np.array([leg for _, leg in events], dtype=np.int64)]
    return Events(*columns)


def _episodes(run: Recorded, leg: int) -> list[tuple[float, float, bool]]:
    """Spans in which the ground acts on a leg: start, end, and whether the span ended before the record did."""
    spans: list[tuple[float, float, bool]] = []
    begin = 0.0 if run.in_play_at_start[leg] else None
    for time, who, acts in run.switches:
        if who != leg:
            continue
        if acts:
            begin = time
        elif begin is not None:
            spans.append((begin, time, True))
            begin = None
    return spans if begin is None else [*spans, (begin, float(run.time[-1]), False)]


def _crossing(
    run: Recorded, depth_at: Callable[[np.ndarray, np.ndarray, int], float], leg: int, row: int, within: float
) -> float:
    """Time between two recorded rows at which a leg's lowest point is at the ground's surface."""
    at, block = run.after(row), float(run.under(run.time[row : row + 1])[0, leg])

    def depth(time: float) -> float:
        return depth_at(*at(time), leg) + block

    early, late = float(run.time[row]), float(run.time[row + 1])
    if depth(early) * depth(late) >= 0.0:
        return early if abs(depth(early)) <= abs(depth(late)) else late
    return float(brentq(depth, early, late, xtol=within, rtol=8.9e-16))


def peaks(
    trajectory: Trajectory, contact: ContactLaw, radii: tuple[float, float], start: float, end: float
) -> np.ndarray:
    """Largest normal force [N], NaN where none is recorded, and penetration [m] from start to end [s], of each leg's
    foot (2, 2 legs).

    Between the solver's steps by the contact law from the motion there, which is known to the steps' own order.
    """
    steps = trajectory.time[(trajectory.time > start) & (trajectory.time < end)]
    times = np.concatenate([[start], steps, [end]])
    recorded = trajectory.ground_reaction.shape[1] > 0

    def of_foot(time: np.ndarray, leg: int, kind: int) -> np.ndarray:
        depth, rate, _ = foot_kinematics(*trajectory.at(time), leg, radii[leg], trajectory.under(time)[:, leg])
        touches = trajectory.in_play(time)[:, leg]
        if recorded:  # there may be no ground between stepping blocks
            touches &= np.interp(time, trajectory.time, trajectory.ground_reaction[:, leg, 1]) > 0.0
        depth = np.where(touches, depth, 0.0)
        return np.asarray(normal_force(contact, depth, rate) if kind == 0 else depth)

    found = np.full((2, 2), nan)
    for leg in (0, 1):
        for kind in (0, 1) if recorded else (1,):
            found[kind, leg] = largest(times, of_foot(times, leg, kind), partial(of_foot, leg=leg, kind=kind))[1]
    return found


def sample(trajectory: Trajectory, biped: Biped, slope: Slope, rate_hz: float) -> Walk:
    """Signals at even times, denser around heel strikes, with the exact times of heel strike and toe-off.

    Motion by Hermite interpolation between the solver's steps; forces and accelerations, which have kinks, by monotone
    cubics, so that a force is never negative between two steps, and is none where the foot does not touch. Forces and
    sensors that the trajectory does not hold have no rows.
    """
    radii = biped.foot_radii
    events, pendulum_time = find_events(trajectory, radii), scales_of(biped, slope.gravity).time
    time = refined_times(float(trajectory.time[-1]), rate_hz, events.heel_strike_time, pendulum_time)
    position, velocity = trajectory.at(time)
    sensed, loaded = trajectory.foot_acceleration.shape[1] > 0, trajectory.ground_reaction.shape[1] > 0
    turning = velocity[:, 2] if sensed else np.zeros(0)

    def force_at(acceleration: np.ndarray) -> np.ndarray:
        if not sensed:
            return np.zeros((0, 2))
        between = np.asarray(PchipInterpolator(trajectory.time, acceleration)(time))
        return specific_force(between, position[:, 2], slope.gravity_vector)

    return Walk(
        time=time,
        hip_position=position[:, :2],
        hip_velocity=velocity[:, :2],
        leg_angle=position[:, 2:4],
        leg_rate=velocity[:, 2:4],
        leg_length=position[:, 4:],
        leg_length_rate=velocity[:, 4:],
        ground_reaction=ground_reaction(trajectory, time, radii) if loaded else np.zeros((0, 2, 2)),
        hip_specific_force=force_at(trajectory.acceleration[:, :2]),
        hip_angular_velocity=turning.copy(),
        foot_specific_force=force_at(trajectory.foot_acceleration),
        foot_angular_velocity=turning.copy(),
        heel_strike_time=events.heel_strike_time,
        heel_strike_leg=events.heel_strike_leg,
        toe_off_time=events.toe_off_time,
        toe_off_leg=events.toe_off_leg,
    )


def ground_reaction(trajectory: Trajectory, time: np.ndarray, radii: tuple[float, float]) -> np.ndarray:
    """Force of the ground on each foot at the given times [s], (n, 2 legs, 2) [N]: monotone between the solver's steps.

    So it is never negative between two steps, and it is none where the foot does not touch.
    """
    position, velocity = trajectory.at(time)
    ground = trajectory.under(time)
    depths = [foot_kinematics(position, velocity, leg, radii[leg], ground[:, leg])[0] for leg in (0, 1)]
    touching = (np.column_stack(depths) > 0.0) & trajectory.in_play(time)
    forces = np.asarray(PchipInterpolator(trajectory.time, trajectory.ground_reaction)(time))
    return np.asarray(forces * touching[:, :, None])
