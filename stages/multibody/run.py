"""The multibody stage: an independent model of the biped in Exudyn, walking from the analytic gait's mid-stance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from stages.biped.progress import Progress, ignore
from stages.biped.walk import Walk
from stages.ground.blocks import lanes
from stages.multibody.energy import EnergyBalance, energy_balance
from stages.multibody.parameters import Parameters, Settings
from stages.multibody.quiet_exudyn import exudyn
from stages.multibody.result import Cycle, Facts, Result
from stages.multibody.solver import Run
from stages.multibody.state import rolling_state
from stages.multibody.trajectory import foot_kinematics
from stages.multibody.walk import sample, simulate

SETTLED_STEPS = 4


def run(parameters: Parameters, inputs: Mapping[str, Any], progress: Progress = ignore) -> Result:
    """Walk and measure. inputs["analytic"] gives the mid-stance state, the normal force of its first sample and, for
    stepping blocks, the step length.

    A fall or a failed solver is a result whose `outcome` says so, with the walk up to there.
    """
    analytic = inputs["analytic"]
    biped, slope, contact, settings = parameters.biped, parameters.slope, parameters.contact, parameters.settings
    standing_force = float(analytic.walk.ground_reaction[0, 0, 1])
    state = rolling_state(biped, contact, analytic.mid_stance, standing_force)
    progress(0.0, f"walking {settings.steps} steps in Exudyn ({settings.assembly})")
    blocks = lanes(analytic.gait.step_length_m, settings.block_length) if settings.scene == "blocks" else None
    walked = simulate(biped, slope, contact, state, settings, lanes=blocks)
    progress(0.8, "sampling the walk")
    walk = sample(walked.trajectory, slope, biped.foot_radius, settings.sampling_rate_hz)
    penetration, slip = contact_signals(walked, walk, biped.foot_radius)
    return Result(
        outcome=walked.outcome,
        message=walked.message,
        steps=walked.heel_strikes,
        walk=walk,
        penetration=penetration,
        slip_velocity=slip,
        cycle=settled_cycle(walked, walk, biped.foot_radius),
        energy=_last_step_energy(walked, walk, parameters),
        facts=_facts(walked, settings),
    )


def contact_signals(walked: Run, walk: Walk, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Penetration [m] and slip velocity [m/s] of both feet on the walk's grid, zero out of contact, each (n, 2)."""
    position, velocity = walked.trajectory.at(walk.time)
    held = walked.trajectory.in_play(walk.time)
    penetration, slip = np.zeros_like(held, dtype=float), np.zeros_like(held, dtype=float)
    for leg in (0, 1):
        depth, _, sliding = foot_kinematics(position, velocity, leg, radius)
        touching = held[:, leg] & (depth > 0.0)
        penetration[:, leg] = np.where(touching, depth, 0.0)
        slip[:, leg] = np.where(touching, sliding, 0.0)
    return penetration, slip


def settled_cycle(walked: Run, walk: Walk, radius: float) -> Cycle:
    """Measures over the last four whole steps, or fewer if there are no more; peaks at the solver's own steps."""
    strikes = walk.heel_strike_time
    count = min(SETTLED_STEPS, len(strikes) - 1)
    if count < 1:
        return Cycle(*[float("nan")] * 8)
    last = strikes[-1 - count :]
    periods = np.diff(last)
    period = float(periods.mean())
    hip = walked.trajectory.at(last)[0][:, 0]
    length = float((hip[-1] - hip[0]) / count)
    inside = (walked.trajectory.time >= last[0]) & (walked.trajectory.time <= last[-1])
    held = walked.trajectory.in_play(walked.trajectory.time)
    rows = walked.trajectory.position, walked.trajectory.velocity
    depth = np.column_stack([foot_kinematics(*rows, leg, radius)[0] for leg in (0, 1)])
    return Cycle(
        period_s=period,
        step_frequency_hz=1.0 / period,
        step_length_m=length,
        speed_m_s=length / period,
        double_stance_s=_double_stance(walk, last),
        peak_normal_force=float(walked.trajectory.ground_reaction[inside, :, 1].max()),
        largest_penetration=float(np.where(held, depth, 0.0)[inside].max()),
        period_change=float(np.ptp(periods)),
    )


def _double_stance(walk: Walk, strikes: np.ndarray) -> float:
    spans = []
    for strike in strikes:
        leg = walk.heel_strike_leg[np.searchsorted(walk.heel_strike_time, strike)]
        after = walk.toe_off_time[(walk.toe_off_time > strike) & (walk.toe_off_leg != leg)]
        if len(after):
            spans.append(after[0] - strike)
    return float(np.mean(spans)) if spans else float("nan")


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
        exudyn_version=exudyn.__version__,
        solver_steps=walked.solver_steps,
        smallest_step=float(spans.min()) if len(spans) else float("nan"),
        joint_drift=walked.joint_drift,
    )
