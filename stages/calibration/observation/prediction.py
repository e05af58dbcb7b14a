"""What the sensors of one run should have shown, with exact derivatives by the design and by the run's unknowns.

Last axes hold a value, then its derivatives: by the parameters of the design, then by the run's unknowns.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

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
    taken = sample_times(dict(zip(layout.names, unknowns, strict=True)), sampling)
    if any(times.size and times[0] < 0.0 for times in taken.values()):
        raise StepFailed("the first sample is before mid-stance")
    last = max((float(times[-1]) for times in taken.values() if times.size), default=0.0)
    walked = walk(design, names, unknowns, layout, sampling, last, tolerance)
    return Predicted(walked.samples(sampling, taken), walked.strikes())


@dataclass(frozen=True)
class Walked:
    """A walk from mid-stance on. Columns of its `stretches`, (1 + c,), times `by` are in SI units: the start, d numbers
    of the design, the foot sensor's place. `value` are the run's unknowns, `longer` (2, d) is how the stance leg and
    the other one are longer at the start where the design's legs are.
    """

    walker: Walker
    stretches: list[Stretch]
    sensing: Sensing
    by: Vector
    layout: Layout
    value: dict[str, float]
    longer: np.ndarray

    @property
    def d(self) -> int:
        """Parameters of the design that are derived by."""
        return len(self.by) - self.layout.free - 2

    def samples(self, sampling: Sampling, taken: Mapping[str, Vector]) -> dict[str, np.ndarray]:
        """What each side's sensor shows, (m, 3, 1 + d + k), at the rising times `taken` (m,) [s] since mid-stance."""
        pieces = _pieces(self.stretches, self.sensing, self.by, self.walker.time)
        bandwidth = sampling.bandwidth_hz * math.exp(self.value["bandwidth"])
        samples = {}
        for side in SIDES:
            shown, rate = filtered(pieces, PLACES[side], bandwidth, taken[side])
            wide, narrow = (filtered(pieces, PLACES[side], bandwidth * (1.0 + step), taken[side], False)[0][:, :, 0]
                            for step in (STEP, -STEP))  # by the bandwidth's logarithm: as exact as the step squared
            found = _read(
                shown, rate, (wide - narrow) / (2.0 * STEP), self.value, self.layout, side, sampling.of(side))
            samples[side] = self._as_long(found)
        return samples

    def strikes(self) -> np.ndarray:
        """Times of the heel strikes, (s, 1 + d + k) [s], on the run's clock."""
        ends = np.array([one.start + one.duration for one in self.stretches if one.ends_step]).reshape(-1, len(self.by))
        return self._spread(ends * self.by * self.walker.time, np.ones(len(ends)), self.value["mid_stance"])

    def states(self, times: Vector) -> tuple[np.ndarray, list[Stretch]]:
        """States (m, size, 1 + d + k) at times (m,) [s] on the run's clock, and the stretch of each. SI units."""
        since = (times - self.value["mid_stance"]) / self.walker.time
        begins = [one.start[0] for one in self.stretches]
        found = np.empty((len(times), self.walker.size, len(self.by)))
        rates = np.empty(found.shape[:2])
        lie = [self.stretches[max(number, 0)] for number in np.searchsorted(begins, since, "right") - 1]
        for row, stretch in enumerate(lie):
            found[row], rates[row] = stretch.at(since[row] - stretch.start[0])
            found[row, :, 1:] -= rates[row][:, None] * stretch.start[1:]
        units = self.walker.scales()
        found *= units[:, None] * self.by
        return self._spread(found, -rates * units / self.walker.time), lie

    def turns(self) -> tuple[np.ndarray, np.ndarray]:
        """Events without an impact: their times, (e, 1 + d + k) [s] on the run's clock, and by what the rates of the
        state jump there, (e, size). SI units.
        """
        pairs = [(one, other) for one, other in pairwise(self.stretches) if not one.ends_step]
        times = np.array([other.start for _, other in pairs]).reshape(-1, len(self.by)) * self.by * self.walker.time
        jumps = np.array([other.rates[0, :, 0] - one.rates[-1, :, 0] for one, other in pairs])
        return (self._spread(times, np.ones(len(times)), self.value["mid_stance"]),
                jumps.reshape(-1, self.walker.size) * self.walker.scales() / self.walker.time)  # fmt: skip

    def next_start(self) -> np.ndarray:
        """The next mid-stance: state without theta, (free, 1 + d + k), as a run's unknowns have it, and then its time.

        Raises StepFailed where the walk does not get there.
        """
        landed = next((number for number, one in enumerate(self.stretches) if one.ends_step), len(self.stretches))
        for stretch in self.stretches[landed + 1 :]:
            at = stretch.upright()
            if at is not None:
                break
        else:
            raise StepFailed("the walk ends before the next mid-stance")
        state, rate = stretch.at(at)
        by_columns = -state[0, 1:] / rate[0]
        state[:, 1:] += rate[:, None] * by_columns
        found = state[1:] * self.walker.scales()[1:, None] * self.by
        when = stretch.start * self.by * self.walker.time
        when[0] += at * self.walker.time
        when[1:] += by_columns * self.by[1:] * self.walker.time
        rows = self._spread(np.vstack([found, when]), np.append(np.zeros(len(found)), 1.0))
        rows[-1, 0] += self.value["mid_stance"]
        natural = natural_lengths(self.walker.on(stretch.stance_leg).p)
        for name, length, longer in zip(STRETCHES, natural, self.longer[::-1], strict=False):
            if name in self.layout.names:
                rows[self.layout.place(name), 0] -= self.walker.length * length
                rows[self.layout.place(name), 1 : 1 + self.d] -= longer
        return rows

    def _spread(self, found: np.ndarray, by_mid_stance: np.ndarray, later: float = 0.0) -> np.ndarray:
        """Columns (..., 1 + c) of the walk as columns (..., 1 + d + k) by all unknowns."""
        d, free = self.d, self.layout.free
        spread = np.zeros((*found.shape[:-1], 1 + d + len(self.layout.names)))
        spread[..., 0] = found[..., 0] + later
        spread[..., 1 : 1 + d] = found[..., 1 + free : -1]
        spread[..., 1 + d : 1 + d + free] = found[..., 1 : 1 + free]
        spread[..., 1 + d + self.layout.place("mid_stance")] = by_mid_stance
        return self._as_long(spread)

    def _as_long(self, found: np.ndarray) -> np.ndarray:
        """Columns by the design where longer legs are longer at the start too, in place."""
        lengths = [1 + self.d + self.layout.place(name) for name in STRETCHES if name in self.layout.names]
        found[..., 1 : 1 + self.d] += found[..., lengths] @ self.longer[: len(lengths)]
        return found


def walk(
    design: DesignPoint, names: tuple[str, ...], unknowns: Vector, layout: Layout, sampling: Sampling, until: float,
    tolerance: float,
) -> Walked:  # fmt: skip
    """Walk from the run's start to the first event after `until` [s]. Raises StepFailed where the walker falls."""
    walker = design.walker()
    changes = changes_of(design, names)
    scales = start_scales(walker)
    value = dict(zip(layout.names, unknowns, strict=True))
    lengths = [layout.place(name) for name in STRETCHES if name in layout.names]
    upright = unknowns[: layout.free].copy()
    upright[lengths] += walker.length * np.array(natural_lengths(walker.on(sampling.first_leg).p))[: len(lengths)]
    along = np.vstack([changes.along, np.zeros(changes.along.shape[1])])  # no number moves with the foot sensor's place
    stretches = walk_stretches(walker, upright / scales, along, until / walker.time, tolerance, sampling.first_leg)
    moved = value["foot_place"]
    sensing = Sensing(walker, along, layout.free, sampling.place + moved,
                      None if sampling.below_hip is None else sampling.below_hip - moved)
    by = np.concatenate([[1.0], 1.0 / scales, 1.0 / changes.scales, [1.0 / walker.length]])  # columns in SI units
    return Walked(walker, stretches, sensing, by, layout, value, _longer(walker, changes, sampling.first_leg))


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
