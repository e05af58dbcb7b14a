"""A toy study of four stages, written into a temporary folder: quick, and it can fail in every way a real one can.

fall -> bounce -> picture, and side by itself. `fall.behaviour` chooses what goes wrong.
"""

from __future__ import annotations

import itertools
import os
import shutil
import subprocess
import sys
import textwrap
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from pipeline.display import Display
from pipeline.executor import Outcome, bring_up_to_date
from pipeline.study import Study

_serial = itertools.count()

FILES = {
    "dvc.yaml": """
        stages:
          bounce:
            cmd: bipedstudy run bounce
            deps: [PACKAGE/bounce, PACKAGE/body, PACKAGE/fall/result.py, results/fall.h5]
            params:
              - params/ground.yaml: [gravity, contact_stiffness, static_friction, dynamic_friction]
            outs: [results/bounce.h5]
          fall:
            cmd: bipedstudy run fall
            deps: [PACKAGE/fall, PACKAGE/body]
            params:
              - params/ground.yaml: [gravity]
              - params/fall.yaml:
            outs: [results/fall.h5]
          side:
            cmd: bipedstudy run side
            deps: [PACKAGE/side]
            params:
              - params/side.yaml:
            outs: [results/side.h5, results/side.bin]
          picture:
            cmd: bipedstudy run picture
            deps: [PACKAGE/picture, PACKAGE/bounce/result.py, PACKAGE/side/result.py, results/bounce.h5, results/side.bin]
            params:
              - params/picture.yaml:
            outs: [results/picture.h5, results/figures, results/claims.yaml]
        """,
    "params/ground.yaml": """
        # comments and layout do not matter
        gravity:           {value: 9.81, unit: m/s^2, source: "standard value"}
        contact_stiffness: {value: 1e5, unit: N/m, source: "assumed"}
        static_friction:   {value: 1.1, unit: "1", source: "assumed"}
        dynamic_friction:  1.0
        """,
    "params/fall.yaml": """
        steps:     {value: 5, unit: "1", source: "assumed"}
        height:    {value: 2.0, unit: m, source: "assumed"}
        behaviour: {value: well, unit: "-", source: "assumed"}
        marks:     {value: [0.5, 1e-7], unit: m, source: "assumed"}
        parts:
          source: "assumed"
          rows:
            - {name: ball, mass: 0.1}
            - {name: shell, mass: 2e-1}
        """,
    "params/side.yaml": "seed: 3\nwait: 0.0\n",
    "params/picture.yaml": "title: fall\nextra: false\n",
    "PACKAGE/__init__.py": "",
    "PACKAGE/body/__init__.py": "",
    "PACKAGE/body/motion.py": '''
        """Shared by two stages."""
        import numpy as np


        def distance(gravity, time):
            """Free fall."""
            return 0.5 * gravity * np.asarray(time) ** 2  # Galileo
        ''',
    "PACKAGE/fall/__init__.py": "",
    "PACKAGE/fall/errors.py": "class NoFall(ValueError):\n    pass\n",
    "PACKAGE/fall/parameters.py": """
        from __future__ import annotations
        from dataclasses import dataclass
        from typing import ClassVar
        from stages.biped.quantity import Bound, Broken, parameter

        @dataclass(frozen=True)
        class Gravity:
            FILE: ClassVar[str] = "ground"
            gravity: float = parameter("m/s^2", "gravity", symbol="g", bound=Bound(above=0, maximum=100))

        @dataclass(frozen=True)
        class Part:
            name: str = parameter("-", "name")
            mass: float = parameter("kg", "mass", bound=Bound(above=0))

        @dataclass(frozen=True)
        class Settings:
            FILE: ClassVar[str] = "fall"
            steps: int = parameter("1", "samples", bound=Bound(minimum=1))
            height: float = parameter("m", "height", bound=Bound(minimum=0))
            behaviour: str = parameter("-", "what happens", choices=(
                "well", "raise", "answer", "crash", "exit", "sleep", "extra", "hidden", "disk"))
            marks: tuple[float, ...] = parameter("m", "marks", bound=Bound(minimum=0))
            parts: tuple[Part, ...] = parameter("1", "parts")
            label: str = parameter("-", "label", default="none")

        @dataclass(frozen=True)
        class Parameters:
            gravity: Gravity
            settings: Settings
        """,
    "PACKAGE/fall/result.py": """
        from __future__ import annotations
        from dataclasses import dataclass
        import numpy as np
        from stages.biped.quantity import quantity

        @dataclass(frozen=True)
        class Sample:
            time: np.ndarray = quantity("s", "time, shape (n,)", symbol="t")
            distance: np.ndarray = quantity("m", "way fallen, shape (n,)", symbol="s")

        @dataclass(frozen=True)
        class Result:
            sample: Sample = quantity("1", "the fall")
            height: float = quantity("m", "height", symbol="h")
            mass: dict[str, float] = quantity("kg", "mass of each part")
            files: dict[str, bytes] = quantity("-", "files")

            def summary(self) -> str:
                return f"fell {self.sample.distance[-1]:.2f} m"

            def tables(self):
                return [("Parts", ("part", "mass [kg]"), list(self.mass.items()))]
        """,
    "PACKAGE/fall/run.py": """
        import importlib, os, signal, sys, time
        import numpy as np
        from PACKAGE.body.motion import distance
        from PACKAGE.fall.errors import NoFall
        from PACKAGE.fall.result import Result, Sample

        def run(parameters, inputs, progress=lambda fraction, what: None):
            settings = parameters.settings
            print("stages print nothing, but libraries do")
            behaviour = settings.behaviour
            if behaviour == "raise":
                raise ZeroDivisionError("a pendulum\\nwithout length")
            if behaviour == "answer":
                raise NoFall("nothing falls upwards")
            if behaviour == "crash":
                os.kill(os.getpid(), signal.SIGSEGV)
            if behaviour == "exit":
                sys.exit("enough")
            if behaviour == "hidden":
                importlib.import_module("PACKAGE.side" + ".result")
            if behaviour == "disk":
                raise OSError(28, "No space left on device")
            files = {"secret.txt": b"x"} if behaviour == "extra" else {}
            if behaviour == "sleep":
                for _ in range(600):
                    progress(0.5, "sleeping")
                    time.sleep(0.1)
            t = np.linspace(0, 1, settings.steps)
            sample = Sample(t, distance(parameters.gravity.gravity, t))
            return Result(sample, settings.height, {part.name: part.mass for part in settings.parts}, files)
        """,
    "PACKAGE/bounce/__init__.py": "",
    "PACKAGE/bounce/parameters.py": """
        from __future__ import annotations
        from dataclasses import dataclass
        from typing import ClassVar
        from stages.biped.quantity import Bound, Broken, parameter

        @dataclass(frozen=True)
        class Ground:
            FILE: ClassVar[str] = "ground"
            gravity: float = parameter("m/s^2", "gravity", symbol="g", bound=Bound(above=0, maximum=100))
            contact_stiffness: float = parameter("N/m", "stiffness", symbol="k", bound=Bound(above=0))
            static_friction: float = parameter("1", "static friction", bound=Bound(minimum=0))
            dynamic_friction: float = parameter("1", "dynamic friction", bound=Bound(minimum=0))

            def broken_rules(self):
                if self.dynamic_friction > self.static_friction:
                    yield Broken("dynamic_friction", f"<= static_friction = {self.static_friction:g}")

        @dataclass(frozen=True)
        class Parameters:
            ground: Ground
        """,
    "PACKAGE/bounce/result.py": """
        from dataclasses import dataclass
        from stages.biped.quantity import quantity

        @dataclass(frozen=True)
        class Result:
            force: float = quantity("N", "peak force", symbol="F")

            def summary(self):
                return f"peak force {self.force:.3g} N"
        """,
    "PACKAGE/bounce/run.py": """
        from PACKAGE.bounce.result import Result

        def run(parameters, inputs, progress=lambda fraction, what: None):
            from PACKAGE.body import motion  # found although it stands inside a function

            fall = inputs["fall"]
            assert not fall.files
            return Result(float(fall.sample.distance[-1] * parameters.ground.contact_stiffness))
        """,
    "PACKAGE/side/__init__.py": "",
    "PACKAGE/side/parameters.py": """
        from __future__ import annotations
        from dataclasses import dataclass
        from typing import ClassVar
        from stages.biped.quantity import Bound, parameter

        @dataclass(frozen=True)
        class Settings:
            FILE: ClassVar[str] = "side"
            seed: int = parameter("1", "seed", bound=Bound(minimum=0))
            wait: float = parameter("s", "time it takes", bound=Bound(minimum=0))

        @dataclass(frozen=True)
        class Parameters:
            settings: Settings
        """,
    "PACKAGE/side/result.py": """
        from __future__ import annotations
        from dataclasses import dataclass
        from stages.biped.quantity import quantity

        @dataclass(frozen=True)
        class Result:
            number: int = quantity("1", "a number")
            files: dict[str, bytes] = quantity("-", "files")

            def summary(self):
                return f"number {self.number}"
        """,
    "PACKAGE/side/run.py": """
        import random, time
        from PACKAGE.side.result import Result

        def run(parameters, inputs, progress=lambda fraction, what: None):
            time.sleep(parameters.settings.wait)
            number = random.Random(parameters.settings.seed).randrange(1000)
            return Result(number, {"side.bin": bytes([number % 256])})
        """,
    "PACKAGE/picture/__init__.py": "",
    "PACKAGE/picture/style.mplstyle": "lines.linewidth: 1\n",
    "PACKAGE/picture/parameters.py": """
        from __future__ import annotations
        from dataclasses import dataclass
        from typing import ClassVar
        from stages.biped.quantity import parameter

        @dataclass(frozen=True)
        class Settings:
            FILE: ClassVar[str] = "picture"
            title: str = parameter("-", "title")
            extra: bool = parameter("1", "a second figure")

        @dataclass(frozen=True)
        class Parameters:
            settings: Settings
        """,
    "PACKAGE/picture/result.py": """
        from __future__ import annotations
        from dataclasses import dataclass
        from stages.biped.quantity import quantity

        @dataclass(frozen=True)
        class Result:
            names: tuple[str, ...] = quantity("-", "figures drawn")
            files: dict[str, bytes] = quantity("-", "files")

            def summary(self):
                return f"{len(self.names)} figures"
        """,
    "PACKAGE/picture/run.py": """
        from PACKAGE.picture.result import Result

        CLAIM = "- {id: force, stated: 1 N, found: %.4g N, holds: false, why: it is another toy}\\n"

        def run(parameters, inputs, progress=lambda fraction, what: None):
            title = parameters.settings.title.encode()
            files = {"figures/one.svg": title, "claims.yaml": (CLAIM % inputs["bounce"].force).encode()}
            if parameters.settings.extra:
                files["figures/two.svg"] = title + inputs["side"].read_bytes()
            return Result(tuple(sorted(files)), files)
        """,
}


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
        """Every file in the results folder outside the cache and the logs."""
        folder = self.root / "results"
        return {
            path.relative_to(folder).as_posix(): path.read_bytes()
            for path in sorted(folder.rglob("*"))
            if path.is_file() and path.relative_to(folder).parts[0] not in (".cache", "log", "log.jsonl")
        }

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        """Start `bipedstudy` in the study's folder as a process of its own."""
        home = str(Path(__file__).resolve().parents[2])
        environment = {**os.environ, "PYTHONPATH": home, "COLUMNS": "200"}
        return subprocess.Popen(
            [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(self.root)!r})\nfrom pipeline.cli import main\nmain()",
             *arguments], cwd=self.root, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)  # fmt: skip

    def command(self, *arguments: str) -> tuple[int, str, str]:
        """Run `bipedstudy` to its end: exit code, standard output, standard error."""
        process = self.start(*arguments)
        out, errors = process.communicate(timeout=60)
        return process.returncode, out, errors


def _write(root: Path, package: str) -> Toy:
    for name, text in FILES.items():
        path = root / name.replace("PACKAGE", package)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text).lstrip("\n").replace("PACKAGE", package))
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
