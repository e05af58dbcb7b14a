"""A proof beside the results: what claims and report say of it, by where it was made and of which parameters."""

from __future__ import annotations

import json

import pytest

from pipeline.commands import claims
from pipeline.report import page

TOLD = {"says": {"force": "proven for a toy"}, "picture": {"extra": False}}


@pytest.fixture
def ran(toy, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "settings"))
    toy.run()
    return toy.study()


def beside(study):
    (claim,) = claims.read(study).claims
    return claim.full_verdict


def test_proven_is_said_of_a_proof_of_the_very_design_that_was_made_here(ran):
    assert beside(ran) == "does not hold"
    before = page.seal(ran, page.entries(ran), True, {})
    content = json.dumps(TOLD).encode()
    claims.keep_proof(ran, content)
    assert beside(ran) == "does not hold (proven for a toy)"
    assert page.seal(ran, page.entries(ran), True, {}) != before
    shown = page.render(ran, page.entries(ran), False, {}).decode()
    assert "<strong>Proven for a toy.</strong>" in shown and "(proven for a toy)" in shown
    (ran.results / "proof.json").write_bytes(json.dumps({**TOLD, "picture": {"extra": True}}).encode())
    assert beside(ran) == "does not hold"


def test_a_file_from_elsewhere_or_an_edited_one_is_not_called_proven(ran):
    (ran.results / "proof.json").write_bytes(json.dumps(TOLD).encode())
    assert beside(ran) == "does not hold (a proof file says so, not checked here)"
    assert "A proof file says so, not checked here." in page.render(ran, page.entries(ran), False, {}).decode()
    claims.keep_proof(ran, json.dumps(TOLD).encode())
    (ran.results / "proof.json").write_bytes(json.dumps(TOLD, indent=1).encode())
    assert beside(ran) == "does not hold (a proof file says so, not checked here)"


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"{}", b'{"says": []}', b'{"says": {"force": "proven"}}',
                                     b'{"says": {"force": "x"}, "picture": []}'])  # fmt: skip
def test_what_is_no_proof_of_any_parameters_says_nothing(ran, content):
    (ran.results / "proof.json").write_bytes(content)
    assert claims.proven(ran) == {}


def test_a_study_without_a_stage_of_claims_has_its_report(toy, ran):
    graph = ran.root / "dvc.yaml"
    graph.write_text(graph.read_text().replace(", results/claims.yaml", ""))
    claims.keep_proof(ran, json.dumps(TOLD).encode())
    without = toy.study()
    assert claims.proven(without) == {}
    assert b"Proven for a toy" not in page.render(without, page.entries(without), False, {})
