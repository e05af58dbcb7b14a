"""The twin stage: the spatial machine, built from its parts, walking from the simple model's fixed point."""

import numpy as np

from stages.analytic.result import Inputs
from stages.biped.accuracy.estimate import finer_explicit, to_accuracy, walk_differences
from stages.biped.accuracy.scales import scales_of
from stages.biped.between_steps import refined_times
from stages.biped.processes import Progress, ignore
from stages.biped.walk import Walk
from stages.multibody.assembly.inventory import bytes_of, take_inventory
from stages.twin.machine.bill import sums
from stages.twin.machine.parts import Part, solid
from stages.twin.machine.projection import machine_of
from stages.twin.machine.tree import SpatialTree
from stages.twin.parameters import Parameters, Settings
from stages.twin.ramp import lay_blocks
from stages.twin.result import EnergyBalance, PartRow, Result, Signals, SumRow
from stages.twin.walking.measures import energy_balance, settling
from stages.twin.walking.record import Record, find_events, sample, snapshots
from stages.twin.walking.simulate import rolling_start, simulate_twin

#: Poses kept for the figure: this many, evenly over the last two strides.
POSES = 13


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Build, walk, measure; what a design in detail adds to its plain one is added to the machine, not to its bill.

    The analytic gait gives the mid-stance state, the normal force of its first sample and the
    step length for which the ramp's blocks are laid.

    A fall or a failed solver is a result whose `outcome` says so, with the walk up to there. Raises ValueError if the
    parts do not add up to the design, BeyondModel for feet that are put down at a time, BlocksDoNotFit if the ramp has
    no room for its blocks or they overlap, NotMet if an accuracy is requested that the walk does not keep with the
    finest settings.
    """
    biped, slope, contact, settings = parameters.biped, parameters.slope, parameters.contact, parameters.settings
    analytic = inputs.analytic
    machine, plain = machine_of(biped, settings), biped.plain()
    start = rolling_start(machine, contact, analytic.mid_stance, analytic.walk.standing_force)
    ramp = lay_blocks(settings, parameters.blocks, analytic.gait.step_length_m) if settings.scene == "ramp" else None
    laid = parameters.blocks.under(0, analytic.limp.feet_apart_m)
    progress(0.0, f"walking {settings.steps} steps in space")

    pendulum_time = scales_of(biped, slope.gravity).time

    def walked_with(settings: Settings) -> tuple[SpatialTree, Record, Signals]:
        tree = SpatialTree(machine, slope, contact)
        record = simulate_twin(machine, slope, contact, start, settings, ramp=ramp, blocks=laid, tree=tree)
        strikes = find_events(record).heel_strike_time
        times = refined_times(float(record.time[-1]), settings.sampling_rate_hz, strikes, pendulum_time)
        return tree, record, sample(record, times, settings)

    settings, (tree, record, signals), errors = to_accuracy(
        settings.accuracy, settings, walked_with, finer_explicit,
        lambda one, other: walk_differences(one[2].walk, other[2].walk))
    progress(0.8, "measuring the walk")
    strikes = signals.walk.heel_strike_time
    last_step = tuple(strikes[-2:]) if len(strikes) > 1 else ()
    bill = settings.bill(plain)
    closed = energy_balance(record, *last_step) if last_step else EnergyBalance(*[np.nan] * 6)
    return Result(
        outcome=record.outcome,
        reason=record.reason,
        steps=record.heel_strikes,
        signals=signals,
        settling=settling(record, signals.walk),
        energy=closed,
        snapshots=snapshots(record, pose_times(signals.walk)),
        parts=tuple(part_row(part) for part in bill),
        sums=tuple(SumRow(what, found, wanted) for what, found, wanted in sums(bill, plain)) if bill else (),
        bill=settings.bill_rule(plain),
        errors=errors,
        solver_steps=len(record.time) - 1,
        inventory=take_inventory(tree.mbs, len(tree.feet), bytes_of(signals)),
    )


def pose_times(walk: Walk) -> np.ndarray:
    """Times evenly over the last two strides, or over the whole walk if it is shorter [s]."""
    strikes = walk.heel_strike_time
    begin = strikes[-5] if len(strikes) >= 5 else walk.time[0]
    end = strikes[-1] if len(strikes) >= 5 else walk.time[-1]
    return np.linspace(begin, end, POSES)


def part_row(part: Part) -> PartRow:
    """The row with the inertia that follows from its shape."""
    shape = solid(part.shape, part.size, part.axis)
    size = " x ".join(f"{1e3 * value:g}" for value in part.size)
    x, y, z = (a + b for a, b in zip(part.position, shape.centroid, strict=True))
    words = f"{part.shape} {part.axis} {size}" if part.shape in ("cylinder", "tube") else f"{part.shape} {size}"
    return PartRow(
        part.name, part.group, part.material, words.strip(), part.pieces, part.mass, x, y, z, *shape.inertia(part.mass)
    )
