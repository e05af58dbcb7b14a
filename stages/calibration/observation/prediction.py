"""What the sensors of one run should have shown, with exact derivatives by the design and by the run's unknowns.

Last axes hold a value, then its derivatives: by the parameters of the design, then by the run's unknowns.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stages.analytic.derivatives.gait import exchanged_rows
from stages.analytic.derivatives.numbers import Changes, changes_of
from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.kinds import natural_lengths
from stages.analytic.model.walker import Vector, Walker
from stages.calibration.observation.measured_run import SIDES, STRETCHES, Layout, Sampling, start_scales
from stages.calibration.observation.signals import SIGNALS, Piece, Sensing, filtered
from stages.calibration.observation.stretches import Stretch, walk_stretches

#: Columns of a sensor's samples.
AXES = ("forward", "up", "rate")
PLACES = {"hip": (0, 1, 4), "foot": (2, 3, 4)}
assert len(SIGNALS) == 5
#: Step of the difference by the bandwidth, relative.
STEP = 1e-4


@dataclass(frozen=True)
class Predicted:
    """Samples of each side, (m, 3, 1 + n), and `strikes` (s, 1 + n) [s] after the first measured one."""

    samples: dict[str, np.ndarray]
    strikes: np.ndarray


def predict(
    design: DesignPoint, names: tuple[str, ...], unknowns: Vector, layout: Layout, sampling: Sampling, tolerance: float
) -> Predicted:
    """Walk from the run's start and sense. `names` are the parameters of the design to derive by.

    Raises StepFailed where the walker does not get to the last sample.
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
    longer = _longer(walker, changes, sampling.first_leg)[: len(lengths)]
    along = np.vstack([changes.along, np.zeros(changes.along.shape[1])])  # no number moves with the foot sensor's place
    stretches = walk_stretches(walker, upright / scales, along, last / walker.time, tolerance, sampling.first_leg)
    moved = value["foot_place"]
    sensing = Sensing(walker, along, layout.free, sampling.place + moved,
                      None if sampling.below_hip is None else sampling.below_hip - moved)
    by = np.concatenate([[1.0], 1.0 / scales, 1.0 / changes.scales, [1.0 / walker.length]])  # columns in SI units
    bandwidth = sampling.bandwidth_hz * math.exp(value["bandwidth"])
    pieces = _pieces(stretches, sensing, by, walker.time)
    d, starts = len(names), [*range(1, 1 + layout.free)]
    samples = {}
    for side in SIDES:
        shown, rate = filtered(pieces, PLACES[side], bandwidth, taken[side])
        wide, narrow = (filtered(pieces, PLACES[side], bandwidth * (1.0 + step), taken[side], False)[0][:, :, 0]
                        for step in (STEP, -STEP))  # by the logarithm of the bandwidth: as exact as the step squared
        samples[side] = _read(shown, rate, (wide - narrow) / (2.0 * STEP), value, layout, side, sampling.of(side))
    ends = np.array([s.start + s.duration for s in stretches if s.ends_step]).reshape(-1, len(by)) * by * walker.time
    strikes = np.zeros((len(ends), 1 + d + len(layout.names)))
    strikes[:, 0] = ends[:, 0] + value["mid_stance"]
    strikes[:, 1 : 1 + d] = ends[:, 1 + layout.free : -1]
    strikes[:, d + np.array(starts)] = ends[:, starts]
    strikes[:, 1 + d + layout.place("mid_stance")] = 1.0
    stretched = [1 + d + place for place in lengths]
    for found in (*samples.values(), strikes):  # longer legs are longer at the start too
        found[..., 1 : 1 + d] += found[..., stretched] @ longer
    return Predicted(samples, strikes)


def sample_times(value: Mapping[str, float], sampling: Sampling) -> dict[str, Vector]:
    """When the samples of each side really were taken, (m,) [s] since mid-stance, by a run's unknowns by name."""
    return {side: (1.0 + value[f"{side}_clock"]) * sampling.of(side) + sampling.late - value["mid_stance"]
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
        impulse = np.zeros((len(SIGNALS), len(by)))
        if stretch.ends_step and after is not None:
            old = sensing.velocities(stretch.end, stretch.stance_leg)
            impulse = (sensing.velocities(after.begin, after.stance_leg) - old) * by
        pieces.append(Piece(stretch.start * by * unit, stretch.duration * by * unit, stretch.edges * unit,
                            sensing.along(stretch) * by, impulse))
    return pieces


def _read(
    shown: np.ndarray, rate: np.ndarray, by_bandwidth: np.ndarray, value: dict[str, float], layout: Layout, side: str,
    clock: Vector,
) -> np.ndarray:
    """What a sensor with its errors makes of signals behind the low pass, (m, 3, 1 + n)."""
    turn, gain, bias = _errors(value, side)
    turned = np.array([[turn[0, 1], -turn[0, 0], 0.0], [turn[0, 0], turn[0, 1], 0.0], [0.0, 0.0, 0.0]])
    through = gain[:, None] * turn
    straight = shown[:, :, 0] @ turn.T
    by = np.einsum("ij,mjc->mic", through, shown[:, :, 1:])
    by_time = rate @ through.T
    run = np.zeros((*straight.shape, len(layout.names)))
    run[:, :, : layout.free] = by[:, :, : layout.free]
    of_all = {"mid_stance": -by_time, "foot_lag": by_time if side == "foot" else 0.0, "foot_place": by[:, :, -1],
              "bandwidth": by_bandwidth @ through.T, f"{side}_clock": by_time * clock[:, None],
              f"{side}_tilt": (shown[:, :, 0] @ turned.T) * gain}  # fmt: skip
    for name, column in of_all.items():
        run[:, :, layout.place(name)] = column
    for axis, name in enumerate(AXES):
        run[:, axis, layout.place(f"{side}_{name}_gain")] = straight[:, axis]
        run[:, axis, layout.place(f"{side}_{name}_bias")] = 1.0
    return np.concatenate([(straight * gain + bias)[:, :, None], by[:, :, layout.free : -1], run], axis=2)
