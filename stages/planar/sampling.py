"""Turns what a solver recorded step by step into the signals of `Walk`."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from stages.biped.accuracy.scales import scales_of
from stages.biped.between_steps import refined_times
from stages.biped.design import Biped
from stages.biped.kinematics import specific_force
from stages.biped.walk import Walk
from stages.ground.slope import Slope
from stages.planar.events import find_events
from stages.planar.trajectory import Trajectory, foot_kinematics


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
    depths = [foot_kinematics(position, velocity, leg, radii[leg])[0] for leg in (0, 1)]
    touching = (np.column_stack(depths) > 0.0) & trajectory.in_play(time)
    forces = np.asarray(PchipInterpolator(trajectory.time, trajectory.ground_reaction)(time))
    return np.asarray(forces * touching[:, :, None])
