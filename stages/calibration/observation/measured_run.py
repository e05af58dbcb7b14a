"""One run as the calibration takes it: samples on body axes, when they were taken, and which of them are used."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stages.analytic.model.walker import Vector
from stages.calibration.observation.prediction import Sampling
from stages.calibration.observation.unknowns import SIDES


@dataclass(frozen=True)
class MeasuredRun:
    """Samples of each side, (m, 3): forward and up [m/s^2], lateral rate [rad/s]; NaN where one is missing.

    `used` (m, 3) marks those that count. `strikes` (s,) [s] are the heel strikes that were measured, the first at 0.
    `own` are measurements of the run's own parameters of the design: name to (value, standard deviation).
    """

    name: str
    sampling: Sampling
    samples: Mapping[str, np.ndarray]
    used: Mapping[str, np.ndarray]
    strikes: Vector
    own: Mapping[str, tuple[float, float]]

    def upto(self, horizon: float) -> MeasuredRun:
        """The run without samples later than `horizon` [s]."""
        kept = {side: getattr(self.sampling, side) <= horizon for side in SIDES}
        return dataclasses.replace(
            self,
            sampling=self.sampling.upto(horizon),
            samples={side: self.samples[side][kept[side]] for side in SIDES},
            used={side: self.used[side][kept[side]] for side in SIDES},
        )

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return max(float(times[-1]) for times in (self.sampling.hip, self.sampling.foot) if times.size)

    @property
    def count(self) -> int:
        """Readings that are used."""
        return int(sum(self.used[side].sum() for side in SIDES))


def usable(times: Vector, strikes: Vector, first: float, before: float, after: float) -> Vector:
    """Mask (m,) of times from `first` on and not from `before` to `after` around a strike [s]."""
    mask = np.asarray(times >= first)
    for strike in strikes:
        mask &= (times < strike - before) | (times > strike + after)
    return mask
