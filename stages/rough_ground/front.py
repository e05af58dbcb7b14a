"""What a search of designs reaches on blocks, over the bound on their speed.

Steps to a fall are dear to search by, and change from one walk to another. The gait sensitivity norm has exact
gradients, and ranks designs nearly as they do. So designs of the least norm are searched, and their steps then counted.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from stages.analytic.derivatives.numbers import sensitive_names
from stages.analytic.design.search import DesignSearch, search_design
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import describe
from stages.analytic.gait.poincare import fixed_point
from stages.analytic.model.walker import Vector
from stages.ground.blocks import Blocks
from stages.rough_ground.parameters import Settings
from stages.rough_ground.result import CONSTRAINT, OnHeight, Reached
from stages.stability.blocks.passage import Counted
from stages.stability.blocks.walks import Rough, some_walks

#: The masses, within the factor of the settings; and the radius, from its value to this share of the leg.
MASSES, RADIUS, RADIUS_TO = ("biped.hip_mass", "biped.foot_mass"), "biped.foot_radius", 0.9
#: Steps after which the given design falls on the blocks, as near as heights of the study are to it.
LASTS = 50.0
#: Tolerance of the search, and how near its speed is to the bound that stops it, as a share.
TOLERANCE, AT_BOUND = 1e-8, 1e-4


def front(
    design: DesignPoint, z: Vector, blocks: Blocks, rows: Sequence[OnHeight], settings: Settings
) -> Iterator[Reached]:
    """For each bound on the speed the design of the least norm, from the design with its gait at `z`, and its steps."""
    given = min((row for row in rows if row.model == CONSTRAINT), key=lambda row: max(
        row.steps_to_fall / LASTS, LASTS / row.steps_to_fall))  # fmt: skip
    point, bounds = fixed_point(design.walker(), z, TOLERANCE), bounds_of(design, settings.share_to)
    if point is None or not bounds:
        return
    speed = describe(design.walker(), point).speed_m_s
    for share in settings.speed_shares:
        limits = speed * (1 - share), speed * (1 + share)
        found = search_design(design, z, bounds, targets={"speed_m_s": limits}, tolerance=TOLERANCE,
                              goal="sensitivity_norm")[0]  # fmt: skip
        best, walker = found.best, found.best.walker
        counted = Counted(given.ramp_steps)
        rough = Rough(walker, best.point.z, given.block_height_rms / walker.length, blocks.block_length / walker.length)
        counted.add(some_walks(rough, blocks.block_seed, 0, settings.steps))
        yield Reached(**vars(counted.passage()), block_height_rms=given.block_height_rms, speed_share=share,
                      speed=best.gait.speed_m_s, sensitivity_norm=best.value, stopped_by=stops(found, limits),
                      met=found.met)  # fmt: skip


def bounds_of(design: DesignPoint, factor: float) -> dict[str, tuple[float, float]]:
    """Least and largest values of the parameters that are searched."""
    known = sensitive_names(design)
    bounds = {name: (design.value(name) / factor, design.value(name) * factor) for name in MASSES if name in known}
    radius, most = design.value(RADIUS), RADIUS_TO * design.biped.leg_length
    return {**bounds, RADIUS: (radius, most)} if RADIUS in known and radius < most else bounds


def stops(found: DesignSearch, limits: tuple[float, float]) -> str:
    """The bounds on which a search ended."""
    speed = ["speed"] if any(abs(found.best.gait.speed_m_s - limit) < AT_BOUND * limit for limit in limits) else []
    return ", ".join([*speed, *(f"{name} {end}" for name, end in found.bounds.items())])
