"""The report: made of intact results only, never written without need, the same bytes without times."""

import json

import pytest

from pipeline.commands import claims
from pipeline.errors import StudyError
from pipeline.report import page
from pipeline.report.page import entries


def bare(toy):
    study = toy.study()
    return page.render(study, entries(study), False, {})


def test_it_is_written_once_and_again_when_something_changed(done):
    study = done.study()
    path = page.refresh(study)
    assert path == done.root / "results/report.html"
    text = path.read_text(encoding="utf-8")
    assert "fell 4.91 m" in text and "does not hold" in text and entries(study)["fall"].key in text
    assert page.refresh(study) is None, "nothing changed"
    done.edit("params/ground.yaml", "standard value", "another book")
    assert page.refresh(done.study()) == path, "it shows sources, which stand in the parameter files"
    path.write_text(path.read_text(encoding="utf-8")[::-1], encoding="utf-8")
    assert page.refresh(done.study()) == path


def test_without_times_the_same_results_give_the_same_bytes(done):
    first = bare(done)
    done.run(force=True)
    assert bare(done) == first and b"://" not in first, "it names no other place"
    assert b"seconds" not in first.lower().split(b"<main")[1]


@pytest.mark.parametrize(("key", "value", "said"), [
    ("ground.contact_stiffness", "2e5", "the file says 1e5"), ("fall.label", "mine", "the file does not state it")])
def test_it_states_the_parameters_that_were_used_and_none_that_nobody_set(done, key, value, said):
    assert b">label<" not in bare(done)
    done.run(f"{key}={value}")
    row = next(line for line in bare(done).decode().splitlines() if f">{key.partition('.')[2]}<" in line)
    assert f">{value}<" in row and f"set for this run; {said}" in row


def test_half_widths_come_from_where_their_values_do_and_what_follows_a_null_is_not_said_to_be_set(done):
    done.edit("params/ground.yaml", "value: 1e5", "value: null")
    used = {"gravity": 9.81, "gravity half-width": 0.005, "contact_stiffness": 2e5,
            "static_friction": 1.2, "static_friction half-width": 0.1}  # fmt: skip
    rows = {row["key"]: (row["unit"], row["source"]) for row in page._parameters(done.study(), "ground", used)}
    assert rows["gravity half-width"] == ("m/s^2", "standard value")
    assert rows["static_friction half-width"] == ("1", "set for this run; the file says 1.1")
    assert rows["contact_stiffness"][1] == "follows from others, or was set for this run; the file says none"


def test_damaged_or_missing_results_are_refused_with_a_sentence(done):
    claims = done.root / "results/claims.yaml"
    claims.write_text("[]")
    with pytest.raises(StudyError, match=r"claims\.yaml was edited or damaged; put it right with: bipedstudy run"):
        bare(done)
    claims.unlink()
    with pytest.raises(StudyError, match=r"results/claims\.yaml is missing"):
        bare(done)


def test_a_figure_names_the_files_with_its_numbers():
    files = {f"results/figures/{name}": b"" for name in ("one.png", "two.html")}
    words = {"figures": [{"name": "one", "shows": ["fall", "side"]}, {"name": "two", "shows": ["fall"]}]}
    one, two = page._figures(files, words, {*files, "results/figures/one.csv", "results/fall.h5"})
    assert one["data"] == [("CSV", "figures/one.csv"), ("fall.h5", "fall.h5")]
    assert two["data"] == [("fall.h5", "fall.h5")]


def test_before_any_run_it_says_what_to_do(toy):
    with pytest.raises(StudyError, match="holds no result of fall, bounce, side, picture; make it with"):
        entries(toy.study())


def test_run_all_writes_it_and_the_command_marks_what_is_stale(ran):
    (ran.root / "results/report.html").unlink()
    assert ran.says("run-all").splitlines()[-1].split() == ["report", "written", "results/report.html"]
    ran.edit("params/fall.yaml", "value: 2", "value: 3")
    code, out, errors = ran.command("report", "--into", "page.html", "--no-times")
    assert (code, out) == (0, "written: page.html\n")
    assert errors == ("note: not current: fall, bounce, picture (fall.yaml: height 2 -> 3); make them current with: "
                      "bipedstudy run picture; the page says so\n")  # fmt: skip
    assert "fall.yaml: height 2 -&gt; 3" in (ran.root / "page.html").read_text(encoding="utf-8")
    assert json.loads(ran.says("report --json")) == {"written": "results/report.html", "not_current": {
        "fall": "fall.yaml: height 2 -> 3", "bounce": "input fall will be computed first",
        "picture": "input bounce will be computed first"}}  # fmt: skip
    ran.says("report --results elsewhere", code=2)


# --- A proof beside the results: what claims and report say of it, by where it was made and of which parameters.


TOLD = {"says": {"force": "proven for a toy"}, "picture": {"extra": False}}


@pytest.fixture
def study(done, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "settings"))
    return done.study()


def beside(study):
    (claim,) = claims.read(study).claims
    return claim.full_verdict


def test_proven_is_said_of_a_proof_of_the_very_design_that_was_made_here(study):
    assert beside(study) == "does not hold"
    claims.keep_proof(study, json.dumps(TOLD).encode())
    assert beside(study) == "does not hold (proven for a toy)"
    shown = page.render(study, page.entries(study), False, {}).decode()
    assert "<strong>Proven for a toy.</strong>" in shown and "(proven for a toy)" in shown
    (study.results / "proof.json").write_bytes(json.dumps({**TOLD, "picture": {"extra": True}}).encode())
    assert beside(study) == "does not hold"


def test_a_file_from_elsewhere_or_an_edited_one_is_not_called_proven(study):
    (study.results / "proof.json").write_bytes(json.dumps(TOLD).encode())
    assert beside(study) == "does not hold (a proof file says so, not checked here)"
    assert "A proof file says so, not checked here." in page.render(study, page.entries(study), False, {}).decode()
    claims.keep_proof(study, json.dumps(TOLD).encode())
    (study.results / "proof.json").write_bytes(json.dumps(TOLD, indent=1).encode())
    assert beside(study) == "does not hold (a proof file says so, not checked here)"


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"{}", b'{"says": []}', b'{"says": {"force": "proven"}}',
                                     b'{"says": {"force": "x"}, "picture": []}'])  # fmt: skip
def test_what_is_no_proof_of_any_parameters_says_nothing(study, content):
    (study.results / "proof.json").write_bytes(content)
    assert claims.proven(study) == {}


def test_a_study_without_a_stage_of_claims_has_its_report(done, study):
    graph = study.root / "dvc.yaml"
    graph.write_text(graph.read_text().replace(", results/claims.yaml", ""))
    claims.keep_proof(study, json.dumps(TOLD).encode())
    without = done.study()
    assert claims.proven(without) == {}
    assert b"Proven for a toy" not in page.render(without, page.entries(without), False, {})
