"""Agreement metrics against an independent library, closed forms and their own limits."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from stages.imu.trial.agreement import (
    agreement,
    bland_altman,
    envelope_share,
    frequency_difference,
    intraclass_correlation,
    multiple_correlation,
    nrmse,
    rmse,
)

#: Tables of so many targets and raters, drawn from a seed, and what Pingouin 0.7 finds for them.
TABLES = pytest.mark.parametrize(("targets", "raters", "seed", "found"), [
    (6, 2, 1, 0.7019369110023882), (20, 3, 2, 0.7524591012541919), (101, 5, 3, 0.8344651268472303),
])  # fmt: skip


def rated(targets: int, raters: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(targets, 1)) + 0.5 * rng.normal(size=raters) + 0.4 * rng.normal(size=(targets, raters))


@TABLES
def test_icc_is_what_pingouin_found(targets: int, raters: int, seed: int, found: float) -> None:
    assert intraclass_correlation(rated(targets, raters, seed)) == pytest.approx(found, abs=1e-9)


@pytest.mark.slow
@TABLES
def test_icc_is_that_of_pingouin(targets: int, raters: int, seed: int, found: float) -> None:
    import pandas as pd  # here: loading both takes two seconds of every process that collects tests
    import pingouin

    ratings = rated(targets, raters, seed)
    target, rater = np.indices(ratings.shape)
    table = pd.DataFrame({"target": target.ravel(), "rater": rater.ravel(), "rating": ratings.ravel()})
    oracle = pingouin.intraclass_corr(table, "target", "rater", "rating")
    single = float(oracle.loc[oracle["Type"].isin(["ICC(A,1)", "ICC2"]), "ICC"].iloc[0])
    assert intraclass_correlation(ratings) == pytest.approx(single, abs=1e-9)
    assert single == pytest.approx(found, abs=1e-9)


def test_icc_of_shrout_and_fleiss() -> None:
    """The worked example of Shrout and Fleiss (1979): ICC(2,1) = 0.29."""
    ratings = np.array([[9, 2, 5, 8], [6, 1, 3, 2], [8, 4, 6, 8], [7, 1, 2, 6], [10, 5, 6, 9], [6, 2, 4, 7]], float)
    assert intraclass_correlation(ratings) == pytest.approx(0.29, abs=0.005)


curves = arrays(float, 20, elements=st.floats(-100, 100))


@settings(max_examples=50)
@given(curves, st.floats(-50, 50))
def test_a_shifted_curve_has_the_shift_as_rmse_and_bias(curve: np.ndarray, shift: float) -> None:
    assert rmse(curve + shift, curve) == pytest.approx(abs(shift), abs=1e-9)
    bias, lower, upper = bland_altman(curve + shift, curve)
    assert (bias, upper - lower) == pytest.approx((shift, 0), abs=1e-9)


@settings(max_examples=50)
@given(curves)
def test_cmc_lies_between_zero_and_one_or_is_undefined(curve: np.ndarray) -> None:
    other = curve[::-1]
    value = multiple_correlation(np.stack([curve, other]))
    assert math.isnan(value) or 0 <= value <= 1


def test_a_correlation_of_equal_waveforms_is_one_and_of_opposite_ones_undefined() -> None:
    wave = np.sin(np.linspace(0, 2 * np.pi, 50))
    assert multiple_correlation(np.stack([wave, wave, wave])) == pytest.approx(1)
    assert math.isnan(multiple_correlation(np.stack([wave, -wave])))
    found = agreement(-wave, wave, wave - 0.1, wave + 0.1)
    assert not found.correlation_defined and math.isnan(found.correlation)
    assert math.isnan(nrmse(np.ones(5), np.zeros(5))), "a flat measurement has no normalised error"


def test_envelope_share_counts_phases_inside() -> None:
    lower, upper, curve = np.zeros(10), np.ones(10), np.linspace(-0.45, 1.35, 10)
    half = np.where(np.arange(10) < 5, np.nan, upper)
    assert envelope_share(curve, lower, upper) == pytest.approx(np.mean((curve >= 0) & (curve <= 1)))
    assert envelope_share(np.full(10, 0.5), lower, half) == 1
    assert math.isnan(envelope_share(curve, lower, np.full(10, np.nan)))


def test_confidence_interval_covers_the_truth_as_often_as_it_says() -> None:
    rng = np.random.default_rng(5)
    found = [frequency_difference(rng.normal(2.05, 0.02, 30), 2.08) for _ in range(2000)]
    covered = np.mean([one.lower <= -0.03 <= one.upper for one in found])
    assert covered == pytest.approx(0.95, abs=0.015)
