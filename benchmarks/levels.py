"""What each accuracy of the whole study costs and changes: time by stage, and every claim's numbers and verdict.

    python -m benchmarks.levels            runs the study at each level from nothing; writes what it keeps, and the page
    python -m benchmarks.levels draft      measures one level anew, against the kept results of `reference`
    python -m benchmarks.levels --errors   brings all levels up to date instead, and keeps the times that were measured
    python -m benchmarks.levels --beside DIR ...  as well, an earlier version, installed in DIR/.venv, for the ratio

Results lie in results/levels/<level>. Errors are differences from the level `reference`; those of `reference` itself
are differences of its three walks from walks at settings that are tighter again. They are kept
in stages/tradeoff/accuracy/levels.json: twice the errors of the walks, which --accuracy reads.
"""

from __future__ import annotations

import argparse
import json
import math
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline.cache import artefact
from pipeline.layout import markdown
from pipeline.parameters import levels, yaml_text
from pipeline.parameters.value import shown
from stages.analytic.result import Result as Analytic
from stages.biped.accuracy.estimate import walk_differences
from stages.biped.accuracy.tolerances import DRAFT, LEVELS, PAPER, REFERENCE, Accuracy
from stages.comparison.claims.verdict import UNDECIDED
from stages.comparison.evidence import largest
from stages.comparison.result import Claim
from stages.comparison.result import Result as Comparison
from stages.multibody.result import Result as Multibody
from stages.tradeoff.accuracy.choice import LEVEL_ERRORS as OF_WALKS
from stages.twin.result import Result as Twin

ROOT = Path(__file__).resolve().parent.parent
PLACE, PAGE = ROOT / "results/levels", ROOT / "docs/levels.md"
COSTS = PLACE / "costs.json"
#: The stages whose walks are shown, and settings tighter than those of the reference.
WALKED: dict[str, Any] = {"analytic": Analytic, "multibody": Multibody, "twin": Twin}
TIGHTER = ("analytic.tolerance=1e-13", "multibody.tolerance=1e-11", "twin.tolerance=1e-9")


def command(*words: str, root: Path = ROOT, python: str = sys.executable) -> dict[str, Any]:
    """What `bipedstudy` says in JSON."""
    asked = [python, "-m", "pipeline.cli", *words, "--json"]
    found: dict[str, Any] = json.loads(subprocess.run(asked, cwd=root, check=True, stdout=subprocess.PIPE).stdout)
    return found


def timed(folder: Path, *words: str, **where: Any) -> tuple[Any, float, float]:
    """What `run-all` says of a run from nothing into a folder; seconds by the clock and of all processors."""
    shutil.rmtree(folder, ignore_errors=True)
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    found = command("run-all", "--results", str(folder), *words, **where)
    clock, after = time.monotonic() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    return found, clock, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def run(level: str) -> dict[str, Any]:
    """The study at a level from nothing, on all cores and then one stage at a time: times [s]."""
    asked = PLACE / level, "--accuracy", level
    _, clock, _ = timed(*asked)
    found, _, processor = timed(*asked, "--jobs", "1")
    stages = {one["stage"]: one["processor_seconds"] for one in found["stages"]}
    return {"clock": clock, "processor": processor, "stages": stages}


def earlier(checkout: Path) -> dict[str, Any]:
    """Version, number of stages and times [s] of an earlier version's study: its draft, and what it does unasked."""
    python = str(checkout.absolute() / ".venv/bin/python")
    asked = [python, "-c", "from importlib.metadata import version; print(version('bipedstudy'))"]
    costs: dict[str, Any] = {
        "version": subprocess.run(asked, cwd=checkout, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()
    }
    command("gait", root=checkout, python=python)
    for level, words in ((DRAFT, ("--accuracy", DRAFT)), (PAPER, ())):
        found, clock, processor = timed(PLACE / "earlier", *words, root=checkout, python=python)
        costs |= {"stages": len(found["stages"]), level: {"clock": clock, "processor": processor}}
    return costs


def result(level: str, stage: str, cls: Any) -> Any:
    """A stage's result at a level."""
    return artefact.load(PLACE / level / f"{stage}.h5", cls)


def walk_errors(level: str, reference: str) -> dict[str, float]:
    """Largest differences of the walks shown from those at `reference`, by the keys of an accuracy."""
    worst = dict.fromkeys(vars(Accuracy()), 0.0)
    for stage, cls in WALKED.items():
        one, other = (result(place, stage, cls) for place in (level, reference))
        found = walk_differences(one.walk, other.walk)
        leading = [largest_multiplier(each) for each in (one, other)]
        found["multiplier"] = abs(leading[0] - leading[1])
        worst |= {key: max(worst[key], value) for key, value in found.items() if math.isfinite(value)}
    return worst


def largest_multiplier(found: Any) -> float:
    """The leading multiplier's magnitude; NaN where a stage has none."""
    if isinstance(found, Analytic):
        return largest(found.gait.floquet_multipliers)
    return float(found.cycle.largest_multiplier) if isinstance(found, Multibody) else math.nan


def pairs(level: str) -> Iterator[tuple[Claim, Claim]]:
    """Each claim at a level and at the reference."""
    found = (result(place, "comparison", Comparison).claims for place in (level, REFERENCE))
    return zip(*found, strict=True)


def page(costs: Mapping[str, Any], walks: Mapping[str, Mapping[str, float]]) -> str:
    """The tables."""
    stages = list(costs[REFERENCE]["stages"])
    lines = [
        "# The study at three prices", "", "Generated by `python -m benchmarks.levels`; `--accuracy LEVEL` or "
        "`params/accuracy.yaml` choose the level.", "",
        "## What it costs", "",
        "Processor seconds from nothing, with compiled code present, one stage at a time on an otherwise idle machine; "
        "in the sum is what no stage does, above all loading packages. Then seconds by the clock on two cores. Of an "
        "earlier version: what its study takes, and how many times as long that is.", "",
        *markdown(["stage", *LEVELS], [
            *([stage, *(f"{costs[level]['stages'][stage]:.1f}" for level in LEVELS)] for stage in stages),
            ["all, processor time", *(f"{costs[level]['processor']:.0f}" for level in LEVELS)],
            ["all, by the clock on all cores", *(f"{costs[level]['clock']:.0f}" for level in LEVELS)],
            *earlier_rows(costs)]),
        "", "## Which settings it decides", "",
        "A value that is set by hand holds at every level. Other settings follow these: a key that is `null` in "
        "`params/` says beside it what it follows, and moves with what is decided here, set by hand or asked for.", "",
        *markdown(["setting", *LEVELS, "why"], list(settings_rows())),
        "", "## What it changes: the walks shown", "",
        "Largest difference from the reference (its own: from tighter settings) over the walks of constraint model, "
        "planar penalty model and twin.", "",
        *markdown(["error", *LEVELS], [[key, *(f"{walks[level][key]:.1g}" for level in LEVELS)]
                                    for key in vars(Accuracy())]),
        "", "## What it changes: the claims", "",
        "For each claim the number that differs most from the reference, in parts of itself, and the verdict. A "
        "verdict that its numerical errors could change is *not decided at this accuracy*.", "",
        *markdown(["claim", "number", "reference", *(f"{level}, difference" for level in LEVELS[:-1]),
                *(f"{level}, verdict" for level in LEVELS)], list(claim_rows())),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def settings_rows() -> Iterator[list[str]]:
    """A row for each parameter with a value for each level."""
    for path in sorted((ROOT / "params").glob("*.yaml")):
        for key, entry in yaml_text.read(path, path.name).value.items():
            if levels.has(entry):
                about = entry.plain()
                yield [f"{path.stem}.{key}", *map(shown, about[levels.PART]), about["source"]]


def earlier_rows(costs: Mapping[str, Any]) -> Iterator[list[str]]:
    """Rows on an earlier version, if one was measured beside this one."""
    if "earlier" in costs:
        old = costs["earlier"]
        name = f"version {old['version']} in the same run ({old['stages']} stages)"
        for key, what in (("processor", "processor time"), ("clock", "by the clock on all cores")):
            pairs = ((old[level][key], costs[level][key]) for level in (DRAFT, PAPER))
            yield [f"{name}, {what}", *(f"{then:.0f}, {then / now:.1f} times" for then, now in pairs), "-"]


def rounded(costs: Mapping[str, Any]) -> dict[str, Any]:
    """Times [s] as they are kept, those of an earlier version as well, if there are some."""
    kept: dict[str, Any] = {level: {name: {stage: round(each, 1) for stage, each in value.items()} if name == "stages"
                                    else round(value, 1) for name, value in costs[level].items()}
                            for level in LEVELS}  # fmt: skip
    return {**kept, **{name: value for name, value in costs.items() if name not in kept}}


def verdicts() -> dict[str, dict[str, int]]:
    """Of each level how many verdicts are not decided at its accuracy, and how many others are not the reference's."""
    counts = {}
    for level in LEVELS:
        found = [(here.verdict, there.verdict) for here, there in pairs(level)]
        left = sum(here == UNDECIDED != there for here, there in found)
        counts[level] = {"not_decided": left, "other": sum(here != there for here, there in found) - left}
    return counts


def claim_rows() -> Iterator[list[str]]:
    """A row for each claim."""
    claims = {level: result(level, "comparison", Comparison).claims for level in LEVELS}
    for of in zip(*(claims[level] for level in LEVELS), strict=True):
        values = [{number.name: number.value for number in claim.numbers} for claim in of]
        exact = values[-1]
        parts = {name: max(abs(each.get(name, math.nan) - value) for each in values[:-1]) / abs(value)
                 for name, value in exact.items() if math.isfinite(value) and value}  # fmt: skip
        parts = {name: part for name, part in parts.items() if math.isfinite(part)}
        name = max(parts, key=lambda name: parts[name], default="")
        numbers = [f"{exact[name]:.6g}", *(f"{each[name] - exact[name]:+.1e}" for each in values[:-1])] if name else [
            "-"] * len(LEVELS)  # fmt: skip
        yield [of[0].id, name, *numbers, *(claim.verdict for claim in of)]


def main() -> None:
    """Run the levels named (default: all), then keep the errors and write the page."""
    words = argparse.ArgumentParser(prog="python -m benchmarks.levels")
    words.add_argument("levels", nargs="*", metavar="LEVEL", help=f"{', '.join(LEVELS)}; default: all")
    words.add_argument("--errors", action="store_true", help="measure errors alone, and no times")
    words.add_argument("--beside", type=Path, metavar="DIR", help="checkout of an earlier version")
    asked = words.parse_args()
    named = asked.levels or list(reversed(LEVELS))
    costs = json.loads(COSTS.read_text()) if COSTS.exists() else json.loads(OF_WALKS.read_text())["costs"]
    command("gait")  # compiles, where that is still to do
    if asked.beside:
        costs["earlier"] = earlier(asked.beside)
        print("earlier", json.dumps(costs["earlier"]), flush=True)
    for level in named:
        if asked.errors:
            command("run-all", "--results", str(PLACE / level), "--accuracy", level)
            continue
        costs[level] = run(level)
        COSTS.write_text(json.dumps(costs, indent=1))
        print(level, json.dumps(costs[level]), flush=True)
    if REFERENCE in named:
        shutil.rmtree(PLACE / "tighter", ignore_errors=True)
        settings = [word for setting in TIGHTER for word in ("--set", setting)]
        command("run", *WALKED, "--accuracy", REFERENCE, "--results", str(PLACE / "tighter"), *settings)
    walks = {level: walk_errors(level, REFERENCE) for level in LEVELS[:-1]}
    walks[REFERENCE] = walk_errors(REFERENCE, "tighter")
    for coarse, fine in ((1, 2), (0, 1)):  # no level promises more than the next one
        walks[LEVELS[coarse]] = {
            key: max(value, walks[LEVELS[fine]][key]) for key, value in walks[LEVELS[coarse]].items()}
    kept = {level: {key: float(f"{2 * value:.1e}") for key, value in of.items()} for level, of in walks.items()}
    about = {"made": "benchmarks/levels.py", "errors": kept, "costs": rounded(costs), "verdicts": verdicts()}
    OF_WALKS.write_text(json.dumps(about, indent=1) + "\n")
    PAGE.write_text(page(costs, walks), encoding="utf-8")


if __name__ == "__main__":
    main()
