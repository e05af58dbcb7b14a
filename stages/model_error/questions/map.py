"""`map`: the gaits of up to millions of designs, by the constraint model or within an error of the twin's."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stages.biped.quantity import Bound
from stages.biped.question import Answer, Asking, Column, Question, option, refuse
from stages.model_error.measures import errors, learnt_by

if TYPE_CHECKING:
    import numpy as np

    from stages.analytic.maps.answers import Counts, Task
    from stages.analytic.maps.box import Box
    from stages.biped.question import Table
    from stages.model_error.parameters import Parameters

#: Designs that are answered, and anchors that are searched, at once.
BLOCK, ANCHOR_BLOCK = 500, 5
#: A small map has an anchor for every so many designs. Designs that a picture shows, and that are rows, at most.
DESIGNS_AN_ANCHOR, DRAWN, LISTED = 10, 200_000, 10_000


@dataclass(frozen=True)
class Options:
    """Options of `map`."""

    file: Mapping[str, Any] = option("-", "YAML file with the ranges of the parameters", positional=True)
    out: Path | None = option("-", "Write the map into this new HDF5 file", default=None)
    anchors: int = option(
        "1", "Designs of which the gait is searched, for others to start from", default=300,
        bound=Bound(minimum=1, maximum=10_000))
    search: str = option(
        "-", "Designs that no neighbour answers: complete search, without families followed from other slopes and "
        "springs, or none", default="complete", choices=("complete", "limited", "none"))  # fmt: skip
    within: tuple[str, ...] = option(
        "-", "Measure and its error, as step_frequency=1%: of the twin, by the cheapest model that is exact enough",
        default=(), metavar="MEASURE=ERROR")

    front: bool = option(
        "-", "List the stable designs that no other beats in both the largest multiplier and speed", default=False)
    norm: bool = option(
        "-", "Also the gait sensitivity norm of each design, at the price of one more derivative",
        name="sensitivity-norm", default=False)


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Answer every design of the map. Raises WrongOption."""
    if options.within:
        refuse((options.front, "--front: a map with --within has no stability of each design"),
               (options.norm, "--sensitivity-norm: a map with --within has no gait of each design"))
        return ask_within(parameters, options, asking)
    from stages.analytic.maps.answers import Counts, columns_of

    asked_of = task(parameters, options.file, options.search)
    box, tolerance = asked_of.box, asked_of.tolerance
    count = min(options.anchors, -(-box.size // DESIGNS_AN_ANCHOR))
    parts = asking.each(anchors, spans(count, ANCHOR_BLOCK), options.file, options.search)
    known = [one for part in parts for one in part if one]
    of_map = columns_of(options.norm)
    requested, counts = spans(box.size, BLOCK), Counts(of_map)
    shown = [axis.name for axis in box.axes] + ["outcome", "largest_multiplier", "period_s", "speed_m_s"]
    axes = [Column(axis.name, axis.unit, "varied") for axis in box.axes]
    about = {"map": box.in_words(), "tolerance": f"{tolerance:g}", "search": options.search}
    with asking.new_table(options.out, [*axes, *of_map], box.size, about) as table:
        rows_of = asking.each(answers, requested, options.file, options.search, known, *[True] * options.norm)
        for (first, _), rows in zip(requested, rows_of, strict=True):
            found = counts.add(rows)
            varied = box.values(first, first + len(found))
            table.write(first, dict(zip([axis.name for axis in axes], varied.T, strict=True)))
            table.write(first, {column.name: row for column, row in zip(of_map, found.T, strict=True)})
        whole = options.front or box.seed is None
        columns = {name: table.read(name, 1 if whole else -(-box.size // DRAWN)) for name in shown}
        designs = [] if options.front else listed(table, [*axes, *of_map], box.size)
    summary, draw = list(lines(counts, options.search)), drawing(box, columns)
    if not options.front:
        return Answer(summary, counts.as_plain(), rows=designs, draw=draw)
    best = front(columns)
    heads = [f"{axis.name.partition('.')[2]} [{axis.unit}]" for axis in box.axes] + ["multiplier [1]", "speed [m/s]"]
    rows = [[f"{value:.6g}" for value in row.values()] for row in best]
    tables = [("No other stable design beats these in both", heads, rows)] if best else []
    return Answer(summary, {**counts.as_plain(), "front": best}, tables, best, draw)


def listed(table: Table, columns: Sequence[Column], size: int) -> list[dict[str, Any]]:
    """The designs of a map, as rows by column with words for their numbers; none of a large map."""
    if size > LISTED:
        return []
    values = ([column.words[int(value)] for value in part] if column.words else part.tolist()
              for column in columns for part in [table.read(column.name)])  # fmt: skip
    return [dict(zip([column.name for column in columns], row, strict=True)) for row in zip(*values, strict=True)]


def front(columns: Mapping[str, np.ndarray]) -> list[dict[str, float]]:
    """The stable designs that no other beats in both, the least largest multiplier first: values by column."""
    import numpy as np

    from stages.analytic.maps.answers import STABLE

    stable = np.flatnonzero(columns["outcome"] == STABLE)
    order = stable[np.lexsort((-columns["speed_m_s"][stable], columns["largest_multiplier"][stable]))]
    speed = columns["speed_m_s"][order]
    best = order[speed > np.maximum.accumulate(np.append(-np.inf, speed[:-1]))] if len(order) else order
    names = [name for name in columns if name not in ("outcome", "largest_multiplier", "period_s", "speed_m_s")]
    return [{name: float(columns[name][row]) for name in (*names, "largest_multiplier", "speed_m_s")} for row in best]


def ask_within(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Tell some measures of every design within their errors. Raises WrongOption."""
    allowed = errors(options.within)
    refuse(("" in allowed, "--within: a map names the measure of each error, as step_frequency=1%"))
    result = learnt_by(asking)
    from stages.model_error import choice

    box = task(parameters, options.file, options.search).box
    shared = options.file, list(options.within), [result.kind, result.numbers.tolist(), result.values.tolist()]
    requested, counts = spans(box.size, BLOCK // 2), {name: Counter[str]() for name in allowed}
    axes, found = [Column(axis.name, axis.unit, "varied") for axis in box.axes], choice.columns(allowed)
    about = {"map": box.in_words(), "within": ", ".join(options.within)}
    with asking.new_table(options.out, [*axes, *found], box.size, about) as table:
        for (first, _), rows in zip(requested, asking.each(answers_within, requested, *shared), strict=True):
            columns = [*zip(*box.values(first, first + len(rows)).tolist(), strict=True), *zip(*rows, strict=True)]
            table.write(first, {column.name: values for column, values in zip([*axes, *found], columns, strict=True)})
            for place, name in enumerate(allowed, start=1):
                counts[name].update(choice.WAYS[int(row[3 * place - 1])] for row in rows)
        designs = listed(table, [*axes, *found], box.size)
    return Answer([f"{box.size} designs", *(
        f"{name} within {text.rpartition('=')[2]} of the twin's: " + ", ".join(
            f"{counts[name][way]} by {way}" for way in choice.WAYS if counts[name][way])
        for name, text in zip(allowed, options.within, strict=True))],
        {"designs": box.size, "answered_by": {name: dict(count) for name, count in counts.items()}}, rows=designs)


def answers_within(
    parameters: Parameters, file: Mapping[str, Any], within: Sequence[str], learnt: Sequence[Any],
    span: tuple[int, int]
) -> list[list[float]]:  # fmt: skip
    """The rows of a block within errors, for `Asking.each`."""
    from stages.model_error import choice

    of_map = task(parameters, file, "none")
    return choice.block(parameters, of_map.box, of_map.base, errors(within), choice.learnt_of(learnt), *span)


def task(parameters: Parameters, file: Mapping[str, Any], search: str, known: Sequence[Any] = ()) -> Task:
    """What is computed of each block of the map that `file` describes. Raises WrongOption."""
    from stages.analytic.gait.design_point import DesignPoint
    from stages.analytic.maps import box
    from stages.analytic.maps.answers import Task

    base = DesignPoint(parameters.biped, parameters.slope, parameters.analytic.limited(parameters.friction))
    return Task(box.read(file, base), base, parameters.analytic.tolerance, search, known)


def spans(size: int, each: int) -> list[tuple[int, int]]:
    """The blocks of `each` among `size` designs: first, and before which."""
    return [(first, min(first + each, size)) for first in range(0, size, each)]


def anchors(
    parameters: Parameters, file: Mapping[str, Any], search: str, span: tuple[int, int]
) -> list[list[Any] | None]:
    """Some anchors of the map, for `Asking.each`."""
    from stages.analytic.maps.answers import anchors_of

    return anchors_of(task(parameters, file, search), *span)


def answers(
    parameters: Parameters, file: Mapping[str, Any], search: str, known: Sequence[Any], *rest: Any
) -> list[list[float]]:
    """The rows of a block, for `Asking.each`: `rest` is True if they have the norm, and then the block's span."""
    from stages.analytic.maps.answers import block

    *norm, span = rest
    return block(replace(task(parameters, file, search, known), norm=bool(norm)), *span)


def drawing(box: Box, columns: Mapping[str, np.ndarray]) -> Any:
    """What draws the map."""

    def draw(save: Any) -> None:
        from stages.analytic.pictures import design_map
        from stages.drawing import style

        with style.drawing():
            save(design_map.draw(box, columns))

    return draw


def lines(counts: Counts, search: str) -> Iterator[str]:
    """The map in words."""
    yield f"{counts.designs} designs: " + ", ".join(f"{count} {word}" for word, count in counts.outcomes().items())
    yield "answered by: " + ", ".join(f"{count} {word}" for word, count in counts.ways().items())
    if counts.answered:
        yield f"largest residual {counts.residual:.1e} (leg lengths and pendulum times)"
        for name, (low, high) in counts.ranges().items():
            yield f"  {name:<24}{low:>10.4g} .. {high:.4g}"
    if search != "complete" and counts.outcomes().get("unanswered"):
        yield f"the unanswered may have a gait: they were searched with --search {search}"


QUESTION = Question(
    "map",
    """Find the gait of every design in FILE: a grid, or points that fill a box of parameters evenly.

    The gait of a few designs is searched. The others start from the nearest of these, along exact derivatives, and are
    corrected by Newton's method; where that fails, their gait is searched too. Each row has outcome, period, step
    length, speed, leading multipliers, friction needed in single stance, residual, and the method. With
    --sensitivity-norm it has the gait sensitivity norm too. A map that was stopped continues. The figure shows two axes
    as a map, more as pairs; --front lists the best of the stable designs.
    With --within the map has the named measures of the twin, by the cheapest model that is exact enough, as in `ask`.
    """,
    Options,
    ask,
    examples=("bipedstudy map box.yaml --out map.h5", "bipedstudy map box.yaml --front --csv",
              "bipedstudy map box.yaml --within step_frequency=0.5% --out map.h5"),
    draws=True,
    pool=True,
    rows=True,
)
