"""A run that is followed, one sample after another, over steps and pushes.

What moves the robot in no model, a push, is told by samples that are all surprising. The step, or where its leg has
landed already the next one, is then begun anew: its start may be any near by, and only what comes later tells of it.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.model.walker import Vector
from stages.calibration.following.follower import Follower
from stages.calibration.following.present import Instant
from stages.calibration.following.step import Belief, Sample, Step
from stages.calibration.observation.measured_run import SIDES, MeasuredRun
from stages.calibration.observation.prediction import Walked

#: A step is linearised again, at most so often, where its mean moved by more than this share of its errors.
AGAIN, MOVED = 6, 0.05
#: So long after a step's last sample it is settled [s], of samples that come every hundredth.
LATER = 0.1
#: Without samples a run is walked for so many steps, and then lost.
BLIND = 4.0
#: So much of a step before a heel strike it is told whether the robot will fall, if the strike is known to this share.
EARLY, SURE = 0.06, 0.006
#: A push is where all of so many samples are so surprising, in mean squares of their standard deviations. Then a start
#: may be so many of its usual changes elsewhere, and the step is linearised so often after each sample.
LATELY, PUSHED, BLOW, AFTER_PUSH = 4, 25.0, 60.0, 2
#: First it is linearised so often from each of several starts: with the speed of its leg times these.
AFRESH = (1.0, 0.7, 0.4, 0.2, 0.0, -0.2, -0.4, 1.5), 4


def follow(follower: Follower, run: MeasuredRun) -> Iterator[Instant]:
    """All that is known of a run from its second mid-stance on. Raises StepFailed where it cannot be followed."""
    track = Track(follower, run, {side: run.sampling.of(side) for side in SIDES})
    for sample in samples_of(run):
        instant = track.take(sample)
        if instant is not None:
            yield instant


class Track:
    """A run that is followed from its first heel strikes on, one sample after another.

    The times of samples that are `coming` (m,) [s] may be known, by side. States are told so long `ahead` [s] of a
    sample's time.

    A step is walked before its first sample, so that none waits for it. After its last one it is linearised again, a
    part with each of the next samples, which it answers meanwhile; then the next step takes these once more. Raises
    StepFailed where the run cannot be followed.
    """

    _step: Step
    _at: Vector
    _walked: Walked
    _until: float
    _pushed: float
    _starts: tuple[tuple[float, ...], int]

    def __init__(
        self, follower: Follower, run: MeasuredRun, coming: Mapping[str, Vector] = MappingProxyType({}),
        ahead: float = 0.0,
    ) -> None:  # fmt: skip
        self._follower, self._sampling, self._coming, self._ahead = follower, run.sampling, coming, ahead
        self._waiting = list[Sample]()
        self._work: Iterator[None] | None = None
        self._jolt, self._lately, self._warned = -math.inf, list[float](), False
        self._speed = len(follower.model.of_design) + follower.model.layout.place("start_theta_rate")
        self._period = self._usual = float(np.diff(run.strikes[:3]).mean())
        belief, at = follower.begin(run)
        self._first = self._until = follower.mid_stance(belief.mean) + follower.settling
        self._enter(belief, at)
        self._shown_from = self._until

    def take(self, sample: Sample) -> Instant | None:
        """What is known after a sample of the hip, from the second mid-stance on."""
        if sample.time < self._first:
            return None
        self._route(sample)
        if sample.side != SIDES[0] or sample.time < self._shown_from:
            return None
        if sample.time > self._step.ends and self._pushed > -math.inf:
            self._starts = AFRESH
            self._again(sample.time)
        if sample.time > self._step.ends:
            raise StepFailed("the robot falls")
        instant = self._step.instant(sample.time + self._ahead)
        soon = EARLY * self._period
        if self._warned or not (instant.strike < sample.time + soon and instant.strike_sd < SURE * self._period):
            return instant
        self._warned = True
        return replace(instant, falls=tuple(self._step.falls()))

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
        settled = sample.time > self._pushed + self._follower.settling
        surprise = self._step.take(replace(sample, used=sample.used & (not near) & settled), kept)
        self._lately = [*self._lately[1 - LATELY:], surprise] if math.isfinite(surprise) else self._lately
        if self._pushed > -math.inf:
            if settled and sample.side == SIDES[0] and kept:
                self._again(sample.time)
        elif len(self._lately) == LATELY and min(self._lately) > PUSHED and self._jolt == -math.inf:
            self._step.forget(sample.time - self._follower.settling)
            if self._step.has_landed(sample.time):
                self._jolt = sample.time
            else:
                self._push(sample.time)

    def _push(self, time: float) -> None:
        """Begin the step anew: what moves the robot is not in its model, so its start may have been any near by."""
        o, layout = len(self._follower.model.of_design), self._follower.model.layout
        start, belief = self._follower.start, self._step.belief
        covariance = belief.covariance.copy()
        covariance[start] = covariance[:, start] = 0.0
        prior = np.where(np.isfinite(layout.prior), layout.prior, BLOW * layout.sizes)
        covariance[start, start] = prior[[place - o for place in start]] ** 2
        self._pushed, self._starts = time, AFRESH
        self._step = self._step.anew(Belief(belief.mean, covariance, belief.leg), self._at, self._walked)

    def _again(self, time: float) -> None:
        """Linearise the step after a push about what its samples up to a time [s] tell, first from several starts.

        A leg that is stopped or turned round moves its sensors as one that was made faster does, for a while.
        """
        (shares, count), found = self._starts, []
        for share in shares:
            at, walked, step = self._at, self._walked, self._step
            moved = step.mean - at
            if share != 1.0:
                moved = np.zeros(len(at))
                moved[self._speed] = (share - 1.0) * at[self._speed]
            with contextlib.suppress(StepFailed):
                for _ in range(count):
                    at, walked = self._follower.nearer(at, moved, step.leg, self._sampling, self._period, time)
                    known, misfit = step.again(at, walked)
                    step = step.anew(known, at, walked, step)
                    moved = step.mean - at
                found.append((misfit, at, walked, step))
        if not found:  # more samples may tell
            self._starts = AFRESH
            return
        self._starts = (1.0,), AFTER_PUSH
        _, self._at, self._walked, self._step = min(found, key=lambda one: one[0])
        self._end()

    def _end(self) -> None:
        """When the step ends [s]: at the next mid-stance; of one that falls, when it would."""
        follower = self._follower
        following = follower.mid_stance(self._at) + self._period
        with contextlib.suppress(StepFailed):
            following = follower.mid_stance(follower.onwards(self._at, self._walked)[0])
        self._until = following + follower.settling

    def _settle(self) -> Iterator[None]:
        """Linearise the step about what all its samples tell, and enter the next one, in parts of like work."""
        follower, step, at = self._follower, self._step, self._at
        mean = step.mean.copy()
        for _ in range(AGAIN):
            at, walked = follower.nearer(at, mean - at, step.leg, self._sampling, self._period, self._until)
            yield
            known, _ = step.again(at, walked)
            yield
            mean = known.mean
            if np.all(np.abs(mean - at) <= MOVED * np.sqrt(np.diag(known.covariance))):
                break
        found, grown = follower.onwards(at, walked)
        mean, covariance = found + grown @ (mean - at), grown @ known.covariance @ grown.T + follower.drift()
        self._period = max(self._usual, follower.mid_stance(mean) - follower.mid_stance(at))  # a short one comes alone
        self._enter(Belief(mean, 0.5 * (covariance + covariance.T), 1 - step.leg), mean)

    def _enter(self, belief: Belief, at: Vector) -> None:
        """Walk a step with the unknowns `at` (n,)."""
        walked = self._follower.walked(at, belief.leg, self._sampling, self._period)
        follower, self._since = self._follower, self._until
        self._at, self._walked, self._warned, self._pushed = at, walked, False, -math.inf
        jolt, self._jolt = self._jolt, -math.inf
        self._lately.clear()
        self._end()
        coming = {side: times[(times >= self._since) & (times < self._until + LATER)]
                  for side, times in self._coming.items()}
        self._step = Step(follower.model, self._sampling, belief, at, walked, follower.wrong, coming)
        if jolt > -math.inf:
            self._push(jolt)


def samples_of(run: MeasuredRun) -> Iterator[Sample]:
    """The samples of a run in the order of time, the foot's first where both have the same."""
    order = sorted((float(time), side, number) for side in SIDES for number, time in enumerate(run.sampling.of(side)))
    for time, side, number in order:
        yield Sample(time, side, run.samples[side][number], run.used[side][number])
