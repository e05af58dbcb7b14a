"""The twin from its bill of parts: its bodies as triangles, its poses in a walk, a camera, and how that is painted."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from stages.biped.accuracy.scales import size
from stages.biped.design import Biped
from stages.biped.walk import Walk
from stages.drawing import style
from stages.twin.exports.solids import BLOCK_HEIGHT, Surface, box, piece_place, shown_parts, surface
from stages.twin.machine.parts import Part
from stages.twin.parameters import Settings
from stages.twin.ramp import Ramp

#: Inner and outer pair, as in the paper.
COLOURS = {"inner": style.SECOND, "outer": style.MULTIBODY}
#: Light and dark parts of a pair's colour, by material: metal is pale, rubber nearly black.
TINTS = {"aluminium": 0.45, "steel": 0.45, "acetal": 0.6, "electronics": -0.55, "rubber": -0.7}
#: Facets of a full circle: from near, and where the whole robot is a thumb's length on the page.
FACETS, SMALL = 12, 8
#: Edges longer than this [m], for Table 1's leg, are cut, so that near and far triangles can be sorted by depth.
LONGEST = 0.11


@dataclass(frozen=True)
class Faces:
    """Corners (n, 3, 3) [m], outward normals (n, 3) and colours (n, 3) of triangles."""

    corners: np.ndarray
    normals: np.ndarray
    colours: np.ndarray


def joined(many: Iterable[Faces]) -> Faces:
    """Several as one."""
    every = [Faces(*(np.zeros((0, *shape)) for shape in ((3, 3), (3,), (3,)))), *many]
    return Faces(*(np.concatenate([getattr(one, name) for one in every])
                   for name in ("corners", "normals", "colours")))  # fmt: skip


def tinted(colour: str, tint: float) -> np.ndarray:
    """A colour made pale (tint > 0) or deep (< 0), (3,)."""
    rgb = np.array([int(colour[place : place + 2], 16) for place in (1, 3, 5)]) / 255.0
    return rgb + tint * (0.88 - rgb) if tint > 0.0 else rgb * (1.0 + tint)


def of_twin(settings: Settings, biped: Biped, facets: int = FACETS) -> dict[str, Faces]:
    """The triangles of the twin of a design, as `by_group` has them."""
    return by_group(shown_parts(settings, biped), facets, LONGEST * size(biped))


@cache
def by_group(parts: tuple[Part, ...], facets: int, longest: float = LONGEST) -> dict[str, Faces]:
    """The triangles of each rigid group, both sides of the machine; `facets` of a full circle. Several figures show the
    same: nobody may change them.
    """
    gathered: dict[str, list[Faces]] = {}
    for part in parts:
        made = surface(part, facets)
        if made is None:
            continue
        colour = tinted(COLOURS[part.group.split("_")[0]], TINTS.get(part.material, 0.0))
        for side in (1.0, -1.0)[: part.pieces]:
            gathered.setdefault(part.group, []).append(faces(made.moved(piece_place(part, side)), colour, longest))
    return {group: joined(many) for group, many in gathered.items()}


def faces(made: Surface, colour: np.ndarray, longest: float) -> Faces:
    """A surface as flat triangles of one colour, none with an edge longer than `longest` [m]."""
    corners = cut(made.corners[made.triangles], longest)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = across / np.linalg.norm(across, axis=1)[:, None]
    return Faces(corners, normals, np.broadcast_to(colour, (len(corners), 3)))


def cut(corners: np.ndarray, longest: float) -> np.ndarray:
    """Triangles (n, 3, 3) halved at their longest edge until none is longer."""
    done = []
    while len(corners):
        edge = np.linalg.norm(corners[:, (1, 2, 0)] - corners, axis=2)
        worst = edge.argmax(axis=1)
        long = edge.max(axis=1) > longest
        done.append(corners[~long])
        rows, first = np.arange(len(corners))[long], worst[long]
        a, b, c = (corners[rows, (first + shift) % 3] for shift in range(3))
        middle = 0.5 * (a + b)
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return np.concatenate(done)


LIGHT = np.array([-0.35, 0.75, 0.56])
WOOD, DECK = "#A98C62", "#CDBFA5"
#: Width of the triangles' outlines [points].
OUTLINE = 0.25
#: Height of the deck under the blocks [m], for Table 1's leg.
DECK_HEIGHT = 0.02


@dataclass(frozen=True)
class Pose:
    """Hip [m] and, of each pair, angle of the legs [rad] and how far its feet have moved up into them [m]."""

    hip: np.ndarray
    angle: np.ndarray
    slide: np.ndarray

    def placed(self, body: Faces, group: str) -> Faces:
        """A group's triangles where this pose has them, in the slope frame."""
        pair = int(group.startswith("outer"))
        turn = self.axes(pair)
        lift = np.array([0.0, self.slide[pair] if group.endswith("foot") else 0.0, 0.0])
        place = np.array([*self.hip, 0.0])
        return Faces((body.corners + lift) @ turn.T + place, body.normals @ turn.T, body.colours)

    def point(self, place: tuple[float, ...], group: str) -> np.ndarray:
        """A point fixed to a group, given in the axes of the bill, in the slope frame (3,) [m]."""
        alone = Faces(np.array([[place]], dtype=float), np.zeros((1, 3)), np.zeros((1, 3)))
        return np.asarray(self.placed(alone, group).corners[0, 0])

    def axes(self, pair: int) -> np.ndarray:
        """Axes of a pair of legs as columns (3, 3): forward, up the leg, lateral."""
        sine, cosine = np.sin(self.angle[pair]), np.cos(self.angle[pair])
        return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])

    def robot(self, bodies: Mapping[str, Faces]) -> Faces:
        """All groups in this pose."""
        return joined(self.placed(body, group) for group, body in bodies.items())


def unloaded(settings: Settings, biped: Biped) -> tuple[float, float]:
    """Lengths of the twin's legs unloaded, with their outsoles [m]."""
    first, other = biped.leg_lengths
    return first + settings.outsole, other + settings.outsole


def pose_at(walk: Walk, time: float, natural: Sequence[float]) -> Pose:
    """The pose of a walk at a time [s]; `natural` are the legs' lengths unloaded (2,) [m]."""
    values = [np.array([np.interp(time, walk.time, signal[:, column]) for column in (0, 1)])
              for signal in (walk.hip_position, walk.leg_angle, walk.leg_length)]  # fmt: skip
    return Pose(values[0], values[1], natural - values[2])


def moment(walk: Walk, phase: float) -> float:
    """A time within the step after the second heel strike, or within a walk that has none [s]."""
    strikes = walk.heel_strike_time
    begin, end = strikes[1:3] if len(strikes) > 2 else (walk.time[0], walk.time[-1])
    return float(begin + phase * (end - begin))


def upright(natural: float) -> Pose:
    """The machine standing straight, unloaded."""
    return Pose(np.array([0.0, natural]), np.zeros(2), np.zeros(2))


@dataclass(frozen=True)
class Camera:
    """Turned about the vertical by `azimuth` (positive: from the front) and raised by `elevation`, on a `slope` [rad].

    It sees without perspective; gravity points down the page.
    """

    azimuth: float
    elevation: float
    slope: float

    @property
    def axes(self) -> np.ndarray:
        """Rows: to the right of the page, up the page, towards the eye; columns: axes of the slope frame."""
        sine, cosine = np.sin(self.slope), np.cos(self.slope)
        level = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        sine, cosine = np.sin(self.azimuth), np.cos(self.azimuth)
        turned = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
        sine, cosine = np.sin(self.elevation), np.cos(self.elevation)
        raised = np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]])
        return np.asarray(raised @ turned @ level)

    def page(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the slope frame on the page (..., 2) [m]."""
        return np.asarray(points @ self.axes[:2].T)

    def spot(self, point: np.ndarray, aside: tuple[float, float] = (0.0, 0.0)) -> tuple[float, float]:
        """One point on the page, moved `aside` there."""
        x, y = self.page(point)
        return float(x) + aside[0], float(y) + aside[1]


def blocks(ramp: Ramp, large: float, first: int = 0, last: int | None = None) -> Faces:
    """The stepping blocks from set `first` to `last` (counted from 0), in the slope frame, for a robot so `large`."""
    height = BLOCK_HEIGHT * large
    block = box((ramp.lanes[0].length, height, ramp.width))
    sides = [(number, side * ramp.tracks[number % 2])
             for number in range(ramp.sets)[first : None if last is None else last + 1] for side in (1.0, -1.0)]
    return joined(faces(block.moved((number * ramp.step, -height / 2, z)), tinted(WOOD, 0.0), LONGEST * large)
                  for number, z in sides)  # fmt: skip


def deck(start: float, end: float, half_width: float, large: float) -> Faces:
    """The board under the blocks, from x = start to end [m], for a robot so `large`."""
    middle = (0.5 * (start + end), -(BLOCK_HEIGHT + DECK_HEIGHT / 2) * large, 0.0)
    board = box((end - start, DECK_HEIGHT * large, 2.0 * half_width))
    return faces(board.moved(middle), tinted(DECK, 0.0), LONGEST * large)


def paint(axes: Axes, camera: Camera, layers: Iterable[Faces], *, strength: float = 1.0) -> None:
    """Paint triangles, those of later layers over those of earlier ones, within a layer the nearer over the farther.

    `strength` below 1 makes them pale.
    """
    eye = camera.axes[2]
    light = LIGHT / np.linalg.norm(LIGHT)
    for layer in layers:
        seen = layer.normals @ eye > 1e-9
        corners, normals, colours = layer.corners[seen], layer.normals[seen], layer.colours[seen]
        order = np.argsort((corners @ eye).mean(axis=1), kind="stable")
        bright = 0.62 + 0.38 * np.clip(normals @ (camera.axes.T @ light), 0.0, 1.0)
        shaded = 1.0 - strength * (1.0 - colours * bright[:, None])
        triangles: Any = camera.page(corners[order])
        colours = shaded[order]
        painted = PolyCollection(triangles, facecolors=colours, edgecolors=colours, linewidths=OUTLINE)
        axes.add_collection(painted, autolim=True)


def arrows(axes: Axes, camera: Camera, origin: np.ndarray, frame: np.ndarray, names: tuple[str, ...],
           *, beside: bool = False, **look: Any) -> None:  # fmt: skip
    """The columns of `frame` (3, n) [m] as arrows from a point of the slope frame, each with its name at its end.

    Names stand `beside` the ends where another arrow may go on in the same direction.
    """
    start = camera.spot(origin)
    for column, name in zip(frame.T, names, strict=True):
        end = camera.spot(origin + column)
        axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, **look})
        if name:
            away = np.subtract(end, start)
            x, y = away / np.linalg.norm(away)
            if beside:
                x, y = -y, x
            axes.annotate(name, end, (8.0 * x, 6.0 * y), textcoords="offset points", fontsize=7,
                          color=look.get("color", "black"), ha="left" if x > 0.3 else "right" if x < -0.3 else "center",
                          va="bottom" if y > 0.3 else "top" if y < -0.3 else "center")  # fmt: skip


def frame(axes: Axes) -> None:
    """Equal scales, no axes."""
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.margins(0.01)
    axes.autoscale_view()
