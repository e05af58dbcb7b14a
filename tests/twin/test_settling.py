"""What is left of a transient in the mean of a walk's last steps, and how it is told."""

import numpy as np
import pytest

from stages.twin.result import Settling, with_doubt
from stages.twin.walking.measures import SETTLED_STEPS, transient_left

STEPS, DRAWN, LIMP = 13, 400, 0.3


def faded(rng, multipliers, steps=STEPS):
    """Two measures (steps,) of a walk that settles at zero, but for a limp that stays, by these two multipliers."""
    waves = np.array(multipliers)[:, None] ** np.arange(steps)
    pair = waves[0].imag.any()
    return [
        (waves[0] * complex(*rng.normal(size=2))).real + LIMP * (-1.0) ** np.arange(steps) if pair
        else rng.normal(size=2) @ waves.real + LIMP * (-1.0) ** np.arange(steps) for _ in (0, 1)
    ]  # fmt: skip


def drawn(rng):
    """Two real multipliers of any sign, or a complex pair, up to .85."""
    if rng.random() < 0.5:
        return rng.uniform(-0.85, 0.85, 2).astype(complex)
    one = rng.uniform(0.2, 0.85) * np.exp(1j * rng.uniform(0.1, 3.0))
    return np.array([one, one.conjugate()])


def test_a_gait_lies_within_what_the_transient_leaves():
    rng, covered, shares = np.random.default_rng(7), 0, []
    for _ in range(DRAWN):
        measures = faded(rng, drawn(rng))
        for measure, left in zip(measures, transient_left(*measures), strict=True):
            off = abs(measure[-SETTLED_STEPS:].mean())
            covered += not off > left
            shares.append(off / left)
    assert covered > 0.99 * 2 * DRAWN
    assert np.nanmedian(shares) > 0.02, "a bound that covers all by its size tells nothing"


def test_one_that_does_not_fade_and_a_short_walk_are_unknown():
    rng = np.random.default_rng(8)
    growing = faded(rng, 1.05 * np.exp([1.0j, -1.0j]))
    assert np.isnan(transient_left(*growing)).all()
    assert np.isnan(transient_left(*faded(rng, [0.5 + 0j, 0.2 + 0j], steps=9))).all()


@pytest.mark.parametrize(("value", "left", "text"), [
    (2.04205, 6.2e-4, "2.0421 ± 0.0007"), (160.31, 0.11, "160.3 ± 0.2"), (750.2, 3.0, "750 ± 3"),
    (2.04205, float("nan"), "2.042 (what is left of the transient is unknown)"),
])
def test_a_mean_is_told_with_the_digits_that_the_transient_leaves(value, left, text):
    assert with_doubt(value, left) == text


def test_a_frequency_is_as_unsure_as_its_period():
    nothing = np.zeros(0)
    gait = Settling(nothing, nothing, 1, 0.5, 2.0, 0.16, period_transient_s=2.4e-4, step_length_transient_m=1e-4)
    assert gait.frequency_text() == "2.0000 ± 0.0010 Hz" and gait.length_text() == "160.0 ± 0.1 mm"
