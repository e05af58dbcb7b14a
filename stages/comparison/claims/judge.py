"""All claims in the paper's order: what is measured for each, which apply to a biped, and their four parts."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Iterable
from typing import Any, get_type_hints

from stages.comparison.claims import calibration, contact, figure_8, gait, measurement, numerics, twin
from stages.comparison.claims.measured import Measured, Unmeasured
from stages.comparison.claims.numerical_error import numbers, other_verdicts
from stages.comparison.claims.paper import BIPED, SAYS, SETTINGS
from stages.comparison.claims.verdict import DOES_NOT_APPLY, OPEN, UNDECIDED, UNKNOWN, Cause, Judgement
from stages.comparison.evidence import Evidence
from stages.comparison.parameters import Parameters
from stages.comparison.result import Claim, Number
from stages.comparison.stride import NoEvidence

#: What a claim on the method asks of a biped: legs that take double stance.
OF_THE_METHOD = ("biped.legs",)


def another_biped(parameters: Parameters, keys: Iterable[str] = BIPED) -> tuple[str, ...]:
    """The parameters among `keys` in which this biped or its slope is not the paper's, in words."""
    differing = []
    for key in keys:
        printed, (value, unit) = BIPED[key], found(parameters, key)
        if value != printed.value:
            differing.append(f"{key} is {quantity(value, unit)}, the paper has {quantity(printed.value, unit)} "
                             f"({printed.source})")  # fmt: skip
    return tuple(differing)


def rests_on(parameters: Parameters, keys: Iterable[str]) -> tuple[str, ...]:
    """Parameters with their values, and the paper's where it prints another; without those that follow from others.

    Parts that were made to fit the design say so.
    """
    named = []
    for key in keys:
        value, unit = found(parameters, key)
        if value is None and unit:
            continue
        text = f"{key} {quantity(value, unit)}".rstrip()
        if key in SETTINGS and value != SETTINGS[key].value:
            text += f" (paper: {quantity(SETTINGS[key].value, unit)}, {SETTINGS[key].source})"
        if key == "twin.parts" and (fitted := parameters.twin.bill_rule(parameters.biped)):
            text += f" ({fitted})"
        named.append(text)
    return tuple(named)


def found(parameters: Parameters, key: str) -> tuple[Any, str]:
    """Value and unit of a parameter file.key; no value where it is none of the comparison's (the ingest's)."""
    file, _, name = key.partition(".")
    for section in (getattr(parameters, field.name) for field in dataclasses.fields(parameters)):
        for field in dataclasses.fields(section):
            if file == section.FILE and field.name == name:
                return getattr(section, name), field.metadata["unit"]
    return None, ""


def quantity(value: Any, unit: str) -> str:
    """A value with its unit; nothing for a list or a table, which is named only."""
    if not isinstance(value, (str, int, float)):
        return ""
    text = value if isinstance(value, str) else f"{value:g}"
    return text if unit in ("1", "-", "") else f"{text} {unit}"


def judge(parameters: Parameters, measured: Iterable[Measured | Unmeasured]) -> tuple[Claim, ...]:
    """A claim for all that was measured, in its order. Claims on the paper's biped are not judged for another one."""
    return tuple(judged(parameters, one) for one in measured)


def judged(parameters: Parameters, measured: Measured | Unmeasured) -> Claim:
    """One claim; what was not measured stays open. Numbers whose errors are unknown are judged as if they had none, and
    that is said.
    """
    known: tuple[Number, ...] = ()
    others: tuple[tuple[Number, str], ...] = ()
    if isinstance(measured, Unmeasured):
        about = measured.claim
        judgement = Judgement(f"nothing: {measured.why}", OPEN, (Cause(True, measured.why),))
    else:
        about, judgement = type(measured), measured.judge(parameters.settings)
        known = numbers(measured, parameters)
        others = tuple(other_verdicts(measured, parameters.settings, known))
    beside = UNKNOWN if any(math.isnan(one.error) for one in known if math.isfinite(one.value)) else ""
    says, verdict, condition, causes = SAYS[about.ID], judgement.verdict, judgement.condition, judgement.reasons
    for number, other in others:
        verdict, condition = UNDECIDED, ""
        causes = (*causes, f"{number.name.replace('_', ' ')} = {number.value:.4g} has a numerical error of "
                           f"{number.error:.1g}, within which the verdict could also be: {other}")  # fmt: skip
    differing = another_biped(parameters, OF_THE_METHOD if about.METHOD else BIPED)
    if differing:
        verdict, condition, beside = DOES_NOT_APPLY, "", ""
        causes = (f"this is another biped than the sentence is about: {'; '.join(differing)}",)
    return Claim(
        id=about.ID,
        section=says.section,
        words=says.words,
        implies=says.implies,
        measured=re.sub(r"[-+]?\bnan\b", "?", judgement.measured),  # a number that is not known
        verdict=verdict,
        condition=condition,
        beside=beside,
        causes=causes,
        rests_on=rests_on(parameters, about.RESTS_ON),
        numbers=known,
    )


#: What measures each claim, in the paper's order.
MEASURES: tuple[Callable[[Evidence], Measured], ...] = (
    numerics.constraints_reduce_effort,
    contact.twice_differentiated,
    gait.multipliers_minimised,
    gait.stable_gait,
    numerics.tight_tolerances,
    gait.chaos_amplifies,
    contact.contact_set,
    contact.contact_set_figure_8,
    contact.rolling_without_slip,
    contact.friction_velocities,
    numerics.stiff_solver,
    figure_8.hip_displacement,
    figure_8.hip_velocity,
    figure_8.integration_tolerance,
    twin.twin_settles,
    twin.ramp_length,
    twin.push_converges,
    gait.step_frequency,
    measurement.sensor_range,
    twin.twin_like_simple,
    measurement.hip_path_drifts,
    measurement.encloses,
    measurement.slower,
    calibration.outsole_slows,
    measurement.push_slows,
    calibration.prototype_is_model,
)


def measure(e: Evidence) -> tuple[Measured | Unmeasured, ...]:
    """Every claim's numbers, or why it has none."""
    return tuple(_measured(e, one) for one in MEASURES)


def _measured(e: Evidence, one: Callable[[Evidence], Measured]) -> Measured | Unmeasured:
    try:
        return one(e)
    except NoEvidence as error:
        return Unmeasured(get_type_hints(one)["return"], str(error))
