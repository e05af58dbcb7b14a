"""Numerical errors of claims: a verdict that they could change is not decided, all others stand."""

from __future__ import annotations

import dataclasses
import math

import pytest

from pipeline.commands.claims import Claim as Shown
from pipeline.commands.claims import as_text
from stages.comparison.claims import judge
from stages.comparison.claims.judge import judged
from stages.comparison.result import FAILS, HOLDS, UNDECIDED, UNKNOWN
from tests.comparison.test_claims import CASES, PARAMETERS, of

STABLE = CASES[3][0]


def beside(measured, **changes):
    """What looser solvers measure: the same but for these changes."""
    return of(measured, **{key: measured.numbers[key] + change for key, change in changes.items()})


def test_a_verdict_that_its_error_could_change_is_not_decided():
    far, near, above = (of(STABLE, multibody=value) for value in (0.985, 0.995, 1.02))
    for error in (1e-2, -1e-2):
        assert judged(PARAMETERS, far, beside(far, multibody=error)).verdict == HOLDS
        claim = judged(PARAMETERS, near, beside(near, multibody=error))
        assert claim.verdict == UNDECIDED and not claim.condition
        assert "multibody = 0.995 has a numerical error of 0.01, within which the verdict could" in claim.causes[-1]
        assert judged(PARAMETERS, above, beside(above, multibody=error)).verdict == FAILS
    assert judged(PARAMETERS, near, beside(near, multibody=1e-3)).verdict == HOLDS


def test_numbers_carry_what_they_differ_by_and_none_where_looser_solvers_have_none():
    claim = judged(PARAMETERS, STABLE, beside(STABLE, constraint=2e-9, multibody=-6e-7))
    assert [number.error for number in claim.numbers] == pytest.approx([2e-9, 6e-7])
    assert "± 6e-07" in str(claim.numbers[1]) and (claim.verdict, claim.beside) == (HOLDS, "")
    for looser in (None, of(STABLE, multibody=math.nan)):
        claim = judged(PARAMETERS, STABLE, looser)
        assert math.isnan(claim.numbers[1].error) and "±" not in str(claim.numbers[1])
        assert (claim.verdict, claim.beside) == (HOLDS, UNKNOWN)
    shown = as_text(Shown(**{**dataclasses.asdict(claim), "numbers": []}), 80)
    assert "stable_gait: holds (errors unknown here)\n" in shown


def test_a_claim_stands_where_looser_solvers_do_not_get_there():
    assert judge.measured_of(STABLE.about, None) is None
    assert judge.measured_of(STABLE.about, object()) is None, "an error that nobody foresaw"


def test_a_number_inside_of_a_tuple_is_named_and_changed():
    ladder = next(case[0] for case in CASES if case[0].about.id == "twin_like_simple")
    names, details = dict(judge.named(ladder.numbers)), ladder.numbers["details"]
    assert names["details.1.1"] == details[1][1]
    changed = judge.with_number(ladder, "details.1.1", 0.5)
    now = changed.numbers["details"]
    assert now[1] == (details[1][0], 0.5) and now[0] == details[0]
    assert of(changed, details=details) == ladder
