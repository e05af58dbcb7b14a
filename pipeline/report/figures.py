"""`bipedstudy figures`: what is drawn, figures drawn from the artefacts as they lie there, folders of them compared."""

import contextlib
import csv
import io
import math
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from pipeline import completion
from pipeline.cache import disk, fingerprint, processor
from pipeline.commands import options, status
from pipeline.errors import FAILED, Declined, StudyError, is_answer, nearest
from pipeline.execution import display
from pipeline.graph import FIGURES, Stage
from pipeline.parameters import loading
from pipeline.study import Study, shown

#: Largest rms difference of two pictures, in grey levels of 255, called the same. A change of a figure's data by 1e-3
#: gives at least three times as much (tests/figures/test_golden.py); a single thin curve changed so may give less.
TOLERANCE = 0.25
#: Largest relative difference of two numbers of a figure called the same, and the part of a curve's largest number that
#: counts as nothing.
NUMBERS, _NOTHING = 1e-3, 1e-6
Row = dict[str, Any]
_NO_CAPTION = "No caption: what is drawn was not computed together, so it is no comparison."


@click.command("figures", epilog=options.examples("figures"))
@click.argument("names", nargs=-1, metavar="NAME...", shell_complete=completion.figures)
@options.own_study
@click.option(
    "--into",
    metavar="DIR",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder for figures that are named (default: results/drawn; results/figures are the stage's own).",
)
@click.option("--check", is_flag=True, help="Draw anew from the artefacts and compare; exit with 1 if they differ.")
@click.option(
    "--against",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Compare with the figures in DIR (default: results/figures).",
)
@click.option(
    "--tolerance",
    type=click.FloatRange(min=0),
    help=f"Largest rms difference of pixels, in grey levels of 255 (default: {TOLERANCE:g}, or none at all for figures "
    "made by such a processor and by such versions as there are here).",
)
@click.option("--exact", is_flag=True, help="Any other byte is a difference, also in PDF.")
@options.answers_without_rows
def figures(
    study: Study, names: tuple[str, ...], into: Path | None, check: bool, against: Path | None,
    tolerance: float | None, exact: bool, form: options.Form,
) -> None:  # fmt: skip
    """Draw the figures that are named, in seconds and from the artefacts alone; the beginning of a name is enough.

    Without names list all figures, or with --check draw them anew and compare; results/figures are not drawn anew where
    they are current and compared with others. Pictures that different versions of Matplotlib drew are compared by the
    numbers beside them. Differences are drawn into results/differences.
    """
    if names:
        if check or against or exact:
            raise click.UsageError("--check, --against and --exact are for all figures: give no names")
        _draw_named(study, names, into or study.results / "drawn", form)
        return
    expected = against or study.store.place(FIGURES)
    if not expected.is_dir():
        raise StudyError(f"{shown(expected)} is not there yet; make it with: bipedstudy run-all")
    present = sorted(path.name for path in expected.iterdir() if not path.name.startswith("."))
    if against is None:
        status.say(study, *study.graph.needed_for((study.graph.maker(FIGURES),)))
    if not check:
        files = [shown(expected / name) for name in present]
        form.give(files, {"files": files})
        return
    how, exact = _strictness(study, exact, tolerance, against)
    allowed, kept = TOLERANCE if tolerance is None else tolerance, study.results / "differences"
    if against is not None and _are_current(study):
        found = compare(expected, study.store.place(FIGURES), kept, allowed)
    else:
        found = _drawn_anew(study, expected, present, kept, allowed)
    _report(found, len(present), how, exact, form)


def _draw_named(study: Study, names: Iterable[str], folder: Path, form: options.Form) -> None:
    """Draw the figures whose names begin so, and show each with its caption and what is said of its results."""
    noted, plain, declined = {""}, [], None
    try:
        for files, caption, said in draw(study, names, folder):
            if said not in noted:
                status.echo(said)
            noted.add(said)
            plain.append({"files": list(map(shown, files)), "caption": caption, "said": said})
            if form.is_text:
                form.give([*map(shown, files), caption], {})
    except Declined as error:  # those that can be drawn are reported first
        declined = error
    if not form.is_text:
        form.give((), {"figures": plain})
    if declined:
        raise declined


def _are_current(study: Study) -> bool:
    """Whether results/figures are there as they would be drawn now."""
    standing = status.Standing(study, (study.graph.maker(FIGURES),))
    return not (standing.found or standing.doubt) and study.store.place(FIGURES).is_dir()


def _drawn_anew(
    study: Study, expected: Path, present: Sequence[str], kept: Path, tolerance: float
) -> list[Row]:
    """Draw all figures anew beside a display, and compare them with those in `expected`, whose names are `present`."""
    shows, count = display.for_terminal(False, False), len({Path(name).stem for name in present})
    with tempfile.TemporaryDirectory(prefix="bipedstudy-") as folder:
        try:
            with contextlib.suppress(Declined):  # what is there and is not drawn is reported below
                for number, _ in enumerate(draw(study, [""], Path(folder), marked=False), 1):
                    shows.points(min(number, count), max(count, 1), f"{number} figures drawn")
        finally:
            shows.close()
        return compare(expected, Path(folder), kept, tolerance)


def _report(found: Sequence[Row], count: int, how: str, exact: bool, form: options.Form) -> None:
    """Tell what differs of `count` files, and end with 1 if some of it is beyond what is allowed."""
    differ = [{**one, "fails": one["fails"] or exact, "picture": one["picture"] and shown(one["picture"])}
              for one in found]  # fmt: skip
    lines = [f"{one['name']} {one['what']}" + (f"; see {one['picture']}" if one["picture"] else "") for one in differ]
    failed = sum(one["fails"] for one in differ)
    form.give([*lines, f"{count} files, {len(differ)} differ, {failed} of them beyond what is allowed: {how}"],
              {"files": count, "differ": differ, "compared": how})
    if failed:
        sys.exit(FAILED)


def _strictness(study: Study, exact: bool, tolerance: float | None, against: Path | None) -> tuple[str, bool]:
    """How figures are compared, in words, and whether byte by byte: as they were made here, or as it was requested."""
    if exact or tolerance is not None:
        return f"{'byte by byte' if exact else f'{tolerance:g} of 255 rms'}, as requested", exact
    allowed = f"{TOLERANCE:g} of 255 rms"
    if against is not None:
        return f"{allowed}, as nothing shows what processor made those in {shown(against)}", False
    place = study.store.place(study.graph.stages[study.graph.maker(FIGURES)].artefact)
    if not place.exists():
        return f"{allowed}, as {shown(place)} is not there to show what made them", False
    about = study.provenance(place)
    if fingerprint.made_as_here(about):
        return "byte by byte, as they were made by such a processor and such versions as there are here", True
    made, here = about.get("processor", "an unknown processor"), processor.words()
    return f"{allowed}, as they were made by {made if made != here else 'other versions'}, and here is {here}", False


def draw(
    study: Study, requested: Iterable[str], folder: Path, *, marked: bool = True
) -> Iterator[tuple[list[Path], str, str]]:
    """Draw every figure whose name begins with one of `requested` into `folder`; gives files and caption of each, and
    what is to be said of the results it shows, which stands in the picture too where that is to be `marked`.

    Reads only the results that these figures name, and draws with the parameters that these were made with. Raises
    `StudyError` for an unknown figure, for a missing or foreign artefact, and if no stage makes results/figures or the
    one that does draws them only together. Raises `Declined` after all others for those that cannot be drawn for a
    reason.
    """
    stage, drawn = _register(study)
    places = {Path(path).stem: path for path in reversed(stage.inputs)}
    chosen = [name for each in requested for name in _chosen(each, drawn.NAMES)]
    shows = {name: _makers(study, [places[key] for key in drawn.figure(name).inputs if key in places])
             for name in chosen}  # fmt: skip
    values = study.parameters((stage.name,))[stage.name]
    surveyed = status.Standing(study, set().union(*shows.values())) if marked else None
    refused = []
    for name, makers in shows.items():
        said = surveyed.sentence(makers) if surveyed else ""
        about = drawn.figure(name)
        without = getattr(about, "without", ())
        if left_out := [key for key in about.inputs if key not in places and key not in without]:
            refused.append(f"{name} is not drawn: this study's dvc.yaml leaves {left_out[0]} out of what stage "
                           f"{stage.name} reads")  # fmt: skip
            continue
        try:
            results = {key: _result(study, places[key]) for key in about.inputs
                       if key in places and (key not in without or not _refused(study, places[key]))}  # fmt: skip
            files, caption = drawn.draw(name, _parameters(study, values, makers), results, said)
        except Exception as error:
            if not is_answer(error, study.package):
                raise
            refused.append(f"{name} is not drawn: {error}")
            continue
        caption = caption if status.together(study, makers) else _NO_CAPTION
        yield _written(files, folder), caption, said
    if refused:
        raise Declined(refused)


def _makers(study: Study, paths: Iterable[str]) -> tuple[str, ...]:
    """The stages that make some results, each once."""
    return tuple(dict.fromkeys(map(study.graph.maker, paths)))


def _written(files: Mapping[str, bytes], folder: Path) -> list[Path]:
    """Where in `folder` the files of a figure now lie."""
    contents = {folder / Path(path).name: content for path, content in files.items()}
    for path, content in contents.items():
        disk.write(path, content)
    return list(contents)


def _register(study: Study) -> tuple[Stage, Any]:
    """The stage that makes results/figures, and its module that can draw each alone."""
    stage = next((stage for stage in study.graph.stages.values() if FIGURES in stage.outs), None)
    if stage is None:
        raise StudyError(f"dvc.yaml: no stage lists {FIGURES} among its outs")
    drawn = study.module(stage.name, "drawn")
    if drawn is None:
        raise StudyError(f"stage {stage.name} has no module drawn: it draws its figures only together")
    return stage, drawn


def _chosen(requested: str, names: tuple[str, ...]) -> list[str]:
    chosen = [name for name in names if name.startswith(requested)]
    if not chosen:
        hint = nearest(requested, [*names, *(name[: len(requested) + 1] for name in names)])
        raise StudyError(f'there is no figure "{requested}" (figures: {", ".join(names)}){hint}')
    return [requested] if requested in chosen else chosen


def _parameters(study: Study, values: Any, makers: Sequence[str]) -> Any:
    """What a figure is drawn with: the parameters of the results it shows, and of `values` the drawing's own."""
    plain = loading.as_plain(values)
    for entry in filter(None, (status.made_by(study, name) for name in reversed(makers))):
        for file, own in plain.items():
            own |= {key: value for key, value in entry.ingredients["parameters"].get(file, {}).items() if key in own}
    return loading.from_plain(type(values), plain)


def _refused(study: Study, path: str) -> bool:
    """Whether the stage of a result said no."""
    entry = study.store.current(study.graph.maker(path))
    return entry is not None and entry.refused


def _result(study: Study, path: str) -> Any:
    """What a figure is handed of a result: of an artefact its content, of another file its place."""
    return study.result(Path(path).stem, "run-all") if path.endswith(".h5") else study.there(path, "run-all")


def differing(one: Path, other: Path) -> Iterator[tuple[str, bytes | None, bytes | None]]:
    """Name, and content in either folder (None where there is none), of every file that is not the same in both."""
    for name in sorted({path.name for folder in (one, other) if folder.is_dir() for path in folder.iterdir()}):
        contents = disk.read(one / name), disk.read(other / name)
        if None in contents or contents[0] != contents[1]:
            yield name, *contents


def compare(expected: Path, drawn: Path, kept: Path, tolerance: float = TOLERANCE) -> list[Row]:
    """How the files in `drawn` differ from those in `expected`; pictures of the differences go into `kept`.

    Of each that differs its `name`, `what` about it, whether that `fails`, and a `picture` of the difference, or None.
    """
    return [difference(expected / name, drawn / name, kept, tolerance)
            if None not in (one, other) and name.endswith(".png") else _row(
                name, "is missing" if one is None else "is no longer drawn" if other is None else "has other bytes",
                None in (one, other))
            for name, one, other in differing(expected, drawn)]  # fmt: skip


def _row(name: str, what: str, fails: bool, picture: Path | None = None) -> Row:
    return {"name": name, "what": what, "fails": fails, "picture": picture}


def rms(expected: Path, drawn: Path) -> float:
    """Rms difference of two PNG files in grey levels of 255 over all pixels and colours; infinite for other sizes."""
    import numpy as np

    one, other = _pixels(expected), _pixels(drawn)
    return 255.0 * float(np.sqrt(np.mean((one - other) ** 2))) if one.shape == other.shape else float("inf")


def _pixels(picture: Path) -> Any:
    import numpy as np
    from matplotlib.image import imread

    return np.asarray(imread(picture), dtype=float)[..., :3]


def difference(expected: Path, drawn: Path, kept: Path, tolerance: float) -> Row:
    """How two PNG files differ: in their pixels or, where different programs drew them, in the numbers beside them."""
    name, size, programs = drawn.name, rms(expected, drawn), [_drawn_by(path) for path in (expected, drawn)]
    if all(programs) and programs[0] != programs[1]:
        what, fails = _by_numbers(expected.with_suffix(".csv"), drawn.with_suffix(".csv"))
        what += f"; {programs[0]} drew it, and here {programs[1]}"
    elif size <= tolerance:
        what, fails = f"has other bytes, pixels differ by {size:.2g} of 255 rms", False
    elif size < math.inf:
        what, fails = f"differs by {size:.2g} of 255 rms (allowed {tolerance:g})", True
    else:
        what, fails = "has another size", True
    if not fails:
        return _row(name, what, False)
    for path, suffix in ((expected, "expected"), (drawn, "drawn")):
        disk.write(kept / f"{drawn.stem}-{suffix}.png", path.read_bytes())
    if size == math.inf:
        return _row(name, what, True, kept / f"{drawn.stem}-drawn.png")
    target = kept / f"{drawn.stem}-difference.png"
    _draw_difference(expected, drawn, target)
    return _row(name, what, True, target)


def _drawn_by(picture: Path) -> str:
    """The program that a PNG file says it was drawn by; nothing where it does not say."""
    from PIL import Image

    with Image.open(picture) as opened:
        return str(opened.info.get("Software", ""))


def _by_numbers(expected: Path, drawn: Path) -> tuple[str, bool]:
    """What is said of two figures by the numbers (CSV) beside them, and whether that is a failure."""
    one, other = (disk.read(path, disk.TEXT) for path in (expected, drawn))
    if one is None and other is None:
        return "has no numbers to compare", False
    said = differing_numbers(one or b"", other or b"")
    return (f"shows other numbers: {said}", True) if said else ("shows the same numbers", False)


def differing_numbers(expected: bytes, drawn: bytes) -> str:
    """What differs by most between the numbers of two figures (CSV), in words; nothing where they are the same."""
    one, other = map(_curves, (expected, drawn))
    worst, said = 1.0, ""
    for curve in {**one, **other}:
        before, after = one.get(curve, []), other.get(curve, [])
        if len(before) != len(after):
            return f"{curve} has {len(after)} points, not {len(before)}"
        for axis in (0, 1):
            pairs = [(was[axis], now[axis]) for was, now in zip(before, after)]
            largest = max((abs(_number(text) or 0.0) for pair in pairs for text in pair), default=0.0)
            for was, now in pairs:
                size = _apart(was, now, _NOTHING * largest)
                if size > worst:
                    worst, said = size, f"{curve} has {'xy'[axis]} = {now}, not {was} (allowed: {100 * NUMBERS:g} %)"
    return said


def _curves(content: bytes) -> dict[str, list[tuple[str, str]]]:
    """The points of each curve in the numbers of a figure."""
    found: dict[str, list[tuple[str, str]]] = {}
    lines = (line for line in content.decode(errors="replace").splitlines() if not line.startswith("#"))
    for row in csv.reader(lines):
        panel, curve, x, y = (*row, "", "", "", "")[:4]
        found.setdefault(f'"{curve}" in panel {panel}', []).append((x, y))
    return found


def _number(text: str) -> float | None:
    """The finite number that a cell holds."""
    try:
        return float(text) if math.isfinite(float(text)) else None
    except ValueError:
        return None


def _apart(before: str, after: str, least: float) -> float:
    """By how much two cells differ, in what is allowed; those that are no numbers not at all or infinitely."""
    one, other = _number(before), _number(after)
    if one is None or other is None:
        return 0.0 if before == after else math.inf
    return abs(other - one) / (NUMBERS * max(abs(one), abs(other)) + least) if one != other else 0.0


def _draw_difference(expected: Path, drawn: Path, target: Path) -> None:
    """What is only in the first picture in orange, what is only in the second in blue, the rest faint."""
    import numpy as np
    from matplotlib.image import imsave

    one, other = (_pixels(path).mean(axis=-1)[..., None] for path in (expected, drawn))
    change, faint = np.clip(10 * (one - other), -1, 1), np.repeat(0.75 + 0.25 * one, 3, axis=-1)
    paint, picture = np.where(change < 0, [0.84, 0.37, 0.0], [0.0, 0.45, 0.70]), io.BytesIO()
    imsave(picture, np.clip(faint * (1 - abs(change)) + paint * abs(change), 0, 1), format="png")
    disk.write(target, picture.getvalue())
