"""Designs with legs that differ: the constraint model against Exudyn, as near as for legs that are alike?

    python benchmarks/unequal_designs.py [DESIGNS [SEED]]     beside Exudyn
    python benchmarks/unequal_designs.py --limits             how far legs may differ, as a table of Markdown

Ten designs drawn by a seed, each with frames, masses off the legs' lines and a hip with spring and damper, and each
twice: with legs that are alike, and with legs of which one differs in every number, by up to 1 % (its length by up to
0.02 mm: a walker of this kind limps a thousand times as much as its legs differ in length). Of each: period, step
length, limp and the two largest multipliers of a stride of the constraint model's gait, and by how much those of
Exudyn's planar model, with the study's ground, differ; and the largest difference of the hips at equal phase over a
stride. Designs without a stable gait are passed over.

The limits: from legs that are alike the gait is followed as they come to differ, in one number of Table 1's other leg
at a time, and for the ten designs in all numbers together, in the proportions in which they are drawn. Told are the
difference at which a multiplier of the stride passes one in magnitude, and that at which the gait is lost.
"""

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from itertools import islice

import numpy as np

from pipeline.parameters.loading import load
from pipeline.study import locate
from stages.analytic.gait.gait_report import limp_of
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import fixed_point as fixed_gait
from stages.analytic.model.walker import build_walker
from stages.biped.design import Biped, Leg
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.parameters import Settings
from stages.multibody.walking.cycle import SectionWalker
from stages.multibody.walking.walk import simulate
from stages.planar.limit_cycle import fixed_point, floquet_multipliers
from stages.planar.run import rolling_state
from stages.planar.section import NoLimitCycle, section_numbers, section_state
from stages.rough_ground.parameters import Parameters as RoughGround
from stages.twin_ladder.parameters import Parameters
from stages.twin_ladder.run import PHASES, ConstraintGait, constraint_gait

#: Ranges of what both legs have, in SI units, evenly; by how much a number of the other leg differs, a part of itself.
RANGES = {
    "hip_mass": (0.10, 0.25), "foot_mass": (0.30, 0.36), "foot_radius": (0.075, 0.088), "foot_com": (0.095, 0.105),
    "stiffness": (2400.0, 3600.0), "damping": (50.0, 70.0), "leg_inertia": (2e-4, 1e-3),
    "foot_offset": (-0.002, 0.002), "frame_mass": (0.03, 0.10), "frame_com": (0.005, 0.03),
    "frame_offset": (-0.004, 0.004), "frame_inertia": (5e-5, 2e-4), "hip_stiffness": (0.0, 0.05),
    "hip_damping": (0.0, 0.002),
}  # fmt: skip
DIFFERENCE, LENGTH_DIFFERENCE = 0.01, 2e-5
#: A gait whose largest multiplier of a stride is larger is not compared: what parts the models could make it unstable.
STABLE = 0.8
#: A gait is lost where a step of its family, as part of the way from zero, is shorter than this; a longer change of its
#: coordinates is to another family.
SHORTEST, JUMP = 1e-4, 0.05
TOLERANCE, ALONG, LARGEST_STEP = 1e-8, 5e-4, 1e-3


@dataclass(frozen=True)
class Beside:
    """The gait of one design in both models; differences are Exudyn's less the constraint model's, SI units.

    Of both models the limp and the two largest multipliers of a stride, (2,) complex; the hips' difference (2,) [m].
    """

    constraint: ConstraintGait
    period: float
    step_length: float
    limps: tuple[float, float]
    multipliers: np.ndarray
    hip: np.ndarray


def drawn(seed: int, like: Biped) -> Iterator[tuple[Biped, Biped]]:
    """Designs with legs alike and with legs that differ, without end."""
    generator = np.random.default_rng(seed)
    names = [field.name for field in fields(Leg)]
    while True:
        alike = replace(like, **{key: float(generator.uniform(*ends)) for key, ends in RANGES.items()})
        off = dict(zip(names, generator.uniform(-1.0, 1.0, len(names)), strict=True))
        other = {f"other_{name}": getattr(alike, name) * (1.0 + DIFFERENCE * part) for name, part in off.items()}
        other["other_leg_length"] = alike.leg_length + LENGTH_DIFFERENCE * off["leg_length"]
        yield alike, replace(alike, **other)


def beside_exudyn(biped: Biped, slope: Slope, contact: ContactLaw, constraint: ConstraintGait) -> Beside:
    """A design's gait in Exudyn beside that of the constraint model. Raises NoLimitCycle."""
    start = rolling_state(biped, contact, constraint.mid_stance, -biped.weighed_mass * slope.gravity_vector[1])
    settings = Settings.of_one_step(TOLERANCE, LARGEST_STEP)
    walker = SectionWalker(biped, slope, contact, start, settings, ALONG)
    point = fixed_point(walker, section_numbers(start))
    steps, derivative = 2 // walker.steps_a_cycle, walker.derivative(point.numbers)
    multipliers = floquet_multipliers(np.linalg.matrix_power(derivative, steps))[:2] @ [1.0, 1.0j]
    here = section_state(point.numbers, start)
    first, stride = (walker.walk(here, count) for count in (1, 2))
    run = simulate(biped, slope, contact, here, settings, steps=2)
    hip = run.trajectory.at(stride.duration * PHASES)[0][:, :2]
    return Beside(
        constraint=constraint,
        period=0.5 * stride.duration - constraint.row.period_s,
        step_length=0.5 * stride.length - constraint.row.step_length_m,
        limps=(constraint.row.inner_outer_difference, (4.0 * first.duration - 2.0 * stride.duration) / stride.duration),
        multipliers=np.array([(constraint.row.multipliers @ [1.0, 1.0j]) ** 2, multipliers]),
        hip=np.abs(hip - constraint.hip).max(axis=0),
    )


def accepted(parameters: Parameters, seed: int) -> Iterator[tuple[tuple[Biped, Biped], list[ConstraintGait]]]:
    """The drawn pairs, without end, whose gaits are stable enough to be compared, with these."""
    for pair in drawn(seed, parameters.biped):
        gaits = [constraint_gait(each, parameters.slope, TOLERANCE) for each in pair]
        if all(gait.row.found and np.hypot(*gait.row.multipliers[0]) ** 2 <= STABLE for gait in gaits):
            yield pair, gaits


def compared(parameters: Parameters, designs: int, seed: int) -> Iterator[tuple[Beside, Beside]]:
    """So many drawn designs that walk in both models, with legs alike and with legs that differ."""
    ground, found = (parameters.slope, parameters.contact), 0
    for pair, gaits in accepted(parameters, seed):
        try:
            alike, unequal = (beside_exudyn(each, *ground, gait) for each, gait in zip(pair, gaits, strict=True))
        except NoLimitCycle as reason:
            print(f"no gait in Exudyn: {reason}")
            continue
        yield alike, unequal
        found += 1
        if found == designs:
            return


@dataclass(frozen=True)
class Limit:
    """How far a gait is followed: the measure at which it is no longer stable, and at which it is lost; NaN where it is
    not by the end.

    `multipliers` (2,): the largest of a stride just after the first, and just before the second. `limp`: just before
    the second.
    """

    unstable: float
    lost: float
    multipliers: tuple[complex, complex]
    limp: float


def followed(design: Callable[[float], Biped], slope: Slope, first: float, end: float) -> Limit:
    """Follow the gait of design(0) as its argument grows from `first` to `end`, by steps that shrink where it is lost.
    """
    walker, point = find_gait(design(first), slope, TOLERANCE)
    at, step, unstable, seen, limp = first, first, math.nan, complex(math.nan), math.nan
    while at < end and step > SHORTEST * at:
        there = build_walker(design(at + step), slope)
        found = fixed_gait(there, point.z, TOLERANCE)
        if found is None or np.abs(found.z - point.z).max() > JUMP:
            step /= 2.0
            continue
        at, point, walker, step = at + step, found, there, min(1.5 * step, 0.2 * (at + step))
        if math.isnan(unstable) and abs(point.floquet_multipliers[0]) > 1.0:
            unstable, seen = at, complex(point.floquet_multipliers[0])
    limp = limp_of(walker, point).limp
    nearest = point.floquet_multipliers[np.argmin(np.abs(point.floquet_multipliers - 1.0))]
    return Limit(unstable, math.nan if at >= end else at, (seen, complex(nearest)), limp)


def limits(parameters: Parameters, designs: int, seed: int) -> Iterator[tuple[str, str, Limit]]:
    """What differs, in which unit, and how far it may."""
    own, slope = parameters.biped, parameters.slope
    for key in ("leg_length", "foot_mass", "foot_radius", "foot_com", "stiffness", "damping"):
        for sign, word in ((1.0, "more"), (-1.0, "less")):

            def one(share: float, key: str = key, sign: float = sign) -> Biped:
                return replace(own, **{f"other_{key}": getattr(own, key) * (1.0 + sign * share)})

            yield f"Table 1, {key}, {word}", "%", followed(one, slope, 1e-6, 0.9)
    for number, ((alike, unequal), _) in enumerate(islice(accepted(parameters, seed), designs), 1):

        def all_of(times: float, alike: Biped = alike, unequal: Biped = unequal) -> Biped:
            names = [field.name for field in fields(Leg)]
            return replace(alike, **{
                f"other_{name}": getattr(alike, name) + times * (
                    unequal.number(f"other_{name}") - getattr(alike, name)) for name in names})

        yield f"design {number}, all as drawn", "times", followed(all_of, slope, 1e-3, 1e3)


def print_limits(parameters: Parameters, designs: int, seed: int) -> None:
    """The limits as a table."""
    print("| what differs | unstable from | multiplier there | lost at | multiplier nearest one | limp there |")
    print("|---|---|---|---|---|---|")
    for what, unit, limit in limits(parameters, designs, seed):
        cells = [f"{100 * value:.3g} %" if unit == "%" else f"{value:.3g} times" for value in
                 (limit.unstable, limit.lost)]  # fmt: skip
        cells = ["-" if "nan" in cell else cell for cell in cells]
        shown = ["-" if math.isnan(value.real) else f"{value.real:.3f}" + (
            f" {value.imag:+.3f}i" if value.imag else "") for value in limit.multipliers]
        print(f"| {what} | {cells[0]} | {shown[0]} | {cells[1]} | {shown[1]} | {100 * limit.limp:.3g} % |", flush=True)


def text(beside: Beside) -> str:
    """One line of a table."""
    own, other = beside.multipliers
    off, simple = np.abs(other - own), beside.constraint.row
    return (
        f"{1e3 * simple.period_s:8.2f} {1e3 * beside.period:+6.2f} {1e3 * simple.step_length_m:7.2f} "
        f"{1e3 * beside.step_length:+5.2f}  {beside.limps[0]:+.4f} {beside.limps[1]:+.4f}  "
        f"{own[0]:.3f} {own[1]:.3f}  {off[0]:.3f} {off[1]:.3f}  "
        f"{1e3 * beside.hip[0]:.2f} {1e3 * beside.hip[1]:.2f}"
    )


def main() -> None:
    """Print the table, and the largest differences of either kind."""
    asked = [word for word in sys.argv[1:] if word != "--limits"]
    designs, seed = (int(value) for value in [*asked[:2], *("10", "20")[len(asked) :]])
    parameters = load(locate(None).params, [], {"twin_ladder": Parameters}, [Parameters, RoughGround])["twin_ladder"]
    if "--limits" in sys.argv:
        print_limits(parameters, designs, seed)
        return
    print("           T [ms] Exudyn  s [mm] Exudyn  limp, Exudyn's  multipliers, Exudyn off by  hip x, y [mm]")
    rows = []
    for number, pair in enumerate(compared(parameters, designs, seed), 1):
        for what, beside in zip(("alike", "unequal"), pair, strict=True):
            print(f"{number:3d} {what:8s}{text(beside)}", flush=True)
        rows.append(pair)
    for kind, what in enumerate(("alike", "unequal")):
        sizes = [abs(getattr(pair[kind], name)) for name in ("period", "step_length") for pair in rows]
        half = len(rows)
        limps = max(abs(pair[kind].limps[1] - pair[kind].limps[0]) for pair in rows)
        print(f"{what}: period off by {1e3 * min(sizes[:half]):.2f} to {1e3 * max(sizes[:half]):.2f} ms, length by "
              f"{1e3 * min(sizes[half:]):.2f} to {1e3 * max(sizes[half:]):.2f} mm, limp by at most {limps:.1e}")


if __name__ == "__main__":
    main()
