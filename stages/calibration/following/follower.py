"""The state of a robot while it walks, from the sensors at its hip and foot: a Kalman filter over step after step.

What is not known, in the order of `Model.names`: the design, the start of the step at its mid-stance, and the errors of
the sensors. They are constants of the step, of which each sample tells something; the state at any time follows from
them, with exact derivatives. At the next mid-stance its state takes the start's place. See Bar-Shalom, Li, Kirubarajan,
Estimation with Applications to Tracking and Navigation (2001), 11.4, on the iterated filter.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.run_fit import Model, fit_run
from stages.calibration.information.identifiability import SLOPE
from stages.calibration.observation.measured_run import SIDES, MeasuredRun
from stages.calibration.observation.prediction import Walked, sample_times, walk
from stages.calibration.observation.stretches import Stretch

#: A step is linearised again, at most so often, where its mean moved by more than this share of its errors.
AGAIN, MOVED = 6, 0.05
#: A step is walked for so many of the last one's period, to the heel strike after the next mid-stance.
AHEAD = 1.2
#: A change of the unknowns with which the robot falls is halved so often at most.
HALVED = 5
#: A state is solved for to this share of its units, which counts where sensors and damping leave less open.
SOLVED = 1e-5
#: So many standard errors of its time from an event a state may be before or after it.
NEAR = 4.0
#: What has no prior begins with so many of its usual changes for a standard deviation.
OPEN = 10.0


@dataclass(frozen=True)
class Belief:
    """What is known of the unknowns (n,) of `Model.names` at a step's mid-stance: `mean` (n,) and `covariance` (n, n)
    in SI units, and the leg that stands."""

    mean: Vector
    covariance: np.ndarray
    leg: int


@dataclass(frozen=True)
class Instant:
    """What is known right after a sample of the hip, at `time` [s] on the run's clock, from samples up to that time.

    The state (size,) in SI units with its `covariance`, the leg that stands, whether both bear, and when the next heel
    strike comes with its standard error [s]. `surprise` is the mean square of the readings' innovations, in their own
    standard deviations; NaN without a reading.
    """

    time: float
    state: Vector
    covariance: np.ndarray
    leg: int
    double: bool
    strike: float
    strike_sd: float
    surprise: float


@dataclass(frozen=True)
class Follower:
    """Follows runs of the robot `design`; what the model looks for has the errors of a `Belief`.

    `covariance` (o, o) is that of the design's parameters `model.of_design`. Samples count from `settling` [s] after a
    mid-stance on, when the low pass has forgotten that its walk began there.
    """

    design: DesignPoint
    model: Model
    covariance: np.ndarray
    settling: float

    def follow(self, run: MeasuredRun) -> Iterator[Instant]:
        """All that is known of a run from its second mid-stance on. Raises StepFailed where it cannot be followed."""
        belief, near = self.begin(run)
        at = near
        period = float(np.diff(run.strikes).mean())
        since = first = self._mid_stance(belief.mean) + self.settling
        while True:
            walked = self._walked(at, belief.leg, run, period)
            until = self._mid_stance(self._onwards(at, walked)[0]) + self.settling
            if until > run.duration:
                return
            instants, following = self.step(belief, between(run, since, until), period, at, walked)
            if since > first:
                yield from instants
            period = self._mid_stance(following.mean) - self._mid_stance(belief.mean)
            belief, at, since = following, following.mean, until

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

    def step(
        self, belief: Belief, run: MeasuredRun, period: float, at: Vector, walked: Walked
    ) -> tuple[list[Instant], Belief]:
        """Follow one step, whose samples `run` has: an instant for each, and what is known at the next mid-stance.

        A step lasts about `period` [s]; it is linearised first `at` unknowns (n,), which have `walked` so. Raises
        StepFailed where the walker does not get there.
        """
        instants = list[Instant]()
        for again in range(AGAIN):
            one = Pass(self, belief, at, walked, run)
            found = list(one.instants())
            instants = instants if again else found
            moved, size = one.mean - at, np.sqrt(np.diag(one.covariance))
            at, walked = self._nearer(at, moved, belief.leg, run, period)
            if np.all(np.abs(moved) <= MOVED * size):
                break
        mean, grown = self._onwards(at, walked)
        covariance = grown @ one.covariance @ grown.T
        return instants, Belief(mean, 0.5 * (covariance + covariance.T), 1 - belief.leg)

    def _nearer(self, at: Vector, moved: Vector, leg: int, run: MeasuredRun, period: float) -> tuple[Vector, Walked]:
        """The unknowns after a step `moved` (n,), or after the largest of its halves with which the robot walks."""
        for halved in range(HALVED):
            with contextlib.suppress(StepFailed):
                return at + moved / 2**halved, self._walked(at + moved / 2**halved, leg, run, period)
        raise StepFailed("no robot near this one walks as the samples say")

    def _walked(self, at: Vector, leg: int, run: MeasuredRun, period: float) -> Walked:
        o = len(self.model.of_design)
        there = self.design.with_values(dict(zip(self.model.of_design, map(float, at[:o]), strict=True)))
        if not there.is_legal():
            raise StepFailed("the robot has no such design")
        return walk(there, self.model.of_design, at[o:], self.model.layout, replace(run.sampling, first_leg=leg),
                    AHEAD * period, self.model.tolerance)  # fmt: skip

    def _mid_stance(self, at: Vector) -> float:
        return float(at[len(self.model.of_design) + self.model.layout.place("mid_stance")])

    def _onwards(self, at: Vector, walked: Walked) -> tuple[Vector, np.ndarray]:
        """The unknowns at the next mid-stance, and their derivatives (n, n) by those at this one."""
        o, layout = len(self.model.of_design), self.model.layout
        rows = walked.next_start()
        mean, grown = at.copy(), np.eye(len(at))
        places = [o + place for place in (*range(layout.free), layout.place("mid_stance"))]
        mean[places], grown[places] = rows[:, 0], rows[:, 1:]
        return mean, grown


def between(run: MeasuredRun, since: float, until: float) -> MeasuredRun:
    """The samples of a run from `since` [s] to before `until`."""
    kept = {side: (run.sampling.of(side) >= since) & (run.sampling.of(side) < until) for side in SIDES}
    hip, foot = (run.sampling.of(side)[kept[side]] for side in SIDES)
    return replace(run, sampling=replace(run.sampling, hip=hip, foot=foot),
                   samples={side: run.samples[side][kept[side]] for side in SIDES},
                   used={side: run.used[side][kept[side]] for side in SIDES})  # fmt: skip


class Pass:
    """The samples of one step, one after another, linearised at the unknowns `at` (n,)."""

    def __init__(self, follower: Follower, belief: Belief, at: Vector, walked: Walked, run: MeasuredRun) -> None:
        self._follower, self._at, self._walked, self._run = follower, at, walked, run
        self.mean, self.covariance = belief.mean.copy(), belief.covariance.copy()
        self._strikes, self._turns = walked.strikes(), walked.turns()

    def instants(self) -> Iterator[Instant]:
        """Take the samples as they were taken, and say what is known after each of the hip's."""
        run, model, noise = self._run, self._follower.model, np.asarray(self._follower.model.noise)
        found = self._walked.samples(run.sampling, sample_times(self._walked.value, run.sampling))
        order = sorted((float(time), side, number)
                       for side in SIDES for number, time in enumerate(run.sampling.of(side)))
        states, lie = self._walked.states(run.sampling.hip)
        surprise, count = 0.0, 0
        for time, side, number in order:
            used = run.used[side][number]
            if used.any():
                left = (run.samples[side][number] - found[side][number, :, 0])[used]
                surprise += self._take(left, found[side][number, :, 1:][used], noise[used], model.robust)
                count += int(used.sum())
            if side == "hip":
                yield self._instant(time, states[number], lie[number], surprise / count if count else np.nan)
                surprise, count = 0.0, 0

    def _take(self, left: Vector, rows: np.ndarray, noise: Vector, robust: float) -> float:
        """Take readings (r,) less what they should have been at the linearisation, and their derivatives (r, n)."""
        innovation = left - rows @ (self.mean - self._at)
        across = self.covariance @ rows.T
        expected = rows @ across + np.diag(noise**2)
        size = np.abs(innovation) / np.sqrt(np.diag(expected))
        expected += np.diag(noise**2 * np.maximum(size / robust - 1.0, 0.0))  # Huber's: what is far off pulls less
        gain = np.linalg.solve(expected, across.T).T
        self.mean = self.mean + gain @ innovation
        self.covariance = self.covariance - gain @ across.T
        self.covariance = 0.5 * (self.covariance + self.covariance.T)
        return float(size @ size)

    def _instant(self, time: float, state: np.ndarray, stretch: Stretch, surprise: float) -> Instant:
        moved, by = self.mean - self._at, state[:, 1:]
        spread = by @ self.covariance @ by.T + np.diag((SOLVED * self._walked.walker.scales()) ** 2)
        for when, jump in zip(*self._turns, strict=True):  # it may be on the other side of an event near by
            sd = self._sd(when)
            if abs(when[0] + when[1:] @ moved - time) < NEAR * sd:
                spread += np.outer(jump, jump) * sd**2
        coming = self._strikes[:, 0] + self._strikes[:, 1:] @ moved
        following = int(np.argmax(coming > time)) if (coming > time).any() else -1
        strike = (float(coming[following]), self._sd(self._strikes[following])) if following >= 0 else (np.nan, np.nan)
        return Instant(
            time, state[:, 0] + by @ moved, spread, stretch.stance_leg, stretch.double, *strike, surprise)

    def _sd(self, time: Vector) -> float:
        """Standard error [s] of a time with its derivatives (1 + n,)."""
        return float(np.sqrt(time[1:] @ self.covariance @ time[1:]))
