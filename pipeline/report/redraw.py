"""Draws the figures anew from the artefacts in the results folder, into a folder of their own."""

from __future__ import annotations

from pathlib import Path

from pipeline.cache import durable, fingerprint
from pipeline.errors import StudyError
from pipeline.execution.job import job_of, task_of
from pipeline.execution.process import computed
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
    files = {path: (str(study.store.place(path)), _digest(study, path)) for path in stage.inputs}
    contents = {path: sha256 for path, (_, sha256) in files.items()}
    parts = fingerprint.ingredients(stage, study.sources, loading.as_plain(values), contents)
    computed(job_of(study, parts, files), task_of(study, {stage.name: values}), folder)
    return folder / FIGURES


def _digest(study: Study, path: str) -> str:
    content = durable.read(study.store.place(path))
    if content is None:
        raise StudyError(f"{shown(study.store.place(path))} is not there yet; make it with: bipedstudy run-all")
    return durable.digest(content)
