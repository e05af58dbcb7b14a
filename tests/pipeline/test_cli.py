"""The command line: what it prints, its exit codes, and how quick it is."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pipeline.commands import show
from pipeline.study import locate

ROOT = Path(__file__).resolve().parents[2]


def test_run_all_prints_a_line_for_each_stage_and_for_the_report(toy_with_commands):
    code, out, errors = toy_with_commands.command("run-all", "--jobs", "1")
    assert (code, errors) == (0, "")
    lines = out.splitlines()
    assert len(lines) == 5 and lines[4].split() == ["report", "written", "results/report.html"]
    assert lines[0].split()[:2] == ["fall", "computed"] and lines[0].endswith("fell 4.91 m")
    code, out, _ = toy_with_commands.command("run-all")
    assert [line.split()[1] for line in out.splitlines()] == ["current"] * 4


def test_run_all_as_json(ran):
    _, out, _ = ran.command("run-all", "--json", "--set", "ground.contact_stiffness=2e5")
    answer = json.loads(out)
    assert [(stage["stage"], stage["how"]) for stage in answer["stages"]] == [
        ("fall", "current"), ("bounce", "computed"), ("side", "current"), ("picture", "computed")
    ]  # fmt: skip
    assert answer["stages"][1]["reasons"] == ["ground.yaml: contact_stiffness 1e5 -> 2e5"]


def test_a_dry_run_runs_nothing(ran):
    before = ran.results()
    code, out, _ = ran.command("run-all", "--dry-run", "--set", "ground.contact_stiffness=2e5")
    assert code == 0
    assert "bounce        stale    ground.yaml: contact_stiffness 1e5 -> 2e5" in out.splitlines()
    assert ran.results() == before


def test_run_takes_several_stages_and_force_means_only_those(ran):
    code, out, _ = ran.command("run", "bounce", "side", "--force")
    assert code == 0
    assert sorted(line.split()[:2] for line in out.splitlines()) == [
        ["bounce", "computed"], ["fall", "current"], ["side", "computed"]
    ]  # fmt: skip


def test_verbose_says_why(ran):
    _, out, _ = ran.command("run", "fall", "-v", "--set", "fall.height=3")
    assert "computing: fall.yaml: height 2 -> 3" in out


def test_status(ran):
    code, out, errors = ran.command("status")
    assert (code, errors) == (0, "")
    assert [line.split() for line in out.splitlines()] == [
        [name, "current"] for name in ("fall", "bounce", "side", "picture")
    ]
    assert json.loads(ran.command("status", "--json")[1])[0] == {"stage": "fall", "state": "current", "reasons": []}


def test_graph(toy_with_commands):
    code, out, _ = toy_with_commands.command("graph")
    assert code == 0 and "  reads   results/bounce.h5, results/side.bin" in out.splitlines()
    nodes = json.loads(toy_with_commands.command("graph", "--json")[1])
    assert nodes[3]["upstream"] == ["bounce", "side"]


def test_show_prints_fields_units_and_tables(ran):
    code, out, errors = ran.command("show", "fall")
    assert code == 0, errors
    assert any(line.split()[:3] == ["height", "2", "m"] for line in out.splitlines())
    assert "Parts" in out.splitlines()
    tree = json.loads(ran.command("show", "results/bounce.h5", "--json")[1])
    assert tree["fields"][0]["path"] == "force" and tree["fields"][0]["unit"] == "N"
    assert tree["provenance"]["stage"] == "bounce"
    assert "ground.contact_stiffness = 1e5" in tree["provenance"]["parameters"].splitlines()


def test_show_why_tells_parameters_by_line_inputs_code_and_the_same_of_what_was_read(ran):
    code, out, errors = ran.command("show", "--why", "bounce.force")
    lines = [line.strip() for line in out.splitlines()]
    assert (code, errors) == (0, "") and lines[0].startswith("results/bounce.h5: force = ")
    own, above = (next(n for n, line in enumerate(lines) if line.startswith(f"stage {name}, "))
                  for name in ("bounce", "fall"))  # fmt: skip
    stated = (ran.root / "params/ground.yaml").read_text().splitlines()
    number = next(n for n, line in enumerate(stated, 1) if line.startswith("contact_stiffness"))
    told = " ".join(lines[own:above])
    assert f"ground.contact_stiffness = 1e5 N/m params/ground.yaml:{number} (assumed)" in " ".join(told.split())
    assert "reads results/fall.h5, made by stage fall, SHA-256 " in told and "code: stages/bounce/run.py and " in told
    assert "fall.marks = [0.5, 1e-7] m" in " ".join(lines[above:]) and "that are told above" in " ".join(lines[above:])
    made = json.loads(ran.command("show", "--why", "bounce", "force", "--json")[1])["made"]
    assert [one["stage"] for one in made] == ["bounce", "fall"]
    assert "stages/fall/run.py" in made[1]["code"] and any(each.startswith("numpy ") for each in made[1]["versions"])
    ran.edit("params/ground.yaml", "value: 1e5", "value: 2e5")
    again = ran.command("show", "--why", "bounce.force", "--csv")[1].splitlines()
    assert "set for this run; the file says 2e5" in next(line for line in again if "contact_stiffness" in line)


def test_why_names_the_line_of_a_row(repository):
    study = locate(start=repository)
    (found,) = show._parameters(study, "twin.materials.1 = {name: aluminium, density: 2700}")
    path, _, number = found["place"].partition(":")
    assert "name: aluminium" in (repository / path).read_text().splitlines()[int(number) - 1]


def test_claims(ran):
    found = json.loads(ran.command("claims", "--json")[1])
    assert found["claims"] == [
        {"id": "force", "section": "1", "words": "one newton", "implies": "1 N", "measured": "4.905e+05 N",
         "verdict": "does not hold", "condition": "", "causes": ["it is another toy"],
         "rests_on": ["ground.gravity 9.81"], "numbers": [], "beside": "", "figures": [], "plain": ""}
    ]  # fmt: skip
    assert found["headlines"] == ["it is a toy"] and found["tables"][0]["rows"] == [["weight", "2"]]
    lines = ran.command("claims")[1].splitlines()
    assert lines[0] == "force: does not hold" and max(map(len, lines)) <= 100
    assert [line.split(maxsplit=1)[0] for line in lines[1:6]] == ["says", "implies", "measured", "verdict", "because"]
    assert "Toys" in lines and not [line for line in lines if line.startswith("1 claims")], "one needs no count"
    assert "| [force](#force) | 1 | does not hold |" in ran.command("claims", "--markdown")[1].splitlines()
    assert 'there is no claim "weight" (claims: force)' in ran.command("claims", "weight")[2]


def test_claims_are_written_between_the_marks_that_a_file_has(ran):
    page = ran.root / "page.md"
    page.write_text("before\n<!-- headlines -->\nold\n<!-- /headlines -->\nafter\n")
    assert ran.command("claims", "--into", str(page))[0] == 0
    assert page.read_text() == "before\n<!-- headlines -->\n- it is a toy\n<!-- /headlines -->\nafter\n"
    page.write_text("<!-- claims -->\n")
    assert "one is missing" in ran.command("claims", "--into", str(page))[2]
    page.write_text("nothing")
    assert "there are no lines" in ran.command("claims", "--into", str(page))[2]


def test_a_claim_names_the_figures_that_show_something_of_it(ran):
    captions = ran.root / "results/captions.yaml"
    captions.write_text("figures:\n- {name: one, claims: [force]}\n- {name: two, claims: []}\n")
    try:
        assert json.loads(ran.command("claims", "--json")[1])["claims"][0]["figures"] == ["one"]
        assert "  shown in  one" in ran.command("claims", "force")[1].splitlines()
    finally:
        captions.unlink()


def test_claims_of_another_version_are_refused_with_a_sentence(ran):
    (ran.root / "results/claims.yaml").write_text("- {id: force, holds: false}\n")
    assert "not the claims of this version; make them anew with" in ran.command("claims")[2]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("run", "fall", "--set", "fall.height=-1"), "height = -1 m is not allowed; allowed: >= 0 m"),
        (("run", "fal"), 'there is no stage "fal" (stages: fall, bounce, side, picture); did you mean "fall"?'),
        (("rn",), 'there is no command "rn"; did you mean "run"? (see bipedstudy --help)'),
        (("run",), "Missing argument 'STAGE...' (see bipedstudy run --help)"),
        (("run-all", "--jobs", "0"), "Invalid value for '--jobs' / '-j': 0 is not in the range x>=1"),
        (("run-all", "--job", "2"), "No such option"),
        (("run-all", "--params", "nowhere"), "nowhere/fall.yaml: there is no such file"),
        (("show", "fal"), '"fal" is neither a stage (fall, bounce, side, picture) nor a file; did you mean "fall"?'),
        (("show", "dvc.yaml"), "dvc.yaml: is truncated or not an HDF5 file; it cannot be read as an artefact"),
        (("show", "params"), "params: is a folder, not a file"),
        (("claims", "--results", "elsewhere"), "claims.yaml is not there yet; make it with: bipedstudy run comparison"),
        (("show", "fall", "--results", "elsewhere"), "fall.h5 is not there yet; make it with: bipedstudy run fall"),
        (("run", "fall", "--results", "dvc.yaml"), "dvc.yaml: cannot be written"),
    ],
)  # fmt: skip
def test_bad_input_is_one_sentence_and_exit_code_2(toy_with_commands, arguments, sentence):
    code, out, errors = toy_with_commands.command(*arguments)
    assert code == 2
    assert "Traceback" not in errors and out == ""
    assert errors.startswith("error: ") and sentence in errors


def test_bad_input_leaves_the_results_valid(ran):
    before = ran.results()
    assert ran.command("run-all", "--set", "ground.gravity=0", "--set", "fall.steps=x")[0] == 2
    assert ran.results() == before
    assert {state["state"] for state in json.loads(ran.command("status", "--json")[1])} == {"current"}


def test_a_truncated_artefact_is_one_sentence(ran):
    path = ran.root / "results/fall.h5"
    path.write_bytes(path.read_bytes()[:1000])
    code, out, errors = ran.command("show", "fall")
    assert code == 2 and out == ""
    assert errors == (
        "error: results/fall.h5: is truncated or not an HDF5 file; it cannot be read as an artefact of this study\n"
    )
    assert "fall          in cache results/fall.h5 was edited or damaged" in ran.command("status")[1].splitlines()


def test_two_runs_at_once(toy_with_commands):
    toy = toy_with_commands
    first = toy.start("run", "side", "--set", "side.wait=100")
    lock = toy.root / "results/.cache/lock"
    while not (lock.exists() and lock.read_text()):
        assert first.poll() is None
        time.sleep(0.02)
    code, _, errors = toy.command("run-all")
    assert code == 2
    assert f"error: results is in use by process {first.pid} (bipedstudy run side" in errors
    assert toy.command("status")[0] == 0
    second = toy.start("run-all", "--wait")
    assert second.stderr.readline().endswith("; waiting\n")
    assert first.poll() is None
    first.kill()
    first.communicate()
    second.communicate()
    assert second.returncode == 0


def test_independent_stages_run_side_by_side(toy_with_commands):
    toy = toy_with_commands
    process = toy.start("run", "fall", "side", "--jobs", "2", "--set", "fall.behaviour=sleep")
    assert process.stdout.readline().startswith("side          computed")
    assert process.poll() is None  # fall, which was started first, still sleeps
    process.kill()
    process.communicate()


def test_results_in_another_folder(ran):
    before = ran.results()
    code, _, errors = ran.command("run-all", "--results", "elsewhere", "--set", "fall.height=7")
    assert code == 0, errors
    assert ran.results() == before
    assert (ran.root / "elsewhere/figures/one.svg").exists()


def test_results_that_cannot_be_locked_are_current_or_refused(ran):
    lock = ran.root / "results/.cache/lock"
    lock.unlink()
    lock.mkdir()  # stops even the superuser from writing
    code, out, _ = ran.command("run-all")
    assert (code, [line.split()[1] for line in out.splitlines()]) == (0, ["current"] * 4)
    code, _, errors = ran.command("run-all", "--set", "fall.height=3")
    assert code == 2 and errors.startswith("error: results: cannot be written (")


def test_a_read_only_results_folder_can_be_looked_at(ran):
    if os.geteuid() == 0:
        pytest.skip("root may write anywhere")
    folder = ran.root / "results"
    folder.chmod(0o500)
    (folder / ".cache").chmod(0o500)
    try:
        assert ran.command("status")[0] == 0
        assert ran.command("show", "fall")[0] == 0
        code, _, errors = ran.command("run-all", "--force")
        assert code in (1, 2) and "Traceback" not in errors and errors.startswith("error: ")
    finally:
        folder.chmod(0o700)
        (folder / ".cache").chmod(0o700)


@pytest.mark.parametrize(("arguments", "code"), [(("status",), 141), (("--help",), 141), (("rn",), 2)])
def test_where_nobody_reads_on_it_ends_as_by_that_signal(ran, arguments, code):
    """Like other tools before `| head -1`: no 1, no word, and no 0 for a run that was cut off."""
    process = ran.start(*arguments)
    process.stdout.close()
    errors = process.stderr.read()
    assert process.wait() == code and bool(errors) == (code == 2) and "Traceback" not in errors


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


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_that_a_library_passes_over_in_its_own_callback_stops_it_all_the_same(toy_with_commands, number):
    code = (
        "import ctypes, os\n"
        "from pipeline import cli as program\n"
        "@ctypes.CFUNCTYPE(None)\n"
        "def back():\n"
        f"    os.kill(os.getpid(), {int(number)})\n"
        "    for _ in range(1000): pass\n"
        "def compiled(*words, **settings):\n"
        "    back()\n"
        "    raise RuntimeError('no compiled object yet')\n"
        "program.cli.main = compiled\n"
    )
    ended, _, errors = toy_with_commands.command("status", before=code)
    assert (ended, errors) == (128 + number, "error: stopped; everything computed before is kept\n")
