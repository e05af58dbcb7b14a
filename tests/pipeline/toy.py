"""A small study of four stages, copied from `toy_study` into a folder: quick, and able to fail in many ways.

fall -> bounce -> picture, and side by itself. `fall.behaviour` chooses what goes wrong.
"""

import contextlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from pipeline import trust
from pipeline.errors import STOPPING, StudyError
from pipeline.execution.display import Display
from pipeline.execution.executor import Assessment, Outcome, bring_up_to_date, survey
from pipeline.study import Study
from pipeline.sweep import spec as specs
from pipeline.sweep.sweep import Sweep
from tests import commands

HOME = Path(__file__).resolve().parents[2]
TEMPLATE = Path(__file__).with_name("toy_study")
TEMPLATE_PACKAGE = "toystages"


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
        return bring_up_to_date(study, values, Display(), force=wanted if force else (), jobs=jobs)

    def sweep(self, text: str) -> Sweep:
        """The sweep that a file with this text describes."""
        (self.root / "sweep.yaml").write_text(text)
        return Sweep(self.study(), specs.read(self.root / "sweep.yaml"), Display())

    def fails(self, *settings: str, said: str | None = None, names: tuple[str, ...] = (), force: bool = False,
              jobs: int = 2) -> StudyError:  # fmt: skip
        """What a run ends with that says this, by a regular expression."""
        with pytest.raises(StudyError, match=said) as failed:
            self.outcomes(*settings, names=names, force=force, jobs=jobs)
        return failed.value

    def survey(self, *settings: str) -> dict[str, Assessment]:
        """What `status` finds of each stage, by its name."""
        study = self.study(*settings)
        return {item.name: item for item in survey(study, study.parameters(study.graph.stages))}

    def path(self, name: str) -> Path:
        return self.root / name.replace("PACKAGE", self.package)

    def kept_syntax(self) -> Path:
        """The file with what was found in the sources of the stages."""
        (found,) = self.path("PACKAGE").glob("__pycache__/*.syntax.json")
        return found

    def record(self, stage: str) -> Path:
        """The file that says which result of a stage was put in place."""
        return self.root / f"results/.cache/current/{stage}.json"

    def entry(self, stage: str) -> Path:
        """The folder of the cache with that result."""
        return self.root / "results/.cache" / json.loads(self.record(stage).read_text())["key"]

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

    def start(self, *arguments: str, environment: Mapping[str, str] | None = None) -> subprocess.Popen[str]:
        """Start `bipedstudy` in the study's folder as a process of its own."""
        return subprocess.Popen(
            [sys.executable, "-c", self.code(), *arguments],
            cwd=self.root,
            env={**self._environment(), **(environment or {})},
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )

    def code(self) -> str:
        """What such a process runs."""
        # in the background of a shell, or by nohup, tests have signals ignored, and their children inherit that
        heed = f"import signal; [signal.signal(each, signal.SIG_DFL) for each in {[*map(int, STOPPING)]}]"
        return f"{heed}; import sys; sys.path.insert(0, {str(self.root)!r}); from pipeline.cli import main; main()"

    def _environment(self) -> dict[str, str]:
        return {**os.environ, "PYTHONPATH": str(HOME), "COLUMNS": "200"}

    def command(
        self, *arguments: str, before: str = "", environment: Mapping[str, str] | None = None, timeout: float = 300.0
    ) -> tuple[int, str, str]:
        """Run `bipedstudy` to its end, after some code: exit code, standard output, standard error."""
        asked = {**self._environment(), **(environment or {})}
        done = commands.python(before + self.code(), *arguments, cwd=self.root, env=asked, timeout=timeout)
        return done.returncode, done.stdout, done.stderr

    def says(self, words: str, *parts: str, code: int = 0, before: str = "",
             environment: Mapping[str, str] | None = None) -> str:
        """Standard output of a command as it is typed; it ends with this code and says these parts, however folded."""
        ended, out, errors = self.command(*shlex.split(words), before=before, environment=environment)
        told = " ".join(f"{out} {errors}".split())
        assert (ended, [part for part in parts if part not in told]) == (code, []), f"{words}: {ended}: {out}{errors}"
        assert not re.search("Traceback|unexpected", errors), errors
        return out

    def give_away(self) -> None:
        """Make all of it another user's, as root alone can."""
        for path in (self.root, *self.root.rglob("*")):
            os.chown(path, 65534, 65534, follow_symlinks=False)

    def answers(self, *typed: str) -> dict[str, tuple[int, str, str]]:
        """Exit code, standard output and errors of commands that compute nothing, by their words."""
        path = os.pathsep.join([str(self.root), str(HOME)])
        return commands.each(*typed, cwd=self.root, env={**self._environment(), "PYTHONPATH": path})

    def shows(self, *typed: str) -> list[str]:
        """Standard output of such commands that end well."""
        found = self.answers(*typed)
        assert not [words for words, (code, _, _) in found.items() if code], found
        return [out for _, out, _ in found.values()]


def put_on_path(folder: Path, code: str, *options: str) -> Path:
    """The command `bipedstudy` in a folder, as an installation of the `code` would put it on the path."""
    folder.mkdir(exist_ok=True)
    words = [sys.executable, "-m", "pipeline.cli", *options]
    (folder / "bipedstudy").write_text(f'#!/bin/sh\nPYTHONPATH="{code}" exec {shlex.join(words)} "$@"\n')
    (folder / "bipedstudy").chmod(0o755)
    return folder / "bipedstudy"


def flipped(content: bytes, at: int) -> bytes:
    """The content with another bit in the byte of this number."""
    return content[:at] + bytes([content[at] ^ 1 << at % 8]) + content[at + 1 :]


def git(folder: Path, *words: str) -> str:
    """What git says in a folder, to somebody."""
    identity = ["-c", "user.name=a lab", "-c", "user.email=lab@example.org"]
    return subprocess.run(["git", *identity, *words], cwd=folder, check=True, text=True, capture_output=True).stdout


def copied(toy: Toy, root: Path) -> Toy:
    """A study for the command line and what it has computed, in another folder."""
    shutil.copytree(toy.root, root, copy_function=shutil.copy, dirs_exist_ok=True)
    return agreed(replace(toy, root=root))


def written(root: Path, package: str) -> Toy:
    """A toy study in `root` whose stages are the package of this name; the words they declare with are their own."""
    sources = {source.relative_to(TEMPLATE).as_posix(): source for source in TEMPLATE.rglob("*.*")
               if source.is_file() and "__pycache__" not in source.parts}  # fmt: skip
    sources |= {f"{TEMPLATE_PACKAGE}/body/{name}.py": HOME / f"stages/biped/{name}.py"
                for name in ("quantity", "question")}  # fmt: skip
    sources |= {name: HOME / name for name in ("CITATION.cff", "LICENSE")}
    for name, source in sources.items():
        place, text = root / name.replace(TEMPLATE_PACKAGE, package), source.read_text()
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text.replace("stages.biped.", f"{package}.body.").replace(TEMPLATE_PACKAGE, package))
    return Toy(root, package)


def with_commands(root: Path) -> Toy:
    """A fresh toy study whose package is called `stages`, as the command line expects."""
    return agreed(written(root, "stages"))


def agreed(toy: Toy) -> Toy:
    """The same study, whose author wrote it just now and agreed to it."""
    for path in (toy.root / toy.package).rglob("*"):
        path.touch()
    trust.agree(True)
    with contextlib.redirect_stderr(None):
        trust.check(toy.root.resolve(), toy.package, True)
    trust.agree(False)
    return toy
