"""What a stage reads: the class `Inputs` beside its `run`, filled field by field.

A field is named like a result (`results/fall.h5` is `fall`) or like a parameter that names a file. Its type says how it
is given: as the maker's `Result`, decoded, or as `Path`, the file itself. What has no field is not read. A stage that
has a field `missing` goes on without results that are not there or that dvc.yaml does not list among its deps: they are
None, and it says why, by name. A field
`looser` is given the same inputs as looser solvers gave them, where there are some.
"""

from __future__ import annotations

import contextlib
import io
import typing
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline.cache import artefact, disk
from pipeline.errors import Lacking, StudyError, nearest
from pipeline.execution.job import File
from pipeline.graph import Stage, beneath
from pipeline.parameters.value import declared
from pipeline.room import hdf5_file
from pipeline.stage_modules import result_class, stage_module

MISSING, LOOSER = "missing", "looser"
_NONE = "there is no "


def disagreements(package: str, stage: Stage, inputs: type | None, parameters: type) -> Iterator[str]:
    """Where a stage's `Inputs` and dvc.yaml do not say the same, a clause each, to follow on the stage's name."""
    fields = declared(inputs) if inputs else {}
    results = {Path(path).stem: path for path in stage.inputs}
    named = {key for _, section in declared(parameters).values() for key, (about, _) in declared(section).items()
             if about.metadata.get("file")}  # fmt: skip
    for name, path in results.items():
        if name not in fields:
            yield f'dvc.yaml lists {path} among its deps, but its Inputs have no "{name}"{nearest(name, fields)}'
    for name, (_, kind) in fields.items():
        known = name in {*results, *named}
        if name in (MISSING, LOOSER) or (not known and MISSING in fields and Path not in _kinds(kind)):
            continue
        if not known:
            hint = nearest(name, {*results, *named})
            yield f'its Inputs have "{name}", but dvc.yaml lists no such result and no parameter such a file{hint}'
        elif Path not in _kinds(kind):
            allowed = [result_class(package, name)] if results.get(name, "").endswith(".h5") else []
            if kind not in allowed:
                yield f'its Inputs have "{name}" as {_named(_kinds(kind))}; allowed: {_named([*allowed, Path])}'


def given(
    package: str, stage: Stage, parameters: Any, named: Mapping[str, File], results: Mapping[str, File],
    errors: bool = True,
) -> tuple[Any, Any, dict[str, File]]:  # fmt: skip
    """The stage's inputs (None without a class for them), the same as looser solvers gave them (None where none did, or
    without `errors`), and those of its files that it is given as they lie there.

    `named` are the files that `parameters` name, by key, `results` those of stages, by path. Raises `StudyError` for a
    disagreement and for a file that is not as it was, `Lacking` for a result that is not there and has to be.
    """
    inputs = getattr(stage_module(package, stage.name, "run"), "Inputs", None)
    for sentence in disagreements(package, stage, inputs, type(parameters)):
        raise StudyError(sentence)
    values: dict[str, Any] = {}
    looser: dict[str, Any] = {}
    open_files: dict[str, File] = {}
    missing: dict[str, str] = {}
    fields = declared(inputs) if inputs else {}
    for name in (name for name in fields if name not in (MISSING, LOOSER)):
        kind, (path, files) = fields[name][1], _lying(name, stage, named, results)
        why = _lacking(path, files)
        if path not in stage.inputs and MISSING in fields and Path not in _kinds(kind):
            why = f"{_NONE}{name}: this study's dvc.yaml leaves it out of what stage {stage.name} reads"
        if why is not None and MISSING not in fields:
            raise Lacking(why)
        if why is not None:
            missing[name], values[name] = why, None
        elif files:  # else a parameter that names no file; the field has a default
            open_files |= files if Path in _kinds(kind) else {}
            values[name], looser[name] = _value(path, kind, files, errors or LOOSER in fields)
    values |= {MISSING: missing} if missing else {}
    solved = {name: value for name, value in looser.items() if value is not None}
    other = inputs(**{**values, **solved}) if inputs and solved else None
    beside = {LOOSER: other} if LOOSER in fields else {}
    return inputs and inputs(**values, **beside), other, open_files


def _lying(
    name: str, stage: Stage, named: Mapping[str, File], results: Mapping[str, File]
) -> tuple[str, Mapping[str, File]]:
    """The path of an input in the study, and the files there, by path; none for a parameter that names no file."""
    path = next((path for path in stage.inputs if Path(path).stem == name), name)
    return path, {name: named[name]} if name in named else {each: results[each] for each in beneath(path, results)}


def _lacking(path: str, files: Mapping[str, File]) -> str | None:
    """Why a result is not there; None where it is."""
    why = next((reason for place, reason in files.values() if not place), None)
    return why if why is None or why.startswith(_NONE) else f"{_NONE}{Path(path).name.removesuffix('.h5')}: {why}"


def _value(path: str, kind: Any, files: Mapping[str, File], errors: bool) -> tuple[Any, Any]:
    """What lies at `path` of the study, one file or several: its place, or decoded as what the field declares; and what
    looser solvers gave in its place, if anything, and if `errors` are wanted.
    """
    if Path in _kinds(kind):
        check_unchanged(files, "was changed by someone else meanwhile; run again")
        first, (place, _) = next(iter(files.items()))
        inside = len(Path(first).parts) - len(Path(path).parts)
        return [Path(place), *Path(place).parents][inside], None
    content = disk.read(Path(files[path][0])) or b""
    if disk.digest(content) != files[path][1]:
        raise StudyError(f"its input {path} was changed by someone else meanwhile; run again")
    hdf5_file.check_plain(io.BytesIO(content), path)
    return artefact.decode(content, kind, path), artefact.decode_looser(content, kind, path) if errors else None


def check_unchanged(
    files: Mapping[str, File], said: str = "was changed while it ran, so its result was not kept; run again"
) -> None:
    """Raises `StudyError` if one of `files` is not what it was when its digest was taken."""
    for name, (file, sha256) in files.items():
        found = ""
        with contextlib.suppress(OSError):  # it is gone
            found = disk.file_digest(Path(file))
        if found != sha256:
            raise StudyError(f"its input {name} {said}")


def _kinds(kind: Any) -> tuple[Any, ...]:
    return typing.get_args(kind) or (kind,)


def _named(classes: Iterable[Any]) -> str:
    return " or ".join(f"{cls.__module__}.{cls.__name__}" for cls in classes)
