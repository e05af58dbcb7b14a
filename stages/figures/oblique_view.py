"""A drawing of the machine in oblique projection, as SVG: what is shown where nothing can move."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

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
    return (
        f'<svg viewBox="{box}" role="img" aria-label="Drawing of the twin on its ramp">' + "".join(drawn) + "</svg>"
    )


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
    slide = scene["natural"]["twin"] - scene["twin"]["length"][pair] * units["length"]
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
