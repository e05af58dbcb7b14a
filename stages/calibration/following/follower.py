"""A fitted robot that is followed: how it walks with what is thought of it, and what is thought at first.

What is not known, in the order of `Model.names`: the design, the start of the step at its mid-stance, and the errors of
the sensors. They are constants of the step, of which each sample tells something; the state at any time follows from
them, with exact derivatives. At the next mid-stance its state takes the start's place. See Bar-Shalom, Li, Kirubarajan,
Estimation with Applications to Tracking and Navigation (2001), 11.4, on the iterated filter.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from scipy.linalg import block_diag

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.run_fit import Model, fit_run
from stages.calibration.following.present import Instant
from stages.calibration.following.step import Belief, Sample, Step
from stages.calibration.information.identifiability import SLOPE
from stages.calibration.observation.measured_run import SIDES, MeasuredRun, Sampling
from stages.calibration.observation.prediction import Walked, walk

#: A step is linearised again, at most so often, where its mean moved by more than this share of its errors.
AGAIN, MOVED = 6, 0.05
#: A step is walked for so many of the last one's period, to the heel strike after the next mid-stance.
AHEAD = 1.2
#: A change of the unknowns with which the robot falls is halved so often at most.
HALVED = 5
#: Walks are solved to this: of a state, sensors and dampers leave less open than a calibration's tolerance.
TOLERANCE = 1e-9
#: What has no prior begins with so many of its usual changes for a standard deviation.
OPEN = 10.0
#: So long after a step's last sample it is settled [s], of samples that come every hundredth.
LATER = 0.1
#: Without samples a run is walked for so many steps, and then lost.
BLIND = 4.0


@dataclass(frozen=True)
class Follower:
    """Follows runs of the robot `design`; what the model looks for has the errors of a `Belief`.

    `covariance` (o, o) is that of the design's parameters `model.of_design`. Samples count from `settling` [s] after a
    mid-stance on, when the low pass has forgotten that its walk began there; and not from `before` to `after` a heel
    strike [s].
    """

    design: DesignPoint
    model: Model
    covariance: np.ndarray
    settling: float
    before: float
    after: float

    def follow(self, run: MeasuredRun) -> Iterator[Instant]:
        """All that is known of a run from its second mid-stance on. Raises StepFailed where it cannot be followed."""
        track = Track(self, run, {side: run.sampling.of(side) for side in SIDES})
        for sample in samples_of(run):
            instant = track.take(sample)
            if instant is not None:
                yield instant

    def begin(self, run: MeasuredRun) -> tuple[Belief, Vector]:
        """What is known at the first mid-stance before its samples are seen, and unknowns (n,) near those of its walk.

        Raises StepFailed where none are found.
        """
        model, layout = self.model, self.model.layout
        alone = replace(model, shared=(), own=(SLOPE,))
        first = run.upto(float(run.strikes[2]))
        fit = fit_run(self.design, replace(first, strikes=run.strikes[:3]), alone, ())
        prior = np.where(np.isfinite(layout.prior), layout.prior, OPEN * layout.sizes)
        middle = np.where(np.isfinite(layout.prior), layout.middle, fit.unknowns)
        mean = np.array([self.design.value(name) for name in model.of_design])
        covariance = self.covariance.copy()
        if SLOPE in run.own:
            place = model.of_design.index(SLOPE)
            mean[place], covariance[place, place] = run.own[SLOPE][0], run.own[SLOPE][1] ** 2
        at = np.concatenate([mean, fit.unknowns])
        at[model.of_design.index(SLOPE)] = fit.own[0]
        whole = block_diag(covariance, np.diag(prior**2))
        return Belief(np.concatenate([mean, middle]), whole, run.sampling.first_leg), at

    def walked(self, at: Vector, leg: int, sampling: Sampling, period: float) -> Walked:
        """A step of about a `period` [s], which begins on a leg, and what follows. Raises StepFailed where it falls."""
        o = len(self.model.of_design)
        there = self.design.with_values(dict(zip(self.model.of_design, map(float, at[:o]), strict=True)))
        if not there.is_legal():
            raise StepFailed("the robot has no such design")
        return walk(there, self.model.of_design, at[o:], self.model.layout, replace(sampling, first_leg=leg),
                    AHEAD * period, TOLERANCE)  # fmt: skip

    def nearer(
        self, at: Vector, moved: Vector, leg: int, sampling: Sampling, period: float
    ) -> tuple[Vector, Walked]:
        """The unknowns after a step `moved` (n,), or after the largest of its halves with which the robot walks."""
        for halved in range(HALVED):
            with contextlib.suppress(StepFailed):
                there = at + moved / 2**halved
                return there, self.walked(there, leg, sampling, period)
        raise StepFailed("no robot near this one walks as the samples say")

    def mid_stance(self, at: Vector) -> float:
        """The time of mid-stance [s] in unknowns (n,)."""
        return float(at[len(self.model.of_design) + self.model.layout.place("mid_stance")])

    def onwards(self, at: Vector, walked: Walked) -> tuple[Vector, np.ndarray]:
        """The unknowns at the next mid-stance, and their derivatives (n, n) by those at this one."""
        o, layout = len(self.model.of_design), self.model.layout
        rows = walked.next_start()
        mean, grown = at.copy(), np.eye(len(at))
        places = [o + place for place in (*range(layout.free), layout.place("mid_stance"))]
        mean[places], grown[places] = rows[:, 0], rows[:, 1:]
        return mean, grown


class Track:
    """A run that is followed from its first heel strikes on, one sample after another; the times of those that are
    `coming` (m,) [s] may be known, by side. States are told so long `ahead` [s] of a sample's time.

    A step is walked before its first sample, so that none waits for it. After its last one it is linearised again, a
    part with each of the next samples, which it answers meanwhile; then the next step takes these once more. Raises
    StepFailed where the run cannot be followed.
    """

    def __init__(
        self, follower: Follower, run: MeasuredRun, coming: Mapping[str, Vector] = MappingProxyType({}),
        ahead: float = 0.0,
    ) -> None:  # fmt: skip
        self._follower, self._sampling, self._coming, self._ahead = follower, run.sampling, coming, ahead
        self._waiting = list[Sample]()
        self._work: Iterator[None] | None = None
        self._period = float(np.diff(run.strikes[:3]).mean())
        belief, at = follower.begin(run)
        self._first = self._until = follower.mid_stance(belief.mean) + follower.settling
        self._enter(belief, at)
        self._told_from = self._until

    def take(self, sample: Sample) -> Instant | None:
        """What is known after a sample of the hip, from the second mid-stance on."""
        if sample.time < self._first:
            return None
        self._route(sample)
        told = sample.side == SIDES[0] and sample.time >= self._told_from
        return self._step.instant(sample.time + self._ahead) if told else None

    def _route(self, sample: Sample) -> None:
        """Give a sample to its step, and go on to the next one where it is beyond; one of an earlier step is too late.
        """
        if sample.time < self._since:
            return
        if sample.time < self._until:
            self._give(sample)
            return
        if sample.time > self._until + BLIND * self._period:
            raise StepFailed(f"there are no samples for {sample.time - self._until:.2f} s")
        self._waiting.append(sample)
        self._work = self._work or self._settle()
        far = sample.time > self._step.ends
        if far or (sample.side == SIDES[0] and next(self._work, self) is self):
            list(self._work)
            waiting, self._waiting, self._work = self._waiting, [], None
            for one in waiting:
                self._route(one)
        else:
            self._give(sample, kept=False)

    def _give(self, sample: Sample, kept: bool = True) -> None:
        """Let the step take a sample, which does not count near a heel strike."""
        near = self._step.is_near_a_strike(sample.time, self._follower.before, self._follower.after)
        self._step.take(replace(sample, used=sample.used & (not near)), kept)

    def _settle(self) -> Iterator[None]:
        """Linearise the step about what all its samples tell, and enter the next one, in parts of like work."""
        follower, step, at = self._follower, self._step, self._at
        mean = step.mean.copy()
        for _ in range(AGAIN):
            at, walked = follower.nearer(at, mean - at, step.leg, self._sampling, self._period)
            yield
            known = step.again(at, walked)
            yield
            mean = known.mean
            if np.all(np.abs(mean - at) <= MOVED * np.sqrt(np.diag(known.covariance))):
                break
        found, grown = follower.onwards(at, walked)
        mean, covariance = found + grown @ (mean - at), grown @ known.covariance @ grown.T
        self._period = follower.mid_stance(mean) - follower.mid_stance(at)
        self._enter(Belief(mean, 0.5 * (covariance + covariance.T), 1 - step.leg), mean)

    def _enter(self, belief: Belief, at: Vector) -> None:
        """Walk a step with the unknowns `at` (n,)."""
        walked = self._follower.walked(at, belief.leg, self._sampling, self._period)
        self._at = at
        follower, self._since = self._follower, self._until
        self._until = follower.mid_stance(follower.onwards(at, walked)[0]) + follower.settling
        coming = {side: times[(times >= self._since) & (times < self._until + LATER)]
                  for side, times in self._coming.items()}
        self._step = Step(follower.model, self._sampling, belief, at, walked, TOLERANCE, coming)


def samples_of(run: MeasuredRun) -> Iterator[Sample]:
    """The samples of a run in the order of time, the foot's first where both have the same."""
    order = sorted((float(time), side, number) for side in SIDES for number, time in enumerate(run.sampling.of(side)))
    for time, side, number in order:
        yield Sample(time, side, run.samples[side][number], run.used[side][number])
