"""The pushes stage: the twin's basin against pushes to the side, and how roll, yaw and drift settle.

Inputs: the analytic gait to start from. Settings: params/twin_pushes.yaml. Output: `Result`, a walk for each push.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import inf

from stages.analytic.result import Inputs
from stages.biped.between_steps import uniform_times
from stages.biped.processes import Progress, ignore
from stages.twin.machine.contact import ROLL, YAW, Z
from stages.twin.machine.projection import machine_of
from stages.twin.machine.tree import SpatialTree
from stages.twin.walking.measures import largest_roll
from stages.twin.walking.record import Record, find_events
from stages.twin.walking.simulate import rolling_start, simulate_twin
from stages.twin_pushes.parameters import KINDS, Parameters
from stages.twin_pushes.result import PushedWalk, Result


def again(parameters: Parameters, inputs: Inputs, result: Result) -> Result:
    """The result at closer settings: of each kind the largest push that is survived and the smallest that is not, as a
    fall enlarges errors, and the others as they were."""
    few = [(kind, size) for kind, _, *sizes in result.limits() for size in sizes if 0.0 < size < inf]
    found = dict(zip(few, walks_after(few, parameters, inputs), strict=True))
    return replace(result, walks=tuple(found.get((walk.kind, walk.size), walk) for walk in result.walks))


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Push and walk on. Raises ValueError if the twin's parts do not add up to the design, BeyondModel for feet that
    are put down at a time."""
    pushes = [(kind, size) for key, _, kind, _ in KINDS for size in getattr(parameters.settings, key)]
    walks = tuple(walks_after(pushes, parameters, inputs, progress))
    alone = [] if any(walk.survived for walk in walks) else walks_after([(pushes[0][0], 0.0)], parameters, inputs)
    return Result(walks, falls_alone=not all(walk.survived for walk in alone))


def walks_after(
    pushes: Sequence[tuple[str, float]], parameters: Parameters, inputs: Inputs, progress: Progress = ignore
) -> Iterator[PushedWalk]:
    """The walks after pushes of a kind and size. A fall is a walk that ends early.

    The analytic gait gives the mid-stance state and the normal force of its first sample.
    """
    analytic, settings = inputs.analytic, parameters.settings
    machine = machine_of(parameters.biped, parameters.twin)
    tree = SpatialTree(machine, parameters.slope, parameters.contact)
    solver = parameters.twin.with_tolerance(settings.tolerance)
    force = analytic.walk.standing_force
    ways = {kind: (keyword, unit) for _, keyword, kind, unit in KINDS}
    for number, (kind, size) in enumerate(pushes):
        keyword, unit = ways[kind]
        progress(number / len(pushes), f"{kind} {size:.3g} {unit}")
        start = rolling_start(machine, parameters.contact, analytic.mid_stance, force, **{keyword: size})
        record = simulate_twin(
            machine, parameters.slope, parameters.contact, start, solver, steps=settings.steps, tree=tree
        )
        yield pushed_walk(record, kind, unit, size, settings.rate_hz)


def pushed_walk(record: Record, kind: str, unit: str, size: float, rate_hz: float) -> PushedWalk:
    """What is kept of a walk after a push."""
    times = uniform_times(float(record.time[-1]), rate_hz)
    q = record.at(times)[0]
    roll_left = yaw_left = float("nan")
    if record.completed:
        strikes = find_events(record).heel_strike_time
        roll_left = largest_roll(record, float(strikes[-3]))
        yaw_left = float(record.position[-1, YAW])
    return PushedWalk(
        kind=kind,
        unit=unit,
        size=size,
        outcome=record.outcome,
        reason=record.reason,
        steps=record.heel_strikes,
        time=times,
        roll=q[:, ROLL].copy(),
        yaw=q[:, YAW].copy(),
        lateral=q[:, Z].copy(),
        roll_left=roll_left,
        yaw_left=yaw_left,
    )
