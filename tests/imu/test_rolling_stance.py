"""Gravity that turns tells a gyroscope's gain, the rate's change the sensor's height; a step's error follows."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from stages.imu.judgement.evidence import confirmed, swept
from stages.imu.result import Evidence
from tests.imu.stand_in import BIPED, PARAMETERS

SLOPE, STANCES = math.radians(2.0), (np.array([0.0, 1.0, 2.0]), np.array([0.45, 1.45, 2.45]))


def stood(gain: float, arm: float, drift: float = 0.0) -> tuple[float, ...]:
    """What is found of a foot that rolls, from its place in the plane by differences: no formula of the law's."""
    time = np.arange(-0.2, 2.8, 0.005)
    fine = np.arange(-0.2, 2.8, 0.0001)
    theta = -(0.25 * np.cos(2 * np.pi * fine) + 0.03 * np.sin(6 * np.pi * fine))
    r = BIPED.foot_radius
    place = np.column_stack((r * theta + (arm - r) * np.sin(theta), r + (arm - r) * np.cos(theta)))
    second = np.gradient(np.gradient(place, fine, axis=0), fine, axis=0)
    felt = second - 9.81 * np.array([math.sin(SLOPE), -math.cos(SLOPE)])
    forward = felt[:, 0] * np.cos(theta) - felt[:, 1] * np.sin(theta)
    said = 0.01 + drift * time - gain * np.interp(time, fine, theta)  # as after a stand that is off
    felt, rate = np.interp(time, fine, forward), -gain * np.interp(time, fine, np.gradient(theta, fine))
    return swept(time, felt, rate, said, STANCES, SLOPE, 9.81, 0.3, r)


@pytest.mark.parametrize(("gain", "arm"), [(1.0, 0.3), (0.85, 0.3), (1.15, 0.27), (2.0, 0.3), (0.5, 0.1)])
def test_a_leg_that_stands_tells_its_gyroscopes_gain_and_its_length(gain: float, arm: float) -> None:
    found, error, height, drift = stood(gain, arm)
    assert (found, height) == pytest.approx((gain, arm), rel=5e-3)
    assert error < 1e-2 and drift == pytest.approx(0.01 / gain, rel=0.05)


def test_a_gyroscope_that_drifts_leaves_gravity() -> None:
    """By 0.01 rad/s to the middle of the last stance at 2.22 s, and what the stand was off."""
    assert stood(1.0, 0.3, 0.01)[3] == pytest.approx(0.0322, rel=0.03)


def test_a_leg_that_does_not_turn_tells_nothing() -> None:
    time = np.arange(-0.2, 2.8, 0.005)
    rng = np.random.default_rng(1)
    rate = 0.01 * rng.normal(size=len(time))
    none = swept(time, rng.normal(size=len(time)), rate, np.cumsum(rate) * 0.005, STANCES, SLOPE, 9.81, 0.3, 0.08)
    assert np.isnan(none).all()


def errors(**found: float) -> tuple[float, float]:
    nothing = Evidence(**{field.name: math.nan for field in dataclasses.fields(Evidence)})
    found = {f"{key}_error": 0.0 for key in ("hip_gain", "foot_gain") if key in found} | found
    return confirmed(dataclasses.replace(nothing, **found), PARAMETERS)


def test_the_error_of_a_step_follows_from_what_was_confirmed() -> None:
    one = math.hypot(PARAMETERS.drawing.swept_error, PARAMETERS.drawing.gain_error)
    assert errors(hip_gain=1.0, foot_gain=1.0, hip_arm=1.0)[0] == pytest.approx(one / math.sqrt(2))
    assert errors(foot_gain=1.0)[0] == pytest.approx(one), "one place tells less than two"
    assert errors(foot_gain=1.0, foot_gain_error=0.02)[0] == pytest.approx(math.hypot(0.02, 0.005)), "or its scatter"
    assert errors(hip_gain=1.1, foot_gain=1.1)[0] == pytest.approx(0.1, rel=0.01), "as far off as is found"
    assert errors(hip_gain=1.0, rate_ratio=1.1)[0] == pytest.approx(0.05, rel=0.05), "half of what the places differ by"
    every = PARAMETERS.limits.rate_scale_tolerance / math.sqrt(3)
    assert errors()[0] == pytest.approx(every), "all that is let through"
    assert errors()[1] == errors(hip_arm=1.005)[1] == PARAMETERS.drawing.leg_length_error
    assert errors(hip_arm=1.1)[1] == pytest.approx(0.1, rel=0.01)
    assert errors(foot_arm=0.9)[1] == pytest.approx(0.1, rel=0.01)
