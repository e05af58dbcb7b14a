"""The ideal ground of a walker without knees, and the watch over a run.

Legs of equal length scuff at mid-swing; the machine walks on stepping blocks for that reason. The ideal rule: the
ground ceases to act on a foot once it is in the air behind the other foot and swings forward, and acts again once the
foot is in the air ahead of the other. Both switches happen in the air, so the force never jumps. The rule and the
watch for falls and for a stuck solver run once a step, before it; the forces themselves involve no Python. In the twin
a pair of legs is one leg, and its lowest point in space that of its foot.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from stages.ground.blocks import Laid
from stages.ground.friction import SCALARS, Lane
from stages.planar.run import COMPLETED, DIVERGED, FELL, RUNNING, STALLED, STEP_FLOOR

if TYPE_CHECKING:
    from stages.multibody.assembly.system import System

#: Calls at one and the same time after which the solver is stuck (an explicit solver at its smallest step never ends).
STUCK = 60
#: Angle of a leg [rad] at which a walker has fallen.
UPSET = 0.5 * math.pi


class Look(NamedTuple):
    """A walker before a solver step: hip height [m], angles of both legs [rad], heights of their feet above the ground
    and places of the feet along it [m], the sum of its coordinates, and in which other way it fell."""

    height: float
    angles: tuple[float, float]
    clearance: tuple[float, float]
    place: tuple[float, float]
    total: float
    fell: str = ""


@dataclass(frozen=True)
class Words:
    """How a walker's runs are said to have ended: of the time t [s], the step that it happened in, and so on."""

    stuck: str = "the solver gets nowhere at its smallest step, t = {t:.6g} s"
    endless: str = "the solver gets nowhere after {calls} steps without a heel strike, t = {t:.6g} s"
    diverged: str = "the state is no longer finite at t = {t:.6g} s"
    fell: str = "the walker fell at t = {t:.6g} s"
    stalled: str = "no heel strike for {longest:g} s at t = {t:.6g} s"
    late: str = ""


@dataclass
class Watch:
    """Called before every solver step; `outcome` and `message` show why the run ended.

    `fallen` [m] is the height of the hip at which the walker has fallen. `in_play` and `landed` show which feet stand
    on the ground at the start, `last_landed` which of them landed last; `refine` may request a pause to change the step
    size. After `most_calls` solver steps without a heel strike the solver is stuck. `approach` [m] is the height of a
    foot that comes down. A foot that leaves its place has the next of the `blocks` under it; `laid` lists them.
    """

    walker: System
    fallen: float
    longest_step: float
    steps_wanted: int
    in_play: list[bool]
    landed: list[bool]
    last_landed: int = 0
    most_calls: int = 500_000
    words: Words = Words()
    refine: Callable[[float], bool] | None = None
    outcome: str = RUNNING
    message: str = ""
    switches: list[tuple[float, int, bool]] = field(default_factory=list)
    heel_strikes: int = 0
    last_heel_strike: float = 0.0
    approach: float = math.inf
    blocks: Laid | None = None
    laid: list[tuple[float, int, float]] = field(default_factory=list)
    calls: int = 0
    stuck: int = 0
    previous: float = -1.0

    def __call__(self, mbs: object, time: float) -> bool:
        """Exudyn's pre-step function: False ends the run."""
        self.calls += 1
        self.stuck = self.stuck + 1 if time == self.previous else 0
        self.previous = time
        if self.stuck > STUCK or self.calls > self.most_calls:
            self.end(STEP_FLOOR, self.words.stuck if self.stuck > STUCK else self.words.endless)
            raise RuntimeError(self.message)  # False is not looked at while a step is being repeated
        look = self.walker.look()
        if not math.isfinite(look.total):
            return self.end(DIVERGED, self.words.diverged)
        if look.height < self.fallen or max(map(abs, look.angles)) > UPSET:
            return self.end(FELL, self.words.fell)
        if look.fell:
            return self.end(FELL, look.fell)
        if time - self.last_heel_strike > self.longest_step:
            return self.end(STALLED, self.words.stalled)
        self.switch(time, look)
        if self.outcome == RUNNING and self.heel_strikes >= self.steps_wanted and look.angles[self.last_landed] <= 0.0:
            return self.end(COMPLETED)
        coming = [look.clearance[leg] for leg in (0, 1) if self.in_play[leg] and not self.landed[leg]]
        self.approach = coming[-1] if coming else math.inf
        return self.outcome == RUNNING and (self.refine is None or self.refine(time))

    @property
    def limit(self) -> float:
        """Time [s] by which its steps are done, or it has stalled."""
        return self.longest_step * (self.steps_wanted + 2)

    def end(self, outcome: str, message: str = "") -> bool:
        """End the run for this reason, with a message made of `Words`."""
        self.outcome, self.message = outcome, message.format(
            t=self.previous, calls=self.most_calls, longest=self.longest_step, wanted=self.steps_wanted,
            limit=self.limit, done=self.heel_strikes, step=self.heel_strikes + 1)
        return False

    def switch(self, time: float, look: Look) -> None:
        """Let the ground act on the feet by the ideal rule, and count heel strikes."""
        for leg in (0, 1):
            ahead = look.place[leg] - look.place[1 - leg]
            if look.clearance[leg] <= 0.0:
                if self.blocks and ahead > self.blocks.ends[leg] and self.in_play[leg] and not self.landed[leg]:
                    self.end(FELL, f"foot {leg} came down beyond its block at t = {{t:.6g}} s")
                    return
                self.touch(time, leg)
            elif self.in_play[leg] and not ahead > 0.0 and self.walker.leg_rate(leg) > 0.0:
                self.set(time, leg, False)
            elif not self.in_play[leg] and ahead > (self.blocks.begins[leg] if self.blocks else 0.0):
                self.set(time, leg, True)

    def touch(self, time: float, leg: int) -> None:
        """A foot is on the ground: a heel strike if it was not."""
        if self.in_play[leg] and not self.landed[leg]:
            self.landed[leg] = True
            self.heel_strikes += 1
            self.calls = 0
            self.last_heel_strike, self.last_landed = time, leg

    def set(self, time: float, leg: int, acts: bool) -> None:
        """Let the ground act on a foot in the air from now on, or not."""
        self.in_play[leg], self.landed[leg] = acts, False
        self.switches.append((time, leg, acts))
        self.walker.set_in_play(leg, acts)
        self.lay(time, leg)

    def lay(self, time: float, leg: int) -> None:
        """Put the block of the next footfall under a foot that is out of play."""
        if self.blocks and not self.in_play[leg]:
            height = self.blocks.height(self.heel_strikes)
            self.walker.set_height(leg, height)
            self.laid.append((time, leg, height))

    def lay_first(self) -> None:
        """Put blocks under the feet as the walk begins: it stands on level ones."""
        for leg in (0, 1) if self.blocks else ():
            self.walker.set_height(leg, 0.0)
            self.lay(0.0, leg)


@dataclass
class BlocksWatch(Watch):
    """The watch without the ideal rule: the ground itself ends between the blocks of the `lanes`."""

    lanes: tuple[Lane, Lane] = field(kw_only=True)

    def switch(self, time: float, look: Look) -> None:
        """A foot passes the edge of a block: fine in the air, the end of the walk otherwise."""
        for leg in (0, 1):
            over = self.lanes[leg].presence(look.place[leg], SCALARS) > 0.5
            if over != self.in_play[leg]:
                if look.clearance[leg] <= 0.0:
                    what = "struck the side of a block" if over else "stepped off its block"
                    self.end(FELL, f"foot {leg} {what} at t = {{t:.6g}} s")
                self.set(time, leg, over)
            if look.clearance[leg] <= 0.0:
                self.touch(time, leg)

    def set(self, time: float, leg: int, acts: bool) -> None:
        """Note that a foot is over a block from now on, or not."""
        self.in_play[leg], self.landed[leg] = acts, False
        self.switches.append((time, leg, acts))
        self.lay(time, leg)
