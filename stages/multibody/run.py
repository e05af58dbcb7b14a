"""The multibody stage: an independent model of the biped in Exudyn, walking from the analytic gait's mid-stance."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from stages.analytic.result import Inputs
from stages.biped.accuracy.estimate import ErrorEstimate, to_accuracy, walk_differences
from stages.biped.design import require_own_strikes
from stages.biped.processes import Progress, ignore
from stages.biped.walk import Walk
from stages.ground.blocks import Laid
from stages.ground.friction import lanes
from stages.multibody.assembly.inventory import bytes_of, take_inventory
from stages.multibody.assembly.planar import Planar
from stages.multibody.assembly.system import VERSION
from stages.multibody.parameters import Parameters, Settings
from stages.multibody.result import Facts, Result
from stages.multibody.walking.cycle import solve
from stages.multibody.walking.walk import build, simulate
from stages.planar.energy import EnergyBalance, energy_balance
from stages.planar.run import PlanarState, Run, foot_kinematics, rolling_state
from stages.planar.sampling import sample
from stages.planar.signals import PENETRATION, SLIP


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Walk and measure. The analytic gait gives the mid-stance state, the normal force of its first sample and, for
    stepping blocks, the step length.

    A fall or a failed solver is a result whose `outcome` says so, with the walk up to there. Raises NotMet if an
    accuracy is requested that the walk does not keep with the finest settings, BeyondModel for a strike at a given
    time, BlocksDoNotFit for blocks of drawn heights that overlap.
    """
    require_own_strikes(parameters.biped, "Exudyn's planar model")
    analytic = inputs.analytic
    biped, contact = parameters.biped, parameters.contact
    progress(0.0, f"walking {parameters.settings.steps} steps in Exudyn ({parameters.settings.assembly})")
    state = rolling_state(biped, contact, analytic.mid_stance, analytic.walk.standing_force)
    laid = parameters.blocks.under(0, analytic.limp.feet_apart_m)
    settings, (assembly, walked, walk), errors = walk_to_accuracy(
        parameters, state, analytic.gait.step_length_m, laid)
    progress(0.3, "measuring the walk")
    penetration, slip = contact_signals(walked, walk, biped.foot_radii, settings.signals)
    inventory = take_inventory(assembly.mbs, sampled_bytes=bytes_of(walk, penetration, slip))
    progress(0.4, "solving for the gait")
    cycle, found, reason = solve(replace(parameters, settings=settings), state, walked, walk)
    return Result(
        outcome=walked.outcome,
        message=walked.message,
        steps=walked.heel_strikes,
        walk=walk,
        penetration=penetration,
        slip_velocity=slip,
        settled=not reason,
        unsettled=reason,
        cycle=cycle,
        mid_stance=found,
        energy=_last_step_energy(walked, walk, parameters),
        errors=errors,
        facts=_facts(walked, settings),
        inventory=inventory,
    )


def walk_to_accuracy(
    parameters: Parameters, state: PlanarState, step_length: float, laid: Laid | None = None
) -> tuple[Settings, tuple[Planar, Run, Walk], tuple[ErrorEstimate, ...]]:
    """The walk from `state` with the settings that keep the accuracy requested, and its estimated errors.

    Rows of blocks, if any, lie `step_length` [m] apart; those `laid` have drawn heights. Raises NotMet.
    """
    biped, slope, contact, settings = parameters.biped, parameters.slope, parameters.contact, parameters.settings
    rows = lanes(step_length, parameters.blocks.block_length) if settings.scene == "blocks" else None

    def walked(settings: Settings) -> tuple[Planar, Run, Walk]:
        assembly = build(biped, slope, contact, settings, rows, signals=settings.signals, rough=laid is not None)
        run = simulate(biped, slope, contact, state, settings, lanes=rows, blocks=laid, assembly=assembly)
        return assembly, run, sample(run.trajectory, biped, slope, settings.sampling_rate_hz)

    return to_accuracy(
        settings.accuracy, settings, walked, Settings.finer, lambda one, other: walk_differences(one[2], other[2]))


def contact_signals(
    walked: Run, walk: Walk, radii: tuple[float, float], signals: Collection[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Penetration [m] and slip velocity [m/s] of both feet on the walk's grid, zero out of contact, each (n, 2).

    (0, 2) where `signals` does not name it.
    """
    position, velocity = walked.trajectory.at(walk.time)
    held, ground = walked.trajectory.in_play(walk.time), walked.trajectory.under(walk.time)
    penetration, slip = np.zeros_like(held, dtype=float), np.zeros_like(held, dtype=float)
    for leg in (0, 1):
        depth, _, sliding = foot_kinematics(position, velocity, leg, radii[leg], ground[:, leg])
        touching = held[:, leg] & (depth > 0.0)
        penetration[:, leg] = np.where(touching, depth, 0.0)
        slip[:, leg] = np.where(touching, sliding, 0.0)
    nothing = np.zeros((0, 2))
    return penetration if PENETRATION in signals else nothing, slip if SLIP in signals else nothing


def _last_step_energy(walked: Run, walk: Walk, parameters: Parameters) -> EnergyBalance:
    if len(walk.heel_strike_time) < 2:
        return EnergyBalance(*[float("nan")] * 6)
    start, end = walk.heel_strike_time[-2:]
    return energy_balance(walked.trajectory, parameters.biped, parameters.slope, parameters.contact, start, end)


def _facts(walked: Run, settings: Settings) -> Facts:
    time = walked.trajectory.time
    spans = np.diff(time[time > 1e-3])
    return Facts(
        assembly=settings.assembly,
        solver="DOPRI5" if settings.assembly == "tree" else settings.implicit_solver,
        exudyn_version=VERSION,
        solver_steps=walked.solver_steps,
        smallest_step=float(spans.min()) if len(spans) else float("nan"),
        joint_drift=walked.joint_drift,
    )
