"""The points of the map: one parameter at a time for every model, and draws in which all vary together.

Designs with frames, legs that differ, and springs, friction or a counterweight at the hip are drawn from far too small
to matter to too large to walk.
"""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from stages.biped.design import Biped
from stages.extremes.parameters import (
    COMPILED,
    COULOMB,
    DERIVATIVES,
    DETAILED,
    ENGINES,
    ESTIMATE,
    GAIT,
    JOINTS,
    KNOWING_DETAILS,
    LIMIT,
    MARCH,
    OF_A_GAIT,
    STEP,
    TOGETHER,
    TREE,
    TWIN,
    USUAL,
    Parameters,
)

#: Parameters that a point changes, by their names in the parameter files.
Changes = tuple[tuple[str, Any], ...]
MASS_RATIO, SIZE, LEG_LENGTH, FRICTION = "hip to foot mass", "size, similar", "leg length", "friction"
RIGID_LEGS, RESTITUTION, COUNTERWEIGHT = "slope_deg, rigid legs", "ground.restitution", "counterweight"
SEED = 7
#: Units of the biped's numbers.
UNITS = {field.name: str(field.metadata["unit"]) for field in fields(Biped) if "unit" in field.metadata}
#: Powers of size by which what has a unit grows in designs that walk alike, of the same material.
OF_SIZE = {"m": 1.0, "kg": 3.0, "N/m": 2.0, "N s/m": 2.5, "kg m^2": 5.0, "N m/rad": 4.0, "N m s/rad": 4.5, "N m": 4.0,
           "rad": 0.0, "s": 0.5}
#: Axes that are no part of the draws.
ALONE = (LEG_LENGTH, SIZE, RIGID_LEGS, RESTITUTION, "ground.contact_exponent")


@dataclass(frozen=True)
class Point:
    """What an engine is tried at: the axis it lies on, its value there, and the parameters changed, by name."""

    engine: str
    axis: str
    value: float
    changes: Changes


def decades(low: float, high: float, count: int) -> list[float]:
    """Values evenly spaced by ratio, to three digits."""
    return [float(f"{value:.3g}") for value in np.geomspace(low, high, count)]


#: Axis, lowest and highest value, further values, and the engines it is tried with.
GROUND_FEET, SPRINGS = (COMPILED, TREE, JOINTS, TWIN), (GAIT, COULOMB, COMPILED, TREE, TWIN)
AXES: tuple[tuple[str, float, float, tuple[float, ...], tuple[str, ...]], ...] = (
    ("biped.stiffness", 1e2, 1e10, (), SPRINGS),
    ("biped.damping", 1e-2, 1e5, (0.0,), SPRINGS),
    ("ground.slope_deg", 0.1, 10.0, (0.0, 15.0, 20.0, 30.0, 45.0, 60.0, 80.0), SPRINGS),
    (RIGID_LEGS, 0.1, 10.0, (0.0, 20.0), (GAIT,)),
    ("biped.foot_radius", 1e-3, 0.32, (0.0,), (GAIT, COMPILED, TREE)),
    ("biped.foot_com", 1e-3, 0.32, (0.0,), (GAIT, COMPILED, TREE)),
    ("biped.leg_inertia", 1e-6, 0.1, (), (GAIT, COMPILED, TREE)),
    ("ground.gravity", 1.62, 24.79, (3.71, 9.81), (GAIT, COMPILED, TREE, TWIN)),
    (MASS_RATIO, 1e-4, 1e4, (), (GAIT, COMPILED, TREE, TWIN)),
    (SIZE, 1e-3, 10.0, (), (GAIT, COMPILED, TREE)),
    (LEG_LENGTH, 1e-3, 10.0, (), (GAIT, COMPILED, TREE)),
    (FRICTION, 1e-2, 5.0, (0.0,), (COULOMB, *GROUND_FEET)),
    ("ground.contact_stiffness", 1.0, 1e10, (), GROUND_FEET),
    ("ground.contact_exponent", 1.0, 5.0, (1.5, 2.2), GROUND_FEET),
    ("ground.contact_damping", 1.0, 1e7, (0.0,), GROUND_FEET),
    ("ground.damping_depth", 1e-7, 1e-1, (), (COMPILED, TREE, TWIN)),
    (RESTITUTION, 0.05, 1.0, (), (COMPILED, TREE, TWIN)),
    ("ground.stiction_velocity", 1e-6, 1.0, (), GROUND_FEET),
    ("analytic.tolerance", 1e-14, 1e-2, (), (GAIT, STEP)),
    ("multibody.tolerance", 1e-14, 1e-2, (), (COMPILED, TREE)),
    ("multibody.largest_step", 1e-5, 1e-1, (), (TREE,)),
    ("multibody.impact_step", 1e-6, 1e-4, (), (JOINTS,)),
    ("multibody.rolling_step", 1e-5, 1e-1, (), (JOINTS,)),
    ("twin.tolerance", 1e-14, 1e-2, (), (TWIN,)),
    ("twin.largest_step", 1e-5, 1e-1, (), (TWIN,)),
    ("biped.frame_mass", 1e-4, 0.2, (), (DETAILED,)),
    ("biped.frame_com", 1e-3, 0.2, (), (DETAILED,)),
    ("biped.frame_offset", 1e-5, 1e-2, (), (DETAILED,)),
    ("biped.frame_inertia", 1e-7, 1e-3, (), (DETAILED,)),
    ("biped.foot_offset", 1e-5, 1e-2, (), (DETAILED,)),
    ("biped.hip_stiffness", 1e-3, 10.0, (), (DETAILED,)),
    ("biped.hip_rest_angle", 1e-4, 0.3, (), (DETAILED,)),
    ("biped.hip_damping", 1e-5, 0.1, (), (DETAILED,)),
    ("biped.hip_friction", 1e-5, 0.1, (), (DETAILED,)),
    ("hip_friction, rigid legs", 1e-5, 0.1, (), (DETAILED,)),
    (COUNTERWEIGHT, 1e-3, 0.6, (), (DETAILED,)),
    ("longer other leg", 1e-6, 1e-2, (), (DETAILED,)),
    ("heavier other leg", 1e-5, 0.5, (), (DETAILED,)),
    ("stiffer other leg", 1e-4, 1.0, (), (DETAILED,)),
    ("rounder other foot", 1e-4, 0.5, (), (DETAILED,)),
    ("other frame", 1e-4, 0.2, (), (DETAILED,)),
)
#: The parameter that an axis varies, where it is not called as that; what it changes besides.
VARIED = {RIGID_LEGS: "ground.slope_deg", "hip_friction, rigid legs": "biped.hip_friction",
          "other frame": "biped.other_frame_mass"}  # fmt: skip
RIGID: dict[str, Any] = {"biped.legs": "rigid"}
FRAME: dict[str, Any] = {"biped.frame_mass": 0.02, "biped.frame_com": 0.03}
BESIDE: dict[str, dict[str, Any]] = {
    RIGID_LEGS: RIGID, "hip_friction, rigid legs": RIGID, RESTITUTION: {"ground.normal_force": "restitution"},
    "biped.hip_rest_angle": {"biped.hip_stiffness": 0.05}, "other frame": FRAME,
    **{f"biped.frame_{key}": FRAME for key in ("mass", "com", "offset", "inertia")},
}  # fmt: skip
#: The number of the other leg that an axis makes larger, by a share of the first leg's.
LARGER = {"longer other leg": "leg_length", "heavier other leg": "foot_mass", "stiffer other leg": "stiffness",
          "rounder other foot": "foot_radius"}  # fmt: skip
#: Points an axis has for each engine in the full map, and engines of which the other maps have the middle one of each
#: axis; then, by resolution, draws of all parameters together, steps in a row, and the rigid limit. All points of a map
#: are points of the next one.
FULL = {GAIT: 14, COULOMB: 10, DETAILED: 7, STEP: 13, DERIVATIVES: 7, ESTIMATE: 7, COMPILED: 9, TREE: 7, JOINTS: 5,
        TWIN: 5}  # fmt: skip
COARSE = (GAIT, COULOMB, STEP)
DRAWS: dict[str, dict[str, int]] = {
    "few": {},
    "coarse": {DETAILED: 4, STEP: 12, COMPILED: 4, TREE: 4, TWIN: 1},
    "full": {GAIT: 30, COULOMB: 20, DETAILED: 250, STEP: 1250, DERIVATIVES: 30, ESTIMATE: 30, COMPILED: 40, TREE: 30,
             TWIN: 8},
}
MARCHES = {
    "few": (),
    "coarse": ((1e2, 1e-10), (1e3, 1e-10)),
    "full": ((1e2, 1e-10), (1e3, 1e-10), (1e4, 1e-6), (1e4, 1e-8), (1e4, 1e-10), (1e5, 1e-10)),
}
LIMITS = {"few": (), "coarse": (1e2,), "full": (1.0, 10.0, 1e2, 1e3, 1e4)}


def points(parameters: Parameters) -> tuple[Point, ...]:
    """All points of the resolution that the settings request, engine by engine.

    From a design with details they depart with those models alone that know them.
    """
    resolution = parameters.settings.resolution
    full = resolution == "full"
    found = [Point(engine, USUAL, 1.0, ()) for engine in (FULL if full else COARSE) if engine != DETAILED]
    for axis, low, high, more, engines in AXES:
        for engine in (*engines, *(OF_A_GAIT if full and GAIT in engines else ())):
            even = decades(low, high, FULL[engine])
            middle = [even[len(even) // 2]] if engine in COARSE else []
            values = sorted({*even, *more}) if full else middle
            found += [Point(engine, axis, value, changes(parameters.biped, axis, value)) for value in values]
    for engine, number in DRAWS[resolution].items():
        found += drawn(parameters.biped, engine, number)
    found += [Point(MARCH, f"steps, tolerance {t:g}", n, (("analytic.tolerance", t),)) for n, t in MARCHES[resolution]]
    found += [Point(LIMIT, "stiffer contact", factor, ()) for factor in LIMITS[resolution]]
    engines = KNOWING_DETAILS if parameters.biped.detailed else ENGINES
    return tuple(sorted((point for point in found if point.engine in engines),
                        key=lambda point: ENGINES.index(point.engine)))


def changes(biped: Biped, axis: str, value: float) -> Changes:
    """The parameters, by name, that an axis's value stands for."""
    if axis == MASS_RATIO:  # the sum stays
        foot = biped.total_mass / (value + 2.0)
        return ("biped.hip_mass", value * foot), ("biped.foot_mass", foot)
    if axis in (SIZE, LEG_LENGTH):
        scale = value / biped.leg_length
        powers = {"leg_length": 1.0, "foot_radius": 1.0, "foot_com": 1.0}
        if axis == SIZE:  # as of the same material, walking alike
            powers |= {"hip_mass": 3.0, "foot_mass": 3.0, "stiffness": 2.0, "damping": 2.5, "leg_inertia": 5.0}
        wanted = ("m",) if axis == LEG_LENGTH else OF_SIZE
        powers |= {key: OF_SIZE[UNITS[key]] for key in biped.details if UNITS[key] in wanted}
        return tuple((f"biped.{key}", getattr(biped, key) * scale**power) for key, power in powers.items())
    if axis == FRICTION:
        return ("ground.static_friction", value), ("ground.dynamic_friction", value / 1.1)
    if axis == COUNTERWEIGHT:
        return (("biped.hip_gravity_mass", biped.hip_mass - value),)
    if axis in LARGER:
        return ((f"biped.other_{LARGER[axis]}", getattr(biped, LARGER[axis]) * (1.0 + value)),)
    found = {**BESIDE.get(axis, {}), VARIED.get(axis, axis): value}
    if axis == "ground.stiction_velocity":
        found["ground.friction_velocity"] = max(1.0, 2.0 * value)
    if axis == "multibody.rolling_step":
        found["multibody.impact_step"] = min(1e-5, value)
    return tuple(found.items())


def drawn(biped: Biped, engine: str, number: int) -> list[Point]:
    """Draws of every parameter the engine has, by turns within a factor 2 of the study's and over the whole axes."""
    if engine == DETAILED:
        return [Point(engine, TOGETHER, float(draw), detailed_draw(biped, draw)) for draw in range(number)]
    generator = np.random.default_rng([SEED, len(engine)])
    own = [row for row in AXES if (GAIT if engine in (STEP, *OF_A_GAIT) else engine) in row[4]]
    axes = [row for row in own if row[0] not in ALONE and row[0].split(".")[-1] not in ("tolerance", "largest_step")]
    found = []
    for draw in range(number):
        everything: dict[str, Any] = {}
        for axis, low, high, _, _ in axes:
            inside = float(generator.uniform())
            near = usual(biped, axis) * 4.0 ** (inside - 0.5)
            value = near if draw % 2 == 0 else low * (high / low) ** inside
            everything |= dict(changes(biped, axis, float(f"{value:.6g}")))
        found.append(Point(engine, TOGETHER, float(draw), tuple(everything.items())))
    return found


def usual(biped: Biped, axis: str) -> float:
    """Middle of the nearer draws of an axis."""
    known = {
        "biped.stiffness": biped.stiffness, "biped.damping": biped.damping,
        MASS_RATIO: biped.hip_mass / biped.foot_mass, "biped.foot_radius": biped.foot_radius,
        "biped.foot_com": biped.foot_com, "biped.leg_inertia": 0.03 * biped.foot_mass * biped.leg_length**2,
        "ground.slope_deg": 2.0, "ground.gravity": 9.81, FRICTION: 1.1, "ground.contact_stiffness": 3e5,
        "ground.contact_damping": 3e4, "ground.damping_depth": 1e-4, "ground.stiction_velocity": 0.03,
    }  # fmt: skip
    return known[axis]


#: Draws go by fifties: compliant legs, those with limited friction, rigid legs, and both whose hip rubs.
KINDS: tuple[Changes, ...] = (
    (), (("analytic.transition", "coulomb"),), (("biped.legs", "rigid"),), (("biped.legs", "rigid"),), ())
BLOCK, RUBBING = 50, (3, 4)
DETAILED_SEED = 20
#: Numbers of the other leg that may be drawn apart.
OF_A_LEG = ("leg_length", "foot_radius", "foot_com", "foot_mass", "stiffness", "damping")


def detailed_draw(biped: Biped, number: int) -> Changes:
    """A draw of all details together, of the kind that its number says."""
    generator = np.random.default_rng([DETAILED_SEED, number])
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
