"""Keeps what a user can see of this checkout, and compares a later one with it: the net under a rebuilding.

Run: python -m benchmarks.net keep FOLDER [PART ...] before walls move, and compare in place of keep after each that
moved. Parts: help, inputs, questions, and one for each study of `STUDIES`. `compare` ends with 1 where a name, unit,
description, word or exit code differs, or a number by more than `WITHIN` of its field's largest.
Numbers that are residuals or counts of a solver are listed by the largest difference, and stop nothing.

The commands are run as a user runs them, from this checkout's program; the bad inputs are drawn once, by `keep`.
"""

from __future__ import annotations

import argparse
import fnmatch
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import yaml

WITHIN = 1e-10
#: Residuals, differences at round-off, counts of a solver's work, times and keys: shown, not judged.
LISTED = ("*residual*", "*solver_steps*", "*evaluations*", "*strides_walked*", "*steps_walked*", "*seconds*",
          "*plane_multipliers*", "*inner_outer_difference*", "*convergence*", "*digest*")  # fmt: skip
#: Attributes of an artefact that tell how it was made.
HOW = ("key", "versions", "code", "inputs", "created", "processor", "software")
RIGID = {"biped.legs": "rigid"}
DETAILED = {"biped.hip_mass": 0.216, "biped.leg_inertia": 5e-4, "biped.frame_mass": 0.05, "biped.frame_com": 0.04,
            "biped.frame_inertia": 5e-5, "biped.foot_offset": -0.001, "ground.slope_deg": 2.5}  # fmt: skip
UNEQUAL = {"biped.other_foot_mass": 0.338, "biped.other_leg_length": 0.3331}
#: Settings and level of each study.
STUDIES = {
    "draft": ({}, "draft"), "paper": ({}, "paper"), "reference": ({}, "reference"),
    "rigid": (RIGID, "draft"), "detailed": (DETAILED, "draft"), "unequal": (UNEQUAL, "draft"),
    "rubbing": ({"biped.hip_friction": 0.002}, "draft"), "limited": ({"analytic.transition": "coulomb"}, "draft"),
}  # fmt: skip
DESIGNS = {"plain": {}, "rigid": RIGID, "detailed": DETAILED, "unequal": UNEQUAL, "rubbing": STUDIES["rubbing"][0]}
QUESTIONS = (
    "gait", "gait --all", "sensitivity", "ground-sensitivity", "basin --points 4 --steps 4",
    "continue ground.slope_deg 1.8:2.2", "design --vary biped.foot_com --iterations 3", "graph",
)  # fmt: skip
COUNT, SEED = 500, 34
WORST = ("nan", "inf", "-1e300", "1e300", "-1", "0", "abc", "''", "[1, 2]", "{a: 1}", "true", "2020-01-01")
PROGRAM = [str(Path(sys.executable).with_name("bipedstudy"))]
Seen = dict[str, object]


def ran(*words: str, cwd: Path | None = None) -> dict[str, object]:
    """What a command printed, and how it ended; paths and times made plain."""
    environment = dict(os.environ, COLUMNS="100", NO_COLOR="1")
    found = subprocess.run([*PROGRAM, *words], capture_output=True, text=True, env=environment, check=False, cwd=cwd)
    changing = rf"{re.escape(tempfile.gettempdir())}\S+|[0-9.]+ m?s\b"
    both = [re.sub(changing, "...", text) for text in (found.stdout, found.stderr)]
    return {"code": found.returncode, "out": both[0], "err": both[1]}


def commands() -> list[str]:
    """Names of all commands, from the program's own help."""
    return re.findall(r"^  ([a-z][a-z-]+)  ", str(ran("--help")["out"]), re.MULTILINE)


def of_help() -> Seen:
    """--help of the program and of each command, and the generated reference."""
    return {name or "bipedstudy": ran(*name.split(), "--help")["out"] for name in ["", *commands()]} | {
        "reference": Path("docs/reference.md").read_text(encoding="utf-8")
    }


def drawn() -> list[list[str]]:
    """Bad inputs: keys of all parameter files and options of all commands, with values that fit none or few."""
    keys = [f"{path.stem}.{key}" for path in sorted(Path("params").glob("*.yaml"))
            for key in yaml.safe_load(path.read_text(encoding="utf-8"))]  # fmt: skip
    writing = ("init", "run-all", "run", "sweep", "report", "figures", "clean")
    options = [(name, option) for name in commands() if name not in writing for option in
               re.findall(r"^ {2,}(--[a-z-]+) [A-Z]", str(ran(name, "--help")["out"]), re.MULTILINE)
               if option not in ("--set", "--cluster", "--into", "--out", "--store", "--export")]  # fmt: skip
    draw, found = random.Random(SEED), []
    for number in range(COUNT):
        value = draw.choice(WORST)
        if number % 5 == 4:
            name, option = draw.choice(options)
            found.append([name, option, value])
        else:
            key = draw.choice(keys)
            key = key if draw.random() < 0.9 else key[:-1] + draw.choice("xyz")
            found.append(["run", "--dry-run", "figures", "--set", f"{key}={value}"])
    return found


def of_inputs(inputs: list[list[str]]) -> Seen:
    """Sentence and exit code of each bad input."""
    return {" ".join(words): ran(*words) for words in inputs}


def of_questions() -> Seen:
    """The JSON of every question to each of `DESIGNS`."""
    found: Seen = {}
    for name, settings in DESIGNS.items():
        changes = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
        for question in QUESTIONS:
            words = question.split()
            said = ran(*words, *(changes if words[0] != "graph" else []), "--json")
            try:
                answer = json.loads(str(said["out"]))
            except ValueError:
                answer = said["out"]
            found[f"{name}: {question}"] = {"code": said["code"], "err": said["err"], "out": answer}
    return found


def of_study(name: str) -> Seen:
    """Every field of every artefact of a study with unit and description, its claims, and how it ended."""
    settings, level = STUDIES[name]
    changes = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
    with tempfile.TemporaryDirectory() as folder:
        ended = ran("run-all", "--accuracy", level, *changes, "--results", folder)
        found: Seen = {"ended": ended["code"]}
        for path in sorted(Path(folder).glob("*.h5")):
            found |= dict(fields(path))
        claims = ran("claims", "--json", "--accuracy", level, *changes, "--results", folder)
        if claims["code"] == 2:
            claims = ran("claims", "--json", *changes, "--results", folder)
        found["claims"] = claims["out"]
    return found


def fields(path: Path) -> Iterator[tuple[str, object]]:
    """Values, units and descriptions of an artefact, by stage and path."""
    found: list[tuple[str, object]] = []

    def take(name: str, item: h5py.HLObject) -> None:
        full = f"{path.stem}/{name}"
        if isinstance(item, h5py.Dataset) and item.shape is not None:
            value = item[()]
            text = item.dtype.kind in "OSU"
            found.append((full, as_text(value) if text else np.asarray(value).tolist()))
        found.extend((f"{full}@{key}", str(value)) for key, value in item.attrs.items()
                     if key not in HOW and not key.isupper() and "error" not in key)  # fmt: skip

    with h5py.File(path) as file:
        file.visititems(take)
    yield from found


def as_text(value: object) -> object:
    """Strings of a dataset of any shape."""
    if isinstance(value, bytes):
        return value.decode()
    return [as_text(one) for one in value] if isinstance(value, np.ndarray) else str(value)


def differences(name: str, was: object, now: object) -> Iterator[tuple[str, float]]:
    """Each place that differs: by how much of the field's largest number, or infinitely for all that is no number."""
    if isinstance(was, dict) and isinstance(now, dict):
        for key in sorted({*was, *now}):
            if key in was and key in now:
                yield from differences(f"{name}/{key}", was[key], now[key])
            else:
                yield f"{name}/{key}: {'gone' if key in was else 'new'}", math.inf
        return
    try:
        first, second = np.asarray(was, dtype=float), np.asarray(now, dtype=float)
        same = first.shape == second.shape and np.array_equal(np.isfinite(first), np.isfinite(second))
    except (TypeError, ValueError):
        if isinstance(was, list) and isinstance(now, list) and len(was) == len(now):
            for index, (left, right) in enumerate(zip(was, now, strict=True)):
                yield from differences(f"{name}/{index}", left, right)
        elif was != now:
            yield f"{name}: {str(was)[:150]!r} -> {str(now)[:150]!r}", math.inf
        return
    if not same:
        yield f"{name}: another shape", math.inf
    elif first.size:
        finite = np.isfinite(first)
        apart = float(np.abs(first[finite] - second[finite]).max(initial=0.0))
        if apart:
            yield name, apart / (float(np.abs(first[finite]).max(initial=0.0)) or 1.0)


def compared(part: str, was: Seen, now: Seen) -> bool:
    """Print what differs; True if nothing that is judged does."""
    found = list(differences(part, was, now))
    judged = [(name, far) for name, far in found if not any(fnmatch.fnmatch(name, one) for one in LISTED)]
    bad = sorted(((name, far) for name, far in judged if far > WITHIN), key=lambda one: -one[1])
    listed = max((far for name, far in found if (name, far) not in judged), default=0.0)
    most = max((far for _, far in judged if far <= WITHIN), default=0.0)
    print(f"{part}: {len(was)} entries, {len(bad)} differ; others by at most {most:.1e}, listed ones by {listed:.1e}")
    for name, far in bad[:40]:
        print(f"  {far:.1e}  {name}")
    return not bad


def main() -> int:
    """Keep or compare; 1 where something differs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("what", choices=["keep", "compare"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("parts", nargs="*", default=["help", "inputs", "questions", *STUDIES])
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    list_of_inputs = given.folder / "inputs.list.json"
    if not list_of_inputs.exists():
        list_of_inputs.write_text(json.dumps(drawn()), encoding="utf-8")
    alike = True
    for part in given.parts:
        inputs = json.loads(list_of_inputs.read_text(encoding="utf-8"))
        seen = {"help": of_help, "inputs": lambda now=inputs: of_inputs(now), "questions": of_questions}.get(
            part, lambda name=part: of_study(name)
        )()
        kept = given.folder / f"{part}.json"
        if given.what == "keep":
            kept.write_text(json.dumps(seen, indent=0), encoding="utf-8")
            print(f"{part}: {len(seen)} entries kept", flush=True)
        else:
            alike &= compared(part, json.loads(kept.read_text(encoding="utf-8")), json.loads(json.dumps(seen)))
    return 0 if alike else 1


if __name__ == "__main__":
    sys.exit(main())
