"""The bill of parts: its sums, its symmetry, and what is refused."""

import dataclasses
import math

import numpy as np
import pytest

from pipeline.errors import StudyError
from pipeline.parameters.loading import load
from stages.stability.parameters import Parameters as Stability
from stages.twin.machine.bill import sums
from stages.twin.machine.machine import Body, bodies, build, join, pieces
from stages.twin.machine.parts import FEET, FRAMES, size_fault, solid
from stages.twin.parameters import Parameters
from tests.study import parameters_of


def test_sums_agree_with_the_bodies(parameters):
    found = {what: value for what, value, _ in sums(parameters.settings.parts, parameters.biped)}
    frame, left, right, outer, *_ = bodies(parameters.settings.parts)
    assert found["hip mass [kg]"] == pytest.approx(frame.mass + outer.mass)
    height = join((left, right)).centre[1] + parameters.biped.leg_length
    assert found["inner foot mass centre above the foot's bottom [m]"] == pytest.approx(height)


def test_order_of_the_rows_does_not_matter(parameters, machine):
    shuffled = dataclasses.replace(parameters.settings, parts=parameters.settings.parts[::-1])
    for a, b in zip(build(parameters.biped, shuffled).bodies, machine.bodies, strict=True):
        assert a.mass == pytest.approx(b.mass) and a.inertia == pytest.approx(b.inertia)


def test_a_bill_that_does_not_add_up_is_one_sentence(parameters):
    lighter, *others = parameters.settings.parts
    parts = (dataclasses.replace(lighter, mass=0.9 * lighter.mass), *others)
    with pytest.raises(ValueError, match=r"add up to the design in biped.yaml .* hip mass \[kg\] 0.316, not 0.31155$"):
        build(parameters.biped, dataclasses.replace(parameters.settings, parts=parts))


def test_parts_that_are_neither_designs_are_told_what_to_do():
    """Shown by parts that no longer say which design they are drawn for, so that they should be the biped's."""
    with pytest.raises(StudyError, match=r"hip mass \[kg\] 0.4, not 0.316") as refused:
        parameters_of("twin", "biped.hip_mass=0.4", "twin.parts_hip_mass=null")
    assert len(refused.value.sentences) == 1 and "twin.inertia = planar" in str(refused.value)
    loaded = parameters_of("twin", "biped.hip_mass=0.4", "twin.inertia=planar")
    assert build(loaded.biped, loaded.settings).mass == pytest.approx(loaded.biped.total_mass)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("mass: 0.0445", "mass: -0.0445", "mass = -0.0445 kg is not allowed; allowed: > 0 kg"),
        ("size: [0.005, 0.210]", "size: [0.005]", "for a cylinder 2 numbers (radius, length)"),
        ("mass: 0.0445", "mass: 0.0545", "at most 0.0445 kg, which is solid aluminium"),
        ("material: acetal", "material: cheese", "a material of the list"),
        ("position: [0, -0.170, 0.040]", "position: [0, -0.170, 0]", "z other than 0"),
        ("group: inner_frame", "group: hat", "inner_frame"),
    ],
)
def test_impossible_rows_are_refused_when_the_file_is_read(repository, tmp_path, old, new, said):
    for file in ("biped", "ground", "twin"):
        text = (repository / "params" / f"{file}.yaml").read_text()
        (tmp_path / f"{file}.yaml").write_text(text.replace(old, new, 1) if file == "twin" else text)
    with pytest.raises(StudyError) as refused:
        load(tmp_path, [], {"twin": Parameters}, [Parameters, Stability])
    assert said in str(refused.value)


# --- Inertia of shapes against textbook formulas.


def test_box():
    a, b, c, m = 0.02, 0.10, 0.03, 0.7
    shape, square = solid("box", (a, b, c)), np.array([a * a, b * b, c * c])
    assert shape.volume == pytest.approx(a * b * c)
    assert shape.inertia(m) == pytest.approx(m / 12 * (square.sum() - square))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_solid_cylinder_about_its_axis_and_across(axis):
    r, length, m = 0.02, 0.3, 1.3
    wanted = [m / 2 * r * r if each == axis else m / 12 * (3 * r * r + length * length) for each in "xyz"]
    assert solid("cylinder", (r, length), axis).inertia(m) == pytest.approx(wanted)


def test_tube_is_a_cylinder_less_a_cylinder():
    outer, inner, length, density = 0.02, 0.015, 0.1, 2700.0
    hollow, full, hole = (
        solid(*each) for each in (
            ("tube", (outer, inner, length)), ("cylinder", (outer, length)), ("cylinder", (inner, length))))
    assert hollow.volume == pytest.approx(full.volume - hole.volume)
    of_hollow, of_full, of_hole = (np.array(each.inertia(density * each.volume)) for each in (hollow, full, hole))
    assert of_hollow == pytest.approx(of_full - of_hole)


def test_arc_against_integration_over_its_area():
    outer, thickness, width, chord = 0.083, 0.012, 0.02, 0.11
    half = math.asin(chord / 2 / outer)
    radius, angle = np.meshgrid(
        np.linspace(outer - thickness, outer, 801), np.linspace(-half, half, 801), indexing="ij"
    )
    x, y, weight = radius * np.sin(angle), -radius * np.cos(angle), radius
    shape = solid("arc", (outer, thickness, width, chord))
    mean = lambda f: np.trapezoid(np.trapezoid(f * weight)) / np.trapezoid(np.trapezoid(weight))  # noqa: E731
    assert shape.centroid[1] == pytest.approx(mean(y), rel=1e-5)
    across = mean(x**2), mean((y - mean(y)) ** 2)
    assert shape.mean_square[:2] == pytest.approx(across, rel=1e-4)


def test_two_halves_of_a_box_make_the_box():
    half, whole = (np.diag(solid("box", (length, 0.05, 0.02)).inertia(m)) for length, m in ((0.1, 0.3), (0.2, 0.6)))
    found = join([Body(0.3, np.array([x, 0.3, 0.1]), half) for x in (-0.05, 0.05)])
    assert found.centre == pytest.approx([0.0, 0.3, 0.1]) and found.inertia == pytest.approx(whole, abs=1e-12)


@pytest.mark.parametrize(
    ("shape", "size"),
    [
        ("box", (1.0, 1.0)),
        ("cylinder", (0.0, 1.0)),
        ("tube", (1.0, 1.0, 1.0)),
        ("arc", (1.0, 2.0, 1.0, 1.0)),
        ("arc", (1.0, 0.1, 1.0, 2.1)),
        ("box", (1.0, float("nan"), 1.0)),
    ],
)
def test_impossible_sizes_are_named(shape, size):
    assert size_fault(shape, size)


# --- Parts that follow a changed design: masses, centres and moments are the design's, whatever was edited.


EDITED = ("hip_mass", "foot_mass", "leg_length", "foot_radius", "foot_com")
EDGES = (
    {"hip_mass": 0.0, "legs": "rigid"}, {"hip_mass": 1e-9}, {"foot_mass": 1e-6}, {"foot_com": 0.0},
    {"foot_com": 0.332999}, {"foot_radius": 0.0}, {"foot_radius": 0.0, "foot_com": 0.0}, {"foot_radius": 0.332999},
    {"leg_length": 0.100001}, {"leg_length": 1.2, "foot_radius": 0.3, "foot_com": 1.199}, {"leg_inertia": 1e-9},
    {"leg_inertia": 0.4, "foot_mass": 5.0}, {},
)  # fmt: skip


def edits(biped, count, seed=11):
    """Designs with one to three numbers changed by up to 30 %, and those at the edge of what is allowed."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        keys = rng.choice(EDITED, size=rng.integers(1, 4), replace=False)
        yield dataclasses.replace(
            biped, leg_inertia=float(rng.choice([0.0, 0.003])),
            **{str(key): getattr(biped, key) * float(rng.uniform(0.7, 1.3)) for key in keys})  # fmt: skip
    yield from (dataclasses.replace(biped, **edge) for edge in EDGES)


def test_masses_and_centres_are_the_edited_designs(parameters):
    for biped in edits(parameters.biped, 12):
        changed = dataclasses.replace(parameters, biped=biped)
        assert not [*biped.broken_rules(), *changed.broken_rules()], biped
        machine = build(biped, parameters.settings)
        scale = max(1.0, biped.leg_length) * 1e-12
        assert machine.bodies[0].mass + machine.bodies[3].mass == pytest.approx(biped.hip_mass, abs=scale)
        assert machine.mass == pytest.approx(biped.total_mass, abs=scale)
        for pair in (machine.bodies[1:3], machine.bodies[4:6]):
            feet = join(pair)
            assert feet.mass == pytest.approx(biped.foot_mass, abs=scale)
            assert feet.centre == pytest.approx([0.0, biped.foot_com - biped.leg_length, 0.0], abs=1e-9)
            if biped.leg_inertia:
                assert feet.inertia[2, 2] == pytest.approx(biped.leg_inertia, rel=1e-12)
        for body in machine.bodies:  # a rigid body's moments: none negative, none above the sum of the others
            low, middle, high = np.linalg.eigvalsh(body.inertia)
            assert low >= -1e-15 and high <= (low + middle) * (1 + 1e-9) + 1e-15


def test_parts_of_an_edited_design_stay_on_the_leg_and_feet_on_the_ground(parameters):
    """Also where the mass centre is so low, or so high, that they have to shrink."""
    for biped in edits(parameters.biped, 10, seed=12):
        for part in parameters.settings.bill(biped):
            if part.group not in FEET:
                continue
            along = {"box": 1, "tube": 2}.get(part.shape)  # what is no arc or point stands along the leg
            reach = 0.0 if not part.size else part.size[0] if along is None else part.size[along] / 2
            low, high = part.position[1] - reach, part.position[1] + (reach if part.shape != "arc" else 0.0)
            assert low >= -biped.leg_length * 1.005 and high <= biped.leg_length * 0.005, (biped, part.name)
            if part.name.endswith("foot cover") and biped.foot_radius:
                assert low == pytest.approx(-biped.leg_length, abs=1e-9 * biped.leg_length)
                assert part.size[0] == pytest.approx(biped.foot_radius)


def test_moments_about_the_hip_axis_scale_with_mass_and_length_squared(parameters, machine):
    """Of a robot half as large again and thrice as heavy; without its lanes, which twin.yaml gives."""
    size, weight = 1.5, 3.0
    lengths = {key: size * getattr(parameters.biped, key) for key in ("leg_length", "foot_radius", "foot_com")}
    masses = {key: weight * getattr(parameters.biped, key) for key in ("hip_mass", "foot_mass")}
    large = build(dataclasses.replace(parameters.biped, **lengths, **masses), parameters.settings)
    for small, body in zip(machine.bodies, large.bodies, strict=True):
        assert body.inertia[2, 2] == pytest.approx(weight * size**2 * small.inertia[2, 2], rel=1e-4)
        assert body.centre[:2] == pytest.approx(size * small.centre[:2], abs=5e-6)
        assert body.centre[2] == pytest.approx(small.centre[2], abs=1e-6)


def test_a_heavier_hip_keeps_what_is_below_the_springs(parameters, machine):
    """The feet's moments change by what the bill was off Table 1, half of its fourth decimal at most."""
    heavy = build(dataclasses.replace(parameters.biped, hip_mass=0.4), parameters.settings)
    for number, (body, before) in enumerate(zip(heavy.bodies, machine.bodies, strict=True)):
        factor = 1.0 if number % 3 else 0.4 / 0.316
        assert body.inertia == pytest.approx(factor * before.inertia, rel=1e-4, abs=1e-12)


def test_the_study_s_own_parts_are_as_written_and_the_rule_names_what_was_changed(parameters):
    settings, biped = parameters.settings, parameters.biped
    edited = dataclasses.replace(biped, hip_mass=0.3, leg_inertia=0.002)
    assert settings.bill_rule(edited) == ("parts scaled from another design (hip_mass 0.316 -> 0.3 kg), "
                                          "feet's moments scaled to leg_inertia 0.002 kg m^2")  # fmt: skip
    small = dataclasses.replace(biped, leg_length=0.3)
    assert settings.bill_rule(small).endswith("(leg_length 0.333 -> 0.3 m), lanes as in twin.yaml"), "not as the legs"
    points, softer = dataclasses.replace(settings, inertia="planar"), dataclasses.replace(biped, stiffness=1000.0)
    for chosen, own, parts in ((settings, biped, settings.parts), (settings, softer, settings.parts),
                               (points, edited, ())):  # fmt: skip
        assert (chosen.bill(own), chosen.bill_rule(own)) == (parts, "")


def test_parts_of_one_s_own_that_add_up_to_the_design_are_used_as_written(parameters):
    """Though the file still says that they are drawn for Table 1."""
    settings, biped = parameters.settings, dataclasses.replace(parameters.biped, hip_mass=0.632)
    heavy = tuple(dataclasses.replace(part, mass=2 * part.mass) if part.group in FRAMES else part
                  for part in settings.parts)  # fmt: skip
    denser = tuple(dataclasses.replace(one, density=3 * one.density) for one in settings.materials)
    own = dataclasses.replace(settings, parts=heavy, materials=denser)
    assert (own.bill(biped), own.bill_rule(biped)) == (heavy, "")
    assert build(biped, own).mass == pytest.approx(1.302)


def test_feet_that_are_nothing_but_arcs_have_the_designs_centre(parameters):
    settings = parameters.settings
    arcs = tuple(part for part in settings.parts if part.group in FRAMES or part.shape == "arc")
    feet = join(piece for part in arcs if part.group == "inner_foot" for piece in pieces(part))
    own = dataclasses.replace(settings, parts=arcs, parts_foot_mass=feet.mass, parts_foot_com=feet.centre[1] + 0.333)
    biped = dataclasses.replace(parameters.biped, foot_mass=0.1, foot_com=0.05)
    feet = join(build(biped, own).bodies[1:3])
    assert feet.mass == pytest.approx(0.1) and feet.centre[1] == pytest.approx(0.05 - 0.333)
