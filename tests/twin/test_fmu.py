"""The walker as a Functional Mock-up Unit: valid, of the compiled walker's equations, and walking as that walks."""

import ctypes
import dataclasses
import json
import zipfile
from functools import partial

import numpy as np
import pytest

from stages.biped.kinematics import specific_force
from stages.biped.question import WrongOption
from stages.penalty.model.walker import build_penalty
from stages.penalty.motion import feet
from stages.penalty.motion.engine import readings
from stages.penalty.walk import Settings, foot_acceleration, simulate
from stages.planar.run import FALLEN, PlanarState
from stages.planar.sampling import find_events
from stages.twin.exports.fmu import package
from tests import commands
from tests.similar import similar

try:
    package.compiler()
except WrongOption as reason:
    pytest.skip(str(reason), allow_module_level=True)

#: Tolerances of a solver, and of the walk that it is compared with.
TOLERANCE, TIGHT = 1e-9, 1e-12
ANY = PlanarState((0.0, 0.33), (0.7, 0.0), (0.0, 0.1), (-2.0, 1.0), (0.33, 0.33), (0.0, 0.0), (True, False))
DETAILS = {
    "frame_mass": 0.05, "frame_com": 0.05, "frame_offset": 0.003, "frame_inertia": 1e-4, "foot_offset": 0.004,
    "hip_stiffness": 0.2, "hip_rest_angle": 0.03, "hip_damping": 0.002, "hip_friction": 0.003, "hip_gravity_mass": 0.3,
    "other_leg_length": 0.335, "other_foot_mass": 0.34, "other_foot_radius": 0.081}  # fmt: skip


@pytest.fixture(scope="module")
def fmpy():
    fmpy = pytest.importorskip("fmpy", reason="needs the package fmpy, of the extra [test]")
    pytest.importorskip("fmpy.validation")
    return fmpy


@pytest.fixture(scope="module")
def given(parameters):
    return parameters.biped, parameters.slope, parameters.contact


@pytest.fixture(scope="module")
def unit(given, tmp_path_factory):
    path = tmp_path_factory.mktemp("fmu") / "walker.fmu"
    path.write_bytes(package.write(given)[0])
    return path


@pytest.fixture(scope="module")
def six(given):
    return walk_of(given, 6)


def walk_of(given, steps, state=None):
    run = simulate(*given, state or package.gait(given)[0], Settings(TIGHT), steps=steps)
    assert run.completed and run.heel_strikes == steps
    return run.trajectory


@pytest.fixture(scope="module")
def solved(fmpy):
    def solved(path, duration, **settings):
        settings = {"relative_tolerance": TOLERANCE, "output_interval": duration / 3000, **settings}
        return fmpy.simulate_fmu(str(path), stop_time=duration, **settings)

    return solved


def apart(found, walk):
    """Largest distance of the hip from a walk's, along either axis [m]."""
    hip = walk.at(np.minimum(found["time"], walk.time[-1]))[0][:, :2]
    return max(np.abs(hip[:, i] - found[f"hip.{axis}"]).max() for i, axis in enumerate("xy"))


def start_of(given, state):
    """Start values of a walk of another design from a state of its own."""
    _, _, every = package.source(given, state)
    return {number.name: number.start for number in every if number.group in ("STATE", "FIXED", "TUNABLE")}


def test_fmpy_finds_no_problem_and_the_bytes_are_the_same_again(fmpy, unit, given):
    assert fmpy.validation.validate_fmu(str(unit)) == []
    assert package.write(given)[0] == unit.read_bytes()
    with zipfile.ZipFile(unit) as archive:
        text = b"".join(map(archive.read, archive.namelist()))
    assert b"/tmp" not in text and b"site-packages" not in text


@pytest.mark.slow
def test_another_process_writes_the_same_bytes(repository, unit, tmp_path):
    words = "export", "walker", "--format", "fmu", "--out", tmp_path / "walker.fmu"
    done = commands.afresh(*words, cwd=repository, PYTHONHASHSEED="7")
    assert done.returncode == 0 and (tmp_path / "walker.fmu").read_bytes() == unit.read_bytes()


@pytest.mark.slow
def test_another_value_is_another_token(given):
    other = given[0], dataclasses.replace(given[1], gravity=9.82), given[2]
    first, again, moved = (package.source(one, ANY)[1] for one in (given, given, other))
    assert first == again != moved


def test_six_steps_are_the_compiled_walkers_however_often_a_master_looks(unit, six, solved, given):
    strikes, speed = find_events(six, given[0].foot_radii).heel_strike_time, six.position[-1, 0] / six.time[-1]
    for interval in (1e-3, 5e-3):
        found = solved(unit, float(six.time[-1]), output_interval=interval)
        assert apart(found, six) < 1e-6 and found["steps"][-1] == 6
        assert found["time"][1:][np.diff(found["steps"]) > 0] == pytest.approx(strikes, abs=1e-6 / speed)


@pytest.mark.slow
def test_euler_walks_at_a_fiftieth_of_a_millisecond_and_falls_at_a_tenth(unit, six, solved):
    found = {step: solved(unit, float(six.time[-1]), solver="Euler", step_size=step, output_interval=step,
                          output=["hip.x", "hip.y", "steps"]) for step in (2e-5, 1e-4)}  # fmt: skip
    assert found[2e-5]["steps"][-1] == 6 and apart(found[2e-5], six) < 1e-3
    assert found[1e-4]["steps"][-1] < 6 and found[1e-4]["time"][-1] < six.time[-1]


class Loaded:
    """The library of a design, called without any other program."""

    def __init__(self, given, folder):
        text, token, self.every = package.source(given, ANY)
        path = folder / token  # a library of the same path as one that is loaded is that one
        path.write_bytes(package.library(text, package.compiler()))
        self.library = ctypes.CDLL(str(path))
        make = self.library.fmi3InstantiateModelExchange
        make.restype = ctypes.c_void_p
        assert make(b"", b"another", None, False, False, None, None) is None
        self.walker = ctypes.c_void_p(make(b"", token.encode(), None, False, False, None, None))
        self.library.fmi3EnterInitializationMode(self.walker, False, ctypes.c_double(), ctypes.c_double())

    def call(self, name, places, values):
        refs, row = (ctypes.c_uint32 * len(places))(*places), (ctypes.c_double * len(places))(*values)
        return getattr(self.library, name)(self.walker, refs, len(places), row, len(places)), list(row)

    def places(self, group):
        return [place for place, number in enumerate(self.every) if number.group == group]

    def set(self, group, values):
        assert self.call("fmi3SetFloat64", self.places(group), values)[0] == 0

    def get(self, group):
        return np.array(self.call("fmi3GetFloat64", self.places(group), [0.0] * len(self.places(group)))[1])


@pytest.mark.parametrize(("legs", "details", "normal_force"), [
    pytest.param(legs, details, law, id=f"{legs}-{'detailed' if details else 'plain'}-{law}",
                 marks=() if (legs == "rigid") == (not details) == (law == "restitution") else pytest.mark.slow)
    for legs in ("compliant", "rigid") for details in ({}, DETAILS) for law in ("impact", "restitution")])  # fmt: skip
def test_equations_and_sensors_are_the_compiled_walkers(given, tmp_path, legs, details, normal_force):
    """At states drawn at random, feet in the ground and slipping: accelerations, forces, and what sensors feel."""
    biped, slope, contact = given
    biped = dataclasses.replace(biped, legs=legs, **details)
    contact = dataclasses.replace(contact, normal_force=normal_force)
    loaded, rng = Loaded((biped, slope, contact), tmp_path), np.random.default_rng(3)
    for statuses in ((feet.LANDED, feet.OUT), (feet.AWAITED, feet.LANDED)):
        q = np.array([0.4, 0.327, 0.1, -0.1, 0.333, 0.335]) + 2e-3 * rng.normal(size=6)
        v = rng.normal(size=6) * [0.5, 0.05, 2.0, 2.0, 0.1, 0.1]
        if legs == "rigid":
            q[4:], v[4:] = [biped.leg(i).leg_length for i in (0, 1)], 0.0
        kept = 4 if legs == "rigid" else 6
        loaded.set("STATE", [*q[:kept], *v[:kept]])
        loaded.set("STATUS", statuses)
        p, phase = build_penalty(biped, slope.gravity_vector, contact, FALLEN), feet.phase_of(*statuses, 0)
        known = readings(np.array([phase]), np.array([[*q, *v]]), p)[0]
        assert known[6] + known[8] > 0.0  # pressed
        close = partial(pytest.approx, rel=1e-9, abs=1e-12 * np.abs(known).max())
        assert loaded.get("DERIVATIVE") == close([*v[:kept], *known[:kept]])
        felt = loaded.get("OUTPUT")
        assert felt[6:] == close(known[6:])
        rows = q[None], v[None], known[None, :6]
        for place, acceleration in ((0, rows[2][:, :2]), (3, foot_acceleration(*rows, biped))):
            force = specific_force(acceleration, q[None, 2], slope.gravity_vector)[0]
            assert felt[place : place + 3] == close([*force, v[2]])


def test_a_push_on_the_hip_does_what_more_weight_of_the_hip_does(unit, given, solved):
    """A hip that weighs more and is no heavier is one that is pushed all the time."""
    biped, slope, contact = given
    more = 0.02
    walk = walk_of((dataclasses.replace(biped, hip_gravity_mass=biped.hip_mass + more), slope, contact), 2,
                   package.gait(given)[0])  # fmt: skip
    push = {f"push.{axis}": more * pull for axis, pull in zip("xy", slope.gravity_vector)}
    assert apart(solved(unit, float(walk.time[-1]), start_values=push), walk) < 1e-6
    assert apart(solved(unit, float(walk.time[-1])), walk) > 1e-4


def test_parameters_make_it_another_design_on_other_ground(unit, given, solved):
    biped, slope, contact = given
    other = (dataclasses.replace(biped, hip_mass=0.35, foot_radius=0.085, damping=60.0),
             dataclasses.replace(slope, slope_deg=2.1), dataclasses.replace(contact, contact_damping=2e4))  # fmt: skip
    state = package.gait(other)[0]
    walk = walk_of(other, 2, state)
    assert apart(solved(unit, float(walk.time[-1]), start_values=start_of(other, state)), walk) < 1e-6


def test_one_that_falls_ends_the_simulation(unit, solved):
    found = solved(unit, 2.0, start_values={"push.y": -20.0, "push.x": -8.0})
    assert found["time"][-1] < 1.9 and found["steps"][-1] < 4


def test_what_a_walker_has_not_is_refused_by_its_functions(given, tmp_path):
    loaded = Loaded(given, tmp_path)
    assert loaded.library.fmi3DoStep() == loaded.library.fmi3GetFMUState() == 3
    for group in ("TIME", "DERIVATIVE", "OUTPUT", "INDICATOR"):
        assert loaded.call("fmi3SetFloat64", loaded.places(group)[:1], [1.0])[0] == 3
    assert loaded.call("fmi3GetFloat64", [len(loaded.every)], [0.0])[0] == 3
    assert loaded.library.fmi3GetContinuousStates(loaded.walker, (ctypes.c_double * 3)(), ctypes.c_size_t(3)) == 3


OTHERS = {
    "large": lambda b, s, c: tuple(similar(each, (20.0, 5.0, 5.0**0.5)) for each in (b, s, c)),
    "small": lambda b, s, c: tuple(similar(each, (1e-3, 0.1, 0.1**0.5)) for each in (b, s, c)),
    "on the moon": lambda b, s, c: (b, dataclasses.replace(s, gravity=1.62), c),
    "rigid": lambda b, s, c: (dataclasses.replace(b, legs="rigid"), s, c),
    "unequal": lambda b, s, c: (dataclasses.replace(b, other_foot_mass=0.345), s, c),
    "detailed": lambda b, s, c: (dataclasses.replace(b, frame_mass=0.05, hip_friction=1e-3, hip_damping=1e-3), s, c),
    "restitution": lambda b, s, c: (b, s, dataclasses.replace(c, normal_force="restitution", friction="coulomb")),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("which", OTHERS)
def test_any_walker_walks_as_the_compiled_one(given, fmpy, solved, tmp_path, which):
    """Six steps, within 3e-6 of a leg: 1e-6 m of Table 1's."""
    other, path = OTHERS[which](*given), tmp_path / "walker.fmu"
    path.write_bytes(package.write(other)[0])
    walk = walk_of(other, 6)
    found = solved(path, float(walk.time[-1]))
    assert fmpy.validation.validate_fmu(str(path)) == []
    assert found["steps"][-1] == 6 and apart(found, walk) < 3e-6 * other[0].leg_length


def export(repository, folder, *arguments):
    """Code, output, and the errors that are no progress, as it is shown on a slow machine."""
    done = commands.run("export", *arguments, "--out", folder / "walker.fmu", cwd=repository)
    said = [line for line in done.stderr.splitlines() if not line.startswith("warning: ") and "%: " not in line]
    return done.returncode, done.stdout, said


@pytest.mark.slow
def test_the_command_writes_it(repository, unit, tmp_path):
    code, out, said = export(repository, tmp_path, "walker", "--format", "fmu", "--json")
    assert (code, said) == (0, []) and json.loads(out)["start"]["biped.hip_mass"]["unit"] == "kg"
    assert (tmp_path / "walker.fmu").read_bytes() == unit.read_bytes()


@pytest.mark.parametrize(
    ("what", "form", "change", "code", "sentence"),
    [
        ("walker", "urdf", "slope_deg=2", 2, "--format = urdf is not allowed: the walker is written as fmu"),
        ("twin", "fmu", "slope_deg=2", 2, "the twin as mjcf, urdf, sdf, gltf"),
        ("walker", "fmu", "slope_deg=0", 3, "no periodic gait: on level ground"),
        ("walker", "fmu", "block_height_rms=0.001", 2, "exported blocks are level"),
        ("walker", "fmu", "friction=none", 3, "the walker fell"),
    ],
)
def test_what_is_refused_leaves_no_file(repository, tmp_path, what, form, change, code, sentence):
    done, out, said = export(repository, tmp_path, what, "--format", form, "--set", f"ground.{change}")
    assert (done, out) == (code, "") and len(said) == 1 and sentence in said[0]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("lines", "sentence"), [("", "needs a C compiler, cc, gcc or clang, and none is found"),
                         ("echo no licence >&2; exit 1", "makes no library: no licence")])  # fmt: skip
def test_without_a_compiler_that_works_it_is_refused(repository, tmp_path, monkeypatch, lines, sentence):
    tools = tmp_path / "tools"
    tools.mkdir()
    monkeypatch.setenv("PATH", str(tools))
    monkeypatch.setattr(package.sysconfig, "get_config_var", {}.get)
    if lines:
        (tools / "cc").write_text(f"#!/bin/sh\n{lines}\n")
        (tools / "cc").chmod(0o755)
    code, out, said = export(repository, tmp_path, "walker", "--format", "fmu")
    assert (code, out) == (2, "") and len(said) == 1 and sentence in said[0]
    assert not (tmp_path / "walker.fmu").exists()
