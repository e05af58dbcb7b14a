"""Designs drawn around one, and the dimensionless numbers by which a design of any size is known.

A robot of another length, mass or time scale with the same numbers has the same gait in its own scales. What a model
misses, as a share of a measure, is therefore a function of these numbers.
"""

import dataclasses
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
from scipy.stats import qmc

from stages.biped.accuracy.scales import Scales, scales_of
from stages.biped.design import Biped
from stages.model_error.result import DIFFERENCES, SHARES
from stages.model_error.rungs import Design

S = TypeVar("S")
#: What is drawn of a design, by file and key, as a share of its value to either side; the details of every other design
#: in its own scales, to either side of none.
SPREAD = {
    **dict.fromkeys(("hip_mass", "foot_mass", "leg_length", "foot_radius", "foot_com", "stiffness", "damping"), 0.25),
    "slope_deg": 0.35,
    **dict.fromkeys(("contact_stiffness", "contact_damping", "stiction_velocity"), 0.1),
}
DETAILS = {"foot_offset": ("m", 0.0015), "hip_damping": ("N m s", 0.002), "hip_stiffness": ("N m", 0.02)}
UNEQUAL = {"other_foot_mass": 0.02, "other_stiffness": 0.1, "other_foot_com": 0.01}


def numbers(design: Design) -> np.ndarray:
    """The dimensionless numbers (n,) of a design, in the order of `NUMBERS`; the legs' are their means."""
    own = scales_of(design.biped, design.slope.gravity)
    measured, ground, twin = own.measure(design.biped), own.measure(design.contact), own.measure(design.twin)
    first, other, held, law = measured.leg(0), measured.leg(1), ground.coefficients, ground.numbers

    def mean(name: str) -> float:
        both: float = getattr(first, name) + getattr(other, name)
        return 0.5 * both

    stiffness, mass = mean("stiffness"), mean("foot_mass")
    return np.array([
        mass, mean("foot_radius"), mean("foot_com"), stiffness, 0.5 * mean("damping") / stiffness**0.5,
        mean("leg_inertia") / mass, design.slope.angle, ground.contact_stiffness, law.normal.damping_under(1.0),
        ground.stiction_velocity, held.static_friction, held.dynamic_friction,
        getattr(law.friction, "friction_velocity", 0.0), ground.contact_exponent, getattr(law.normal, "depth", 0.0),
        mean("frame_mass"), mean("frame_inertia"), *map(mean, DIFFERENCES), measured.hip_stiffness,
        measured.hip_damping, measured.hip_friction, measured.hip_rest_angle,
        measured.weighed_hip - measured.hip_mass, twin.outsole, twin.bearing_friction, twin.slider_friction,
        *(getattr(other, name) / mean(name) if mean(name) else 1.0 for name in SHARES),
        *(getattr(other, name) - getattr(first, name) for name in DIFFERENCES),
    ])  # fmt: skip


def kind(design: Design) -> str:
    """What no number shows of a design: misses of one kind say nothing of another."""
    feet = "retracting feet" if design.biped.feet_retract else "feet that swing through"
    transition = "rolls" if design.friction is None else "has Coulomb friction"
    return (f"{design.biped.legs} legs, {feet}, {design.contact.normal_force} force and {design.contact.friction} "
            f"friction, a trailing foot that {transition}, {design.twin.inertia} inertia")  # fmt: skip


def draws(design: Design, count: int, seed: int) -> list[Design]:
    """So many designs that fill a box around one evenly; every other one is drawn with details."""
    keys = [*SPREAD, *DETAILS, *UNEQUAL]
    shares = 2.0 * qmc.LatinHypercube(len(keys), seed=np.random.default_rng(seed)).random(count) - 1.0
    own = scales_of(design.biped, design.slope.gravity)
    found = []
    for number, row in enumerate(shares):
        share: dict[str, float] = dict(zip(keys, row.tolist(), strict=True))
        biped = scaled(design.biped, share)
        found.append(dataclasses.replace(
            design, biped=in_detail(biped, own, share) if number % 2 else biped, slope=scaled(design.slope, share),
            contact=scaled(design.contact, share)))  # fmt: skip
    return found


def scaled(section: S, share: Mapping[str, float]) -> S:
    """Parameters of a file with what is drawn of them as much larger or smaller as its share (-1 to 1) says.

    What the other leg has of its own changes by the same share: legs stay as unlike as they are.
    """
    given: Any = section
    changed: S = dataclasses.replace(given, **{
        name: value * (1.0 + part * share[key]) for key, part in SPREAD.items() for name in (key, f"other_{key}")
        if (value := getattr(given, name, None)) is not None
    })  # fmt: skip
    return changed


def in_detail(biped: Biped, own: Scales, share: Mapping[str, float]) -> Biped:
    """A drawn design with details as large as their shares say, (-1 to 1); hip's springs and dampers only add."""
    changed: dict[str, Any] = {}
    for key, (unit, part) in DETAILS.items():
        some = share[key] if key == "foot_offset" else 0.5 + 0.5 * share[key]
        changed[key] = getattr(biped, key) + part * some * own.size(unit)
    for key, part in UNEQUAL.items():
        changed[key] = biped.number(key) * (1.0 + part * share[key])
    return dataclasses.replace(biped, **changed)
