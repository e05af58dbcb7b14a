"""Which rung answers: the cheapest whose model and solver leave less than the error requested.

A rung is passed over before it is walked where what it misses is more than the error. What it finds is corrected by its
bias, and its solver's error checked; where that is too large, a tighter tolerance follows, then the next rung.

A block of a map's designs is answered from its numbers alone. The search of each begins at the gait of the nearest
design of the block that has one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import t as student

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.poincare import by_stability
from stages.analytic.maps.box import Box
from stages.analytic.model.walker import Vector
from stages.biped.processes import Progress, ignore
from stages.biped.question import Column
from stages.model_error.designs import kind, numbers
from stages.model_error.measures import IMPULSIVE, NAMES, UNITS, Allowed
from stages.model_error.miss import Learnt, Miss
from stages.model_error.parameters import Parameters
from stages.model_error.result import EVEN, MODELS, NUMBERS, PENALTY, SHARED, TWIN, WIDTH, Result, Stability
from stages.model_error.rungs import CONSTRAINT, RUNGS, Found, NoRung, TooLoose, design_of

if TYPE_CHECKING:
    from stages.analytic.derivatives.gait import GaitTangents

MULTIPLIER = NAMES.index("multiplier")
#: Names of the measures that the constraint model's derivatives have.
DERIVED = {"period": "period_s", "step_frequency": "period_s", "step_length": "step_length_m", "speed": "speed_m_s"}
#: So small a probability of the other decides.
DECIDED = 1e-3
CLOSER = 10.0
#: A multiplier is taken on so many slopes of those that may be, the design's in their middle.
SLOPES = 9
#: Draws of the values that may be.
DRAWS = 4000
NOTHING: Mapping[str, Vector] = MappingProxyType({})


@dataclass(frozen=True)
class Answered:
    """A measure with its errors, as a `share` of it or in its unit; NaN and `met` false where no rung has the error."""

    measure: str
    value: float
    share: bool
    requested: float
    met: bool
    solver: float
    model: float
    inputs: float
    ramp: float
    correction: float
    rung: str
    tolerance: float
    price_s: float
    passed_over: tuple[str, ...]
    closer: str


class Ladder:
    """The rungs of one design; each is walked once at a tolerance, for all measures."""

    def __init__(
        self, parameters: Parameters, learnt: Learnt, progress: Progress = ignore, near: Mapping[str, Vector] = NOTHING
    ) -> None:
        self.parameters, self.learnt, self.progress = parameters, learnt, progress
        self.design = replace(design_of(parameters), near=near)
        self.numbers = numbers(self.design)
        self.walked: dict[tuple[int, float], Found | NoRung] = {}
        self.slopes: dict[int, Vector] = {}

    def outside(self) -> list[str]:
        """The numbers in which the design lies outside of what was drawn."""
        beyond = self.learnt.outside(self.numbers)
        return [name for name, each in zip(NUMBERS, beyond, strict=True) if each > 1e-9]

    def unlike(self) -> str:
        """What the design is and the drawn ones were, if it is of another kind, so that no miss of it is known."""
        own = kind(self.design)
        return "" if own == self.learnt.kind else f"{own}; sampled were {self.learnt.kind}"

    def miss(self, rung: int, measure: int) -> Miss:
        """What a rung misses of the twin; infinite where nothing is known of designs of this kind."""
        if self.unlike() and rung != TWIN:
            return Miss(0.0, math.inf)
        return self.learnt.at(rung, measure, self.numbers)

    def find(self, rung: int, tolerance: float) -> Found:
        """What a rung finds. Raises NoRung."""
        key = rung, tolerance
        if key not in self.walked:
            self.progress(rung / len(RUNGS), f"{RUNGS[rung].name} at tolerance {tolerance:g}")
            try:
                self.walked[key] = RUNGS[rung].find(self.design, tolerance)
            except NoRung as reason:
                self.walked[key] = reason
        found = self.walked[key]
        if isinstance(found, NoRung):
            raise found
        return found

    def easiest(self, rung: int) -> Found:
        """What a rung finds at the loosest tolerance that does. Raises NoRung."""
        *looser, last = RUNGS[rung].tolerances
        for tolerance in looser:
            with suppress(TooLoose):
                return self.find(rung, tolerance)
        return self.find(rung, last)

    def corrected(self, rung: int, measure: int, tolerance: float) -> tuple[float, float, float]:
        """A measure with the rung's bias, its solver's error and its model's, as shares where errors are. Raises NoRung
        where the gait may not be stable, of which no rung below the penalty walker has learnt its miss. Inside of what
        was sampled all better models found it; outside it counts only with a multiplier that is below one for sure."""
        found = self.find(rung, tolerance)
        miss = self.miss(rung, measure)
        multiplier = self.miss(rung, MULTIPLIER)
        largest = float(found.values[MULTIPLIER]) + multiplier.bias
        if rung < PENALTY and largest >= 1.0:
            raise NoRung(f"the {RUNGS[rung].name} finds a gait that is not stable: its error there is not known")
        if rung < PENALTY and largest + multiplier.error >= 1.0 and self.outside():
            raise NoRung(f"the {RUNGS[rung].name} finds a gait of multiplier {largest:.2g} ± {multiplier.error:.2g}, "
                         "which outside of the sampled designs may not be there")
        value, solver = float(found.values[measure]), float(found.errors[measure])
        if not SHARED[measure]:
            return value + miss.bias, solver, miss.error
        return value * math.exp(miss.bias), solver / value, math.expm1(miss.error) if miss.error < 1.0 else math.inf

    def within(self, name: str, error: float, share: bool) -> Answered:
        """The cheapest answer within an error, a share of the measure or in its unit."""
        measure = NAMES.index(name)
        passed: list[str] = []
        for rung, tolerance, value, solver, model in self.climb(measure, error, share, passed):
            wanted = error if share or not SHARED[measure] else error / value
            if solver + model > wanted:
                passed.append(self.too_large(rung, measure, solver + model, f" at tolerance {tolerance:g}"))
                continue
            bias = self.miss(rung, measure).bias
            return Answered(name, value, bool(SHARED[measure]), wanted, True, solver, model,
                            self.inputs(name, rung), WIDTH * self.by_slope(rung, measure),
                            math.expm1(bias) if SHARED[measure] else bias,
                            RUNGS[rung].name, tolerance, RUNGS[rung].price, tuple(dict.fromkeys(passed)),
                            self.closer(measure, wanted))  # fmt: skip
        nothing = math.nan
        return Answered(name, nothing, share, error, False, nothing, nothing, nothing, nothing, nothing, "", nothing,
                        nothing, tuple(dict.fromkeys(passed)), "")  # fmt: skip

    def climb(
        self, measure: int, error: float, share: bool, passed: list[str]
    ) -> Iterator[tuple[int, float, float, float, float]]:
        """Rung, tolerance, corrected value, solver's and model's error, the cheapest first; why others are `passed`."""
        shares = share or not SHARED[measure]
        for rung, one in enumerate(RUNGS):
            floor = self.miss(rung, measure).error + (one.differences if measure == MULTIPLIER else 0.0)
            if not math.isfinite(floor) or (shares and floor >= error):
                passed.append(self.too_large(rung, measure, floor))
                continue
            for tolerance, value, solver, model in self.walks(rung, measure, passed):
                yield rung, tolerance, value, solver, model
                if shares and model >= error:
                    break  # the model's part is too large: no tolerance mends that

    def walks(self, rung: int, measure: int, passed: list[str]) -> Iterator[tuple[float, float, float, float]]:
        """Tolerances of a rung, the loosest first, with what is `corrected` there; why others are `passed`."""
        for tolerance in RUNGS[rung].tolerances:
            try:
                found = self.corrected(rung, measure, tolerance)
            except NoRung as reason:
                passed.append(str(reason))
                if not isinstance(reason, TooLoose):
                    break
            else:
                yield tolerance, *found

    def too_large(self, rung: int, measure: int, error: float, how: str = "") -> str:
        """Why a rung does not do."""
        if rung < PENALTY and NAMES[measure] in IMPULSIVE:
            return f"the {RUNGS[rung].name} has no {NAMES[measure]}: {IMPULSIVE[NAMES[measure]]}"
        if not math.isfinite(error):
            return f"the error of the {RUNGS[rung].name} is not known"
        printed = f"{100 * error:.2g} %" if SHARED[measure] else f"{error:.2g}"
        return f"the {RUNGS[rung].name} has an error of up to {printed}{how}"

    def closer(self, measure: int, wanted: float) -> str:
        """What an error ten times smaller would take."""
        for rung, one in enumerate(RUNGS):
            least = one.differences if measure == MULTIPLIER else 0.0
            if self.miss(rung, measure).error + least < wanted / CLOSER:
                return f"ten times closer would cost about {one.price:g} s, with the {one.name}"
        return "no model has an error ten times smaller"

    def stable(self) -> Stability:
        """The probability that the best rung's largest multiplier is below one. Raises NoRung."""
        passed, best = ["no model's error is known"], None
        for rung, one in enumerate(RUNGS):
            known = self.multiplier(rung, passed)
            if known is None:
                continue
            (value, solver, model), miss = known, self.miss(rung, MULTIPLIER)
            alone = decided(below_one(value, miss, solver))
            if rung < PENALTY and not alone:
                continue
            inputs, changes = self.inputs("multiplier", rung), self.multipliers_on_slopes(rung)
            values = np.where(np.isnan(self.multipliers_over_values), 0.0, self.multipliers_over_values)
            whole = below_one(value + np.add.outer(changes, values), miss, solver)
            found = Stability(whole, value, solver, model, inputs, one.name)
            near = rung == PENALTY and (alone or model < CLOSER * RUNGS[TWIN].differences)  # the twin leaves as much
            if rung == TWIN or decided(whole) or near:
                return found
            best = found if rung == PENALTY else None  # which stays, where the twin has none
        if best is None:
            raise NoRung(passed[-1])
        return best

    def multiplier(self, rung: int, passed: list[str]) -> tuple[float, float, float] | None:
        """A rung's largest multiplier, solver's and model's error, as close as that may decide more; why it is None is
        `passed`."""
        found, miss = None, self.miss(rung, MULTIPLIER)
        for _, value, solver, model in self.walks(rung, MULTIPLIER, passed) if math.isfinite(miss.error) else ():
            found = value, solver, model
            if solver <= model or decided(below_one(value, miss, solver)):
                break
        return found

    def inputs(self, name: str, rung: int) -> float:
        """What the digits of the parameters leave of a measure, as a share of it or by itself; NaN if not known.

        By the constraint model's exact derivatives, which lack what its impulses do. A slope's part is that of gaits
        there, as it is far from linear.
        """
        from stages.analytic.derivatives.uncertainty import SLOPE, together

        if not self.inexact:
            return 0.0
        if self.derivatives is None or name in IMPULSIVE:
            return math.nan
        measure = NAMES.index(name)
        if measure == MULTIPLIER:
            values = math.sqrt(float(np.mean(self.multipliers_over_values**2)))
        else:
            gait = self.derivatives.only([each for each in self.inexact if each != SLOPE])
            shares = np.array([self.spreads[each] for each in gait.changes.names]) / gait.changes.scales
            parts = dict(zip(gait.changes.names, gait.elasticities()[DERIVED[name]] * shares, strict=True))
            values = together(parts, self.parameters.correlations)
        return WIDTH * math.hypot(values, self.by_slope(rung, measure))

    @cached_property
    def spreads(self) -> dict[str, float]:
        """Standard deviations of all parameters but the slope, by file.key: what was fitted together is normal about
        its value, any other is anywhere between the edges of its last digit."""
        from stages.analytic.derivatives.uncertainty import SLOPE

        fitted = {name for pair in self.parameters.correlations for name in pair}
        return {name: width / WIDTH if name in fitted else EVEN * width
                for name, width in self.parameters.half_widths.items() if name != SLOPE}  # fmt: skip

    def by_slope(self, rung: int, measure: int) -> float:
        """What the slope's last digit leaves of a measure, as a root mean square: of multipliers on the slopes that may
        be, of others of a share that is anywhere within their largest there. NaN if not known.
        """
        if measure == MULTIPLIER:
            return math.sqrt(float(np.mean(self.multipliers_on_slopes(rung) ** 2)))
        return EVEN * self.off_on_slopes.get(DERIVED.get(NAMES[measure], ""), math.nan)

    @cached_property
    def off_on_slopes(self) -> dict[str, float]:
        """By how large a share measures of the constraint model's gait are off on slopes that may be, at most; near the
        slope of the quickest steps a derivative says nothing of them. NaN if the gait is lost on some."""
        from stages.analytic.derivatives.uncertainty import SLOPE, numbers_at, over_slopes

        if SLOPE not in self.inexact:
            return dict.fromkeys(DERIVED.values(), 0.0)
        if self.derivatives is None:
            return {}
        own = numbers_at(self.derivatives.walker, self.derivatives.point, 0)
        ends = over_slopes(self.design_point, self.derivatives, self.parameters.half_widths[SLOPE], 0)
        return {name: max(abs(end / own[name] - 1.0) for end in ends[name]) for name in DERIVED.values()}

    def multipliers_on_slopes(self, rung: int) -> Vector:
        """Changes (n,) of a rung's multiplier on slopes that may be, each as probable as the others, from that on its
        own; infinite where no gait is found. The twin's are those of the penalty walker, which walks the same machine.

        Beyond a doubling the legs' pairs, which differ a little, limp: the multiplier of a stable gait turns back.
        """
        from stages.analytic.derivatives.uncertainty import SLOPE

        rung, slope, found = min(rung, PENALTY), self.parameters.slope, list[float]()
        width = self.parameters.half_widths.get(SLOPE, 0.0)
        if rung not in self.slopes:
            for part in np.linspace(-1.0, 1.0, 2 * SLOPES + 1)[1::2] if width else ():
                there = replace(self.parameters, slope=replace(slope, slope_deg=slope.slope_deg + width * part))
                ladder = Ladder(there, self.learnt, near=self.design.searched)
                try:
                    found.append(float(ladder.easiest(rung).values[MULTIPLIER]))
                except NoRung:
                    found.append(math.inf)
            own = self.easiest(rung).values[MULTIPLIER] if found else 0.0
            self.slopes[rung] = np.array(found or [0.0]) - own
        return self.slopes[rung]

    @cached_property
    def inexact(self) -> list[str]:
        """The gait's parameters that are known to a last digit only."""
        from stages.analytic.derivatives.numbers import sensitive_names

        return [each for each in sensitive_names(self.design_point, self.parameters.half_widths)
                if self.parameters.half_widths.get(each)]

    @cached_property
    def multipliers_over_values(self) -> Vector:
        """Changes (n,) of the constraint model's multiplier by values that all but the slope may have, each as probable
        as the others; infinite where the gait is lost, NaN if not known.

        By gaits on the way of values on which it changes most: what is linear near the design is not near a fold.
        """
        from stages.analytic.derivatives.multipliers import multiplier_derivatives
        from stages.analytic.derivatives.uncertainty import SLOPE, towards

        names = [each for each in self.inexact if each != SLOPE]
        if not names or self.derivatives is None:
            return np.zeros(1)
        gait, correlations = self.derivatives.only(names), self.parameters.correlations
        names = list(gait.changes.names)
        spreads = np.array([self.spreads[name] for name in names])
        parts = multiplier_derivatives(gait).elasticities()[0] * spreads / gait.changes.scales
        together = np.array([[correlations.get((one, other), correlations.get((other, one), float(one == other)))
                              for other in names] for one in names])  # fmt: skip
        alone = np.array([not any(name in pair for pair in correlations) for name in names])
        size, fitted = (math.sqrt(max(each @ together @ each, 0.0)) for each in (parts, np.where(alone, 0.0, parts)))
        if not size > 0.0:
            return np.full(1, size)
        draws = np.random.default_rng(0)
        even = draws.uniform(-1.0 / EVEN, 1.0 / EVEN, (DRAWS, len(names))) @ np.where(alone, parts, 0.0)
        drawn = even + fitted * draws.standard_normal(DRAWS)
        drawn = (drawn - drawn.mean()) / drawn.std()
        changes = dict(zip(names, (together @ parts * spreads / size).tolist(), strict=True))
        seen = {0.0: by_stability(gait.point)}
        for edge in (drawn.min(), drawn.max()):
            seen |= {way * edge: by_stability(point) for way, _, point in towards(
                self.design_point, gait, {name: edge * change for name, change in changes.items()})}  # fmt: skip
        ways = sorted(seen)
        changed = np.array([seen[way] - seen[0.0] for way in ways])
        return np.asarray(np.interp(drawn, ways, changed, left=math.inf, right=math.inf))

    @cached_property
    def design_point(self) -> DesignPoint:
        """The design as the constraint model has it."""
        return DesignPoint(self.parameters.biped, self.parameters.slope, self.design.friction)

    @cached_property
    def derivatives(self) -> GaitTangents | None:
        """The constraint model's gait with its derivatives by all parameters; None without one."""
        from stages.analytic.derivatives.gait import gait_derivatives
        from stages.analytic.derivatives.numbers import sensitive_names

        names = sensitive_names(self.design_point, self.parameters.half_widths)
        try:
            return gait_derivatives(self.design_point, self.design.as_it_stands[1], names, CONSTRAINT)
        except (NoGait, StepFailed, np.linalg.LinAlgError):
            return None


def decided(probability: float) -> bool:
    """Whether so little is left open that a dearer rung would not change what is decided."""
    return min(probability, 1.0 - probability) < DECIDED


def below_one(values: Vector | float, miss: Miss, other: float) -> float:
    """The probability that a multiplier is below one of which a model says one of `values`, with what it misses and
    `other` errors; Student's t, as what it misses is estimated from some draws, with the freedom of the sum.
    """
    spread = max(math.hypot(miss.spread, other / WIDTH), 1e-12)
    freedom = miss.freedom * (spread / max(miss.spread, 1e-12)) ** 4
    return float(np.mean(student.sf((values - 1.0) / spread, freedom)))


#: What answered a design: a rung, none as no rung has the error, none as the values break a rule.
WAYS = (*MODELS, "no model", "not allowed")


def columns(allowed: Mapping[str, Allowed]) -> list[Column]:
    """The columns of a map of these measures: value, error of solver and model, and which model it is of."""
    found = []
    for name in allowed:
        unit = UNITS[name]
        found += [Column(name, unit, "less what the model misses of the twin; NaN where no model has the error"),
                  Column(f"{name}_error", unit, "what solver and model leave of it"),
                  Column(f"{name}_model", "-", "what it is of", WAYS)]  # fmt: skip
    return found


def learnt_of(plain: Sequence[Any]) -> Learnt:
    """What was learnt, from kind, numbers and values of the stage's result, as JSON gives them back."""
    kind, numbers, values = plain
    return Learnt(Result(0, kind, np.array(numbers), np.array(values), np.zeros_like(values), np.zeros(0), ()))


def block(
    parameters: Parameters, box: Box, base: DesignPoint, allowed: Mapping[str, Allowed], learnt: Learnt, first: int,
    end: int
) -> list[list[float]]:  # fmt: skip
    """The rows of `columns` of the designs `first` to before `end` of the box."""
    shares = box.shares(first, end)
    rows, known = [], list[tuple[np.ndarray, dict[str, Vector]]]()
    for share, values in zip(shares, box.at(shares), strict=True):
        design = box.design(base, values)
        if not design.is_legal():
            rows.append([np.nan, np.nan, float(WAYS.index("not allowed"))] * len(allowed))
            continue
        near = min(known, key=lambda one: float(np.abs(one[0] - share).max()), default=(share, {}))[1]
        ladder = Ladder(parameters.with_exact(design.biped, design.slope), learnt, near=near)
        rows.append([number for name, one in allowed.items()
                     for number in numbers_of(ladder.within(name, one.error, one.share))])  # fmt: skip
        known.append((share, ladder.design.searched))
    return rows


def numbers_of(answer: Answered) -> list[float]:
    """Value, error in its unit, and place of its model among `WAYS`."""
    if not answer.met:
        return [np.nan, np.nan, float(WAYS.index("no model"))]
    error = (answer.solver + answer.model) * (answer.value if answer.share else 1.0)
    return [answer.value, error, float(WAYS.index(answer.rung))]
