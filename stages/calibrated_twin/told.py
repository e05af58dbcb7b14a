"""What fits and their corrections tell of a robot: its numbers with errors, its gait, and what an outsole does."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.errors import NoGait
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import gait_near
from stages.analytic.model.walker import Vector
from stages.calibrated_twin.result import Number, Pair, Robot
from stages.calibration.estimation.held_out import Corrected
from stages.calibration.information.planned import FINE
from stages.calibration.intervals.model_error import SPARE, Discrepancy
from stages.calibration.result import FittedRun
from stages.campaign.result import BARE

HIP, FRAME = "biped.hip_mass", "biped.frame_mass"


@dataclass(frozen=True)
class Fitted:
    """Fits of one kind of robot as `drawn`, the corrections of some of them by their places, and what fits of other
    machines' runs miss, where enough tell it, in shares of `scales` (d,)."""

    kind: str
    drawn: DesignPoint
    fits: Sequence[FittedRun]
    corrections: dict[int, Corrected]
    scales: Vector
    pull: float = 0.0
    discrepancy: Discrepancy | None = None

    @property
    def by_twin(self) -> Vector:
        """What the model puts wrong, (d,), mean of the corrected runs; zero where there is none."""
        if not self.corrections:
            return np.zeros(len(self.scales))
        return np.asarray(np.mean([one.bias for one in self.corrections.values()], axis=0))

    @property
    def bias(self) -> Vector:
        """What the model puts wrong, (d,): by the other machines' runs, else by the twin's correction."""
        return self.by_twin if self.discrepancy is None else self.discrepancy.expected(self.scales, self.pull)

    def corrected(self, place: int) -> Vector:
        """A run's parameters less the bias by the twin, (d,)."""
        return np.asarray(self.fits[place].design - self.by_twin)

    @property
    def found(self) -> Vector:
        """Mean of the runs' parameters, (d,)."""
        return np.asarray(np.mean([one.design for one in self.fits], axis=0))

    @property
    def covariance(self) -> np.ndarray:
        """Of the mean of the corrected parameters, (d, d): what fits of other machines' runs scatter, noise with it.

        Where they do not tell it: that of the fits, and the whole of the bias, which moves as one.
        """
        if self.discrepancy is not None:
            return self.discrepancy.spread(self.scales, self.pull)
        noise = np.sum([one.covariance for one in self.fits], axis=0) / len(self.fits) ** 2
        return np.asarray(noise + np.outer(self.bias, self.bias))


def design_of(drawn: DesignPoint, names: Sequence[str], values: Vector) -> DesignPoint:
    """The robot with legs alike on the nominal ramp."""
    biped = dataclasses.replace(drawn.biped, other_leg_length=None)
    return DesignPoint(biped, drawn.slope).with_values(dict(zip(names, values.tolist(), strict=True)))


def frequency(
    design: DesignPoint, names: Sequence[str], covariance: np.ndarray, near: Vector
) -> tuple[float, float]:
    """Step frequency [Hz] of the gait of a design `near` another's, and its standard error; NaN where it has none."""
    try:
        walker, point = gait_near(design, near, FINE)
    except NoGait:
        return math.nan, math.nan
    value = len(point.steps) / (sum(step.period for step in point.steps) * walker.time)
    found = gait_derivatives(design, point, tuple(names), FINE)
    slope = value * found.elasticities()["step_frequency_hz"] / found.changes.scales
    return value, float(np.sqrt(slope @ covariance @ slope))


def robot_of(fitted: Fitted, names: Sequence[str], near: Vector) -> Robot:
    """A robot's numbers, as Table 1 counts them: frames belong to the hip. `near` is where a similar one's gait begins.
    """
    drawn, corrected, covariance = fitted.drawn, fitted.found - fitted.bias, fitted.covariance
    by_twin = fitted.found - fitted.by_twin
    truth = np.mean([one.truth for one in fitted.fits], axis=0)
    sd = np.sqrt(np.diag(covariance))
    values = np.array([drawn.value(name) for name in names])
    numbers = []
    for row, name in enumerate(names):
        times, more = (2.0, drawn.biped.hip_mass) if name == FRAME else (1.0, 0.0)
        of = [times * float(each[row]) + more for each in (values, fitted.found, by_twin, corrected, truth)]
        numbers.append(Number(HIP if name == FRAME else name, drawn.unit(name), of[0], of[1], of[2],
                              of[3], times * float(sd[row]), of[4]))
    value, value_sd = frequency(design_of(drawn, names, corrected), names, covariance, near)
    known = np.isfinite(truth).all()
    true = frequency(design_of(drawn, names, truth), names, covariance, near)[0] if known else math.nan
    first = fitted.fits[0].covariance
    biases = np.array([one.bias for one in fitted.corrections.values()]).reshape(-1, len(names))
    spread = np.sqrt(np.diag(first))
    others = fitted.discrepancy.count if fitted.discrepancy else 0
    return Robot(fitted.kind, len(fitted.fits), len(fitted.corrections), others, tuple(numbers),
                 first / np.outer(spread, spread), biases, value, value_sd, true)


def pairs_of(usual: Fitted, bare: Fitted, names: Sequence[str], near: Vector) -> tuple[Pair, ...]:
    """What the outsole does, by each run that was made with it and without. `near` as for `robot_of`.

    What is wrong in both alike is not in the difference. How much else is, three other pairs of known machines tell;
    where there are fewer, all that the corrections differ by counts, beside the errors of both fits.
    """
    without = {one.name.replace(BARE, ""): place for place, one in enumerate(bare.fits)}
    length, mass = names.index("biped.leg_length"), names.index("biped.foot_mass")
    both = [(place, without[one.name]) for place, one in enumerate(usual.fits) if one.name in without]
    missed = {pair: (usual.corrected(pair[0]) - usual.fits[pair[0]].truth)
              - (bare.corrected(pair[1]) - bare.fits[pair[1]].truth) for pair in both}
    found = []
    for place, other in both:
        one = usual.fits[place]
        ends = usual.corrected(place), bare.corrected(other)
        others = np.array([miss for pair, miss in missed.items() if pair != (place, other) and np.isfinite(miss).all()])
        if len(others) > SPARE:
            term = Discrepancy.of(tuple(names), others)
            ends, shared = (ends[0] - term.mean, ends[1]), term.spread(np.ones(len(names)))
        else:
            apart = usual.by_twin - bare.by_twin
            shared = one.covariance + bare.fits[other].covariance + np.outer(apart, apart)
        drawn = usual.drawn, bare.drawn
        (with_it, sd), (without_it, _) = (
            frequency(design_of(of, names, each), names, shared, near) for of, each in zip(drawn, ends, strict=True))
        true = [one.truth, bare.fits[other].truth]
        known = np.isfinite(true).all()
        designs = [design_of(of, names, each) for of, each in zip(drawn, true, strict=True)] if known else []
        real = [frequency(each, names, shared, near)[0] for each in designs] or [math.nan, math.nan]
        found.append(Pair(
            name=one.name, longer=float((ends[0] - ends[1])[length]), longer_sd=float(np.sqrt(shared[length, length])),
            true_longer=float((true[0] - true[1])[length]), heavier=float((ends[0] - ends[1])[mass]),
            slower=with_it / without_it - 1, slower_sd=sd / without_it, true_slower=real[0] / real[1] - 1))  # fmt: skip
    return tuple(found)
