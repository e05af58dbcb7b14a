"""Draws the figures anew from the artefacts in the results folder, into a folder of their own."""

from __future__ import annotations

import queue
from pathlib import Path
from typing import Any

from pipeline.cache import durable, fingerprint
from pipeline.errors import StageFailed, StudyError
from pipeline.execution.order import order_of
from pipeline.execution.process import Event, Worker
from pipeline.graph import Stage
from pipeline.parameters import loading
from pipeline.study import Study, shown

FIGURES = "results/figures"


def drawing_stage(study: Study) -> Stage:
    """The stage that draws. Raises `StudyError` if no stage of dvc.yaml makes results/figures."""
    for stage in study.graph.stages.values():
        if FIGURES in stage.outs:
            return stage
    raise StudyError(f"dvc.yaml: no stage lists {FIGURES} among its outs")


def redraw(study: Study, folder: Path) -> Path:
    """Run the drawing stage on the artefacts as they lie there, whatever made them; returns the folder of figures.

    Raises `StudyError` for a missing or foreign artefact, `StageFailed` if the stage does not finish.
    """
    stage = drawing_stage(study)
    values = study.parameters((stage.name,))[stage.name]
    inputs = [(path, str(study.store.place(path)), _digest(study, path)) for path in stage.inputs]
    contents = {path: sha256 for path, _, sha256 in inputs}
    parts = fingerprint.ingredients(stage, study.sources, loading.as_plain(values), contents)
    events: queue.SimpleQueue[Event] = queue.SimpleQueue()
    worker = Worker(order_of(study, values, parts, folder, inputs), study.root, folder / "stage.log", events)
    try:
        _wait(events, stage.name)
    finally:
        worker.end()
    return folder / FIGURES


def _digest(study: Study, path: str) -> str:
    content = durable.read(study.store.place(path))
    if content is None:
        raise StudyError(f"{shown(study.store.place(path))} is not there yet; make it with: bipedstudy run-all")
    return durable.digest(content)


def _wait(events: queue.SimpleQueue[Event], name: str) -> None:
    while True:
        message: dict[str, Any] = events.get()[1]
        if "done" in message:
            return
        if "failed" in message:
            raise StageFailed(f"stage {name}: {message['failed']['text']}")
