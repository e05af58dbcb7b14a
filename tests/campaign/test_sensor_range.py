"""The spike at heel strike follows the contact set; the time above the sensor's range hardly does."""

import pytest

from stages.biped.walk import StanceState
from stages.campaign.run import spike
from tests.imu.made_walks import campaign_parameters

#: A mid-stance that leads to steps; the numbers are no result of the study.
ROUGH = StanceState(0.0, 0.331, 0.27, 0.334, 0.71, 0.0, 1.8, 0.0)


@pytest.fixture(scope="module")
def parameters():
    return campaign_parameters()


def test_softer_ground_lowers_the_spike_and_not_the_time_above_range(parameters):
    own, soft = (spike(share, ROUGH, 9.4, parameters) for share in (1.0, 4.0))
    assert own.contact_stiffness == parameters.contact.contact_stiffness > soft.contact_stiffness
    assert own.hip_peak > 3.0 * soft.hip_peak and own.foot_peak > 2.0 * soft.foot_peak
    assert 0.5e-3 < own.time_above_range < 2.0 * soft.time_above_range < 8e-3


def test_a_fall_is_told_by_nan(parameters):
    slow = StanceState(0.0, 0.331, 0.27, 0.334, -0.4, 0.0, 0.0, 0.0)
    found = spike(1.0, slow, 9.4, parameters)
    assert found.hip_peak != found.hip_peak and found.time_above_range != found.time_above_range
