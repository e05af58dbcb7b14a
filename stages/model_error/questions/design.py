"""`design`: change design parameters until the gait is most stable, fastest, or needs the least friction."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

from stages.biped.quantity import Bound
from stages.biped.question import Answer, Asking, Question, WrongOption, interval, option, refuse
from stages.model_error.measures import Allowed, errors, learnt_by
from stages.model_error.questions.ask import as_json, in_words as as_words

if TYPE_CHECKING:
    from stages.analytic.design.goals import Goal
    from stages.analytic.design.search import Candidate, DesignSearch, Targets
    from stages.analytic.gait.design_point import DesignPoint
    from stages.analytic.gait.poincare import FixedPoint
    from stages.analytic.result import Validity
    from stages.model_error.choice import Answered
    from stages.model_error.parameters import Parameters
    from stages.model_error.result import Result

VARIED = ("biped.foot_radius", "biped.foot_com", "biped.stiffness", "biped.damping")
MEASURES = ("step_frequency_hz", "step_length_m", "speed_m_s")
GROUND = ("friction_single_stance", "impulse_friction_landing", "friction_there_is", "time_outside_cone",
          "impulse_outside_cone", "deepest_scuff")
Bounds = Mapping[str, tuple[float, float]]
#: Searches with targets moved by what the constraint model misses of the twin, at most.
AIMS = 4
#: A measure is at a limit of its target that differs from it by no more than this share.
LIMIT = 1e-3
#: Goals on blocks of drawn heights.
ON_BLOCKS = ("sensitivity_norm", STEPS := "steps_to_fall")


@dataclass(frozen=True)
class Options:
    """Options of `design`."""

    vary: tuple[str, ...] = option("-", "Parameter to vary; repeatable", default=(), metavar="FILE.KEY[=LOW:HIGH]")
    target: tuple[str, ...] = option(
        "-", "Measure to hold, as speed=0.33, or within limits, as scuff=0:0.004; repeatable", default=(),
        metavar="MEASURE=VALUE[:HIGH]")
    goal: str = option(
        "-", "What is to be least: largest multiplier, speed, friction needed in single stance, "
        "deepest scuff, or gait sensitivity norm; or to be most: steps to a fall on blocks of ground.block_height_rms",
        default="multiplier", choices=("multiplier", "speed", "friction", "scuff", *ON_BLOCKS))
    maximise: bool = option("-", "Search for the largest value of the goal", default=False)
    starts: int = option(
        "1", "Starts: the design, and others spread within the bounds", default=1, bound=Bound(minimum=1, maximum=1000))
    share: float = option(
        "1", "Share by which a parameter without bounds may change", name="range", default=0.2,
        bound=Bound(above=0, maximum=0.9))
    iterations: int = option("1", "Most steps of the search", default=60, bound=Bound(minimum=1, maximum=1000))
    within: tuple[str, ...] = option(
        "-", "Measure and its error, as speed=1%: its target and value are then the twin's", default=(),
        metavar="MEASURE=ERROR")


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Search from the design. Raises NoGait, WrongOption, BlocksDoNotFit."""
    from stages.analytic.derivatives.numbers import sensitive_names
    from stages.analytic.derivatives.on_blocks import refusal
    from stages.analytic.design.goals import GOALS
    from stages.analytic.design.search import TARGETS, search_design
    from stages.analytic.gait.design_point import DesignPoint
    from stages.analytic.gait.gait_report import report_gait
    from stages.analytic.gait.gait_search import find_gait
    from stages.analytic.gait.poincare import by_stability
    from stages.stability.blocks.borne import Borne

    friction, tolerance = parameters.analytic.limited(parameters.friction), parameters.analytic.tolerance
    allowed = errors(options.within)
    refuse(("" in allowed, "--within: a design names the measure of each error, as speed=1%"))
    result = learnt_by(asking) if allowed else None
    design = DesignPoint(parameters.biped, parameters.slope, friction)
    known = sensitive_names(design, [text.partition("=")[0] for text in options.vary])
    vary = options.vary or tuple(name for name in VARIED if name in known)
    bounds = dict(bounds_of(design, text, options.share, known) for text in vary)
    held = dict(target_of(text, TARGETS) for text in options.target)
    refuse(*senseless(parameters, options, refusal(design.walker()), held))
    _, point = find_gait(parameters.biped, parameters.slope, tolerance, friction)
    refuse((options.goal in ON_BLOCKS and by_stability(point) >= 1.0,
            f"--goal {options.goal}: the gait is unstable, and on even ground too a walk leaves it"))
    goal = GOALS.get(options.goal) or Borne(parameters.blocks).goal
    before = lasts(parameters, design, point) if options.goal == STEPS else {}

    def search(targets: Targets) -> Sequence[DesignSearch]:
        return search_design(
            design, point.z, bounds, targets=targets, tolerance=tolerance, iterations=options.iterations, goal=goal,
            maximise=options.maximise or options.goal == STEPS, starts=options.starts,
            progress=lambda step, value: asking.note(f"iteration {step + 1}: {goal.title} {value:.6g}{_shown(goal)}"))

    def answer(found: DesignPoint) -> list[Answered]:
        return measured(parameters, result, found, allowed, asking)

    searches, aims, answers = aimed(search, answer, held, allowed)
    missed = misses(answers, held, allowed)

    def draw(save: Any) -> None:
        from stages.analytic.pictures import gaits
        from stages.drawing import style

        with style.drawing():
            save(gaits.draw_searches(searches, bounds, goal))

    found = searches[0].best
    static = parameters.friction.coefficients.static_friction
    ground = report_gait(found.walker, found.point, tolerance, static).validity
    lasting = {STEPS: {"block_height_rms_m": parameters.blocks.block_height_rms, "start": before,
                       "best": lasts(parameters, found.design, found.point)}} if before else {}  # fmt: skip
    lines = [*in_words(searches, bounds, aims, goal, options.starts, held), *longer(lasting), ground_needed(ground),
             *(line for one in answers for line in as_words(one)),
             *(f"Not met: {name} misses its target by {abs(miss):.3g}" for name, miss in missed.items())]
    plain = {**as_plain(searches, bounds, aims, goal), "ground": {name: getattr(ground, name) for name in GROUND},
             "targets": plain_targets(held), **lasting, "within": {one.measure: as_json(one) for one in answers}}
    rows = [{"parameter": name, **entry} for name, entry in plain["parameters"].items()]
    values = {name: {"value": found.design.value(name), "unit": found.design.unit(name)} for name in bounds}
    return Answer(lines, plain, rows=rows, draw=draw, parameters=values,
                  no=not searches[0].met or bool(missed) or not all(one.met for one in answers))  # fmt: skip


def senseless(
    parameters: Parameters, options: Options, on_blocks: str, held: Targets
) -> Iterator[tuple[bool, str]]:
    """Whether there is nothing to search for, with a sentence each; `on_blocks` is why the design has no answer there.
    """
    from stages.stability.questions.rough import EVEN

    yield options.goal in ON_BLOCKS and bool(on_blocks), f"--goal {options.goal}: {on_blocks}"
    yield options.goal == STEPS and parameters.blocks.block_height_rms == 0.0, f"--goal {STEPS}: {EVEN}"
    yield options.goal == STEPS and options.maximise, f"--goal {STEPS} is made most without --maximise"
    yield (parameters.biped.feet_retract and "scuff" in (options.goal, *held),
           "scuff: biped.feet_retract is true, and feet that retract touch nothing in swing")  # fmt: skip


@dataclass(frozen=True)
class Here:
    """Answers in this process for a design that is not the study's own."""

    parameters: Any

    def each(self, function: Callable[..., Any], arguments: Sequence[Any], *shared: Any) -> Iterator[Any]:
        """As `Asking.each`; nothing is kept."""
        return (function(self.parameters, *shared, argument) for argument in arguments)

    def progress(self, fraction: float, what: str) -> None:
        """Nothing is shown."""


def lasts(parameters: Parameters, design: DesignPoint, point: FixedPoint) -> dict[str, Any]:
    """Steps to a fall of a design with its gait, as JSON. Raises BlocksDoNotFit."""
    from stages.stability.questions import rough

    there: Any = replace(parameters, biped=design.biped, slope=design.slope)
    asking: Any = Here(there)
    return asdict(rough.passage(there, rough.Options(), asking, point.z.tolist())[0])


def longer(lasting: Mapping[str, Any]) -> Iterator[str]:
    """Steps to a fall in words."""
    for of in lasting.values():
        start, best = (f"{one['steps_to_fall']:.4g} ({one['steps_low']:.4g} to {one['steps_high']:.4g})"
                       for one in (of["start"], of["best"]))
        yield (f"mean steps to a fall on blocks of {1e3 * of['block_height_rms_m']:g} mm, with 95 % intervals: "
               f"{start} -> {best}")


def aimed(
    search: Callable[[Targets], Sequence[DesignSearch]], answer: Callable[[DesignPoint], list[Answered]],
    held: Targets, allowed: Mapping[str, Allowed]
) -> tuple[Sequence[DesignSearch], Targets, list[Answered]]:  # fmt: skip
    """The searches, with targets moved until the best design has those that are `held` as the twin has them; these
    targets; and its measures.
    """
    from stages.analytic.design.search import TARGETS

    aims = held
    for searched in itertools.count(1):
        searches = search(aims)
        answers = answer(searches[0].best.design)
        missed = misses(answers, held, allowed)
        if not (missed and searches[0].met) or searched == AIMS:
            break
        aims = {**aims, **{TARGETS[name]: (low - miss, high - miss) for name, miss in missed.items()
                           for low, high in [aims[TARGETS[name]]]}}  # fmt: skip
    return searches, aims, answers


def misses(answers: Sequence[Answered], held: Targets, allowed: Mapping[str, Allowed]) -> dict[str, float]:
    """By how much measures miss their targets, of those that miss them by more than their error."""
    from stages.analytic.design.search import TARGETS

    limits = {one.measure: held[TARGETS[one.measure]] for one in answers if TARGETS.get(one.measure) in held}
    of_targets = {one.measure: min(max(one.value, low), high) for one in answers if one.measure in limits
                  for low, high in [limits[one.measure]]}  # fmt: skip
    missed = {one.measure: one.value - of_targets[one.measure] for one in answers if one.measure in of_targets}
    return {name: miss for name, miss in missed.items()
            if abs(miss) > allowed[name].error * (of_targets[name] if allowed[name].share else 1.0)}  # fmt: skip


def measured(
    parameters: Parameters, result: Result | None, found: DesignPoint, allowed: Mapping[str, Allowed], asking: Asking
) -> list[Answered]:
    """Measures of a design that was found, within their errors, as `ask` answers them."""
    if result is None:
        return []
    from stages.model_error.choice import Ladder
    from stages.model_error.miss import Learnt

    ladder = Ladder(parameters.with_exact(found.biped, found.slope), Learnt(result), asking.progress)
    return [ladder.within(name, one.error, one.share) for name, one in allowed.items()]


def bounds_of(design: DesignPoint, text: str, share: float, known: Collection[str]) -> tuple[str, tuple[float, float]]:
    """Name and bounds from "FILE.KEY" or "FILE.KEY=LOW:HIGH". Raises WrongOption."""
    name, given, limits = text.partition("=")
    try:
        value, allowed = design.value(name), design.bound(name)
    except KeyError as error:
        raise WrongOption(error.args[0]) from None
    refuse((name not in known, f"--vary {name}: this gait has no such number; it has {', '.join(known)}"))
    low, high = interval(limits, f"--vary {name}") if given else sorted(((1 - share) * value, (1 + share) * value))
    refuse(*((not allowed.holds(limit), f"--vary {name}: {limit:g} is not allowed; allowed is {allowed}")
             for limit in (low, high)),
           (not low < high, f"--vary {name}: its value is 0, so its range needs bounds, as {name}=0:0.001"))
    return name, (low, high)


def target_of(text: str, known: Mapping[str, str]) -> tuple[str, tuple[float, float]]:
    """Measure and its limits, alike for a value, from "MEASURE=VALUE" or "MEASURE=LOW:HIGH"; a measure by its word or
    by its field, as speed or speed_m_s.

    Raises WrongOption with the known measures.
    """
    word, _, limits = text.partition("=")
    name, (first, between, last) = known.get(word, word), limits.partition(":")
    try:
        low, high = float(first), float(last if between else first)
    except ValueError:
        low, high = 0.0, 0.0
    if name not in known.values() or not (0 < low <= high < float("inf") or 0 == low < high < float("inf")):
        raise WrongOption(f"--target {text!r} is not MEASURE=VALUE with a positive value, or MEASURE=LOW:HIGH with "
                          f"0 <= LOW < HIGH; measures are {', '.join(known)}")
    return name, (low, high)


def plain_targets(held: Targets) -> dict[str, Any]:
    """Targets as JSON: a value, or both limits."""
    return {name: low if low == high else [low, high] for name, (low, high) in held.items()}


def as_plain(
    searches: Sequence[DesignSearch], bounds: Bounds, held: Targets, goal: Goal
) -> dict[str, Any]:
    """The searches as JSON; the best comes first, and starts are the design's own."""
    found, own = searches[0], own_start(searches)
    start, best = own.design, found.best.design
    return {
        "goal": {"title": goal.title, "unit": goal.unit, "start": own.value, "best": found.best.value},
        "largest_multiplier": {"start": own.largest_multiplier, "best": found.best.largest_multiplier},
        "parameters": {
            name: {"start": start.value(name), "best": best.value(name), "bounds": list(limits),
                   "at_bound": found.bounds.get(name)}
            for name, limits in bounds.items()
        },
        "measures": {name: getattr(found.best.gait, name) for name in MEASURES},
        "targets": plain_targets(held),
        "met": found.met,
        "iterations": sum(len(search.history) - 1 for search in searches),
        "converged": found.converged,
        "ending": found.ending,
        "left_to_gain": found.gain,
        "path": {"goal": list(found.history), "parameters": found.path.tolist()},
        "starts": [{"start": search.start.value, "best": search.best.value, "ending": search.ending, "met": search.met,
                    "gaits": search.gaits, "gradients": search.gradients} for search in searches],
    }


def own_start(searches: Sequence[DesignSearch]) -> Candidate:
    """The study's own design, with its gait, whichever start led to the best."""
    return next(search.start for search in searches if search.own)


def _shown(goal: Goal) -> str:
    return "" if goal.unit == "1" else f" {goal.unit}"


def in_words(
    searches: Sequence[DesignSearch], bounds: Bounds, held: Targets, goal: Goal, starts: int, twins: Targets
) -> Iterator[str]:
    """The searches in words, of targets that are `held` so that the twin has its own."""
    from stages.analytic.design.search import ENDINGS, HELD

    found, own, unit = searches[0], own_start(searches), _shown(goal)
    origin = "" if found.own else f" from another start, which has {found.start.value:.6g}"
    yield (f"{goal.title} {own.value:.6g} -> {found.best.value:.6g}{unit} in {len(found.history) - 1} steps{origin} "
           f"({found.gaits} gaits, {found.gradients} gradients)")
    for name, (low, high) in bounds.items():
        at = f" (at its {found.bounds[name]} bound)" if name in found.bounds else f" (from {low:g} to {high:g})"
        yield f"  {name:<22} {own.design.value(name):>12.6g} -> {found.best.design.value(name):<12.6g}{at}"
    for name, value, (low, high) in zip(held, found.best.held, held.values(), strict=True):
        at = next((f", at its {side} limit" for side, limit in (("lower", low), ("upper", high))
                   if low < high and abs(value - limit) <= LIMIT * limit), "")  # fmt: skip
        moved = "" if twins[name] == (low, high) else f", as the twin's is {between(twins[name])}"
        yield f"  {name:<22} {value:>12.6g} (target {between((low, high))}{moved}{at})"
    if not found.met:
        limits = [low if value < low else high for value, (low, high) in zip(found.best.held, held.values())]
        missed = [f"{name} by {100 * abs(value / limit - 1):.3g} %" for name, value, limit, miss
                  in zip(held, found.best.held, limits, found.best.misses, strict=True) if abs(miss) > HELD]
        yield f"Not met: no gait was found that holds the targets; the nearest misses {', '.join(missed)}."
    optimum = found.ending not in ("fold", "edge", "unfinished")
    ending = f"It ends {ENDINGS[found.ending] if found.met or not optimum else 'as near to the targets as it comes'}"
    if found.bounds:
        ending += "; at a bound: " + ", ".join(f"{name} ({side})" for name, side in found.bounds.items())
    left = f" Left to gain for a share of the parameters: {found.gain:.1g} of the start's value."
    yield f"{ending}.{'' if found.ending in ('walked', 'coalescence') else left}"  # there derivatives do not say it
    if not found.best.gait.stable:
        yield f"The gait is unstable: its largest multiplier is {found.best.largest_multiplier:.6g}."
    yield from elsewhere(searches, starts)


def between(limits: tuple[float, float]) -> str:
    """A target in words: a value, or both limits."""
    return f"{limits[0]:g}" if limits[0] == limits[1] else f"{limits[0]:g} to {limits[1]:g}"


def elsewhere(searches: Sequence[DesignSearch], starts: int) -> Iterator[str]:
    """Where the searches from several starts ended, in words."""
    from stages.analytic.design.search import SAME

    best, met = searches[0].best.value, searches[0].met
    same = sum(abs(search.best.value - best) <= SAME * best and search.met == met for search in searches)
    others = ", ".join(f"{search.best.value:.6g} ({search.ending if search.met else 'target missed'})"
                       for search in searches[same:])  # fmt: skip
    if starts > 1:
        yield (f"Of {starts} starts {starts - len(searches)} have no gait to follow; {same} end at this value"
               + (f", others worse: {others}" if others else ""))


def ground_needed(validity: Validity) -> str:
    """What a gait needs of the ground beside friction in single stance, in words."""
    from stages.analytic.result import of_friction

    time, impulse = 100 * validity.time_outside_cone, 100 * validity.impulse_outside_cone
    return (f"It needs friction {of_friction(validity.friction_single_stance)} in single stance and "
           f"{of_friction(validity.impulse_friction_landing)} for the impulse on the landing foot. In double stance "
           f"the trailing foot is outside of the cone of friction {validity.friction_there_is:g} for {time:.3g} % of "
           f"time and {impulse:.3g} % of its tangential impulse. Deepest scuff: {1e3 * validity.deepest_scuff:.3g} mm.")


QUESTION = Question(
    "design",
    """Minimise (or maximise) a goal over chosen design parameters within bounds, from one start or several.

    The search uses exact derivatives. For steps to a fall all designs walk over the same blocks. The answer says where
    it ended: in an optimum, on a bound (which), where two parts of the goal or two multipliers are equal, on a fold, or
    at the edge of what can walk. If no gait holds the targets, the answer says how far the nearest is, and the command
    ends with 3. The gait is the constraint model's. With --within a measure is the twin's, by the cheapest model that
    is exact enough, and a target is held for the twin.

    Without --vary: foot radius, foot_com, stiffness and damping within 20 %.
    """,
    Options,
    ask,
    examples=(
        "bipedstudy design",
        "bipedstudy design --vary biped.foot_radius=0.05:0.12 --goal friction",
        "bipedstudy design --goal speed --maximise --target multiplier=0.6",
        "bipedstudy design --target speed=0.33 --within speed=1%",
        "bipedstudy design --goal steps_to_fall --set ground.block_height_rms=4e-4 --target speed=0.3:0.36",
    ),
    draws=True,
    rows=True,
    leaves="parameter files with the best design",
)
