"""The toy study of four stages in `toy_study`, copied into a temporary folder: quick, and able to fail in many ways.

fall -> bounce -> picture, and side by itself. `fall.behaviour` chooses what goes wrong.
"""

from __future__ import annotations

import itertools
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from pipeline.display import Display
from pipeline.executor import Outcome, bring_up_to_date
from pipeline.study import Study

_serial = itertools.count()

TEMPLATE = Path(__file__).with_name("toy_study")
TEMPLATE_PACKAGE = "toystages"


class Quiet(Display):
    """Collects what a run says."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def started(self, stage: str, reasons: object) -> None:
        self.lines.append(f"{stage} started")

    def note(self, sentence: str) -> None:
        self.lines.append(sentence)


@dataclass
class Toy:
    """A toy study: edit its files, run it in this process (its stages in workers), or through the command line."""

    root: Path
    package: str

    def study(self, *settings: str) -> Study:
        return Study(self.root, self.root / "params", self.root / "results", settings, self.package)

    def run(self, *settings: str, names: tuple[str, ...] = (), force: bool = False, jobs: int = 2) -> dict[str, str]:
        """Bring stages (default: all) up to date; returns stage -> current, restored or computed."""
        return {outcome.stage: outcome.how for outcome in self.outcomes(*settings, names=names, force=force, jobs=jobs)}

    def outcomes(
        self, *settings: str, names: tuple[str, ...] = (), force: bool = False, jobs: int = 2
    ) -> list[Outcome]:
        study = self.study(*settings)
        wanted = study.graph.needed_for(names or tuple(study.graph.stages))
        values = study.parameters(wanted)
        return bring_up_to_date(study, values, Quiet(), force=wanted if force else (), jobs=jobs)

    def path(self, name: str) -> Path:
        return self.root / name.replace("PACKAGE", self.package)

    def edit(self, name: str, old: str, new: str) -> None:
        path = self.path(name)
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))

    def results(self) -> dict[str, bytes]:
        """Every file in the results folder outside the cache, the logs and the report, which tells the times."""
        folder = self.root / "results"
        return {
            path.relative_to(folder).as_posix(): path.read_bytes()
            for path in sorted(folder.rglob("*"))
            if path.is_file() and path.relative_to(folder).parts[0] not in (".cache", "log", "log.jsonl", "report.html")
        }

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        """Start `bipedstudy` in the study's folder as a process of its own."""
        home = str(Path(__file__).resolve().parents[2])
        environment = {**os.environ, "PYTHONPATH": home, "COLUMNS": "200"}
        # a shell that runs the tests in the background has interrupts ignored, and its children inherit that
        heed = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
        code = f"{heed}; import sys; sys.path.insert(0, {str(self.root)!r}); from pipeline.cli import main; main()"
        return subprocess.Popen(
            [sys.executable, "-c", code, *arguments],
            cwd=self.root,
            env=environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )

    def command(self, *arguments: str) -> tuple[int, str, str]:
        """Run `bipedstudy` to its end: exit code, standard output, standard error."""
        process = self.start(*arguments)
        out, errors = process.communicate(timeout=300)
        return process.returncode, out, errors


def _write(root: Path, package: str) -> Toy:
    for source in TEMPLATE.rglob("*"):
        if source.is_file() and "__pycache__" not in source.parts:
            path = root / source.relative_to(TEMPLATE).as_posix().replace(TEMPLATE_PACKAGE, package)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(source.read_text().replace(TEMPLATE_PACKAGE, package))
    return Toy(root, package)


@pytest.fixture
def toy(tmp_path: Path) -> Toy:
    """A fresh toy study for runs from this process; its package has a name of its own, as imports are remembered."""
    before = list(sys.path)
    yield _write(tmp_path, f"toy{os.getpid()}_{next(_serial)}")
    sys.path[:] = before


@pytest.fixture
def toy_with_commands(tmp_path: Path, repository: Path) -> Toy:
    """A fresh toy study whose package is called `stages`, as the command line expects."""
    study = _write(tmp_path, "stages")
    (tmp_path / "stages/biped").mkdir()
    (tmp_path / "stages/biped/__init__.py").touch()
    shutil.copyfile(repository / "stages/biped/quantity.py", tmp_path / "stages/biped/quantity.py")
    return study


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Toy:
    """A toy study that has been run once; tests copy it with `copy_of`."""
    toy = _write(tmp_path_factory.mktemp("finished"), f"toy{os.getpid()}_{next(_serial)}")
    before = list(sys.path)
    toy.run()
    sys.path[:] = before
    return toy


@pytest.fixture
def done(finished: Toy, tmp_path: Path) -> Toy:
    """A toy study that has been run once, free to be spoilt."""
    root = tmp_path / "study"
    shutil.copytree(finished.root, root)
    before = list(sys.path)
    yield replace(finished, root=root)
    sys.path[:] = before
