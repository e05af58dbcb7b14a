"""`gait`: the gaits of a design."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

from stages.biped.question import Answer, Asking, Question, as_plain, option

if TYPE_CHECKING:
    from stages.analytic.gait.gait_report import GaitReport
    from stages.analytic.parameters import Parameters
    from stages.analytic.result import OnBlocks
    from stages.analytic.walk.error_estimate import GaitError


#: Columns of the words, and of the number beside them.
WORDS, NUMBER = 56, 17


@dataclass(frozen=True)
class Options:
    """Options of `gait`."""

    every: bool = option(
        "-", "Every gait found, unstable ones too, and stable cycles of 2, 4, 8 steps", name="all", default=False)


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Find the gaits of the design. Raises NoGait."""
    from stages.analytic.derivatives.on_blocks import on_blocks
    from stages.analytic.gait.gait_report import report_gait
    from stages.analytic.gait.gait_search import find_gait, find_gaits
    from stages.analytic.gait.poincare import by_stability, find_cycle, is_new
    from stages.analytic.walk.error_estimate import gait_error

    tolerance = parameters.settings.tolerance
    walker, point = find_gait(parameters.biped, parameters.slope, tolerance, parameters.limited_friction)
    points = [point]
    if options.every:
        every = find_gaits(walker, tolerance, unstable=True)
        points = sorted([point, *(each for each in every if is_new([point], each))], key=by_stability)
    cycle = find_cycle(walker, points[0].z, tolerance) if by_stability(points[0]) >= 1 else None
    lines: list[str] = []
    plain: list[dict[str, Any]] = []
    for number, each in enumerate(points, 1):
        found = report_gait(walker, each, tolerance, parameters.friction.coefficients.static_friction)
        stable = "stable" if found.gait.stable else "unstable"
        lines += [f"gait {number} of {len(points)}, {stable}"] if options.every else []
        more, about = in_words(found, gait_error(walker, each, tolerance), on_blocks(walker, each, tolerance),
                               len(cycle.steps) if cycle else 0)
        lines += more
        plain.append(about)
    cycle_plain = None
    if cycle is not None:
        period = sum(step.period for step in cycle.steps) * walker.time
        lines.append(f"stable cycle of {len(cycle.steps)} steps, period {period:.9g} s")
        multipliers = [[float(value.real), float(value.imag)] for value in cycle.floquet_multipliers]
        cycle_plain = {"steps": len(cycle.steps), "period_s": period, "floquet_multipliers": multipliers}

    def draw(save: Any) -> None:
        from stages.analytic.pictures import gaits
        from stages.drawing import style

        with style.drawing():
            save(gaits.draw_gaits(walker, points, tolerance))

    return Answer(lines, {"gaits": plain, "cycle": cycle_plain} if options.every else plain[0], draw=draw,
                  rows=[{"gait": number, **each} for number, each in enumerate(plain, 1)])  # fmt: skip


def in_words(
    found: GaitReport, error: GaitError, rough: OnBlocks | None, cycle: int
) -> tuple[list[str], dict[str, Any]]:
    """A gait in words and as JSON; `cycle`: steps of a stable cycle beside it, 0 without one."""
    from stages.analytic.walk.on_a_ramp import on_a_ramp

    judged = on_a_ramp(found.validity, found.gait.stable, cycle)
    limp = found.limp if found.gait.steps > 1 else None
    own = {"limp": limp, "put_down": found.put_down, "on_blocks": rough}
    parts = {"numerical_error": error, "energy": found.energy, "validity": found.validity,
             **{name: record for name, record in own.items() if record}}  # fmt: skip
    lines = textwrap.wrap(judged.sentence, WORDS + NUMBER)
    for record in (found.gait, limp, found.put_down, rough, error, found.energy, found.validity):
        lines += field_lines(record) if record else []
    plain = {"on_a_ramp": as_plain(judged), **as_plain(found.gait)}
    return lines, plain | {name: as_plain(record) for name, record in parts.items()}


def field_lines(record: Any, room: int = WORDS) -> Iterator[str]:
    """The fields of a result: description, folded to `room` columns, value, unit."""
    for field in fields(record):
        value, about, unit = getattr(record, field.name), field.metadata["description"], field.metadata["unit"]
        if is_dataclass(value):
            yield f"{about}:"
            yield from (f"  {line}" for line in field_lines(value, room - 2))
        elif isinstance(value, str):
            yield f"{about}:"
            yield f"  {value}"
        else:
            about = "Floquet multipliers, largest first" if field.name == "floquet_multipliers" else about
            words = textwrap.wrap(about, room, subsequent_indent="  ", break_on_hyphens=False)
            words = [about] if getattr(value, "ndim", 0) else words
            unit = "" if unit in ("1", "-") else unit
            for word, number in zip_longest(words, as_text(value), fillvalue=""):
                yield f"{word:<{room}} {number:>{NUMBER}} {unit if number else ''}".rstrip()


def as_text(value: Any) -> list[str]:
    """A number, each of several, or each of several complex numbers in rows of real and imaginary part."""
    if value is None or isinstance(value, bool):
        return ["not known" if value is None else "yes" if value else "no"]
    if getattr(value, "ndim", 0) == 2:
        return [f"{real:.6g}" + (f"{imaginary:+.6g}j" if imaginary else "") for real, imaginary in value]
    return [f"{one:.9g}" for one in (value if getattr(value, "ndim", 0) else [value])]


QUESTION = Question(
    "gait",
    """Find the most stable gait of the design in params/ (change it with --set) and print its measures.

    Also whether it walks so on a plain ramp, the energy audit of a step, and the friction that it needs.
    """,
    Options,
    ask,
    examples=("bipedstudy gait --set ground.slope_deg=2.5", "bipedstudy gait --all --csv",),
    draws=True,
    rows=True,
)
