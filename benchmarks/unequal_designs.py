"""Designs with legs that differ: the constraint model against Exudyn, as near as for legs that are alike?

    python benchmarks/unequal_designs.py [DESIGNS [SEED]]

Ten designs drawn by a seed, each with frames, masses off the legs' lines and a hip with spring and damper, and each
twice: with legs that are alike, and with legs of which one differs in every number, by up to 1 % (its length by up to
0.02 mm: a walker of this kind limps a thousand times as much as its legs differ in length). Of each: period, step
length, limp and the two largest multipliers of a stride of the constraint model's gait, and by how much those of
Exudyn's planar model, with the study's ground, differ; and the largest difference of the hips at equal phase over a
stride. Designs without a stable gait are passed over.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.parameters.loading import load
from pipeline.study import locate
from stages.biped.design import Biped
from stages.biped.leg import Leg
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.parameters import Settings
from stages.multibody.walking.limit_cycle import SectionWalker
from stages.multibody.walking.walk import simulate
from stages.planar.limit_cycle import fixed_point, floquet_multipliers
from stages.planar.section import NoLimitCycle, section_numbers, section_state
from stages.planar.state import rolling_state
from stages.twin_ladder.constraint_side import PHASES, ConstraintGait, constraint_gait
from stages.twin_ladder.parameters import Parameters
from stages.twin_ladder.result import COMPLETED

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
TOLERANCE, RESIDUAL, ALONG, LARGEST_STEP = 1e-8, 1e-5, 5e-4, 1e-3


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
    names = [field.name for field in dataclasses.fields(Leg)]
    while True:
        alike = dataclasses.replace(like, **{key: float(generator.uniform(*ends)) for key, ends in RANGES.items()})
        off = dict(zip(names, generator.uniform(-1.0, 1.0, len(names)), strict=True))
        other = {f"other_{name}": getattr(alike, name) * (1.0 + DIFFERENCE * part) for name, part in off.items()}
        other["other_leg_length"] = alike.leg_length + LENGTH_DIFFERENCE * off["leg_length"]
        yield alike, dataclasses.replace(alike, **other)


def beside_exudyn(biped: Biped, slope: Slope, contact: ContactLaw, constraint: ConstraintGait) -> Beside:
    """A design's gait in Exudyn beside that of the constraint model. Raises NoLimitCycle."""
    start = rolling_state(biped, contact, constraint.mid_stance, constraint.standing_force)
    settings = Settings.of_one_step(TOLERANCE, LARGEST_STEP)
    walker = SectionWalker(biped, slope, contact, start, settings, ALONG)
    point = fixed_point(walker, section_numbers(start), RESIDUAL)
    steps, derivative = 2 // walker.steps_a_cycle, walker.derivative(point.numbers)
    multipliers = floquet_multipliers(np.linalg.matrix_power(derivative, steps))[:2] @ [1.0, 1.0j]
    here = section_state(point.numbers, start)
    first, stride = (walker.walk(here, count) for count in (1, 2))
    run = simulate(biped, slope, contact, here, settings, steps=2)
    hip = run.trajectory.at(stride.duration * PHASES)[0][:, :2]
    return Beside(
        constraint=constraint,
        period=0.5 * stride.duration - constraint.period,
        step_length=0.5 * stride.length - constraint.step_length,
        limps=(constraint.limp, (4.0 * first.duration - 2.0 * stride.duration) / stride.duration),
        multipliers=np.array([constraint.multipliers**2, multipliers]),
        hip=np.abs(hip - constraint.hip).max(axis=0),
    )


def compared(parameters: Parameters, designs: int, seed: int) -> Iterator[tuple[Beside, Beside]]:
    """So many drawn designs that walk in both models, with legs alike and with legs that differ."""
    ground, found = (parameters.slope, parameters.contact), 0
    for pair in drawn(seed, parameters.biped):
        gaits = [constraint_gait(each, parameters.slope, TOLERANCE) for each in pair]
        if any(gait.outcome != COMPLETED or abs(gait.multipliers[0]) ** 2 > STABLE for gait in gaits):
            continue
        try:
            alike, unequal = (beside_exudyn(each, *ground, gait) for each, gait in zip(pair, gaits, strict=True))
        except NoLimitCycle as reason:
            print(f"no gait in Exudyn: {reason}")
            continue
        yield alike, unequal
        found += 1
        if found == designs:
            return


def text(beside: Beside) -> str:
    """One line of a table."""
    own, other = beside.multipliers
    off = np.abs(other - own)
    return (
        f"{1e3 * beside.constraint.period:8.2f} {1e3 * beside.period:+6.2f} {1e3 * beside.constraint.step_length:7.2f} "
        f"{1e3 * beside.step_length:+5.2f}  {beside.limps[0]:+.4f} {beside.limps[1]:+.4f}  "
        f"{own[0]:.3f} {own[1]:.3f}  {off[0]:.3f} {off[1]:.3f}  "
        f"{1e3 * beside.hip[0]:.2f} {1e3 * beside.hip[1]:.2f}"
    )


def main() -> None:
    """Print the table, and the largest differences of either kind."""
    designs, seed = (int(value) for value in [*sys.argv[1:3], *("10", "20")[len(sys.argv) - 1 :]])
    parameters = load(locate(None).params, [], {"twin_ladder": Parameters}, [Parameters])["twin_ladder"]
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
