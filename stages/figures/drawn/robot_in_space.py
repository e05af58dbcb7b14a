"""The twin in space on its ramp, walking, with the constraint model as a ghost: what the report opens with.

A fragment of a page without any outside reference. Where a browser has no WebGL, no scripts, or prints, it shows a
drawing of the same machine. Both legs of a pair move as one, as in the walk that the twin hands on.
"""

import dataclasses
import json
from collections.abc import Iterator, Mapping
from importlib.resources import files
from typing import Any

import numpy as np

from stages.biped.accuracy.scales import size
from stages.biped.design import Biped
from stages.biped.quantity import mm
from stages.biped.walk import Walk
from stages.comparison.stride import there
from stages.figures.drawn.gait_animation import frames, resolution
from stages.figures.entry import Entry, Given
from stages.figures.view import COLOURS as PAIRS, TINTS, unloaded
from stages.twin.exports.solids import SOLE, shown_parts, what_is_drawn
from stages.twin.machine.parts import FEET, FRAMES, Part

FRAME_RATE = 120  # Hz: slow motion goes between the frames
#: Half the width of the ramp [m] under a robot of size 1.
WIDE = 0.15
#: The constraint model as on a dark page in `gait_animation`.
COLOURS = {**PAIRS, "ghost": "#56B4E9"}


#: The part of a walk that is shown: its start and end [s], and whether it is a stride, to be shown again and again.
Stretch = tuple[float, float, bool]


def stretch(walk: Walk) -> Stretch:
    """The last stride between heel strikes of leg 0; of a walk that has none, all."""
    strikes = walk.heel_strike_time[walk.heel_strike_leg == 0]
    if len(strikes) < 2:
        return float(walk.time[0]), float(walk.time[-1]), False
    return float(strikes[-2]), float(strikes[-1]), True


def motion(walk: Walk, shown: Stretch, phase: np.ndarray, units: Mapping[str, float]) -> dict[str, Any]:
    """Poses and forces at phases (n,) of a stretch, as `frames` gives them; x from where the stretch begins."""
    start, end, _ = shown
    begin, ahead = (float(np.interp(time, walk.time, walk.hip_position[:, 0])) for time in (start, end))
    moved = dataclasses.replace(walk, hip_position=walk.hip_position - np.array([begin, 0.0]))
    return {"advance": round(ahead - begin, 6)} | frames(moved, start + phase * (end - start), units)


def rows(parts: tuple[Part, ...]) -> list[dict[str, Any]]:
    """Parts as the page takes them: group, shape with its axis and size, place, pieces, and tint of the colour."""
    return [{"group": part.group, "shape": part.shape, "axis": part.axis, "size": list(part.size),
             "place": list(part.position), "pieces": part.pieces, "tint": TINTS.get(part.material, 0.0)}
            for part in parts if part.shape != "point"]  # fmt: skip


def ghost(biped: Biped, number: int) -> tuple[Part, ...]:
    """The constraint model as solids in the mid-plane: a leg above and below its spring, a round foot, and the hip."""
    radius, centre = biped.foot_radii[number], biped.foot_radii[number] - biped.leg_lengths[number]
    middle, large, frame, foot = 0.6 * centre, size(biped), f"ghost_frame_{number}", f"ghost_foot_{number}"

    def part(group: str, shape: str, axis: str, size: tuple[float, ...], height: float) -> Part:
        return Part("", group, "", shape, axis, size, 1.0, (0.0, height, 0.0), 1)

    shown = [
        part(frame, "cylinder", "z", (0.016 * large, 0.03 * large), 0.0),
        part(frame, "cylinder", "y", (0.005 * large, -middle), middle / 2),
        part(foot, "cylinder", "y", (0.007 * large, middle - centre + radius), (middle + centre - radius) / 2),
    ]
    if radius > 0.0:
        shown.append(part(foot, "arc", "z", (radius, 0.1 * radius, 0.03 * large, 2.0 * SOLE * radius), centre))
    return tuple(shown)


def scene(given: Given) -> dict[str, Any]:
    """What the page moves: parts, and the poses of twin and ghost at the same phases of their strides."""
    biped, twin = given.parameters.biped, given.parameters.twin
    walks = {"twin": given.twin.walk, "ghost": given.analytic.walk}
    shown = {name: stretch(walk) for name, walk in walks.items()}
    start, end, is_stride = shown["twin"]
    duration = end - start
    count = max(2, round(FRAME_RATE * duration))
    phase = np.arange(count) / count
    load = np.linalg.norm(given.twin.walk.ground_reaction, axis=2).sum(axis=1)
    units = resolution(biped, given.parameters.slope.gravity)
    return {
        "count": count, "duration": round(duration, 6), "loops": is_stride,
        "units": units, "slope": round(given.parameters.slope.angle, 9),
        "natural": {"twin": list(unloaded(twin, biped)), "ghost": list(biped.leg_lengths)},
        "size": round(max(size(biped), (twin.outer_lane + 0.5 * twin.foot_width) / WIDE), 9),
        "weight": float(np.median(load)) or 1.0,
        "radius": [radius + twin.outsole for radius in biped.foot_radii], "lanes": [twin.inner_lane, twin.outer_lane],
        "groups": [*FRAMES, *FEET], "colours": COLOURS,
        "parts": rows((*shown_parts(twin, biped), *ghost(biped, 0), *ghost(biped, 1))),
        **{name: motion(walk, shown[name], phase, units) for name, walk in walks.items()},
    }  # fmt: skip


def numbers(given: Given) -> list[tuple[str, str, str]]:
    """The three numbers beside the robot: the claim that judges each, the number, and what it is."""
    model, twin = given.analytic.gait.step_frequency_hz, given.twin.settling.frequency_text()
    apart = float(np.max(there(given.comparison.models).same_start.position))
    left = given.analytic.gait.largest_multiplier
    walking = twin if given.twin.outcome == "completed" else given.twin.outcome
    return [
        ("step_frequency", f"{model:.3f} Hz", f"steps a second of the constraint model; the twin: {walking}"),
        ("hip_displacement", mm(apart), "between the hips over a step, constraints against penalty contact"),
        ("stable_gait", f"{left:.2f}", "largest multiplier: what a step leaves of a disturbance"),
    ]


def draw(given: Given) -> str:
    """The scene as a fragment of a page."""
    page = files("stages.figures.drawn").joinpath("robot_in_space.html").read_text(encoding="utf-8")
    moving = scene(given)
    put = {
        "COLOURS": "".join(f"--{name}:{colour};" for name, colour in COLOURS.items()),
        "DRAWING": drawing(moving),
        "NUMBERS": "\n".join(
            f'<li><a href="#claim-{claim}"><b>{number}</b> <span>{what}</span></a></li>'
            for claim, number, what in numbers(given)
        ),
        "SLOPE": f"{np.degrees(given.parameters.slope.angle):.3g}°",
        "DATA": json.dumps(moving, separators=(",", ":")).replace("<", "\\u003c"),
    }
    for mark, text in put.items():
        page = page.replace(f"@{mark}@", text)
    return page


def caption(given: Given) -> str:
    settling, drawn = given.twin.settling, what_is_drawn(given.parameters.twin, given.parameters.biped)
    return (
        f"The last stride of the twin's walk of {given.twin.steps} steps, over and over: {drawn} "
        f"where the walk has it. Its last four steps: {settling.last_four()}. "
        "The ghost is the constraint model at the same phase of its own stride, from the same place. Arrows: force of "
        "the ground, half a pair's on each foot, impacts cut off. Thin rods are no parts: they join what slides."
    )


#: Millimetres of the page from the hip: left, top, width, height; for a robot of size 1.
FRAME = (-360, -110, 720, 500)
CIRCLE = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]


def drawing(scene: Mapping[str, Any]) -> str:
    """The first pose of a scene (`robot_in_space.scene`), gravity pointing down the page."""
    hip = np.array(scene["twin"]["hip"][:2]) * scene["units"]["length"]
    shapes = [
        (place, group, tint, text)
        for row in scene["parts"]
        if not row["group"].startswith("ghost")
        for place, group, tint, text in _pieces(scene, row)
    ]
    ground = _ramp(scene["slope"], hip[1], scene["size"])
    drawn = [ground, *(f'<path class="{group} {tint}" d="{text}"/>' for _, group, tint, text in sorted(shapes))]
    box = " ".join(f"{value * scene['size']:.6g}" for value in FRAME)
    return f'<svg viewBox="{box}" role="img" aria-label="Drawing of the twin on its ramp">' + "".join(drawn) + "</svg>"


def _page(points: np.ndarray, slope: float) -> np.ndarray:
    """Points of the slope frame [m] from the hip, (n, 3), on the page [mm], (n, 2): z comes to the lower left."""
    x = np.cos(slope) * points[:, 0] + np.sin(slope) * points[:, 1]
    y = np.cos(slope) * points[:, 1] - np.sin(slope) * points[:, 0]
    return 1e3 * np.column_stack([x - 0.55 * points[:, 2], -(y - 0.30 * points[:, 2])])


def _ramp(slope: float, height: float, large: float) -> str:
    ends = large * np.array(((-0.27, -0.13), (0.3, -0.13), (0.3, 0.13), (-0.27, 0.13)))
    corners = np.array([[x, -height, z] for x, z in ends])
    return f'<path class="ramp" d="{_path(_page(corners, slope))}"/>'


def _pieces(scene: Mapping[str, Any], row: Mapping[str, Any]) -> Iterator[tuple[float, str, str, str]]:
    """Pieces of a part: depth by which they are sorted, pair, tint, and outline."""
    from scipy.spatial import ConvexHull  # a quarter of a second that no other figure needs

    pair = 0 if row["group"].startswith("inner") else 1
    units = scene["units"]
    turn = scene["twin"]["angle"][pair] * units["angle"]
    slide = scene["natural"]["twin"][pair] - scene["twin"]["length"][pair] * units["length"]
    shift = slide if row["group"].endswith("foot") else 0.0
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    outline, depth = _outline(row)
    x, y, lateral = row["place"]
    flat = (outline + np.array([x, y + shift])) @ rotation.T
    for side in (1.0, -1.0)[: row["pieces"]]:
        middle = side * lateral
        ends = [np.column_stack([flat, np.full(len(flat), middle + end)]) for end in (-depth / 2, depth / 2)]
        back, front = (_page(end, scene["slope"]) for end in ends)
        if row["shape"] == "arc":
            text = _path(back) + _path(front)
        else:
            both = np.vstack([back, front])
            text = _path(both[ConvexHull(both).vertices])
        tint = "pale" if row["tint"] > 0 else "deep" if row["tint"] < 0 else "plain"
        yield round(middle, 6), ("inner", "outer")[pair], tint, text


def _outline(row: Mapping[str, Any]) -> tuple[np.ndarray, float]:
    """Outline of a part from the side (n, 2) about its place, and its depth along z [m]."""
    shape, size, axis = row["shape"], row["size"], row["axis"]
    if shape == "arc":
        outer, thickness, width, chord = size
        turn = np.linspace(-1.0, 1.0, 13) * np.arcsin(min(1.0, 0.5 * chord / outer))
        rim = np.column_stack([np.sin(turn), -np.cos(turn)])
        return np.vstack([outer * rim, (outer - thickness) * rim[::-1]]), width
    if shape == "box":
        across, up, depth = size
    elif axis == "z":
        return size[0] * np.column_stack([np.cos(CIRCLE), np.sin(CIRCLE)]), size[-1]
    else:
        across, up = (size[-1], 2 * size[0]) if axis == "x" else (2 * size[0], size[-1])
        depth = 2 * size[0]
    return 0.5 * np.array([[-across, -up], [across, -up], [across, up], [-across, up]]), depth


def _path(points: np.ndarray) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + "Z"


FIGURES = {
    "robot_in_space": Entry(
        "The digital twin on its ramp",
        -1,
        ("analytic", "twin", "comparison"),
        draw,
        caption,
        claims=("twin_settles", "twin_like_simple", "step_frequency"),
        opens=True,
    )
}
