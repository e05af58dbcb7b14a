"""`continue`: follow the gait through a design parameter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stages.biped.quantity import Bound
from stages.biped.question import Answer, Asking, Question, WrongOption, interval, option, refuse

if TYPE_CHECKING:
    from stages.analytic.gait.continuation import Branch, BranchPoint
    from stages.analytic.parameters import Parameters


@dataclass(frozen=True)
class Options:
    """Options of `continue`."""

    parameter: str = option("-", "Design parameter to follow the gait in", metavar="FILE.KEY", positional=True)
    limits: tuple[float, float] = option("-", "Range of that parameter", positional=True, read=interval)
    doublings: int = option(
        "1", "Period doublings to follow as well", default=0, bound=Bound(minimum=0, maximum=4))


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Follow the gait within the limits. Raises NoGait, WrongOption."""
    from stages.analytic.gait.continuation import follow_family
    from stages.analytic.gait.design_point import DesignPoint
    from stages.analytic.gait.gait_search import find_gait

    name, (low, high) = options.parameter, options.limits
    friction, tolerance = parameters.limited_friction, parameters.settings.tolerance
    design = DesignPoint(parameters.biped, parameters.slope, friction)
    try:
        here, bound = design.value(name), design.bound(name)
    except KeyError as error:
        raise WrongOption(error.args[0]) from None
    where = f"the design's {name} = {here:g}, where the family starts"
    refuse((not low <= here <= high, f"LIMITS {low:g}:{high:g} do not hold {where}"),
           *((not bound.holds(limit), f"LIMITS: {name} = {limit:g} is not allowed; allowed is {bound}")
             for limit in (low, high)))
    _, point = find_gait(parameters.biped, parameters.slope, tolerance, friction)
    branches = follow_family(design, name, (low, high), point.z, tolerance, options.doublings, asking.progress)

    def draw(save: Any) -> None:
        from stages.analytic.gait.continuation import recorded
        from stages.analytic.pictures import families
        from stages.drawing import style

        found = [recorded(design, branch, tolerance) for branch in branches]
        with style.drawing():
            save(families.draw_families(found, f"{name} [{design.unit(name)}]", here))

    lines = [line for branch in branches for line in branch_lines(branch)]
    rows = [{"cycle": branch.steps, **point_as_plain(point)} for branch in branches for point in branch.points]
    plain = {"parameter": name, "branches": [
        {"cycle": branch.steps, "ended": branch.ended, "points": list(map(point_as_plain, branch.points)),
         # a multiplier on the unit circle is inside or outside of it by round-off
         "special": [{"kind": kind, **point_as_plain(point), "stable": None} for kind, point in branch.special]}
        for branch in branches]}
    return Answer(lines, plain, draw=draw, rows=rows)


def branch_lines(branch: Branch) -> Iterator[str]:
    """A family in words."""
    found = [point.value for point in (*branch.points, *(turn for _, turn in branch.special))]
    yield (
        f"cycle of {branch.steps}: {branch.name} {min(found):.9g} to {max(found):.9g}, {len(branch.points)} gaits, "
        f"{sum(point.stable for point in branch.points)} stable; ends: {branch.ended}"
    )
    for kind, point in branch.special:
        yield f"  {kind} at {point.value:.12g}"


def point_as_plain(point: BranchPoint) -> dict[str, Any]:
    """A gait of a family as JSON."""
    return {
        "value": point.value,
        "period_s": point.period,
        "stable": point.stable,
        "floquet_multipliers": [[float(value.real), float(value.imag)] for value in point.floquet_multipliers],
        "section": point.z.tolist(),
    }


QUESTION = Question(
    "continue",
    """Follow the design's gait in PARAMETER (as ground.slope_deg) within LIMITS (LOW:HIGH).

    Prints ends, turning points and doublings; --json: every gait, with its cycle's period.
    """,
    Options,
    ask,
    key="branches",
    examples=("bipedstudy continue ground.slope_deg 1:4 --doublings 1 --figure family.png",),
    draws=True,
    rows=True,
)
