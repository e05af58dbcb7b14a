"""The bill of parts: its sums, its symmetry, and what is refused."""

import dataclasses

import numpy as np
import pytest

from pipeline.errors import StudyError
from pipeline.parameters.loading import load
from stages.stability.parameters import Parameters as Stability
from stages.twin.machine.bill import sums
from stages.twin.machine.machine import bodies, build, join
from stages.twin.parameters import Parameters


def test_sums_agree_with_the_bodies(parameters):
    found = {what: value for what, value, _ in sums(parameters.settings.parts, parameters.biped)}
    frame, left, right, outer, *_ = bodies(parameters.settings.parts)
    assert found["hip mass [kg]"] == pytest.approx(frame.mass + outer.mass)
    height = join((left, right)).centre[1] + parameters.biped.leg_length
    assert found["inner foot mass centre above the foot's bottom [m]"] == pytest.approx(height)


def test_right_is_the_mirror_image_of_left(machine):
    mirror = np.diag([1.0, 1.0, -1.0])
    for left, right in ((1, 2), (4, 5)):
        a, b = machine.bodies[left], machine.bodies[right]
        assert b.mass == a.mass
        assert np.array_equal(b.centre, mirror @ a.centre)
        assert np.array_equal(b.inertia, mirror @ a.inertia @ mirror)
    for frame in (0, 3):
        assert machine.bodies[frame].centre[2] == pytest.approx(0.0, abs=1e-15)


def test_order_of_the_rows_does_not_matter(parameters, machine):
    shuffled = dataclasses.replace(parameters.settings, parts=parameters.settings.parts[::-1])
    for a, b in zip(build(parameters.biped, shuffled).bodies, machine.bodies, strict=True):
        assert a.mass == pytest.approx(b.mass) and a.inertia == pytest.approx(b.inertia)


def test_a_bill_that_does_not_add_up_is_one_sentence(parameters):
    lighter, *others = parameters.settings.parts
    parts = (dataclasses.replace(lighter, mass=0.9 * lighter.mass), *others)
    with pytest.raises(ValueError, match=r"add up to the design in biped.yaml .* hip mass \[kg\] 0.316, not 0.31155$"):
        build(parameters.biped, dataclasses.replace(parameters.settings, parts=parts))


def test_parts_that_are_neither_designs_are_told_what_to_do(repository):
    """Shown by parts that no longer say which design they are drawn for, so that they should be the biped's."""
    alone = ["biped.hip_mass=0.4", "twin.parts_hip_mass=null"]
    with pytest.raises(StudyError, match=r"hip mass \[kg\] 0.4, not 0.316") as refused:
        load(repository / "params", alone, {"twin": Parameters}, [Parameters, Stability])
    assert len(refused.value.sentences) == 1 and "twin.inertia = planar" in str(refused.value)
    changed = ["biped.hip_mass=0.4", "twin.inertia=planar"]
    loaded = load(repository / "params", changed, {"twin": Parameters}, [Parameters, Stability])["twin"]
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


def test_point_masses_need_no_bill(parameters):
    settings = dataclasses.replace(parameters.settings, inertia="planar", parts=parameters.settings.parts[:1])
    heavier = dataclasses.replace(parameters.biped, hip_mass=0.4)
    assert build(heavier, settings).mass == pytest.approx(heavier.total_mass)
