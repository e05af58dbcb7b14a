"""glTF: what is seen, moving. One binary file for viewers, with the walk as an animation.

glTF knows no bodies. Masses, springs and the start stand in the `extras` of nodes, for those who look there.
"""

import json
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stages.twin.exports.exported import Exported, Link
from stages.twin.exports.solids import Surface, box, joined, piece_place, surface
from stages.twin.machine.contact import PITCH, ROLL, YAW

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
FLOAT, INTEGER = 5126, 5125
CORNERS, TRIANGLES = 34962, 34963


#: Times (n,) [s] and the coordinates (n, 11) there.
Motion = tuple[np.ndarray, np.ndarray]


@dataclass
class Document:
    """The parts of a file while they are gathered: lists by name, and the binary data they point to."""

    about: dict[str, Any]
    lists: dict[str, list[dict[str, Any]]] = field(
        default_factory=lambda: {name: [] for name in ("nodes", "meshes", "materials", "accessors", "bufferViews")})
    walk: dict[str, list[dict[str, Any]]] = field(default_factory=lambda: {"channels": [], "samplers": []})
    data: bytearray = field(default_factory=bytearray)

    def add(self, kind: str, entry: dict[str, Any]) -> int:
        """Add an entry to a list; its number."""
        self.lists[kind].append(entry)
        return len(self.lists[kind]) - 1

    def child(self, above: int, name: str, **values: Any) -> int:
        """Add a node under another one; its number."""
        number = self.add("nodes", {"name": name, **values})
        self.lists["nodes"][above].setdefault("children", []).append(number)
        return number

    def accessor(self, values: np.ndarray, kind: str, target: int = 0, limits: bool = False) -> int:
        """Add an array (n, components) and give its number."""
        whole = values.dtype.kind in "iu"
        raw = np.ascontiguousarray(values, dtype="<u4" if whole else "<f4")
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "byteLength": raw.nbytes}
        self.data += raw.tobytes()
        count = len(raw) if kind != "SCALAR" else raw.size
        made = {"bufferView": self.add("bufferViews", view | ({"target": target} if target else {})),
                "componentType": INTEGER if whole else FLOAT, "count": count, "type": kind}  # fmt: skip
        if limits:
            table = raw.reshape(count, -1)
            made |= {"min": table.min(axis=0).tolist(), "max": table.max(axis=0).tolist()}
        return self.add("accessors", made)

    def material(self, name: str, colour: tuple[float, float, float], metallic: float, rough: float) -> int:
        """The number of a material, added at its first use."""
        known = [material["name"] for material in self.lists["materials"]]
        if name in known:
            return known.index(name)
        shown = {"baseColorFactor": [*colour, 1.0], "metallicFactor": metallic, "roughnessFactor": rough}
        return self.add("materials", {"name": name, "pbrMetallicRoughness": shown})

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
        return self.add("meshes", {"name": name, "primitives": primitives})

    def animate(self, node: int, path: str, time: int, values: np.ndarray) -> None:
        """Let a node's `path` take values (n, 3 or 4) at the times of an accessor."""
        output = self.accessor(values, "VEC4" if path == "rotation" else "VEC3")
        target = {"sampler": len(self.walk["samplers"]), "target": {"node": node, "path": path}}
        self.walk["samplers"].append({"input": time, "output": output, "interpolation": "LINEAR"})
        self.walk["channels"].append(target)

    def packed(self) -> bytes:
        """The binary file."""
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "bipedstudy", "extras": self.about},
            "scene": 0, "scenes": [{"nodes": [0]}], **self.lists, "buffers": [{"byteLength": len(self.data)}],
        }  # fmt: skip
        if self.walk["channels"]:
            document["animations"] = [{"name": "walk", **self.walk}]
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        binary = bytes(self.data) + b"\0" * (-len(self.data) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def write(exported: Exported, motion: Motion | None = None) -> bytes:
    """The file as bytes; without a motion the pose of the start."""
    hinge, slides = exported.hinge, exported.slides
    made = Document({
        "springs [N/m]": [each.stiffness for each in slides], "dampers [N s/m]": [each.damping for each in slides],
        "hinge: spring [N m/rad], its rest [rad], damper [N m s/rad], friction [N m]": [
            hinge.stiffness, hinge.rest, hinge.damping, hinge.friction],
    })  # fmt: skip
    half = 0.5 * exported.slope.angle
    turn = [0.0, 0.0, -float(np.sin(half)), float(np.cos(half))]
    numbers = [made.add("nodes", {"name": "slope", "rotation": turn})]
    made.child(numbers[0], "ramp", mesh=_ramp(made, exported))
    time = made.accessor(motion[0][:, None], "SCALAR", limits=True) if motion is not None else -1
    for link in exported.links:
        body = link.body
        extras = {"mass [kg]": float(body.mass), "mass centre [m]": body.centre.tolist(),
                  "inertia about it [kg m^2]": body.inertia.tolist()}  # fmt: skip
        number = made.child(numbers[link.parent + 1], link.name, extras=extras)
        numbers.append(number)
        pieces = _pieces(made, link)
        node = made.lists["nodes"][number]
        if pieces:
            node["mesh"] = made.mesh(link.name, pieces)
        for name, place in link.sites:
            made.child(number, name, translation=list(map(float, place)))
        node.update({path: now[0].tolist() for path, now in placing(link, exported.start.position[None, :]).items()})
        if motion is not None:
            for path, values in placing(link, motion[1]).items():
                made.animate(number, path, time, values)
    return made.packed()


def placing(link: Link, q: np.ndarray) -> dict[str, np.ndarray]:
    """A link's `translation` (n, 3) and `rotation` (n, 4), x y z w, on its parent, from coordinates (n, 11)."""
    if link.parent < 0:
        yaw, roll, pitch = (_about(axis, q[:, row]) for axis, row in ((1, YAW), (0, ROLL), (2, PITCH)))
        return {"translation": q[:, :3], "rotation": _times(_times(yaw, roll), pitch)}
    joint = link.joints[0]
    if joint.turns:
        return {"rotation": _about(2, q[:, joint.row])}
    return {"translation": q[:, joint.row, None] * np.array(joint.axis)}


def _about(axis: int, angle: np.ndarray) -> np.ndarray:
    turn = np.zeros((len(angle), 4))
    turn[:, axis], turn[:, 3] = np.sin(0.5 * angle), np.cos(0.5 * angle)
    return turn


def _times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Product of quaternions x y z w, row by row: first b, then a."""
    vector = a[:, 3:] * b[:, :3] + b[:, 3:] * a[:, :3] + np.cross(a[:, :3], b[:, :3])
    return np.column_stack([vector, a[:, 3] * b[:, 3] - (a[:, :3] * b[:, :3]).sum(axis=1)])


def _pieces(made: Document, link: Link) -> dict[int, list[Surface]]:
    """Surfaces of a link's parts by material."""
    found: dict[int, list[Surface]] = {}
    for part, side in link.parts:
        shape = surface(part)
        if shape is None:
            continue
        pair = part.group.split("_")[0]
        colour, metallic, rough = MATERIALS.get(part.material, (None, 0.0, 0.6))
        name = part.material if colour else pair
        number = made.material(name, colour or PAIRS[pair], metallic, rough)
        found.setdefault(number, []).append(shape.moved(piece_place(part, side)))
    return found


def _ramp(made: Document, exported: Exported) -> int:
    blocks, deck = [block for _, block in exported.blocks()], exported.board()
    shapes = {made.material("wood", *WOOD): blocks, made.material("deck", *DECK): [deck]}
    return made.mesh("ramp", {number: [box(shape.sizes["size"]).moved(shape.place) for shape in of_one]
                              for number, of_one in shapes.items()})  # fmt: skip
