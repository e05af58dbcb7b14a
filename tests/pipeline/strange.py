"""Strange files in the places where a study reads files, and what the study makes of them.

A file is *survived* if every command ends in time and in bounded memory, with a code and a sentence of its own where
the file is refused, and once the file is gone the study has the right results. *Wrong*: a command that ended well left
something else than the right results. *Lost*: a stage that the file does not belong to computed again.
"""

import contextlib
import ctypes
import json
import os
import re
import resource
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass

from pipeline.cache import disk
from tests.pipeline import strange_files
from tests.pipeline.counts import Count
from tests.pipeline.strange_files import Maker, written
from tests.pipeline.toy import HOME, TEMPLATE, TEMPLATE_PACKAGE, Toy

_FALL = "  fall:\n    cmd: bipedstudy run fall"
_OUTS = "outs: [results/fall.h5]"
_DEPS = "deps: [stages/fall, stages/body]"
_PARAMS = "      - params/fall.yaml:\n"

_EDITS: tuple[tuple[str, str, str], ...] = (
    ("another key at the top", "stages:\n", "vars: [a.yaml]\nstages:\n"),
    ("no stages", "stages:\n", "stage:\n"),
    ("another command", "cmd: bipedstudy run fall", "cmd: rm -rf /"),
    ("two commands", "cmd: bipedstudy run fall", "cmd: [bipedstudy run fall, rm -rf /]"),
    ("command with more", "cmd: bipedstudy run fall", "cmd: bipedstudy run fall; rm -rf /"),
    ("no command", "    cmd: bipedstudy run fall\n", ""),
    ("unknown key", _FALL, _FALL + "\n    wdir: /"),
    ("misspelt key", "deps: [stages/fall, stages/body]", "dep: [stages/fall, stages/body]"),
    ("key twice", _FALL, _FALL + "\n    cmd: bipedstudy run fall"),
    ("stage twice", "  side:\n", "  fall:\n"),
    ("stage that is a list", _FALL, "  fall: []\n  other:\n    cmd: bipedstudy run other"),
    ("stage that is null", _FALL, "  other:\n  fall:\n    cmd: bipedstudy run fall"),
    ("out outside of the study", _OUTS, "outs: [results/fall.h5, /tmp/x]"),
    ("out with a step up", _OUTS, "outs: [results/fall.h5, results/../x]"),
    ("out outside of results", _OUTS, "outs: [results/fall.h5, params/fall.yaml]"),
    ("out that is the lock", _OUTS, "outs: [results/fall.h5, results/.cache/lock]"),
    ("out that is the report", _OUTS, "outs: [results/fall.h5, results/report.html]"),
    ("out that is the log", _OUTS, "outs: [results/fall.h5, results/log/fall.log]"),
    ("out of another stage", _OUTS, "outs: [results/fall.h5, results/side.bin]"),
    ("out inside of another's folder", _OUTS, "outs: [results/fall.h5, results/figures/one.svg]"),
    ("out twice", _OUTS, "outs: [results/fall.h5, results/fall.h5]"),
    ("out that is the whole folder", _OUTS, "outs: [results/fall.h5, results]"),
    ("out with a drive", _OUTS, "outs: [results/fall.h5, 'C:results/x']"),
    ("out with a backslash", _OUTS, "outs: [results/fall.h5, 'results\\x']"),
    ("out with a null byte", _OUTS, 'outs: [results/fall.h5, "results/x\\0"]'),
    ("out that is a mapping", _OUTS, "outs: [results/fall.h5, {results/x: {cache: false}}]"),
    ("outs that are a word", _OUTS, "outs: results/fall.h5"),
    ("outs that are a number", _OUTS, "outs: 3"),
    ("outs that are null", _OUTS, "outs:"),
    ("no artefact among the outs", _OUTS, "outs: [results/other.h5]"),
    ("input that no stage makes", _DEPS, "deps: [stages/fall, stages/body, results/nosuch.h5]"),
    ("input of its own", _DEPS, "deps: [stages/fall, stages/body, results/fall.h5]"),
    ("circle of stages", _DEPS, "deps: [stages/fall, stages/body, results/bounce.h5]"),
    ("input outside of the study", _DEPS, "deps: [stages/fall, stages/body, /etc/passwd]"),
    ("input that is a mapping", _DEPS, "deps: [stages/fall, {stages/body: 1}]"),
    ("parameters of another folder", _PARAMS, "      - ../fall.yaml:\n"),
    ("parameters that are a word", "    params:\n      - params/side.yaml:\n", "    params: side\n"),
    ("parameters that are a number", "    params:\n      - params/side.yaml:\n", "    params: 3\n"),
    ("parameter key that is none", "params/ground.yaml: [gravity]", "params/ground.yaml: [gravitty]"),
    ("parameter keys that are a mapping", "params/ground.yaml: [gravity]", "params/ground.yaml: {gravity: 1}"),
    ("parameter file that is not there", _PARAMS, "      - params/nosuch.yaml:\n"),
    ("tag", "cmd: bipedstudy run fall", "cmd: !!python/object/apply:os.system [true]"),
    ("anchor inside itself", _DEPS, "deps: &a [*a]"),
    ("variable", "cmd: bipedstudy run fall", "cmd: bipedstudy run ${stage}"),
    ("foreach", _FALL, "  many:\n    foreach: [1, 2]\n    do: {cmd: bipedstudy run many}\n" + _FALL),
)
#: Names of a stage as they stand in YAML, each with command and outs that fit it.
_NAMES = {
    "number": "1", "null": "~", "step up": "../fall", "blank": "fall down", "line end": "fa\\nll",
    "null byte": "fa\\0ll",
    "keyword": "import", "no code": "nosuch", "hidden": ".fall", "package": "fall.run", "dunder": "__init__",
    "not in ASCII": "fäll", "surrogate": "\\ud800", "very long": "f" * 300, "empty": "", "option": "--help",
}  # fmt: skip


def graphs(text: str) -> Iterator[tuple[str, str]]:
    """Each strange graph that the right one can be edited to."""
    for name, old, new in _EDITS:
        assert text.count(old) >= 1, f"{name}: {old}"
        yield name, text.replace(old, new, 1)
    for name, stage in _NAMES.items():
        named = text.replace(_FALL, f'  "{stage}":\n    cmd: "bipedstudy run {stage}"')
        yield f"stage called by a {name}", named.replace("results/fall.h5", f'"results/{stage}.h5"')


# --- Files in their places.


_LONGEST_S = 180
_MEMORY = 6_000_000_000
_MAY_READ_ALL = 0b110  # CAP_DAC_OVERRIDE and CAP_DAC_READ_SEARCH
_CAPABILITIES_3 = 0x20080522  # the form in which the system tells and takes them
_NO_SENTENCE = re.compile("Traceback|unexpected|Segmentation")
_SAID = re.compile("^error: .|^0 of 1 runs can be used", re.MULTILINE)  # the second is the end of a report
_MAP = """
runs:
  - experiment: {name: walk 1, origin: measured, slope_deg: 2.0}
    files:
      - file: walk.csv
        device: {place: hip, rate_hz: 100, accelerometer_unit: g, gyroscope_unit: deg/s}
        columns: {packet: Counter, ax: AccX, ay: AccY, az: AccZ, gx: GyrX, gy: GyrY, gz: GyrZ}
"""


@dataclass(frozen=True)
class Place:
    """Where a strange file lies, in the toy study's folder, and the commands that meet it there.

    `repaired`: a run puts a right file in its place, and must end well.
    """

    name: str
    path: str
    commands: tuple[tuple[str, ...], ...]
    makers: dict[str, Maker]
    repaired: bool = False


_GRAPH = (TEMPLATE / "dvc.yaml").read_text(encoding="utf-8").replace(TEMPLATE_PACKAGE, "stages")
_INGEST = "ingest"  # is asked of the real study
PLACES = (
    Place("parameter file", "params/fall.yaml", (("status",), ("run", "fall")), strange_files.YAML),
    Place("file of a sweep", "strange.yaml", (("sweep", "strange.yaml", "--dry-run"),), strange_files.YAML),
    Place(
        "file that a parameter names", "lab.txt", (("run", "side", "--set", "side.table=lab.txt"),), strange_files.ANY
    ),
    Place("artefact", "results/fall.h5", (("show", "fall"), ("status",), ("run-all",)), strange_files.ARTEFACT, True),
    Place("manifest", "results/.cache/KEY/manifest.json", (("status",), ("run-all",)), strange_files.JSON, True),
    Place("record", "results/.cache/current/fall.json", (("status",), ("run-all",)), strange_files.JSON, True),
    Place("graph", "dvc.yaml", (("status",), ("run-all",)), {name: written(text) for name, text in graphs(_GRAPH)}),
    Place("database", "walk.sqlite", ((_INGEST, "walk.sqlite"),), strange_files.DATABASE),
    Place("log", "logs/walk.csv", ((_INGEST, "logs", "--map", "map.yaml"),), strange_files.LOG),
)


class Strange:
    """A toy study that has been run."""

    def __init__(self, toy: Toy) -> None:
        self.toy, self.counts = toy, {}
        toy.says("run-all")
        self.right = toy.results()
        self.kept = toy.root.parent / f"{toy.root.name}-kept"
        shutil.copytree(toy.root, self.kept)
        self.key = toy.entry("fall").name
        (toy.root / "map.yaml").write_text(_MAP)
        (toy.root / "logs").mkdir()

    def suffer(self, place: Place, kind: str) -> None:
        """Put one strange file in its place, run the commands, take it away, and look at what is left."""
        count = self.counts.setdefault(place.name, Count())
        path = self.toy.root / place.path.replace("KEY", self.key)
        told, before = f"{place.name}, {kind}", count.problems
        disk.remove(path)
        place.makers[kind](path)
        for command in place.commands:
            code, errors = self.command(*command)
            if code not in (0, 1, 2, 3) or _NO_SENTENCE.search(errors) or (code and not _SAID.search(errors)):
                count.told.append(f"{told}: {' '.join(command)}: {code}: {errors[-1500:]}")
            if code in (1, 2) and not place.repaired and path.name not in errors and "error: stage " not in errors:
                count.told.append(f"{told}: {' '.join(command)}: the file is not named: {errors}")
            repairs = place.repaired and command[0] == "run-all"
            if repairs and code == 0 and self.toy.results() != self.right:
                count.wrong.append(f"{told}: a run that ended well left something else than the right results")
        disk.remove(path)
        if not place.repaired:
            with contextlib.suppress(FileNotFoundError):
                shutil.copyfile(self.kept / place.path, path)
        code, out, errors = self.toy.command("run-all", "--json")
        hows = {item["stage"]: item["how"] for item in json.loads(out)["stages"]} if code == 0 else {}
        count.lost += [f"{told}: {stage} computed again" for stage, how in hows.items()
                       if how == "computed" and stage != ("fall" if place.repaired else "")]  # fmt: skip
        if code or self.toy.results() != self.right:
            count.wrong.append(f"{told}: afterwards {code}: {errors}")
        count.tried += 1
        count.survived += before == count.problems

    def command(self, *words: str) -> tuple[int, str]:
        """Run `bipedstudy` with bounds on time and memory: exit code and standard error."""
        asked = self.toy
        if words[0] == _INGEST:
            inside, asked = {word: asked.root / word for word in words}, Toy(HOME, asked.package)
            words = (*(str(path) if os.path.lexists(path) else word for word, path in inside.items()),
                     "--results", str(self.toy.root / "other"))  # fmt: skip
        try:
            bounds = "from tests.pipeline import strange; strange.bounded(); "
            code, _, errors = asked.command(*words, before=bounds, timeout=_LONGEST_S)
        except subprocess.TimeoutExpired:
            return -1, f"did not end within {_LONGEST_S} s"
        return code, errors


def everything() -> Iterator[tuple[Place, str]]:
    """Each place with each file that can lie there."""
    return ((place, kind) for place in PLACES for kind in place.makers)


def bounded() -> None:
    """Bound the memory of this process, and let permissions count for the administrator as well."""
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    if sys.platform == "linux":
        system = ctypes.CDLL(None)
        whose, sets = (ctypes.c_uint32 * 2)(_CAPABILITIES_3, 0), (ctypes.c_uint32 * 6)()
        system.capget(whose, sets)
        sets[0] &= ~_MAY_READ_ALL  # those that count, of the first 32
        system.capset(whose, sets)
