"""The parts of the bill: their simple shapes with volume, centroid and inertia, what a row says, and what makes a row
impossible.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from stages.biped.quantity import Bound, Broken, parameter
from stages.biped.rubber import ring_sector

Triple = tuple[float, float, float]

#: What the entries of a part's size mean, by shape [m].
SIZES: dict[str, tuple[str, ...]] = {
    "box": ("length x", "length y", "length z"),
    "cylinder": ("radius", "length"),
    "tube": ("outer radius", "inner radius", "length"),
    "arc": ("outer radius", "thickness", "width", "chord"),
    "point": (),
}


@dataclass(frozen=True)
class Solid:
    """Volume [m^3], centroid [m] from the shape's reference point, and mean squares of x, y, z about it [m^2].

    The reference point is the centre, for an arc the axis of its cylinder. The tensor of inertia of a mass m is
    m diag(y2 + z2, z2 + x2, x2 + y2).
    """

    volume: float
    centroid: Triple
    mean_square: Triple

    def inertia(self, mass: float) -> Triple:
        """Principal moments of inertia about the centroid [kg m^2] for axes x, y, z."""
        x2, y2, z2 = self.mean_square
        return mass * (y2 + z2), mass * (z2 + x2), mass * (x2 + y2)


def size_fault(shape: str, size: tuple[float, ...]) -> str:
    """What is wrong with the size of a shape, "" if nothing."""
    names = SIZES[shape]
    if len(size) != len(names):
        return f"{len(names)} numbers ({', '.join(names)})"
    if any(not value > 0.0 for value in size):
        return "positive lengths only"
    if shape == "tube" and size[1] >= size[0]:
        return "an inner radius below the outer radius"
    if shape == "arc" and size[1] > size[0]:
        return "a thickness of at most the outer radius"
    if shape == "arc" and size[3] > 2.0 * size[0]:
        return "a chord of at most the diameter"
    return ""


def solid(shape: str, size: tuple[float, ...], axis: str = "z") -> Solid:
    """The shape with its axis (of rotation; a box has none) along a coordinate axis.

    An arc is a sector of a thick ring about z, symmetric to and open towards -y: a foot's rim.
    """
    if shape == "point":
        return Solid(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    if shape == "box":
        x, y, z = size
        return Solid(x * y * z, (0.0, 0.0, 0.0), (x * x / 12, y * y / 12, z * z / 12))
    if shape == "arc":
        return _arc(*size)
    outer, inner, length = (size[0], 0.0, size[1]) if shape == "cylinder" else size
    across, along = (outer**2 + inner**2) / 4, length**2 / 12
    squares = tuple(along if name == axis else across for name in "xyz")
    return Solid(math.pi * (outer**2 - inner**2) * length, (0.0, 0.0, 0.0), squares)  # type: ignore[arg-type]


def _arc(outer: float, thickness: float, width: float, chord: float) -> Solid:
    rim = ring_sector(outer, thickness, math.asin(0.5 * chord / outer))
    return Solid(rim.area * width, (0.0, -rim.depth, 0.0), (rim.across, rim.along, width**2 / 12))


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
        """Rules within a row: the size fits the shape, the position is a point, and distinguishes left from right."""
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
            yield Broken("position", "z other than 0, which distinguishes the left foot from the right one")

    @property
    def volume(self) -> float:
        """Volume of one piece [m^3]."""
        return solid(self.shape, self.size, self.axis).volume
