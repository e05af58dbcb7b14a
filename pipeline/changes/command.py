"""`bipedstudy compare OTHER`: parameters, verdicts, numbers and pictures that changed since another results folder."""

from __future__ import annotations

import io
import re
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline import layout
from pipeline.cache import disk
from pipeline.commands import options
from pipeline.errors import ANSWER, StudyError
from pipeline.graph import CLAIMS, FIGURES
from pipeline.parameters import yaml_text
from pipeline.report.figures import differing, rms
from pipeline.report.page import address, template
from pipeline.study import Study, shown

if TYPE_CHECKING:
    import numpy as np

Row = dict[str, Any]
_RESULTS = "results/"
_TEMPLATE = Path(__file__).with_name("page.html")
#: Numbers that are printed (all are in --csv), and on the page; smaller ones, in their units, are round-off as a rule.
_PRINTED, _MOST, _ROUND_OFF = 12, 300, 1e-9
_NAMED = 5
#: Verdicts of 0.1.0, which had no words for them, and the number of a row in a path of its files.
_FIRST = {True: "holds", False: "does not hold", None: "open"}
_ROW = re.compile(r"/\d+/")


@click.command("compare", epilog=options.examples("compare"))
@click.argument("other", metavar="OTHER", type=click.Path(exists=True, file_okay=False, path_type=Path))
@options.own_study
@click.option("--tolerance", type=click.FloatRange(min=0), default=1e-9, show_default=True,
              help="Relative change of a number that counts as none.")
@click.option("--page", metavar="FILE", type=click.Path(dir_okay=False, path_type=Path),
              help="Write a page with all of it, and pictures side by side.")
@options.answers
def compare(study: Study, other: Path, tolerance: float, page: Path | None, form: options.Form) -> None:
    """Say what changed from the results in OTHER to those of the study: parameters, verdicts, numbers, figures.

    OTHER is a results folder or a study, also of an earlier version: then every number that both have is listed, and
    what cannot be compared is said. OTHER stays as it is. Ends with 0 if nothing changed and with 3 if something did,
    or could not be compared. --csv prints the numbers.
    """
    if page is not None:
        disk.replaceable(page)
    found = between(study, other, tolerance)
    if page is not None:
        disk.write(page, html(found))
    form.give(_lines(found), found, found["numbers"])
    if page is not None:
        click.echo(f"written: {shown(page)}", err=True)
    if found["changed"]:
        sys.exit(ANSWER)


def _lines(found: Row) -> Iterator[str]:
    for sentence in found["unread"]:
        yield from layout.folded(sentence)
    if not found["changed"]:
        small = f" ({found['smaller']} numbers changed by less)" if found["smaller"] else ""
        yield f"nothing changed from {found['before']} to {found['after']}{small}"
    if found["parameters"]:
        yield from layout.titled("Parameters", ("parameter", "before", "after"), [
            (row["key"], *("not there" if value is None else value for value in (row["before"], row["after"])))
            for row in found["parameters"]])  # fmt: skip
    if found["claims"]:
        turned = [(row["id"], row["before"] or "not judged", row["after"] or "not judged") for row in found["claims"]
                  if row["before"] != row["after"]]  # fmt: skip
        others = len(found["claims"]) - len(turned)
        title = f"Claims: {len(turned)} with another verdict, {others} more with other numbers"
        yield from layout.titled(title, ("claim", "before", "after"), turned)
    if found["numbers"]:
        yield from _numbers(found["numbers"], found["smaller"])
    if found["figures"]:
        yield from layout.titled(f"Figures: {len(found['figures'])} changed", ("figure", "what"),
                                 [(row["name"], row["what"]) for row in found["figures"]])  # fmt: skip


def _numbers(rows: list[Row], small: int) -> Iterator[str]:
    """How many changed in each stage, answers of yes or no, and those single ones that changed most."""
    many = Counter(row["stage"] for row in rows)
    single = [row for row in rows if row["relative"] is not None and isinstance(row["before"], (int, float))
              and max(abs(row["before"]), abs(row["after"])) > _ROUND_OFF]  # fmt: skip
    turned = [row for row in single if isinstance(row["before"], bool) and row["relative"]]
    listed = [*turned, *(row for row in single if not isinstance(row["before"], bool))]
    what = "single ones that changed most:" if listed else "all of them in arrays, words or round-off"
    counted = ", ".join(f"{stage} {count}" for stage, count in many.items())
    same = sum(row["relative"] == 0.0 for row in rows)
    title = (f"Numbers that both have: {len(rows)} ({counted}), {same} of them the same; {what}" if same
             else f"Numbers: {len(rows)} changed ({counted}), {small} by less; {what}")
    yield from ("", *layout.folded(title, 0))
    for row in listed[:_PRINTED]:
        yield f"  {row['stage']} {row['path']}"
        values = f"{layout.short(row['before'])} -> {layout.short(row['after'])} {row['unit']}".rstrip()
        part = share(row["relative"], row["before"])
        yield f"    {values}" + f" ({part})" * bool(part)


def share(relative: float | None, before: object) -> str:
    """A relative change in per cent, or why there is none; nothing for what is no number."""
    if relative is None or isinstance(before, bool):
        return ""
    if abs(relative) == float("inf"):
        return "from zero" if before == 0.0 else "not finite in one of them"
    return f"{100 * relative:+.3g} %"


def html(found: Row) -> bytes:
    """The page, with pictures side by side; self-contained like the report."""
    folders = [Path(found[side]) / FIGURES.removeprefix(_RESULTS) for side in ("before", "after")]
    pictures = [(row["name"], row["what"], *(address(disk.read(folder / f"{row['name']}.png")) for folder in folders))
                for row in found["figures"]]  # fmt: skip
    page = template(_TEMPLATE).render(found=found, most=_MOST, share=share, short=layout.short, pictures=pictures)
    return page.encode()


def results_of(path: Path) -> Path:
    """The results folder that is meant: the folder itself, or `results` in it. Raises `StudyError`."""
    for folder in (path, path / "results"):
        if folder.is_dir() and next(folder.glob("*.h5"), None) is not None:
            return folder
    raise StudyError(f"{shown(path)}: there are no results there (a folder with the stages' .h5 files)")


def between(study: Study, other: Path, tolerance: float) -> Row:
    """What changed from the results in `other` to those of the study, as plain values. Raises `StudyError`.

    Rows by name, with None for what is not there on one side: `parameters` (key, before, after, stages), `claims` (id;
    before, after: the verdict; measured_before, measured_after: its words), `numbers` (stage, path, unit, before,
    after; relative: the change as a share of what it was, of an array the largest as a share of its largest value, None
    for what is no number), `figures` (name, what, rms over its pixels in grey levels of 255). `unread` are sentences on
    what could not be compared; `smaller` counts numbers that changed by no more than `tolerance`, which have no row;
    `changed` shows whether there is anything of all this.
    """
    before, after = results_of(other), results_of(study.results)
    if before.resolve() == after.resolve():
        raise StudyError(f"{shown(other)}: these are the results themselves; name others")
    by_key: dict[tuple[str, str | None, str | None], list[str]] = {}
    every: list[Row] = []
    unread: list[str] = []
    missing: dict[Path, list[str]] = {}
    older = False
    for stage in study.graph.stages.values():
        name = stage.artefact.removeprefix(_RESULTS)
        lacking = [folder for folder in (before, after) if not (folder / name).exists()]
        if len(lacking) == 1:
            missing.setdefault(lacking[0], []).append(stage.name)
        if lacking:
            continue
        older |= _compare(stage.name, before / name, after / name, by_key, every, unread)
    unread += [f"not compared, as {shown(folder)} has no result of: {', '.join(names)}"
               for folder, names in missing.items()]  # fmt: skip
    unread += [f"not compared, as this study has no such stage: {name}"
               for name in sorted({path.stem for path in before.glob("*.h5")} - {*study.graph.stages})]  # fmt: skip
    judged = _claims(before, after, unread)
    least = -1.0 if older else tolerance  # every number that both have
    large = [row for row in every if row["relative"] is None or abs(row["relative"]) > least]
    found = {
        "before": shown(before), "after": shown(after),
        "parameters": [{"key": key, "before": was, "after": now, "stages": stages}
                       for (key, was, now), stages in by_key.items()],
        "claims": judged,
        "numbers": sorted(large, key=lambda row: -abs(row["relative"] or 0.0)), "smaller": len(every) - len(large),
        "figures": _figures(before, after), "unread": unread,
    }  # fmt: skip
    return {**found, "changed": any(found[name] for name in ("parameters", "claims", "numbers", "figures", "unread"))}


def _compare(stage: str, before: Path, after: Path, by_key: dict[tuple[str, str | None, str | None], list[str]],
             every: list[Row], unread: list[str]) -> bool:  # fmt: skip
    """Add what differs between two artefacts of a stage; of one of an earlier form, which is noted, all that both have.

    Raises `StudyError`; that one is no artefact is added to what is `unread`.
    """
    from pipeline.cache import artefact
    from pipeline.room import reading

    names = shown(before), shown(after)
    old, new = reading.vetted(before, names[0]), reading.vetted(after, names[1])
    if old == new:
        return False
    alone: dict[str, list[str]] = {"before": [], "after": []}
    try:
        older = artefact.is_older(old, names[0])
        for change in parameters(artefact.provenance(old, names[0], older), artefact.provenance(new, names[1])):
            by_key.setdefault(change, []).append(stage)
        for row in changes(stage, old, new, names, older):
            side = row.pop("alone")
            if older and side:
                alone[side].append(row["path"])
            else:
                every.append(row)
    except StudyError as error:
        unread.append(f"stage {stage}: {'; '.join(error.sentences)}")
        return False
    for where, paths in zip(names, alone.values()):
        some = ", ".join(paths[:_NAMED]) + (f" and {len(paths) - _NAMED} more" if len(paths) > _NAMED else "")
        if paths:
            unread.append(f"not compared, as in {where} alone or in another unit: {some}")
    return older


def _claims(before: Path, after: Path, unread: list[str]) -> list[Row]:
    """Claims whose verdict or measured words changed, those with another verdict first.

    None where one side has judged none: that its stage has no result there is reported by itself.
    """
    paths = [folder / CLAIMS.removeprefix(_RESULTS) for folder in (before, after)]
    if not all(path.exists() for path in paths):
        return []
    try:
        one, other = map(_judged, paths)
    except StudyError as error:
        unread.append(str(error))
        return []
    found = []
    for key in dict.fromkeys((*other, *one)):
        (was, words), (now, new_words) = one.get(key, (None, "")), other.get(key, (None, ""))
        if (was, words) != (now, new_words):
            found.append({"id": key, "before": was, "after": now, "measured_before": words,
                          "measured_after": new_words})  # fmt: skip
    turned = [row for row in found if row["before"] != row["after"]]
    return [*turned, *(row for row in found if row not in turned)]


def _judged(path: Path) -> dict[str, tuple[str, str]]:
    """Verdict and measured words of each claim in a file of this version or an earlier one. Raises `StudyError`."""
    plain = yaml_text.read(path, shown(path)).plain()
    found = {}
    try:
        for claim in plain["claims"] if isinstance(plain, dict) else plain:
            verdict = claim["verdict"] if "verdict" in claim else _FIRST[claim["holds"]]
            beside = claim.get("beside") and f"({claim['beside']})"
            words = " ".join(filter(None, (verdict, claim.get("condition"), beside)))
            found[claim["id"]] = words, claim.get("measured", claim.get("found", ""))
    except (TypeError, KeyError, AttributeError):
        raise StudyError(f"{shown(path)}: its claims are not of a form that can be compared") from None
    return found


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


def changes(stage: str, before: bytes, after: bytes, names: tuple[str, str], older: bool = False) -> Iterator[Row]:
    """Every field that differs between two artefacts' bytes; if the first is `older`, every field.

    `alone` is the side that alone has it, or has it in this unit. Raises `StudyError`; `names` are the files'.
    """
    one, other = _fields(before, names[0], older), _fields(after, names[1], False)
    for path in dict.fromkeys((*one, *other)):
        (was, unit), (now, new_unit) = one.get(path, (None, "")), other.get(path, (None, ""))
        alone = "" if path in one and path in other and unit == new_unit else "before" if path in one else "after"
        change = _change(was, now)
        if change is None and older:
            change = _shown(was), _shown(now), 0.0
        if change is not None:
            yield {"stage": stage, "path": path.replace("/", "."), "unit": new_unit or unit, "alone": alone,
                   **dict(zip(("before", "after", "relative"), change))}  # fmt: skip


def _fields(content: bytes, name: str, older: bool) -> dict[str, tuple[Any, str]]:
    """Value and unit of each field by its path; the numbered rows of the first form's tables become columns."""
    import h5py
    import numpy as np

    from pipeline.cache import artefact

    with h5py.File(io.BytesIO(content), "r") as file:
        found = {field.path: (_value(file[field.path]), field.shown_unit)
                 for field in artefact.tree(content, name, older) if field.shape is not None}  # fmt: skip
    columns: dict[str, list[str]] = {}
    for path in found if older else ():
        if _ROW.search(path):
            columns.setdefault(_ROW.sub("/", path), []).append(path)
    for column, rows in columns.items():
        cells = [np.asarray(np.nan) if found[row][0] is None else found[row][0] for row in rows]
        if len({cell.shape for cell in cells}) == 1:
            found[column] = np.stack(cells), found[rows[0]][1]
            for row in rows:
                del found[row]
    return found


def _value(item: Any) -> Any:
    """An array, or a scalar's value; None where there is none."""
    import numpy as np

    from pipeline.cache import hdf5

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
    import numpy as np

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
