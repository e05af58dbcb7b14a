"""The watch over a run: which pair of feet the ground acts on, steps counted, falls told.

The rule for scuffing is that of `stages.multibody.walking.scuffing`, with the lowest point of each pair's feet in
space: the ground ceases to act on a pair that is in the air behind the other and swings forward, and acts again once
the pair is in the air ahead of the other. Both switches happen in the air, so the force never jumps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from stages.multibody.walking.scuffing import STUCK, UPSET
from stages.planar.run import COMPLETED, DIVERGED, FALLEN, FELL, RUNNING, STALLED, STEP_FLOOR
from stages.twin.machine.contact import HINGE, PITCH, ROLL, YAW, Y, clearances
from stages.twin.machine.tree import SpatialTree

#: Roll or yaw [rad] beyond which the machine has toppled or turned away.
TOPPLED = 0.5


@dataclass
class Watch:
    """Exudyn's pre-step function; `outcome` tells why the run ended, `reason` in which way.

    `in_play` and `landed` (2,) tell which pairs stand at the start, `last_landed` which of them landed last. After
    `most_calls` solver steps without a heel strike the solver is stuck.
    """

    tree: SpatialTree
    steps_wanted: int
    longest_step: float
    in_play: list[bool]
    landed: list[bool]
    last_landed: int
    outcome: str = RUNNING
    reason: str = ""
    switches: list[tuple[float, int, bool]] = field(default_factory=list)
    heel_strikes: int = 0
    last_heel_strike: float = 0.0
    previous: float = -1.0
    stuck: int = 0
    most_calls: int = 500_000
    calls: int = 0

    def __post_init__(self) -> None:
        self.fallen = FALLEN * float(self.tree.machine.length[0])

    def __call__(self, mbs: object, time: float) -> bool:
        """Watch the state before a solver step; False ends the run."""
        self.calls += 1
        self.stuck = self.stuck + 1 if time == self.previous else 0
        self.previous = time
        if self.stuck > STUCK or self.calls > self.most_calls:
            many = f"the solver took {self.most_calls} steps without a heel strike"
            self._end(STEP_FLOOR, "the solver's step became too small" if self.stuck > STUCK else many)
            raise RuntimeError(self.reason)  # an explicit solver ignores False here
        place = self.tree.position()
        q = place.tolist()
        if not math.isfinite(sum(q)):
            return self._end(DIVERGED, "the state is not finite")
        angles = q[PITCH], q[PITCH] + q[HINGE]
        if q[Y] < self.fallen or abs(angles[0]) > UPSET or abs(angles[1]) > UPSET:
            return self._end(FELL, f"fell in step {self.heel_strikes + 1}")
        if abs(q[ROLL]) > TOPPLED:
            return self._end(FELL, f"toppled sideways in step {self.heel_strikes + 1}")
        if abs(q[YAW]) > TOPPLED:
            return self._end(FELL, f"turned away from the walking direction in step {self.heel_strikes + 1}")
        if time - self.last_heel_strike > self.longest_step:
            return self._end(STALLED, f"no heel strike for {self.longest_step:g} s after step {self.heel_strikes}")
        self._switch(time, place)
        if self.outcome != RUNNING:
            return False
        if self.heel_strikes >= self.steps_wanted and angles[self.last_landed] <= 0.0:
            return self._end(COMPLETED, "")
        return True

    def _end(self, outcome: str, reason: str) -> bool:
        self.outcome, self.reason = outcome, reason
        return False

    def _switch(self, time: float, q: np.ndarray) -> None:
        clearance, place = clearances(q, self.tree.feet)
        for pair in (0, 1):
            ahead = place[pair] > place[1 - pair]
            if clearance[pair] > 0.0:
                if self.in_play[pair] and not ahead and self._rate(pair) > 0.0:
                    self._set(time, pair, False)
                elif not self.in_play[pair] and ahead:
                    self._set(time, pair, True)
            elif self.in_play[pair] and not self.landed[pair]:
                self._land(time, pair)

    def _land(self, time: float, pair: int) -> None:
        self.landed[pair] = True
        self.heel_strikes += 1
        self.calls = 0
        self.last_heel_strike, self.last_landed = time, pair

    def _rate(self, pair: int) -> float:
        v = self.tree.velocity()
        return float(v[PITCH] + (v[HINGE] if pair else 0.0))

    def _set(self, time: float, pair: int, acts: bool) -> None:
        self.in_play[pair], self.landed[pair] = acts, False
        self.switches.append((time, pair, acts))
        self.tree.set_in_play(pair, acts)
