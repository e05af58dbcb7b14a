"""What is measured of a twin's walk: step by step, how it settles from the simple model's fixed point, and where its
energy goes.
"""

from functools import partial

import numpy as np

from stages.biped.between_steps import NODES, largest, quadrature
from stages.biped.walk import Walk
from stages.planar.run import hip_creep
from stages.twin.machine.contact import HINGE, ROLL, SLIDE, along, point_law
from stages.twin.machine.machine import FOOT_BODY, Machine
from stages.twin.machine.projection import project
from stages.twin.result import EnergyBalance, Settling
from stages.twin.walking.record import Record, pair_axes, point_motion

#: Steps at the end of a walk over which means are taken: two strides.
SETTLED_STEPS = 4
#: A step has settled when its period and its length are this close to the means of these that its leg takes.
SETTLED_WITHIN = 0.01
#: How the transient fades is seen by the largest of so many changes from stride to stride, and of those so many before.
SEEN, BEFORE = 3, 4
#: What it leaves is at most so many times what it would be if it faded as the largest of them does. Without this factor
#: the worst of 72 walks of 10 to 20 steps, of 8 bipeds, was .99.
SURE = 2.0
LATE, EARLY = slice(-SEEN, None), slice(-SEEN - BEFORE, -BEFORE)
#: What is to go of a limp moves the mean by its square over the mean, times 2 to 6 in walks of 100 bipeds; what fades
#: by less than this share in a stride is to go on for so long.
BENDS, LONG = 10.0, 0.99


def settling(record: Record, walk: Walk) -> Settling:
    """Measures of the walk's steps; steps are counted from the first heel strike."""
    strikes = walk.heel_strike_time
    if len(strikes) < 2:
        nothing = np.zeros(0)
        return Settling(nothing, nothing, -1)
    position = record.at(strikes)[0]
    periods, lengths = np.diff(strikes), np.diff(position[:, 0])
    yaw, sideways = (float(record.position[-1, i] - record.position[0, i]) for i in (3, 2))
    if len(periods) < SETTLED_STEPS:
        return Settling(periods, lengths, -1, yaw_change=yaw, lateral_drift=sideways)
    period, length = float(periods[-SETTLED_STEPS:].mean()), float(lengths[-SETTLED_STEPS:].mean())
    off = np.array([measure / of_its_leg(measure) - 1.0 for measure in (periods, lengths)])
    unsettled = np.flatnonzero((np.abs(off) >= SETTLED_WITHIN).any(axis=0))
    needed = int(unsettled[-1]) + 1 if len(unsettled) else 0
    left = transient_left(periods, lengths)
    return Settling(
        step_period=periods,
        step_length=lengths,
        steps_to_settle=needed if needed <= len(periods) - SETTLED_STEPS else -1,
        period_s=period,
        step_frequency_hz=1.0 / period,
        step_length_m=length,
        speed_m_s=length / period,
        double_stance_s=walk.double_stance(strikes[-1 - SETTLED_STEPS : -1]),
        inner_outer_difference=_limp(periods[-SETTLED_STEPS:], walk.heel_strike_leg[-1 - SETTLED_STEPS : -1]) / period,
        largest_roll=largest_roll(record, float(strikes[-1 - SETTLED_STEPS])),
        yaw_change=yaw,
        lateral_drift=sideways,
        period_transient_s=left[0],
        step_length_transient_m=left[1],
    )


def of_its_leg(measure: np.ndarray) -> np.ndarray:
    """Of each step (n,) the mean of the last two steps of the same leg: a robot may limp."""
    legs: np.ndarray = measure[-SETTLED_STEPS:].reshape(-1, 2).mean(axis=0)
    return legs[np.arange(-len(measure), 0) % 2]


def transient_left(*measures: np.ndarray) -> list[float]:
    """By how much the mean of the last two strides of a measure (n,) of steps may differ from where it settles.

    Of measures of the same steps, whose changes fade alike: that which fades slowest shows the rate. Multipliers may be
    of either sign, or complex: sums of two steps keep no limp, and a largest change of several does not miss one that
    passes zero. A limp moves the mean by its square, late and behind what fades faster: where that may count, its
    rate does too. NaN where changes do not fade, or the walk is too short.
    """
    if len(measures[0]) < SEEN + BEFORE + 3:
        return [float("nan")] * len(measures)
    late, kept = fading([0.5 * (measure[1:] + measure[:-1]) for measure in measures])
    limping, limp_kept = fading([0.5 * np.diff(measure) * (-1.0) ** np.arange(1, len(measure)) for measure in measures])
    share = min(limp_kept, LONG)
    to_go = np.array(limping) * share / (1.0 - share)
    left = _left(late, kept)
    bent = BENDS * to_go**2 / np.abs([measure.mean() for measure in measures])
    return _left(late, max(kept, limp_kept)) if (bent > left).any() else left


def fading(series: list[np.ndarray]) -> tuple[list[float], float]:
    """Of series (n,) of steps the largest late change in a stride of each, and which share a stride keeps of the one
    that fades slowest."""
    changes = [np.abs(each[2:] - each[:-2]) for each in series]
    late, early = ([float(change[part].max()) for change in changes] for part in (LATE, EARLY))
    return late, max(now / then if then else 0.0 for now, then in zip(late, early, strict=True)) ** (2.0 / BEFORE)


def _left(late: list[float], kept: float) -> list[float]:
    """What changes of this size in a stride leave, of which a stride keeps so much; NaN where they do not fade."""
    return [SURE * now * (kept / (1.0 - kept) + 0.5) if kept < 1.0 else float("nan") for now in late]


def largest_roll(record: Record, start: float) -> float:
    """Largest magnitude of roll [rad] from a time [s] to the end."""
    times = np.append(start, record.time[record.time > start])

    def roll(time: np.ndarray, side: float) -> np.ndarray:
        return np.asarray(side * record.at(time)[0][:, ROLL])

    return max(largest(times, roll(times, side), partial(roll, side=side))[1] for side in (1.0, -1.0))


def _limp(periods: np.ndarray, landing: np.ndarray) -> float:
    """Mean period of the steps that the inner pair's landing begins, less that of the outer pair's [s]."""
    if len(set(landing.tolist())) < 2:
        return float("nan")
    return float(periods[landing == 0].mean() - periods[landing == 1].mean())


def energy_balance(record: Record, start: float, end: float) -> EnergyBalance:
    """Energy balance between two times [s], the powers integrated by quadrature over the solver's own steps."""
    machine = record.machine
    time, weight = quadrature(record.time, start, end)
    q, v = record.at(time)
    # a switch happens at a solver step, so the middle of each span stands for the whole of it
    acts = np.repeat(record.ground(time[len(NODES) // 2 :: len(NODES)]), len(NODES), axis=0)
    ground = -along(q, v, acts, machine.feet, point_law(record.contact))[1]
    legs = (machine.damping * v[:, list(SLIDE)] ** 2).sum(axis=1)
    rubbing = machine.hip_friction * np.abs(v[:, HINGE]) * np.minimum(
        np.abs(v[:, HINGE]) / hip_creep(project(machine), record.slope), 1.0)
    bearing = machine.bearing_friction * v[:, HINGE] ** 2 + rubbing
    lost = float(weight @ legs), float(weight @ bearing), float(weight @ ground)
    (before, after), moment = mechanical_energy(machine, *record.at(np.array([start, end])))
    gravity = float((moment[1] - moment[0]) @ np.array([*record.slope.gravity_vector, 0.0]))
    stored = float(after - before)
    return EnergyBalance(gravity, *lost, stored, gravity - sum(lost) - stored)


def mechanical_energy(machine: Machine, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Kinetic energy plus that of all springs [J] (n,), and sum of weighed mass times position [kg m] (n, 3)."""
    energy = 0.5 * (machine.stiffness * q[:, list(SLIDE)] ** 2).sum(axis=1)
    energy += 0.5 * machine.hip_stiffness * (q[:, HINGE] + machine.hip_rest_angle) ** 2
    none = np.zeros_like(q)
    axes = [pair_axes(q, v, none, pair) for pair in (0, 1)]
    moment = machine.hip_weight * point_motion(q, v, none, axes[0], np.zeros(3), None).position
    slides: list[int | None] = [None] * 6
    for slide, foot in zip(SLIDE, FOOT_BODY, strict=True):
        slides[foot] = slide
    for index, body in enumerate(machine.bodies):
        pair = axes[index // 3]
        motion = point_motion(q, v, none, pair, body.centre, slides[index])
        spin = pair.components(pair.spin)
        energy += 0.5 * body.mass * (motion.velocity**2).sum(axis=1)
        energy += 0.5 * np.einsum("ij,jk,ik->i", spin, body.inertia, spin)
        moment += body.mass * motion.position
    return energy, moment
