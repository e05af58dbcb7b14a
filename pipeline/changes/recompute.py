"""`bipedstudy recompute RESULTS`: whether somebody's results follow from their parameters and recordings, by this code.

Nothing of the results is believed but the parameters that they name: neither cache nor code nor digests. What is
computed here, by the program and machine code of whoever asks, is held against every number and word of theirs.
"""

import contextlib
import dataclasses
import json
import os
import random
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from pipeline import layout
from pipeline.cache import disk, fingerprint
from pipeline.changes.command import results_of
from pipeline.commands import options
from pipeline.commands.show import check_links
from pipeline.errors import ANSWER, StageFailed, StudyError
from pipeline.execution.display import Display
from pipeline.execution.executor import bring_up_to_date
from pipeline.graph import beneath
from pipeline.package.command import unpacked
from pipeline.parameters import loading
from pipeline.parameters.value import SUFFIX
from pipeline.study import Study, shown

Row = dict[str, Any]
Plain = Mapping[str, Mapping[str, Any]]
#: What another processor may change of a number without a stated error, as a share of the largest in its field.
ROUNDED = 1e-5
_PRINTED = 8
#: Attributes that say who made a file, and how dimensions are tied, not what was found.
_APART = ("source", "DIMENSION_LIST", "REFERENCE_LIST", "_Netcdf4Dimid", "_Netcdf4Coordinates")


@click.command("recompute", epilog=options.examples("recompute"))
@click.argument("theirs", metavar="RESULTS", type=click.Path(exists=True, path_type=Path))
@options.study
@click.option("--share", type=click.FloatRange(0, 1, min_open=True), default=1.0, show_default=True,
              help="Share of the stages, chosen by chance.")
@click.option("--seed", type=click.IntRange(min=0), default=None, help="Chooses the stages (default: by chance).")
@click.option("--recordings", metavar="DIR", type=click.Path(exists=True, file_okay=False, path_type=Path),
              help="Folder from which parameters name recordings (default: the one above RESULTS).")
@click.option("--jobs", "-j", metavar="N", type=click.IntRange(min=1), help="Stages side by side (default: cores).")
@options.answers_without_rows
def recompute(study: Study, theirs: Path, share: float, seed: int | None, recordings: Path | None, jobs: int | None,
              form: options.Form) -> None:  # fmt: skip
    """Compute the stages of RESULTS again and say which of their numbers differ.

    RESULTS is a results folder, a study with one, or the file that package made. Its parameters and recordings are
    read, never its cache or code.
    Numbers must be equal where it names this kind of processor and these versions, elsewhere within the errors that
    are estimated here. With --share only some stages are compared, and those that they need. Ends with 3 if something
    differs.
    """
    seed = random.SystemRandom().randrange(1 << 31) if seed is None else seed
    with unpacked(theirs) as place:
        folder = results_of(place)
        found = held(study, folder, (recordings or folder.resolve().parent).absolute(), share, seed, jobs)
        found["results"] = shown(theirs)
    form.give(_lines(found), found)
    if found["differs"]:
        sys.exit(ANSWER)


def held(study: Study, folder: Path, recordings: Path, share: float, seed: int, jobs: int | None = None) -> Row:
    """What differs, as plain values: `seed`, `differs`, and of each stage compared its name, whether it was compared
    `exactly`, and `differences` (path, theirs, recomputed, why, apart, allowed). Raises `StudyError` for what cannot
    be read.
    """
    contents = {name: _content(folder / f"{name}.h5") for name in study.graph.stages
                if os.path.lexists(folder / f"{name}.h5")}  # fmt: skip
    if not contents:
        raise StudyError(f"{shown(folder)}: holds no result of a stage of {shown(study.root)}")
    about, values, other = stated(study, contents)
    needed = [name for name in study.graph.needed_for(chosen([*contents], share, seed)) if name in contents]
    _check_inputs(study, folder, needed, about)
    every = study.graph.needed_for((*needed,))
    lacking = [name for name in every if name not in values]
    if lacking:
        values |= unstated(study, lacking, about)
    with tempfile.TemporaryDirectory(prefix="bipedstudy-") as place:
        mine = dataclasses.replace(study, results=Path(place, "results"), settings=(), requested=(), cache=None,
                                   recordings=recordings)  # fmt: skip
        failed = _computed(mine, {name: values[name] for name in study.graph.stages if name in every}, jobs)
        for name in lacking:
            if (entry := mine.store.current(name)) is not None and not entry.refused:
                raise StudyError(f"{shown(folder)}: has no {name}.h5, where that stage does not say no, and so no "
                                 f"parameters for what {needed[-1]} needs")
        stages = [{"stage": name, "exactly": fingerprint.made_as_here(about[name]), "differences": [
            *other.get(name, []), *_held(mine, folder, name, contents[name], about[name], failed)]} for name in needed]
    return {"results": shown(folder), "seed": seed, "stages": stages, "of": len(contents),
            "differs": any(each["differences"] for each in stages)}  # fmt: skip


def _check_inputs(study: Study, folder: Path, names: Sequence[str], about: Mapping[str, Mapping[str, str]]) -> None:
    """Raise `StudyError` where an artefact was made without an input that its stage has in this study."""
    for name in names:
        had = json.loads(about[name][fingerprint.INGREDIENTS])["inputs"]
        for path in study.graph.stages[name].inputs:
            if not beneath(path, had):
                raise StudyError(f"{shown(folder)}/{name}.h5: was made without {path}, which that stage reads in "
                                 f"{shown(study.root)}: recompute it in a study that leaves it out too, as one that "
                                 "bipedstudy init lays out")


def chosen(names: Sequence[str], share: float, seed: int) -> tuple[str, ...]:
    """A share of the names, at least one, by chance."""
    return tuple(random.Random(seed).sample(list(names), max(1, round(share * len(names)))))


def _content(path: Path) -> bytes:
    from pipeline.room import reading

    content = reading.vetted(path, shown(path))
    check_links(content, shown(path))
    return content


def stated(
    study: Study, contents: Mapping[str, bytes]
) -> tuple[dict[str, Mapping[str, str]], dict[str, Any], dict[str, list[Row]]]:
    """Of each stage what its artefact says of its making, its parameters, and where two artefacts name one parameter
    with two values. Raises `StudyError` for parameters that are not those of this version.
    """
    from pipeline.cache import artefact

    classes = study.parameters_classes()
    about: dict[str, Mapping[str, str]] = {}
    values: dict[str, Any] = {}
    plains: dict[str, Plain] = {}
    for name, content in contents.items():
        about[name] = artefact.provenance(content, f"{name}.h5")
        try:
            plains[name] = json.loads(about[name][fingerprint.INGREDIENTS])["parameters"]
            values[name] = loading.from_plain(classes[name], plains[name])
        except (StudyError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise StudyError(f"{name}.h5: its parameters are not those of this version ({error})") from None
    other: dict[str, list[Row]] = {}
    for name, row in _contradictions(classes, plains):
        other.setdefault(name, []).append(row)
    return about, values, other


def unstated(study: Study, lacking: Sequence[str], about: Mapping[str, Mapping[str, str]]) -> dict[str, Any]:
    """Parameters of stages without an artefact, as those that said no: what the artefacts of others name of them, and
    the rest as the study at hand has it. Raises `StudyError`."""
    known = defaultdict[str, dict[str, Any]](dict)
    for each in about.values():
        for file, keys in json.loads(each[fingerprint.INGREDIENTS])["parameters"].items():
            known[file].update({key: value for key, value in keys.items()
                                if value is not None or key not in known[file]})
    found = {}
    for name, own in study.parameters(lacking).items():
        # the half width at hand belongs to the value at hand, not to one that an artefact names
        plain = {file: {key: known[file].get(key, value) for key, value in keys.items()
                        if key in known[file] or key.removesuffix(SUFFIX) not in known[file]}
                 for file, keys in loading.as_plain(own).items()}  # fmt: skip
        found[name] = loading.filled(type(own), plain)
    return found


def _contradictions(classes: Mapping[str, type], plains: Mapping[str, Plain]) -> Iterator[tuple[str, Row]]:
    """Parameters that two stages state with two values, with the later stage."""
    seen: dict[tuple[str, str], tuple[str, Any]] = {}
    for name, plain in plains.items():
        for file, key in ((file, key) for file, keys in plain.items() for key in keys):
            value = plain[file][key]
            first, said = seen.setdefault((file, key), (name, value))
            if value == said:
                continue
            whose = name if said is None else first
            if None in (value, said) and _follows(classes[whose], plains[whose], file, key):
                seen[file, key] = whose, plains[whose][file][key]
            else:
                yield name, _row(f"parameter {file}.{key}", value, said, f"as {first}.h5 has it")


def _follows(cls: type, plain: Plain, file: str, key: str) -> bool:
    """Whether a parameter is what null becomes in its place; a stage that needs it not may leave it null."""
    with contextlib.suppress(StudyError):
        null = {**plain, file: {**plain[file], key: None}}
        return loading.as_plain(loading.filled(cls, null)) == plain
    return False


def _computed(mine: Study, values: Mapping[str, Any], jobs: int | None) -> str:
    """Compute stages in a folder of their own; what failed, in a sentence."""
    for files in map(mine.named_files, values.values()):
        for place, _ in files.values():
            if mine.recordings is not None and not Path(place).resolve().is_relative_to(mine.recordings.resolve()):
                raise StudyError(f"{place}: a recording of these results, lies outside of {shown(mine.recordings)}")
    try:
        bring_up_to_date(mine, values, Display(), jobs=jobs or os.cpu_count() or 1)
    except StageFailed as error:
        return "; ".join(error.sentences)
    return ""


def _held(
    mine: Study, folder: Path, name: str, content: bytes, about: Mapping[str, str], failed: str
) -> Iterator[Row]:
    """Where a stage's files are not as they were computed here."""
    entry = mine.store.current(name)
    if entry is None or entry.refused:
        yield _row("", "a result", "none", entry.summary if entry else failed)
        return
    own = mine.graph.stages[name].artefact
    recomputed = disk.content(mine.store.place(own), own)
    exactly = fingerprint.made_as_here(about)
    yield from apart(content, recomputed, name, exactly)
    for path, out in entry.outs.items() if exactly else ():
        place = folder / path.removeprefix("results/")
        with contextlib.suppress(OSError):
            if path == own or disk.file_digest(place) == out.sha256:
                continue
        yield _row(path, "another file" if place.exists() else "no file", "a file", "not the same bytes")


def apart(theirs: bytes, recomputed: bytes, name: str, exactly: bool) -> Iterator[Row]:
    """Where two artefacts differ: in any number, word or attribute, or (not `exactly`) by more than is allowed."""
    import h5py

    from pipeline.cache import artefact

    with artefact.opened(theirs, f"{name}.h5") as one, artefact.opened(recomputed, f"{name}.h5") as other:
        skipped = (artefact.PROVENANCE,) if exactly else (artefact.PROVENANCE, artefact.CLOSER)
        both = [_items(each, skipped) for each in (one, other)]
        for path in sorted({*both[0], *both[1]}):
            here, there = (found.get(path) for found in both)
            if here is None or there is None or isinstance(here, h5py.Group) != isinstance(there, h5py.Group):
                yield _row(path, _kind(here), _kind(there), "")
                continue
            if exactly:
                yield from _attributes(path, here, there)
            if isinstance(here, h5py.Dataset):
                yield from _values(path, here, there, None if exactly else float(there.attrs.get(artefact.ERROR, 0.0)))


def _items(file: Any, skipped: Sequence[str]) -> dict[str, Any]:
    found = {"": file}
    file.visititems(found.__setitem__)
    return {path: item for path, item in found.items() if path.split("/")[0] not in skipped}


def _attributes(path: str, here: Any, there: Any) -> Iterator[Row]:
    for name in sorted({*here.attrs, *there.attrs} - {*_APART}):
        one, other = here.attrs.get(name), there.attrs.get(name)
        if one is None or other is None or not _same(one, other):
            yield _row(f"{path}@{name}", str(one), str(other), "")


def _values(path: str, here: Any, there: Any, error: float | None) -> Iterator[Row]:
    """What differs of two datasets: of numbers beyond an `error`, or (None) at all."""
    import numpy as np

    if here.shape != there.shape or here.dtype != there.dtype:
        yield _row(path, f"{here.shape} {here.dtype}", f"{there.shape} {there.dtype}", "another form")
        return
    if here.shape is None or _same(one := here[()], other := there[()]):
        return
    if here.dtype.kind not in "biuf":
        yield _row(path, str(np.ravel(one)[:1]), str(np.ravel(other)[:1]), "other words")
        return
    one, other = np.atleast_1d(one).astype(float), np.atleast_1d(other).astype(float)
    with np.errstate(invalid="ignore"):
        off = np.abs(one - other)
    off[~np.isfinite(off)] = np.inf
    off[((one != one) & (other != other)) | (one == other)] = 0.0
    finite = np.abs(other[np.isfinite(other)])
    allowed = 0.0 if error is None else max(error, ROUNDED * max(1.0, float(finite.max(initial=0.0))))
    place = np.unravel_index(int(off.argmax()), off.shape)
    if error is None or off[place] > allowed:
        yield {**_row(path, float(one[place]), float(other[place]), ""), "apart": float(off[place]), "allowed": allowed}


def _same(one: Any, other: Any) -> bool:
    """Whether two values have the same bits, or the same words."""
    import numpy as np

    first, second = np.asarray(one), np.asarray(other)
    if first.shape != second.shape or first.dtype != second.dtype:
        return False
    return first.tolist() == second.tolist() if first.dtype.kind in "OSU" else first.tobytes() == second.tobytes()


def _kind(item: Any) -> str:
    return "nothing" if item is None else f"a {type(item).__name__.lower()}"


def _row(path: str, theirs: Any, recomputed: Any, why: str) -> Row:
    return {"path": path, "theirs": theirs, "recomputed": recomputed, "why": why, "apart": None, "allowed": None}


def _lines(found: Row) -> Iterator[str]:
    for each in found["stages"]:
        how = "exactly" if each["exactly"] else "within errors, as it says that it was made on another kind of machine"
        rows = each["differences"]
        said = f"differs in {len(rows)} places" if rows else "the same"
        yield from layout.folded(f"{each['stage']:<{layout.STAGE}} {said} (compared {how})", layout.STAGE + 1)
        for row in rows[:_PRINTED]:
            by = "" if row["apart"] is None else f", apart by {row['apart']:.3g}, allowed {row['allowed']:.3g}"
            why = f" ({row['why']})" if row["why"] else ""
            yield from layout.folded(f"  {row['path']}: {row['theirs']}, recomputed {row['recomputed']}{by}{why}", 4)
        if len(rows) > _PRINTED:
            yield f"  and {len(rows) - _PRINTED} more, in --json"
    verdict = "differ" if found["differs"] else "are the same"
    yield from layout.folded(f"{len(found['stages'])} of {found['of']} stages were computed again, and {verdict} "
                             f"(seed {found['seed']})")  # fmt: skip
