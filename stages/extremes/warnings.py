"""Warns of parameters outside those at which every model was found right, by the kept map of extremes.

A design lies among the points of the map by its dimensionless numbers, as similar designs answer alike. Distances are
in decades: the root of the sum of squares of the numbers' decimal logarithms. The table is written by
benchmarks/extremes_table.py from the full map; docs/extremes.md says how the map was made.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from stages.biped.accuracy.tolerances import CUSTOM
from stages.extremes.parameters import COMPILED, COULOMB, GAIT, INACCURATE, JOINTS, RIGHT, TREE, TWIN

TABLE = Path(__file__).with_name("envelope") / "table.json"
#: Columns of a row of the table; what follows them are the numbers, in the order that the table names.
COLUMNS = ("what", "status", "error", "reason")
#: Beyond this distance from every point nothing is known: the widest gap between neighbours of an axis is twice that.
REACH = 1.2
#: A tolerance or a step of the solver varies over many decades of which each changes little: it counts by half.
OF_A_SOLVER = 0.5


def warnings(values: Mapping[str, Any]) -> Iterator[str]:
    """One sentence for each stage whose parameters are outside; `values` is stage -> parameters."""
    for stage, own in values.items():
        engine = engine_of(stage, own)
        if engine is None:
            continue
        ground = own.contact if hasattr(own, "contact") else own.friction
        here = place_of(engine, own.biped, own.slope, ground, own.settings)
        sentence = warning(engine, here, tried(engine), own.settings.accuracy != CUSTOM)
        if sentence is not None:
            yield f"stage {stage}: {sentence}"


def engine_of(stage: str, parameters: Any) -> str | None:
    """The engine that a stage with these parameters uses; None for a stage that stands on others."""
    if stage == "analytic":
        return COULOMB if parameters.limited_friction and parameters.biped.legs == "compliant" else GAIT
    if stage == "multibody":
        return JOINTS if parameters.settings.assembly == "joints" else TREE
    return TWIN if stage == "twin" else None


@cache
def table() -> dict[str, Any]:
    """The kept table: engine -> groups of points with the same choices."""
    read: dict[str, Any] = json.loads(TABLE.read_text(encoding="utf-8"))
    return read


def tried(engine: str) -> list[Tried]:
    """The points of an engine."""
    found = []
    for group in table()["engines"].get(engine, ()):
        for *said, numbers in group["points"]:
            place = Place(group["choices"], dict(zip(group["numbers"], numbers, strict=True)))
            found.append(Tried(place, **dict(zip(COLUMNS, said, strict=True))))
    return found


@dataclass(frozen=True)
class Place:
    """What an engine's answer depends on: the choices made, and decimal logarithms of dimensionless numbers."""

    choices: Mapping[str, str]
    numbers: Mapping[str, float]


@dataclass(frozen=True)
class Tried:
    """A point of the map: what was tried there, and what came of it."""

    place: Place
    what: str
    status: str
    error: float | None
    reason: str


def place_of(engine: str, biped: Any, slope: Any, ground: Any, settings: Any) -> Place:
    """The place of a design; `ground` is a `Friction` or a `ContactLaw`, `settings` those of the engine's stage.

    Numbers too small to matter count as a least one. Lengths are measured in leg lengths, masses in total masses,
    times in sqrt(leg length / gravity).
    """
    mass, length = biped.total_mass, biped.leg_length
    above = biped.hip_mass + biped.frame_mass + biped.leg(1).frame_mass  # the springs
    time = math.sqrt(length / slope.gravity)
    choices, numbers = {"biped.legs": biped.legs}, {
        "hip to foot mass": (above / biped.foot_mass, 1e-5),
        "foot radius": (biped.foot_radius / length, 1e-2),
        "foot's mass centre": (biped.foot_com / length, 1e-2),
        "leg inertia": (biped.leg_inertia / (mass * length**2), 1e-2),
        "slope": (slope.slope_deg, 1e-2),
    }  # fmt: skip
    if biped.legs == "compliant":
        numbers["stiffness"] = biped.stiffness * time**2 / mass, 1e-3
        numbers["damping"] = biped.damping * time / mass, 1e-2
    if engine == COULOMB:
        numbers["friction"] = ground.coefficients.static_friction, 1e-2
    if engine not in (GAIT, COULOMB):
        choices |= {"ground.normal_force": ground.normal_force, "ground.friction": ground.friction}
        weight = mass * slope.gravity
        numbers |= {
            "friction": (ground.coefficients.static_friction, 1e-2),
            "penetration": ((weight / ground.stiffness_si) ** (1.0 / ground.contact_exponent) / length, 1e-9),
            "contact exponent": (ground.contact_exponent, 1.0),
            "contact damping": (ground.contact_damping * time / mass, 1.0),
            "damping depth": (ground.damping_depth / length, 1e-9),
            "stiction velocity": (ground.stiction_velocity * time / length, 1e-9),
        }
        if ground.normal_force == "restitution":
            numbers["restitution"] = ground.restitution, 1e-2
    found = {name: math.log10(max(value, least)) for name, (value, least) in numbers.items()}
    if engine == JOINTS:
        solver = {"rolling step": settings.rolling_step / time, "impact step": settings.impact_step / time}
    elif engine in (GAIT, COULOMB, COMPILED):
        solver = {"tolerance": settings.tolerance}
    else:
        solver = {"tolerance": settings.tolerance, "largest step": settings.largest_step / time}
    return Place(choices, found | {name: OF_A_SOLVER * math.log10(value) for name, value in solver.items()})


def distance(one: Place, other: Place) -> float:
    """Decades between two places; infinite if a choice differs."""
    if one.choices != other.choices:
        return math.inf
    return math.dist([one.numbers[name] for name in one.numbers], [other.numbers[name] for name in one.numbers])


def warning(engine: str, here: Place, tried: Sequence[Tried], accuracy_requested: bool) -> str | None:
    """What is to be said of a design outside what the map found right, with the nearest point; None inside.

    Whoever requested an accuracy is not warned of inaccuracy.
    """
    nearest = min(tried, key=lambda point: distance(here, point.place), default=None)
    away = distance(here, nearest.place) if nearest else math.inf
    if nearest is None or away == math.inf:
        chosen = ", ".join(f"{name} = {choice}" for name, choice in here.choices.items())
        text = f"the map of extremes has no point of the model {engine} with {chosen}; nothing is known of its errors"
        return None if accuracy_requested else f"{text} until an accuracy is requested (--accuracy hip_position_m=1e-5)"
    fine = (RIGHT, INACCURATE) if accuracy_requested else (RIGHT,)
    if nearest.status in fine and away <= REACH:
        return None
    said = f"{nearest.status} by {nearest.error:.1e} leg lengths" if nearest.status == INACCURATE else nearest.status
    point = f"the point tried that is most similar in ratios, {engine} at {nearest.what}, came out as {said}"
    point += f": {nearest.reason}" if nearest.reason and nearest.status != RIGHT else ""
    if nearest.status in fine:
        return f"these parameters are a factor {10**away:.2g} away from all that the map of extremes has tried; {point}"
    return f"these parameters lie outside what the map of extremes (docs/extremes.md) found right; {point}"
