"""What changed between two results folders of a study: parameters, verdicts, numbers, pictures."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pipeline.cache import artefact, disk
from pipeline.cache.hdf5 import values
from pipeline.commands import claims
from pipeline.errors import ArtefactError, StudyError
from pipeline.graph import CLAIMS, FIGURES
from pipeline.report.figures import differing, rms
from pipeline.study import Study, shown

_RESULTS = "results/"
Row = dict[str, Any]


@dataclass(frozen=True)
class Changes:
    """All that changed from the folder `before` to `after`, as rows; None is what is not there on one side.

    `parameters`: key, before, after, stages. `claims`, whose verdict (before, after) or words (measured_before,
    measured_after) changed: id. `numbers`: stage, path, unit, before, after and relative change, as a share of what it
    was; of an array the largest, as a share of its largest value, with words before and after; None for what is no
    number. `figures`: name, what, rms over its pixels in grey levels of 255. `unread` are sentences on what could not
    be compared. `small` counts the numbers that changed by no more than was asked for; they are not among `numbers`.
    """

    before: Path
    after: Path
    parameters: list[Row] = field(default_factory=list)
    claims: list[Row] = field(default_factory=list)
    numbers: list[Row] = field(default_factory=list)
    small: int = 0
    figures: list[Row] = field(default_factory=list)
    unread: list[str] = field(default_factory=list)

    @property
    def any(self) -> bool:
        """Whether anything changed, or could not be compared."""
        return bool(self.parameters or self.claims or self.numbers or self.figures or self.unread)

    @property
    def turned(self) -> list[Row]:
        """The claims with another verdict."""
        return [claim for claim in self.claims if claim["before"] != claim["after"]]

    def plain(self) -> Row:
        """Everything as plain values, for JSON."""
        return {
            "before": shown(self.before), "after": shown(self.after), "parameters": self.parameters,
            "claims": self.claims, "numbers": self.numbers, "smaller": self.small, "figures": self.figures,
            "unread": self.unread, "changed": self.any,
        }  # fmt: skip


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
    every: list[Row] = []
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
    large = [row for row in every if row["relative"] is None or abs(row["relative"]) > tolerance]
    return Changes(
        before, after,
        [{"key": key, "before": was, "after": now, "stages": stages} for (key, was, now), stages in by_key.items()],
        _claims(before, after), sorted(large, key=lambda row: -abs(row["relative"] or 0.0)), len(every) - len(large),
        _figures(before, after), unread,
    )  # fmt: skip


def _compare(stage: str, before: Path, after: Path, by_key: dict[tuple[str, str | None, str | None], list[str]],
             every: list[Row]) -> None:  # fmt: skip
    """Add what differs between two artefacts of a stage. Raises `StudyError`, `ArtefactError` if one is unreadable."""
    names = shown(before), shown(after)
    old, new = disk.content(before, names[0]), disk.content(after, names[1])
    if old == new:
        return
    for change in parameters(artefact.provenance(old, names[0]), artefact.provenance(new, names[1])):
        by_key.setdefault(change, []).append(stage)
    every += changes(stage, old, new, names)


def _claims(before: Path, after: Path) -> list[Row]:
    """Claims whose verdict or measured words changed, those with another verdict first.

    None where one side has judged none: that its stage has no result there is told by itself.
    """
    paths = [folder / CLAIMS.removeprefix(_RESULTS) for folder in (before, after)]
    if not all(path.exists() for path in paths):
        return []
    one, other = ({claim.id: (claim.full_verdict, claim.measured) for claim in claims.read_file(path).claims}
                  for path in paths)  # fmt: skip
    found = []
    for key in dict.fromkeys((*other, *one)):
        (was, words), (now, new_words) = one.get(key, (None, "")), other.get(key, (None, ""))
        if (was, words) != (now, new_words):
            found.append({"id": key, "before": was, "after": now, "measured_before": words,
                          "measured_after": new_words})  # fmt: skip
    return sorted(found, key=lambda row: row["before"] == row["after"])


def _figures(before: Path, after: Path) -> list[Row]:
    """Pictures with other pixels, those that differ most first, then those that are in one folder only.

    None where one side has drawn none.
    """
    one, other = (folder / FIGURES.removeprefix(_RESULTS) for folder in (before, after))
    found: list[Row] = []
    for name, *contents in differing(one, other) if all(any(each.glob("*")) for each in (one, other)) else ():
        size: float | None = None
        if not name.endswith((".png", ".html")):
            continue
        if None in contents:
            what = "is new" if contents[0] is None else "is no longer there"
        elif name.endswith(".html"):
            what = "has other data"
        else:
            size = rms(one / name, other / name)
            what = "has another size" if size == float("inf") else f"differs by {size:.2g} of 255 rms"
        if size != 0.0:
            found.append({"name": Path(name).stem, "what": what, "rms": size})
    return sorted(found, key=lambda row: -(row["rms"] or 0.0))


def parameters(before: Mapping[str, str], after: Mapping[str, str]) -> Iterator[tuple[str, str | None, str | None]]:
    """File.key, value before and after, of those that differ, from what two artefacts say of their making."""
    one, other = (dict(line.split(" = ", 1) for line in about.get("parameters", "").splitlines() if " = " in line)
                  for about in (before, after))  # fmt: skip
    for key in dict.fromkeys((*one, *other)):
        if one.get(key) != other.get(key):
            yield key, one.get(key), other.get(key)


def changes(stage: str, before: bytes, after: bytes, names: tuple[str, str]) -> Iterator[Row]:
    """Every field that differs between two artefacts' bytes. Raises `ArtefactError`; `names` are those of the files."""
    one, other = ({field.path: field for field in artefact.tree(content, name) if field.shape is not None}
                  for content, name in zip((before, after), names))  # fmt: skip
    with h5py.File(io.BytesIO(before), "r") as old, h5py.File(io.BytesIO(after), "r") as new:
        for path in dict.fromkeys((*one, *other)):
            unit = (other.get(path) or one[path]).unit
            change = _change(*(_value(file[path]) if path in known else None
                               for file, known in ((old, one), (new, other))))  # fmt: skip
            if change is not None:
                yield {"stage": stage, "path": path.replace("/", "."), "unit": "" if unit in ("1", "-") else unit,
                       **dict(zip(("before", "after", "relative"), change))}  # fmt: skip


def _value(item: Any) -> Any:
    """An array, or a scalar's value; None where there is none."""
    if item.shape is None or (not item.shape and values.NONE in item.attrs):
        return None
    return np.asarray(values.read(item))


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
