"""`bipedstudy design`: change design parameters until the gait is most stable."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from pipeline.commands import answer, options
from pipeline.errors import StudyError
from pipeline.study import Study

_DEFAULT = ("biped.foot_radius", "biped.foot_com", "biped.stiffness", "biped.damping")


@click.command("design")
@click.option("--vary", "varied", metavar="FILE.KEY[=LOW:HIGH]", multiple=True, help="Parameter to vary; repeatable.")
@click.option("--target", "targets", metavar="MEASURE=VALUE", multiple=True, help="Measure to hold, as speed_m_s=0.33.")
@click.option(
    "--range",
    "share",
    type=click.FloatRange(0, 0.9, min_open=True),
    default=0.2,
    show_default=True,
    help="Share by which a parameter without bounds may change.",
)
@click.option(
    "--iterations", type=click.IntRange(1, 1000), default=60, show_default=True, help="Most steps of the search."
)
@options.study
@options.as_json
@answer.figure
def command(
    study: Study,
    varied: tuple[str, ...],
    targets: tuple[str, ...],
    share: float,
    iterations: int,
    as_json: bool,
    figure: Path | None,
) -> None:
    """Minimise the largest multiplier over chosen design parameters within bounds.

    Without --vary: foot radius, foot_com, stiffness and damping within 20 %.
    """
    values = study.parameters([answer.STAGE])[answer.STAGE]
    search, engine = answer.module(study, "gait.gait_search"), answer.module(study, "gait.design_search")
    design = answer.module(study, "gait.design_point").DesignPoint(values.biped, values.slope, values.limited_friction)
    bounds = dict(bounds_of(design, text, share) for text in varied or _DEFAULT)
    held = dict(target_of(text, engine.TARGETS) for text in targets)
    with answer.or_reason(study, "design", as_json):
        _, point = search.find_gait(values.biped, values.slope, values.settings.tolerance, values.limited_friction)
        found = engine.search_design(
            design,
            point.z,
            bounds,
            targets=held,
            tolerance=values.settings.tolerance,
            iterations=iterations,
            progress=lambda step, merit: click.echo(f"iteration {step + 1}: largest multiplier {merit:.6f}", err=True),
        )
    if as_json:
        options.print_json(as_plain(found, bounds, held))
    else:
        for line in lines(found, bounds, held):
            click.echo(line)
    if figure is not None:
        from stages.analytic.pictures import design_path
        from stages.drawing import style

        with style.drawing():
            answer.save(figure, design_path.draw(found, list(bounds)))


def bounds_of(design: Any, text: str, share: float) -> tuple[str, tuple[float, float]]:
    """Name and bounds from "FILE.KEY" or "FILE.KEY=LOW:HIGH". Raises `StudyError`."""
    name, given, limits = text.partition("=")
    value = answer.number_of_design(design, name)
    low, high = answer.interval(limits, f"--vary {name}") if given else ((1 - share) * value, (1 + share) * value)
    allowed = design.bound(name)
    for limit in (low, high):
        if not allowed.holds(limit):
            raise StudyError(f"--vary {name}: {limit:g} is not allowed; allowed is {allowed}")
    if not low < high:
        raise StudyError(f"--vary {name}: its value is 0, so its range needs bounds, as {name}=0:0.001")
    return name, (low, high)


def target_of(text: str, known: tuple[str, ...]) -> tuple[str, float]:
    """Measure and value from "MEASURE=VALUE". Raises `StudyError` with the known measures."""
    name, _, number = text.partition("=")
    try:
        value = float(number)
    except ValueError:
        value = 0.0
    if name not in known or not 0 < value < float("inf"):
        raise StudyError(
            f"--target {text!r} is not MEASURE=VALUE with a positive value; measures are {', '.join(known)}"
        )
    return name, value


def as_plain(found: Any, bounds: dict[str, tuple[float, float]], held: dict[str, float]) -> dict[str, Any]:
    """The search as JSON."""
    return {
        "largest_multiplier": {"start": found.start.largest_multiplier, "best": found.best.largest_multiplier},
        "parameters": {
            name: {
                "start": found.start.design.value(name),
                "best": found.best.design.value(name),
                "bounds": list(limits),
            }
            for name, limits in bounds.items()
        },
        "measures": {
            name: getattr(found.best.gait, name) for name in ("step_frequency_hz", "step_length_m", "speed_m_s")
        },
        "targets": held,
        "iterations": len(found.history) - 1,
        "converged": found.converged,
    }


def lines(found: Any, bounds: dict[str, tuple[float, float]], held: dict[str, float]) -> list[str]:
    """The search in words."""
    said = [
        f"largest multiplier {found.start.largest_multiplier:.6f} -> {found.best.largest_multiplier:.6f} "
        f"({'converged' if found.converged else 'not converged'} in {len(found.history) - 1} steps)"
    ]
    for name, (low, high) in bounds.items():
        best = found.best.design.value(name)
        at = " (at its bound)" if min(abs(best - low), abs(best - high)) < 1e-6 * (high - low) else ""
        said.append(f"  {name:<22} {found.start.design.value(name):>12.6g} -> {best:<12.6g}{at}")
    for name, value in held.items():
        said.append(f"  {name:<22} {getattr(found.best.gait, name):>12.6g} (asked for {value:g})")
    return said
