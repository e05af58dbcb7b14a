"""Draws figures in this process, from the artefacts as they lie there, with the parameters that these were made with.

Where these are not the ones at hand, each figure says so in its picture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from pipeline.cache import artefact, disk
from pipeline.errors import Declined, StudyError, is_answer, nearest
from pipeline.graph import Stage
from pipeline.parameters import loading
from pipeline.report.standing import Standing, made_by, together
from pipeline.stage_modules import result_class
from pipeline.study import Study, shown

FIGURES = "results/figures"
_NO_CAPTION = "No caption: what is drawn was not computed together, so it is no comparison."


def draw(
    study: Study, asked: Iterable[str], folder: Path, *, marked: bool = True
) -> Iterator[tuple[list[Path], str, str]]:
    """Draw every figure whose name begins with one of `asked` into `folder`; gives the files and the caption of each,
    and what is to be said of the results it shows, which stands in the picture too where that is to be `marked`.

    Reads only the results that these figures name. Raises `StudyError` for an unknown figure, for a missing or foreign
    artefact, and if no stage makes results/figures or the one that does draws them only together. Raises `Declined`
    after all others for those that cannot be drawn for a reason.
    """
    stage = next((stage for stage in study.graph.stages.values() if FIGURES in stage.outs), None)
    if stage is None:
        raise StudyError(f"dvc.yaml: no stage lists {FIGURES} among its outs")
    drawn = study.module(stage.name, "drawn")
    if drawn is None:
        raise StudyError(f"stage {stage.name} has no module drawn: it draws its figures only together")
    names = dict.fromkeys(name for each in asked for name in _chosen(each, drawn.NAMES))
    shows = {name: _makers(study, stage, drawn.figure(name).inputs) for name in names}
    values = study.parameters((stage.name,))[stage.name]
    standing = Standing(study, {each for makers in shows.values() for each in makers}) if marked else None
    refused = []
    for name, makers in shows.items():
        said = standing.said(makers) if standing else ""
        try:
            results = {key: _result(study, stage, key) for key in drawn.figure(name).inputs}
            files, caption = drawn.draw(name, _parameters(study, values, makers), results, said)
        except Exception as error:
            if not is_answer(error, study.package):
                raise
            refused.append(f"{name} is not drawn: {error}")
            continue
        for path, content in files.items():
            disk.write(folder / Path(path).name, content)
        yield [folder / Path(path).name for path in files], caption if together(study, makers) else _NO_CAPTION, said
    if refused:
        raise Declined(refused)


def _makers(study: Study, stage: Stage, inputs: Iterable[str]) -> tuple[str, ...]:
    """The stages whose results a figure shows."""
    return tuple(dict.fromkeys(study.graph.maker(_path(stage, key)) for key in inputs))


def _parameters(study: Study, values: Any, makers: Sequence[str]) -> Any:
    """What a figure is drawn with: the parameters of the results it shows, and of `values` the drawing's own."""
    plain = loading.as_plain(values)
    for entry in (made_by(study, name) for name in reversed(makers)):
        for file, own in plain.items():
            theirs = entry.ingredients["parameters"].get(file, {}) if entry is not None else {}
            own |= {key: value for key, value in theirs.items() if key in own}
    return loading.from_plain(type(values), plain)


def _path(stage: Stage, key: str) -> str:
    return next(path for path in stage.inputs if Path(path).stem == key)


def _chosen(asked: str, names: tuple[str, ...]) -> list[str]:
    chosen = [name for name in names if name.startswith(asked)]
    if not chosen:
        hint = nearest(asked, [*names, *(name[: len(asked) + 1] for name in names)])
        raise StudyError(f'there is no figure "{asked}" (figures: {", ".join(names)}){hint}')
    return [asked] if asked in chosen else chosen


def _result(study: Study, stage: Stage, key: str) -> Any:
    path = _path(stage, key)
    file = study.store.place(path)
    if not file.exists():
        raise study.absent(study.graph.maker(path), file, "run-all")
    disk.check(file, shown(file), disk.ARTEFACT)
    return artefact.load(file, result_class(study.package, key)) if path.endswith(".h5") else file
