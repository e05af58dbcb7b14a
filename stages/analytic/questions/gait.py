"""`gait`: the gaits of a design."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from stages.analytic.parameters import Parameters
from stages.biped.question import Answer, Asking, Question, as_plain, option


@dataclass(frozen=True)
class Options:
    """Options of `gait`."""

    every: bool = option(
        "-", "Every gait found, unstable ones too, and stable cycles of 2, 4, 8 steps", name="all", default=False)


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Find the gaits of the design. Raises NoGait."""
    from stages.analytic.gait.cycles import find_cycle
    from stages.analytic.gait.gait_report import report_gait
    from stages.analytic.gait.gait_search import find_gait, find_gaits
    from stages.analytic.gait.newton import by_stability, is_new
    from stages.analytic.walk.error_estimate import gait_error

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
        lines += [line for record in (each.gait, error, each.energy, each.validity) for line in field_lines(record)]
    plain: list[dict[str, Any]] = [
        {**as_plain(each.gait), "numerical_error": as_plain(error), "energy": as_plain(each.energy),
         "validity": as_plain(each.validity)}
        for each, error in zip(found, errors, strict=True)
    ]
    cycle_plain = None
    if cycle is not None:
        steps, around = cycle
        period = sum(step.period for step in around.steps) * walker.time
        lines.append(f"stable cycle of {steps} steps, period {period:.9g} s")
        multipliers = [[float(value.real), float(value.imag)] for value in around.floquet_multipliers]
        cycle_plain = {"steps": steps, "period_s": period, "floquet_multipliers": multipliers}

    def draw(save: Any) -> None:
        from stages.analytic.pictures import gait_portrait
        from stages.drawing import style

        with style.drawing():
            save(gait_portrait.draw(walker, points, tolerance))

    return Answer(lines, {"gaits": plain, "cycle": cycle_plain} if options.every else plain[0], draw=draw)


def field_lines(record: Any) -> Iterator[str]:
    """The fields of a result, a line each: description, value, unit."""
    for field in dataclasses.fields(record):
        value = getattr(record, field.name)
        about = field.metadata["description"]
        if dataclasses.is_dataclass(value):
            yield f"{about}:"
            yield from (f"  {line}" for line in field_lines(value))
        elif field.name == "floquet_multipliers":
            shown = [f"{real:.6g}" if imaginary == 0 else f"{real:.6g}{imaginary:+.6g}j" for real, imaginary in value]
            yield f"{'Floquet multipliers, largest first':<72} {', '.join(shown)}"
        elif isinstance(value, bool):
            yield f"{about:<72} {'yes' if value else 'no':>14}"
        elif value is None or isinstance(value, str):
            yield f"{about:<72} {'not known' if value is None else value:>14}"
        else:
            yield f"{about:<72} {value:>14.9g} {field.metadata['unit']}"


QUESTION = Question(
    "gait",
    """Find the most stable gait of the design in params/ (change it with --set) and print its measures.

    With them: the energy audit of a step, and what the gait asks of the ground.
    """,
    Options,
    ask,
    draws=True,
)
