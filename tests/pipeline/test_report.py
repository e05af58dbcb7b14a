"""The report: made of intact results only, never written without need, the same bytes without times."""

from __future__ import annotations

import pytest

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
    path.write_text("")
    assert page.refresh(done.study()) == path


def test_without_times_the_same_results_give_the_same_bytes(done):
    first = bare(done)
    done.run(force=True)
    assert bare(done) == first
    assert b"seconds" not in first.lower().split(b"<main")[1]


def test_it_states_the_parameters_that_were_used(done):
    done.run("ground.contact_stiffness=2e5")
    text = bare(done).decode()
    row = next(line for line in text.splitlines() if ">contact_stiffness<" in line)
    assert ">2e5<" in row and "set for this run; the file says 1e5" in row


def test_it_does_not_list_what_no_file_states_and_nobody_set(done):
    assert b">label<" not in bare(done)
    done.run("fall.label=mine")
    text = bare(done).decode()
    row = next(line for line in text.splitlines() if ">label<" in line)
    assert ">mine<" in row and "set for this run; the file does not state it" in row


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


def test_the_page_names_no_other_place(done):
    assert b"://" not in bare(done)


def test_run_all_writes_it_and_the_command_marks_what_is_stale(toy_with_commands):
    toy = toy_with_commands
    assert toy.command("report")[0] == 2
    code, out, errors = toy.command("run-all")
    assert (code, errors) == (0, "") and out.splitlines()[-1].split() == ["report", "written", "results/report.html"]
    toy.edit("params/fall.yaml", "value: 2", "value: 3")
    code, out, errors = toy.command("report", "--into", "page.html", "--no-times")
    assert (code, out) == (0, "written: page.html\n")
    assert errors == ("note: not current: fall, bounce, picture (fall.yaml: height 2 -> 3); make them current with: "
                      "bipedstudy run picture; the page says so\n")  # fmt: skip
    assert "fall.yaml: height 2 -&gt; 3" in (toy.root / "page.html").read_text(encoding="utf-8")
