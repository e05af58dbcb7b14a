"""What a stage can be asked: options, answers as text, JSON and picture, files it leaves, and going on after a stop."""

import json
import random
import shutil
import signal
import time
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.questions.asking import BlockTable

NUMBERS = [random.Random(seed).randrange(1000) for seed in (3, 4, 5, 6)]


@pytest.fixture
def toy(toy_with_commands, told):
    (toy_with_commands.root / "marks").symlink_to(told)
    return toy_with_commands


def marks(toy):
    return len(list((toy.root / "marks").iterdir()))


def kept(toy):
    """Answers in the journals of questions."""
    return sum(len(path.read_bytes().splitlines()) for path in toy.root.glob("results/.cache/questions/*.jsonl"))


def test_a_question_of_a_stage_is_a_command(toy):
    code, out, errors = toy.command("tally", "--jobs", "1")
    assert (code, errors) == (0, "all drawn\n")
    assert out.splitlines()[0] == "4 of 4 numbers lie within"
    assert [line.split() for line in out.splitlines()[2:]] == [
        ["Numbers"], ["place", "number"], *([str(place), str(number)] for place, number in enumerate(NUMBERS))
    ]  # fmt: skip


def test_its_answer_as_json_and_other_parameters(toy):
    _, out, _ = toy.command("tally", "--json", "--set", "side.seed=4", "--count", "3", "--order", "sorted")
    assert json.loads(out) == {"numbers": sorted(NUMBERS[1:]), "inside": 3}
    _, out, _ = toy.command("tally", "--json", "--skip", str(NUMBERS[1]), "--skip", str(NUMBERS[3]),
                            "--wanted", f"0:{min(NUMBERS[0], NUMBERS[2])}")  # fmt: skip
    assert json.loads(out) == {"numbers": [NUMBERS[0], NUMBERS[2]], "inside": 1}


def test_help_lists_questions_by_stage_and_their_options_with_unit_range_and_default(toy):
    _, out, _ = toy.command("--help")
    assert "Questions to stage side:\n  tally  Draw numbers from the seed and those after it." in out
    code, out, _ = toy.command("tally", "--help")
    words = " ".join(out.split())
    assert code == 0 and "Ends with 3 if none is wanted." in words
    for said in (
        "--count INTEGER Numbers to draw. Allowed: >= 1 and <= 100. [default: 4]",
        "--pause NUMBER Time that each takes, and every other twice [s]. Allowed: >= 0 s. [default: 0]",
        "--order WORD How they are listed. Allowed: drawn, sorted. [default: drawn]",
        "--into DIR Leave a table of the numbers, and parameter files with the best seed in the new folder DIR.",
    ):
        assert said in words


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--count", "0"), "--count = 0 is not allowed; allowed: >= 1 and <= 100"),
        (("--count", "1.5"), "--count = 1.5 is not a whole number; allowed: >= 1 and <= 100"),
        (("--count", "13"), "--count = 13 brings bad luck"),
        (("--pause", "-1"), "--pause = -1 s is not allowed; allowed: >= 0 s"),
        (("--pause", "soon"), '--pause = "soon" is not a number; allowed: >= 0 s'),
        (("--wanted", "3"), "--wanted: '3' is not two numbers LOW:HIGH with LOW < HIGH"),
        (("--order", "sort"), '--order = "sort" is not allowed; allowed: drawn, sorted; did you mean "sorted"?'),
        (("--counts", "1"), "No such option '--counts'"),
        (("--figure", "x.foo"), "x.foo: the ending names the format, one of "),
        (("--into", "params"), "params: is there already, and is not replaced"),
        (("--set", "side.seed=-1"), "--set side.seed=-1: seed = -1 is not allowed; allowed: >= 0"),
    ],
)
def test_a_wrong_option_is_one_sentence_before_anything_is_computed(toy, arguments, sentence):
    code, out, errors = toy.command("tally", "--marks", "marks", *arguments)
    assert (code, out, marks(toy)) == (2, "", 0)
    assert errors.startswith("error: " + sentence) and len(errors.splitlines()) == 1


def test_a_stage_that_refuses_gives_its_reason(toy):
    assert toy.command("tally", "--set", "side.seed=0") == (3, "", "nothing grows from seed 0\n")
    code, out, _ = toy.command("tally", "--set", "side.seed=0", "--json")
    assert (code, json.loads(out)) == (3, {"tally": None, "reason": "nothing grows from seed 0"})


def test_an_answer_that_is_no_is_printed_and_ends_with_3(toy):
    code, out, errors = toy.command("tally", "--wanted", "1:2")
    assert code == 3 and out.startswith("0 of 4 numbers") and errors.splitlines()[-1] == "none lies within"


def test_it_draws_and_leaves_files_and_parameters(toy):
    code, _, errors = toy.command("tally", "--figure", "numbers.png", "--into", "best", "--set", "ground.gravity=9.8")
    assert code == 0 and "drawn: numbers.png" in errors.splitlines()
    assert (toy.root / "numbers.png").read_bytes().startswith(b"\x89PNG")
    assert (toy.root / "best/numbers.csv").read_text().split() == [str(number) for number in NUMBERS]
    _, out, _ = toy.command("tally", "--params", "best", "--count", "1", "--json")
    assert json.loads(out)["numbers"] == [max(NUMBERS)]
    ground, before = (toy.root / folder / "ground.yaml" for folder in ("best", "params"))
    changed = [new for new, old in zip(ground.read_text().splitlines(), before.read_text().splitlines()) if new != old]
    assert changed == ['gravity: {value: 9.8, unit: "m/s^2", source: "bipedstudy tally --figure numbers.png --into best'
                       ' --set ground.gravity=9.8"}']  # fmt: skip


def test_a_parameter_folder_cannot_hold_an_entry_of_a_table(toy):
    code, _, errors = toy.command("tally", "--into", "best", "--set", "fall.parts.0.mass=0.2")
    assert code == 2 and "fall.parts.0.mass: an entry of a table cannot be written" in errors
    assert not [path for path in toy.root.iterdir() if "best" in path.name]


def stopped_half_way(toy, how):
    """A question for 8 numbers on two processes, stopped by a signal when some are done: exit code and errors."""
    process = toy.start("tally", "--count", "8", "--pause", "0.3", "--jobs", "2", "--marks", "marks")
    while kept(toy) < 3:
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(how)
    _, errors = process.communicate(timeout=60)
    return process.returncode, errors


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_stopped_question_goes_on_where_it_was(toy, how):
    code, errors = stopped_half_way(toy, how)
    done = kept(toy)
    assert code != 0 and 3 <= done < 8
    if how == signal.SIGINT:
        # one fewer where the signal came after a row was written, and before it was counted
        assert code == 130 and errors in [
            f"error: stopped; {said} of 8 parts are done and kept: asked again, it goes on from there\n"
            for said in (done, done - 1)]  # fmt: skip
    time.sleep(0.7)  # what a process that outlived its parent would need to compute one more
    before = marks(toy)
    assert before <= done + 2
    code, out, _ = toy.command("tally", "--count", "8", "--pause", "0.3", "--marks", "marks", "--json")
    assert (code, json.loads(out)["numbers"][:4]) == (0, NUMBERS)
    assert marks(toy) - before == 8 - done
    assert kept(toy) == 8


def test_a_table_has_the_same_bytes_however_its_parts_were_computed(toy):
    ask = ("tally", "--count", "8", "--pause", "0.1")
    assert toy.command(*ask, "--jobs", "1", "--out", "alone.h5")[0] == 0
    assert toy.command(*ask, "--jobs", "2", "--results", "others", "--out", "beside.h5")[0] == 0
    shutil.rmtree(toy.root / "results/.cache/questions")
    stopped_half_way(toy, signal.SIGKILL)
    assert toy.command(*ask, "--jobs", "2", "--pause", "0.3", "--marks", "marks", "--out", "again.h5")[0] == 0
    alone = (toy.root / "alone.h5").read_bytes()
    assert alone == (toy.root / "beside.h5").read_bytes() == (toy.root / "again.h5").read_bytes()


@pytest.mark.parametrize("order", [[1, 0, 3, 2], [3, 0, 2, 1]])
def test_a_table_of_many_columns_has_the_same_bytes_in_any_order_of_its_blocks(tmp_path, order):
    """A compressed chunk is written once: where each block wrote it anew, chunks moved and the file was larger."""
    values, files = np.random.default_rng(1).random((12, 4000)).round(3), []
    columns = [SimpleNamespace(name=f"x{at}", unit="1", description="", words=()) for at in range(12)]
    for blocks in (range(4), order):
        table = BlockTable(tmp_path / "table.h5", columns, 4000, {})
        for first in (1000 * block for block in blocks):
            table.write(first, {f"x{at}": row[first : first + 1000] for at, row in enumerate(values)})
        table.close()
        files.append((tmp_path / "table.h5").read_bytes())
    assert files[0] == files[1]


def test_a_part_that_is_refused_or_dies_is_said_and_the_others_are_kept(toy):
    for first, code, said in (
        (99, 3, "nothing grows from seed 99"),
        (95, 1, "error: a process of this question failed: its process ended by itself with code 7, twice; what is "
                "done is kept: asked again, it goes on from there"),
    ):  # fmt: skip
        assert toy.command("tally", "--jobs", "2", "--set", f"side.seed={first}", "--count", "4")[::2] == (
            code, said + "\n")  # fmt: skip
    assert kept(toy)


def test_kept_answers_are_of_this_code_and_these_parameters(toy):
    ask = ("tally", "--marks", "marks", "--json", "--jobs", "1")
    first = toy.command(*ask)[1]
    assert toy.command(*ask)[1] == first and marks(toy) == 4
    toy.command(*ask, "--set", "side.wait=1")  # the function could read any parameter of its stage
    assert marks(toy) == 8
    toy.edit("stages/side/questions/tally.py", "randrange(1000)", "randrange(10)")
    assert toy.command(*ask)[1] != first and marks(toy) == 12


def test_a_question_that_cannot_be_used_is_a_sentence_and_the_others_go_on(toy):
    toy.edit("stages/side/questions/tally.py", "import random", "import randomness")
    code, _, errors = toy.command("tally")
    reason = "stage side: stages/side/questions/tally.py cannot be used: No module named 'randomness'"
    assert code == 2 and errors.splitlines() == [
        'error: there is no command "tally" (see bipedstudy --help)', f"error: {reason}"
    ]  # fmt: skip
    code, out, _ = toy.command("--help")
    assert code == 0 and reason in " ".join(out.split())
    assert toy.command("status")[0] == 0


@pytest.mark.parametrize("name", ["tally", "run"])
def test_a_question_cannot_have_the_name_of_another_command(toy, name):
    text = toy.path("stages/side/questions/tally.py").read_text()
    toy.path("stages/side/questions/twice.py").write_text(text.replace('"tally",', f'"{name}",'))
    said = " ".join(toy.command("--help")[1].split())
    assert f'stage side: stages/side/questions/twice.py cannot be used: there is a command "{name}" already' in said
    assert toy.command("tally")[0] == 0


def test_a_question_whose_code_is_compiled_first_says_so(toy):
    toy.path("stages/side/compiled.py").write_text(
        "import os\nCOMPILING = 'compiling, once'\n"
        "class CODE:\n    is_cold = staticmethod(lambda: not os.path.exists('warm'))\n"
    )
    assert toy.command("tally")[2].splitlines() == ["note: stage side: compiling, once", "all drawn"]
    (toy.root / "warm").touch()
    assert toy.command("tally")[2].splitlines() == ["all drawn"]


def test_a_misspelt_question_is_named(toy):
    assert 'there is no command "taly"; did you mean "tally"?' in toy.command("taly")[2]


def test_a_study_that_cannot_be_read_is_said(toy):
    (toy.root / "dvc.yaml").write_text("stages: [")
    code, _, errors = toy.command("tally")
    assert code == 2 and "dvc.yaml" in errors and "Traceback" not in errors
    assert toy.command("--help")[0] == 0
