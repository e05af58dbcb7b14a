"""What the sensors of one run should have shown, with exact derivatives by the design and by the run's unknowns."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stages.analytic.derivatives.numbers import Changes, changes_of
from stages.analytic.derivatives.step_map import exchanged_rows
from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.kinds import natural_lengths
from stages.analytic.model.walker import Vector, Walker
from stages.calibration.motion.stretches import Stretch, walk_stretches
from stages.calibration.observation.felt import SIGNALS, Sensing
from stages.calibration.observation.low_pass import Filtered, Piece, filtered
from stages.calibration.observation.unknowns import SIDES, STRETCHES, Layout, start_scales

#: Columns of a sensor's samples.
AXES = ("forward", "up", "rate")
PLACES = {"hip": (0, 1, 4), "foot": (2, 3, 4)}
assert len(SIGNALS) == 5
#: Step of the difference by the bandwidth, relative.
STEP = 1e-4


@dataclass(frozen=True)
class Sampling:
    """When and how a run was sampled: of each side the times (m,) [s] since its first heel strike, as its clock has it.

    `late` [s] is what the samples were really taken after these times (the delay of the low pass that the ingest took
    out); `bandwidth_hz` cuts the low pass off; leg `first_leg` (0 carries the sensors) lands at the first heel strike,
    and no sample is earlier than the mid-stance after it. The foot sensor sits `below_hip` [m] on
    unloaded springs; where that is not known, `place` [m] above the foot's mass. A bandwidth that is not `declared` is
    a usual one.
    """

    hip: Vector
    foot: Vector
    late: float
    bandwidth_hz: float
    first_leg: int
    place: float = 0.0
    below_hip: float | None = None
    declared: bool = True

    def upto(self, horizon: float) -> Sampling:
        """The same without samples later than `horizon` [s]."""
        hip, foot = (times[times <= horizon] for times in (self.hip, self.foot))
        return dataclasses.replace(self, hip=hip, foot=foot)


@dataclass(frozen=True)
class Predicted:
    """Samples of each side, (m, 3), and their derivatives by design (m, 3, d) and by the run's unknowns (m, 3, k).

    `strikes` (s,) [s] after the first measured one, and their derivatives (s, d) and (s, k).
    """

    samples: dict[str, np.ndarray]
    by_design: dict[str, np.ndarray]
    by_run: dict[str, np.ndarray]
    strikes: Vector
    strikes_by_design: np.ndarray
    strikes_by_run: np.ndarray


def predict(
    design: DesignPoint, names: tuple[str, ...], unknowns: Vector, layout: Layout, sampling: Sampling, tolerance: float
) -> Predicted:
    """Walk from the run's start and sense. `names` are the parameters of the design to derive by.

    Raises StepFailed where the walker does not get to the last
    sample.
    """
    walker = design.walker()
    changes = changes_of(design, names)
    scales = start_scales(walker)
    value = dict(zip(layout.names, unknowns, strict=True))
    taken = sample_times(value, sampling)
    if any(times.size and times[0] < 0.0 for times in taken.values()):
        raise StepFailed("the first sample is before mid-stance")
    last = max((float(times[-1]) for times in taken.values() if times.size), default=0.0)
    lengths = [layout.place(name) for name in STRETCHES if name in layout.names]
    upright = unknowns[: layout.free].copy()
    upright[lengths] += walker.length * np.array(natural_lengths(walker.on(sampling.first_leg).p))[: len(lengths)]
    longer = _longer(walker, changes, sampling.first_leg)
    along = np.vstack([changes.along, np.zeros(changes.along.shape[1])])  # no number moves with the foot sensor's place
    stretches = walk_stretches(walker, upright / scales, along, last / walker.time, tolerance, sampling.first_leg)
    moved = value["foot_place"]
    sensing = Sensing(walker, along, layout.free, sampling.place + moved,
                      None if sampling.below_hip is None else sampling.below_hip - moved)
    by = np.concatenate([1.0 / scales, 1.0 / changes.scales, [1.0 / walker.length]])  # columns in SI units
    bandwidth = sampling.bandwidth_hz * math.exp(value["bandwidth"])
    pieces = _pieces(stretches, sensing, by, walker.time)
    samples, by_design, by_run = {}, {}, {}
    for side in SIDES:
        channels = list(PLACES[side])
        chosen = [Piece(p.start, p.edges, p.signals[:, channels], p.start_by, p.duration_by, p.impulse[channels])
                  for p in pieces]
        found = filtered(chosen, bandwidth, taken[side])
        samples[side], by_design[side], by_run[side] = _read(
            found, _by_bandwidth(chosen, bandwidth, taken[side]), value, layout, side,
            np.asarray(getattr(sampling, side)))
        by_design[side] += by_run[side][:, :, lengths] @ longer[: len(lengths)]  # longer legs are longer there too
    ends = [s for s in stretches if s.ends_step]
    strikes = np.array([s.start + s.duration for s in ends]) * walker.time + value["mid_stance"]
    strikes_by = np.array([s.start_by + s.duration_by for s in ends]).reshape(len(ends), len(by)) * by * walker.time
    strikes_by_run = np.zeros((len(ends), len(layout.names)))
    strikes_by_run[:, : layout.free] = strikes_by[:, : layout.free]
    strikes_by_run[:, layout.place("mid_stance")] = 1.0
    strikes_by_design = strikes_by[:, layout.free : -1]
    strikes_by_design += strikes_by_run[:, lengths] @ longer[: len(lengths)]
    return Predicted(samples, by_design, by_run, strikes, strikes_by_design, strikes_by_run)


def sample_times(value: Mapping[str, float], sampling: Sampling) -> dict[str, Vector]:
    """When the samples of each side really were taken, (m,) [s] since mid-stance, by a run's unknowns by name."""
    return {side: (1.0 + value[f"{side}_clock"]) * getattr(sampling, side) + sampling.late - value["mid_stance"]
            + (value["foot_lag"] if side == "foot" else 0.0) for side in SIDES}  # fmt: skip


def as_sensed(signals: np.ndarray, value: Mapping[str, float], side: str) -> np.ndarray:
    """What a sensor with a run's unknown errors makes of signals (m, 3)."""
    turn, gain, bias = _errors(value, side)
    return np.asarray((signals @ turn.T) * gain + bias)


def _errors(value: Mapping[str, float], side: str) -> tuple[np.ndarray, Vector, Vector]:
    """A sensor's turning (3, 3), gains and biases (3,)."""
    cos, sin = np.cos(value[f"{side}_tilt"]), np.sin(value[f"{side}_tilt"])
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return (turn, 1.0 + np.array([value[f"{side}_{axis}_gain"] for axis in AXES]),
            np.array([value[f"{side}_{axis}_bias"] for axis in AXES]))  # fmt: skip


def _longer(walker: Walker, changes: Changes, leg: int) -> np.ndarray:
    """Derivatives (2, d) of the natural lengths [m] of the leg that stands and of the other one by the parameters."""
    fields = walker.p._fields
    rows = (changes.along, exchanged_rows(walker, changes.along))[leg] / changes.scales[:, None] * walker.length
    other = "L_nat_2" if "L_nat_2" in fields else "L_nat"
    return np.array([rows[:, fields.index("L_nat")], rows[:, fields.index(other)]])


def _pieces(stretches: list[Stretch], sensing: Sensing, by: Vector, unit: float) -> list[Piece]:
    """The stretches as the low pass takes them, in SI units."""
    pieces = []
    for stretch, after in zip(stretches, [*stretches[1:], None], strict=True):
        found = sensing.along(stretch)
        signals = np.concatenate([found.value[:, :, None], found.by * by], axis=2)
        impulse = np.zeros(signals.shape[1:])
        if stretch.ends_step and after is not None:
            old = sensing.velocities(stretch.end, stretch.end_by, stretch.stance_leg)
            new = sensing.velocities(after.begin, after.begin_by, after.stance_leg)
            impulse = np.concatenate([(new.value - old.value)[0, :, None], (new.by - old.by)[0] * by], axis=1)
        pieces.append(Piece(stretch.start * unit, stretch.edges * unit, signals, stretch.start_by * by * unit,
                            stretch.duration_by * by * unit, impulse))
    return pieces


def _by_bandwidth(pieces: list[Piece], bandwidth_hz: float, times: Vector) -> np.ndarray:
    """Derivative (m, k) of the filtered signals by the logarithm of the bandwidth: a central difference, as exact as
    its step squared."""
    bare = [dataclasses.replace(one, signals=one.signals[:, :, :1].copy(), start_by=one.start_by[:0],
                                duration_by=one.duration_by[:0], impulse=one.impulse[:, :1]) for one in pieces]
    wide, narrow = (filtered(bare, bandwidth_hz * (1.0 + step), times).value for step in (STEP, -STEP))
    return np.asarray((wide - narrow) / (2.0 * STEP))


def _read(
    found: Filtered, by_bandwidth: np.ndarray, value: dict[str, float], layout: Layout, side: str, clock: Vector
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What a sensor with its errors makes of its signals: samples (m, 3), by the design, by the run's unknowns."""
    turn, gain, bias = _errors(value, side)
    turned = np.array([[turn[0, 1], -turn[0, 0], 0.0], [turn[0, 0], turn[0, 1], 0.0], [0.0, 0.0, 0.0]])
    through = gain[:, None] * turn
    straight = found.value @ turn.T
    samples = straight * gain + bias
    by = np.einsum("ij,mjc->mic", through, found.by)
    by_time = found.rate @ through.T
    by_run = np.zeros((*samples.shape, len(layout.names)))
    by_run[:, :, : layout.free] = by[:, :, : layout.free]
    by_run[:, :, layout.place("mid_stance")] = -by_time
    if side == "foot":
        by_run[:, :, layout.place("foot_lag")] = by_time
    by_run[:, :, layout.place("foot_place")] = by[:, :, -1]
    by_run[:, :, layout.place("bandwidth")] = by_bandwidth @ through.T
    by_run[:, :, layout.place(f"{side}_clock")] = by_time * clock[:, None]
    by_run[:, :, layout.place(f"{side}_tilt")] = (found.value @ turned.T) * gain
    for axis, name in enumerate(AXES):
        by_run[:, axis, layout.place(f"{side}_{name}_gain")] = straight[:, axis]
        by_run[:, axis, layout.place(f"{side}_{name}_bias")] = 1.0
    return samples, by[:, :, layout.free : -1], by_run
