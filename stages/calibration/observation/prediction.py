"""What the sensors of one run should have shown, with exact derivatives by the design and by the run's unknowns.

Last axes hold a value, then its derivatives: by the parameters of the design, then by the run's unknowns.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stages.analytic.derivatives.gait import exchanged_rows
from stages.analytic.derivatives.numbers import changes_of
from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.kinds import natural_lengths
from stages.analytic.model.walker import Vector, Walker
from stages.calibration.observation.measured_run import SIDES, STRETCHES, Layout, Sampling
from stages.calibration.observation.signals import SIGNALS, LowPass, Piece, Sensing
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
    found = sample_times(dict(zip(layout.names, unknowns, strict=True)), sampling)
    if any(times.size and times[0] < 0.0 for times in found.values()):
        raise StepFailed("the first sample is before mid-stance")
    last = max((float(times[-1]) for times in found.values() if times.size), default=0.0)
    walked = walk(design, names, unknowns, layout, sampling, last, tolerance)
    return Predicted(walked.samples(sampling), walked.strikes())


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

    def samples(self, sampling: Sampling) -> dict[str, np.ndarray]:
        """What each side's sensor shows at its times (m,), rising, (m, 3, 1 + d + k)."""
        return {side: Shown(self, sampling, side).read(sampling.of(side)) for side in SIDES}

    @cached_property
    def pieces(self) -> list[Piece]:
        """The stretches as the low pass takes them, in SI units."""
        pieces, by, unit = [], self.by, self.walker.time
        for stretch, after in zip(self.stretches, [*self.stretches[1:], None], strict=True):
            impulse = np.zeros((len(SIGNALS), len(by)))
            if stretch.ends_step and after is not None:
                old = self.sensing.velocities(stretch.end, stretch.stance_leg)
                impulse = (self.sensing.velocities(after.begin, after.stance_leg) - old) * by
            pieces.append(Piece(stretch.start * by * unit, stretch.duration * by * unit, stretch.edges * unit,
                                self.sensing.along(stretch) * by, impulse))
        return pieces

    def strikes(self) -> np.ndarray:
        """Times of the heel strikes, (s, 1 + d + k) [s], on the run's clock."""
        ends = np.array([one.start + one.duration for one in self.stretches if one.ends_step]).reshape(-1, len(self.by))
        return self._spread(ends * self.by * self.walker.time, np.ones(len(ends)), self.value["mid_stance"])

    @cached_property
    def columns(self) -> np.ndarray:
        """How the walk's own columns, and last the time of its first state, change with the unknowns, (c + 1, d + k).
        """
        c = len(self.by) - 1
        found = np.hstack([np.zeros((c + 1, 1)), np.vstack([np.diag(self.by[1:]), np.zeros(c)])])
        return self._spread(found, np.append(np.zeros(c), 1.0 / self.walker.time))[:, 1:]

    def begins(self) -> tuple[Vector, np.ndarray]:
        """When each stretch begins, (e,) on the run's clock, and its derivatives by the `columns`, (e, c + 1);
        dimensionless."""
        starts = np.array([one.start for one in self.stretches])
        return (starts[:, 0] + self.value["mid_stance"] / self.walker.time,
                np.hstack([starts[:, 1:], np.ones((len(starts), 1))]))  # fmt: skip

    def states(self, times: Vector) -> tuple[np.ndarray, list[Stretch]]:
        """States (m, size, 1 + d + k) at times (m,) [s] on the run's clock, and the stretch of each. SI units."""
        (begins, begins_by), found, lie = self.begins(), [], []
        for time in times / self.walker.time:
            number = max(int(np.searchsorted(begins, time, "right")) - 1, 0)
            state, rate, _ = self.stretches[number].at(time - begins[number])
            by = np.hstack([state[:, 1:], np.zeros((len(state), 1))]) - np.outer(rate[:, 0], begins_by[number])
            found.append(self.walker.scales()[:, None] * np.hstack([state[:, :1], by @ self.columns]))
            lie.append(self.stretches[number])
        return np.array(found), lie

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
        state, rate, _ = stretch.at(at)
        by_columns = -state[0, 1:] / rate[0, 0]
        state[:, 1:] += rate[:, :1] * by_columns
        found = state[-self.layout.free :] * self.walker.scales()[-self.layout.free :, None] * self.by
        when = stretch.start * self.by * self.walker.time
        when[0] += at * self.walker.time
        when[1:] += by_columns * self.by[1:] * self.walker.time
        rows = self._spread(np.vstack([found, when]), np.append(np.zeros(len(found)), 1.0))
        rows[-1, 0] += self.value["mid_stance"]
        return self._stretched(rows, stretch.stance_leg)

    def start_at(self, time: float) -> tuple[np.ndarray, int]:
        """A step's start at a time [s], or as soon then as one leg alone stands, (free + 1, 1 + d + k), as `next_start`
        has it, and that leg."""
        begins = self.begins()[0] * self.walker.time
        number = max(int(np.searchsorted(begins, time, "right")) - 1, 0)
        if self.stretches[number].double and number + 1 < len(begins):
            time = begins[number + 1]
        states, (stretch,) = self.states(np.array([time]))
        when = np.append(time, np.zeros(states.shape[-1] - 1))
        leg = stretch.stance_leg
        return self._stretched(np.vstack([states[0, -self.layout.free :], when]), leg), leg

    def _stretched(self, rows: np.ndarray, leg: int) -> np.ndarray:
        """A start with lengths as a run's unknowns have it, by what they are longer than natural ones; in place."""
        longer = self.longer if leg == self.stretches[0].stance_leg else self.longer[::-1]
        for name, length, more in zip(STRETCHES, natural_lengths(self.walker.on(leg).p), longer, strict=False):
            if name in self.layout.names:
                rows[self.layout.place(name), 0] -= self.walker.length * length
                rows[self.layout.place(name), 1 : 1 + self.d] -= more
        return rows

    def _spread(self, found: np.ndarray, by_mid_stance: np.ndarray, later: float = 0.0) -> np.ndarray:
        """Columns (..., 1 + c) of the walk as columns (..., 1 + d + k) by all unknowns."""
        d, free = self.d, self.layout.free
        spread = np.zeros((*found.shape[:-1], 1 + d + len(self.layout.names)))
        spread[..., 0] = found[..., 0] + later
        spread[..., 1 : 1 + d] = found[..., 1 + free : -1]
        spread[..., 1 + d : 1 + d + free] = found[..., 1 : 1 + free]
        spread[..., 1 + d + self.layout.place("mid_stance")] = by_mid_stance
        return self.as_long(spread)

    def as_long(self, found: np.ndarray) -> np.ndarray:
        """Columns by the design where longer legs are longer at the start too, in place."""
        lengths = [1 + self.d + self.layout.place(name) for name in STRETCHES if name in self.layout.names]
        found[..., 1 : 1 + self.d] += found[..., lengths] @ self.longer[: len(lengths)]
        return found


class Shown:
    """What the sensor of one side shows of a walk, requested in the order of time."""

    def __init__(self, walked: Walked, sampling: Sampling, side: str) -> None:
        self._walked, self._sampling, self._side = walked, sampling, side
        bandwidth = sampling.bandwidth_hz[side] * math.exp(walked.value["bandwidth"])
        self._low_pass, *self._beside = (
            LowPass(walked.pieces, PLACES[side], bandwidth * (1.0 + step), not step) for step in (0.0, STEP, -STEP))

    def read(self, clock: Vector) -> np.ndarray:
        """Samples (m, 3, 1 + d + k) at rising times (m,) [s] on the sensor's clock."""
        walked = self._walked
        times = taken(walked.value, self._sampling, self._side, clock)
        shown, rate = self._low_pass.read(times)
        wide, narrow = (one.read(times)[0][:, :, 0] for one in self._beside)
        by_bandwidth = (wide - narrow) / (2.0 * STEP)  # by its logarithm: as exact as the step squared
        value, layout, side = walked.value, walked.layout, self._side
        turn, gain, bias = _errors(value, side)
        turned = np.array([[turn[0, 1], -turn[0, 0], 0.0], [turn[0, 0], turn[0, 1], 0.0], [0.0, 0.0, 0.0]])
        through = gain[:, None] * turn
        straight = shown[:, :, 0] @ turn.T
        by = np.einsum("ij,mjc->mic", through, shown[:, :, 1:])
        by_time = rate @ through.T
        run = np.zeros((*straight.shape, len(layout.names)))
        run[:, :, : layout.free] = by[:, :, : layout.free]
        of_all = {"mid_stance": -by_time, "foot_lag": by_time if side == "foot" else 0.0, "foot_place": by[:, :, -1],
                  "bandwidth": by_bandwidth @ through.T,
                  f"{side}_clock": by_time * (clock[:, None] - self._sampling.since),
                  f"{side}_tilt": (shown[:, :, 0] @ turned.T) * gain}  # fmt: skip
        for name, column in of_all.items():
            run[:, :, layout.place(name)] = column
        for axis, name in enumerate(AXES):
            run[:, axis, layout.place(f"{side}_{name}_gain")] = straight[:, axis]
            run[:, axis, layout.place(f"{side}_{name}_bias")] = 1.0
        return walked.as_long(np.concatenate(
            [(straight * gain + bias)[:, :, None], by[:, :, layout.free : -1], run], axis=2))


def walk(
    design: DesignPoint, names: tuple[str, ...], unknowns: Vector, layout: Layout, sampling: Sampling, until: float,
    tolerance: float, least: float = math.inf,
) -> Walked:  # fmt: skip
    """Walk from the run's start to the first event after `until` [s], or to the last one before a fall that comes after
    the `least` time [s]. Raises StepFailed where the walker falls earlier."""
    walker = design.walker()
    changes = changes_of(design, names)
    scales = walker.scales()[-layout.free :]
    value = dict(zip(layout.names, unknowns, strict=True))
    lengths = [layout.place(name) for name in STRETCHES if name in layout.names]
    upright = unknowns[: layout.free].copy()
    upright[lengths] += walker.length * np.array(natural_lengths(walker.on(sampling.first_leg).p))[: len(lengths)]
    along = np.vstack([changes.along, np.zeros(changes.along.shape[1])])  # no number moves with the foot sensor's place
    stretches, end = list[Stretch](), -math.inf
    try:
        for stretch in walk_stretches(walker, upright / scales, along, tolerance, sampling.first_leg):
            stretches.append(stretch)
            end = float(stretch.start[0] + stretch.duration[0]) * walker.time
            if end > until:
                break
    except StepFailed:
        if end <= least:
            raise
    moved = value["foot_place"]
    sensing = Sensing(walker, along, layout.free, sampling.place + moved,
                      None if sampling.below_hip is None else sampling.below_hip - moved)
    by = np.concatenate([[1.0], 1.0 / scales, 1.0 / changes.scales, [1.0 / walker.length]])  # columns in SI units
    rows = (changes.along, exchanged_rows(walker, changes.along))[sampling.first_leg]
    lengths_by, fields = rows / changes.scales[:, None] * walker.length, walker.p._fields
    longer = np.array([lengths_by[:, fields.index(name)]
                       for name in ("L_nat", "L_nat_2" if "L_nat_2" in fields else "L_nat")])
    return Walked(walker, stretches, sensing, by, layout, value, longer)


def taken(value: Mapping[str, float], sampling: Sampling, side: str, clock: Vector) -> Vector:
    """When samples with times (m,) on the clock of a side's sensor really were taken [s] since mid-stance, by a run's
    unknowns by name."""
    late = sampling.late[side] - value["mid_stance"] + (value["foot_lag"] if side == "foot" else 0.0)
    return np.asarray(clock + value[f"{side}_clock"] * (clock - sampling.since) + late)


def sample_times(value: Mapping[str, float], sampling: Sampling) -> dict[str, Vector]:
    """When the samples of each side really were taken, (m,) [s] since mid-stance."""
    return {side: taken(value, sampling, side, sampling.of(side)) for side in SIDES}


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
