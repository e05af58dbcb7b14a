"""Where a design lies among the points of the map: by its dimensionless numbers, as similar designs answer alike.

Distances are in decades: the root of the sum of squares of the numbers' decimal logarithms.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from stages.extremes.engines import COMPILED, COULOMB, GAIT, JOINTS
from stages.extremes.verdict import INACCURATE, RIGHT

#: Beyond this distance from every point nothing is known: the widest gap between neighbours of an axis is twice that.
REACH = 1.2
#: A tolerance or a step of the solver varies over many decades of which each changes little: it counts by half.
OF_A_SOLVER = 0.5


@dataclass(frozen=True)
class Place:
    """What an engine's answer depends on: the choices made, and decimal logarithms of dimensionless numbers."""

    choices: Mapping[str, str]
    numbers: Mapping[str, float]


@dataclass(frozen=True)
class Tried:
    """A point of the map: what was asked there, and what came of it."""

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
    time = math.sqrt(length / slope.gravity)
    choices, numbers = {"biped.legs": biped.legs}, {
        "hip to foot mass": (biped.hip_mass / biped.foot_mass, 1e-5),
        "foot radius": (biped.foot_radius / length, 1e-2),
        "foot's mass centre": (biped.foot_com / length, 1e-2),
        "leg inertia": (biped.leg_inertia / (mass * length**2), 1e-2),
        "slope": (slope.slope_deg, 1e-2),
    }  # fmt: skip
    if biped.legs == "compliant":
        numbers["stiffness"] = biped.stiffness * time**2 / mass, 1e-3
        numbers["damping"] = biped.damping * time / mass, 1e-2
    if engine == COULOMB:
        numbers["friction"] = ground.static_friction, 1e-2
    if engine not in (GAIT, COULOMB):
        choices |= {"ground.normal_force": ground.normal_force, "ground.friction": ground.friction}
        weight = mass * slope.gravity
        numbers |= {
            "friction": (ground.static_friction, 1e-2),
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


def warning(engine: str, here: Place, tried: Sequence[Tried], accuracy_asked: bool) -> str | None:
    """What is to be said of a design outside what the map found right, with the nearest point; None inside.

    Whoever asked for an accuracy is not told of inaccuracy.
    """
    nearest = min(tried, key=lambda point: distance(here, point.place), default=None)
    away = distance(here, nearest.place) if nearest else math.inf
    if nearest is None or away == math.inf:
        chosen = ", ".join(f"{name} = {choice}" for name, choice in here.choices.items())
        return f"the map of extremes has no point of the model {engine} with {chosen}; nothing is known of its errors"
    fine = (RIGHT, INACCURATE) if accuracy_asked else (RIGHT,)
    if nearest.status in fine and away <= REACH:
        return None
    said = f"{nearest.status} by {nearest.error:.1e} leg lengths" if nearest.status == INACCURATE else nearest.status
    told = f"the nearest point tried, {engine} at {nearest.what}, came out as {said}"
    told += f": {nearest.reason}" if nearest.reason and nearest.status != RIGHT else ""
    if nearest.status in fine:
        return f"these parameters are a factor {10**away:.2g} away from all that the map of extremes has tried; {told}"
    return f"these parameters lie outside what the map of extremes found right; {told}"
