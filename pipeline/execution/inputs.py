"""What a stage reads: the class `Inputs` beside its `run`, filled field by field.

A field is named like a result (`results/fall.h5` is `fall`) or like a parameter that names a file. Its type says how it
is given: as the maker's `Result`, decoded, or as `Path`, the file itself. What has no field is not read. A stage that
has a field `missing` goes on without results that are not there or that dvc.yaml does not list among its deps: they are
None, and it says why, by name. A field
`closer` is given the same inputs as closer solvers gave them, where there are some. A closer result with files goes to
stages that read these files too, or have both: what others made of them they made of those beside the result itself. A
stage that has an artefact as a `Path` reads none of it, but then gets files beside it as closer solvers made them.
"""

import contextlib
import io
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline.cache import artefact, disk
from pipeline.errors import Lacking, StudyError, nearest
from pipeline.execution.job import File
from pipeline.graph import Stage, beneath
from pipeline.home import DISTRIBUTION, result_class, stage_module
from pipeline.parameters import loading
from pipeline.parameters.value import declared, options_of
from pipeline.room import reading

MISSING, CLOSER = "missing", "closer"
_NONE, _ARTEFACT = "there is no ", ".h5"
#: Of a longer reason only the first clause is passed on; the stage that gave it says the whole.
_LONG = 120


def disagreements(package: str, stage: Stage, inputs: type | None, parameters: type) -> Iterator[str]:
    """Where a stage's `Inputs` and dvc.yaml do not say the same, a clause each, to follow on the stage's name."""
    fields, optional = _fields(inputs)
    results = {Path(path).stem: path for path in stage.inputs}
    known = {*results, *(key for _, section in declared(parameters).values() for key in loading.file_keys(section))}
    for name in (name for name in results if name not in fields):
        yield f'dvc.yaml lists {results[name]} among its deps, but its Inputs have no "{name}"{nearest(name, fields)}'
    for name, kinds in fields.items():
        if name not in known and (Path in kinds or not optional):
            hint = nearest(name, known)
            yield (f'its Inputs have "{name}", but dvc.yaml lists no such result and no parameter such a file{hint}; '
                   f"one that an earlier version laid out is renewed by: {DISTRIBUTION} init . --update")
        elif name in known and Path not in kinds:
            allowed = [result_class(package, name)] if results.get(name, "").endswith(_ARTEFACT) else []
            if list(kinds) != allowed:
                yield f'its Inputs have "{name}" as {_named(kinds)}; allowed: {_named([*allowed, Path])}'


def _fields(inputs: type | None) -> tuple[dict[str, tuple[Any, ...]], bool]:
    """The types of each input by its name, and whether the stage goes on without results that are not there."""
    fields = {} if inputs is None else declared(inputs)
    return {name: options_of(kind) for name, (_, kind) in fields.items()
            if name not in (MISSING, CLOSER)}, MISSING in fields  # fmt: skip


def given(
    package: str, stage: Stage, parameters: Any, named: Mapping[str, File], results: Mapping[str, File],
    errors: bool, folder: Path,
) -> tuple[Any, Any, dict[str, File]]:  # fmt: skip
    """The stage's inputs (None without a class for them), the same as closer solvers gave them (None where none did, or
    without `errors`), and those of its files that it is given as they lie there.

    `named` are the files that `parameters` name, by key, `results` those of stages, by path; files beside closer
    results are written into `folder`. Raises `StudyError` for a disagreement and for a file that is not as it was,
    `Lacking` for a result that is not there and has to be.
    """
    inputs = getattr(stage_module(package, stage.name, "run"), "Inputs", None)
    for sentence in disagreements(package, stage, inputs, type(parameters)):
        raise StudyError(sentence)
    if inputs is None:
        return None, None, {}
    fields, optional = _fields(inputs)
    asks = CLOSER in declared(inputs)
    lying = {name: _lying(name, stage, named, results) for name in fields}
    missing = {name: why for name, kinds in fields.items()
               if (why := _lacking(stage, kinds, optional, name, *lying[name]))}  # fmt: skip
    for why in () if optional else missing.values():
        raise Lacking(why)
    values, closer = dict[str, Any](dict.fromkeys(missing)), dict[str, Any]()
    open_files, beside = dict[str, File](), dict[str, bytes]()
    for name, (path, files) in lying.items():
        if name in missing or not files:  # a parameter that names no file; the field has a default
            continue
        if Path in fields[name]:
            open_files |= files
            values[name] = _place(path, files)
            if errors and path.endswith(_ARTEFACT):
                beside |= artefact.closer_files(_content(path, *files[path]), path)
        else:
            values[name], closer[name] = _decoded(path, fields[name][0], *files[path], errors or asks)
    for name, (path, _) in lying.items():
        if content := beside.get(Path(path).name):
            closer[name] = folder / Path(path).name
            disk.write(closer[name], content)
    values |= {MISSING: missing} if missing else {}
    solved = {name: value for name, value in closer.items()
              if value is not None and (asks or _read_whole(stage, value))}  # fmt: skip
    other = inputs(**{**values, **solved}) if solved else None
    return inputs(**values, **({CLOSER: other} if asks else {})), other, open_files


def _read_whole(stage: Stage, result: Any) -> bool:
    """Whether a stage reads files of a result beside it, or this has none."""
    files = getattr(result, "files", {})
    return not files or any(Path(path).name in files for path in stage.inputs)


def _lying(
    name: str, stage: Stage, named: Mapping[str, File], results: Mapping[str, File]
) -> tuple[str, Mapping[str, File]]:
    """The path of an input in the study, and the files there, by path; none for a parameter that names no file."""
    path = next((path for path in stage.inputs if Path(path).stem == name), name)
    return path, {name: named[name]} if name in named else {each: results[each] for each in beneath(path, results)}


def _lacking(
    stage: Stage, kinds: Iterable[Any], optional: bool, name: str, path: str, files: Mapping[str, File]
) -> str:
    """Why a result is not there; nothing where it is."""
    if path not in stage.inputs and optional and Path not in kinds:
        return f"{_NONE}{name}: this study's dvc.yaml leaves it out of what stage {stage.name} reads"
    why = next((reason for place, reason in files.values() if not place), "")
    if not why or why.startswith(_NONE):
        return why
    clause = re.split(r"[:;] | \(", why, maxsplit=1)[0] if len(why) > _LONG else why
    return f"{_NONE}{Path(path).name.removesuffix('.h5')}: {clause}"


def _place(path: str, files: Mapping[str, File]) -> Path:
    """Where what stands at `path` of the study lies, one file or a folder of several."""
    check_unchanged(files, "was changed by someone else meanwhile; run again")
    first, (place, _) = next(iter(files.items()))
    inside = len(Path(first).parts) - len(Path(path).parts)
    return [Path(place), *Path(place).parents][inside]


def _decoded(path: str, kind: Any, place: str, sha256: str, errors: bool) -> tuple[Any, Any]:
    """The result that is called `path` and lies at `place`, as what the field declares, and what closer solvers gave in
    its place, if anything, and if `errors` are wanted.
    """
    content = _content(path, place, sha256)
    return artefact.decode(content, kind, path), artefact.decode_closer(content, kind, path) if errors else None


def _content(path: str, place: str, sha256: str) -> bytes:
    """The artefact that is called `path` and lies at `place`, if it is as it was and may be read."""
    content = disk.read(Path(place)) or b""
    if disk.digest(content) != sha256:
        raise StudyError(f"its input {path} was changed by someone else meanwhile; run again")
    reading.check_plain(io.BytesIO(content), path)
    return content


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


def _named(classes: Iterable[Any]) -> str:
    """Classes as one imports them: Python 3.13 has `Path` in a private module of `pathlib`."""
    return " or ".join(f"{cls.__module__.partition('._')[0]}.{cls.__name__}" for cls in classes)
