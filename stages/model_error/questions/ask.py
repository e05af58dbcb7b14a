"""`ask`: a measure of the design's gait within an error, by the cheapest model that has it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stages.biped.quantity import Bound
from stages.biped.question import Answer, Asking, Question, WrongOption, option
from stages.model_error.measures import NAMES, UNITS, Allowed, errors, in_digits, learnt_by

if TYPE_CHECKING:
    from stages.model_error.choice import Answered
    from stages.model_error.parameters import Parameters
    from stages.model_error.result import Stability

STABLE = "stable"


@dataclass(frozen=True)
class Options:
    """Options of `ask`."""

    what: tuple[str, ...] = option(
        "-", "Measure, or stable", positional=True, choices=(*NAMES, STABLE), metavar="MEASURE")
    within: tuple[str, ...] = option(
        "-", "Largest error: a share (1%), a number in the measure's unit, or one for each (speed=1%)", default=(),
        metavar="ERROR")
    learn: int = option(
        "1", "Compute so many more designs, for smaller errors; they are kept", default=0,
        bound=Bound(minimum=0, maximum=10_000))

    def allowed(self, measure: str) -> Allowed:
        """The error requested of a measure. Raises WrongOption."""
        given = errors(self.within)
        found = given.get(measure, given.get(""))
        if found is None:
            raise WrongOption(f"--within: no error is given for {measure}; as --within {measure}=1%")
        if measure == "multiplier" and found.share:
            raise WrongOption("--within: a multiplier can be 0: its error is a number, as --within multiplier=0.01")
        return found


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """The measures requested. Raises WrongOption."""
    allowed = {name: options.allowed(name) for name in dict.fromkeys(options.what) if name != STABLE}
    result = learnt_by(asking)
    from stages.model_error.choice import Ladder
    from stages.model_error.miss import Learnt
    from stages.model_error.run import further
    from stages.model_error.rungs import NoRung

    if options.learn:
        result = further(result, parameters, list(asking.each(walk, range(options.learn), options.learn)))
    ladder = Ladder(parameters, Learnt(result), asking.progress)
    found = [ladder.within(name, one.error, one.share) for name, one in allowed.items()]
    lines = [line for one in found for line in in_words(one)]
    plain: dict[str, Any] = {one.measure: as_json(one) for one in found}
    refused = any(not one.met for one in found)
    if STABLE in options.what:
        try:
            stable = ladder.stable()
            lines += stability_in_words(stable)
            plain[STABLE] = as_json(stable)
        except NoRung as reason:
            lines.append(f"stable: not known, as {reason}")
            plain[STABLE], refused = {"probability": None, "reason": str(reason)}, True
    rows = [{"measure": name, **one} for name, one in plain.items()]
    outside, unlike = ladder.outside(), ladder.unlike()
    if unlike:
        lines.append(f"of another kind than the sampled designs, so that only the twin answers: {unlike}")
    elif outside:
        lines.append(f"outside of the sampled designs in {', '.join(outside)}: the model's error is widened")
    calibrated, _ = asking.result("calibrated_twin")
    late = calibrated and calibrated.strikes_off
    lines.append(of_the_robot(late))
    plain |= {"outside_of_drawn": outside, "unlike_the_drawn": unlike or None, "twin_strikes_off_s": late}
    return Answer(lines, plain, rows=rows, no=refused)


def of_the_robot(late: float | None) -> str:
    """What is known of how the twin differs from the robot, of whose strikes its own are `late` by at most [s]."""
    if late is None:
        return ("nothing is known of how the twin differs from a robot: stage calibrated_twin finds it from recordings "
                "of one")
    return ("no error here contains how the twin differs from the robot: of a recording that was not fitted, the "
            f"calibrated twin's heel strikes are off by up to {1e3 * late:.2g} ms")


def walk(parameters: Parameters, count: int, number: int) -> list[list[list[float]]]:
    """Measures by every rung, and their errors, of one of so many further draws, for `Asking.each`."""
    from stages.model_error.run import further_draws, walked

    return [each.tolist() for each in walked(further_draws(parameters, count)[number], twin=False)[:2]]


def as_json(one: Answered | Stability) -> dict[str, Any]:
    """An answer as JSON: no number where none is known."""
    plain = {key: value for key, value in vars(one).items() if key != "measure"}
    return {key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in plain.items()}


def amount(one: Answered, error: float) -> str:
    """An error of an answer in words: as a share, or in the measure's unit."""
    if not math.isfinite(error):
        return "not known"
    return f"{100 * error:.2g} %" if one.share else f"{error:.2g}"


def in_words(one: Answered) -> list[str]:
    """An answer in words."""
    requested = amount(one, one.requested)
    if not one.met:
        return [f"{one.measure}: no model has it within {requested}", *(f"  {reason}" for reason in one.passed_over)]
    unit = UNITS[one.measure].replace("1", "")
    return [
        f"{one.measure}: {one.value:.9g} {unit}".rstrip() + f", within {amount(one, one.solver + one.model)} of the "
        f"twin's ({requested} requested)",
        f"  error: solver {amount(one, one.solver)}, model {amount(one, one.model)}; " + (
            f"beside it, errors of the parameters leave {amount(one, one.inputs)} open"
            if math.isfinite(one.inputs) else "what errors of the parameters leave open is not known")
        + f", the ramp's slope alone {amount(one, one.ramp)}" * (one.ramp > 0.0),
        f"  by the {one.rung} at tolerance {one.tolerance:g}, corrected by {amount(one, one.correction)}; it takes "
        f"{one.price_s:g} s of processor time",
        *(f"  not by a cheaper one: {reason}" for reason in one.passed_over),
        f"  {one.closer}",
    ]


def stability_in_words(found: Stability) -> list[str]:
    """The answer to whether a gait is stable, in words."""
    left = f"leave {found.inputs:.2g} open" if math.isfinite(found.inputs) else "leave an unknown part open"
    return [
        f"stable: with a probability {in_digits(found.probability, 3)}",
        f"  largest multiplier {found.multiplier:.4g} +- {found.solver + found.model:.2g}, by the {found.rung}; errors "
        f"of the parameters {'reach where it has no gait' if math.isinf(found.inputs) else left}",
    ]


QUESTION = Question(
    "ask",
    """Print a measure of the design's gait within an error, by the cheapest model that is exact enough.

    Measures: period, step_frequency, step_length, speed, peak_force (the largest normal force on a foot), multiplier
    (the largest magnitude), and stable, as a probability. The models are the constraint model, the same with the
    twin's details, the compiled penalty walker, and the twin. Each is corrected by its known difference to the twin
    (stage model_error); --learn adds designs to that, which are walked once and kept. The command ends with 3 if no
    model is exact enough.
    """,
    Options,
    ask,
    examples=("bipedstudy ask step_frequency --within 1%", "bipedstudy ask stable --set ground.slope_deg=3",
              "bipedstudy ask speed period --within speed=2% --within 1e-3",
              "bipedstudy ask step_length --within 0.5% --learn 40"),
    rows=True,
    pool=True,
)
