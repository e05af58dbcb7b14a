"""glTF: what is seen, moving. One binary file for viewers, with the walk as an animation.

glTF knows no bodies. Masses, springs and the start stand in the `extras` of nodes, for those who look there.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stages.twin.exports.exported import Exported, Link
from stages.twin.exports.solids import Surface, box, joined, piece_place, surface
from stages.twin.machine.contact import HINGE, PITCH, ROLL, YAW

ENDING = "glb"
OF = "viewers, Blender, three.js"
CARRIES = {
    "inertias": "as `extras`, which programs ignore",
    "coordinates": "no: places and turns of nodes",
    "springs and dampers": "no",
    "start": "yes, the pose",
    "sensors": "places only, as nodes",
    "slope": "yes, the first node is tilted",
    "stepping blocks": "yes, as shapes",
    "contact law": "no",
    "friction": "no",
    "rule for scuffing": "no",
    "shape": "yes",
    "motion": "yes, the walk as an animation",
}
#: Base colour, metallic and roughness by what a piece is made of; plastics have the colour of their pair.
PAIRS = {"inner": (0.0, 0.342, 0.171), "outer": (0.672, 0.112, 0.0)}
MATERIALS: dict[str, tuple[tuple[float, float, float] | None, float, float]] = {
    "aluminium": ((0.6, 0.61, 0.63), 0.3, 0.4),  # metal all through is black where a viewer has nothing to mirror
    "steel": ((0.4, 0.41, 0.43), 0.3, 0.45),
    "acetal": ((0.85, 0.85, 0.82), 0.0, 0.5),
    "electronics": ((0.05, 0.08, 0.06), 0.0, 0.6),
    "rubber": ((0.02, 0.02, 0.02), 0.0, 0.9),
}
WOOD, DECK = ((0.27, 0.156, 0.06), 0.0, 0.8), ((0.55, 0.47, 0.35), 0.0, 0.9)
#: Thickness of the board under the blocks [m].
BOARD = 0.01
FLOAT, INTEGER = 5126, 5125
CORNERS, TRIANGLES = 34962, 34963


@dataclass(frozen=True)
class Motion:
    """Coordinates (n, 11) at times (n,) [s]."""

    time: np.ndarray
    position: np.ndarray


@dataclass
class Scene:
    """The parts of a file while they are gathered."""

    about: dict[str, Any]
    nodes: list[dict[str, Any]] = field(default_factory=list)
    meshes: list[dict[str, Any]] = field(default_factory=list)
    materials: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)
    views: list[dict[str, Any]] = field(default_factory=list)
    channels: list[dict[str, Any]] = field(default_factory=list)
    samplers: list[dict[str, Any]] = field(default_factory=list)
    data: bytearray = field(default_factory=bytearray)

    def node(self, name: str, **values: Any) -> int:
        """Add a node; its number."""
        self.nodes.append({"name": name, **values})
        return len(self.nodes) - 1

    def accessor(self, values: np.ndarray, kind: str, target: int = 0, limits: bool = False) -> int:
        """Add an array (n, components) and give its number."""
        whole = values.dtype.kind in "iu"
        raw = np.ascontiguousarray(values, dtype="<u4" if whole else "<f4")
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "byteLength": raw.nbytes}
        self.views.append(view | ({"target": target} if target else {}))
        self.data += raw.tobytes()
        made: dict[str, Any] = {"bufferView": len(self.views) - 1, "componentType": INTEGER if whole else FLOAT,
                "count": len(raw) if kind != "SCALAR" else raw.size, "type": kind}  # fmt: skip
        if limits:
            table = raw.reshape(made["count"], -1)
            made |= {"min": table.min(axis=0).tolist(), "max": table.max(axis=0).tolist()}
        self.accessors.append(made)
        return len(self.accessors) - 1

    def material(self, name: str, colour: tuple[float, float, float], metallic: float, rough: float) -> int:
        """The number of a material, added at its first use."""
        for number, known in enumerate(self.materials):
            if known["name"] == name:
                return number
        shown = {"baseColorFactor": [*colour, 1.0], "metallicFactor": metallic, "roughnessFactor": rough}
        self.materials.append({"name": name, "pbrMetallicRoughness": shown})
        return len(self.materials) - 1

    def mesh(self, name: str, pieces: dict[int, list[Surface]]) -> int:
        """Add a mesh of surfaces by material; its number."""
        primitives = []
        for material, surfaces in pieces.items():
            one = joined(surfaces)
            primitives.append({
                "attributes": {
                    "POSITION": self.accessor(one.corners, "VEC3", CORNERS, limits=True),
                    "NORMAL": self.accessor(one.normals, "VEC3", CORNERS),
                },
                "indices": self.accessor(one.triangles.ravel().astype(int), "SCALAR", TRIANGLES),
                "material": material,
            })  # fmt: skip
        self.meshes.append({"name": name, "primitives": primitives})
        return len(self.meshes) - 1

    def animate(self, node: int, path: str, time: int, values: np.ndarray) -> None:
        """Let a node's `path` take values (n, 3 or 4) at the times of an accessor."""
        kind = "VEC4" if path == "rotation" else "VEC3"
        self.samplers.append({"input": time, "output": self.accessor(values, kind), "interpolation": "LINEAR"})
        self.channels.append({"sampler": len(self.samplers) - 1, "target": {"node": node, "path": path}})

    def packed(self) -> bytes:
        """The binary file."""
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "bipedstudy", "extras": self.about},
            "scene": 0, "scenes": [{"nodes": [0]}], "nodes": self.nodes, "meshes": self.meshes,
            "materials": self.materials, "accessors": self.accessors, "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.data)}],
        }  # fmt: skip
        if self.channels:
            document["animations"] = [{"name": "walk", "channels": self.channels, "samplers": self.samplers}]
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        binary = bytes(self.data) + b"\0" * (-len(self.data) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def write(exported: Exported, motion: Motion | None = None) -> bytes:
    """The file as bytes; without a motion the pose of the start."""
    machine = exported.machine
    scene = Scene({"springs [N/m]": machine.stiffness.tolist(), "dampers [N s/m]": machine.damping.tolist()})
    half = 0.5 * exported.slope.angle
    root = scene.node("slope", rotation=[0.0, 0.0, -float(np.sin(half)), float(np.cos(half))], children=[])
    scene.nodes[root]["children"].append(scene.node("ramp", mesh=_ramp(scene, exported)))
    time = scene.accessor(motion.time[:, None], "SCALAR", limits=True) if motion is not None else -1
    numbers: list[int] = []
    for link in exported.links:
        body = link.body
        extras = {"mass [kg]": float(body.mass), "mass centre [m]": body.centre.tolist(),
                  "inertia about it [kg m^2]": body.inertia.tolist()}  # fmt: skip
        number = scene.node(link.name, extras=extras)
        numbers.append(number)
        above = scene.nodes[root if link.parent < 0 else numbers[link.parent]]
        above.setdefault("children", []).append(number)
        pieces = _pieces(scene, link)
        if pieces:
            scene.nodes[number]["mesh"] = scene.mesh(link.name, pieces)
        for name, place in link.sites:
            scene.nodes[number].setdefault("children", []).append(scene.node(name, translation=list(map(float, place))))
        for path, now in placing(link, exported.start.position[None, :]).items():
            scene.nodes[number][path] = now[0].tolist()
        if motion is not None:
            for path, values in placing(link, motion.position).items():
                scene.animate(number, path, time, values)
    return scene.packed()


def placing(link: Link, q: np.ndarray) -> dict[str, np.ndarray]:
    """A link's `translation` (n, 3) and `rotation` (n, 4), x y z w, on its parent, from coordinates (n, 11)."""
    placed: dict[str, np.ndarray] = {}
    if link.parent < 0:
        yaw, roll, pitch = (_about(axis, q[:, row]) for axis, row in ((1, YAW), (0, ROLL), (2, PITCH)))
        return {"translation": q[:, :3], "rotation": _times(_times(yaw, roll), pitch)}
    for joint in link.joints:
        if joint.row == HINGE:
            placed["rotation"] = _about(2, q[:, HINGE])
        else:
            placed["translation"] = q[:, joint.row, None] * np.array(joint.axis)
    return placed


def _about(axis: int, angle: np.ndarray) -> np.ndarray:
    turn = np.zeros((len(angle), 4))
    turn[:, axis], turn[:, 3] = np.sin(0.5 * angle), np.cos(0.5 * angle)
    return turn


def _times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Product of quaternions x y z w, row by row: first b, then a."""
    vector = a[:, 3:] * b[:, :3] + b[:, 3:] * a[:, :3] + np.cross(a[:, :3], b[:, :3])
    return np.column_stack([vector, a[:, 3] * b[:, 3] - (a[:, :3] * b[:, :3]).sum(axis=1)])


def _pieces(scene: Scene, link: Link) -> dict[int, list[Surface]]:
    """Surfaces of a link's parts by material."""
    found: dict[int, list[Surface]] = {}
    for part, side in link.parts:
        made = surface(part)
        if made is None:
            continue
        pair = part.group.split("_")[0]
        colour, metallic, rough = MATERIALS.get(part.material, (None, 0.0, 0.6))
        name = part.material if colour else pair
        number = scene.material(name, colour or PAIRS[pair], metallic, rough)
        found.setdefault(number, []).append(made.moved(piece_place(part, side)))
    return found


def _ramp(scene: Scene, exported: Exported) -> int:
    size = exported.block_size
    blocks = [box(size).moved((x, top - size[1] / 2, z)) for x, top, z in (each.middle for each in exported.blocks())]
    span = (exported.ramp.sets - 1) * exported.ramp.step
    board = (span + 2.0 * size[0], BOARD, 2.0 * (exported.ramp.tracks[1] + size[2]))
    deck = box(board).moved((span / 2, -size[1] - BOARD / 2, 0.0))
    return scene.mesh("ramp", {scene.material("wood", *WOOD): blocks, scene.material("deck", *DECK): [deck]})
