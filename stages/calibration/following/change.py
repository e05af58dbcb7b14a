"""What a run shows of whether it is one of the robot that was fitted, and of which part or sensor has changed.

Under the hypothesis that nothing has, a run's design is the robot's with the robot's covariance, its ramp and its
sensors are as they usually are, and its start is free. The fit of the run with all that as priors leaves residuals, on
which parts that have changed pull by their scores.
"""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np
from scipy.linalg import block_diag

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.least_squares import combinations
from stages.calibration.estimation.run_fit import (
    WHOLE,
    Model,
    RunFit,
    begun,
    design_sizes,
    fit_from,
    fit_run,
    run_equations,
)
from stages.calibration.following.robot_file import FittedRobot
from stages.calibration.following.score_test import Change, Part, Verdict, by_chance, shifts, verdict
from stages.calibration.information.identifiability import short
from stages.calibration.intervals.left_out import FRICTION, OTHER, with_all
from stages.calibration.observation.measured_run import MeasuredRun

#: What sensors that were moved or turned change of a run's unknowns.
MOVED = (Part("place of the foot sensor", "m", ("foot_place",)), Part("tilt of the hip sensor", "rad", ("hip_tilt",)),
         Part("tilt of the foot sensor", "rad", ("foot_tilt",)))
#: So many parts at most are fitted in turn.
MOST = 5


@dataclass(frozen=True)
class Evidence:
    """What `runs` runs show of the design's parameters (d,) and of changes (c,) from the robot's values: the normal
    equations, with the runs' own unknowns eliminated. `misfit` is the sum of squares of `count` readings."""

    matrix: np.ndarray
    right: Vector
    misfit: float
    count: int
    runs: int = 1

    def __add__(self, other: Evidence) -> Evidence:
        return Evidence(self.matrix + other.matrix, self.right + other.right, self.misfit + other.misfit,
                        self.count + other.count, self.runs + other.runs)  # fmt: skip


class Comparison:
    """A fitted robot, to which runs are held that a `model` of it reads."""

    def __init__(self, robot: FittedRobot, model: Model) -> None:
        self.robot, design = robot, robot.design  # noise is as wide as residuals were, and a spike what it was there
        self.model = replace(robot.model(model), robust=model.robust / robot.wider)
        sizes = design_sizes(design, robot.names)
        self._prior = np.linalg.inv(robot.covariance / np.outer(sizes, sizes)) / np.outer(sizes, sizes)
        self._values = np.array([design.value(name) for name in robot.names])
        self._known = combinations(robot.names, self._values, self._prior, sizes)
        alike = [name for name in OTHER if name.replace("other_", "") in robot.names
                 and getattr(design.biped, name.partition(".")[2]) is None]  # fmt: skip
        rubs = [FRICTION] * (design.value(FRICTION) == 0.0)
        self._more = (*alike, *rubs) if design.biped.legs == "compliant" else ()
        self._wide = replace(self.model, shared=(*robot.names, *self._more))
        self.parts = tuple(self._parts(design))
        self._fitted = [self._with(name) for name in robot.names]
        names = self._wide.names
        self._null = np.array([[float(name in self._with(one)) for one in robot.names] for name in names])
        self._moves = np.array([[float(name in part.moves) for part in self.parts] for name in names])

    def _with(self, name: str) -> tuple[str, ...]:
        """A parameter of the design, and the other leg's that goes with it where the robot's legs are alike."""
        other = name.replace("biped.", "biped.other_")
        return (name, other) if other in self._more else (name,)

    def _parts(self, design: DesignPoint) -> list[Part]:
        found = []
        names = (*self.robot.names, *self.robot.own)
        for name in names:
            other, key, unit = name.replace("biped.", "biped.other_"), name.partition(".")[2], design.unit(name)
            if name.replace("other_", "") != name and name.replace("other_", "") in names:
                continue
            if other != name and other in (*names, *self._more):
                found += [Part(f"{key} of {legs}", unit, moves, design.value(moves[0])) for legs, moves in (
                    ("both legs", (name, other)), ("the first leg", (name,)), ("the other leg", (other,)))]
            else:
                found.append(Part(key, unit, (name,), design.value(name)))
        found += [Part(short(FRICTION), design.unit(FRICTION), (FRICTION,))] * (FRICTION in self._more)
        return [*found, *MOVED]

    def held(self, run: MeasuredRun) -> Evidence:
        """What a run shows: as the robot's, or where it is not, with the part that explains most changed.

        Where the robot does not walk it, that is said where one that is free does. Raises StepFailed where none does.
        """
        run = self._read(run)
        fit = self._near(run)
        found = self._at_best(run, fit)
        if not self.verdict(found).explained:  # a fit that went astray is no other robot
            with contextlib.suppress(StepFailed):
                again = self._at_best(run, fit_run(self.robot.design, run, self.model, self._known))
                found = min(found, again, key=attrgetter("misfit"))
        return found

    def alike(self, run: MeasuredRun) -> Evidence:
        """What a run of this robot shows, whatever it shows. Raises StepFailed."""
        fit = self._near(self._read(run))
        return self.evidence(run, self.model.robot(self.robot.design, fit.design, fit.own), fit.unknowns)

    def _near(self, run: MeasuredRun) -> RunFit:
        """The fit of a run as the robot's, else as one of its kind. Raises StepFailed."""
        design, model = self.robot.design, self.model
        try:  # it need not come to rest, as scores count from anywhere
            return fit_from(design, begun(design, run, model).unknowns, run, model, self._known, WHOLE)
        except StepFailed:
            return fit_run(design, run, model, self.robot.known)

    def _read(self, run: MeasuredRun) -> MeasuredRun:
        """A run with what is known of its own parameters."""
        robot = self.robot
        own = {name: (robot.design.value(name), float(sd)) for name, sd in zip(robot.own, robot.own_sd, strict=True)}
        return replace(run, own={**own, **run.own})

    def _at_best(self, run: MeasuredRun, fit: RunFit) -> Evidence:
        """What a run shows about its fit as the robot's, or where that is another's, with one part fitted too.

        That is the part that explains most; scores are taken again there, until they name none or one that was fitted.
        """
        there, unknowns = self.model.robot(self.robot.design, fit.design, fit.own), fit.unknowns
        best, least, tried = self.evidence(run, there, unknowns), np.inf, set[str]()
        judged = self.verdict(best)
        while not judged.same and len(tried) < MOST and (part := judged.changes[0].part).name not in tried:
            tried.add(part.name)
            with contextlib.suppress(StepFailed):
                cost, at, others = self._changed(part, run, there, unknowns)
                found = self.evidence(run, at, others)
                judged = self.verdict(found)
                if cost < least:
                    least, best = cost, found
        return best

    def _changed(
        self, part: Part, run: MeasuredRun, there: DesignPoint, unknowns: Vector
    ) -> tuple[float, DesignPoint, Vector]:
        """The fit with a part that is not known any more: its cost, design, unknowns (k,). Raises StepFailed."""
        names, layout = (*self.robot.names, *self.robot.own), self.model.layout
        read = np.array([run.own[name] for name in self.robot.own]).reshape(-1, 2)
        middle = np.concatenate([self._values, read[:, 0]])
        prior = block_diag(self._prior, np.diag(read[:, 1] ** -2.0))
        tied, extra = names, tuple(name for name in part.moves if name in self._more)
        along = np.array([float(name in part.moves) for name in names])
        if not extra and len(both := self._with(part.moves[0])) == 2:  # the other leg is as the robot's was
            tied, extra = tuple(both[1] if name == both[0] else name for name in names), both[1:]
        elif along.any():
            free = prior @ along
            prior, extra = prior - np.outer(free, free) / (along @ free), ()
        known = combinations(tied, middle, prior, design_sizes(there, names))
        open_prior = np.where([name in part.moves for name in layout.names], np.inf, layout.prior)
        model = replace(self.model, shared=(*names, *extra), own=(), layout=replace(layout, prior=open_prior))
        fit = fit_from(with_all(there, extra), unknowns, run, model, known)
        at = model.robot(with_all(there, extra), fit.design)
        cost = fit.equations.cost + 0.5 * sum(((one.of(at) - one.value) / one.sd) ** 2 for one in known)
        return cost, at, fit.unknowns

    def evidence(self, run: MeasuredRun, at: DesignPoint, unknowns: Vector) -> Evidence:
        """What a run shows, linearised at a design and a run's unknowns (k,). Raises StepFailed.

        What the run has of its own is eliminated. Of that, a part moves the middle of what is known before.
        """
        run = self._read(run)
        robot, layout, shared = self.robot, self.model.layout, len(self._wide.shared)
        there = with_all(at, [name for name in self._more if not getattr(at.biped, name.partition(".")[2])])
        values, own = (np.array([there.value(name) for name in names]) for names in (self._wide.shared, robot.own))
        found = run_equations(there, own, unknowns, run, self._wide)
        read = np.array([run.own[name] for name in robot.own]).reshape(-1, 2)
        precision = np.concatenate([read[:, 1] ** -2.0, layout.prior_at(run.sampling) ** -2.0])
        pull = precision * np.concatenate([own - read[:, 0], unknowns - layout.middle])
        right = found.right + found.matrix[:, :shared] @ (values - self._null[:shared] @ self._values)
        kept = np.hstack([self._null, self._moves])
        moved, kept[shared:] = kept[shared:].copy(), 0.0
        across = found.matrix @ kept
        matrix = kept.T @ across + moved.T @ (moved * precision[:, None])
        left = across[shared:] - moved * precision[:, None]
        solved = found.others(np.column_stack([left, right[shared:]]))
        return Evidence(matrix - left.T @ solved[:, :-1], kept.T @ right + moved.T @ pull - left.T @ solved[:, -1],
                        found.chi2, found.count)

    def shifts(self, evidence: Evidence) -> np.ndarray:
        """By how much each part would have changed, and the standard error, (c, 2), before what is usual is taken off.
        """
        d = len(self.robot.names)
        solved = np.linalg.solve(evidence.matrix[:d, :d] + self._prior, np.column_stack(
            [evidence.matrix[:d, d:], evidence.right[:d]]))  # fmt: skip
        across = evidence.matrix[d:, :d]
        return shifts(evidence.right[d:] - across @ solved[:, -1], evidence.matrix[d:, d:] - across @ solved[:, :-1])

    def verdict(self, evidence: Evidence) -> Verdict:
        """Whether runs are this robot's."""
        changes, robot = [], self.robot
        more = 1.0 / evidence.runs + 1.0 / robot.compared
        for part, (shift, sd) in zip(self.parts, self.shifts(evidence), strict=True):
            mean, apart, freedom = robot.usual.get(part.name, (0.0, 0.0, math.inf))
            apart = abs(mean) if robot.compared == 1 else apart  # one run does not say how others are
            least = -np.nan_to_num(part.value) if part.moves == (FRICTION,) else -np.inf  # no hip rubs less than not
            change = float(max(shift - mean, least))
            between = more * apart**2
            known = part.moves in self._fitted or not robot.usual  # else chance is in what is usual
            variance = float(sd**2) * (1.0 if known else 1.0 + evidence.runs / robot.compared) + between
            # F. E. Satterthwaite, Biometrics Bull. 2, 1946, 110: what was seen to scatter has chance in it
            scatter = more * (apart**2 + evidence.runs * float(sd**2))
            freedom = freedom * (variance / scatter) ** 2 if between else math.inf
            changes.append(Change(part, change, math.sqrt(variance), (change / float(sd)) ** 2, freedom))
        size = math.sqrt(evidence.misfit / evidence.count) * robot.wider / robot.sigmas
        alike = max(robot.wider / robot.sigmas, 1.0) ** 2  # so many neighbours hang together
        by_count = math.sqrt(0.5 * alike / evidence.count * (1.0 + evidence.runs / robot.runs))
        between = robot.sigmas_sd / robot.sigmas * math.sqrt(1.0 / evidence.runs + 1.0 / robot.runs)
        freedom = robot.runs - 1 if robot.runs > 1 and between > by_count else math.inf
        return verdict(changes, size, by_chance((size - 1.0) / max(by_count, between), freedom))
