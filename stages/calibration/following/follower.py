"""A fitted robot that is followed: how it walks with what is thought of it, and what is thought at first.

What is not known, in the order of `Model.names`: the design, the start of the step at its mid-stance, and the errors of
the sensors. They are constants of the step, of which each sample shows something; the state at any time follows from
them, with exact derivatives. At the next mid-stance its state takes the start's place. See Bar-Shalom, Li, Kirubarajan,
Estimation with Applications to Tracking and Navigation (2001), 11.4, on the iterated filter.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np
from scipy.linalg import block_diag

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.run_fit import Model, begun
from stages.calibration.following.robot_file import FittedRobot
from stages.calibration.following.step import Estimate, Step
from stages.calibration.information.identifiability import SLOPE
from stages.calibration.observation.measured_run import MeasuredRun, Sampling
from stages.calibration.observation.prediction import Walked, walk
from stages.calibration.parameters import Settings

#: A step is walked for so many of the last one's period, to the heel strike after the next mid-stance.
AHEAD = 1.2
#: A change of the unknowns with which the robot falls is halved so often at most.
HALVED = 5
#: Robots that are drawn of what is known where it falls with all of these.
DRAWN = 12
#: Walks are solved to this: of a state, sensors and dampers leave less open than a calibration's tolerance.
TOLERANCE = 1e-9
#: Errors of a walk, in tolerances of its integrator: of Table 1's robot over a step, against 1e-13.
SOLVED = 10.0
#: A usual change of a state, dimensionless.
USUAL = 0.01
#: What a model puts wrong in a step's start, in usual changes, where residuals are as large again as noise alone (root
#: of the sum of squares): of three walks of the twin with the numbers of the model.
DRIFT = 0.06
#: A push may change a rate by so many of its usual changes.
BLOW = 60.0
#: What has no prior begins with so many of its usual changes for a standard deviation.
OPEN = 10.0


@dataclass(frozen=True)
class Follower:
    """Follows runs of the robot `design`; what the model looks for has the errors of an `Estimate`.

    `covariance` (o, o) is that of the design's parameters `model.of_design`. By the `settings` samples count from some
    time after a mid-stance on, when the low pass has forgotten that its walk began there. The robot's fit left
    residuals so many times as wide (`wider`) as noise makes them, which is known to what is `unseen`, and some in a row
    that are `unexplained`, as `FittedRobot` has it.
    """

    design: DesignPoint
    model: Model
    covariance: np.ndarray
    settings: Settings
    wider: float = 1.0
    unexplained: float = 0.0
    unseen: float = 0.0

    @classmethod
    def of(cls, robot: FittedRobot, model: Model, settings: Settings) -> Follower:
        """That of a robot of a file, of which a `model` is made."""
        return cls(robot.design, robot.model(model), robot.of_design(), settings, robot.wider, robot.unexplained,
                   robot.unseen)  # fmt: skip

    @property
    def discrepancy(self) -> float:
        """What the model itself puts wrong in each step: of a start in its usual changes, of a state in hundredths of
        the walker's units."""
        return DRIFT * math.sqrt(max(self.wider**2 - 1.0, 0.0))

    @property
    def wrong(self) -> float:
        """Standard deviation of what is wrong in a state, by the integrator and by the model, dimensionless."""
        return max(SOLVED * TOLERANCE, USUAL * self.discrepancy)

    @cached_property
    def start(self) -> list[int]:
        """Places of a step's start among the unknowns: the state, and its time."""
        o, layout = len(self.model.of_design), self.anywhere.layout
        return [o + place for place in (*range(layout.free), layout.place("mid_stance"))]

    @cached_property
    def anywhere(self) -> Model:
        """The model of a step that may begin anywhere in single stance: its angle then is not known either."""
        layout = self.model.layout
        front = {"middle": 0.0, "prior": 0.0, "sizes": USUAL}
        arrays = {name: np.append(value, getattr(layout, name)) for name, value in front.items()}
        return replace(self.model, layout=replace(layout, names=("start_theta", *layout.names), free=layout.free + 1,
                                                  **arrays))  # fmt: skip

    def pushed(self, step: Step, time: float) -> Estimate:
        """What a step shows of its state at a time [s], from when on rates may be any near by, and a new step begins.

        The push was a sampling period later at most: places are as far off as rates move them until then.
        """
        layout = self.anywhere.layout
        rows, leg = step.walked.start_at(time)
        off = np.where(np.isfinite(layout.prior), layout.prior, BLOW * layout.sizes)[: layout.free]
        half = layout.free // 2
        off[0] = BLOW * USUAL
        off[:half] = np.hypot(off[half:] * self.settings.before_strike_s,
                              self.wrong * step.walked.walker.scales()[:half])
        wrong = np.zeros(len(step.at))
        wrong[self.start[:-1]] = off
        return self._carried(step, rows, wrong, leg)

    def begin(self, run: MeasuredRun) -> tuple[Estimate, Vector]:
        """What is known at the first mid-stance before its samples are seen, and unknowns (n,) near those of its walk.

        Raises StepFailed where none are found.
        """
        model, layout = self.model, self.anywhere.layout
        fit = begun(self.design, run, model)
        prior = layout.prior_at(run.sampling)
        prior = np.where(np.isfinite(prior), prior, OPEN * layout.sizes)
        unknowns = np.append(0.0, fit.unknowns)
        middle = np.where(np.isfinite(layout.prior), layout.middle, unknowns)
        mean = np.array([self.design.value(name) for name in model.of_design])
        covariance = self.covariance.copy()
        if SLOPE in run.own:
            place = model.of_design.index(SLOPE)
            mean[place], covariance[place, place] = run.own[SLOPE][0], run.own[SLOPE][1] ** 2
        at = np.concatenate([mean, unknowns])
        at[model.of_design.index(SLOPE)] = fit.own[0]
        whole = block_diag(covariance, np.diag(prior**2))
        return Estimate(np.concatenate([mean, middle]), whole, run.sampling), at

    def walked(
        self, at: Vector, sampling: Sampling, period: float, reached: float = -math.inf
    ) -> Walked:
        """A step of about a `period` [s], and what follows, as far as it does not fall.

        Raises StepFailed where it has no end, or one before a time that is `reached` [s].
        """
        o = len(self.model.of_design)
        there = self.design.with_values(dict(zip(self.model.of_design, map(float, at[:o]), strict=True)))
        if not there.is_legal():
            raise StepFailed("the robot has no such design")
        least = max(reached - self.mid_stance(at), 0.0)
        return walk(there, self.model.of_design, at[o:], self.anywhere.layout, sampling, max(AHEAD * period, least),
                    TOLERANCE, least)  # fmt: skip

    def nearer(self, step: Step, period: float, reached: float, share: float = 1.0) -> Step:
        """A step about what its samples tell, or a `share` of the way there, or about the largest of halves of that
        with which the robot walks until a time [s] that is `reached`; or about the first drawn robot that does, as
        where a push leaves it at the brink of a fall that does not come."""
        moved = share * (step.known.mean - step.at)
        halves = (step.at + moved / 2**halved for halved in range(HALVED))
        return step.about(*self.walking(halves, step.known, period, "no robot near this one walks as the samples say",
                                        reached))  # fmt: skip

    def walking(
        self, among: Iterable[Vector], estimate: Estimate, period: float, otherwise: str, reached: float = -math.inf
    ) -> tuple[Vector, Walked]:
        """The first of some unknowns (n,), and then of ones drawn by an estimate, with which the robot walks as
        `walked` has it, and that walk. Raises StepFailed, which says what is `otherwise`."""
        for there in chain(among, drawn(estimate)):
            with contextlib.suppress(StepFailed):
                return there, self.walked(there, estimate.sampling, period, reached)
        raise StepFailed(otherwise)

    def mid_stance(self, at: Vector) -> float:
        """The time of mid-stance, or of a step's other start [s], in unknowns (n,)."""
        return float(at[self.start[-1]])

    def onwards(self, step: Step, share: float = 1.0) -> Estimate:
        """What a step shows of the next mid-stance, a `share` of the way from where it was linearised to its mean.

        The model's discrepancy is in its start, at least as much as residuals would not show: without any, what is bent
        in each step adds up, and a limping robot's angle was six standard errors off. Raises StepFailed where it does
        not get there.
        """
        wrong, later = np.zeros(len(step.at)), self.start[1:]
        sizes = self.anywhere.layout.sizes[np.array(later) - len(self.model.of_design)]
        wrong[later] = max(self.discrepancy, DRIFT * math.sqrt(self.unseen)) * sizes
        return self._carried(step, step.walked.next_start(), wrong, 1 - step.sampling.first_leg, share)

    def _carried(self, step: Step, rows: np.ndarray, wrong: Vector, leg: int, share: float = 1.0) -> Estimate:
        """What a step shows of a later start on a `leg`, given as `rows` of it and its derivatives; errors (n,) that
        are not the step's come on top.

        From there on time is what the hip's clock shows then, and by how much clocks are apart by then is known too.
        """
        known, mean, grown, apart = step.known, step.at.copy(), np.eye(len(step.at)), np.eye(len(step.at))
        mean[self.start], grown[self.start] = rows[:, 0], rows[:, 1:]
        o, layout, since = len(self.model.of_design), self.anywhere.layout, float(rows[-1, 0])
        hip, foot, lag = (o + layout.place(name) for name in ("hip_clock", "foot_clock", "foot_lag"))
        apart[[self.start[-1], lag], hip], apart[lag, foot] = step.sampling.since - since, since - step.sampling.since
        mean, grown = apart @ mean, apart @ grown
        covariance = grown @ known.covariance @ grown.T + np.diag(wrong**2)
        return Estimate(mean + grown @ (share * (known.mean - step.at)), 0.5 * (covariance + covariance.T),
                      replace(step.sampling, first_leg=leg, since=since))


def drawn(estimate: Estimate) -> Iterator[Vector]:
    """Some unknowns (n,) as likely as they are known."""
    yield from np.random.default_rng(0).multivariate_normal(
        estimate.mean, estimate.covariance, DRAWN, "ignore", method="eigh")
