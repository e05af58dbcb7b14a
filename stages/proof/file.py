"""The proof file: what was proven of which design, as decimals rounded outwards; and what it takes to confirm one.

Of a file nothing is believed but the design, the centre and the radius: these say what is to be shown. All else is
computed anew and has to lie within what the file has.
"""

from __future__ import annotations

import dataclasses
import json
import math
import re
from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from stages.biped.design import Biped
from stages.biped.gait import StanceState
from stages.biped.quantity import faults
from stages.biped.question import refuse
from stages.ground.slope import Slope

if TYPE_CHECKING:
    from stages.proof.theorem import Theorem

KIND = "bipedstudy proof 1"
KEYS = ("kind", "biped", "ground", "steps", "phases", "centre", "radius", "stable", "enclosures")
#: Entries of the state of compliant and of rigid legs.
STATE = tuple(StanceState.__dataclass_fields__)
RIGID_STATE = STATE[::2]
DECIMAL = re.compile(r"-?\d{1,40}(\.\d{1,80})?(e-?\d{1,3})?")


def outward(ball: Any) -> list[str]:
    """Decimals below and above a ball."""
    low, high = (rational(end) for end in (ball.lower(), ball.upper()))
    width = float(high - low)
    digits = max(1, 2 - math.floor(math.log10(width))) if width > 0 else 40
    scale = 10**digits
    return [text(math.floor(low * scale), digits), text(math.ceil(high * scale), digits)]


def rational(thin: Any) -> Fraction:
    """A thin ball as a fraction."""
    mantissa, exponent = thin.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def text(scaled: int, digits: int) -> str:
    """scaled / 10^digits as a decimal."""
    plain = str(abs(scaled)).rjust(digits + 1, "0")
    return f"{'-' if scaled < 0 else ''}{plain[:-digits]}.{plain[-digits:]}"


def state_names(biped: Biped) -> tuple[str, ...]:
    """Names of a state's entries."""
    return RIGID_STATE if biped.legs == "rigid" else STATE


def enclosures(biped: Biped, theorem: Theorem) -> dict[str, list[str]]:
    """All enclosures of a theorem by name, SI units."""
    from flint import arb

    multipliers = theorem.multipliers
    balls = {"period_s": theorem.period, "step_length_m": theorem.step_length}
    balls |= dict(zip(state_names(biped), theorem.fixed_point, strict=True))
    balls |= {f"least_force_{phase.replace(' ', '_')}_N": ball for phase, ball in theorem.least_forces.items()}
    for place, (centre, radius) in enumerate(multipliers.discs, 1):
        beside = arb(0, radius.abs_upper())
        balls[f"multiplier_{place}_real"] = centre.real + beside
        balls[f"multiplier_{place}_imaginary"] = centre.imag + beside
    balls["other_multipliers_size"] = arb(0).union(multipliers.others)
    balls["largest_multiplier_size"] = multipliers.least.union(multipliers.most)
    return {name: outward(ball) for name, ball in balls.items()}


def record(biped: Biped, slope: Slope, steps: int, theorem: Theorem) -> dict[str, Any]:
    """A proof file's content."""
    about = {name: value for name, value in dataclasses.asdict(biped).items() if value is not None}
    return {
        "kind": KIND, "biped": about, "ground": dataclasses.asdict(slope), "steps": steps, "phases": theorem.phases,
        "centre": dict(zip(state_names(biped), theorem.centre, strict=True)), "radius": theorem.radius,
        "stable": theorem.multipliers.stable, "enclosures": enclosures(biped, theorem),
    }  # fmt: skip


def read(content: bytes, name: str) -> tuple[Biped, Slope, dict[str, Any]]:
    """The design and the content of a proof file. Raises WrongOption."""
    try:
        told: Any = json.loads(content)
    except ValueError:
        told = None
    refuse((not isinstance(told, dict) or told.get("kind") != KIND, f"{name} is no proof file (kind: {KIND!r})"))
    refuse((set(told) != set(KEYS), f"{name}: the keys of a proof file are {', '.join(KEYS)}"))
    try:
        biped, slope = Biped(**told["biped"]), Slope(**told["ground"])
        broken = [*faults(biped), *faults(slope)]
    except (TypeError, ValueError) as error:
        refuse((True, f"{name}: biped and ground are no design: {error}"))
    refuse((bool(broken), f"{name}: biped or ground has a value that no design may have: {broken[:1]}"))
    centre, found = told["centre"], told["enclosures"]
    refuse(
        (not isinstance(centre, dict) or tuple(centre) != state_names(biped),
         f"{name}: centre has the entries {', '.join(state_names(biped))}"),
        (not isinstance(found, dict) or not set(state_names(biped)) <= set(found),
         f"{name}: enclosures lack the fixed point's"),
        (told["steps"] not in (1, 2, 4, 8), f"{name}: steps = {told['steps']!r}; allowed: 1, 2, 4 or 8"))
    numbers = [told["radius"], *centre.values(), *(each for pair in found.values() for each in pair)]
    refuse((not all(isinstance(each, str) and DECIMAL.fullmatch(each) for each in numbers),
            f"{name}: radius, centre and enclosures are decimals, as text"))  # fmt: skip
    refuse((not all(len(pair) == 2 for pair in found.values()), f"{name}: an enclosure has two ends"))
    return biped, slope, told


def unlikely(told: Mapping[str, Any], expected: list[str]) -> str | None:
    """What in a file contradicts itself or the model, before anything is computed; None if nothing does."""
    if told["phases"] != expected:
        return f"its phases are {', '.join(map(str, told['phases']))}, and the model's are {', '.join(expected)}"
    radius = Fraction(told["radius"])
    for name, middle in told["centre"].items():
        low, high = map(Fraction, told["enclosures"][name])
        if not (Fraction(middle) - radius <= low <= high <= Fraction(middle) + radius):
            return f"its enclosure of {name} is not within its ball"
    return None


def unconfirmed(told: Mapping[str, Any], anew: Mapping[str, Any]) -> str | None:
    """What a file says and a proof made anew does not; None if all is confirmed."""
    for name in ("phases", "stable"):
        if told[name] != anew[name]:
            return f"its {name} is {told[name]}, and the proof made anew has {anew[name]}"
    if set(told["enclosures"]) != set(anew["enclosures"]):
        return "its enclosures are others than those of the proof made anew"
    for name, found in anew["enclosures"].items():
        (low, high), (at_least, at_most) = map(Fraction, told["enclosures"][name]), map(Fraction, found)
        if not low <= at_least <= at_most <= high:
            return f"its {name}, {' .. '.join(told['enclosures'][name])}, is not what the proof made anew shows"
    return None
