"""Whose study it is: nothing of another's, and no code that nobody agreed to, is run by being near it."""

import importlib.util
import os
import py_compile
import shutil
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from pipeline import SealedLoader, trust
from pipeline.cache import processor
from pipeline.errors import StudyError
from pipeline.home import engine, face
from pipeline.study import locate
from tests import commands

unix = pytest.mark.skipif(os.name != "posix", reason="uses owners of files")
as_root = pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="gives files to another user")
NOBODY = 65534
#: Every command, one that the study's own stage adds, and help.
COMMANDS = ("run-all", "run side", "status", "graph", "sweep grid.yaml", "show side", "claims", "report", "figures one",
            "compare results", "doctor", "clean", "tally", "--help", "run-all --help")  # fmt: skip


def each(folder: Path, *words: str, **environment: str) -> dict[str, tuple[int, str]]:
    """Exit code and errors of commands in a folder, as a user of this program calls them there."""
    told = commands.each(*words, cwd=folder, **environment)
    return {typed: (code, " ".join(errors.split())) for typed, (code, _, errors) in told.items()}


@pytest.fixture
def trapped(toy_with_commands, monkeypatch, tmp_path, told):
    """A study whose code leaves a file wherever it is run, and a user who agreed to nothing."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "settings"))
    toy = toy_with_commands
    for source in toy.path("stages").rglob("*.py"):
        source.write_text(f"{source.read_text()}\nopen({str(told / 'sprung')!r}, 'a').close()\n")
    (toy.root / "sprung").symlink_to(told / "sprung")
    (toy.root / "below/deeper").mkdir(parents=True)
    for place in (".", "below/deeper"):
        (toy.root / place / "grid.yaml").write_text("stage: side\nkind: grid\nvary: {side.seed: [1, 2]}\n")
    return toy


@pytest.mark.parametrize(("whose", "place"), [
    pytest.param("another's", ".", marks=as_root), ("unread", "."), ("unread", "below/deeper")])  # fmt: skip
def test_no_command_runs_anything_of_a_study_that_was_not_agreed_to(trapped, place, whose):
    if whose == "another's":
        trapped.give_away()
    found = each(trapped.root / place, *COMMANDS)
    assert found.keys() == {*COMMANDS} and not (trapped.root / "sprung").exists()
    refused = {words for words, (code, said) in found.items() if code == 2 and "would run as you" in said}
    with_code = {"run-all", "run side", "status", "sweep grid.yaml", "tally"}
    assert refused >= (with_code if whose == "unread" else {*COMMANDS} - {"--help", "run-all --help"})


def test_a_study_of_ones_own_is_agreed_to_once_where_nobody_else_may_write_it(trapped):
    assert each(trapped.root, "status")["status"][0] == 2
    assert each(trapped.root / "below/deeper", "--trust status")["--trust status"][0] == 0
    assert (trapped.root / "sprung").exists()
    trapped.edit("PACKAGE/side/run.py", "import", "import\\\n ")
    found = each(trapped.root, "status", "run side")
    assert [code for code, _ in found.values()] == [0, 0] and not any("agree" in said for _, said in found.values())
    (rows,) = (trapped.root / "settings").rglob("trusted.jsonl")
    rows.chmod(0o666)
    assert each(trapped.root, "status")["status"][0] == (2 if os.name == "posix" else 0)


@unix
@pytest.mark.parametrize("whose", ["unpacked", pytest.param("another's", marks=as_root)])
def test_code_that_came_from_elsewhere_is_agreed_to_by_content(trapped, whose, tmp_path_factory):
    code, long_ago = trapped.path("stages/fall/run.py"), time.time() - 3600
    os.utime(code, (long_ago, long_ago)) if whose == "unpacked" else os.chown(code, NOBODY, NOBODY)
    said = each(trapped.root, "--trust status", "status")
    assert [code for code, _ in said.values()] == [0, 0] and "as it is now" in said["--trust status"][1]
    trapped.edit("PACKAGE/side/run.py", "import", "import\\\n ")
    code, errors = each(trapped.root, "status")["status"]
    digest = errors.rpartition("=")[2]
    assert code == 2 and "has code of its own" in errors and len(digest) == 32
    assert each(trapped.root, "status", BIPEDSTUDY_TRUST=f"{'0' * 32} {digest}")["status"][0] == 0
    shutil.copytree(trapped.root, copy := tmp_path_factory.mktemp("elsewhere") / "copy")
    assert each(copy, "status", BIPEDSTUDY_TRUST=digest)["status"][0] == 0, "in CI it lies elsewhere"
    trapped.edit("dvc.yaml", "stages:", "stages: ")
    assert each(trapped.root, "status", BIPEDSTUDY_TRUST=digest)["status"][0] == 2


def test_what_could_be_imported_in_place_of_a_package_is_part_of_the_content(trapped):
    before = set(trust._code(trapped.root, "stages"))
    for name in ("numpy.py", "yaml/__init__.py", "yaml/__pycache__/x.pyc", "stages/table.csv", "results/no.py"):
        (trapped.root / name).parent.mkdir(parents=True, exist_ok=True)
        (trapped.root / name).touch()
    more = {path.relative_to(trapped.root).as_posix() for path in {*trust._code(trapped.root, "stages")} - before}
    assert more == {"numpy.py", "yaml/__init__.py", "yaml/__pycache__/x.pyc", "stages/table.csv"}


def test_what_a_link_names_is_told_once_in_whatever_order_a_disk_lists_folders(trapped, monkeypatch):
    def backwards(*of, walk=os.walk, **how):
        for place, folders, names in walk(*of, **how):
            folders.reverse()
            yield place, folders, names[::-1]

    (trapped.root / "stages/again").symlink_to("side")
    found = sorted(trust._code(trapped.root, "stages"))
    assert len({path.resolve() for path in found}) == len(found)
    monkeypatch.setattr(os, "walk", backwards)
    assert sorted(trust._code(trapped.root, "stages")) == found


def test_compiled_code_that_came_along_is_not_run(trapped):
    """Whoever agreed to the sources has not seen it. It has the right seal, and times and size of its source."""
    clean = trapped.path("stages/fall/parameters.py")
    text, found = clean.read_text(), clean.stat()
    for source in (clean, trapped.path("stages/__init__.py")):
        text, found = source.read_text(), source.stat()
        source.write_text(f"{text}\nopen({str(trapped.root / 'planted')!r}, 'a').close()\n"[:4000])
        planted = Path(py_compile.compile(str(source), doraise=True))
        content = bytearray(planted.read_bytes())
        source.write_text(text)
        os.utime(source, ns=(found.st_atime_ns, found.st_mtime_ns))
        content[12:16] = len(text.encode()).to_bytes(4, "little")
        content[8:12] = int(found.st_mtime).to_bytes(4, "little")
        SealedLoader(source.stem, str(source)).set_data(str(planted), bytes(content))
        assert planted == Path(importlib.util.cache_from_source(str(source)))
    assert each(trapped.root, "--trust status")["--trust status"][0] == 0
    assert (trapped.root / "sprung").exists() and not (trapped.root / "planted").exists()


@unix
def test_the_checkout_that_runs_is_trusted_whoever_owns_it(trapped, monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    trust.check(engine(), "stages", True)
    with pytest.raises(StudyError, match=r"belongs to .*, not to you"):
        trust.check(trapped.root, "stages", False)


# --- One folder, one program, one environment: a checkout is computed by its own engine, stages come from one
# place.


@pytest.fixture
def other(repository, tmp_path):
    """As much of another checkout as tells that it is one."""
    (tmp_path / "pipeline").mkdir()
    for name in ("dvc.yaml", "pipeline/home.py"):
        shutil.copy(repository / name, tmp_path / name)
    return tmp_path.resolve()


@pytest.mark.parametrize("words", ["gait --json", "run-all --accuracy draft", "run analytic", "status", "unknown"])
def test_a_command_in_another_checkout_ends_with_a_sentence(other, words):
    done = commands.run(*words.split(), cwd=other)
    own = other / ".venv" / "bin" / "bipedstudy"
    assert done.returncode == 2 and done.stdout == "" and len(done.stderr.splitlines()) == 1
    assert f"{other} is computed by its own program, and this one is that of {engine()}; " in done.stderr
    assert done.stderr.endswith(f"run make install in {other}, then {own}\n")


def test_nor_does_a_notebook_mix_them(other):
    (other / "below").mkdir()
    with pytest.raises(StudyError, match="is computed by its own program"):
        locate(start=other / "below")


def test_a_copy_of_this_one_under_another_name_is_itself(repository, tmp_path):
    (tmp_path / "link").symlink_to(repository)
    assert locate(start=tmp_path / "link").root == repository.resolve()


def test_the_face_takes_the_stages_of_a_study_that_brings_its_own(toy_with_commands):
    """Questions as workers: the installed stages, which the face knows as its own, have no such question."""
    with_face = f"import sys; sys.path.insert(0, {str(face().parent)!r}); import bipedstudy; "
    code, out, errors = toy_with_commands.command("tally", "--jobs", "1", before=with_face)
    assert code == 0 and out, errors


def test_one_process_takes_the_stages_of_one_place(done):
    values = done.study().parameters(("side",))
    assert values and type(values["side"]).__module__.startswith(done.package)
    shutil.copytree(done.root, done.root.with_name("copy"))
    with pytest.raises(StudyError, match=f"another {done.package} was imported before, from {done.root}"):
        replace(done, root=done.root.with_name("copy")).study().parameters(("side",))


@pytest.mark.parametrize("begin", ["import bipedstudy", "import pipeline.cli as c; c.cli.main = int; c.main()"])
def test_notebooks_and_commands_compute_in_the_environment_of_workers(begin, monkeypatch):
    """Before NumPy is loaded, which reads it then."""
    monkeypatch.delenv(processor.VARIABLE, raising=False)  # what whoever runs the tests chose
    clean = {name: value for name, value in os.environ.items() if name not in processor.environment()}
    tell = (f"import os, sys, atexit; told = {sorted(processor.environment())}\n"
            f"sys.path.insert(0, {str(face().parent)!r})\n"
            "atexit.register(lambda: print('numpy' in sys.modules, [os.environ.get(name) for name in told]))\n")
    said = subprocess.run([sys.executable, "-c", tell + begin], cwd=engine(), env=clean, text=True, capture_output=True)
    assert said.stdout == f"False {[value for _, value in sorted(processor.environment().items())]}\n", said.stderr
