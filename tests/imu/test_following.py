"""What is null in imu.yaml and campaign.yaml follows the robot: Table 1's to the bit, others' by their own time."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from pipeline.study import locate
from stages.imu.sources.units import implied_acceleration_unit
from tests.imu.stand_in import device

ROOT = Path(__file__).parents[2]
SENSOR = ("rate_hz", "bandwidth_hz", "accelerometer_range_g", "gyroscope_range_deg_s")


def values(*settings):
    found = locate(start=ROOT, settings=settings).parameters(("campaign", "imu", "calibration"))
    sensor, read = found["campaign"].sensor, found["imu"].read
    assert found["calibration"].sensor == sensor and found["calibration"].ingest.read == read
    return ([getattr(sensor, name) for name in SENSOR], found["campaign"].push_s,
            [read.settings.gravity, read.settings.grid_rate_hz, read.settings.slowest_step_hz,
             read.settings.fastest_step_hz, read.settings.rest_rate_deg_s, read.settings.rest_acceleration],
            [read.limits.lever_arm, read.drawing.leg_length, read.drawing.foot_radius])  # fmt: skip


LONGER = ("biped.leg_length=1.332", "biped.foot_radius=0.332", "biped.foot_com=0.4", "biped.foot_mass=1.34")
#: What is set, and by it rate, cut-off and ranges of a sensor, push, windows and drawing; None: whatever it is.
FOLLOWING = {
    "Table 1": ((), [100.0, 40.0, 4.0, 2000.0], 0.4, [9.81, 200.0, 0.8, 4.0, 3.0, 0.3], [0.233, 0.335, 0.085]),
    # four times as long takes twice as long; the outsole is part of the robot
    "longer": (LONGER, [50.0, 20.0, 4.0, 1000.0], 0.8, [9.81, 100.0, 0.4, 2.0, 1.5, 0.3], [0.932, 1.34, 0.34]),
    "lighter": (("ground.gravity=2.4525",), [50.0, 20.0, 1.0, 1000.0], None,
                [2.4525, None, None, None, None, 0.075], [None] * 3),
    "given": (("ground.gravity=1.62", "campaign.rate_hz=200", "campaign.accelerometer_range_g=8", "campaign.push_s=0.3",
               "imu.gravity=9.81", "imu.lever_arm=0.2"),
              [200.0, 80.0, 8.0, None], 0.3, [9.81, *[None] * 5], [0.2, None, None]),
}  # fmt: skip


@pytest.mark.parametrize("robot", FOLLOWING)
def test_what_is_null_follows_the_robot_and_what_a_file_gives_stays(robot):
    settings, *expected = FOLLOWING[robot]
    for found, want in zip(np.hstack(values(*settings)), np.hstack(expected), strict=True):
        assert want is None or found == (want if not settings else pytest.approx(want, rel=1e-14))


@pytest.mark.parametrize(("settings", "outsole"), [
    ((), (2e-3, 2e-4, 1e-4)), (("biped.leg_length=0.4902", "biped.foot_mass=0.0335"), (2e-4, 2e-5, None))])
def test_rubber_weighs_no_larger_share_of_a_light_leg(settings, outsole):
    runs = locate(start=ROOT, settings=settings).parameters(("campaign",))["campaign"]
    own = runs.runs.of(runs.biped)
    assert (own.outsole, own.outsole_sd) == pytest.approx(outsole[:2], rel=1e-14)
    assert outsole[2] in (None, own.length_sd)


def test_so_do_the_calibration_and_the_ladder():
    names = ("settling_s", "before_strike_s", "after_strike_s", "foot_lag_sd_s", "mid_stance_sd_s", "begun_s",
             "start_length_sd", "start_length_rate_sd")  # fmt: skip

    def of(*settings):
        found = locate(start=ROOT, settings=settings).parameters(("calibration", "calibrated_twin", "twin_ladder"))
        assert found["calibrated_twin"].settings == found["calibration"].settings
        return [getattr(found["calibration"].settings, name) for name in names], found["twin_ladder"].settings.outsole

    assert of() == ([0.05, 0.01, 0.03, 0.002, 0.06, 0.15, 1e-3, 0.02], 2e-3)
    times, outsole = of("biped.leg_length=1.332", "biped.foot_radius=0.332", "biped.foot_com=0.4",
                        "biped.foot_mass=21.44", "calibration.begun_s=0.2")
    assert times == pytest.approx([0.1, 0.02, 0.06, 0.004, 0.12, 0.2, 4e-3, 0.04], rel=1e-14)
    assert outsole == pytest.approx(8e-3, rel=1e-14)


@pytest.mark.parametrize("gravity", [1.62, 9.81, 15.0])
def test_a_reading_at_rest_is_gravity_where_the_robot_walks(gravity):
    """Counts of a full scale that is no usual one, off by a gain's error."""
    sensor = dataclasses.replace(device("hip"), accelerometer_range_g=4.0 * gravity / 9.81)
    counts = 1.02 * gravity / 9.80665 * 2**15 / sensor.accelerometer_range_g
    said = f"counts of {sensor.accelerometer_range_g:g} g full scale"
    assert implied_acceleration_unit(counts, sensor, gravity) == said
