"""The bill of parts: what a row says, and what makes a row impossible."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from stages.biped.quantity import Bound, Broken, parameter
from stages.twin.machine.shapes import SIZES, size_fault, solid

#: The rigid groups of parts. Frames turn with a pair of legs above the springs, feet slide on them below the springs.
FRAMES = ("inner_frame", "outer_frame")
FEET = ("inner_foot", "outer_foot")

#: A part may be this much heavier than a solid of its material and size, for rounding of its dimensions.
SOLID_MARGIN = 1.05


@dataclass(frozen=True)
class Material:
    """A material by its density."""

    name: str = parameter("-", "name of the material")
    density: float = parameter("kg/m^3", "density", bound=Bound(above=0))


@dataclass(frozen=True)
class Part:
    """One row of the bill: a piece, or a piece and its mirror image in the machine's mid-plane.

    Positions are given with both legs upright and unloaded, from the middle of the hip axis: x forward, y up, z along
    the axis. A foot's piece with z > 0 belongs to the left foot of its pair, with z < 0 to the right one.
    """

    name: str = parameter("-", "name of the part")
    group: str = parameter("-", "rigid group it belongs to", choices=FRAMES + FEET)
    material: str = parameter("-", "material, a row of materials")
    shape: str = parameter("-", "shape", choices=tuple(SIZES))
    axis: str = parameter("-", "axis of the shape", choices=("x", "y", "z"))
    size: tuple[float, ...] = parameter(
        "m",
        "box: x, y, z; cylinder: radius, length; tube: outer radius, inner radius, "
        "length; arc: outer radius, thickness, width, chord; point: none",
    )
    mass: float = parameter("kg", "mass of one piece", bound=Bound(above=0))
    position: tuple[float, ...] = parameter("m", "reference point x, y, z")
    pieces: int = parameter("1", "1, or 2 for a piece and its mirror image", bound=Bound(minimum=1, maximum=2))

    def broken_rules(self) -> Iterator[Broken]:
        """Rules within a row: the size fits the shape, the position is a point, and tells left from right."""
        if len(self.position) != 3:
            yield Broken("position", "three numbers x, y, z")
            return
        wrong_size = size_fault(self.shape, self.size)
        if wrong_size:
            yield Broken("size", f"for a {self.shape} {wrong_size}")
        if self.shape == "arc" and self.axis != "z":
            yield Broken("axis", "z for an arc")
        if self.pieces == 2 and self.position[2] == 0.0:
            yield Broken("position", "z other than 0 for two pieces, which would coincide")
        if self.group in FEET and self.position[2] == 0.0:
            yield Broken("position", "z other than 0, which tells the left foot from the right one")

    @property
    def volume(self) -> float:
        """Volume of one piece [m^3]."""
        return solid(self.shape, self.size, self.axis).volume
