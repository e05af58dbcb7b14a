"""Let the penalty walker walk: the counterpart of `stages.multibody.walking.walk`, with the same words for the same."""

import math
from collections.abc import Collection
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from stages.analytic.integration.phase import EVENT, FALL, STEP_LIMIT, TIME_LIMIT
from stages.biped.accuracy.scales import Scales, scales_of
from stages.biped.design import Biped
from stages.biped.kinematics import Coordinate, Motion, constant, shifted, swing_point_motion
from stages.ground.blocks import Laid
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.penalty.model.walker import (
    ANGLE,
    LENGTH,
    RATES,
    SIZE,
    UNITS,
    Directions,
    Penalty,
    X,
    Y,
    build_penalty,
    natural_lengths,
)
from stages.penalty.motion import feet
from stages.penalty.motion.engine import integrate, readings, states_at
from stages.planar.run import (
    COMPLETED,
    DIVERGED,
    FALLEN,
    FELL,
    PATIENCE,
    RUNNING,
    STALLED,
    STEP_FLOOR,
    PlanarState,
    Run,
    Trajectory,
)
from stages.planar.signals import GROUND_REACTION, IMU, SIGNALS


@dataclass(frozen=True)
class Settings:
    """Tolerance, absolute and relative alike, in the design's scales; moments between two steps of the integrator that
    are recorded too; the time without a heel strike after which a walk counts as stalled [s], None: by its size; the
    steps after which the solver is stuck.
    """

    tolerance: float
    between: int = 0
    longest_step: float | None = None
    most_solver_steps: int = 500_000


#: First step of all, in the walker's scales: the error estimate corrects it either way.
FIRST_STEP = 5e-5
#: A guard this far below zero has fallen; nearer to it is round-off of the event just located.
FALLEN_GUARD = -1e-12
#: Rows that the record of a stretch has room for at first, and the factor of more room.
ROOM, GROWTH = 2048, 8
NO_ROOM = np.empty((0, 2 + SIZE))
#: Evaluations of the rates in a step of the integrator. Who is due where the end is, and no leg.
EVALUATIONS, END = 12, 2


@lru_cache(maxsize=64)
def numbers_of(biped: Biped, slope: Slope, contact: ContactLaw) -> Penalty:
    """The walker's numbers, in scales of the design."""
    return build_penalty(biped, slope.gravity_vector, contact, FALLEN, scales_of(biped, slope.gravity))


@dataclass
class Ongoing:
    """A walk on its way: what the watch over an Exudyn run knows as well.

    `y`: state (12,), followed by any variations, changed in place, in `scales` as `p` is. `record`: rows of time [s],
    phase and state at the start of every step, or None if none are kept. `directions`: those of the
    walker's numbers that the last variations go along. A foot that goes out of play has the next of `blocks` under it.
    """

    p: Penalty
    scales: Scales
    y: np.ndarray
    phase: int
    settings: Settings
    longest_step: float
    wanted: float
    until: float = math.inf
    record: list[np.ndarray] | None = None
    time: float = 0.0
    heel_strikes: int = 0
    last_heel_strike: float = 0.0
    since: int = 0
    evaluations: int = 0
    steps: int = 0
    outcome: str = RUNNING
    message: str = ""
    switches: list[tuple[float, int, bool]] = field(default_factory=list)
    directions: Directions | None = None
    blocks: Laid | None = None

    @property
    def in_play(self) -> tuple[bool, bool]:
        """Whether the ground acts on each leg."""
        return feet.acts_on(self.phase, 0), feet.acts_on(self.phase, 1)

    def go_on(self) -> None:
        """Walk until the outcome is known."""
        length = FIRST_STEP
        self._change()
        while self.outcome == RUNNING:
            length = self._stretch(length)

    def _stretch(self, length: float) -> float:
        """Integrate to the next event; the length of its last step."""
        settings = self.settings
        left = self.last_heel_strike + self.longest_step - self.time
        limit = min(left, self.until - self.time) / self.scales.time
        steps = settings.most_solver_steps - self.since
        before = self.y.copy()
        room = 0 if self.record is None and self.until == math.inf else ROOM
        while True:
            nodes = np.empty((room, 2 + SIZE)) if room else NO_ROOM
            status, taken, length, count, evaluations = integrate(
                self.phase, self.y, self.p, settings.tolerance, limit, steps, length, nodes, self.directions)
            if count < room or not room:
                break
            self.y[:] = before
            room *= GROWTH
        self.evaluations += evaluations
        self.since += evaluations // EVALUATIONS
        taken *= self.scales.time
        if self.time + taken > self.until:
            taken = self._cut(nodes[:count])
            status = TIME_LIMIT
        if self.record is not None:
            rows = self._with_moments_between(nodes[:count], taken / self.scales.time)
            rows[:, 0] = rows[:, 0] * self.scales.time + self.time
            self.record.append(rows)
            self.steps += count
        self.time += taken
        if status == EVENT:
            self._change(first=True)
        else:
            self._end(status)
        return length

    def _with_moments_between(self, nodes: np.ndarray, taken: float) -> np.ndarray:
        """The record of a stretch of this length with the moments between, by shorter steps: as accurate as these.
        """
        parts = self.settings.between + 1
        if parts == 1 or not len(nodes):
            return nodes
        spans = np.diff(nodes[:, 0], append=taken)
        times = (nodes[:, :1] + spans[:, None] * np.arange(parts) / parts).ravel()
        start, states = nodes[:, 0].copy(), np.ascontiguousarray(nodes[:, 2:])
        rows = np.repeat(nodes, parts, axis=0)
        rows[:, 0], rows[:, 2:] = times, states_at(self.phase, start, states, times, self.p)
        return rows

    def _cut(self, nodes: np.ndarray) -> float:
        """Take the last step again, to the time at which the walk ends; how long the stretch is then."""
        last, left = nodes[-1:], self.until - self.time
        ends = np.array([left / self.scales.time])
        self.y[:SIZE] = states_at(self.phase, last[:, 0].copy(), last[:, 2:].copy(), ends, self.p)[0]
        return left

    def _change(self, first: bool = False) -> None:
        """Change the status of every leg whose guard has fallen; with `first` one has just been located."""
        while self.outcome == RUNNING:
            who, value = feet.due(self.phase, self.y, self.p)
            if not first and value > (0.0 if who == END else FALLEN_GUARD):
                return
            first = False
            if who == END:
                self.outcome = COMPLETED
                self.y[ANGLE + feet.end_of(self.phase) - 1] = 0.0
                return
            self._set(who, feet.status_after(self.phase, self.y, self.p, who))

    def _set(self, leg: int, status: int) -> None:
        statuses = [feet.status_of(self.phase, other) for other in (0, 1)]
        end, acted = feet.end_of(self.phase), statuses[leg] != feet.OUT
        statuses[leg] = status
        if status == feet.LANDED and self.blocks and self.ahead(leg) > self.blocks.ends[leg]:
            self.outcome, self.message = FELL, f"foot {leg} came down beyond its block at t = {self.time:.6g} s"
            return
        if status == feet.LANDED:
            self.heel_strikes += 1
            self.last_heel_strike, self.since = self.time, 0
            end = leg + 1 if self.heel_strikes >= self.wanted else end
        elif acted != (status != feet.OUT):
            self.switches.append((self.time, leg, not acted))
            self.lay(leg)
        self.phase = feet.phase_of(statuses[0], statuses[1], end)

    def ahead(self, leg: int) -> float:
        """How far a foot is ahead of the other [m]."""
        own, other = (feet.place(self.y, self.p, which, self.y, 0)[0] for which in (leg, 1 - leg))
        return (own - other) * self.scales.length

    def lay(self, leg: int) -> None:
        """Put the block of the next footfall under a foot that is out of play, or about to land."""
        if self.blocks:
            height = self.blocks.height(self.heel_strikes) / self.scales.length
            self.p = self.p._replace(h_0=height) if leg == 0 else self.p._replace(h_1=height)

    def _end(self, status: int) -> None:
        """Why the integration ended before an event, in the words of the watch over Exudyn's runs."""
        at = f"t = {self.time:.6g} s"
        if not np.isfinite(self.y[:SIZE]).all():
            self.outcome, self.message = DIVERGED, f"the state is no longer finite at {at}"
        elif status == TIME_LIMIT and self.time >= self.until:
            self.outcome = COMPLETED
        elif status == TIME_LIMIT:
            self.outcome, self.message = STALLED, f"no heel strike for {self.longest_step:g} s at {at}"
        elif status == FALL:
            self.outcome, self.message = FELL, f"the walker fell at {at}"
        else:
            many = f"after {self.settings.most_solver_steps} steps without a heel strike"
            reason = many if status == STEP_LIMIT else "at its smallest step"
            self.outcome, self.message = STEP_FLOOR, f"the solver gets nowhere {reason}, {at}"


def simulate(
    biped: Biped,
    slope: Slope,
    contact: ContactLaw,
    state: PlanarState,
    settings: Settings,
    *,
    steps: int = 1,
    duration: float | None = None,
    signals: Collection[str] = SIGNALS,
) -> Run:
    """Walk from `state` at t = 0 through `steps` heel strikes to the mid-stance after them, or for `duration` [s].

    The walk ends where the hip is over the foot that landed last. A fall, a standstill or a failure of the solver ends
    it earlier and is stated in the run's outcome. Motion, accelerations and what `signals` names are kept at every step
    and at the moments between that the settings request.
    """
    p = numbers_of(biped, slope, contact)
    scales = scales_of(biped, slope.gravity)
    walk = begin(p, scales, state, settings, math.inf if duration is not None else steps)
    walk.record = []
    walk.until = math.inf if duration is None else duration
    walk.go_on()
    trajectory = recorded(walk, state, biped, signals)
    return Run(
        walk.outcome, walk.message, trajectory, walk.heel_strikes, walk.steps, walk.evaluations, 0.0)


def begin(
    p: Penalty, scales: Scales, state: PlanarState, settings: Settings, steps: float, blocks: Laid | None = None
) -> Ongoing:
    """A walk about to begin from a state, through so many heel strikes. Rigid legs have their natural length.

    With `blocks` feet on which the ground acts stand on level ones, and no record is kept.
    """
    y = np.array([
        *state.hip_position, *state.leg_angle, *state.leg_length, *state.hip_velocity, *state.leg_rate,
        *state.leg_length_rate,
    ]) / [scales.size(unit) for unit in UNITS]  # fmt: skip
    if p.slide == 0.0:
        y[LENGTH:RATES], y[RATES + LENGTH :] = natural_lengths(p), 0.0
    statuses = []
    for leg, acts in enumerate(state.in_play):
        standing = feet.height(y, p, leg, y, 0)[0] <= feet.AIR
        statuses.append(feet.OUT if not acts else feet.LANDED if standing else feet.AWAITED)
    longest = settings.longest_step or PATIENCE * scales.time
    if blocks:
        first, other = blocks.begins
        p = p._replace(x_0=first / scales.length, x_1=other / scales.length)
    walk = Ongoing(
        p, scales, y, feet.phase_of(statuses[0], statuses[1], 0), settings, longest, steps, blocks=blocks)
    for leg in (0, 1):
        if not state.in_play[leg]:
            walk.lay(leg)
    return walk


def recorded(walk: Ongoing, state: PlanarState, biped: Biped, signals: Collection[str]) -> Trajectory:
    """The record of a walk at the solver's own steps."""
    end = np.concatenate([[walk.time, walk.phase], walk.y[:SIZE]])
    rows = np.concatenate([*(walk.record or []), end[None]])
    rows = rows[np.isfinite(rows).all(axis=1)]
    rows = rows[np.concatenate([np.diff(rows[:, 0]) > 0.0, [True]])]
    states, units = np.ascontiguousarray(rows[:, 2:]), np.array([walk.scales.size(unit) for unit in UNITS])
    read = readings(rows[:, 1].astype(np.int64), states, walk.p)
    place, motion = (states * units)[:, :RATES], (states * units)[:, RATES:]
    change, pushes = read[:, :RATES] * units[RATES:] / walk.scales.time, read[:, RATES:] * walk.scales.size("N")
    count = len(rows)
    force = pushes[:, [1, 0, 3, 2]].reshape(count, 2, 2) if GROUND_REACTION in signals else np.zeros((count, 0, 2))
    sensed = foot_acceleration(place, motion, change, biped) if IMU in signals else np.zeros((count, 0))
    return Trajectory(
        time=rows[:, 0].copy(), position=place.copy(), velocity=motion.copy(), acceleration=change.copy(),
        foot_acceleration=sensed, ground_reaction=force, in_play_at_start=state.in_play,
        switches=tuple(walk.switches),
    )  # fmt: skip


def foot_acceleration(place: np.ndarray, motion: np.ndarray, change: np.ndarray, biped: Biped) -> np.ndarray:
    """Acceleration of the inner foot's mass centre, (n, 2) [m/s^2]."""
    hip = Motion(*(rows[:, [X, Y]] for rows in (place, motion, change)))
    angle, length = (Coordinate(place[:, i], motion[:, i], change[:, i]) for i in (2, 4))
    centre = swing_point_motion(hip, angle, shifted(length, biped.foot_com))
    if biped.foot_offset:
        centre = swing_point_motion(centre, shifted(angle, -0.5 * math.pi), constant(biped.foot_offset, angle))
    return centre.acceleration
