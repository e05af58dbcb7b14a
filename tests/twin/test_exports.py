"""The twin's exports, loaded again by other programs: bodies, flight and sensors as Exudyn's, and MuJoCo's walk."""

import dataclasses
import json
import re
import shutil
import struct
import subprocess
from xml.etree import ElementTree

import numpy as np
import pytest

from stages.ground.friction import normal_force, static_penetration
from stages.twin.exports import gltf, mjcf, sdf, urdf
from stages.twin.exports.exported import NAMES, exported as begun
from stages.twin.exports.formats import FORMATS
from stages.twin.exports.solids import shown_parts, surface
from stages.twin.machine.contact import COUNT, SLIDE
from stages.twin.machine.machine import join
from stages.twin.machine.parts import solid
from stages.twin.machine.projection import machine_of
from stages.twin.questions.export import FORMATS as OFFERED, values
from stages.twin.walking.record import find_events, pair_axes, point_motion
from tests import commands
from tests.changed import changed
from tests.twin.peers import PEERS

RATES = np.array([0.2, 0.5, -0.1, 0.4, -0.3, 0.8, 0.02, -0.03, -1.1, 0.01, 0.04])


@pytest.fixture(scope="module")
def exported(parameters):
    return begun(parameters)


@pytest.fixture(scope="module")
def flight(machine, fly):
    """A tumbling flight with springs and dampers."""
    return fly(machine, RATES)


def some(flight):
    """Coordinates, rates and accelerations at every 20th step of the solver, the first left out."""
    return flight.position[20::20], flight.velocity[20::20], flight.acceleration[20::20]


def test_every_format_says_the_same_things_of_itself():
    assert len({tuple(each.CARRIES) for each in FORMATS.values()}) == 1


def test_links_are_the_bodies_of_the_machine(exported):
    links, machine = exported.links, exported.machine
    assert [joint.name for link in links for joint in link.joints] == list(NAMES)
    for link, body in zip(links, machine.bodies, strict=True):
        assert link.body is body
    pieces = sum(len(link.parts) for link in links)
    assert pieces == sum(part.pieces for part in exported.seen) > sum(part.pieces for part in exported.settings.parts)
    bill = [part.mass for link in links for part, _ in link.parts if part.name != "guide"]
    assert sum(bill) == pytest.approx(machine.mass, abs=1e-4)


@pytest.mark.parametrize("of_a_kind", ["box", "cylinder", "tube", "arc"])
def test_surfaces_enclose_the_volume_and_centroid_of_their_shape(settings, of_a_kind):
    """Divergence theorem over the triangles; facets lie inside of a round shape by less than a per cent."""
    for part in (each for each in settings.parts if each.shape == of_a_kind):
        made = surface(part)
        a, b, c = (made.corners[made.triangles[:, k]] for k in range(3))
        pyramids = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
        shape = solid(part.shape, part.size, part.axis)
        assert pyramids.sum() == pytest.approx(shape.volume, rel=1e-12 if of_a_kind == "box" else 7e-3)
        centroid = ((a + b + c) / 4 * pyramids[:, None]).sum(axis=0) / pyramids.sum()
        assert abs(centroid - shape.centroid).max() < 2e-3 * max(part.size)
        normal = np.cross(b - a, c - a)
        assert (np.einsum("ij,ij->i", normal, made.normals[made.triangles[:, 0]]) > 0.0).all()


@pytest.fixture(scope="module")
def in_mujoco(exported):
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    return mujoco, mujoco.MjModel.from_xml_string(mjcf.write(exported).decode())


#: Other bipeds, their parts or points, and their settings.
OWN = (
    {"inertia": "planar", "leg_length": 0.5, "foot_radius": 0.125, "foot_com": 0.15},
    {"inertia": "planar", "leg_length": 0.1, "foot_radius": 0.02, "foot_com": 0.03, "hip_mass": 0.01,
     "foot_mass": 0.02},
    {"inertia": "planar", "leg_inertia": 0.004},
    {"inertia": "planar", "legs": "rigid", "foot_radius": 0.0},
    {"leg_length": 1.2, "foot_radius": 1e-7, "foot_com": 0.0, "hip_mass": 20.0},
    {"legs": "rigid", "hip_mass": 0.0, "leg_inertia": 0.01},
    {"legs": "rigid"},
    {},
    {"outsole": 0.002},
    {"other_leg_length": 0.33, "other_foot_radius": 0.08, "other_stiffness": 2700.0, "frame_mass": 0.05,
     "frame_com": 0.1, "frame_offset": 0.002, "foot_offset": 0.003, "hip_stiffness": 0.05, "hip_rest_angle": 0.02,
     "hip_damping": 0.002, "hip_friction": 0.01},
    {"inertia": "planar", "leg_inertia": 2e-3, "other_foot_mass": 0.35, "frame_mass": 0.1, "frame_com": 0.06,
     "frame_inertia": 8e-4, "hip_mass": 0.2},
)  # fmt: skip


@pytest.fixture
def of_ones_own(exported, parameters):
    """What is exported of another biped; its start and its ramp are those of Table 1."""

    def other(own):
        given = changed(parameters, **own)
        machine, seen = machine_of(given.biped, given.settings), shown_parts(given.settings, given.biped)
        return dataclasses.replace(exported, settings=given.settings, machine=machine, seen=seen)

    return other


@pytest.mark.parametrize("own", OWN)
def test_mujoco_loads_a_biped_of_ones_own(of_ones_own, own):
    """Table 1's too. Point masses, point feet, frames without mass: masses, mass centres and start within 1e-9 of the
    machine's."""
    mujoco, given = pytest.importorskip("mujoco", reason="MuJoCo is not installed"), of_ones_own(own)
    model, machine = mujoco.MjModel.from_xml_string(mjcf.write(given).decode()), given.machine
    assert model.nv == (7 if machine.rigid else COUNT)
    assert model.body_mass.sum() == pytest.approx(machine.mass, abs=1e-9)
    bodies = (join(machine.bodies[:3]), join(machine.bodies[3:])) if machine.rigid else machine.bodies
    for link, body in zip(given.links, bodies, strict=True):
        number = model.body(link.name).id
        assert model.body_mass[number] == pytest.approx(body.mass, abs=1e-9)
        assert model.body_ipos[number] == pytest.approx(body.centre, abs=1e-9)
    start = [numbers for _, *numbers in given.coordinates()]
    assert np.transpose([model.key_qpos[0], model.key_qvel[0]]) == pytest.approx(np.array(start), abs=1e-9)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    assert np.isfinite(data.qacc).all()


def accelerations_in(program, exported):
    """Those of the program, which must be installed."""
    package, peer = PEERS[program]
    pytest.importorskip(package, reason=f"{program.split(',')[0]} is not installed")
    return peer(exported)


@pytest.mark.parametrize("program", [name for name in PEERS if "MuJoCo" not in name])
@pytest.mark.parametrize("own", [own for own in OWN if "legs" not in own])
def test_others_load_it_too(of_ones_own, program, own):
    assert np.isfinite(accelerations_in(program, of_ones_own(own))(np.zeros(COUNT), np.zeros(COUNT))).all()


@pytest.mark.parametrize("own", [{}, {**OWN[-2], "hip_friction": 0.0}, OWN[-1]],
                         ids=["the twin", "with all details", "without parts"])
@pytest.mark.parametrize("program", PEERS)
def test_it_flies_as_in_exudyn(of_ones_own, fly, program, own):
    """Masses, inertias, axes, springs and dampers: every acceleration along a tumbling flight."""
    given = of_ones_own(own)
    accelerations, flown = accelerations_in(program, given), fly(given.machine, RATES)
    for q, v, a in zip(*some(flown), strict=True):
        assert abs(accelerations(q, v) - a).max() < 1e-9 * abs(a).max()


def test_springs_and_dampers_of_legs_are_told_where_there_are_some(of_ones_own):
    for own in ({"legs": "rigid"}, {"legs": "rigid", "hip_stiffness": 0.05}, {}):
        given, there = of_ones_own(own), "legs" not in own
        about = unpacked(gltf.write(given))[0]["asset"]["extras"]
        assert any("leg" in each for each in values(given, "springs and dampers")) == there
        assert len(about["springs [N/m]"]) == len(about["dampers [N s/m]"]) == 4 * there


def test_friction_at_the_hinge_stands_in_every_format(of_ones_own):
    given = of_ones_own(OWN[-2])
    roots = {form: ElementTree.fromstring(form.write(given)) for form in (mjcf, urdf, sdf)}
    found = {
        roots[mjcf].find(".//joint[@name='hinge']").get("frictionloss"),
        roots[urdf].find(".//joint[@name='hinge']/dynamics").get("friction"),
        roots[sdf].find(".//joint[@name='hinge']/axis/dynamics/friction").text,
    }
    assert found == {"0.01"}
    (hinge,) = (value for key, value in unpacked(gltf.write(given))[0]["asset"]["extras"].items() if "hinge" in key)
    assert hinge == [0.05, -0.02, given.machine.bearing_friction, 0.01]


def test_ground_without_friction_has_none_and_a_restitution_has_its_own_damping(exported):
    def numbers(**changes):
        given = dataclasses.replace(exported, contact=dataclasses.replace(exported.contact, **changes))
        soft = ElementTree.fromstring(sdf.write(given)).find(".//surface")
        touches = ElementTree.fromstring(mjcf.write(given)).find(".//geom[@condim='3']")
        mus = {soft.find(".//mu").text, soft.find(".//mu2").text, touches.get("friction").split()[0]}
        return {*map(float, mus)}, float(soft.find(".//kd").text)

    law, weight = exported.contact, exported.machine.mass * exported.slope.gravity
    assert numbers() == ({law.static_friction}, 0.5 * law.contact_damping)
    assert numbers(friction="none")[0] == {0.0}
    damping = numbers(normal_force="restitution")[1]
    bouncing, rate = dataclasses.replace(law, normal_force="restitution"), 1e-6
    depth = static_penetration(bouncing, weight)
    rise = (normal_force(bouncing, depth, rate) - normal_force(bouncing, depth, -rate)) / (2 * rate)
    assert damping == pytest.approx(0.5 * rise, rel=1e-6)


def test_mujoco_sensors_feel_what_sockets_feel(in_mujoco, exported, flight, settings):
    """Axes of a site are those of its body: forward, up the leg, lateral."""
    mujoco, model = in_mujoco
    data = mujoco.MjData(model)
    q, v, a = some(flight)
    axes = pair_axes(q, v, a, 0)
    gravity = np.array([*exported.slope.gravity_vector, 0.0])
    foot = settings.foot_sensor(exported.machine.drawn_foot_com)
    for name, place, slide in (("hip", settings.hip_socket, None), ("foot", foot, SLIDE[0])):
        felt = axes.components(point_motion(q, v, a, axes, np.array(place), slide).acceleration - gravity)
        for row, (position, rate) in enumerate(zip(q, v, strict=True)):
            data.qpos[:], data.qvel[:] = position, rate
            mujoco.mj_forward(model, data)
            force, spin = (data.sensor(f"{name} sensor {kind}").data for kind in ("specific force", "angular velocity"))
            assert abs(force - felt[row]).max() < 1e-8
            assert abs(spin - axes.components(axes.spin)[row]).max() < 1e-12


def test_mujoco_walks_over_every_set_of_blocks(in_mujoco, exported, three_steps):
    """Its contact is another than the study's: a step lasts as long as the twin's on its own ground within 2 %."""
    mujoco = in_mujoco[0]
    model = mujoco.MjModel.from_xml_string(mjcf.write(exported, mjcf.Ground(0.004, 1.0, 5e-4)).decode())
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    names = [model.geom(number).name for number in range(model.ngeom)]
    block = np.array([int(name.split()[1]) if name.startswith("block") else 0 for name in names])
    first = {}
    while exported.ramp.sets not in first and data.time < 8.0:
        mujoco.mj_step(model, data)
        for number in block[data.contact.geom].max(axis=1).tolist():
            first.setdefault(number, data.time)
    assert set(first) == set(range(1, exported.ramp.sets + 1))
    step = np.diff([first[number] for number in sorted(first)])[2:].mean()
    assert step == pytest.approx(np.diff(find_events(three_steps).heel_strike_time).mean(), rel=0.02)
    assert abs(data.qpos[3:5]).max() < 1e-2


def test_blocks_are_level_with_the_ground_and_lie_on_the_deck(exported):
    def ends(shape):
        half = 0.5 * np.array(shape.sizes["size"])
        return shape.place - half, shape.place + half

    below, above = ends(exported.board())
    for low, high in (ends(block) for _, block in exported.blocks()):
        assert high[1] == pytest.approx(0.0, abs=1e-12) and low[1] == pytest.approx(above[1])
        assert (low[[0, 2]] >= below[[0, 2]]).all() and (high[[0, 2]] <= above[[0, 2]]).all()


def test_numbers_of_the_xml_are_read_as_the_same_bits(exported, machine):
    for form in (urdf, sdf, mjcf):
        root = ElementTree.fromstring(form.write(exported))
        found = {float(each.get("value") or each.get("mass") or each.text or 0) for each in root.iter()
                 if each.tag == "mass" or each.get("mass")}  # fmt: skip
        assert found - {0.0} == {float(body.mass) for body in machine.bodies}


@pytest.mark.parametrize("form, link_is, seen_is", [
    (urdf, "link", "visual"), (sdf, "link", "visual"), (mjcf, "body", "geom")])
def test_every_part_is_seen_on_its_link(exported, form, link_is, seen_is):
    """But points, which have no size, and what touches in MuJoCo, which is transparent."""
    of_name = {each.get("name").replace("_", " "): each.findall(seen_is)
               for each in ElementTree.fromstring(form.write(exported)).iter(link_is)}  # fmt: skip
    for link in exported.links:
        seen = [each for each in of_name[link.name] if each.get("rgba") != "0 0 0 0"]
        assert len(seen) == sum(part.shape != "point" for part, _ in link.parts) > 0


def test_mujoco_shows_each_part_as_large_as_it_is(in_mujoco, exported):
    """Halves of what its surface takes up along the axes of its link. The mesh of an outsole MuJoCo turns by itself."""
    mujoco, model = in_mujoco
    for link in exported.links:
        body = model.body(link.name)
        geoms = np.arange(body.geomnum[0]) + body.geomadr[0]
        parts = [part for part, _ in link.parts if part.shape != "point"]
        for number, part in zip(geoms[model.geom_group[geoms] == 1], parts, strict=True):
            turn = np.zeros(9)
            mujoco.mju_quat2Mat(turn, model.geom_quat[number])
            half = abs(turn.reshape(3, 3)) @ model.geom_aabb[number, 3:]
            if part.shape != "arc":
                np.testing.assert_allclose(half, 0.5 * np.ptp(surface(part).corners, axis=0), rtol=1e-9)


@pytest.fixture(scope="module")
def animated(exported, three_steps):
    time = np.linspace(0.0, three_steps.time[-1], 50)
    return gltf.write(exported, (time, three_steps.at(time)[0])), three_steps, time


def unpacked(content):
    """The document of a binary file, and a function that reads an accessor."""
    magic, version, size = struct.unpack_from("<4sII", content)
    length = struct.unpack_from("<I", content, 12)[0]
    assert (magic, version, size) == (b"glTF", 2, len(content))
    document, binary = json.loads(content[20 : 20 + length]), content[28 + length :]

    def values(number):
        accessor = document["accessors"][number]
        view = document["bufferViews"][accessor["bufferView"]]
        kind = {5126: "<f4", 5125: "<u4"}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        return np.frombuffer(binary, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)

    return document, values


def turned(quaternion, vector):
    x, w = quaternion[..., :3].astype(float), quaternion[..., 3:].astype(float)
    return vector + 2 * np.cross(x, np.cross(x, vector) + w * vector)


def test_gltf_moves_its_nodes_as_the_walk_does(animated, machine):
    content, record, time = animated
    document, values = unpacked(content)
    names = [node["name"] for node in document["nodes"]]
    moving = {}
    animation = document["animations"][0]
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        assert abs(values(sampler["input"])[:, 0] - time).max() < 1e-6
        moving[names[channel["target"]["node"]], channel["target"]["path"]] = values(sampler["output"])
    q, v = record.at(time)
    place = machine.bodies[4].centre
    expected = point_motion(q, v, 0 * q, pair_axes(q, v, 0 * q, 1), place, SLIDE[2]).position
    in_frame = turned(moving["outer frame", "rotation"], place + moving["outer left foot", "translation"])
    found = moving["inner frame", "translation"] + turned(moving["inner frame", "rotation"], in_frame)
    assert abs(found - expected).max() < 1e-6
    masses = [node["extras"]["mass [kg]"] for node in document["nodes"] if "extras" in node]
    assert masses == [body.mass for body in machine.bodies]


def test_gltf_states_the_bounds_of_each_component(animated):
    """Of positions and times always, which glTF 2.0 demands in 3.7.2.1 and 3.11."""
    document, values = unpacked(animated[0])
    told = {number for number, accessor in enumerate(document["accessors"]) if "min" in accessor}
    drawn = {each["attributes"]["POSITION"] for mesh in document["meshes"] for each in mesh["primitives"]}
    assert told >= drawn | {each["input"] for each in document["animations"][0]["samplers"]}
    for number in told:
        bounds = document["accessors"][number]
        assert bounds["min"] == values(number).min(axis=0).tolist()
        assert bounds["max"] == values(number).max(axis=0).tolist()


def test_gltf_is_read_by_others(animated, tmp_path):
    pygltflib = pytest.importorskip("pygltflib", reason="pygltflib is not installed")
    (tmp_path / "twin.glb").write_bytes(animated[0])
    loaded = pygltflib.GLTF2().load(tmp_path / "twin.glb")
    assert [node.name for node in loaded.nodes][:2] == ["slope", "ramp"] and len(loaded.animations[0].channels) == 7


def test_gltf_satisfies_the_khronos_validator(animated, tmp_path):
    """The validator is a package of Node: `npm install gltf-validator`, found by NODE_PATH."""
    node = shutil.which("node")
    if node is None or subprocess.run([node, "-e", "require('gltf-validator')"], capture_output=True).returncode:
        pytest.skip("Node's package gltf-validator is not installed")
    (tmp_path / "twin.glb").write_bytes(animated[0])
    script = ("const bytes = new Uint8Array(require('fs').readFileSync('twin.glb'));"
              "require('gltf-validator').validateBytes(bytes).then(r => console.log(JSON.stringify(r.issues)))")
    done = subprocess.run([node, "-e", script], cwd=tmp_path, capture_output=True, check=True)
    issues = json.loads(done.stdout)
    assert issues["numErrors"] == issues["numWarnings"] == 0, issues["messages"]


# --- `bipedstudy export twin`: the file, what is said of it, and what is refused.


@pytest.fixture
def export(repository, tmp_path):
    def export(*arguments):
        done = commands.afresh("export", *arguments, cwd=repository)
        assert "Traceback" not in done.stderr
        return done.returncode, done.stdout, done.stderr

    return export


def test_every_format_is_offered():
    assert tuple(FORMATS) == OFFERED


@pytest.mark.slow
def test_it_writes_the_file_and_says_what_it_lacks(export, tmp_path, parameters):
    path = tmp_path / "twin.urdf"
    code, out, errors = export("twin", "--format", "urdf", "--out", path)
    assert (code, errors) == (0, "") and path.read_bytes().startswith(b"<?xml")
    words = " ".join(out.split())
    assert f"each leg {0.5 * parameters.biped.stiffness:g} N/m" in words
    assert all(len(line) <= 80 for line in out.splitlines() if path.name not in line)  # a path is not folded
    assert export("twin", "--format", "urdf", "--out", path)[0] == 2


@pytest.mark.slow
def test_its_answer_as_json_with_other_parameters(export, tmp_path):
    path = tmp_path / "twin.xml"
    _, out, _ = export("twin", "--format", "mjcf", "--out", path, "--set", "ground.block_sets=5", "--json")
    told = json.loads(out)
    assert told["bytes"] == path.stat().st_size and told["carries"] == FORMATS["mjcf"].CARRIES
    assert told["start"]["hinge"]["rate"] > 0.0
    assert path.read_text().count('name="block') == 10


@pytest.mark.slow
def test_of_a_walk_on_the_plane_the_ramp_has_its_sets_of_blocks_and_is_as_long_as_they_need(export, tmp_path):
    settings = ("--set", "twin.ramp_length=0.1", "--set", "ground.block_sets=4")
    assert export("twin", "--format", "mjcf", "--out", tmp_path / "twin.xml", *settings)[0] == 0
    assert (tmp_path / "twin.xml").read_text().count('name="block') == 2 * 4


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        (("robot", "--format", "urdf"), 2, 'WHAT = "robot" is not allowed; allowed: twin'),
        (("twin",), 2, "Missing option '--format'"),
        (("twin", "--format", "usd"), 2, '--format = "usd" is not allowed; allowed: mjcf, urdf, sdf, gltf'),
        (("twin", "--format", "urdf", "--set", "twin.scene=ramp", "--set", "twin.ramp_length=1.5"), 3,
         "twin.ramp_length = 1.5 m is not allowed for steps of"),
        (("twin", "--format", "urdf", "--set", "ground.slope_deg=0"), 3, "no periodic gait: on level ground"),
        (("twin", "--format", "urdf", "--set", "biped.hip_gravity_mass=0.3"), 3,
         "no exported format knows a weight without a mass (hip_gravity_mass)"),
    ],
)
def test_what_is_refused_leaves_no_file(export, tmp_path, arguments, code, sentence):
    done, out, errors = export(*arguments, "--out", tmp_path / "file")
    said = [line for line in errors.splitlines() if not re.match(r"warning: |\d+ %: ", line)]  # how far it is, if slow
    assert (done, out) == (code, "") and len(said) == 1 and sentence in said[0]
    assert not list(tmp_path.iterdir())
