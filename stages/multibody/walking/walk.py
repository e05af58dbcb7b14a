"""Let the planar multibody biped walk: the one entry for everything that needs such a walk."""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Collection

import numpy as np
from scipy.interpolate import PchipInterpolator

from stages.biped.design import Biped
from stages.biped.frames import specific_force
from stages.biped.sampling_times import refined_times
from stages.biped.walk import Walk
from stages.ground.blocks import Lane
from stages.ground.contact_law import ContactLaw
from stages.ground.operations import SCALARS
from stages.ground.slope import Slope
from stages.multibody.assembly.signals import SIGNALS
from stages.multibody.assembly.solver import Assembly, Run, integrate
from stages.multibody.assembly.state import PlanarState
from stages.multibody.parameters import Settings
from stages.multibody.walking.events import find_events
from stages.multibody.walking.scuffing import Watch
from stages.multibody.walking.trajectory import Trajectory, foot_kinematics


def build(
    biped: Biped,
    slope: Slope,
    contact: ContactLaw,
    settings: Settings,
    lanes: tuple[Lane, Lane] | None = None,
    *,
    compiled: bool = True,
    signals: Collection[str] = SIGNALS,
) -> Assembly:
    """The assembly that the settings choose, with sensors for `signals`, see `stages.multibody.assembly.signals`.

    `compiled=False` evaluates the contact in Python, for benchmarks.
    """
    if settings.assembly == "tree":
        from stages.multibody.assembly.tree import Tree

        return Tree(biped, slope, contact, lanes, compiled=compiled, signals=signals)
    from stages.multibody.assembly.joints import Joints

    return Joints(biped, slope, contact, lanes, compiled=compiled, signals=signals)


def simulate(
    biped: Biped,
    slope: Slope,
    contact: ContactLaw,
    state: PlanarState,
    settings: Settings,
    *,
    steps: int | None = None,
    duration: float | None = None,
    lanes: tuple[Lane, Lane] | None = None,
    assembly: Assembly | None = None,
) -> Run:
    """Walk from `state` at t = 0 through `steps` heel strikes (default: the settings') to the mid-stance after them.

    The walk ends in the solver step in which the hip passes over the foot that landed last, or after `duration` [s] if
    that is given. A fall, a standstill or a failure of the solver ends it earlier and is told by the run's outcome.
    With `lanes` the feet stand on stepping blocks instead of the ideal ground, see `stages.multibody.walking.scuffing`.
    Pass a built `assembly` of the same design (and the same lanes) to save building it again.
    """
    machine = assembly or build(biped, slope, contact, settings, lanes)
    if lanes:
        state = dataclasses.replace(state, in_play=_over_blocks(state, biped.foot_radius, lanes))
    standing = _standing(state, biped.foot_radius)
    watch = Watch(
        walker=machine,
        radius=biped.foot_radius,
        natural_length=biped.leg_length,
        longest_step=settings.longest_step,
        heel_strikes_wanted=(settings.steps if steps is None else steps) if duration is None else sys.maxsize,
        in_play=list(state.in_play),
        landed=standing,
        lanes=lanes,
        last_landed=1 if standing == [False, True] else 0,
        most_calls=settings.most_solver_steps,
    )
    return integrate(machine, state, watch, settings, duration)


def _standing(state: PlanarState, radius: float) -> list[bool]:
    """Which feet touch the ground while it acts on them."""
    reach = [(length - radius) * math.cos(angle) for length, angle in zip(state.leg_length, state.leg_angle)]
    return [acts and state.hip_position[1] - leg <= radius for acts, leg in zip(state.in_play, reach)]


def _over_blocks(state: PlanarState, radius: float, lanes: tuple[Lane, Lane]) -> tuple[bool, bool]:
    legs = zip(lanes, state.leg_length, state.leg_angle)
    place = [state.hip_position[0] + (length - radius) * math.sin(angle) for _, length, angle in legs]
    return lanes[0].presence(place[0], SCALARS) > 0.5, lanes[1].presence(place[1], SCALARS) > 0.5


def sample(trajectory: Trajectory, slope: Slope, radius: float, rate_hz: float) -> Walk:
    """Signals at even times, denser around heel strikes, with the exact times of heel strike and toe-off.

    Motion by Hermite interpolation between the solver's steps; forces and accelerations, which have kinks, by monotone
    cubics, so that a force is never negative between two steps, and is none where the foot does not touch. Forces and
    sensors that the trajectory does not hold have no rows.
    """
    events = find_events(trajectory, radius)
    time = refined_times(float(trajectory.time[-1]), rate_hz, events.heel_strike_time)
    position, velocity = trajectory.at(time)
    felt, loaded = trajectory.foot_acceleration.shape[1] > 0, trajectory.ground_reaction.shape[1] > 0
    turning = velocity[:, 2] if felt else np.zeros(0)

    def force_at(acceleration: np.ndarray) -> np.ndarray:
        if not felt:
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
        ground_reaction=ground_reaction(trajectory, time, radius) if loaded else np.zeros((0, 2, 2)),
        hip_specific_force=force_at(trajectory.acceleration[:, :2]),
        hip_angular_velocity=turning.copy(),
        foot_specific_force=force_at(trajectory.foot_acceleration),
        foot_angular_velocity=turning.copy(),
        heel_strike_time=events.heel_strike_time,
        heel_strike_leg=events.heel_strike_leg,
        toe_off_time=events.toe_off_time,
        toe_off_leg=events.toe_off_leg,
    )


def ground_reaction(trajectory: Trajectory, time: np.ndarray, radius: float) -> np.ndarray:
    """Force of the ground on each foot at the given times [s], (n, 2 legs, 2) [N]: monotone between the solver's steps.

    So it is never negative between two steps, and it is none where the foot does not touch.
    """
    position, velocity = trajectory.at(time)
    depths = [foot_kinematics(position, velocity, leg, radius)[0] for leg in (0, 1)]
    touching = (np.column_stack(depths) > 0.0) & trajectory.in_play(time)
    forces = np.asarray(PchipInterpolator(trajectory.time, trajectory.ground_reaction)(time))
    return np.asarray(forces * touching[:, :, None])
