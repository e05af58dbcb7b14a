"""What a stage can be asked: options, answers as text, JSON and picture, files it leaves, and going on after a stop."""

import io
import json
import os
import random
import signal
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.cache.artefact import tree
from pipeline.commands.options import Form
from pipeline.errors import Stopped, StudyError
from pipeline.questions.asking import Asked, BlockTable

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
    assert toy.says("tally --jobs 1 --wanted 1:2", "none lies within", code=3).startswith("0 of 4 numbers")


def test_its_answer_as_json_and_other_parameters(toy):
    told = json.loads(toy.says("tally --json --set side.seed=4 --count 3 --order sorted"))
    assert told == {"numbers": sorted(NUMBERS[1:]), "inside": 3}
    told = json.loads(toy.says(f"tally --json --skip {NUMBERS[1]} --skip {NUMBERS[3]} --wanted "
                               f"0:{min(NUMBERS[0], NUMBERS[2])}"))  # fmt: skip
    assert told == {"numbers": [NUMBERS[0], NUMBERS[2]], "inside": 1}


def test_help_lists_questions_by_stage_and_their_options_with_unit_range_and_default(toy):
    told = toy.answers("--help", "tally --help")
    assert "Questions to stage side:\n  tally  Draw numbers from the seed and those after it." in told["--help"][1]
    code, out, _ = told["tally --help"]
    words = " ".join(out.split())
    assert code == 0 and "Ends with 3 if none is wanted." in words
    for said in (
        "--count INTEGER Numbers to draw. Allowed: >= 1 and <= 100. [default: 4]",
        "--pause NUMBER Time that each takes, and every other twice [s]. Allowed: >= 0 s. [default: 0]",
        "--order WORD How they are listed. Allowed: drawn, sorted. [default: drawn]",
        "--into DIR Leave a table of the numbers, and parameter files with the best seed in the new folder DIR.",
    ):
        assert said in words


WRONG = {
    "--count 0": "--count = 0 is not allowed; allowed: >= 1 and <= 100",
    "--count 1.5": "--count = 1.5 is not a whole number; allowed: >= 1 and <= 100",
    "--count 13": "--count = 13 brings bad luck",
    "--pause -1": "--pause = -1 s is not allowed; allowed: >= 0 s",
    "--pause soon": '--pause = "soon" is not a number; allowed: >= 0 s',
    "--wanted 3": "--wanted: '3' is not two numbers LOW:HIGH with LOW < HIGH",
    "--order sort": '--order = "sort" is not allowed; allowed: drawn, sorted; did you mean "sorted"?',
    "--counts 1": "No such option '--counts'",
    "--figure x.foo": "x.foo: the ending names the format, one of ",
    "--into params": "params: is there already, and is not replaced",
    "--set side.seed=-1": "--set side.seed=-1: seed = -1 is not allowed; allowed: >= 0",
}


def test_a_wrong_option_is_one_sentence_before_anything_is_computed(toy):
    typed = {f"tally --marks marks {words}": said for words, said in WRONG.items()}
    for words, (code, out, errors) in toy.answers(*typed).items():
        assert (code, out, errors.count("\n")) == (2, "", 1), words
        assert errors.startswith("error: " + typed[words])
    assert marks(toy) == 0
    toy.says("tally --into best --set fall.parts.0.mass=0.2", "an entry of a table cannot be written", code=2)
    assert not [path for path in toy.root.iterdir() if "best" in path.name]


def test_a_stage_that_refuses_gives_its_reason(toy):
    asked = "tally --set side.seed=0"
    text, (code, told, _) = toy.answers(asked, f"{asked} --json").values()
    assert text == (3, "", "nothing grows from seed 0\n")
    assert (code, json.loads(told)) == (3, {"tally": None, "reason": "nothing grows from seed 0"})


def test_it_draws_and_leaves_files_and_parameters(toy):
    words, notebook = "tally --figure numbers.png --into best --set ground.gravity=9.8", {"MPLBACKEND": "nowhere"}
    toy.says(words, "drawn: numbers.png", environment=notebook)
    assert (toy.root / "numbers.png").read_bytes().startswith(b"\x89PNG")
    assert (toy.root / "best/numbers.csv").read_text().split() == [str(number) for number in NUMBERS]
    assert json.loads(toy.says("tally --params best --count 1 --json"))["numbers"] == [max(NUMBERS)]
    ground, before = (toy.root / folder / "ground.yaml" for folder in ("best", "params"))
    changed = [new for new, old in zip(ground.read_text().splitlines(), before.read_text().splitlines()) if new != old]
    assert changed == ['gravity: {value: 9.8, unit: "m/s^2", source: "bipedstudy tally --figure numbers.png --into best'
                       ' --set ground.gravity=9.8"}']  # fmt: skip


@pytest.mark.skipif(os.name != "posix", reason="sizes of files are bounded by POSIX")
@pytest.mark.parametrize(("room", "name"), [(4096, "table.h5"), (16384, "numbers.png")])
def test_where_the_disk_has_no_room_the_file_is_named_and_the_old_one_stays(toy, room, name):
    (toy.root / "numbers.png").write_text("old")
    full = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({room}, {room})); "
    toy.says("tally --figure numbers.png", f"{name}: File too large", code=1, before=full)
    assert (toy.root / "numbers.png").read_text() == "old"


def stopped(toy, how, count):
    """A question for 12 numbers on two processes, stopped by a signal when `count` are done: exit code and errors."""
    process = toy.start("tally", "--count", "12", "--pause", "0.1", "--jobs", "2", "--marks", "marks")
    while kept(toy) < count:
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(how)
    _, errors = process.communicate(timeout=60)
    return process.returncode, errors


def test_a_stopped_question_goes_on_where_it_was_and_its_table_is_that_of_an_undisturbed_one(toy):
    code, errors = stopped(toy, signal.SIGINT, 2)
    done = kept(toy)
    # one fewer where the signal came after a row was written, and before it was counted
    assert code == 130 and errors in [
        f"error: stopped; {said} of 12 parts are done and kept: asked again, it goes on from there\n"
        for said in (done, done - 1)]  # fmt: skip
    assert stopped(toy, signal.SIGKILL, done + 2)[0] == -signal.SIGKILL
    time.sleep(0.25)  # what a process that outlived its parent would need to compute one more
    before, done = marks(toy), kept(toy)
    assert done < 12 and before <= done + 4
    told = json.loads(toy.says("tally --count 12 --pause 0.1 --marks marks --out again.h5 --json"))
    assert told["numbers"][:4] == NUMBERS and marks(toy) - before == 12 - done and kept(toy) == 12
    toy.says("tally --count 12 --jobs 1 --results others --out alone.h5")
    assert toy.says("show alone.h5").startswith("alone.h5: stage side, question tally\n")
    assert "  parameters: " in toy.says("show alone.h5 --why")
    assert (toy.root / "alone.h5").read_bytes() == (toy.root / "again.h5").read_bytes()


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


def test_a_line_of_standard_input_that_never_ends_is_refused(monkeypatch):
    """A device that sends zeros was read for ever; a long line in between is none of the rows."""
    asked = Asked(None, "side", None, None, 1)
    sent = b"1,2\n" + 9000 * b"x" + b"\n3,4\r\n5"
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(sent)))
    assert list(asked.lines()) == ["1,2", "", "3,4", "5"]
    with open("/dev/zero", "rb") as endless:
        monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=endless))
        with pytest.raises(StudyError, match="no line ends within 1000000 bytes"):
            next(asked.lines())


def test_of_rows_that_are_written_as_they_come_a_stopped_question_does_not_say_that_nothing_is_kept():
    """As of `follow -`, whose first row takes the stream up again."""
    with pytest.raises(Stopped, match=r"^stopped; lines written until then: 2$"), Asked(
            None, "side", None, None, 1) as asked:  # fmt: skip
        asked.say({"row": 1})
        asked.say({"row": 2})
        raise KeyboardInterrupt


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
    text = toy.path("stages/side/questions/tally.py").read_text()
    for file, name in (("twice", "tally"), ("walk", "run")):
        toy.path(f"stages/side/questions/{file}.py").write_text(text.replace('"tally",', f'"{name}",'))
    toy.path("stages/side/questions/lost.py").write_text(text.replace("import random", "import randomness"))
    told = toy.answers("--help", "lost", "taly", "status")
    reasons = [f"stage side: stages/side/questions/{file}.py cannot be used: {why}" for file, why in (
        ("lost", "No module named 'randomness'"), ("twice", 'there is a command "tally" already'),
        ("walk", 'there is a command "run" already'))]  # fmt: skip
    assert all(said in " ".join(told["--help"][1].split()) for said in reasons)
    assert told["lost"] == (2, "", "".join(f"error: {said}\n" for said in (
        'there is no command "lost" (see bipedstudy --help)', *reasons)))  # fmt: skip
    assert 'there is no command "taly"; did you mean "tally"?' in told["taly"][2] and told["status"][0] == 0


def test_a_question_whose_code_is_compiled_first_says_so(toy):
    toy.path("stages/side/compiled.py").write_text(
        "import os\nCOMPILING = 'compiling, once'\n"
        "class CODE:\n    is_cold = staticmethod(lambda: not os.path.exists('warm'))\n"
    )
    assert toy.command("tally")[2].splitlines() == ["note: stage side: compiling, once", "all drawn"]
    (toy.root / "warm").touch()
    assert toy.command("tally")[2].splitlines() == ["all drawn"]


def test_a_study_that_cannot_be_read_is_said(toy):
    (toy.root / "dvc.yaml").write_text("stages: [")
    told = toy.answers("tally", "--help")
    code, _, errors = told["tally"]
    assert code == 2 and "dvc.yaml" in errors and "Traceback" not in errors
    assert told["--help"][0] == 0


def test_words_of_a_column_are_shown_for_their_numbers(tmp_path):
    columns = [SimpleNamespace(name="outcome", unit="-", description="", words=("stable", "none"))]
    table = BlockTable(tmp_path / "table.h5", columns, 3, {"provenance": {}})
    table.write(0, {"outcome": np.array([1, 0, 1])})
    table.close()
    (found,) = (field for field in tree((tmp_path / "table.h5").read_bytes(), "table.h5") if "outcome" in field.path)
    assert found.value == ["none", "stable", "none"]


def test_an_answer_without_rows_says_so_and_prints_none(capsys):
    Form(as_csv=True).give((), {}, ())
    assert (*capsys.readouterr(),) == ("", "note: this answer has no rows\n")
