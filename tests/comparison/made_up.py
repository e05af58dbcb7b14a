"""A made-up walk: smooth, periodic, with known strides. Nothing in it comes from a model."""

from __future__ import annotations

import numpy as np

from stages.biped.walk import Walk


def make_walk(period: float = 0.5, steps: int = 8, speed: float = 0.3, first_periods: tuple[float, ...] = ()) -> Walk:
    """Heel strikes every `period` (after `first_periods`), legs in turn; signals are sines of the stride phase."""
    strikes = 0.2 + np.cumsum([0.0, *first_periods, *([period] * (steps - 1 - len(first_periods)))])
    time = np.linspace(0.0, strikes[-1] + 0.1, 4001)
    phase = 2 * np.pi * np.interp(time, strikes, 0.5 * np.arange(steps))
    legs = np.arange(steps) % 2
    two = np.column_stack([np.sin(phase), np.cos(phase)])
    # the ground carries leg 0 in the first half of its stride and leg 1 in the second
    share = np.column_stack([np.sin(phase) >= 0, np.sin(phase) < 0]).astype(float)
    return Walk(
        time=time,
        hip_position=np.column_stack([speed * time, 0.33 + 0.003 * np.sin(phase)]),
        hip_velocity=np.column_stack([speed + 0.1 * np.sin(phase), 0.02 * np.cos(phase)]),
        leg_angle=0.3 * two,
        leg_rate=2.0 * two,
        leg_length=0.333 + 0.002 * two,
        leg_length_rate=0.01 * two,
        ground_reaction=np.stack([share * np.array([0.5, -0.5]), 9.0 * share], axis=-1),
        hip_specific_force=np.column_stack([np.sin(phase), 9.8 + np.cos(phase)]),
        hip_angular_velocity=2 * np.sin(phase),
        foot_specific_force=np.column_stack([2 * np.sin(phase), 9.8 + 2 * np.cos(phase)]),
        foot_angular_velocity=2 * np.sin(phase),
        heel_strike_time=strikes,
        heel_strike_leg=legs,
        toe_off_time=strikes + 0.02,
        toe_off_leg=1 - legs,
    )
