"""What commands print fits the terminal: 80 columns, more where it is wider, down to 60 where it is narrower."""

import csv
import io
import json
import re
from dataclasses import make_dataclass

import pytest

from pipeline import layout
from pipeline.cache import artefact
from stages.biped.quantity import quantity
from tests import commands

#: Commands that answer from what lies there.
AT_ONCE = (
    "--help", "status", "graph", "claims", "doctor", "figures", "show analytic", "show twin", "show tradeoff",
    "run-all --dry-run", "run figures --dry-run --set biped.foot_radius=0.09", "clean --dry-run",
)  # fmt: skip
#: Commands that compute.
ASKED = (
    "gait", "gait --all", "sensitivity", "basin --points 4 --steps 4", "continue ground.slope_deg 1.8:2.2",
    "design --iterations 2", "ingest results/measurements.sqlite",
)  # fmt: skip

SWEEP = "stage: fall\nkind: grid\nvary:\n  fall.height: [0.5, 1.0, 2.0]\n"


def too_wide(text: str, columns: int) -> list[str]:
    """Lines that are wider and could be folded: a word that is too long for a line stands alone in one."""
    return [line for line in text.splitlines() if len(line) > columns and len(line.split()) > 1]


@pytest.fixture(scope="module")
def study(repository):
    if not (repository / "results/claims.yaml").exists():
        pytest.skip("results are not there: bipedstudy run-all")
    return repository


@pytest.mark.parametrize("typed", [AT_ONCE, *(pytest.param((one,), marks=pytest.mark.slow) for one in ASKED)])
def test_a_command_and_an_answer_fit_80_columns(typed, study):
    for words, (code, text, errors) in commands.each(*typed, cwd=study, COLUMNS="80").items():
        if any(said in errors for said in ("made by an earlier version", "do not fit this version")):
            pytest.skip("the results are of an earlier version: bipedstudy run-all")
        assert code == 0 and text and not too_wide(text, 80), f"{words}: {text}{errors}"


def test_commands_of_the_toy_study_fit_narrow_terminals_and_rows_of_a_sweep_are_told_as_csv(ran):
    (ran.root / "sweep.yaml").write_text(SWEEP)
    for words in ("run-all --force", "sweep sweep.yaml", "show fall"):
        for columns in (60, 80):
            text = ran.says(words, environment={"COLUMNS": str(columns)})
            assert text and not too_wide(text, columns), text
    rows = list(csv.DictReader(io.StringIO(ran.answers("sweep sweep.yaml --csv")["sweep sweep.yaml --csv"][1])))
    assert [float(row["fall.height"]) for row in rows] == [0.5, 1.0, 2.0]
    assert {row["outcome"] for row in rows} == {"computed"}


def test_a_terminal_is_used_as_it_is_from_60_columns_on(monkeypatch):
    line = "word " * 60
    for columns, wanted in ((40, 60), (60, 60), (80, 80), (132, 132)):
        monkeypatch.setenv("COLUMNS", str(columns))
        longest = max(map(len, layout.folded(line)))
        assert wanted - 5 < longest <= wanted


def test_a_line_is_folded_between_words_with_its_indent():
    assert layout.folded("  one two three four", columns=12) == ["  one two", "    three", "    four"]
    assert layout.folded("", columns=12) == [""]
    path = "/a/" + "long" * 30
    assert path in layout.folded(f"made by {path} today", columns=40)[1].strip()


@pytest.mark.parametrize(("first", "second"), [(11, 30), (30, 11), (30, 30)])
def test_a_table_of_words_is_as_low_as_any_division_of_its_room_makes_it(first, second, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    words = ["word " * first, "word " * second]
    by_hand = [max(len(layout.folded(text.strip(), 0, columns)) for text, columns in zip(words, (one, 56 - one)))
               for one in range(16, 41)]  # fmt: skip
    assert len(list(layout.table(["one", "other"], [[text.strip() for text in words]]))) == 1 + min(by_hand)


def test_a_table_aligns_numbers_and_keeps_every_cell(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    columns = ["run", "sensor", *(f"measure number {index} in m/s" for index in range(14)), "remark"]
    rows = [[f"run {run}", place, *(1.25 * index for index in range(14)), f"what is said of run {run} at the {place}"]
            for run in range(3) for place in ("hip", "foot")]  # fmt: skip
    lines = list(layout.table(columns, rows))
    assert not too_wide("\n".join(lines), 80)
    panels = "\n".join(lines).split("\n\n")
    assert len(panels) > 1
    for panel in panels:
        assert panel.count("hip") >= 3, "the first two columns stand in each part, as the first alone is not unique"
    words = " ".join(lines).split()
    for index in range(14):
        assert words.count(layout.short(1.25 * index)) >= 6
    ends = {match.end() for line in panels[0].splitlines() for match in re.finditer(r"2\.5\b", line)}
    assert len(ends) == 1, "numbers end in one column"


def test_what_fits_is_not_folded(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert layout.titled("Claims: 0", ["name", "value"], []) == ["", "Claims: 0"], "no head without rows"
    assert list(layout.table(["name", "value"], [["a b", 1.5], ["c", 22.25]])) == [
        "  name  value", "  a b     1.5", "  c     22.25"]  # fmt: skip


def test_a_path_in_an_artefact_and_csv(ran):
    text, table, states = ran.shows("show fall mass.ball", "show fall --csv", "status --csv")
    fields = {field["path"]: field for field in csv.DictReader(io.StringIO(table))}
    assert text.split()[0] == fields["mass/ball"]["value"] == "0.1"
    assert [row["state"] for row in csv.DictReader(io.StringIO(states))] == ["current"] * 4


#: A row of a table, and a result with it.
Part = make_dataclass("Part", [("name", str), ("good", bool), ("mass", float | None, quantity("kg", "it weighs"))])
Parts = make_dataclass("Parts", [("parts", tuple[Part, ...], quantity("-", "parts of the toy"))])


def test_a_table_in_an_artefact_as_text_csv_and_json(ran):
    result = Parts((Part("ball", True, 1.5), Part("shell of wood", False, None)))
    (ran.root / "parts.h5").write_bytes(artefact.encode(result, {"stage": "none", "key": "0"}))
    asked = ("show parts.h5 parts", "show parts.h5 parts --csv", "show parts.h5 parts.good --json")
    text, table, plain = ran.shows(*asked)
    assert [line.split("  ") for line in text.splitlines() if "shell" in line] and "mass [kg]" in text
    rows = list(csv.DictReader(io.StringIO(table)))
    assert [(row["name"], row["good"], row["mass"]) for row in rows] == [
        ("ball", "true", "1.5"), ("shell of wood", "false", "")]  # fmt: skip
    assert json.loads(plain)["value"] == [True, False]


# --- Help, completion in the shell, and what a command says beside its answer.


def test_a_run_with_other_parameters_says_whose_results_give_way(ran):
    words = "run fall --set fall.height=2.5"
    ran.says(words, "results of fall.height = 2 give way to those of 2.5", "come back at once")
    assert "give way" not in ran.command(*words.split())[2]


def test_without_arguments_there_is_plain_help(ran):
    code, said, errors = ran.command()
    text = said + errors  # click 8.1 prints it to standard output and ends with 0
    assert code == (0 if said else 2) and text.startswith("Usage: bipedstudy") and "error" not in text
    titles = [line for line in text.splitlines() if line.endswith(":") and not line.startswith(" ")]
    assert titles == ["Options:", "Study:", "Questions to stage side:", "Looking:", "Housekeeping:"]


@pytest.mark.parametrize(
    ("words", "place", "wanted"),
    [
        ("bipedstudy sw", 1, "plain,sweep"),
        ("bipedstudy run fa", 2, "plain,fall"),
        ("bipedstudy show bo", 2, "plain,bounce"),
        ("bipedstudy run --set fall.he", 3, "plain,fall.height="),
        ("bipedstudy figures pi", 2, "plain,pi"),
    ],
)
def test_the_shell_completes(words, place, wanted, ran):
    (ran.root / "results/figures").mkdir(exist_ok=True)
    (ran.root / "results/figures/pi.png").write_bytes(b"")
    asked = {"_BIPEDSTUDY_COMPLETE": "bash_complete", "COMP_WORDS": words, "COMP_CWORD": str(place)}
    _, text, errors = ran.command(environment=asked)
    assert wanted in text.splitlines(), errors
