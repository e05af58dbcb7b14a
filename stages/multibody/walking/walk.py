"""Let the planar multibody biped walk: the one entry for everything that needs such a walk."""

import dataclasses
import math
import sys
from collections.abc import Collection
from functools import partial

from stages.biped.design import Biped
from stages.ground.blocks import Laid
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import SCALARS, Lane
from stages.ground.slope import Slope
from stages.multibody.assembly.planar import Planar
from stages.multibody.assembly.solver import explicit_plan, solve, stepped_plan
from stages.multibody.parameters import Settings
from stages.multibody.walking.watch import BlocksWatch, Watch
from stages.planar.run import COMPLETED, FALLEN, STALLED, PlanarState, Run, Trajectory, patience
from stages.planar.signals import SIGNALS


def build(
    biped: Biped,
    slope: Slope,
    contact: ContactLaw,
    settings: Settings,
    lanes: tuple[Lane, Lane] | None = None,
    *,
    compiled: bool = True,
    signals: Collection[str] = SIGNALS,
    rough: bool = False,
) -> Planar:
    """The assembly that the settings choose, with sensors for `signals`, see `stages.planar.run`.

    `compiled=False` evaluates the contact in Python, for benchmarks. A `rough` ground has heights.
    """
    if settings.assembly == "tree":
        from stages.multibody.assembly.tree import Tree

        return Tree(biped, slope, contact, lanes, compiled=compiled, signals=signals, rough=rough)
    from stages.multibody.assembly.joints import Joints

    return Joints(biped, slope, contact, lanes, compiled=compiled, signals=signals, rough=rough)


def simulate(
    biped: Biped,
    slope: Slope,
    contact: ContactLaw,
    state: PlanarState,
    settings: Settings,
    *,
    steps: int | None = None,
    duration: float | None = None,
    lanes: tuple[Lane, Lane] | None = None,
    blocks: Laid | None = None,
    assembly: Planar | None = None,
) -> Run:
    """Walk from `state` at t = 0 through `steps` heel strikes (default: the settings') to the mid-stance after them.

    The walk ends in the solver step in which the hip passes over the foot that landed last, or after `duration` [s] if
    that is given. A fall, a standstill or a failure of the solver ends it earlier and is stated in the run's outcome.
    With `lanes` the feet stand on stepping blocks instead of the ideal ground, see `stages.multibody.walking.watch`.
    `blocks` have drawn heights. Pass a built `assembly` of the same design (and the same lanes; rough for blocks) to
    save building it again.
    """
    machine = assembly or build(biped, slope, contact, settings, lanes, rough=blocks is not None)
    if lanes:
        state = dataclasses.replace(state, in_play=_over_blocks(state, biped.foot_radii, lanes))
    standing = _standing(state, biped.foot_radii)
    made = partial(BlocksWatch, lanes=lanes) if lanes else Watch
    watch = made(
        walker=machine,
        fallen=FALLEN * biped.leg_length,
        longest_step=patience(settings.longest_step, biped.leg_length, slope),
        steps_wanted=(settings.steps if steps is None else steps) if duration is None else sys.maxsize,
        in_play=list(state.in_play),
        landed=standing,
        last_landed=1 if standing == [False, True] else 0,
        most_calls=settings.most_solver_steps,
        blocks=blocks,
    )
    machine.start(state)
    watch.lay_first()
    for leg in (0, 1) if lanes else ():  # the ground itself ends between blocks
        machine.set_in_play(leg, True)
    end = watch.limit if duration is None else duration
    explicit = settings.assembly == "tree"
    plan = (explicit_plan(settings.tolerance, settings.largest_step, end) if explicit
            else stepped_plan(settings, watch, end))  # fmt: skip
    rows, evaluations, drift = solve(machine, watch, plan, end, STALLED if duration is None else COMPLETED)
    trajectory = Trajectory(**rows, in_play_at_start=state.in_play, switches=tuple(watch.switches),
                            blocks=tuple(watch.laid), exact_acceleration=machine.exact_acceleration)  # fmt: skip
    count = len(trajectory.time) - 1
    return Run(watch.outcome, watch.message, trajectory, watch.heel_strikes, count, evaluations, drift)


def _standing(state: PlanarState, radii: tuple[float, float]) -> list[bool]:
    """Which feet touch the ground while it acts on them."""
    legs = zip(state.in_play, state.leg_length, state.leg_angle, radii, strict=True)
    return [
        acts and state.hip_position[1] - (length - radius) * math.cos(angle) <= radius
        for acts, length, angle, radius in legs
    ]


def _over_blocks(state: PlanarState, radii: tuple[float, float], lanes: tuple[Lane, Lane]) -> tuple[bool, bool]:
    legs = zip(state.leg_length, state.leg_angle, radii, strict=True)
    place = [state.hip_position[0] + (length - radius) * math.sin(angle) for length, angle, radius in legs]
    return lanes[0].presence(place[0], SCALARS) > 0.5, lanes[1].presence(place[1], SCALARS) > 0.5
