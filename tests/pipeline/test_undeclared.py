"""A stage that reads a file that dvc.yaml does not list is told by name, in whatever way it opens it."""

from __future__ import annotations

import os
import sqlite3

import h5py
import pytest

from pipeline.errors import StageFailed, StudyError

WAYS = {
    "open": "open(FILE).read()",
    "bytes": "Path(FILE).read_bytes()",
    "from the study": "open('lab.txt').read()",
    "by a link": "open('link').read()",
    "caught": "contextlib.suppress(Exception).__enter__(); open(FILE).read()",
    "sqlite": "sqlite3.connect(FILE).close()",
    "sqlite as a URI": "sqlite3.connect(f'file:{FILE}?mode=ro', uri=True).close()",
    "hdf5": "h5py.File(FILE)",
    "forked": "(lambda process: (process.start(), process.join()))"
              "(multiprocessing.get_context('fork').Process(target=Path(FILE).read_bytes))",
}


def reading(toy, way, file):
    """Let stage `side` read a file so."""
    head = "import contextlib\nimport multiprocessing\nimport sqlite3\nimport tempfile\n\nimport h5py\n"
    toy.edit("PACKAGE/side/run.py", "import random\n", f"import random\n{head}FILE = {str(file)!r}\n")
    toy.edit("PACKAGE/side/run.py", "    time.sleep(", f"    {way}\n    time.sleep(")


@pytest.mark.parametrize("way", WAYS)
def test_an_undeclared_file_is_named_with_its_stage(toy, way):
    if way == "forked" and not hasattr(os, "fork"):
        pytest.skip("no process is forked here")
    file = toy.root / "lab.txt"
    if way == "hdf5":
        h5py.File(file, "w").close()
    elif way.startswith("sqlite"):
        sqlite3.connect(file).close()
    file.touch()
    (toy.root / "link").symlink_to(file)
    reading(toy, WAYS[way], file)
    with pytest.raises((StageFailed, StudyError), match=r"stage side.*it read lab\.txt, which dvc\.yaml does not list"):
        toy.run(names=("side",))
    assert not (toy.root / "results/side.h5").exists()


def test_another_stages_result_and_parameters_are_undeclared_too(toy):
    toy.run(names=("fall",))
    way = ("for file in (FILE, 'params/fall.yaml'):\n        with contextlib.suppress(PermissionError):\n"
           "            open(file, 'rb').read()")  # fmt: skip
    reading(toy, way, toy.root / "results/fall.h5")
    with pytest.raises((StageFailed, StudyError), match=r"it read results/fall\.h5, params/fall\.yaml, which"):
        toy.run(names=("side",))


def test_what_is_declared_or_of_the_system_may_be_read(toy, tmp_path_factory):
    """A named file, a file of the stage's own code, what is written, and what is not there."""
    (toy.root / "lab.txt").write_text("41")
    way = ("inputs.table.read_text(), Path(__file__).read_text(), open('/etc/passwd').read() if Path('/etc/passwd')."
           "exists() else '', tempfile.TemporaryFile().write(b'x')")  # fmt: skip
    reading(toy, way, "none")
    assert toy.run("side.table=lab.txt", names=("side",)) == {"side": "computed"}


def test_the_branch_that_tells_who_uses_machine_code_is_no_input(toy):
    """Whoever compiles something in a fresh clone reads it while its stage runs."""
    (toy.root / ".git").mkdir()
    (toy.root / ".git/HEAD").write_text("ref: refs/heads/main")
    reading(toy, "Path(FILE).read_text()", toy.root / ".git/HEAD")
    assert toy.run(names=("side",)) == {"side": "computed"}
