"""Help, completion in the shell, and what a command says beside its answer."""

from __future__ import annotations

import pytest


def test_a_run_with_other_parameters_says_whose_results_give_way(ran):
    _, _, errors = ran.command("run", "fall", "--set", "fall.height=2.5")
    assert "results of fall.height = 2 give way to those of 2.5" in errors and "come back at once" in errors
    _, _, errors = ran.command("run", "fall", "--set", "fall.height=2.5")
    assert "give way" not in errors


def test_without_arguments_there_is_plain_help(ran):
    code, said, errors = ran.command()
    text = said + errors  # click 8.1 prints it to standard output and ends with 0
    assert code == (0 if said else 2) and text.startswith("Usage: bipedstudy") and "error" not in text
    titles = [line for line in text.splitlines() if line.endswith(":") and not line.startswith(" ")]
    assert titles == ["Options:", "Study:", "Questions to stage side:", "Looking:", "Housekeeping:"]


@pytest.mark.parametrize(
    ("words", "place", "wanted"),
    [
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
