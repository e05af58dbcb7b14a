"""Speed against accuracy of all ways this study can walk, in clock time; keeps the table that docs/prices.md shows.

    python -m benchmarks.tradeoff            measures (some minutes), writes benchmarks/ways.json
    python -m benchmarks.tradeoff twin       measures one kind of model anew: constraint, detailed, penalty or twin
    python -m benchmarks.tradeoff --picture  writes docs/prices.png from the kept table alone

Reads results/analytic.h5. Times are processor times of the integration alone, the best of a few, in yardsticks: one
step of the compiled constraint model at 1e-10, timed between the ways so that it shares the machine's mood.
"""

import argparse
import dataclasses
import datetime
import importlib.metadata
import json
import math
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pipeline.cache import artefact
from pipeline.layout import markdown
from pipeline.parameters.loading import load
from stages.analytic.gait.poincare import poincare_map
from stages.analytic.result import Result as Analytic
from stages.drawing import style
from stages.figures.drawn import work_and_extremes
from stages.tradeoff import constraint_ways
from stages.tradeoff.parameters import Parameters
from stages.tradeoff.result import ERRORS, Errors, Reference, Result, Row, cells, front, gain
from stages.tradeoff.run import constraint_plans, measure, penalty_plans, projected_plan, twin_plan

ROOT = Path(__file__).resolve().parent.parent
LISTED = ("constraint model, rolling", "penalty model", "twin")
KEPT, PICTURE = ROOT / "benchmarks/ways.json", ROOT / "docs/prices.png"
#: Rounds end when they have taken this much processor time [s].
LONG = 0.4
PACKAGES = ("exudyn", "numba", "numpy", "scipy")


def spent(call: Callable[[], Any], rounds: int = 5) -> float:
    """Processor time of the best round [s]; a call that takes long is made once."""
    times: list[float] = []
    while len(times) < rounds and sum(times) < LONG:
        began = time.process_time()
        call()
        times.append(time.process_time() - began)
    return min(times)


#: The kinds of models, by the first word of their names.
KINDS = {"constraint": constraint_plans, "detailed": lambda parameters, _: [projected_plan(parameters)],
         "penalty": penalty_plans, "twin": lambda *given: [twin_plan(*given)]}  # fmt: skip


def measured(kind: str) -> dict[str, Any]:
    """The full study of one kind of model with times, as plain values."""
    wanted = {"tradeoff": Parameters}
    parameters = load(ROOT / "params", ["tradeoff.resolution=full"], wanted, [Parameters])["tradeoff"]
    path = ROOT / "results/analytic.h5"
    analytic = artefact.decode(path.read_bytes(), Analytic, str(path))
    steps = parameters.settings.walked_steps
    at = constraint_ways.scene(parameters.biped, parameters.slope, None, analytic.mid_stance, steps)

    def yardstick() -> float:
        return spent(lambda: [poincare_map(at.walker, at.gait, 1e-10) for _ in range(50)], 5) / 50

    references, rows, sticks = [], [], []
    for plan in KINDS[kind](parameters, analytic):
        reference, found = measure(plan)
        references.append(dataclasses.asdict(reference))
        for way, row in zip(plan.ways, found):
            stick, seconds = yardstick(), math.nan
            if row.completed:
                seconds = spent(way.integrate) / steps
            sticks.append(stick)
            rows.append({**dataclasses.asdict(row), "seconds": seconds, "yardsticks": seconds / stick})
            print(row.model, "|", row.way, "|", row.setting, f"| {seconds / stick:.1f}", flush=True)
    stick = sorted(sticks)[len(sticks) // 2]
    return {
        "about": {kind: {**about(), "yardstick_s": stick}},
        "yardstick": "one step of the compiled constraint model at tolerance 1e-10, without recording",
        "walked_steps": steps,
        "references": references,
        "rows": rows,
    }


def about() -> dict[str, Any]:
    """When, on what machine and with which versions."""
    versions = {name: importlib.metadata.version(name) for name in PACKAGES}
    return {"made": datetime.date.today().isoformat(), "machine": f"{platform.machine()}, {platform.system()}, {cpu()}",
            "versions": {"python": platform.python_version(), **versions}}


def as_text(table: dict[str, Any]) -> str:
    """The kept table as JSON, a measured row a line."""
    parts = []
    for key, value in table.items():
        rows = ",\n".join(f"  {json.dumps(row, allow_nan=False)}" for row in value) if isinstance(value, list) else ""
        parts.append(f' "{key}": ' + (f"[\n{rows}\n ]" if rows else json.dumps(value, allow_nan=False)))
    return "{\n" + ",\n".join(parts) + "\n}\n"


def merged(old: dict[str, Any], new: dict[str, Any]) -> dict[str, Any]:
    """The old table with the models of the new one in place of theirs, in the order of `KINDS`."""
    kinds = set(new["about"])
    kept = {**new, "about": {**old.get("about", {}), **new["about"]}}
    for part in ("references", "rows"):
        others = [item for item in old.get(part, ()) if item["model"].split()[0] not in kinds]
        order = list(KINDS)
        kept[part] = sorted(others + new[part], key=lambda item: order.index(item["model"].split()[0]))
    return kept


def cpu() -> str:
    """The processor's name where the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or "unknown processor"
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "unknown")


def as_result(kept: dict[str, Any]) -> tuple[Result, list[float]]:
    """The kept table as the stage's own result, and the times in yardsticks."""
    names = {field.name for field in dataclasses.fields(Row)}

    def errors(values: dict[str, Any]) -> Errors:
        return Errors(**{name: math.nan if value is None else value for name, value in values.items()})

    rows = []
    for row in kept["rows"]:
        values = {key: math.nan if value is None else value for key, value in row.items() if key in names}
        rows.append(Row(**{**values, "errors": errors(row["errors"]), "doubt": errors(row["doubt"])}))
    references = tuple(
        Reference(**{**{key: math.nan if value is None else value for key, value in given.items()},
                     "second_differs": errors(given["second_differs"]),
                     "independent_differs": errors(given["independent_differs"])})
        for given in kept["references"])
    times = [math.nan if row["yardsticks"] is None else row["yardsticks"] for row in kept["rows"]]
    return Result(kept["walked_steps"], references, tuple(rows)), times


def fronts(kept: dict[str, Any]) -> list[str]:
    """The section of docs/prices.md on ways to solve: what nothing measured beats, for each model."""
    result, times = as_result(kept)
    made = ", ".join(f"{kind} {said['made']}" for kind, said in kept["about"].items())
    lines = [
        "## Which way to solve", "", f"Kept by `python -m benchmarks.tradeoff` ({made}).",
        f"Each way walks {kept['walked_steps']} steps from one mid-stance. The unit of time is",
        f"{kept['yardstick']}.",
        "Listed are the ways of three models that no other beats in both time and hip error; `bipedstudy show",
        "tradeoff` has all.", "",
        "![Work and precision](prices.png)", ""]  # fmt: skip
    for model in result.references:
        ratio = gain(result.rows, model.model, times)
        if math.isfinite(ratio):
            lines += [f"{model.model[0].upper()}{model.model[1:]}: the default is {ratio:.1f} times as fast "
                      "as the paper's setting, at the same hip error.", ""]  # fmt: skip
    rows = []
    for model in (each for each in result.references if each.model in LISTED):
        pairs = [(row, cost) for row, cost in zip(result.rows, times) if row.model == model.model]
        chosen = front([row for row, _ in pairs], [cost for _, cost in pairs], ERRORS[0])
        rows += [[model.model, row.way, row.setting, *cells(row.errors), f"{cost:.3g}"]
                 for number, (row, cost) in enumerate(pairs) if number in chosen]  # fmt: skip
    columns = "model", "way", "setting", "hip [m]", "period [s]", "multiplier [1]", "peak force [N]", "time"
    lines += markdown(columns, rows)
    return [
        *lines, "", "`accuracy: {hip_position_m: 1e-5}` in `params/analytic.yaml`, `multibody.yaml` or `twin.yaml`, or",
        "`--accuracy hip_position_m=1e-5` for all of them, refines each walk until its own error is smaller;",
        "`--verify` shows the errors that it found."]  # fmt: skip


def main() -> None:
    """Measure unless only the picture is wanted; write table and picture."""
    parser = argparse.ArgumentParser()
    parser.add_argument("kinds", nargs="*", choices=[*KINDS, []], help="kinds of models to measure (default: all)")
    parser.add_argument("--picture", action="store_true", help="only draw the kept table")
    given = parser.parse_args()
    for kind in () if given.picture else given.kinds or KINDS:
        new = finite(measured(kind))
        old = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
        KEPT.write_text(as_text(merged(old, new)), encoding="utf-8")
    with style.drawing():
        result, times = as_result(json.loads(KEPT.read_text(encoding="utf-8")))
        figure = work_and_extremes.work_and_precision(result, times, "time [steps of the constraint model at 1e-10]")
        PICTURE.write_bytes(style.pictures("x", figure, 200)["figures/x.png"])


def finite(value: Any) -> Any:
    """The same with None for what is not a number, which JSON does not know."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


if __name__ == "__main__":
    main()
