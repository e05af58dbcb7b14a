"""What accuracy costs: models, levels of the study, ways to solve, and elements of a scene. Writes docs/prices.md.

    python -m benchmarks.prices            all of it: the study at each level from nothing, some ten minutes
    python -m benchmarks.prices --page     the page alone, from the results that lie in results/levels

Times are processor seconds on an otherwise idle machine. Results lie in results/levels/<level>. The ways to solve are
those that `python -m benchmarks.tradeoff` measured and kept.
"""

import argparse
import dataclasses
import json
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import bipedstudy as bs
from benchmarks.tradeoff import KEPT, fronts
from pipeline.cache import artefact
from pipeline.layout import markdown
from pipeline.parameters import yaml_text
from pipeline.parameters.value import OF_LEVELS, has_levels, shown
from stages.biped.accuracy.tolerances import LEVELS
from stages.comparison.result import Result as Comparison
from stages.extremes.parameters import Parameters
from stages.extremes.penalty_points import mid_stance
from stages.ground.blocks import Blocks
from stages.ground.friction import lanes
from stages.model_error.result import Result as ModelError
from stages.multibody.walking.walk import build, simulate
from stages.planar.run import rolling_state
from stages.planar.sampling import sample
from stages.planar.signals import GROUND_REACTION, IMU, SIGNALS
from stages.twin.machine.projection import machine_of
from stages.twin.machine.tree import SpatialTree
from stages.twin.walking.record import find_events
from stages.twin.walking.simulate import rolling_start, simulate_twin

ROOT = Path(__file__).resolve().parent.parent
PLACE, PAGE = ROOT / "results/levels", ROOT / "docs/prices.md"
COSTS = PLACE / "costs.json"
STEPS, REPEATS, BLOCK_SPACING = 2, 3, 0.1612


def run(level: str) -> dict[str, Any]:
    """The study at a level from nothing, on all cores: seconds by the clock and of all processors."""
    shutil.rmtree(PLACE / level, ignore_errors=True)
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    said = subprocess.run([sys.executable, "-m", "pipeline.cli", "run-all", "--json", "--accuracy", level, "--results",
                           str(PLACE / level)], cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout  # fmt: skip
    clock, after = time.monotonic() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    stages = {one["stage"]: one["processor_seconds"] for one in json.loads(said)["stages"]}
    return {"clock": clock, "processor": processor, "stages": stages}


def settings_rows() -> Iterator[list[str]]:
    """A row for each parameter with a value for each level."""
    for path in sorted((ROOT / "params").glob("*.yaml")):
        for key, entry in yaml_text.read(path, path.name).value.items():
            if has_levels(entry):
                about = entry.plain()
                yield [f"{path.stem}.{key}", *map(shown, about[OF_LEVELS])]


def result(level: str, stage: str, kind: type) -> Any:
    """A stage's result at a level."""
    return artefact.decode((PLACE / level / f"{stage}.h5").read_bytes(), kind, stage)


@dataclasses.dataclass(frozen=True)
class Scene:
    """What two steps in a scene took: solver steps, seconds; when its last heel strike was [s] and where [m]."""

    steps: int
    seconds: float
    strike: float
    place: float


def least(walk: Callable[[], Any]) -> tuple[Any, float]:
    """A run's result and the least of its processor times [s]."""
    times = []
    for _ in range(REPEATS):
        began = time.process_time()
        found = walk()
        times.append(time.process_time() - began)
    return found, min(times)


def planar(here: Parameters, stance: Any, force: float, blocks: bool = False, compiled: bool = True,
           signals: tuple[str, ...] = SIGNALS) -> Scene:  # fmt: skip
    """A planar scene."""
    lane = lanes(BLOCK_SPACING, Blocks().block_length) if blocks else None
    machine = build(here.biped, here.slope, here.contact, here.multibody, lane, compiled=compiled, signals=signals)
    start = rolling_state(here.biped, here.contact, stance, force)
    walked, seconds = least(lambda: simulate(here.biped, here.slope, here.contact, start, here.multibody, steps=STEPS,
                                             lanes=lane, assembly=machine))  # fmt: skip
    strike = sample(walked.trajectory, here.biped, here.slope, 100.0).heel_strike_time[STEPS - 1]
    return Scene(walked.solver_steps, seconds, float(strike), float(walked.trajectory.at(np.array([strike]))[0][0, 0]))


def spatial(here: Parameters, stance: Any, force: float) -> Scene:
    """The twin's scene."""
    machine = machine_of(here.biped, here.twin)
    tree = SpatialTree(machine, here.slope, here.contact)
    start = rolling_start(machine, here.contact, stance, force)
    record, seconds = least(
        lambda: simulate_twin(machine, here.slope, here.contact, start, here.twin, steps=STEPS, tree=tree))
    strike = float(find_events(record).heel_strike_time[STEPS - 1])
    return Scene(len(record.time) - 1, seconds, strike, float(record.at(np.array([strike]))[0][0, 0]))


def scenes() -> Iterator[list[str]]:
    """A row for each element: what it costs and changes against the scene that it is measured against."""
    base: Parameters = bs.parameters("extremes")
    base = base.changed((("multibody.tolerance", 1e-7), ("twin.tolerance", 1e-7)))
    stance, force = mid_stance(base.biped, base.slope)
    straight = dataclasses.replace(stance, stance_length=base.biped.leg_length, swing_length=base.biped.leg_length,
                                   stance_length_rate=0.0, swing_length_rate=0.0)  # fmt: skip

    def at(key: str, value: Any) -> Parameters:
        return base.changed(((key, value),))

    plain, bare = planar(base, stance, force), planar(base, stance, force, signals=())
    points = spatial(at("twin.inertia", "planar"), stance, force)
    for words, one, other in (
        ("ground reaction recorded, against motion alone", planar(base, stance, force, signals=(GROUND_REACTION,)),
         bare),
        ("foot's sensor recorded, against motion alone", planar(base, stance, force, signals=(IMU,)), bare),
        ("springs in the legs, against rigid legs", plain, planar(at("biped.legs", "rigid"), straight, force)),
        ("stepping blocks, against the ideal ground", planar(base, stance, force, blocks=True), plain),
        ("Stribeck friction, against Coulomb's", plain, planar(at("ground.friction", "coulomb"), stance, force)),
        ("restitution law, against IMPACT", planar(at("ground.normal_force", "restitution"), stance, force), plain),
        ("stiction velocity 3 mm/s, against 30", planar(at("ground.stiction_velocity", 0.003), stance, force), plain),
        ("contact ten times as stiff",
         planar(at("ground.contact_stiffness", 10 * base.contact.contact_stiffness), stance, force), plain),
        ("contact law in Python, against compiled", planar(base, stance, force, compiled=False), plain),
        ("bodies and joints, against the tree", planar(at("multibody.assembly", "joints"), stance, force), plain),
        ("space and four feet, against the plane", points, plain),
        ("inertia of the parts, against point masses", spatial(base, stance, force), points),
    ):
        yield [words, f"{one.steps / other.steps:.2f}", f"{one.seconds / other.seconds:.1f}",
               f"{1e3 * (one.strike - other.strike):+.3f}", f"{1e3 * (one.place - other.place):+.3f}"]  # fmt: skip


def loop() -> float:
    """Processor time of ten million turns of an empty loop [s]: how fast this machine is today."""
    began = time.process_time()
    for _ in range(10_000_000):
        pass
    return time.process_time() - began


def page(costs: dict[str, Any]) -> str:
    """The page."""
    learnt = result("paper", "model_error", ModelError)
    _, columns, rows = next(table for table in learnt.tables() if table[0].startswith("What solver and model"))
    claims = zip(*(result(level, "comparison", Comparison).claims for level in LEVELS), strict=True)
    stages = list(costs[LEVELS[-1]]["stages"])
    lines = [
        "# What accuracy costs", "",
        "This page helps to choose how exactly the study is computed, by time and error. For one number within an",
        "error, use `bipedstudy ask` ([asking.md](asking.md)). For the whole study, use `--accuracy draft`, `paper` or",
        "`reference`.", "",
        "Times are processor seconds on an idle computer with two cores, with compiled code in place. As a scale, ten",
        f"million turns of an empty Python loop took {loop():.2f} s there. Made by `python -m benchmarks.prices`.", "",
        "## Which model", "",
        "Largest error of each measure against the twin, from solver and model together, for the study's own design.",
        "",
        *markdown([str(each) for each in columns], [[str(each) for each in row] for row in rows]), "",
        "## Which level of the study", "",
        *markdown(["stage", *LEVELS], [
            *([stage, *(f"{costs[level]['stages'][stage]:.1f}" for level in LEVELS)] for stage in stages),
            ["all, with starting", *(f"{costs[level]['processor']:.0f}" for level in LEVELS)],
            ["by the clock, two cores", *(f"{costs[level]['clock']:.0f}" for level in LEVELS)]]), "",
        "These settings depend on the level; `params/` has the reasons. A value that you set yourself holds at every",
        "level.", "",
        *markdown(["setting", *LEVELS], list(settings_rows())), "",
        "Verdicts that depend on the level: " + (", ".join(f"`{of[0].id}`" for of in claims if len({
            claim.verdict for claim in of}) > 1) or "none") + ".", "",
        *fronts(json.loads(KEPT.read_text(encoding="utf-8"))), "",
        "## Which elements of a model", "",
        "What an element of a model costs and changes, over two steps from the same mid-stance at tolerance 1e-7.",
        "Solver steps and time are ratios; those of time are uncertain by a third. The last columns are changes of the",
        "second heel strike.", "",
        *markdown(["element", "steps", "time", "strike [ms]", "hip there [mm]"], list(scenes())),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run the levels, unless only the page is wanted, and write it."""
    words = argparse.ArgumentParser(prog="python -m benchmarks.prices")
    words.add_argument("--page", action="store_true", help="only write the page from results that are there")
    if not words.parse_args().page:
        PLACE.mkdir(parents=True, exist_ok=True)
        run(LEVELS[0])  # compiles, where that is still to do
        COSTS.write_text(json.dumps({level: run(level) for level in LEVELS}, indent=1))
    PAGE.write_text(page(json.loads(COSTS.read_text())), encoding="utf-8")


if __name__ == "__main__":
    main()
