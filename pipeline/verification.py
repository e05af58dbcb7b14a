"""`--verify`: how far a result is from a second run at half the budget, as an estimate of its error.

The cheaper run's error is the larger one, so the difference of the two estimates it, and the result asked for is
better. The second run is not kept.
"""

from __future__ import annotations

import importlib
import math
from typing import Any

import click
import numpy as np

from pipeline import artefact, parameters
from pipeline.accuracy import Choice
from pipeline.study import Study, shown


def verify_run(study: Study, stages: tuple[str, ...]) -> None:
    """Run each of `stages` that has an accuracy once more at half the budget, and print what differs."""
    values = study.parameters(study.graph.needed_for(stages))
    for choice in study.choices(values):
        if choice.stage not in stages:
            continue
        settings = ", ".join(f"{key} {value:g}" for key, value in choice.settings.items())
        asked = ", ".join(f"{key} {value:g}" for key, value in choice.asked.items())
        said = f"{choice.stage}: asked {asked}; settings {settings}; expected {choice.expected:.1e}; "
        if choice.half is None:
            click.echo(said + "no setting is measured at half the budget, so nothing estimates the error")
            continue
        difference = hip_difference(study, choice, values)
        click.echo(said + f"hip of a run at half the budget differs by {difference:.1e} m")


def hip_difference(study: Study, choice: Choice, values: dict[str, Any]) -> float:
    """Largest distance [m] of the hips of the stage's walk and of one at half the budget, at common times."""
    stage = study.graph.stages[choice.stage]
    given = {path.rsplit("/", 1)[-1].removesuffix(".h5"): _result(study, path) for path in stage.inputs}
    cls = study.parameters_class(stage)
    assert cls is not None and choice.half is not None
    rough = parameters.load(
        study.params, study.settings + choice.texts(choice.half), {stage.name: cls},
        [kind for other in study.graph.stages.values() if (kind := study.parameters_class(other)) is not None],
        shown(study.params))[stage.name]  # fmt: skip
    run = importlib.import_module(f"{study.package}.{stage.name}.run").run
    return walk_difference(_walk(_result(study, stage.artefact)), _walk(run(rough, given)))


def walk_difference(one: Any, other: Any) -> float:
    """Largest distance [m] of two walks' hips at the times both have sampled; NaN without any."""
    _, first, second = np.intersect1d(np.round(one.time, 9), np.round(other.time, 9), return_indices=True)
    if not len(first):
        return math.nan
    return float(np.abs(one.hip_position[first] - other.hip_position[second]).max())


def _walk(result: Any) -> Any:
    return result.signals.walk if hasattr(result, "signals") else result.walk


def _result(study: Study, path: str) -> Any:
    place = study.store.place(path)
    name = place.stem
    cls = importlib.import_module(f"{study.package}.{name}.result").Result
    return artefact.decode(place.read_bytes(), cls, shown(place))
