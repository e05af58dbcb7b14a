"""What changed between two results folders of a study: parameters, verdicts, numbers, pictures."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pipeline.cache import artefact, disk, hdf5
from pipeline.commands import claims
from pipeline.errors import ArtefactError, StudyError
from pipeline.graph import CLAIMS, FIGURES
from pipeline.report.figures import differing, rms
from pipeline.study import Study, shown

_RESULTS = "results/"


@dataclass(frozen=True)
class Parameter:
    """A parameter of some stages: value before and after, None where no stage there has it."""

    key: str
    before: str | None
    after: str | None
    stages: tuple[str, ...]


@dataclass(frozen=True)
class Verdict:
    """A claim whose verdict or numbers changed; a verdict is None where the claim is not judged there."""

    id: str
    before: str | None
    after: str | None
    measured_before: str
    measured_after: str

    @property
    def turned(self) -> bool:
        """Whether the verdict is another one."""
        return self.before != self.after


@dataclass(frozen=True)
class Picture:
    """A figure that differs: rms over its pixels in grey levels of 255; None where it is in one folder only."""

    name: str
    what: str
    rms: float | None
    before: Path
    after: Path


@dataclass(frozen=True)
class Change:
    """A field of a stage: before, after (None where it is not there), its unit, and the relative change.

    The change of a number is a share of what it was. Of an array it is the largest, as a share of its largest value;
    before and after are then words. What is no number has no relative change.
    """

    stage: str
    path: str
    unit: str
    before: Any
    after: Any
    relative: float | None


@dataclass(frozen=True)
class Changes:
    """All that changed from the folder `before` to `after`. `unread` are sentences on what could not be compared.

    `small` counts the numbers that changed by no more than was asked for; they are no longer among `numbers`.
    """

    before: Path
    after: Path
    parameters: list[Parameter] = field(default_factory=list)
    claims: list[Verdict] = field(default_factory=list)
    numbers: list[Change] = field(default_factory=list)
    small: int = 0
    figures: list[Picture] = field(default_factory=list)
    unread: list[str] = field(default_factory=list)

    @property
    def any(self) -> bool:
        """Whether anything changed, or could not be compared."""
        return bool(self.parameters or self.claims or self.numbers or self.figures or self.unread)


def results_of(path: Path) -> Path:
    """The results folder that is meant: the folder itself, or `results` in it. Raises `StudyError`."""
    for folder in (path, path / "results"):
        if folder.is_dir() and next(folder.glob("*.h5"), None) is not None:
            return folder
    raise StudyError(f"{shown(path)}: there are no results there (a folder with the stages' .h5 files)")


def between(study: Study, other: Path, tolerance: float) -> Changes:
    """What changed from the results in `other` to those of the study. Raises `StudyError`."""
    before, after = results_of(other), results_of(study.results)
    if before.resolve() == after.resolve():
        raise StudyError(f"{shown(other)}: these are the results themselves; name others")
    by_key: dict[tuple[str, str | None, str | None], list[str]] = {}
    every: list[Change] = []
    unread: list[str] = []
    missing: dict[Path, list[str]] = {}
    for stage in study.graph.stages.values():
        name = stage.artefact.removeprefix(_RESULTS)
        lacking = [folder for folder in (before, after) if not (folder / name).exists()]
        if len(lacking) == 1:
            missing.setdefault(lacking[0], []).append(stage.name)
        if lacking:
            continue
        try:
            _compare(stage.name, before / name, after / name, by_key, every)
        except ArtefactError as error:
            unread.append(f"stage {stage.name}: {'; '.join(error.sentences)}")
    unread += [f"not compared, as {shown(folder)} has no result of: {', '.join(names)}"
               for folder, names in missing.items()]  # fmt: skip
    large = [change for change in every if change.relative is None or abs(change.relative) > tolerance]
    return Changes(
        before, after,
        parameters=[Parameter(*change, tuple(stages)) for change, stages in by_key.items()],
        claims=_claims(before, after),
        numbers=sorted(large, key=lambda change: -abs(change.relative or 0.0)), small=len(every) - len(large),
        figures=_figures(before, after),
        unread=unread,
    )  # fmt: skip


def _compare(stage: str, before: Path, after: Path, by_key: dict[tuple[str, str | None, str | None], list[str]],
             every: list[Change]) -> None:  # fmt: skip
    """Add what differs between two artefacts of a stage. Raises `StudyError`, `ArtefactError` if one is unreadable."""
    names = shown(before), shown(after)
    old, new = disk.content(before, names[0]), disk.content(after, names[1])
    if old == new:
        return
    for change in parameters(artefact.provenance(old, names[0]), artefact.provenance(new, names[1])):
        by_key.setdefault(change, []).append(stage)
    every += changes(stage, old, new, names)


def _claims(before: Path, after: Path) -> list[Verdict]:
    """Claims whose verdict or measured words changed, those with another verdict first.

    None where one side has judged none: that its stage has no result there is told by itself.
    """
    name = CLAIMS.removeprefix(_RESULTS)
    if not all((folder / name).exists() for folder in (before, after)):
        return []
    one, other = ({claim.id: claim for claim in claims.read_file(folder / name).claims} for folder in (before, after))
    found = []
    for key in dict.fromkeys((*other, *one)):
        old, new = one.get(key), other.get(key)
        verdicts = old.full_verdict if old else None, new.full_verdict if new else None
        measured = old.measured if old else "", new.measured if new else ""
        if verdicts[0] != verdicts[1] or measured[0] != measured[1]:
            found.append(Verdict(key, *verdicts, *measured))
    return sorted(found, key=lambda verdict: not verdict.turned)


def _figures(before: Path, after: Path) -> list[Picture]:
    """Pictures with other pixels, those that differ most first, then those that are in one folder only.

    None where one side has drawn none.
    """
    folder = FIGURES.removeprefix(_RESULTS)
    found: list[Picture] = []
    if all(any((each / folder).glob("*")) for each in (before, after)):
        for name, *contents in differing(before / folder, after / folder):
            one, other = before / folder / name, after / folder / name
            size: float | None = None
            if one.suffix not in (".png", ".html"):
                continue
            if None in contents:
                what = "is new" if contents[0] is None else "is no longer there"
            elif one.suffix == ".html":
                what = "has other data"
            else:
                size = rms(one, other)
                what = "has another size" if size == float("inf") else f"differs by {size:.2g} of 255 rms"
            if size != 0.0:
                found.append(Picture(one.stem, what, size, one, other))
    return sorted(found, key=lambda picture: -(picture.rms or 0.0))


def parameters(before: Mapping[str, str], after: Mapping[str, str]) -> Iterator[tuple[str, str | None, str | None]]:
    """File.key, value before and after, of those that differ, from what two artefacts say of their making."""
    one, other = (dict(line.split(" = ", 1) for line in about.get("parameters", "").splitlines() if " = " in line)
                  for about in (before, after))  # fmt: skip
    for key in dict.fromkeys((*one, *other)):
        if one.get(key) != other.get(key):
            yield key, one.get(key), other.get(key)


def changes(stage: str, before: bytes, after: bytes, names: tuple[str, str]) -> Iterator[Change]:
    """Every field that differs between two artefacts' bytes. Raises `ArtefactError`; `names` are those of the files."""
    one, other = ({field.path: field for field in artefact.tree(content, name) if field.shape is not None}
                  for content, name in zip((before, after), names))  # fmt: skip
    with h5py.File(io.BytesIO(before), "r") as old, h5py.File(io.BytesIO(after), "r") as new:
        for path in dict.fromkeys((*one, *other)):
            unit = (other.get(path) or one[path]).unit
            values_of = [_value(file[path]) if path in known else None
                         for file, known in ((old, one), (new, other))]  # fmt: skip
            change = _change(*values_of)
            if change is not None:
                yield Change(stage, path, "" if unit in ("1", "-") else unit, *change)


def _value(item: Any) -> Any:
    """An array, or a scalar's value; None where there is none."""
    if item.shape is None or (not item.shape and hdf5.NONE in item.attrs):
        return None
    return np.asarray(hdf5.read(item))


def _change(before: Any, after: Any) -> tuple[Any, Any, float | None] | None:
    """Before and after as they are shown, and the relative change; None if nothing changed."""
    if before is None or after is None:
        return None if before is after else (_shown(before), _shown(after), None)
    numbers = before.dtype.kind in "biuf" and after.dtype.kind in "biuf"
    if before.shape != after.shape or not numbers:
        same = before.shape == after.shape and bool((before == after).all())
        return None if same else (_shown(before), _shown(after), None)
    return _apart(before, after)


def _apart(before: np.ndarray, after: np.ndarray) -> tuple[Any, Any, float | None] | None:
    """The same for numbers or arrays of one shape."""
    one, other = before.astype(float), after.astype(float)
    if np.array_equal(one, other, equal_nan=True):
        return None
    if not one.shape:
        finite = one != 0.0 and np.isfinite(one) and np.isfinite(other)
        return before.item(), after.item(), float((other - one) / abs(one)) if finite else np.inf
    size = np.abs(np.concatenate([each[np.isfinite(each)].ravel() for each in (one, other)])).max(initial=0.0)
    changed = (one != other) & ~(np.isnan(one) & np.isnan(other))
    apart = np.abs(other[changed] - one[changed])
    largest = float(apart.max()) if np.isfinite(apart).all() else np.inf
    return _shown(before), f"differs by {largest:.3g} at most", largest / float(size) if size else np.inf


def _shown(value: Any) -> Any:
    if value is None:
        return None
    if value.shape:
        return f"array {' x '.join(map(str, value.shape))}"
    return value.item() if hasattr(value.item(), "__float__") else str(value.item())


def plain(found: Changes) -> dict[str, Any]:
    """Everything as plain values, for JSON."""
    return {
        "before": shown(found.before),
        "after": shown(found.after),
        "parameters": [asdict(each) for each in found.parameters],
        "claims": [asdict(each) for each in found.claims],
        "numbers": [{**asdict(each), "path": each.path.replace("/", ".")} for each in found.numbers],
        "smaller": found.small,
        "figures": [{"name": each.name, "what": each.what, "rms": each.rms} for each in found.figures],
        "unread": found.unread,
    }  # fmt: skip
