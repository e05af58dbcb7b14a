"""Rough ground stage: how many steps each model makes on blocks of drawn heights until it falls.

Inputs: the analytic gait. Settings: params/rough_ground.yaml. Output: `Result`: steps to a fall and the chance to pass
the ramp by model and height, and the gait sensitivity norm of the design and of others near it.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from stages.analytic.derivatives.numbers import sensitive_names
from stages.analytic.derivatives.on_blocks import on_blocks, refusal
from stages.analytic.design.search import DesignSearch, search_design
from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import describe
from stages.analytic.gait.poincare import fixed_point
from stages.analytic.model.walker import Vector
from stages.analytic.result import OTHERWISE, REACHES, Inputs, Result as Analytic
from stages.biped.accuracy.scales import scales_of
from stages.biped.processes import Progress, ignore
from stages.ground.blocks import Blocks
from stages.penalty.walk import Settings as PenaltySettings, begin, numbers_of
from stages.planar.run import COMPLETED, rolling_state
from stages.rough_ground.parameters import Parameters, Settings
from stages.rough_ground.result import CONSTRAINT, PENALTY, TWIN, DesignNorm, OnHeight, Reached, Result
from stages.stability.blocks.passage import Counted
from stages.stability.blocks.walks import Rough, Walk, heights_of, some_walks, walk_on
from stages.stability.run import section_of
from stages.twin.machine.projection import machine_of
from stages.twin.machine.tree import SpatialTree
from stages.twin.walking.simulate import rolling_start, simulate_twin

#: What numbers leave open is how few walks are drawn, which their intervals say; a second run would draw the same.
ONCE = "its intervals are those of what is drawn, beside which the solver's error is none"
#: Parameters whose change of the gait sensitivity norm is stated.
CHANGED = ("biped.foot_radius", "biped.foot_com", "biped.hip_mass")
#: Tolerance of the penalty walker's steps: at 1e-8 none of 510 walks of Table 1's ends at another step, at 1e-4 one.
TOLERANCE = 1e-5
#: Tolerance of the steps of which the norm is made.
NORM_TOLERANCE = 1e-10
#: Longest stride, in the logarithm of a factor, from one gait to the next: from farther another gait may be found.
LONGEST = 0.06
#: First number of walks over a ramp, beyond those that are walked until they fall, and how many fewer are dear ones.
OF_RAMPS, FEWER = 1_000_000, 5

#: A walk by its number over blocks, for at most so many steps.
Walks = Callable[[Blocks, int, int], Walk]


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Walk every model on every height. Raises NoGait where the design has no answer on blocks."""
    settings, analytic = parameters.settings, inputs.analytic
    design = DesignPoint(parameters.biped, parameters.slope, parameters.analytic.limited(parameters.friction))
    reason = refusal(design.walker())
    if reason or not analytic.gait.stable:
        raise NoGait(reason or "the gait is unstable: on even ground too a walk leaves it")
    z = section_of(design.walker(), analytic.gait.fixed_point)
    made, apart = walkers(parameters, analytic, z), float(analytic.limp.feet_apart_m.min())
    ramp, length = parameters.blocks.block_sets - 1, min(parameters.blocks.block_length, apart)
    rows: list[OnHeight] = []
    shares = np.geomspace(settings.height_from, settings.height_to, settings.heights)
    for number, rms in enumerate((shares * parameters.biped.leg_length).tolist()):
        blocks = replace(parameters.blocks, block_height_rms=rms, block_length=length)
        progress(0.9 * number / len(shares), f"walks over blocks of {1e3 * rms:.2g} mm")
        for model, (walk, steps, ramps) in made.items():
            if model != TWIN or number >= len(shares) - 2:
                counted = counting(walk, blocks, ramp, steps, ramps)
                rows.append(OnHeight(**vars(counted.passage()), model=model, block_height_rms=rms))
    progress(0.9, "gait sensitivity norm of other designs")
    of_others = tuple(norms(design, z, settings))
    progress(0.95, "designs of the least norm")
    reached = tuple(front(design, z, replace(parameters.blocks, block_length=length), rows, settings))
    return Result(tuple(rows), of_others, norm_of(design, z)[0], reached)


def counting(walk: Walks, blocks: Blocks, ramp: int, steps: int, ramps: int) -> Counted:
    """Walks that make so many steps together, the last cut short, and others over the ramp alone."""
    counted, number = Counted(ramp), 0
    while counted.steps < steps:
        left = steps - counted.steps
        counted.add([walk(blocks, number, left)], left)
        number += 1
    for number in range(OF_RAMPS, OF_RAMPS + ramps):
        over = walk(blocks, number, ramp)
        counted.passed += over.ending == REACHES
        counted.stopped += over.ending != REACHES
    return counted


def walkers(parameters: Parameters, analytic: Analytic, z: Vector) -> dict[str, tuple[Walks, int, int]]:
    """Of each model how it walks, its steps on each height, and its walks over the ramp."""
    biped, slope, contact, settings = parameters.biped, parameters.slope, parameters.contact, parameters.settings
    walker, force = DesignPoint(biped, slope).walker(), analytic.walk.standing_force
    apart = analytic.limp.feet_apart_m
    start = rolling_state(biped, contact, analytic.mid_stance, force)
    numbers, scales = numbers_of(biped, slope, contact), scales_of(biped, slope.gravity)
    machine = machine_of(biped, parameters.twin)
    tree, on_it = SpatialTree(machine, slope, contact), rolling_start(machine, contact, analytic.mid_stance, force)
    loose = parameters.twin.with_tolerance(None)

    def constraint(blocks: Blocks, number: int, most: int) -> Walk:
        rough = Rough(walker, z, blocks.block_height_rms / walker.length, blocks.block_length / walker.length)
        return walk_on(rough, islice(heights_of(blocks.block_seed, number), most))

    def penalty(blocks: Blocks, number: int, most: int) -> Walk:
        walk = begin(numbers, scales, start, PenaltySettings(TOLERANCE), most, blocks.under(number, apart))
        walk.go_on()
        return Walk(walk.heel_strikes, REACHES if walk.outcome == COMPLETED else OTHERWISE)

    def twin(blocks: Blocks, number: int, most: int) -> Walk:
        record = simulate_twin(machine, slope, contact, on_it, loose, steps=most, tree=tree,
                               blocks=blocks.under(number, apart))  # fmt: skip
        return Walk(record.heel_strikes, REACHES if record.completed else OTHERWISE)

    return {CONSTRAINT: (constraint, settings.steps, settings.ramps),
            PENALTY: (penalty, settings.penalty_steps, settings.ramps // FEWER), TWIN: (twin, settings.twin_steps, 0)}


def norms(design: DesignPoint, z: Vector, settings: Settings) -> Iterator[DesignNorm]:
    """The norm over factors on single parameters, each gait searched from its neighbour's, from the design on."""
    count = settings.designs // 2
    parts = int(np.ceil(np.log(settings.share_to) / (count * LONGEST)))
    for name in CHANGED:
        rows = {}
        for way in (-1, 1):
            there = z
            for number in range(count * parts + 1):
                share = settings.share_to ** (way * number / (count * parts))
                changed = design.with_value(name, share * design.value(name))
                if number % parts == 0:
                    rows[share], there = norm_of(changed, there)
                elif (point := fixed_point(changed.walker(), there, NORM_TOLERANCE)) is not None:
                    there = point.z
        yield from (DesignNorm(name, share, rows[share]) for share in sorted(rows))


def norm_of(design: DesignPoint, z: Vector) -> tuple[float, Vector]:
    """The gait sensitivity norm [s/m] of the gait near section coordinates `z`, and the gait's own; NaN without one
    that is stable.
    """
    walker = design.walker()
    point = fixed_point(walker, z, NORM_TOLERANCE)
    try:
        found = on_blocks(walker, point, NORM_TOLERANCE) if point is not None else None
    except StepFailed:
        found = None
    return (found.sensitivity_norm if found else float("nan")), z if point is None else point.z


#: Steps to a fall are dear to search by, and change from one walk to another. The norm has exact gradients, and ranks
#: designs nearly as they do. So designs of the least norm are searched, and their steps then counted.
#: The masses, within the factor of the settings; and the radius, from its value to this share of the leg.
MASSES, RADIUS, RADIUS_TO = ("biped.hip_mass", "biped.foot_mass"), "biped.foot_radius", 0.9
#: Steps after which the given design falls on the blocks, as near as heights of the study are to it.
LASTS = 50.0
#: Tolerance of the search, and how near its speed is to the bound that stops it, as a share.
OF_SEARCH, AT_BOUND = 1e-8, 1e-4


def front(
    design: DesignPoint, z: Vector, blocks: Blocks, rows: Sequence[OnHeight], settings: Settings
) -> Iterator[Reached]:
    """For each bound on the speed the design of the least norm, from the design with its gait at `z`, and its steps."""
    given = min((row for row in rows if row.model == CONSTRAINT), key=lambda row: max(
        row.steps_to_fall / LASTS, LASTS / row.steps_to_fall))  # fmt: skip
    point, bounds = fixed_point(design.walker(), z, OF_SEARCH), bounds_of(design, settings.share_to)
    if point is None or not bounds:
        return
    speed = describe(design.walker(), point).speed_m_s
    for share in settings.speed_shares:
        limits = speed * (1 - share), speed * (1 + share)
        found = search_design(design, z, bounds, targets={"speed_m_s": limits}, tolerance=OF_SEARCH,
                              goal="sensitivity_norm")[0]  # fmt: skip
        best, walker = found.best, found.best.walker
        counted = Counted(given.ramp_steps)
        rough = Rough(walker, best.point.z, given.block_height_rms / walker.length, blocks.block_length / walker.length)
        counted.add(some_walks(rough, blocks.block_seed, 0, settings.steps), settings.steps)
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
