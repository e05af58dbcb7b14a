"""The machines between the simple model and the twin, each with one thing more than the one before."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from stages.biped.design import Biped
from stages.twin.machine.machine import FRAME_BODY, Machine, build
from stages.twin.parameters import Settings


@dataclass(frozen=True)
class Rung:
    """A machine, its name, what it has that the one before has not, and whether it is the twin as it walks."""

    name: str
    added: str
    machine: Machine
    is_twin: bool


def rungs(biped: Biped, settings: Settings, outsole: float) -> list[Rung]:
    """All machines in order; `outsole` [m] is the rubber of the last one if the twin itself has none.

    The first two differ from the planar model only out of the plane. With the planar inertia of twin.yaml there are
    no parts to add. Raises ValueError as `build` does.
    """
    bare = dataclasses.replace(settings, outsole=0.0, bearing_friction=0.0, slider_friction=0.0)
    points = build(biped, dataclasses.replace(bare, inertia="planar"))
    found = [
        ("paired legs", "two legs a pair, each with half the spring and mass, on feet without width",
         dataclasses.replace(points, half_width=0.0)),
        ("foot width", "feet are cylinders that touch with two edges", points),
    ]  # fmt: skip
    if settings.inertia == "parts":
        parts = build(biped, bare)
        feet = tuple(points.bodies[i] if i in FRAME_BODY else body for i, body in enumerate(parts.bodies))
        found += [
            ("distributed inertia", "the mass below the springs is spread as in the bill of parts",
             dataclasses.replace(points, bodies=feet)),
            ("leg mass above the spring", "the mass above the springs swings with the legs instead of sitting at the "
             "hip's axis", parts),
        ]  # fmt: skip
    rubbed = build(biped, dataclasses.replace(settings, outsole=0.0))
    if settings.bearing_friction > 0.0 or settings.slider_friction > 0.0:
        found.append(("joint friction", "friction in bearings and sliders", rubbed))
    rubber = settings.outsole or outsole
    soled = build(biped, dataclasses.replace(settings, outsole=rubber))
    found.append(("rubber outsoles", f"{1e3 * rubber:g} mm of rubber: longer legs, wider feet, and its mass", soled))
    twin = build(biped, settings)
    return [Rung(name, added, machine, same(machine, twin)) for name, added, machine in found]


def alike_in_the_plane(one: Machine, other: Machine) -> bool:
    """Whether machines differ in the width of their feet at most, of which motion in the plane knows nothing."""
    return same(one, dataclasses.replace(other, half_width=one.half_width))


def same(one: Machine, other: Machine) -> bool:
    """Whether two machines are equal to the last bit."""
    numbers = ("lane", "radius", "length", "stiffness", "damping")
    return (
        all(np.array_equal(getattr(one, name), getattr(other, name)) for name in numbers)
        and (one.half_width, one.bearing_friction) == (other.half_width, other.bearing_friction)
        and all(
            a.mass == b.mass and np.array_equal(a.centre, b.centre) and np.array_equal(a.inertia, b.inertia)
            for a, b in zip(one.bodies, other.bodies, strict=True)
        )
    )
