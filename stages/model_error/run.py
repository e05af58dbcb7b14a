"""The model error stage: what each rung misses of the best one, at designs drawn around the study's.

Inputs: none. Settings: params/model_error.yaml. Output: `Result`, the measures of each rung's gait; what they miss
follows from these (`stages.model_error.miss`), and whether the study's own gait is stable.
"""

import dataclasses
import warnings
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from stages.biped.processes import Progress, ignore
from stages.model_error.choice import Ladder
from stages.model_error.designs import draws, kind, numbers
from stages.model_error.measures import MEASURES
from stages.model_error.miss import Learnt
from stages.model_error.parameters import Parameters
from stages.model_error.result import PENALTY, SHARED, TWIN, Result, Stability
from stages.model_error.rungs import RUNGS, Design, NoRung, design_of

#: The second run for the errors of a stage's numbers is made here gait by gait.
ONCE = "each gait is searched a second time at ten times the tolerance, whose difference is its solver_errors"
#: Place among a rung's tolerances of the one at which it is walked here.
FINER = 1


def run(parameters: Parameters, inputs: None = None, progress: Progress = ignore) -> Result:
    """Draw, and find each rung's gait; the twin's of the first draws that have the penalty walker's."""
    settings = parameters.settings
    base = design_of(parameters)
    drawn = draws(base, settings.designs, settings.seed)
    shape = len(drawn), len(RUNGS), len(MEASURES)
    values, errors = np.full(shape, np.nan), np.full(shape, np.nan)
    without: list[str] = []
    twins = settings.twins
    for number, design in enumerate(drawn):
        progress(number / len(drawn), f"design {number + 1} of {len(drawn)}")
        values[number], errors[number], reasons = walked(design, twin=twins > 0)
        without += [f"design {number + 1}: {reason}" for reason in reasons]
        twins -= not np.isnan(values[number, TWIN, 0])
    known = np.array([numbers(design) for design in drawn])
    nothing = np.full((len(RUNGS), len(MEASURES), 3), np.nan)
    result = Result(settings.seed, kind(base), known, values.swapaxes(0, 1), errors.swapaxes(0, 1), nothing,
                    tuple(without))  # fmt: skip
    return dataclasses.replace(
        result, at_the_design=left_at(result, numbers(base)), stability=stability(parameters, result))


def walked(design: Design, *, twin: bool) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Measures by every rung (r, k) and their solver's errors (r, k), NaN without a gait; and why there is none.

    With `twin` the twin's too, if the penalty walker has a gait.
    """
    values, errors = np.full((2, len(RUNGS), len(MEASURES)), np.nan)
    reasons: list[str] = []
    for place, rung in enumerate(RUNGS):
        if place == TWIN and (not twin or np.isnan(values[PENALTY, 0])):
            continue
        try:
            found = rung.find(design, rung.tolerances[min(FINER, len(rung.tolerances) - 1)])
        except NoRung as reason:
            reasons.append(str(reason))
            continue
        values[place], errors[place] = found.values, found.errors
    return values, errors, reasons


def further(result: Result, parameters: Parameters, walks: Sequence[Any]) -> Result:
    """A result with what `further_draws` are and measure: values and errors of each, (n, 2, r, k)."""
    known = np.array([numbers(design) for design in further_draws(parameters, len(walks))])
    values, errors = np.array(walks).transpose(1, 2, 0, 3)
    return dataclasses.replace(
        result,
        numbers=np.concatenate([result.numbers, known]),
        values=np.concatenate([result.values, values], axis=1),
        solver_errors=np.concatenate([result.solver_errors, errors], axis=1),
    )


def further_draws(parameters: Parameters, count: int) -> list[Design]:
    """So many designs beside those of the stage."""
    return draws(design_of(parameters), count, parameters.settings.seed + 1)


def stability(parameters: Parameters, result: Result) -> Stability | None:
    """Whether the study's own gait is stable, as `ask stable` says it; None where no model's error is known."""
    with suppress(NoRung):
        return Ladder(parameters, Learnt(result)).stable()
    return None


def left_at(result: Result, own: np.ndarray) -> np.ndarray:
    """What the solver leaves of each measure (median of the draws), the model's known miss, what it may miss beside."""
    learnt = Learnt(result)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of a rung without any gait
        solver = np.nanmedian(np.where(SHARED, result.solver_errors / result.values, result.solver_errors), axis=1)
    misses = [[learnt.at(rung, measure, own) for measure in range(len(MEASURES))] for rung in range(len(RUNGS))]
    model = np.array([[(each.bias, each.error) for each in one] for one in misses])
    model[..., 0] = np.where(SHARED, np.expm1(model[..., 0]), model[..., 0])
    return np.concatenate([solver[..., None], model], axis=-1)
