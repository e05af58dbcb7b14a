"""The command line: what it prints, its exit codes, and how quick it is."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import pytest

from pipeline.commands import show
from pipeline.errors import STOPPING
from pipeline.study import locate
from tests import commands

ROOT = Path(__file__).resolve().parents[2]


def test_run_all_prints_a_line_for_each_stage_and_for_the_report(toy_with_commands):
    code, out, errors = toy_with_commands.command("run-all", "--jobs", "1")
    assert (code, errors) == (0, "")
    lines = [line.split() for line in out.splitlines()]
    assert len(lines) == 5 and lines[4] == ["report", "written", "results/report.html"]
    assert lines[0][:2] == ["fall", "computed"] and lines[0][-3:] == ["fell", "4.91", "m"]
    assert [line.split()[1] for line in toy_with_commands.says("run-all").splitlines()] == ["current"] * 4


def test_a_dry_run_runs_nothing_and_json_tells_what_a_run_does(ran):
    before, setting = ran.results(), "--set ground.contact_stiffness=2e5"
    ran.says(f"run-all --dry-run {setting}", "bounce stale ground.yaml: contact_stiffness 1e5 -> 2e5")
    assert ran.results() == before
    stages = json.loads(ran.says(f"run-all --json {setting}"))["stages"]
    assert [(stage["stage"], stage["how"]) for stage in stages] == [
        ("fall", "current"), ("bounce", "computed"), ("side", "current"), ("picture", "computed")
    ]  # fmt: skip
    assert stages[1]["reasons"] == ["ground.yaml: contact_stiffness 1e5 -> 2e5"]


def test_run_takes_several_stages_and_force_means_only_those_and_verbose_says_why(ran):
    out = ran.says("run bounce side --force")
    assert sorted(line.split()[:2] for line in out.splitlines()) == [
        ["bounce", "computed"], ["fall", "current"], ["side", "computed"]
    ]  # fmt: skip
    before = ran.results()
    ran.says("run fall -v --results elsewhere --set fall.height=3", "computing: never run")
    assert ran.results() == before and (ran.root / "elsewhere/fall.h5").exists()


def test_status_and_graph(ran):
    text, plain, graph, nodes = ran.shows("status", "status --json", "graph", "graph --json")
    assert [line.split() for line in text.splitlines()] == [
        [name, "current"] for name in ("fall", "bounce", "side", "picture")]  # fmt: skip
    assert json.loads(plain)[0] == {"stage": "fall", "state": "current", "reasons": []}
    assert "  reads   results/bounce.h5, results/side.bin" in graph.splitlines()
    assert json.loads(nodes)[3]["upstream"] == ["bounce", "side"]


def test_show_prints_fields_units_and_tables(ran):
    text, plain = ran.shows("show fall", "show results/bounce.h5 --json")
    assert any(line.split()[:3] == ["height", "2", "m"] for line in text.splitlines()) and "Parts" in text.splitlines()
    tree = json.loads(plain)
    assert tree["fields"][0]["path"] == "force" and tree["fields"][0]["unit"] == "N"
    assert tree["provenance"]["stage"] == "bounce"
    assert "ground.contact_stiffness = 1e5" in tree["provenance"]["parameters"].splitlines()


def test_show_reads_a_table_that_does_not_say_what_made_it(ran, tmp_path):
    """As maps of an earlier program: it ended with a KeyError."""
    table = Path(shutil.copy(ran.root / "results/fall.h5", tmp_path / "table.h5"))
    with h5py.File(table, "r+") as file:
        del file["provenance"]
    assert "table.h5: it does not say what made it\n" in ran.says(f"show {table}", code=0)


def test_show_why_tells_parameters_by_line_inputs_code_and_the_same_of_what_was_read(ran):
    text, plain = ran.shows("show --why bounce.force", "show --why bounce force --json")
    lines = [line.strip() for line in text.splitlines()]
    assert lines[0].startswith("results/bounce.h5: force = ")
    own, above = (next(n for n, line in enumerate(lines) if line.startswith(f"stage {name}, "))
                  for name in ("bounce", "fall"))  # fmt: skip
    stated = (ran.root / "params/ground.yaml").read_text().splitlines()
    number = next(n for n, line in enumerate(stated, 1) if line.startswith("contact_stiffness"))
    told = " ".join(" ".join(lines[own:above]).split())
    assert f"ground.contact_stiffness = 1e5 N/m params/ground.yaml:{number} (assumed)" in told
    assert "reads results/fall.h5, made by stage fall, SHA-256 " in told and "code: stages/bounce/run.py and " in told
    below = " ".join(lines[above:])
    assert "fall.marks = [0.5, 1e-7] m" in below and "that are listed above" in below
    made = json.loads(plain)["made"]
    assert [one["stage"] for one in made] == ["bounce", "fall"]
    assert "stages/fall/run.py" in made[1]["code"] and any(each.startswith("numpy ") for each in made[1]["versions"])
    ran.edit("params/ground.yaml", "value: 1e5", "value: 2e5")
    again = ran.says("show --why bounce.force --csv").splitlines()
    assert "set for this run; the file says 2e5" in next(line for line in again if "contact_stiffness" in line)


def test_why_names_the_line_of_a_row(repository):
    study = locate(start=repository)
    (found,) = show._parameters(study, "twin.materials.1 = {name: aluminium, density: 2700}")
    path, _, number = found["place"].partition(":")
    assert "name: aluminium" in (repository / path).read_text().splitlines()[int(number) - 1]


def test_claims(ran):
    """With the figures that show something of them."""
    captions = ran.root / "results/captions.yaml"
    captions.write_text("figures:\n- {name: one, claims: [force]}\n- {name: two, claims: []}\n")
    plain, text, table = ran.shows("claims --json", "claims", "claims --markdown")
    found, lines = json.loads(plain), text.splitlines()
    assert found["claims"] == [
        {"id": "force", "section": "1", "words": "one newton", "implies": "1 N", "measured": "4.905e+05 N",
         "verdict": "does not hold", "condition": "", "causes": ["it is another toy"],
         "rests_on": ["ground.gravity 9.81"], "numbers": [], "beside": "", "figures": ["one"], "plain": ""}
    ]  # fmt: skip
    assert found["headlines"] == ["it is a toy"] and found["tables"][0]["rows"] == [["weight", "2"]]
    assert lines[0] == "force: does not hold" and max(map(len, lines)) <= 100
    assert [line.split(maxsplit=1)[0] for line in lines[1:6]] == ["says", "implies", "measured", "verdict", "because"]
    assert "Toys" in lines and not [line for line in lines if line.startswith("1 claims")], "one needs no count"
    assert "  shown in  one" in lines
    assert "| [force](#force) | 1 | does not hold |" in table.splitlines()


def test_claims_are_written_between_the_marks_that_a_file_has(ran):
    page = ran.root / "page.md"
    page.write_text("before\n<!-- headlines -->\nold\n<!-- /headlines -->\nafter\n")
    ran.says("claims --into page.md")
    assert page.read_text() == "before\n<!-- headlines -->\n- it is a toy\n<!-- /headlines -->\nafter\n"
    (ran.root / "half.md").write_text("<!-- claims -->\n")
    (ran.root / "none.md").write_text("nothing")
    (ran.root / "old").mkdir()
    (ran.root / "old/claims.yaml").write_text("- {id: force, holds: false}\n")
    told = {"claims --into half.md": "one is missing", "claims --into none.md": "there are no lines",
            "claims weight": 'there is no claim "weight" (claims: force)',
            "claims --results old": "not the claims of this version; make them anew with"}  # fmt: skip
    for words, (code, _, errors) in ran.answers(*told).items():
        assert code == 2 and told[words] in errors


WRONG = {
    "run fall --set fall.height=-1": "height = -1 m is not allowed; allowed: >= 0 m",
    "run fal": 'there is no stage "fal" (stages: fall, bounce, side, picture); did you mean "fall"?',
    "rn": 'there is no command "rn"; did you mean "run"? (see bipedstudy --help)',
    "run": "Missing argument 'STAGE...' (see bipedstudy run --help)",
    "run-all --jobs 0": "Invalid value for '--jobs' / '-j': 0 is not in the range x>=1",
    "run-all --job 2": "No such option",
    "run -1:2": "No such option '-1'; what begins with a minus stands after -- and behind all options (see ",
    "run-all --params nowhere": "--params nowhere: there is no such folder\n",
    "status --params dvc.yaml": "--params dvc.yaml: there is no such folder\n",
    "run-all --results ''": "run-all --results '': ends with an empty value",
    "run-all --results= --force": "run-all --results=: ends with an empty value",
    "figures ''": "figures '': ends with an empty value",
    "show fal": '"fal" is neither a stage (fall, bounce, side, picture) nor a file; did you mean "fall"?',
    "show dvc.yaml": "dvc.yaml: is truncated or not an HDF5 file; it cannot be read as an artefact",
    "show params": "params: is a folder, not a file",
    "show huge.h5": "huge.h5: has 5000000000 bytes; at most",
    "claims --results elsewhere": "claims.yaml is not there yet; make it with: bipedstudy run comparison",
    "show fall --results elsewhere": "fall.h5 is not there yet; make it with: bipedstudy run fall",
    "run fall --results dvc.yaml": "dvc.yaml: cannot be written",
    "status --csv --json": "exclude each other",
    "compare results": "these are the results themselves",
    "compare params": "there are no results there",
    "compare nowhere": "does not exist",
    "clean --older-than soon": "--older-than = soon is not allowed; allowed: a",
    "clean --max-size 2": "--max-size = 2 is not allowed; allowed: a",
    "show fall heightx": "did you mean",
}


def test_bad_input_is_one_sentence_and_exit_code_2_and_leaves_the_results_valid(ran):
    before = ran.results()
    with open(ran.root / "huge.h5", "wb") as file:
        file.truncate(5_000_000_000)
    for words, (code, out, errors) in ran.answers(*WRONG).items():
        assert (code, out, "Traceback" in errors) == (2, "", False), words
        assert errors.startswith("error: ") and WRONG[words] in errors
    ran.says("run-all --set ground.gravity=0 --set fall.steps=x", code=2)
    assert ran.results() == before
    assert {state["state"] for state in json.loads(ran.says("status --json"))} == {"current"}


def test_two_runs_at_once(toy_with_commands):
    """Stages that need nothing of each other run side by side; another run names this one, or waits for it."""
    toy = toy_with_commands
    first = toy.start("run", "fall", "side", "--jobs", "2", "--set", "fall.behaviour=sleep")
    assert first.stdout.readline().split()[:2] == ["side", "computed"]
    assert first.poll() is None  # fall, which was started first, still sleeps
    toy.says("run-all", f"error: results is in use by process {first.pid} (bipedstudy run fall side",
             "wait for it with --wait", code=2)  # fmt: skip
    toy.says("status")
    second = toy.start("run", "side", "--wait")
    assert second.stderr.readline().endswith("; waiting\n")
    assert first.poll() is None
    first.kill()
    first.communicate()
    second.communicate()
    assert second.returncode == 0


def test_results_that_cannot_be_locked_are_current_or_refused(ran):
    lock = ran.root / "results/.cache/lock"
    lock.unlink()
    lock.mkdir()  # stops even the superuser from writing
    assert [line.split()[1] for line in ran.says("run-all").splitlines()] == ["current"] * 4
    ran.says("run-all --set fall.height=3", "error: results: cannot be written (", code=2)


@pytest.mark.parametrize(("arguments", "code"), [(("status",), 141), (("--help",), 141), (("rn",), 2)])
def test_where_nobody_reads_on_it_ends_as_by_that_signal(ran, arguments, code):
    """Like other tools before `| head -1`: no 1, no word, and no 0 for a run that was cut off."""
    process = ran.start(*arguments)
    process.stdout.close()
    errors = process.stderr.read()
    assert process.wait() == code and bool(errors) == (code == 2) and "Traceback" not in errors


@pytest.mark.parametrize("closed", [(0,), (1,), (2,), (0, 1, 2)])
def test_with_closed_streams_it_does_its_work(ran, closed):
    """As some start programs at night; no file takes the place of standard output."""
    before, again = ran.results(), f"os.execv(sys.executable, [sys.executable, '-c', {ran.code()!r}, *sys.argv[1:]])"
    code, _, errors = ran.command("run-all", "--force", before=f"import os, sys; [*map(os.close, {closed})]; {again}; ")
    assert (code, errors, ran.results()) == (0, "", before)


def test_a_letter_that_the_terminal_lacks_stops_nothing(tmp_path):
    done = commands.afresh("init", "ω", cwd=tmp_path, PYTHONIOENCODING="latin-1")
    assert (done.returncode, done.stderr) == (0, "") and "a new study is in \\u03c9; next" in done.stdout


@pytest.mark.skipif(sys.platform == "win32", reason="a folder in use stays there")
@pytest.mark.parametrize(("words", "code"), [("status", 2), ("init new", 2), ("--help", 0)])
def test_in_a_folder_that_is_gone_it_is_one_sentence_and_the_help_is_there(ran, words, code):
    gone = "import os, tempfile; os.chdir(tempfile.mkdtemp()); os.rmdir(os.getcwd()); "
    ended, _, errors = ran.command(*words.split(), before=gone)
    said = "error: the working folder is no longer there; change to another\n" if code else ""
    assert (ended, errors) == (code, said)


MAIN = "from pipeline.cli import main\ntry: main([{}])\nexcept SystemExit: pass\n"
HEAVY = {"numpy", "scipy", "matplotlib", "exudyn", "h5py", "rich", "sympy", "numba", "stages.fall.run"}


@pytest.mark.parametrize(("code", "own"), [
    ("from pipeline.cli import cli; [cli.get_command(None, name) for name in cli.list_commands(None)]\n", True),
    (MAIN.format("'run-all', '--dry-run'"), True), (MAIN.format("'run-all'"), False),
], ids=["all commands", "a dry run", "a run with nothing to do"])  # fmt: skip
def test_what_computes_nothing_loads_nothing_heavy(ran, repository, code, own):
    code = (f"import sys; sys.path[:0] = {[] if own else [str(ran.root), str(repository)]}\n{code}"
            f"print(sorted({HEAVY} & set(sys.modules)))")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", code], cwd=repository if own else ran.root, text=True,
                          capture_output=True, check=True)  # fmt: skip
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize(("arguments", "code"), [(("--version",), 0), (("rn",), 2)])
def test_the_program_ends_with_its_code_after_all_is_said_and_tidied(arguments, code):
    """It does not wait until Python has taken its modules apart."""
    face = str(ROOT / "pipeline/face")
    program = (f"import atexit, sys; sys.path.insert(0, {face!r}); atexit.register(print, 'tidied'); "
               "from bipedstudy.__main__ import main; main()")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", program, *arguments], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == code and done.stdout.splitlines()[-1] == "tidied"
    assert ("version" in done.stdout) == (not done.stderr) == (code == 0)


#: A library that raises what it likes in place of what a signal raised in its own callback, as a dead terminal does.
BACK = """
import ctypes, os
from pipeline import cli as program
@ctypes.CFUNCTYPE(None)
def back():
    os.kill(os.getpid(), NUMBER)
    for _ in range(1000): pass
def compiled(*words, **settings):
    back()
    raise ERROR
program.cli.main = compiled
"""


@pytest.mark.parametrize("error", ["RuntimeError('no compiled object yet')", "OSError(5, 'Input/output error')"])
@pytest.mark.parametrize("number", STOPPING)
def test_a_signal_that_a_library_passes_over_in_its_own_callback_stops_it_all_the_same(
    toy_with_commands, number, error
):
    library = BACK.replace("NUMBER", str(int(number))).replace("ERROR", error)
    ended, _, errors = toy_with_commands.command("status", before=library)
    assert (ended, errors) == (128 + number, "error: stopped; everything computed before is kept\n")
