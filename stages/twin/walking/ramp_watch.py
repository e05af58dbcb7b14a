"""The watch over a run on the ramp: feet swing down through the gaps between blocks, and must come down on a block.

The ground acts on a pair while both its feet are over their blocks. A foot that crosses a block's edge does so in the
air, so the force never jumps; if it touches then, or comes down where no block is, the run ends with that reason.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stages.twin.machine.contact import feet_places
from stages.twin.machine.machine import LEGS
from stages.twin.ramp import Ramp
from stages.twin.walking.watch import Watch

MISSED = "missed a block"


@dataclass
class RampWatch(Watch):
    """`Watch` with the ground of a `ramp`; `risen` tells which pairs are in the air ahead of the other pair."""

    ramp: Ramp = field(kw_only=True)
    risen: list[bool] = field(default_factory=lambda: [False, False])

    def _switch(self, time: float, q: np.ndarray) -> None:
        places = feet_places(q, self.tree.feet)
        middle = places[::2, 0] + places[1::2, 0]
        for pair in (0, 1):
            feet = (2 * pair, 2 * pair + 1)
            carried = [self._carried(foot, places[foot]) for foot in feet]
            low = [foot for foot in feet if places[foot, 1] <= 0.0]
            if self.in_play[pair] and not all(carried):
                lost = [foot for foot, there in zip(feet, carried, strict=True) if not there and foot in low]
                if lost:
                    self._end(MISSED, self._departure(lost[0], places[lost[0]]))
                    return
                self._set(time, pair, False)
            elif not self.in_play[pair] and any(carried):
                struck = [foot for foot, there in zip(feet, carried, strict=True) if there and foot in low]
                if struck:
                    self._end(MISSED, f"{self._foot(struck[0])} struck the side of {self._set_name(struck[0], places)}")
                    return
                if all(carried):
                    self._set(time, pair, True)
            ahead = middle[pair] > middle[1 - pair]
            if low and not self.in_play[pair] and self.risen[pair] and ahead:
                self._end(MISSED, self._landing(low[0], places[low[0]]))
                return
            self.risen[pair] = bool(ahead and not low)
            if low and self.in_play[pair] and not self.landed[pair]:
                self._land(time, pair)

    def _carried(self, foot: int, place: np.ndarray) -> bool:
        half_width = self.tree.machine.half_width
        return self.ramp.carries(foot // 2, float(place[0]), float(place[2]), half_width)

    def _foot(self, foot: int) -> str:
        return f"in step {self.heel_strikes + 1} the {LEGS[foot]} foot"

    def _set_name(self, foot: int, places: np.ndarray) -> str:
        return f"block set {self.ramp.number(foot // 2, float(places[foot, 0]))}"

    def _departure(self, foot: int, place: np.ndarray) -> str:
        aside = self.ramp.beside(foot // 2, float(place[2]), self.tree.machine.half_width)
        way = f"over the side of its block by {1e3 * aside:.1f} mm" if aside > 0.0 else "off the end of its block"
        return f"{self._foot(foot)} went {way}"

    def _landing(self, foot: int, place: np.ndarray) -> str:
        pair, x = foot // 2, float(place[0])
        number, miss = self.ramp.number(pair, x), self.ramp.miss(pair, x)
        if number > self.ramp.sets:
            return f"{self._foot(foot)} left the ramp beyond its last set of blocks"
        aside = self.ramp.beside(pair, float(place[2]), self.tree.machine.half_width)
        if miss == 0.0:
            return f"{self._foot(foot)} came down {1e3 * aside:.1f} mm beside block set {number}"
        side = "beyond" if miss > 0.0 else "short of"
        return f"{self._foot(foot)} came down {1e3 * abs(miss):.1f} mm {side} block set {number}"
