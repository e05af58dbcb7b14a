"""All claims in the paper's order: which apply to a biped, their four parts, and what numerical errors could change.

The error of a number is what it differs by where all stages solved more closely.
"""

import contextlib
import dataclasses
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from stages.comparison.claims import calibration, contact, figure_8, gait, measurement, numerics, twin
from stages.comparison.claims.paper import BIPED, SETTINGS
from stages.comparison.claims.statement import Measured, Statement
from stages.comparison.evidence import Evidence
from stages.comparison.parameters import Parameters, Settings
from stages.comparison.result import DOES_NOT_APPLY, UNDECIDED, UNKNOWN, Claim, Number


def in_the_papers_order(one: Statement) -> list[int]:
    """Chapter and section of a statement."""
    return [int(part) for part in re.findall(r"\d+", one.section)[:2]]


#: The statements by name; within a section in the order of their files.
STATEMENTS = {
    one.id: one
    for one in sorted(
        (one for topic in (numerics, contact, gait, figure_8, twin, measurement, calibration)
         for one in topic.STATEMENTS), key=in_the_papers_order)
}  # fmt: skip
#: Evidence and what closer solvers gave in its place, if anything.
Both = tuple[Evidence, Evidence] | None
#: Errors are so many times what closer solvers change, as those of artefacts are.
SAFE = 3.0
#: What a claim on the method needs of a biped: legs that take double stance.
OF_THE_METHOD = ("biped.legs",)


def judge(e: Evidence, both: Both = None) -> tuple[Claim, ...]:
    """Every claim, measured and judged; `both` are evidence and what closer solvers gave in its place. Claims on the
    paper's biped are not judged for another one.
    """
    return tuple(judged(e.parameters, one.measured(e), *measured_of(one, both)) for one in STATEMENTS.values())


def measured_of(one: Statement, both: Both) -> tuple[Measured, Measured] | tuple[()]:
    """What is measured, and what closer solvers measure; nothing where they do not get there: errors are then unknown,
    and the claim stands."""
    with contextlib.suppress(Exception):
        return (one.measured(both[0]), one.measured(both[1])) if both else ()
    return ()


def judged(parameters: Parameters, measured: Measured, *both: Measured) -> Claim:
    """One claim, and if they are known both measurements that its errors are the difference of. Numbers whose errors
    are unknown are judged as if they had none, and that is said."""
    about, judgement = measured.about, measured.judge(parameters.settings)
    known = numbers(measured, *both)
    beside = UNKNOWN if any(math.isnan(one.error) for one in known if math.isfinite(one.value)) else ""
    verdict, condition, causes = judgement.verdict, judgement.condition, judgement.reasons
    for number, other in other_verdicts(measured, parameters.settings, known):
        verdict, condition = UNDECIDED, ""
        causes = (*causes, f"{number.name.replace('_', ' ')} = {number.value:.4g} has a numerical error of "
                           f"{number.error:.1g}, within which the verdict could also be: {other}")  # fmt: skip
    differing = another_biped(parameters, OF_THE_METHOD if about.method else BIPED)
    if differing:
        verdict, condition, beside = DOES_NOT_APPLY, "", ""
        causes = (f"this is another biped than the sentence is about: {'; '.join(differing)}",)
    return Claim(
        id=about.id,
        section=about.section,
        plain=about.plain,
        words=about.words,
        implies=about.implies,
        measured=re.sub(r"[-+]?\bnan\b", "?", judgement.measured),  # a number that is not known
        verdict=verdict,
        condition=condition,
        beside=beside,
        causes=causes,
        rests_on=rests_on(parameters, about.rests_on),
        numbers=known,
    )


def another_biped(parameters: Parameters, keys: Iterable[str] = BIPED) -> tuple[str, ...]:
    """The parameters among `keys` in which this biped or its slope is not the paper's, in words.

    Of all `keys` together: also the details that a biped may have and the paper's has not.
    """
    differing = []
    for key in keys:
        (printed, source), (value, unit) = BIPED[key], found(parameters, key)
        if (own := quantity(value, unit)) != (papers := quantity(printed, unit)):  # not in a last digit of round-off
            differing.append(f"{key} is {own}, the paper has {papers} ({source})")
    further = () if keys is not BIPED else (key for key in parameters.biped.details if f"biped.{key}" not in BIPED)
    given = ((key, quantity(*found(parameters, f"biped.{key}"))) for key in further)
    return (*differing, *(f"biped.{key} is {value}, the paper's biped has none" for key, value in given))


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
        if key in SETTINGS and value != SETTINGS[key][0]:
            text += f" (paper: {quantity(SETTINGS[key][0], unit)}, {SETTINGS[key][1]})"
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
    text = str(value).lower() if isinstance(value, bool) else value if isinstance(value, str) else f"{value:g}"
    return text if unit in ("1", "-", "") else f"{text} {unit}"


def numbers(measured: Measured, *both: Measured) -> tuple[Number, ...]:
    """The numbers of a claim, each with its error: `SAFE` times what those of its name in `both` differ by."""
    one, other = (dict(named(each.numbers)) for each in both) if both else ({}, {})
    return tuple(Number(name, measured.unit(name), value,
                        SAFE * abs(one.get(name, math.nan) - other.get(name, math.nan)))
                 for name, value in named(measured.numbers))  # fmt: skip


def named(parts: Any, where: str = "") -> Iterator[tuple[str, float]]:
    """Name and value of each float in fields and in tuples, to any depth."""
    pairs = parts.items() if isinstance(parts, Mapping) else enumerate(parts)
    for key, value in pairs:
        name = f"{where}.{key}" if where else str(key)
        if isinstance(value, float):
            yield name, float(value)
        elif isinstance(value, tuple):
            yield from named(value, name)


def other_verdicts(measured: Measured, settings: Settings, known: tuple[Number, ...]) -> Iterator[tuple[Number, str]]:
    """Numbers that change the verdict if they are more or less by their error, and what it then is."""
    verdict = measured.judge(settings).verdict
    for number in known:
        if number.error > 0 and math.isfinite(number.value):
            for value in (number.value - number.error, number.value + number.error):
                other = with_number(measured, number.name, value).judge(settings).verdict
                if other != verdict:
                    yield number, other
                    break


def with_number(measured: Measured, name: str, value: float) -> Measured:
    """The same claim with one number changed."""
    key, *places = name.split(".")
    changed = _changed(measured.numbers[key], places, value)
    return dataclasses.replace(measured, numbers={**measured.numbers, key: changed})


def _changed(part: Any, places: list[str], value: float) -> Any:
    if not places:
        return value
    return tuple(_changed(item, places[1:], value) if at == int(places[0]) else item for at, item in enumerate(part))
