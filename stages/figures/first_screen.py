"""What a report says first: whether the biped walks, how fast, how stable, what was measured, each with its error.

Numbers of the gait are the constraint model's, corrected by what it is known to miss of the twin, as `ask` gives them.
Its stability is that of `ask stable`, by the model that decides it.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from stages.about import ATTRIBUTES
from stages.analytic.result import Result as Analytic
from stages.analytic.walk.on_a_ramp import DOES_NOT, WALKS, WALKS_IF, on_a_ramp
from stages.biped.quantity import count_of, written_out
from stages.comparison.result import Result as Comparison
from stages.figures.entry import Inputs
from stages.imu.judgement.verdict import FREQUENCY
from stages.imu.result import Result as Ingested, stepping
from stages.model_error.measures import NAMES, in_digits
from stages.model_error.result import EVEN, SHARED, WIDTH, Result as ModelError
from stages.planar.run import FELL
from stages.twin.result import with_doubt

#: Measures as the constraint model's uncertainties name them.
FIELDS = {"step_frequency": "step_frequency_hz", "step_length": "step_length_m", "speed": "speed_m_s",
          "multiplier": "multiplier_1"}  # fmt: skip
PAPERS = "The passive biped of Vasileiou, Smyrli, Drogosis and Papadopoulos (2021)"
#: A stability of less probability is left open; of more, errors that reach beyond one lie on the other side.
SURE, UNSURE, CERTAIN = 0.9, "Its errors leave open whether it is stable", 0.999
#: Errors below this are stated as below it; a disturbance has faded when this part of it is left.
LEAST, FADED = 1e-5, 0.1


class Answer(NamedTuple):
    """One thing that a report says first: where its errors come from, what it `means` for who builds a walker."""

    question: str
    answer: str
    errors: str
    means: str


@dataclass(frozen=True)
class Measure:
    """A number, and by how much solver, model and inputs may move it, in its unit; NaN or infinite: not known."""

    value: float
    solver: float
    model: float
    inputs: float

    @property
    def known(self) -> bool:
        """Whether model's and inputs' parts are known; else a robot beyond the other errors may still be alike."""
        return math.isfinite(self.model + self.inputs)

    @property
    def error(self) -> float:
        """What is known of its errors, together; zero if nothing is."""
        solver, model, inputs = np.nan_to_num([self.solver, self.model, self.inputs], posinf=0.0)
        return float(solver + math.hypot(model, inputs))

    def text(self, factor: float = 1.0) -> str:
        """The number times a factor with its error, in as many digits as that leaves."""
        value, error = factor * self.value, factor * self.error
        return with_doubt(value, error) if error > LEAST * abs(value) else f"{value:.4g}"

    def parts(self, share: bool = True) -> str:
        """What each source of error leaves of it, to one digit, as a share or a number."""
        factor, unit, scale = (100.0, " %", abs(self.value)) if share else (1.0, "", 1.0)
        return ", ".join(
            f"{name} " + ("not known" if not math.isfinite(part) else f"< {factor * LEAST:.5f}".rstrip("0") + unit
                          if part < LEAST * scale else f"{written_out(factor * part / scale, 1)}{unit}")
            for name, part in (("solver", self.solver), ("model", self.model), ("inputs", self.inputs))
            if part or name != "inputs") + ", inputs taken as exact" * (self.inputs == 0.0)  # fmt: skip


def measure(analytic: Analytic, learnt: ModelError | None, name: str) -> Measure:
    """A measure of the gait with its errors. What a model misses was learnt of stable gaits alone."""
    place, gait = NAMES.index(name), analytic.gait
    found = gait.largest_multiplier if name == "multiplier" else getattr(gait, FIELDS[name])
    own = next((one for one in analytic.uncertainties if one.name == FIELDS[name]), None)
    own = own.of_a_step(gait.steps) if own and name == "multiplier" else own
    slopes = max(own.slope_most - own.value, own.value - own.slope_least) if own else 0.0  # NaN: no gait on some
    inputs = EVEN * WIDTH * math.hypot(own.independent, slopes) if own else 0.0
    errors = np.full(3, math.nan) if learnt is None else np.array(learnt.at_the_design[0, place])
    errors[1:] = errors[1:] if gait.stable else math.nan
    solver, bias, model = (float(part) for part in errors * (found if SHARED[place] else 1.0))
    known = math.isfinite(model)
    return Measure(max(found + bias, 0.0) if known else found, solver, model if known else math.nan, inputs)


def answers(inputs: Inputs) -> tuple[Answer, ...]:
    """The answers, as far as there are results."""
    if why := inputs.missing.get("analytic"):
        cause = why.removeprefix("there is no analytic: ")
        return (Answer("Does it walk?", "No gait is known.", "", f"{cause[:1].upper()}{cause[1:]}."),)
    found = {name: measure(inputs.analytic, inputs.model_error, name) for name in FIELDS}
    return (walks(inputs), fast(inputs, found), stable(inputs, found["multiplier"]),
            *measured(inputs.imu, found))  # fmt: skip


def walks(inputs: Inputs) -> Answer:
    """Whether it walks on a plain ramp, and what that requires."""
    settled = inputs.analytic.gait.stable
    cycle = 0 if settled or inputs.stability is None else inputs.stability.cycle
    judged = on_a_ramp(inputs.analytic.validity, settled, cycle)
    how, means = {
        WALKS: ("Yes, on a plain ramp.", "It needs neither stepping blocks nor feet that retract."),
        WALKS_IF: ("Yes, on conditions.", f"It walks if {'; and if '.join(judged.because)}."),
        DOES_NOT: (f"Not{' so' * bool(cycle)} on a plain ramp.", f"Why not: {'; '.join(judged.because)}."),
    }[judged.verdict]
    twin = inputs.missing.get("twin", "") or (
        f"The twin: {inputs.twin.outcome}, {count_of(inputs.twin.steps, 'step')}")
    return Answer("Does it walk?", how, f"By the constraint model. {twin}.", means)


def fast(inputs: Inputs, found: dict[str, Measure]) -> Answer:
    """Speed, step frequency and step length; of a limping gait, whose means these are, both steps, corrected alike.

    Where it is not known what the model misses of the twin, what the twin did.
    """
    analytic, speed, frequency = inputs.analytic, found["speed"], found["step_frequency"]
    low, high = frequency.value - frequency.error, frequency.value + frequency.error
    means = f"A metre takes {1.0 / speed.value:.3g} s. " + (
        f"A robot that takes fewer than {low:.3g} or more than {high:.3g} steps a second differs from this design, or "
        "its ramp does." if frequency.known else "Not all errors of these are known." if
        inputs.missing.get("twin") else f"The twin's last four steps: {inputs.twin.settling.last_four()}.")
    steps = f"{frequency.text()} steps a second, each {found['step_length'].text(1e3)} mm."
    if analytic.gait.steps > 1:
        longer = analytic.gait.step_frequency_hz / frequency.value
        wider = found["step_length"].value / analytic.gait.step_length_m
        each = ", the other ".join(f"{longer * time:.4g} s and {1e3 * wider * length:.4g} mm" for time, length in zip(
            analytic.limp.period_s, analytic.limp.step_length_m, strict=True))  # fmt: skip
        means += f" These are means: it limps, and its step on the first leg takes {each}."
    return Answer("How fast?", f"{speed.text()} m/s: {steps}", f"Errors of the speed: {speed.parts()}.", means)


def stable(inputs: Inputs, multiplier: Measure) -> Answer:
    """What a step leaves of a disturbance, and which starts end in the gait.

    As `ask stable` says it; where it is not known what models miss, the multiplier is the constraint model's.
    """
    found = inputs.model_error and inputs.model_error.stability
    if found:
        multiplier = Measure(found.multiplier, found.solver, found.model, found.inputs)
        likely, by = found.probability, f", by the {found.rung}"
    else:
        likely, by = NormalDist(multiplier.value, max(multiplier.error / WIDTH, 1e-12)).cdf(1.0), ""
    value, basin = multiplier.value, inputs.stability and inputs.stability.basin
    likely, word = (likely, "stable") if value < 1.0 else (1.0 - likely, "unstable")
    faded = math.ceil(math.log(FADED) / math.log(value)) if 0.0 < value < 1.0 else 1
    means = (f"A small disturbance has faded to a tenth after {count_of(faded, 'step')}" if value < 1.0 else
             "A small disturbance grows from step to step") if likely > SURE else UNSURE  # fmt: skip
    means += f"; of the starts tried, {100 * basin.share:.0f} % end in this gait." if basin else "."
    rung = inputs.twin_ladder.twin if inputs.twin_ladder else None
    twins = inputs.twin_ladder.largest_multipliers[0] if inputs.twin_ladder else math.nan
    if rung and math.isfinite(twins) and (rung.limps or likely <= SURE or (twins < 1.0) != (value < 1.0)):
        gait = "gait, which limps," if rung.limps else "gait"
        means += f" The twin's {gait} is {'stable' if twins < 1.0 else 'unstable'}: it leaves {twins:.3g} in the plane."
    if inputs.analytic.gait.stable != (value < 1.0):
        means += f" The constraint model's gait leaves {inputs.analytic.gait.largest_multiplier:.3g}."
    sure = f"with a probability {in_digits(likely, 2)}" + ("" if multiplier.known else " by the errors that are known")
    left = f"{multiplier.text()} of a small disturbance"
    if likely > CERTAIN and multiplier.error >= abs(1.0 - value):  # as where beyond a doubling it limps
        number, _, doubt = multiplier.text().partition(" ± ")
        left = f"{number} of a small disturbance, or up to {doubt} {'less' if value < 1.0 else 'more'}"
    how = f"A step leaves {left}: {word}, {sure}."
    how += _in_space(inputs) if word == "stable" else ""
    return Answer("How stable?", how, f"Errors of this multiplier{by}: {multiplier.parts(share=False)}.", means)


def _in_space(inputs: Inputs) -> str:
    """That the twin, which is not kept in the plane as the gait is, falls; nothing where it walks."""
    twin, pushed = inputs.twin, inputs.twin_pushes
    if twin and twin.outcome == FELL:
        return f" That is in the plane: in space the twin falls after {count_of(twin.steps, 'step')}."
    if pushed and pushed.walks and not any(walk.survived for walk in pushed.walks):
        return " That is in the plane: in space the twin falls after every push to the side that was tried."
    return ""


def measured(imu: Ingested | None, found: dict[str, Measure]) -> Iterator[Answer]:
    """What own recordings show beside what the model says; nothing for synthetic ones."""
    if imu is None or imu.origin == "synthetic":
        return
    shown, runs = [], stepping(imu.runs)
    for name, factor, unit in (("step_frequency", 1.0, "steps a second"), ("step_length", 1e3, "mm a step")):
        rows = np.array([[getattr(run.report, name), getattr(run.report, f"{name}_error")]
                         for run in runs]).reshape(-1, 2)  # fmt: skip
        values, errors = rows[np.isfinite(rows[:, 0])].T
        if len(values):  # several show their scatter, one alone its own error
            error = WIDTH * max(np.std(values, ddof=len(values) > 1), errors.max()) / math.sqrt(len(values))
            shown.append((Measure(float(values.mean()), math.nan, math.nan, float(error)), found[name], factor, unit))
    if not shown:
        one = imu.runs[0].report
        yield Answer("What was measured?", "No step frequency that can be trusted.", "",
                     f"{one.name}: {'; '.join(one.remarks)}.")  # fmt: skip
        return
    robot, model = shown[0][:2]
    alike = abs(robot.value - model.value) <= robot.error + model.error
    off = robot.value / model.value - 1.0
    doubted = next((run.report for run in runs if FREQUENCY in run.report.not_trusted), None)
    doubt = f" A remark speaks against them: {doubted.name}: {doubted.remarks[0]}." if doubted else ""
    yield Answer(
        "What was measured?",
        "; ".join(f"{one.text(by)} {unit} (model: {other.text(by)})" for one, other, by, unit in shown) + ".",
        f"Errors of what was measured: from the scatter of {count_of(len(runs), 'run')}.{doubt}",
        f"The robot steps {100 * abs(off):.2g} % {'faster' if off > 0 else 'slower'} than the model, "
        + ("within their errors: nothing speaks against the design." if alike else
           "more than their errors: a calibration shows which parameter differs." if model.known else
           "more than the errors that are known; others are not."),
    )  # fmt: skip


def title(compared: Comparison | None) -> dict[str, str | bool]:
    """Title, what stands below, and whether claims go before numbers. A report puts the study's name for {study}."""
    differing = compared.another if compared else ()
    if compared and not differing:
        return {"title": PAPERS, "about": ATTRIBUTES["references"], "claims_first": True}
    rest = f"; and {len(differing) - 2} more" if len(differing) > 2 else ""
    return {"title": "{study}: a passive biped", "claims_first": False,
            "about": f"Not the paper's biped: {'; '.join(differing[:2])}{rest}." if compared else
            "Not compared with the paper's biped."}  # fmt: skip
