"""Let the twin walk: the one entry for everything that needs such a walk."""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass

import numpy as np

from stages.biped.gait import StanceState
from stages.ground.contact_law import ContactLaw
from stages.ground.normal_force import static_penetration
from stages.ground.slope import Slope
from stages.multibody.assembly.quiet_exudyn import SOLVER_ERRORS
from stages.multibody.assembly.solver import (
    EVALUATIONS,
    LAST_SOLVER,
    SOLVER,
    explicit_settings,
    first_sentence,
    further_evaluations,
    valid_rows,
)
from stages.planar.run import DIVERGED, RUNNING, SOLVER_FAILED, STALLED, patience
from stages.twin.machine.contact import COUNT, HINGE, PITCH, ROLL, SLIDE, YAW, X, Y, Z
from stages.twin.machine.machine import Machine
from stages.twin.machine.tree import SpatialTree
from stages.twin.parameters import Settings
from stages.twin.ramp import Ramp
from stages.twin.walking.ramp_watch import RampWatch
from stages.twin.walking.record import Record
from stages.twin.walking.watch import Watch


@dataclass(frozen=True)
class Start:
    """Initial coordinates and rates of the tree (11,), and whether the ground acts on each pair."""

    position: np.ndarray
    velocity: np.ndarray
    in_play: tuple[bool, bool] = (True, False)


def rolling_start(
    machine: Machine,
    contact: ContactLaw,
    stance: StanceState,
    normal_force: float,
    *,
    yaw: float = 0.0,
    yaw_rate: float = 0.0,
    roll_rate: float = 0.0,
    sideways: float = 0.0,
) -> Start:
    """The simple model's state given to the twin: inner pair standing and rolling, outer pair swinging, out of play.

    Both feet of the inner pair are pressed into the ground by `normal_force` [N] in all. Leg lengths of `stance` are
    those of the simple model; a longer machine keeps its springs as loaded. Yaw [rad], its rate and that of roll
    [rad/s] and a speed to the side [m/s] are pushes that the simple model does not know.
    """
    drawn = machine.drawn_length
    r = float(np.mean(machine.radius[:2]))
    theta, length = stance.stance_angle, stance.stance_length + float(np.mean(machine.length[:2])) - drawn
    rate, length_rate = stance.stance_rate, stance.stance_length_rate
    sine, cosine = math.sin(theta), math.cos(theta)
    q, v = np.zeros(COUNT), np.zeros(COUNT)
    q[X] = r * theta + (length - r) * sine
    q[Y] = r + (length - r) * cosine - static_penetration(contact, max(normal_force, 0.0))
    forward = r * rate + length_rate * sine + rate * (length - r) * cosine
    v[X], v[Z] = forward * math.cos(yaw), sideways - forward * math.sin(yaw)
    v[Y] = length_rate * cosine - rate * (length - r) * sine
    q[YAW], v[YAW], v[ROLL] = yaw, yaw_rate, roll_rate
    q[PITCH], v[PITCH] = -theta, -rate
    q[HINGE], v[HINGE] = stance.swing_angle + theta, stance.swing_rate + rate
    for leg, slide in enumerate(SLIDE):
        standing = leg < 2
        q[slide] = drawn - (stance.stance_length if standing else stance.swing_length)
        v[slide] = -(stance.stance_length_rate if standing else stance.swing_length_rate)
    return Start(q, v)


def simulate_twin(
    machine: Machine,
    slope: Slope,
    contact: ContactLaw,
    start: Start,
    settings: Settings,
    *,
    steps: int | None = None,
    tree: SpatialTree | None = None,
    ramp: Ramp | None = None,
) -> Record:
    """Walk from `start` at t = 0 through `steps` heel strikes (default: the settings') to the mid-stance after them.

    With a `ramp` there is ground on its blocks only, and the walk ends at the latest on the last of them. A fall, a
    standstill or a failure of the solver ends the walk earlier; the record's outcome and reason tell it.
    Pass a built `tree` of the same machine to save building it again.
    """
    wanted_steps = settings.steps if steps is None else steps
    if ramp is not None:
        wanted_steps = min(wanted_steps, ramp.steps)
    machine_tree = tree or SpatialTree(machine, slope, contact)
    machine_tree.start(start.position, start.velocity, start.in_play)
    standing = list(start.in_play)
    longest_step = patience(settings.longest_step, machine.drawn_length, slope)
    common = machine_tree, wanted_steps, longest_step, standing, standing.copy(), int(not standing[0])
    watch = Watch(*common) if ramp is None else RampWatch(*common, ramp=ramp)
    watch.most_calls = settings.most_solver_steps
    machine_tree.mbs.SetPreStepUserFunction(watch)
    limit = longest_step * (wanted_steps + 2)
    machine_tree.mbs.sys.pop(LAST_SOLVER, None)
    began = clock.perf_counter()
    try:
        wanted = explicit_settings(settings.tolerance, settings.largest_step, limit)
        machine_tree.mbs.SolveDynamic(wanted, solverType=SOLVER.DOPRI5)
    except SOLVER_ERRORS as error:
        if watch.outcome == RUNNING:
            watch.outcome = SOLVER_FAILED
            watch.reason = first_sentence(error)
    if watch.outcome == RUNNING:
        watch.outcome, watch.reason = STALLED, f"{wanted_steps} steps not done in {limit:g} s"
    rows = _recording(machine_tree, watch)
    evaluations = EVALUATIONS * (len(rows[0]) - 1) + further_evaluations(machine_tree.mbs)
    return Record(
        machine, slope, contact, *rows, start.in_play, tuple(watch.switches), watch.outcome,
        watch.reason, watch.heel_strikes, evaluations, clock.perf_counter() - began,
    )  # fmt: skip


def _recording(tree: SpatialTree, watch: Watch) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """What the tree recorded, up to the first value that is not finite; then the watch is told."""
    time, position, velocity, acceleration = tree.recording()
    keep = valid_rows(time, position, velocity)
    if not (np.isfinite(position).all() and np.isfinite(velocity).all()):
        watch.outcome, watch.reason = DIVERGED, "the state is not finite"
    time, position, velocity, acceleration = time[keep], position[keep], velocity[keep], acceleration[keep]
    if len(time) > 1:
        acceleration[0] = acceleration[1]
    return time, position, velocity, acceleration
