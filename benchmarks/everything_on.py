"""The study with its default scenes against the same with everything on: time, changes in claims and figures.

Everything on: stepping blocks under every foot, all signals, rates five times as high. Computed anew are the stages
that walk in a scene of the parameter files; those that build scenes of their own are read from the results folder.
Time: processor time, loading and children included. Run after `bipedstudy run-all`:

    python -m benchmarks.everything_on [--results DIR] [--into docs/scenes.md]
"""

from __future__ import annotations

import argparse
import importlib
import multiprocessing
import os
import re
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.cache import artefact
from pipeline.study import Study
from stages.planar.signals import SIGNALS as PLANAR_SIGNALS
from stages.twin.parameters import SIGNALS as SPATIAL_SIGNALS

ROOT = Path(__file__).resolve().parent.parent
MARK = "<!-- default scenes -->"
WALKING, READ = ("multibody", "twin", "campaign", "imu", "comparison", "figures"), (
    "analytic", "contact_study", "error_budget", "twin_ladder", "twin_pushes", "tradeoff", "extremes")  # fmt: skip
#: The ramp is made long enough for the twin's 14 steps.
EVERYTHING = (
    "multibody.scene=blocks", f"multibody.signals=[{', '.join(PLANAR_SIGNALS)}]", "multibody.sampling_rate_hz=10000",
    "twin.scene=ramp", "twin.ramp_length=3", "twin.block_sets=15", f"twin.signals=[{', '.join(SPATIAL_SIGNALS)}]",
    "twin.sampling_rate_hz=5000", "campaign.motion_rate_hz=25000",
)  # fmt: skip
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
PLANE, SPACE = "the plane, ideal ground, motion", "space, plane ground, motion"
#: Figure -> (scenes beside the constraint model, model whose walk it draws, signals of `Walk` that it draws).
FIGURES = {
    "figure 2": (f"{PLANE} and ground_reaction", "multibody", ("ground_reaction",)),
    "figure 7": (PLANE, "multibody", ("hip_position", "leg_angle")),
    "figure 8": (PLANE, "multibody", ("hip_position", "hip_velocity")),
    "figure 10": (f"{SPACE} and the poses", "twin", ("leg_angle", "leg_rate")),
    "figure 16, simple model": (f"{PLANE} and imu", "multibody", ("hip_specific_force", "hip_angular_velocity")),
    "figure 16, twin": (f"{SPACE} and imu; 30 more with imu_in_space", "twin",
                        ("hip_specific_force", "hip_angular_velocity")),
    "animation": (f"{PLANE} and ground_reaction; {SPACE} and ground_reaction", "twin",
                  ("hip_position", "ground_reaction")),
}  # fmt: skip
UNITS = {"hip_position": "m", "leg_angle": "rad", "leg_rate": "rad/s", "hip_velocity": "m/s", "ground_reaction": "N",
         "hip_specific_force": "m/s^2", "hip_angular_velocity": "rad/s"}  # fmt: skip


@dataclass(frozen=True)
class Made:
    """Results and processor times [s] of the walking stages, by name."""

    results: dict[str, Any]
    seconds: dict[str, float]


def timed(call: Callable[[], Any]) -> tuple[Any, float]:
    """A result and its processor time, that of finished children included [s]."""
    before = os.times()
    result = call()
    return result, sum(os.times()[:4]) - sum(before[:4])


def made(results: Path, settings: tuple[str, ...], folder: Path) -> Made:
    """The walking stages with these settings, in a scene each; the database goes to `folder`."""
    study = Study(ROOT, ROOT / "params", results, settings)
    values = study.parameters(WALKING)
    found: dict[str, Any] = {}
    for name in READ:
        cls = importlib.import_module(f"stages.{name}.result").Result
        path = results / f"{name}.h5"
        found[name] = artefact.decode(path.read_bytes(), cls, str(path))
    seconds = {}
    for name in WALKING:
        stage = importlib.import_module(f"stages.{name}.run")
        read = {field.name: found[field.name] for field in fields(stage.Inputs) if field.name in found}
        inputs = stage.Inputs(**read)
        found[name], seconds[name] = timed(lambda run=stage.run, name=name, given=inputs: run(values[name], given))
        if name == "campaign":
            path = folder / "measurements.sqlite"
            path.write_bytes(found[name].files[path.name])
            found["measurements"] = path
    return Made(found, seconds)


def anew(results: Path, settings: tuple[str, ...], folder: Path) -> Made:
    """`made` in a fresh process, so that no scene finds what another has loaded."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
        return process.submit(made, results, settings, folder).result()


def largest_change(one: str, other: str) -> float:
    """Largest relative change of the numbers in two texts; infinite if their words differ."""
    if NUMBER.sub("#", one) != NUMBER.sub("#", other):
        return float("inf")
    pairs = [(float(a), float(b)) for a, b in zip(NUMBER.findall(one), NUMBER.findall(other))]
    return max((abs(b - a) / abs(a) if a else float(b != a) for a, b in pairs), default=0.0)


def signal_change(one: Any, other: Any, name: str) -> tuple[float, float]:
    """Largest and median difference of a signal of two walks at the times both have sampled."""
    times = (np.round(walk.time, 9) for walk in (one, other))
    _, first, second = np.intersect1d(*times, return_indices=True)
    gap = np.abs(getattr(one, name)[first] - getattr(other, name)[second])
    return float(gap.max()), float(np.median(gap))


def sampled(made: Made, name: str) -> int:
    """Bytes of the signals that a scene's artefact holds."""
    return int(made.results[name].inventory.sampled_bytes)


def report(default: Made, full: Made) -> str:
    """The tables as Markdown."""
    lines = [
        MARK, "", "# Default scenes against everything on", "",
        "Made by `benchmarks/everything_on.py`. Everything on: stepping blocks under every foot, all signals, rates",
        f"five times as high. Measured on {date.today()}: processor time, with loading, each in a fresh process.",
        "Stages with scenes of their own are not in it.",
        "", "| stage | default | everything on | |", "| --- | --- | --- | --- |"]  # fmt: skip
    rows = [*WALKING, "sum"]
    for name in rows:
        a, b = (sum(m.seconds.values()) if name == "sum" else m.seconds[name] for m in (default, full))
        lines.append(f"| {name} | {a:.1f} s | {b:.1f} s | {b / a:.2f} times |")
    for name in ("multibody", "twin"):
        a, b = sampled(default, name), sampled(full, name)
        lines.append(f"| {name}, signals in the artefact | {a / 1e6:.2f} MB | {b / 1e6:.2f} MB | {b / a:.1f} times |")
    claims = [made.results["comparison"].claims for made in (default, full)]
    changed = [(a, b, largest_change(a.measured, b.measured)) for a, b in zip(*claims) if a.measured != b.measured]
    turned = [a.id for a, b in zip(*claims) if a.verdict != b.verdict]
    lines += ["", f"Verdicts that change: {', '.join(turned) or 'none'} of {len(claims[0])}. "
                  f"Claims whose printed numbers change: {len(changed)}.", ""]  # fmt: skip
    if changed:
        lines += ["| claim | default | everything on | largest relative change of a number |", "|" + " --- |" * 4]
        lines += [f"| {a.id} | {a.measured} | {b.measured} | {size:.1e} |" for a, b, size in changed]
    lines += ["", "The smallest scene of each figure, and by how much everything on changes what it draws, at common",
              "times: largest, median. The other figures draw studies with scenes of their own.", "",
              "| figure | smallest scene | change |", "| --- | --- | --- |"]  # fmt: skip
    for figure, (scene, model, names) in FIGURES.items():
        walks = (made.results[model].walk for made in (default, full))
        one, other = walks
        said = [(name, *signal_change(one, other, name)) for name in names]
        shown = "; ".join(f"{name} {most:.1e}, {half:.1e} {UNITS[name]}" for name, most, half in said)
        lines.append(f"| {figure} | {scene} | {shown} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure and print, or put the tables at the end of a page."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--results", type=Path, default=ROOT / "results")
    options.add_argument("--into", type=Path)
    given = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        default, full = (anew(given.results, settings, Path(folder)) for settings in ((), EVERYTHING))
    text = report(default, full)
    if given.into is None:
        print(text)
    else:
        given.into.write_text(given.into.read_text(encoding="utf-8").partition(MARK)[0] + text, encoding="utf-8")


if __name__ == "__main__":
    main()
