"""Stability stage: what becomes of the constraint model's gait on other slopes, and from other starts.

Inputs: the analytic gait. Settings: params/stability.yaml. Output: `Result`: the gait's family over the slope with its
multipliers, the families of doubled period that leave it, and the basin of attraction over two coordinates.
"""

from collections.abc import Callable

import numpy as np

from stages.analytic.gait.basin import basin_of_attraction
from stages.analytic.gait.continuation import follow_family, recorded
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.section import section_coordinates
from stages.analytic.result import Basin, Inputs, RecordedFamily
from stages.biped.processes import Progress, ignore
from stages.biped.walk import StanceState
from stages.stability.parameters import Parameters, Settings
from stages.stability.result import Result

SLOPE, STEEPEST = "ground.slope_deg", 89.0


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Follow the gait over the slope, and walk from a grid of starts.

    A gait that cannot be followed has no families, and one that is unstable has no basin.
    """
    settings, gait = parameters.settings, inputs.analytic.gait
    design = DesignPoint(parameters.biped, parameters.slope, parameters.analytic.limited(parameters.friction))
    walker = design.walker()
    z = section_of(walker, gait.fixed_point)
    progress(0.0, "following the gait over the slope")
    families = over_slope(design, z, settings, lambda share, what: progress(0.6 * share, what))
    basin = starts_around(walker, z, settings, lambda share: progress(0.6 + 0.4 * share, "starts")) \
        if gait.stable else None  # fmt: skip
    return Result(design.value(SLOPE), families, basin)


def section_of(walker: Walker, state: StanceState) -> Vector:
    """Section coordinates (j,) of a state just after heel strike in SI units."""
    return np.asarray(section_coordinates(walker.from_stance(state), walker.p))


def over_slope(
    design: DesignPoint, z: Vector, settings: Settings, progress: Progress = ignore
) -> tuple[RecordedFamily, ...]:
    """The gait's family over the slope and those of doubled period; none where `z` leads to no gait."""
    slope = design.value(SLOPE)
    limits = settings.slope_from * slope, min(settings.slope_to * slope, STEEPEST)
    try:
        branches = follow_family(
            design, SLOPE, limits, z, settings.tolerance, settings.doublings, progress, settings.gait_distance)
    except ValueError:
        return ()
    return tuple(recorded(design, branch, settings.tolerance) for branch in branches)


def starts_around(
    walker: Walker, z: Vector, settings: Settings, progress: Callable[[float], None] = lambda share: None
) -> Basin:
    """Walks from a grid of angles and rates of the stance leg around the gait's own."""
    rate = z[walker.rate_entry] / walker.time
    return basin_of_attraction(
        walker, z,
        np.linspace(settings.angle_from, settings.angle_to, settings.starts) * -z[0],
        np.linspace(settings.rate_from, settings.rate_to, settings.starts) * rate,
        steps=settings.most_steps, progress=progress,
    )  # fmt: skip
