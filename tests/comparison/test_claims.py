"""Every verdict must be able to fall either way."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from made_up import make_agreement, make_budget, make_study

from stages.comparison import claims
from stages.comparison.agreement import ModelAgreement, TwinAgreement
from stages.comparison.claims import Claim
from stages.comparison.hip_motion import HipDifference
from stages.comparison.parameters import Settings
from stages.multibody.result import FrictionVariation

SETTINGS = Settings(3e-4, 5e-3, 101, 0.01, 0.05, 0.95, 3)


def analytic(
    frequency=2.08, stable=True, multiplier=0.6, neighbour=0.7, drift=0.0, needed=0.3, residual=1e-12, length=0.16
):
    return SimpleNamespace(
        gait=SimpleNamespace(
            step_frequency_hz=frequency,
            stable=stable,
            floquet_multipliers=np.array([[multiplier, 0.0]]),
            step_length_m=length,
        ),
        variations=(SimpleNamespace(name="hip_mass", change=0.05, multiplier_below=neighbour, multiplier_above=0.9),),
        constraint_drift=np.full(3, drift),
        validity=SimpleNamespace(
            impulse_friction_trailing=needed, friction_double_stance=needed, friction_single_stance=0.1
        ),
        energy=SimpleNamespace(residual=residual),
    )


def models(position=1e-4, velocity=1e-3, energy=1e-8):
    difference = HipDifference(np.full(2, position), np.full(2, velocity))
    return ModelAgreement(difference, np.full(2, velocity), difference, 0.0, 0.0, 0.005, energy)


def twin(steps=4, rms=0.01, above=0.0):
    return TwinAgreement(steps, 2.0, np.full(6, rms), 20.0, 30.0, 3.0, above)


def friction(change):
    """Halving and doubling the default moves the hip by 0.5 and 1 times `change` of a step."""
    variation = FrictionVariation("stiction_velocity", 2.0, 0.48, 0.16)
    return claims.friction_velocities([variation], 0.48, 0.16, 0.01, make_study(hip=0.16 * change))


def with_outsole(frequency):
    result = analytic()
    result.variations = (SimpleNamespace(name="outsole", change=0.006, frequency_above=frequency),)
    return result


CASES = [
    (friction(0.001), friction(0.05)),
    (claims.step_frequency(analytic(), SETTINGS), claims.step_frequency(analytic(frequency=2.2), SETTINGS)),
    (claims.stable_gait(analytic()), claims.stable_gait(analytic(stable=False))),
    (claims.multipliers_minimised(analytic()), claims.multipliers_minimised(analytic(neighbour=0.5))),
    (
        claims.twice_differentiated_constraints(analytic(drift=1e-3)),
        claims.twice_differentiated_constraints(analytic()),
    ),
    (claims.rolling_without_slip(analytic(), 1.1), claims.rolling_without_slip(analytic(needed=6.0), 1.1)),
    (claims.contact_set(make_study(hip=5e-4), SETTINGS), claims.contact_set(make_study(hip=2e-3), SETTINGS)),
    (claims.hip_displacement(models(), SETTINGS), claims.hip_displacement(models(position=1e-3), SETTINGS)),
    (claims.hip_velocity(models(), SETTINGS), claims.hip_velocity(models(velocity=1e-2), SETTINGS)),
    (
        claims.integration_tolerance(make_budget(integration=1e-4)),
        claims.integration_tolerance(make_budget()),
    ),
    (claims.twin_settles(twin()), claims.twin_settles(twin(steps=-1))),
    (claims.twin_like_simple(twin(), SETTINGS), claims.twin_like_simple(twin(rms=0.2), SETTINGS)),
    (claims.ramp_length(analytic()), claims.ramp_length(analytic(length=0.4))),
    (claims.sensor_range(twin()), claims.sensor_range(twin(above=1e-3))),
    (
        claims.measurement_encloses(make_agreement(), SETTINGS),
        claims.measurement_encloses(make_agreement(share=0.5), SETTINGS),
    ),
    (claims.outsole_slows(with_outsole(2.0)), claims.outsole_slows(with_outsole(2.1))),
    (claims.measurement_slower(make_agreement()), claims.measurement_slower(make_agreement(frequency=2.1))),
]


@pytest.mark.parametrize(("holding", "failing"), CASES, ids=[case[0].id for case in CASES])
def test_a_verdict_follows_the_numbers(holding, failing):
    assert holding.holds is True
    assert failing.holds is False
    assert holding.found != failing.found or holding.id == "stable_gait"


def test_the_claim_on_the_contact_set_says_whether_ground_yaml_holds_the_choice():
    assert "ground.yaml holds the chosen" in claims.contact_set(make_study(), SETTINGS).why
    assert "does not hold the chosen" in claims.contact_set(make_study(ground_is_choice=False), SETTINGS).why


def test_a_difference_that_cannot_be_split_decides_nothing():
    empty = dataclasses.replace(make_budget(), outcome="over one step: fall", step=None, cycle=None)
    assert claims.integration_tolerance(empty).holds is None
    assert "fall" in claims.integration_tolerance(empty).found


def test_synthetic_measurements_decide_nothing():
    assert claims.measurement_encloses(make_agreement("synthetic"), SETTINGS).holds is None
    assert claims.measurement_slower(make_agreement("synthetic")).holds is None
    assert "synthetic" in claims.measurement_encloses(make_agreement("synthetic"), SETTINGS).why


def test_a_design_without_neighbouring_gaits_still_gets_an_answer():
    lonely = analytic()
    lonely.variations = (
        SimpleNamespace(name="hip_mass", change=0.05, multiplier_below=float("nan"), multiplier_above=float("nan")),
    )
    assert claims.multipliers_minimised(lonely).holds is None


def test_claims_survive_yaml():
    awkward = Claim("an_id", 'quotes " and: colons', "µ ≤ 3 # not a comment", None, "line\nbreak")
    read = yaml.safe_load(claims.as_yaml([awkward, CASES[0][0]]))
    assert read[0] == {
        "id": "an_id",
        "stated": awkward.stated,
        "found": awkward.found,
        "holds": None,
        "why": awkward.why,
    }
    assert read[1]["holds"] is True
