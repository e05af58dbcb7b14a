"""Whether a run is one of the robot that was fitted, and which part of the robot or of its sensors has changed.

Under the hypothesis that nothing has, a run's design is the robot's with the robot's covariance, its ramp and its
sensors are as they usually are, and its start is free. The fit of the run with all that as priors leaves residuals. A
part that has changed pulls on them by its score (C. R. Rao, Proc. Camb. Phil. Soc. 44, 1948, 50), whose variance is the
run's information of the part with everything else eliminated. Score over variance is the change, with its error.
"""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np
from scipy.linalg import block_diag
from scipy.special import ndtr, stdtr

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
from stages.calibration.intervals.left_out import FRICTION, OTHER, with_all
from stages.calibration.observation.measured_run import MeasuredRun

#: Of runs of the same robot so many are said to be another's; of these, the share that all parts and the size of the
#: residuals have (Bonferroni).
LEVEL = 0.01
PARTS, RESIDUALS = 0.9, 0.1
#: Two parts cannot be told apart where what they explain differs by no more than this in chi-square.
ALIKE = 2.0
#: Sensors that were moved or turned, as unknowns of a run.
MOVED = {"foot_place": "place of the foot sensor", "hip_tilt": "tilt of the hip sensor",
         "foot_tilt": "tilt of the foot sensor"}  # fmt: skip
UNITS = {"foot_place": "m", "hip_tilt": "rad", "foot_tilt": "rad"}
#: So many parts at most are fitted in turn.
MOST = 5


@dataclass(frozen=True)
class Part:
    """What may change: its name, and the unknowns that go with a change of it by one `unit`."""

    name: str
    unit: str
    moves: tuple[str, ...]


@dataclass(frozen=True)
class Change:
    """How much a part would have changed, with its standard error, and what it `explains` of the run in chi-square."""

    part: Part
    change: float
    sd: float
    explains: float

    @property
    def sigmas(self) -> float:
        """Size of the change in its standard errors."""
        return abs(self.change) / self.sd


@dataclass(frozen=True)
class Evidence:
    """What `runs` runs tell of the design's parameters (d,) and of changes (c,) from the robot's values: the normal
    equations, with the runs' own unknowns eliminated. `misfit` is the sum of squares of `count` readings."""

    matrix: np.ndarray
    right: Vector
    misfit: float
    count: int
    runs: int = 1

    def __add__(self, other: Evidence) -> Evidence:
        return Evidence(self.matrix + other.matrix, self.right + other.right, self.misfit + other.misfit,
                        self.count + other.count, self.runs + other.runs)  # fmt: skip


@dataclass(frozen=True)
class Verdict:
    """The probability that the same robot looks so different, by all tests together; changes of the parts, the most
    telling first; the residuals over those of the robot; whether they are as that robot's where the first part has
    changed."""

    probability: float
    changes: tuple[Change, ...]
    residuals: float
    explained: bool

    @property
    def same(self) -> bool:
        """Whether nothing says that it is another robot."""
        return self.probability >= LEVEL

    @property
    def named(self) -> tuple[Change, ...]:
        """The part that explains most, and those that cannot be told apart from it."""
        return tuple(one for one in self.changes if one.explains > self.changes[0].explains - ALIKE)


@dataclass(frozen=True)
class Held:
    """A run's evidence, fitted as the robot's, and `at_best`, with the part that explains most fitted too."""

    evidence: Evidence
    at_best: Evidence

    def __add__(self, other: Held) -> Held:
        return Held(self.evidence + other.evidence, self.at_best + other.at_best)


def _has(design: DesignPoint, name: str) -> bool:
    """Whether a design gives a number that is none of Table 1's."""
    return bool(getattr(design.biped, name.partition(".")[2]))


class Comparison:
    """A fitted robot, to which runs are held that a `model` of it reads."""

    def __init__(self, robot: FittedRobot, model: Model) -> None:
        self.robot, self.model, design = robot, robot.model(model), robot.design  # noise is as wide as residuals were
        sizes = design_sizes(design, robot.names)
        self._prior = np.linalg.inv(robot.covariance / np.outer(sizes, sizes)) / np.outer(sizes, sizes)
        self._values = np.array([design.value(name) for name in robot.names])
        self._known = combinations(robot.names, self._values, self._prior, sizes)
        compliant = design.biped.legs == "compliant"
        alike = [name for name in OTHER if name.replace("other_", "") in robot.names and compliant
                 and getattr(design.biped, name.partition(".")[2]) is None]  # fmt: skip
        rubs = [FRICTION] if compliant and design.value(FRICTION) == 0.0 else []
        self._more = (*alike, *rubs)
        self._wide = replace(self.model, shared=(*robot.names, *self._more))
        self.parts = tuple(self._parts(design))
        names = self._wide.names
        self._null = np.array([[float(name in self._with(own)) for own in self.model.names] for name in names])
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
                found += [Part(f"{key} of {legs}", unit, moves) for legs, moves in (
                    ("both legs", (name, other)), ("the first leg", (name,)), ("the other leg", (other,)))]
            else:
                found.append(Part(key, unit, (name,)))
        found += [Part(FRICTION.partition(".")[2], design.unit(FRICTION), (FRICTION,))] * (FRICTION in self._more)
        return found + [Part(words, UNITS[name], (name,)) for name, words in MOVED.items()]

    def held(self, run: MeasuredRun) -> Held:
        """A run held against the robot: as the robot's, and as one of which a part has changed where it is not.

        The scores are told again where that part is fitted too, until it is the one that explains most. Where the
        robot does not walk the run, they are told where one that is free does. Raises StepFailed where none does.
        """
        design, model = self.robot.design, self.model
        try:
            evidence, there, unknowns, run = self.as_this(run, begun(design, run, model))
        except StepFailed:
            evidence, there, unknowns, run = self._there(run, fit_run(design, run, model, self.robot.known))
        if not self.verdict(evidence).same:  # a fit that went astray is no other robot
            with contextlib.suppress(StepFailed):
                again = self._there(run, fit_run(design, run, model, self._known))
                if again[0].misfit < evidence.misfit:
                    evidence, there, unknowns, run = again
        verdict, at_best, tried, least = self.verdict(evidence), evidence, set[str](), np.inf
        while not verdict.same and len(tried) < MOST and verdict.changes[0].part.name not in tried:
            part = verdict.changes[0].part
            tried.add(part.name)
            with contextlib.suppress(StepFailed):
                cost, at, others = self._changed(part, run, there, unknowns)
                found = self._evidence(run, at, others)
                verdict = self.verdict(found)
                if cost < least:
                    least, at_best = cost, found
        return Held(evidence, at_best)

    def as_this(self, run: MeasuredRun, begin: Vector) -> tuple[Evidence, DesignPoint, Vector, MeasuredRun]:
        """What a run tells as this robot's, from unknowns near it (k,), the design and the unknowns then, and the run
        with what is known of its own parameters. It need not come to rest, as scores count from anywhere.

        Raises StepFailed.
        """
        design, run = self.robot.design, self._read(run)
        try:
            return self._there(run, fit_from(design, begin, run, self.model, self._known, WHOLE))
        except StepFailed:
            return self._there(run, fit_run(design, run, self.model, self._known))

    def _read(self, run: MeasuredRun) -> MeasuredRun:
        """A run with what is known of its own parameters."""
        robot = self.robot
        own = {name: (robot.design.value(name), float(sd)) for name, sd in zip(robot.own, robot.own_sd, strict=True)}
        return replace(run, own={**own, **run.own})

    def _there(self, run: MeasuredRun, fit: RunFit) -> tuple[Evidence, DesignPoint, Vector, MeasuredRun]:
        """What a run tells about where a fit of it ended. Raises StepFailed."""
        run, there = self._read(run), self.model.robot(self.robot.design, fit.design, fit.own)
        return self._evidence(run, there, fit.unknowns), there, fit.unknowns, run

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

    def _evidence(self, run: MeasuredRun, at: DesignPoint, unknowns: Vector) -> Evidence:
        """What a run tells, linearised at a design and a run's unknowns (k,). Raises StepFailed."""
        robot, layout, wide = self.robot, self.model.layout, self._wide
        there = with_all(at, [name for name in self._more if not _has(at, name)])
        values, own = (np.array([there.value(name) for name in names]) for names in (wide.shared, robot.own))
        found = run_equations(there, own, unknowns, run, wide)
        read = np.array([run.own[name] for name in robot.own]).reshape(-1, 2)
        precision = np.concatenate([read[:, 1] ** -2.0, layout.prior**-2.0])
        off = np.concatenate([own - read[:, 0], unknowns - layout.middle])
        d, last = len(robot.names), range(len(values), len(found.right))
        data, right = found.matrix.copy(), found.right.copy()
        data[last, last] -= precision
        right[last] += precision * off
        right += data[:, : len(values)] @ (values - self._null[: len(values), :d] @ self._values)
        kept, gone = np.hstack([self._null[:, :d], self._moves]), self._null[:, d:]
        mine = gone.T @ data @ gone + np.diag(precision)
        unit = 1.0 / np.sqrt(np.diag(mine))
        across = kept.T @ data @ gone * unit
        solved = np.linalg.lstsq(mine * unit * unit[:, None], np.column_stack(
            [across.T, (gone.T @ right - precision * off) * unit]), rcond=1e-14)[0]
        matrix = kept.T @ data @ kept - across @ solved[:, :-1]
        return Evidence(0.5 * (matrix + matrix.T), kept.T @ right - across @ solved[:, -1], found.chi2, found.count)

    def shifts(self, evidence: Evidence) -> np.ndarray:
        """By how much each part would have changed, and the standard error, (c, 2), before what is usual is taken off.
        """
        d = len(self.robot.names)
        solved = np.linalg.solve(evidence.matrix[:d, :d] + self._prior, np.column_stack(
            [evidence.matrix[:d, d:], evidence.right[:d]]))  # fmt: skip
        across = evidence.matrix[d:, :d]
        information = evidence.matrix[d:, d:] - across @ solved[:, :-1]
        score = evidence.right[d:] - across @ solved[:, -1]
        return np.column_stack([score / np.diag(information), np.diag(information) ** -0.5])

    def verdict(self, evidence: Evidence) -> Verdict:
        """Whether runs are this robot's."""
        changes = []
        for part, (shift, sd) in zip(self.parts, self.shifts(evidence), strict=True):
            mean, apart = self.robot.usual.get(part.name, (0.0, 0.0))
            apart = abs(mean) if self.robot.runs == 1 else apart  # one run does not say how others are
            if part.moves != (FRICTION,) or shift > mean:
                more = apart * math.sqrt(1.0 / evidence.runs + 1.0 / self.robot.runs)
                changes.append(Change(part, float(shift - mean), math.hypot(sd, more), float((shift - mean) / sd) ** 2))
        changes.sort(key=attrgetter("explains"), reverse=True)
        residuals, of_residuals = self._residuals(evidence)
        most = max(one.sigmas for one in changes)
        every = 2.0 * len(self.parts) * float(ndtr(-most)) / PARTS, of_residuals / RESIDUALS
        return Verdict(min(1.0, *every), tuple(changes), residuals, of_residuals >= LEVEL)

    def verdict_of(self, held: Held) -> Verdict:
        """Whether runs are this robot's, and where they are not what has changed, with the part that explains most
        fitted."""
        first = self.verdict(held.evidence)
        if first.same:
            return first
        return replace(self.verdict(held.at_best), probability=first.probability, residuals=first.residuals)

    def _residuals(self, evidence: Evidence) -> tuple[float, float]:
        """Residuals of runs over the robot's own, and the probability that such are so large: by the readings' number,
        of which neighbours hang together, and by how those of the robot's runs differ."""
        robot = self.robot
        size = math.sqrt(evidence.misfit / evidence.count) * robot.wider / robot.sigmas
        alike = max(robot.wider / robot.sigmas, 1.0) ** 2
        by_count = math.sqrt(0.5 * alike / evidence.count * (1.0 + evidence.runs / robot.runs))
        between = robot.sigmas_sd / robot.sigmas * math.sqrt(1.0 / evidence.runs + 1.0 / robot.runs)
        freedom = robot.runs - 1 if robot.runs > 1 and between > by_count else 1e6
        return size, float(stdtr(freedom, (1.0 - size) / max(by_count, between)))
