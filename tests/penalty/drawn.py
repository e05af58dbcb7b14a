"""Contact sets and designs drawn by a seed, for checks of one engine against the other; hard ones are among them."""

import dataclasses
from collections.abc import Iterator

import numpy as np

from stages.biped.design import Biped, Leg
from stages.ground.contact_law import ContactLaw
from stages.ground.laws import NORMAL_FORCES

#: Ranges of the draws, evenly by ratio, around the sets of the study: Adams' defaults to a hundred times as stiff.
RANGES = {
    "contact_stiffness": (3e4, 1e7),
    "contact_damping": (3e3, 1e5),
    "damping_depth": (1e-5, 3e-4),
    "stiction_velocity": (5e-3, 0.2),
    "contact_exponent": (1.5, 3.0),
    "impact_speed": (0.1, 0.5),
    "restitution": (0.1, 0.9),
}
#: A stiffness is that of this exponent: with another, the depth under this force [N] stays what it is.
EXPONENT, FORCE = 2.2, 10.0


def drawn_sets(like: ContactLaw, seed: int, count: int, normal_force: str) -> Iterator[ContactLaw]:
    """So many contact sets with this law of the normal force; friction coefficients are those of `like`."""
    generator = np.random.default_rng([seed, list(NORMAL_FORCES).index(normal_force)])
    for _ in range(count):
        values = {key: float(low * (high / low) ** generator.uniform()) for key, (low, high) in RANGES.items()}
        depth = (FORCE / values["contact_stiffness"]) ** (1.0 / EXPONENT)  # in mm, as the stiffness is
        values["contact_stiffness"] = FORCE / depth ** values["contact_exponent"]
        values["friction_velocity"] = 10.0 * values["stiction_velocity"]
        yield dataclasses.replace(like, normal_force=normal_force, **values)  # type: ignore[arg-type]


#: Ranges of what a detailed design adds, SI units, around what builds of the twin have; the share by which legs differ.
DETAIL_RANGES = {
    "foot_offset": (-8e-3, 8e-3),
    "leg_inertia": (0.0, 1e-3),
    "frame_mass": (0.02, 0.1),
    "frame_com": (0.01, 0.08),
    "frame_offset": (-8e-3, 8e-3),
    "frame_inertia": (0.0, 4e-4),
    "hip_stiffness": (0.0, 0.5),
    "hip_damping": (0.0, 5e-3),
    "hip_friction": (0.0, 5e-3),
    "hip_rest_angle": (-0.05, 0.05),
    "hip_gravity_mass": (0.25, 0.35),
}
LEGS_DIFFER = 0.02


def drawn_designs(like: Biped, seed: int, count: int) -> Iterator[Biped]:
    """So many detailed designs: every detail there is, and every number of the other leg another one."""
    generator = np.random.default_rng(seed)
    names = [field.name for field in dataclasses.fields(Leg)]
    for _ in range(count):
        details = {key: float(generator.uniform(*ends)) for key, ends in DETAIL_RANGES.items()}
        first = dataclasses.replace(like, **details)  # type: ignore[arg-type]
        other = {f"other_{name}": getattr(first, name) * (1.0 + LEGS_DIFFER * float(generator.uniform(-1.0, 1.0)))
                 for name in names}  # fmt: skip
        other["other_leg_length"] = first.leg_length + 1e-3 * float(generator.uniform(-1.0, 1.0))
        yield dataclasses.replace(first, **other)
