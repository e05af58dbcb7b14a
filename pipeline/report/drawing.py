"""Draws figures in this process, from the artefacts as they lie there, whatever made them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from pipeline.cache import artefact, durable, regular
from pipeline.errors import StudyError, nearest
from pipeline.graph import Stage
from pipeline.stage_modules import result_class
from pipeline.study import Study, shown

FIGURES = "results/figures"


def draw(study: Study, asked: Iterable[str], folder: Path) -> Iterator[tuple[list[Path], str]]:
    """Draw every figure whose name begins with one of `asked` into `folder`; gives the files and the caption of each.

    Reads only the results that these figures name. Raises `StudyError` for an unknown figure, for a missing or foreign
    artefact, and if no stage makes results/figures or the one that does draws them only together.
    """
    stage = next((stage for stage in study.graph.stages.values() if FIGURES in stage.outs), None)
    if stage is None:
        raise StudyError(f"dvc.yaml: no stage lists {FIGURES} among its outs")
    drawn = study.module(stage.name, "drawn")
    if drawn is None:
        raise StudyError(f"stage {stage.name} has no module drawn: it draws its figures only together")
    names = dict.fromkeys(name for each in asked for name in _chosen(each, drawn.NAMES))
    values = study.parameters((stage.name,))[stage.name]
    for name in names:
        results = {key: _result(study, stage, key) for key in drawn.figure(name).INPUTS}
        files, caption = drawn.draw(name, values, results)
        for path, content in files.items():
            durable.write(folder / Path(path).name, content)
        yield [folder / Path(path).name for path in files], caption


def _chosen(asked: str, names: tuple[str, ...]) -> list[str]:
    chosen = [name for name in names if name.startswith(asked)]
    if not chosen:
        hint = nearest(asked, [*names, *(name[: len(asked) + 1] for name in names)])
        raise StudyError(f'there is no figure "{asked}" (figures: {", ".join(names)}){hint}')
    return [asked] if asked in chosen else chosen


def _result(study: Study, stage: Stage, key: str) -> Any:
    path = next(path for path in stage.inputs if Path(path).stem == key)
    file = study.store.place(path)
    if not file.exists():
        raise study.absent(study.graph.maker(path), file, "run-all")
    regular.check(file, shown(file), regular.ARTEFACT)
    return artefact.load(file, result_class(study.package, key)) if path.endswith(".h5") else file
