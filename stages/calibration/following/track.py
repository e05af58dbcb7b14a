"""A run that is followed, one sample after another, over steps and pushes.

What moves the robot in no model, a push, shows in samples that are all improbable. A step then begins where the
robot is: with the places that were known, and rates that may be any near by.
"""

import contextlib
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import ndtr, stdtrit

from stages.analytic.errors import StepFailed
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.run_fit import Model
from stages.calibration.following.follower import Follower
from stages.calibration.following.present import Instant
from stages.calibration.following.robot_file import IN_A_ROW, FittedRobot
from stages.calibration.following.step import Estimate, Sample, Step
from stages.calibration.observation.measured_run import SIDES, MeasuredRun
from stages.calibration.parameters import Settings
from stages.calibration.result import HALF_WIDTH

#: A step is linearised again, at most so often, where its mean moved by more than this share of its errors; what is
#: known for certain, as the angle at mid-stance, moves by what is rounded. A move that fits worse is shortened so.
AGAIN, MOVED, ROUNDED, SHORTER = 12, 0.05, 1e-9, 0.25
#: Without samples a run is walked for so many steps, and then lost.
BLIND = 4.0
#: So much of a step before a heel strike it is said whether the robot will fall, if the strike is known to this share.
EARLY, SURE = 0.06, 0.006
#: Forecasts of heel strikes are held against measured ones from so long before on, in steps; so many runs show how they
#: differ.
BEFORE, ENOUGH = 0.2, 9
#: Forecasts with so many times the usual standard error, as the first ones of a run, do not show how late strikes are.
VAGUE = 2.0
#: Half of the mean squares of three normal numbers are below this.
HALF = 0.789
#: A push is where all of so many samples are so improbable, in mean squares of their standard deviations, and so many
#: times as much as any of the robot's own runs: what the model lacks in each step, as a pair's second foot that lands
#: later, is no push. Then the step is linearised anew after each sample.
PUSHED, BEYOND = 25.0, 4.0


def follow(follower: Follower, run: MeasuredRun) -> Iterator[Instant]:
    """All that is known of a run from its second mid-stance on. Raises StepFailed where it cannot be followed."""
    track = Track(follower, run)
    for sample in samples_of(run):
        yield from track.take(sample)


def forecasts(instants: Sequence[Instant], strikes: Vector) -> np.ndarray:
    """Heel strikes (s,) [s] less what was forecast `BEFORE` of a step before, and its standard errors, (f, 2)."""
    ahead = BEFORE * float(np.median(np.diff(strikes)))
    told = [one for one in instants if math.isfinite(one.strike)]
    seen = [(strike, [one for one in told if strike - 2 * ahead < one.time < strike - ahead]) for strike in strikes]
    return np.array([(strike - some[-1].strike, some[-1].strike_sd) for strike, some in seen if some]).reshape(-1, 2)


def with_forecasts(
    robot: FittedRobot, model: Model, settings: Settings, held_out: Sequence[MeasuredRun] = ()
) -> FittedRobot:
    """A robot whose heel strikes are as late as those of its own runs, and of ones held out, came after forecasts of
    them, and whose innovations are as large; of the last nine runs."""
    follower, found, sizes = Follower.of(robot, model, settings), [], [0.0]
    for run in [*(one.run for one in robot.learned), *held_out][-ENOUGH:]:
        instants = list[Instant]()
        with contextlib.suppress(StepFailed):  # as far as it goes
            instants.extend(follow(follower, run))
        found.append(forecasts(instants, run.strikes))
        sizes.append(typical(one.innovation for one in instants))
    late, sd = lateness(found)
    return replace(robot, late=late, late_sd=sd, innovation=float(np.nanmax(sizes)))


def typical(innovations: Iterable[float]) -> float:
    """Typical size of readings' innovations in their standard deviations, by mean squares of them; NaN without any. A
    few outliers do not count."""
    known = [one for one in innovations if math.isfinite(one)]
    return math.sqrt(np.median(known) / HALF) if known else math.nan


def lateness(found: Sequence[np.ndarray]) -> tuple[float, float]:
    """How late heel strikes of a further run come after forecasts, and the standard deviation [s] beside a forecast's
    own, by those of each of some runs (f, 2); zero without any.

    Strikes scatter within a run, and whole runs among each other (R. A. Fisher's analysis of variance). Few runs leave
    that open: `HALF_WIDTH` deviations are Student's interval, with the freedom of F. E. Satterthwaite (Biometrics
    Bulletin 2, 1946, 110). A lone run does not say how others are, and is taken to be off by all that it is late.
    """
    every = np.vstack([np.empty((0, 2)), *found])
    if not len(every):
        return 0.0, 0.0
    least = VAGUE * np.median(every[:, 1])
    each = [sure for one in found if len(sure := one[one[:, 1] <= least])]
    runs = [one[:, 0] for one in each]
    means, count = np.array([one.mean() for one in runs]), sum(map(len, runs))
    within = sum(float(((one - one.mean()) ** 2).sum()) for one in runs) / max(count - len(runs), 1)
    by_chance = within * np.mean([1.0 / len(one) for one in runs])
    alike, freedom = (means.var(ddof=1), len(runs) - 1) if len(runs) > 1 else (means[0] ** 2, math.inf)
    parts = np.array([max(alike, by_chance) * (1.0 + 1.0 / len(runs)), within - by_chance])
    left_open = float((parts**2 / [freedom, max(count - len(runs), 1)]).sum())
    widening = stdtrit(parts.sum() ** 2 / left_open, ndtr(HALF_WIDTH)) / HALF_WIDTH if left_open else 1.0
    spread = parts.sum() * widening**2
    return float(means.mean()), math.sqrt(max(spread - np.mean(np.vstack(each)[:, 1] ** 2), 0.0))


class Track:
    """A run that is followed from its first heel strikes on, one sample after another; states are given so long `ahead`
    [s] of a sample's time.

    No answer waits for what the next ones need. After a step's last sample it is linearised again, a part after the
    answer to each of the next samples; then the next step takes these once more. The chances to fall are walked after
    one answer and come with the next. Raises StepFailed where the run cannot be followed.
    """

    _step: Step
    _until: float
    _pushed: float
    _warned: bool
    _falls: tuple[float, ...] = ()
    _lately: list[tuple[float, float]]

    def __init__(self, follower: Follower, run: MeasuredRun, ahead: float = 0.0) -> None:
        self._follower, self._ahead = follower, ahead
        self._pushes = max(PUSHED, BEYOND * follower.unexplained)
        self._waiting, self._early = list[Sample](), list[Sample]()
        self._work: Iterator[None] | None = None
        self._period = self._usual = float(np.diff(run.strikes[:3]).mean())
        estimate, at = follower.begin(run)
        self._first = self._seen = self._until = follower.mid_stance(estimate.mean) + follower.settings.settling_s
        self._enter(self._begun(estimate, at))
        self._shown_from = self._until

    def take(self, sample: Sample) -> Iterator[Instant]:
        """What is known after a sample of the hip, from the second mid-stance on; then work that is not for it."""
        if sample.time < self._first:
            return
        if sample.side != SIDES[0]:
            self._early.append(sample)
            if sample.time > self._seen + BLIND * self._period:
                raise StepFailed(f"there are no samples of the hip for {sample.time - self._seen:.3g} s")
            return
        due = [one for one in self._early if one.time <= sample.time]  # a hip's that come late find their step
        self._seen, self._early = sample.time, self._early[len(due) :]
        for one in [*due, sample]:
            self._route(one)
        if sample.time >= self._shown_from:
            if sample.time > self._step.ends:
                raise StepFailed("the robot falls")
            instant = self._step.instant(sample.time + self._ahead)
            yield replace(instant, falls=self._falls)
            self._falls = ()
            soon = instant.strike < sample.time + EARLY * self._period and instant.strike_sd < SURE * self._period
            if soon and not self._warned:
                self._warned, self._falls = True, tuple(self._step.falls())
        if self._work is not None and next(self._work, self) is self:
            self._enter_next()

    def _route(self, sample: Sample) -> None:
        """Give a sample to its step, and go on to the next one where it is beyond; one of an earlier step is too late.
        """
        if sample.time < self._since:
            return
        if sample.time < self._until:
            self._give(sample)
            return
        if sample.time > self._until + BLIND * self._period:
            raise StepFailed(f"there are no samples for {sample.time - self._until:.3g} s")
        self._waiting.append(sample)
        self._work = self._work or self._settle()
        if sample.time > self._step.ends:
            self._enter_next()
        else:
            self._give(sample, kept=False)

    def _enter_next(self) -> None:
        """Go on to the next step, which takes the samples that wait for it."""
        list(self._work or ())
        waiting, self._waiting, self._work = self._waiting, [], None
        for one in waiting:
            self._route(one)

    def _give(self, sample: Sample, kept: bool = True) -> None:
        """Let the step take a sample, which does not count near a heel strike."""
        settings = self._follower.settings
        near = self._step.is_near_a_strike(sample.time, settings.before_strike_s, settings.after_strike_s)
        settled = sample.time > self._pushed + settings.settling_s
        innovation = self._step.take(replace(sample, used=sample.used & (not near) & settled), kept)
        if math.isfinite(innovation):
            self._lately = [*self._lately[1 - IN_A_ROW:], (innovation, sample.time)]
        if self._pushed > -math.inf:
            if settled and sample.side == SIDES[0] and kept:
                with contextlib.suppress(StepFailed):  # where no step is near, more samples may show
                    self._step = self._follower.nearer(self._step, self._period, sample.time)
                    self._end()
        elif len(self._lately) == IN_A_ROW and min(self._lately)[0] > self._pushes:
            self._push(min(time for _, time in self._lately))

    def _push(self, time: float) -> None:
        """Begin a step where it is: at a time [s] something moved the robot that is not in its model."""
        estimate = self._follower.pushed(self._step.until(time), time)
        self._until, self._waiting, self._work, self._falls = time, [], None, ()
        self._enter(self._begun(estimate, estimate.mean))
        self._pushed = time

    def _end(self) -> None:
        """When the step ends [s]: at the next mid-stance; when it usually would, if it falls, or if so little is known
        after a push that this came before its start."""
        follower = self._follower
        begins, following = follower.mid_stance(self._step.at), -math.inf
        with contextlib.suppress(StepFailed):
            following = follower.mid_stance(follower.onwards(self._step).mean)
        self._until = (following if following > begins else begins + self._period) + follower.settings.settling_s

    def _settle(self) -> Iterator[None]:
        """Linearise the step about what all its samples tell, and enter the next one, in parts of like work."""
        follower, step, share = self._follower, self._step, 1.0
        least = step.cost
        for _ in range(AGAIN):
            tried = follower.nearer(step, self._period, self._until, share)
            yield
            known, cost = tried.known, tried.cost
            yield
            if cost > least:  # where readings bend, a whole step may lead away, and never come to rest
                share *= SHORTER
                continue
            step, least, share = tried, cost, min(share / SHORTER, 1.0)
            errors = np.sqrt(np.abs(np.diag(known.covariance)))
            if np.all(np.abs(known.mean - step.at) <= np.maximum(MOVED * errors, ROUNDED)):
                break
        estimate = follower.onwards(step, share)
        late = follower.mid_stance(estimate.mean) - follower.mid_stance(step.at)
        self._period = max(self._usual, late)  # a short one comes alone
        entered = self._begun(estimate, estimate.mean)
        yield
        self._enter(entered)

    def _begun(self, estimate: Estimate, at: Vector) -> Step:
        """A step with the unknowns `at` (n,), or with drawn ones where it falls with those."""
        follower = self._follower
        found = follower.walking((at,), estimate, self._period, "the robot falls before its next heel strike")
        return Step(follower.anywhere, follower.wrong, estimate, *found)

    def _enter(self, step: Step) -> None:
        """Go on to a step."""
        self._since, self._step = self._until, step
        self._warned, self._pushed, self._lately = False, -math.inf, []
        self._end()


def samples_of(run: MeasuredRun) -> Iterator[Sample]:
    """The samples of a run in the order of time, the foot's first where both have the same."""
    order = sorted((float(time), side, number) for side in SIDES for number, time in enumerate(run.sampling.of(side)))
    for time, side, number in order:
        yield Sample(time, side, run.samples[side][number], run.used[side][number])
