from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from stages.comparison.agreement import between_cycles, creep_velocity, from_same_start, overlay
from stages.comparison.stride import last_stride
from tests.comparison.made_up import make_walk


def test_a_known_offset_is_found_with_its_sign_and_axis_and_none_from_itself():
    walk = make_walk()
    for position, velocity in (((0.0, 0.0), (0.0, 0.0)), ((-2e-3, 1e-3), (0.01, -0.02))):
        other = dataclasses.replace(
            walk, hip_position=walk.hip_position + position, hip_velocity=walk.hip_velocity + velocity)
        laid, found = overlay(walk, other, 1.0), from_same_start(walk, other, 1.0)
        for signed, largest, added in zip((laid.position, laid.velocity), (found.position, found.velocity),
                                          (position, velocity), strict=True):  # fmt: skip
            assert signed == pytest.approx(np.broadcast_to(added, signed.shape), abs=1e-15)
            assert largest == pytest.approx(np.abs(added), abs=1e-15)


def test_velocities_between_the_two_heel_strikes_are_not_compared():
    """A walk that strikes 5 ms earlier has had its jump while the other has not."""
    walk = make_walk()
    strikes = walk.heel_strike_time - 5e-3
    velocity = walk.hip_velocity.copy()
    for early, late in zip(strikes, walk.heel_strike_time):
        velocity[(walk.time >= early) & (walk.time <= late), 0] += 0.03
    other = dataclasses.replace(walk, heel_strike_time=strikes, hip_velocity=velocity)
    assert overlay(walk, other, 1.0).velocity[:, 0].max() > 0.029
    assert from_same_start(walk, other, 1.0).velocity[0] < 1e-9


def test_only_the_asked_duration_counts():
    walk = make_walk()
    late = walk.hip_position.copy()
    late[:, 0] += np.maximum(2.0 * (walk.time - 1.0), 0.0)
    other = dataclasses.replace(walk, hip_position=late)
    assert from_same_start(walk, other, 0.9).position[0] == pytest.approx(0.0, abs=1e-12)
    assert from_same_start(walk, other, 1.5).position[0] == pytest.approx(1.0)


def test_different_sampling_does_not_make_a_difference_of_straight_motion():
    walk = make_walk()
    rows = np.union1d(np.random.default_rng(0).choice(len(walk.time), 3000, replace=False), [0, len(walk.time) - 1])
    thin = dataclasses.replace(
        walk, time=walk.time[rows], hip_position=walk.hip_position[rows], hip_velocity=walk.hip_velocity[rows]
    )
    assert from_same_start(walk, thin, 1.0).position[0] < 1e-12


def test_cycles_are_compared_at_equal_phase_and_from_equal_start():
    fast, slow = make_walk(period=0.5, speed=0.3), make_walk(period=0.5, speed=0.31)
    difference = between_cycles(last_stride(fast, 101), last_stride(slow, 101))
    assert difference.position[0] == pytest.approx(0.01, rel=1e-6), "0.01 m/s over a stride of 1 s"


def test_creep_is_the_slip_of_the_one_loaded_foot():
    walk = make_walk()
    slip = np.full((len(walk.time), 2), 0.005)
    assert creep_velocity(walk, slip) == pytest.approx(0.005)
    both = dataclasses.replace(walk, ground_reaction=np.ones_like(walk.ground_reaction))
    assert creep_velocity(both, slip) == 0.0, "double stance is not counted"
