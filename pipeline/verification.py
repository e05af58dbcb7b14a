"""`--verify`: the error of a stage's walk, estimated by a second run and kept beside the artefact.

The second run takes the most accurate setting measured at no more than half the cost; where none is measured, the next
more accurate one, which costs somewhat more. Both runs differ by the difference of their errors. The kept table shows
with which power of the tolerance (or step) the errors of the way go; so the difference gives the error, as Richardson
has it. The artefact's own bytes follow from its key alone and do not depend on whether it was verified.
"""

from __future__ import annotations

import importlib
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np
import yaml

from pipeline.accuracy import TABLE, Choice
from pipeline.cache import artefact, durable, lock
from pipeline.errors import StudyError
from pipeline.study import Study, shown

#: Places to which times count as equal [s].
PLACES = 9


def choices(study: Study, stages: tuple[str, ...]) -> list[tuple[Choice, Any]]:
    """Of each of `stages` that is asked for an accuracy its solver settings and its parameters.

    Raises `StudyError` if none is asked.
    """
    values = study.parameters([study.graph.stage(name).name for name in stages])
    found = [(choice, values[name]) for name in stages if (choice := study.choice(name, values[name])) is not None]
    if not found:
        raise StudyError(f"--verify estimates an error that was asked for, and none is asked of {', '.join(stages)}; "
                         f"give --accuracy, or accuracy in the stage's parameter file")  # fmt: skip
    return found


def verify(study: Study, chosen: list[tuple[Choice, Any]], *, told: bool) -> None:
    """Run each stage once more at another budget, under the results folder's lock; keep the estimate and, if `told`,
    print it.
    """
    with lock.held(study.results, shown(study.results), "bipedstudy --verify", True, click.echo):
        for choice, values in chosen:
            found = verified(study, choice, values)
            place = record_of(study, choice.stage)
            durable.write(place, yaml.safe_dump(found, sort_keys=False).encode())
            if told:
                click.echo(f"{line(found)}; {shown(place)}")


def verified(study: Study, choice: Choice, values: Any) -> dict[str, Any]:
    """What is kept of a verification, as plain values."""
    about = {
        "stage": choice.stage,
        "artefact_key": artefact.provenance(*_content(study, choice.stage))["key"],
        "asked": dict(choice.asked),
        "settings": dict(choice.settings),
        "hip_error_expected_m": _rounded(choice.expected),
        "table": {kind: entry["made"] for kind, entry in json.loads(TABLE.read_text())["about"].items()},
    }
    second = choice.second
    if second is None:
        return {**about, "hip_error_estimate_m": None, "reason": "no other setting of this way is measured"}
    about["second_run"] = {"settings": dict(second.settings), "budget": round(second.budget, 2),
                           "order": round(second.order, 2)}  # fmt: skip
    try:
        difference = hip_difference(study, choice, values)
    except Exception as error:  # whatever a stage raises at another setting: the run asked for is there and stays
        return {**about, "hip_error_estimate_m": None, "reason": f"the second run failed: {error}"}
    about["hip_difference_m"] = _rounded(difference)
    return {**about, "hip_error_estimate_m": _rounded(second.estimate(difference))}


def record_of(study: Study, stage: str) -> Path:
    """Where the verification of a stage's artefact is kept: results/accuracy/<stage>.yaml."""
    return study.results / "accuracy" / f"{stage}.yaml"


def kept(study: Study, stage: str, key: str) -> dict[str, Any] | None:
    """The verification of the artefact with this key, or None if there is none."""
    try:
        found = yaml.safe_load(durable.read(record_of(study, stage)) or b"")
    except yaml.YAMLError:
        return None
    return found if isinstance(found, dict) and found.get("artefact_key") == key else None


def line(found: dict[str, Any]) -> str:
    """A verification in one line."""
    asked, used = _listed(found["asked"]), _listed(found["settings"])
    said = f"{found['stage']}: asked {asked}; used {used}; hip error expected {found['hip_error_expected_m']:.1e} m"
    estimate = found["hip_error_estimate_m"]
    if estimate is None:
        return f"{said}; not estimated: {found['reason']}"
    second = found["second_run"]
    other = f"a run with {_listed(second['settings'])}, at {second['budget']:g} of the cost"
    return f"{said}, estimated {estimate:.1e} m ({other}, differs by {found['hip_difference_m']:.1e} m)"


def hip_difference(study: Study, choice: Choice, values: Any) -> float:
    """Largest distance [m] of the hips of the stage's walk and of the second run's, at common times."""
    assert choice.second is not None
    stage = study.graph.stages[choice.stage]
    given = {path.rsplit("/", 1)[-1].removesuffix(".h5"): _result(study, path) for path in stage.inputs}
    name = next(name for name, section in vars(values).items() if choice.stage == section.FILE)
    other = replace(values, **{name: replace(getattr(values, name), **choice.second.settings)})
    run = importlib.import_module(f"{study.package}.{stage.name}.run").run
    return walk_difference(_result(study, stage.artefact).walk, run(other, given).walk)


def walk_difference(one: Any, other: Any) -> float:
    """Largest distance [m] of two walks' hips at the times both have sampled; NaN without any."""
    times = (np.round(walk.time, PLACES) for walk in (one, other))
    _, first, second = np.intersect1d(*times, return_indices=True)
    if not len(first):
        return math.nan
    return float(np.abs(one.hip_position[first] - other.hip_position[second]).max())


def _listed(values: dict[str, float]) -> str:
    return ", ".join(f"{key} {value:g}" for key, value in values.items())


def _rounded(value: float) -> float:
    """Two digits: an estimate has no more."""
    return float(f"{value:.1e}")


def _content(study: Study, stage: str) -> tuple[bytes, str]:
    """Bytes of a stage's artefact, and how messages name it."""
    place = study.store.place(study.graph.stages[stage].artefact)
    return place.read_bytes(), shown(place)


def _result(study: Study, path: str) -> Any:
    stage = Path(path).stem
    content, name = _content(study, stage)
    return artefact.decode(content, importlib.import_module(f"{study.package}.{stage}.result").Result, name)
