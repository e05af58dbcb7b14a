"""Designs with frames, legs that differ, and springs, friction or a counterweight at the hip: one at a time, and drawn.

Each from far too small to matter to too large to walk.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stages.biped.design import Biped

#: Parameters that a point changes, by their names in the parameter files.
Changes = tuple[tuple[str, Any], ...]

#: Axis, lowest and highest value.
DETAILED_AXES: tuple[tuple[str, float, float], ...] = (
    ("biped.frame_mass", 1e-4, 0.2), ("biped.frame_com", 1e-3, 0.2), ("biped.frame_offset", 1e-5, 1e-2),
    ("biped.frame_inertia", 1e-7, 1e-3), ("biped.foot_offset", 1e-5, 1e-2), ("biped.hip_stiffness", 1e-3, 10.0),
    ("biped.hip_rest_angle", 1e-4, 0.3), ("biped.hip_damping", 1e-5, 0.1), ("biped.hip_friction", 1e-5, 0.1),
    ("hip_friction, rigid legs", 1e-5, 0.1),
    ("counterweight", 1e-3, 0.6), ("longer other leg", 1e-6, 1e-2), ("heavier other leg", 1e-5, 0.5),
    ("stiffer other leg", 1e-4, 1.0), ("rounder other foot", 1e-4, 0.5), ("other frame", 1e-4, 0.2),
)  # fmt: skip
#: The number of the other leg that an axis makes larger, by a share of the first leg's.
LARGER = {"longer other leg": "leg_length", "heavier other leg": "foot_mass", "stiffer other leg": "stiffness",
          "rounder other foot": "foot_radius"}  # fmt: skip
#: A frame for the axes that need one.
FRAME = {"frame_mass": 0.02, "frame_com": 0.03}
#: Draws go by fifties: compliant legs, those with limited friction, rigid legs, and both whose hip rubs.
KINDS: tuple[Changes, ...] = (
    (), (("analytic.transition", "coulomb"),), (("biped.legs", "rigid"),), (("biped.legs", "rigid"),), ())
BLOCK, RUBBING = 50, (3, 4)
SEED = 20
#: Numbers of the other leg that may be drawn apart.
OF_A_LEG = ("leg_length", "foot_radius", "foot_com", "foot_mass", "stiffness", "damping")


def detailed_changes(biped: Biped, axis: str, value: float) -> Changes:
    """The parameters that an axis's value stands for."""
    if axis in LARGER:
        key = LARGER[axis]
        return ((f"biped.other_{key}", getattr(biped, key) * (1.0 + value)),)
    key = axis.removeprefix("biped.").partition(",")[0]
    own: dict[str, Any] = {key: value}
    if key == "counterweight":
        own = {"hip_gravity_mass": biped.hip_mass - value}
    elif key == "other frame":
        own = {**FRAME, "other_frame_mass": value}
    elif "rigid" in axis:
        own = {"legs": "rigid", **own}
    elif key == "hip_rest_angle":
        own = {"hip_stiffness": 0.05, **own}
    elif key.startswith("frame"):
        own = {**FRAME, **own}
    return tuple((f"biped.{name}", number) for name, number in own.items())


def detailed_draw(biped: Biped, number: int) -> Changes:
    """A draw of all details together, of the kind that its number says."""
    generator = np.random.default_rng([SEED, number])
    kind = number // BLOCK % len(KINDS)

    def size(low: float, high: float) -> float:
        return float(f"{np.exp(generator.uniform(np.log(low), np.log(high))):.6g}")

    def either(value: float) -> float:
        return float(value * generator.choice([-1, 1]))

    def sometimes(share: float) -> bool:
        return bool(generator.random() < share)

    own: dict[str, float] = {"leg_inertia": size(1e-6, 1e-3)}
    if sometimes(0.6):
        own |= {"frame_mass": size(1e-4, 0.2), "frame_com": either(size(1e-3, 0.1)),
                "frame_offset": either(size(1e-5, 0.01)), "frame_inertia": size(1e-7, 1e-3)}  # fmt: skip
    if sometimes(0.5):
        own["foot_offset"] = either(size(1e-5, 0.01))
    if sometimes(0.5):
        own |= {"hip_stiffness": size(1e-3, 1.0), "hip_damping": size(1e-5, 1e-2)}
        own["hip_rest_angle"] = either(size(1e-4, 0.1)) if sometimes(0.5) else 0.0
    if sometimes(0.3):
        own["hip_gravity_mass"] = float(f"{biped.hip_mass - size(1e-3, 0.3):.6g}")
    for key in OF_A_LEG:
        if sometimes(0.3):
            own[f"other_{key}"] = float(f"{getattr(biped, key) * (1 + either(size(1e-5, 0.03))):.6g}")
    if kind in RUBBING:
        own["hip_friction"] = size(1e-5, 0.1)
    return (*KINDS[kind], *((f"biped.{key}", value) for key, value in own.items()))
