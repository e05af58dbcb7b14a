"""Numerical errors of claims: a verdict that they could change is not decided, all others stand."""

from __future__ import annotations

import dataclasses
import json
import math

import pytest

from pipeline.commands.claims import Claim as Shown
from pipeline.commands.claims import as_text
from pipeline.study import Study
from stages.biped.accuracy.tolerances import LEVELS, Level
from stages.comparison.claims import judge
from stages.comparison.claims.judge import judged
from stages.comparison.claims.verdict import FAILS, HOLDS, UNDECIDED, UNKNOWN
from tests.comparison.test_claims import CASES, PARAMETERS, ROOT, of

DRAFT = dataclasses.replace(PARAMETERS, level=Level("draft"))
STABLE = CASES[3][0]


@pytest.fixture
def errors(monkeypatch):
    table = {"draft": {STABLE.about.id: {"multibody": 1e-2}}}
    monkeypatch.setattr(judge, "measured_errors", lambda parameters, claim: table.get(
        parameters.level.level, {}).get(claim, {}))


@pytest.fixture
def measured(tmp_path, monkeypatch):
    """Keep these errors of claims as those measured with the study's own parameters."""

    def keep(**claims):
        kept = {"parameters": {"paper": judge.digest(parameters("paper"))}, "errors": {"paper": claims}}
        (tmp_path / "table.json").write_text(json.dumps(kept))
        monkeypatch.setattr(judge, "TABLE", tmp_path / "table.json")

    return keep


def test_a_verdict_that_its_error_could_change_is_not_decided(errors):
    far, near = (of(STABLE, multibody=value) for value in (0.985, 0.995))
    assert judged(DRAFT, far).verdict == HOLDS and judged(PARAMETERS, near).verdict == HOLDS
    claim = judged(DRAFT, near)
    assert claim.verdict == UNDECIDED and not claim.condition
    assert "multibody = 0.995 has a numerical error of 0.01, within which the verdict could" in claim.causes[-1]
    beyond = judged(DRAFT, of(STABLE, multibody=1.02))
    assert beyond.verdict == FAILS, "the margin is twice the error"


def test_numbers_carry_their_errors_by_name(errors):
    numbers = {number.name: number for number in judged(DRAFT, STABLE).numbers}
    assert numbers["multibody"].error == 1e-2 and "± 0.01" in str(numbers["multibody"])
    assert math.isnan(numbers["constraint"].error) and "±" not in str(numbers["constraint"])


def parameters(level, *settings):
    study = Study(ROOT, ROOT / "params", ROOT / "results", settings, asked=(("accuracy", level),))
    return study.parameters(("comparison",))["comparison"]


def test_errors_are_twice_what_was_measured_with_the_same_parameters_and_unknown_with_all_others(measured):
    measured(stable_gait={"constraint": 1e-9, "multibody": 3e-7})
    claim = judged(parameters("paper"), STABLE)
    assert [number.error for number in claim.numbers] == [2e-9, 6e-7]
    assert (claim.verdict, claim.beside) == (HOLDS, "")
    near = of(STABLE, multibody=1.0 - 1e-9)
    assert judged(parameters("paper"), near).verdict == UNDECIDED
    for setting in ("biped.hip_mass=0.316", "multibody.tolerance=3e-8", "twin_ladder.outsole=0.003",
                    "imu.skipped_steps=4"):  # fmt: skip
        claim = judged(parameters("paper", setting), near)
        assert all(math.isnan(number.error) for number in claim.numbers)
        assert (claim.verdict, claim.beside) == (HOLDS, UNKNOWN)
    shown = as_text(Shown(**{**dataclasses.asdict(claim), "numbers": []}), 80)
    assert "stable_gait: holds (errors unknown here)\n" in shown


def test_errors_of_a_claim_that_nobody_measured_yet_are_unknown(measured):
    measured()
    assert judged(parameters("paper"), STABLE).beside == UNKNOWN


def test_a_number_inside_of_a_tuple_is_named_and_changed():
    ladder = next(case[0] for case in CASES if case[0].about.id == "twin_like_simple")
    names, details = dict(judge.named(ladder.numbers)), ladder.numbers["details"]
    assert names["details.1.1"] == details[1][1]
    changed = judge.with_number(ladder, "details.1.1", 0.5)
    now = changed.numbers["details"]
    assert now[1] == (details[1][0], 0.5) and now[0] == details[0]
    assert of(changed, details=details) == ladder


def test_the_kept_errors_are_of_levels_and_claims_that_exist_and_shrink_with_the_level():
    kept = json.loads(judge.TABLE.read_text())["errors"]
    assert set(kept) == set(LEVELS[:-1])
    largest = {}
    for level, claims in kept.items():
        assert set(claims) == set(judge.STATEMENTS)
        largest[level] = [error for of in claims.values() for error in of.values()]
        assert all(error >= 0 for error in largest[level])
    smaller = [kept["paper"][claim][name] <= error for claim, of in kept["draft"].items() for name, error in of.items()
               if name in kept["paper"][claim] and error > 0]  # fmt: skip
    assert sum(smaller) > 0.8 * len(smaller)
