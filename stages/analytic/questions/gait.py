"""`gait`: the gaits of a design."""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stages.biped.question import Answer, Asking, Question, as_plain, option

if TYPE_CHECKING:
    from stages.analytic.parameters import Parameters


#: Columns of the words, and of the number beside them.
WORDS, NUMBER = 56, 17


@dataclass(frozen=True)
class Options:
    """Options of `gait`."""

    every: bool = option(
        "-", "Every gait found, unstable ones too, and stable cycles of 2, 4, 8 steps", name="all", default=False)


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Find the gaits of the design. Raises NoGait."""
    from stages.analytic.gait.gait_report import report_gait
    from stages.analytic.gait.gait_search import find_gait, find_gaits
    from stages.analytic.gait.poincare import by_stability, find_cycle, is_new
    from stages.analytic.walk.error_estimate import gait_error
    from stages.analytic.walk.validity import on_a_ramp

    tolerance = parameters.settings.tolerance
    walker, point = find_gait(parameters.biped, parameters.slope, tolerance, parameters.limited_friction)
    points = [point]
    if options.every:
        every = find_gaits(walker, tolerance, unstable=True)
        points = sorted([point, *(each for each in every if is_new([point], each))], key=by_stability)
    found = [report_gait(walker, each, tolerance, parameters.friction.static_friction) for each in points]
    errors = [gait_error(walker, each, tolerance) for each in points]
    cycle = None
    if options.every and not found[0].gait.stable:
        cycle = find_cycle(walker, points[0].z, tolerance)
    lines = []
    for number, (each, error) in enumerate(zip(found, errors, strict=True), 1):
        if options.every:
            lines.append(f"gait {number} of {len(found)}, {'stable' if each.gait.stable else 'unstable'}")
        lines += textwrap.wrap(on_a_ramp(each.validity, each.gait.stable).sentence, WORDS + NUMBER)
        own = [record for record in (each.limp, each.put_down) if record]
        records = (each.gait, *own, error, each.energy, each.validity)
        lines += [line for record in records for line in field_lines(record)]
    plain: list[dict[str, Any]] = [
        {"on_a_ramp": as_plain(on_a_ramp(each.validity, each.gait.stable)), **as_plain(each.gait),
         "numerical_error": as_plain(error), "energy": as_plain(each.energy),
         "validity": as_plain(each.validity), **({"limp": as_plain(each.limp)} if each.limp else {}),
         **({"put_down": as_plain(each.put_down)} if each.put_down else {})}
        for each, error in zip(found, errors, strict=True)
    ]
    cycle_plain = None
    if cycle is not None:
        _, around = cycle
        period = sum(step.period for step in around.steps) * walker.time
        lines.append(f"stable cycle of {len(around.steps)} steps, period {period:.9g} s")
        multipliers = [[float(value.real), float(value.imag)] for value in around.floquet_multipliers]
        cycle_plain = {"steps": len(around.steps), "period_s": period, "floquet_multipliers": multipliers}

    def draw(save: Any) -> None:
        from stages.analytic.pictures import gait_portrait
        from stages.drawing import style

        with style.drawing():
            save(gait_portrait.draw(walker, points, tolerance))

    return Answer(lines, {"gaits": plain, "cycle": cycle_plain} if options.every else plain[0], draw=draw,
                  rows=[{"gait": number, **each} for number, each in enumerate(plain, 1)])  # fmt: skip


def field_lines(record: Any, room: int = WORDS) -> Iterator[str]:
    """The fields of a result: description, folded to `room` columns, value, unit."""
    for field in dataclasses.fields(record):
        value = getattr(record, field.name)
        about = field.metadata["description"]
        if dataclasses.is_dataclass(value):
            yield f"{about}:"
            yield from (f"  {line}" for line in field_lines(value, room - 2))
        elif field.name == "floquet_multipliers":
            shown = [f"{real:.6g}" if imaginary == 0 else f"{real:.6g}{imaginary:+.6g}j" for real, imaginary in value]
            first, *others = shown
            yield f"{'Floquet multipliers, largest first':<{room}} {first:>{NUMBER}}"
            yield from (f"{'':<{room}} {other:>{NUMBER}}" for other in others)
        elif getattr(value, "ndim", 0) == 1:
            shown = [f"{one:.9g}" for one in value]
            yield f"{about:<{room}} {shown[0]:>{NUMBER}} {field.metadata['unit']}"
            yield from (f"{'':<{room}} {other:>{NUMBER}} {field.metadata['unit']}" for other in shown[1:])
        elif isinstance(value, str):
            yield f"{about}:"
            yield f"  {value}"
        else:
            unit = "" if field.metadata["unit"] in ("1", "-") else field.metadata["unit"]
            said = "not known" if value is None else f"{value:.9g}"
            if isinstance(value, bool):
                said = "yes" if value else "no"
            first, *others = textwrap.wrap(about, room, subsequent_indent="  ", break_on_hyphens=False)
            yield f"{first:<{room}} {said:>{NUMBER}} {unit}".rstrip()
            yield from others


QUESTION = Question(
    "gait",
    """Find the most stable gait of the design in params/ (change it with --set) and print its measures.

    First whether it walks so on a plain ramp, and why not. With the measures: the energy audit of a step, and what the
    gait asks of the ground.
    """,
    Options,
    ask,
    examples=("bipedstudy gait --set ground.slope_deg=2.5", "bipedstudy gait --all --csv",),
    draws=True,
    rows=True,
)
