"""Draws single figures in this process, from the artefacts as they lie there, whatever made them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from pipeline.cache import artefact, durable
from pipeline.errors import StudyError, nearest
from pipeline.report.redraw import drawing_stage
from pipeline.stage_modules import result_class
from pipeline.study import Study, shown


def draw(study: Study, asked: Iterable[str], folder: Path) -> Iterator[tuple[list[Path], str]]:
    """Draw every figure whose name begins with one of `asked` into `folder`; gives the files and caption of each.

    Reads only the results that these figures name. Raises `StudyError` for an unknown figure, for a missing or foreign
    artefact, and if the stage that draws has no module `drawing`.
    """
    stage = drawing_stage(study)
    module = study.module(stage.name, "drawing")
    if module is None:
        raise StudyError(f"stage {stage.name} draws its figures together: bipedstudy run {stage.name}")
    names = [name for each in asked for name in _chosen(each, module.NAMES)]
    values = study.parameters((stage.name,))[stage.name]
    for name in dict.fromkeys(names):
        results = {key: _result(study, stage.inputs, key) for key in module.inputs_of(name)}
        drawing = module.draw(name, values, results)
        files = {folder / Path(path).name: content for path, content in drawing.files.items()}
        for file, content in files.items():
            durable.write(file, content)
        yield list(files), drawing.caption.text


def _chosen(asked: str, names: Sequence[str]) -> list[str]:
    chosen = [name for name in names if name.startswith(asked)]
    if not chosen:
        hint = nearest(asked, [*names, *(name[: len(asked) + 1] for name in names)])
        raise StudyError(f'there is no figure "{asked}" (figures: {", ".join(names)}){hint}')
    return [asked] if asked in chosen else chosen


def _result(study: Study, paths: Iterable[str], key: str) -> Any:
    path = next(path for path in paths if Path(path).stem == key)
    file = study.store.place(path)
    if not file.exists():
        raise StudyError(f"{shown(file)} is not there yet; make it with: bipedstudy run {Path(path).stem}")
    return artefact.load(file, result_class(study.package, key)) if path.endswith(".h5") else file
