"""The ideal ground of a walker without knees, and the watch over a run.

Legs of equal length scuff at mid-swing; the machine walks on stepping blocks for that reason. The ideal rule: the
ground ceases to act on a foot once it is in the air behind the other foot and swings forward, and acts again once the
foot is in the air ahead of the other. Both switches happen in the air, so the force never jumps. The rule and the
watch for falls and for a stuck solver run once a step, before it; the forces themselves involve no Python.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from stages.ground.friction import SCALARS, Lane
from stages.planar.run import COMPLETED, DIVERGED, FALLEN, FELL, RUNNING, STALLED, STEP_FLOOR

Pose = tuple[float, float, tuple[float, float], tuple[float, float]]

#: Calls at one and the same time after which the solver is stuck (an explicit solver at its smallest step never ends).
STUCK = 60
#: Angle of a leg [rad] at which a walker has fallen.
UPSET = 0.5 * math.pi


class Walker(Protocol):
    """What the watch needs from an assembly."""

    def pose(self) -> Pose:
        """Hip x, hip y, leg angles, leg lengths at the current step."""

    def leg_rate(self, leg: int) -> float:
        """Rate of a leg's angle at the current step [rad/s]."""

    def set_in_play(self, leg: int, acts: bool) -> None:
        """Let the ground act on a leg's foot, or not."""


@dataclass
class Watch:
    """Called before every solver step; `outcome` and `message` tell why the run ended.

    `landed` tells which feet stand on the ground at the start; `refine` may ask for a pause to change the step size.
    After `most_calls` solver steps without a heel strike the solver is stuck. With `lanes` the ideal rule is off: the
    ground itself ends between the blocks.
    """

    walker: Walker
    radii: tuple[float, float]
    natural_length: float
    longest_step: float
    heel_strikes_wanted: int
    in_play: list[bool]
    landed: list[bool]
    lanes: tuple[Lane, Lane] | None = None
    refine: Callable[[float], bool] | None = None
    most_calls: int = 500_000
    outcome: str = RUNNING
    switches: list[tuple[float, int, bool]] = field(default_factory=list)
    heel_strikes: int = 0
    last_heel_strike: float = 0.0
    last_landed: int = 0
    approach: float = math.inf
    calls: int = 0
    stuck: int = 0
    previous: float = -1.0
    message: str = ""

    def __call__(self, mbs: object, time: float) -> bool:
        """Exudyn's pre-step function: False ends the run."""
        self.calls += 1
        self.stuck = self.stuck + 1 if time == self.previous else 0
        self.previous = time
        if self.stuck > STUCK or self.calls > self.most_calls:
            many = f"after {self.most_calls} steps without a heel strike"
            reason = "at its smallest step" if self.stuck > STUCK else many
            self._end(STEP_FLOOR, f"the solver gets nowhere {reason}, t = {time:.6g} s")
            raise RuntimeError(self.message)  # False is not looked at while a step is being repeated
        x, y, angles, lengths = self.walker.pose()
        if not math.isfinite(x + y + angles[0] + angles[1] + lengths[0] + lengths[1]):
            return self._end(DIVERGED, f"the state is no longer finite at t = {time:.6g} s")
        if y < FALLEN * self.natural_length or abs(angles[0]) > UPSET or abs(angles[1]) > UPSET:
            return self._end(FELL, f"the walker fell at t = {time:.6g} s")
        if time - self.last_heel_strike > self.longest_step:
            return self._end(STALLED, f"no heel strike for {self.longest_step:g} s at t = {time:.6g} s")
        self._switch(time, x, y, angles, lengths)
        if self.outcome != RUNNING:
            return False
        if self.heel_strikes >= self.heel_strikes_wanted and self._mid_stance(angles):
            return self._end(COMPLETED)
        return self.refine is None or self.refine(time)

    def _end(self, outcome: str, message: str = "") -> bool:
        self.outcome, self.message = outcome, message
        return False

    def _switch(
        self, time: float, x: float, y: float, angles: tuple[float, float], lengths: tuple[float, float]
    ) -> None:
        reach = lengths[0] - self.radii[0], lengths[1] - self.radii[1]
        place = x + reach[0] * math.sin(angles[0]), x + reach[1] * math.sin(angles[1])
        self.approach = math.inf
        for leg in (0, 1):
            clearance = y - reach[leg] * math.cos(angles[leg]) - self.radii[leg]
            ahead = place[leg] > place[1 - leg]
            if self.lanes:
                self._cross_edge(time, leg, place[leg], clearance)
            if clearance > 0.0:
                if self.lanes:
                    pass
                elif self.in_play[leg] and not ahead and self.walker.leg_rate(leg) > 0.0:
                    self._set(time, leg, False)
                elif not self.in_play[leg] and ahead:
                    self._set(time, leg, True)
            elif self.in_play[leg] and not self.landed[leg]:
                self.landed[leg] = True
                self.heel_strikes += 1
                self.last_heel_strike = time
                self.last_landed = leg
                self.calls = 0
            if self.in_play[leg] and not self.landed[leg]:
                self.approach = clearance

    def _cross_edge(self, time: float, leg: int, place: float, clearance: float) -> None:
        """A foot passes the edge of a block: fine in the air, the end of the walk otherwise."""
        over = self.lanes is not None and self.lanes[leg].presence(place, SCALARS) > 0.5
        if over == self.in_play[leg]:
            return
        if clearance <= 0.0:
            what = "struck the side of a block" if over else "stepped off its block"
            self._end(FELL, f"foot {leg} {what} at t = {time:.6g} s")
        self._set(time, leg, over)

    def _set(self, time: float, leg: int, acts: bool) -> None:
        self.in_play[leg] = acts
        self.landed[leg] = False
        self.switches.append((time, leg, acts))
        if self.lanes is None:
            self.walker.set_in_play(leg, acts)

    def _mid_stance(self, angles: tuple[float, float]) -> bool:
        return angles[self.last_landed] <= 0.0
