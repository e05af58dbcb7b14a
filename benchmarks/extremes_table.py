"""Keeps the map of extremes: docs/extremes.csv, .md, .png and the table of `stages.extremes.envelope`.

    bipedstudy run extremes --set extremes.resolution=full --set extremes.processes=2
    python -m benchmarks.extremes_table                     keeps what that run left in results/extremes.h5
    python -m benchmarks.extremes_table "gait, detailed"    computes one engine's points anew and keeps the others

"""

import argparse
import csv
import datetime
import json
import math
import platform
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from pipeline.cache.artefact import decode
from pipeline.parameters import loading
from stages.drawing import style
from stages.extremes import warnings as warned
from stages.extremes.parameters import (
    COMPILED,
    COULOMB,
    CRASHED,
    DETAILED,
    ENGINES,
    GAIT,
    HUNG,
    JOINTS,
    REFUSED,
    TOGETHER,
    TREE,
    TWIN,
    USUAL,
    WRONG,
    Parameters,
)
from stages.extremes.points import points
from stages.extremes.result import Finding, Result
from stages.extremes.run import as_result, compile_once, evaluate, in_words
from stages.extremes.warnings import REACH, place_of
from stages.extremes.watchdog import compute
from stages.figures.drawn import work_and_extremes
from stages.studies.result import Table

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
PACKAGES = ("numpy", "scipy", "numba", "exudyn")
#: Engines of a stage of the study: the settings they are run with.
OF_A_STAGE: dict[str, Callable[[Parameters], Any]] = {
    GAIT: lambda here: here.analytic, COULOMB: lambda here: here.analytic, TREE: lambda here: here.multibody,
    COMPILED: lambda here: here.multibody,
    JOINTS: lambda here: here.multibody, TWIN: lambda here: here.twin,
}  # fmt: skip
COLUMNS = ("engine", "axis", "value", "changes", "status", "error", "audit", "reference", "reason")

EXPLANATION = """# Where each model is right

This page says for which parameters each model was compared with an independent reference, and how it came out. You need
it when your robot is far from the paper's, or when a command warns of its parameters.

Of {points} points in all models: {summary}. {defects}

`bipedstudy run`, `run-all` and `gait` warn where the nearest point of this map is not right. They also warn where it is
further than a factor {reach:.2g} away in the dimensionless numbers of design and contact, or its square in those of the
solver.

![Map of the extremes](extremes.png)

## What the words mean

- *right*: within 1e-4 of the reference, in leg lengths and pendulum times.
- *inaccurate*: further off, but within the requested tolerance, or shown by the model's own energy audit.
- *refused*: the check of parameters or the search for gaits says no, with a reason. This is no proof that no gait
  exists.
- *failed*: the run ended early with a reason: a fall, a standstill, the limit on solver steps.
- *unconfirmed*: the reference run ended early, or is less exact than the answer and differs.
- *wrong*: the reference contradicts an answer that shows no sign of it.

## What each model was compared with

- **Gaits and steps**: SciPy's DOP853 or Radau on the equations as they are derived. With Coulomb feet, and where legs
  oscillate fast and long, a second run at tolerance 1e-12 together with the energy audit. Where round-off allows no
  tighter tolerance, the second run is ten times looser, and the difference is an upper bound.
- **Detailed designs** (frames, unequal legs, hip springs, friction): the same for the two steps of a stride, and the
  gait of the same robot with its legs exchanged. With friction at the hip: the second run.
- **Penalty model**, compiled, or by Exudyn with joints: Exudyn's minimal coordinates ("tree") at 1e-9.
- **Tree and twin**: a second run at a hundredth of the tolerance, together with the energy balance.
- **Rigid limit**: the constraint model with Coulomb feet.
- **Derivatives** of the period by slope, foot mass and leg length: extrapolated differences.
- **Error estimate** of the hip over three steps: the true error, within a factor of 2.

In *all together*, all parameters are random at once: every other point within a factor 2 of the study's values, the
others over the whole range. All points are in `extremes.csv`. Measured on {measured}, by
`benchmarks/extremes_table.py`.

The study's own parameters are listed only where a model is not right there. *Refused* without a reason: no periodic
gait was found.
"""


def markdown(table: Table) -> str:
    """A table of a result as Markdown."""
    title, columns, rows = table
    lines = [f"\n## {title}\n", "| " + " | ".join(columns) + " |", "|" + " --- |" * len(columns)]
    return "\n".join(lines + ["| " + " | ".join(cell.replace("|", "/") for cell in row) + " |" for row in rows]) + "\n"


def full_map() -> Parameters:
    """The study's parameters, with the full map asked for."""
    usual = loading.load(ROOT / "params", ["extremes.resolution=full"], {"extremes": Parameters}, [Parameters])
    found: Parameters = usual["extremes"]
    return found


def renewed(engine: str) -> Result:
    """The kept map with one engine's points computed anew. Raises SystemExit if a kept point is no longer asked for."""
    parameters, kept = full_map(), {}
    with open(DOCS / "extremes.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            error, audit = (float(row[name] or math.nan) for name in ("error", "audit"))
            found = Finding(row["status"], error, audit, row["reference"], row["reason"])
            kept[row["engine"], row["axis"], row["value"], row["changes"]] = found
    asked = points(parameters)
    anew = [point for point in asked if point.engine == engine]
    compile_once(parameters, ENGINES)
    computed = iter(compute(evaluate, parameters, anew, processes=parameters.settings.processes,
                            longest_s=parameters.settings.longest_s))
    findings = []
    for point in asked:
        name = point.engine, point.axis, f"{point.value:g}", in_words(point)
        if point.engine != engine and name not in kept:
            raise SystemExit(f"the kept map has no point {name}: run the whole map anew")
        findings.append(next(computed) if point.engine == engine else kept[name])
    return as_result("full", asked, findings)


def envelope(result: Result, when: str) -> dict[str, Any]:
    """The table that warnings read: every engine's points, but for those that the check of parameters refuses."""
    own = full_map()
    penalty = [(f"{file}.tolerance", own.settings.penalty_tolerance) for file in ("multibody", "twin")]
    engines: dict[str, list[dict[str, Any]]] = {}
    for point, words, row in zip(points(own), result.changes, result.rows(), strict=True):
        if words != in_words(point):
            raise SystemExit(f"the map was computed with other points: {words} is now {in_words(point)}")
        _, axis, value, status, error, _, _, reason = row
        if point.engine not in OF_A_STAGE or (status == REFUSED and "is not allowed" in reason):
            continue
        here = own.changed((*penalty, *point.changes))
        place = place_of(point.engine, here.biped, here.slope, here.contact, OF_A_STAGE[point.engine](here))
        groups = engines.setdefault(point.engine, [])
        group: dict[str, Any] = {"choices": place.choices, "numbers": list(place.numbers), "points": []}
        same = [each for each in groups if each["choices"] == place.choices]
        if not same:
            groups.append(group)
        numbers = [round(number, 4) for number in place.numbers.values()]
        known = float(f"{error:.3g}") if error == error else None
        what = {TOGETHER: f"draw {value:g} of all parameters", USUAL: "the study's own parameters"}
        said = [what.get(axis, f"{axis} {value:g}"), status, known, reason.partition(" (")[0][:140]]
        (same or [group])[0]["points"].append([*said, numbers])
    return {"measured": when, "engines": engines}


def measured() -> str:
    """Date and versions."""
    versions = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    return f"{datetime.date.today()} with Python {platform.python_version()}, {versions}"


def main(engine: str | None) -> None:
    """Write the four files. A map that is not full is not kept."""
    if engine is None:
        path, when = ROOT / "results/extremes.h5", measured()
        result = decode(path.read_bytes(), Result, path.name)
        if result.resolution != "full":
            raise SystemExit(f"{path} holds the {result.resolution} map; the full one is kept")
    else:
        before = warned.table()["measured"].partition(f"; {engine}: ")[0]
        result, when = renewed(engine), f"{before}; {engine}: {measured()}"
    with open(DOCS / "extremes.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row, changes in zip(result.rows(), result.changes, strict=True):
            engine, axis, value, status, error, audit, reference, reason = row
            numbers = [f"{number:.3g}" if number == number else "" for number in (error, audit)]
            writer.writerow([engine, axis, f"{value:g}", changes, status, *numbers, reference, reason[:160]])
    lines = json.dumps(envelope(result, when), allow_nan=False).replace('["', '\n["')
    warned.TABLE.write_text(lines + "\n", encoding="utf-8")
    defects = [row for row in result.rows() if row[3] in (WRONG, CRASHED, HUNG)]
    words = EXPLANATION.format(
        points=len(result.status), summary=result.summary().partition(": ")[2], measured=when, reach=10**REACH,
        defects="Those that are wrong without a sign, crashed, or did not end are listed last." if defects else
                "No point was wrong without a sign, crashed, or did not end.",
    )  # fmt: skip
    listed = ("Defects", ["engine", "axis", "value", "status", "error", "reason"],
              [[r[0], r[1], f"{r[2]:g}", r[3], f"{r[4]:.1e}", r[7]] for r in defects])  # fmt: skip
    counts, (_, columns, rows) = result.tables()
    own = [row for row in rows if row[1] == USUAL and row[3].startswith("1 of 1")]
    parts = [(f"Ranges: {name}", columns[1:], [[cell.replace(": no periodic gait", "") for cell in row[1:]]
                                               for row in rows if row[0] == name and row not in own])
             for name in (GAIT, COULOMB, DETAILED, COMPILED, TREE, TWIN)]  # fmt: skip
    tables = [counts, *parts, *([listed] if defects else [])]
    (DOCS / "extremes.md").write_text(words + "".join(markdown(table) for table in tables), encoding="utf-8")
    with style.drawing():
        pictures = style.pictures("extremes", work_and_extremes.draw_extremes(SimpleNamespace(extremes=result)), 150)
    (DOCS / "extremes.png").write_bytes(pictures["figures/extremes.png"])


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("engine", nargs="?", choices=ENGINES, help="the engine whose points alone are computed anew")
    main(parser.parse_args().engine)
