"""`design`: change design parameters until the gait is most stable."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stages.analytic.parameters import Parameters
from stages.biped.quantity import Bound
from stages.biped.question import Answer, Asking, Question, WrongOption, interval, option

if TYPE_CHECKING:
    from stages.analytic.gait.design_point import DesignPoint
    from stages.analytic.gait.design_search import DesignSearch

VARIED = ("biped.foot_radius", "biped.foot_com", "biped.stiffness", "biped.damping")
MEASURES = ("step_frequency_hz", "step_length_m", "speed_m_s")
Bounds = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Options:
    """Options of `design`."""

    vary: tuple[str, ...] = option("-", "Parameter to vary; repeatable", default=(), metavar="FILE.KEY[=LOW:HIGH]")
    target: tuple[str, ...] = option(
        "-", "Measure to hold, as speed_m_s=0.33; repeatable", default=(), metavar="MEASURE=VALUE")
    share: float = option(
        "1", "Share by which a parameter without bounds may change", name="range", default=0.2,
        bound=Bound(above=0, maximum=0.9))
    iterations: int = option("1", "Most steps of the search", default=60, bound=Bound(minimum=1, maximum=1000))


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Search from the design. Raises NoGait, WrongOption."""
    from stages.analytic.gait.design_point import DesignPoint
    from stages.analytic.gait.design_search import TARGETS, search_design
    from stages.analytic.gait.gait_search import find_gait

    friction, tolerance = parameters.limited_friction, parameters.settings.tolerance
    design = DesignPoint(parameters.biped, parameters.slope, friction)
    bounds = dict(bounds_of(design, text, options.share) for text in options.vary or VARIED)
    held = dict(target_of(text, TARGETS) for text in options.target)
    _, point = find_gait(parameters.biped, parameters.slope, tolerance, friction)
    found = search_design(
        design,
        point.z,
        bounds,
        targets=held,
        tolerance=tolerance,
        iterations=options.iterations,
        progress=lambda step, merit: asking.note(f"iteration {step + 1}: largest multiplier {merit:.6f}"),
    )

    def draw(save: Any) -> None:
        from stages.analytic.pictures import design_path
        from stages.drawing import style

        with style.drawing():
            save(design_path.draw(found, list(bounds)))

    best = {name: found.best.design.value(name) for name in bounds}
    return Answer(list(lines(found, bounds, held)), as_plain(found, bounds, held), draw=draw, parameters=best)


def bounds_of(design: DesignPoint, text: str, share: float) -> tuple[str, tuple[float, float]]:
    """Name and bounds from "FILE.KEY" or "FILE.KEY=LOW:HIGH". Raises WrongOption."""
    name, given, limits = text.partition("=")
    try:
        value, allowed = design.value(name), design.bound(name)
    except KeyError as error:
        raise WrongOption(error.args[0]) from None
    low, high = interval(limits, f"--vary {name}") if given else ((1 - share) * value, (1 + share) * value)
    for limit in (low, high):
        if not allowed.holds(limit):
            raise WrongOption(f"--vary {name}: {limit:g} is not allowed; allowed is {allowed}")
    if not low < high:
        raise WrongOption(f"--vary {name}: its value is 0, so its range needs bounds, as {name}=0:0.001")
    return name, (low, high)


def target_of(text: str, known: tuple[str, ...]) -> tuple[str, float]:
    """Measure and value from "MEASURE=VALUE". Raises WrongOption with the known measures."""
    name, _, number = text.partition("=")
    try:
        value = float(number)
    except ValueError:
        value = 0.0
    if name not in known or not 0 < value < float("inf"):
        measures = ", ".join(known)
        raise WrongOption(f"--target {text!r} is not MEASURE=VALUE with a positive value; measures are {measures}")
    return name, value


def as_plain(found: DesignSearch, bounds: Bounds, held: Mapping[str, float]) -> dict[str, Any]:
    """The search as JSON."""
    start, best = found.start.design, found.best.design
    return {
        "largest_multiplier": {"start": found.start.largest_multiplier, "best": found.best.largest_multiplier},
        "parameters": {
            name: {"start": start.value(name), "best": best.value(name), "bounds": list(limits)}
            for name, limits in bounds.items()
        },
        "measures": {name: getattr(found.best.gait, name) for name in MEASURES},
        "targets": held,
        "iterations": len(found.history) - 1,
        "converged": found.converged,
    }


def lines(found: DesignSearch, bounds: Bounds, held: Mapping[str, float]) -> Iterator[str]:
    """The search in words."""
    yield (
        f"largest multiplier {found.start.largest_multiplier:.6f} -> {found.best.largest_multiplier:.6f} "
        f"({'converged' if found.converged else 'not converged'} in {len(found.history) - 1} steps)"
    )
    for name, (low, high) in bounds.items():
        best = found.best.design.value(name)
        at = " (at its bound)" if min(abs(best - low), abs(best - high)) < 1e-6 * (high - low) else ""
        yield f"  {name:<22} {found.start.design.value(name):>12.6g} -> {best:<12.6g}{at}"
    for name, value in held.items():
        yield f"  {name:<22} {getattr(found.best.gait, name):>12.6g} (asked for {value:g})"


QUESTION = Question(
    "design",
    """Minimise the largest multiplier over chosen design parameters within bounds.

    Without --vary: foot radius, foot_com, stiffness and damping within 20 %.
    """,
    Options,
    ask,
    draws=True,
    leaves="parameter files with the best design",
)
