"""Ten reference gaits: every one is walked again by the program in docs/reference_gaits.md, which shares no code."""

import dataclasses
import json
import re
import subprocess
import sys

import numpy as np
import pytest

from stages.analytic.errors import NoGait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.parameters import Parameters, Settings
from stages.analytic.questions import reference_gaits
from stages.biped.quantity import faults
from stages.biped.question import WrongOption
from tests.analytic.designs import FRICTION, RUBBER, SLOPE, TABLE_1, changed
from tests.asking import Asking
from tests.pipeline import documented

pytest.importorskip("flint", reason="python-flint is not installed: pip install 'bipedstudy[proof]'")


PARAMETERS = Parameters(TABLE_1, SLOPE, FRICTION, RUBBER, Settings(tolerance=1e-10, steps=2, sampling_rate_hz=100.0))
#: Largest difference of period [s] and return state [SI units].
CLOSE = 1e-10


def the_design(name, biped=TABLE_1):
    return next(each for each in reference_gaits.designs(biped, SLOPE) if each.name == name)


def scored(path, repository):
    """What the page's program prints of each gait: name, difference of period, of the state."""
    (program,) = documented.blocks(repository / "docs/reference_gaits.md", "python")
    assert len(program.splitlines()) <= 60 and "bipedstudy" not in program
    done = subprocess.run([sys.executable, "-c", program, path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return re.findall(r"^(\w+) +period (\S+) s, state (\S+)$", done.stdout, flags=re.M)


def test_there_are_ten_legal_designs_of_any_robot():
    for biped in (TABLE_1, changed(TABLE_1, leg_length=0.9, foot_com=0.25, foot_radius=0.2, hip_mass=20.0)):
        found = list(reference_gaits.designs(biped, SLOPE))
        assert len({each.name for each in found}) == 10 and found[0].biped == biped
        assert [broken for each in found for broken in (*faults(each.biped), *faults(each.slope))] == []


@pytest.mark.parametrize("name", ["large", "small"])
def test_both_legs_and_all_details_of_a_robot_grow_with_it(name):
    """Else a robot with numbers of the other leg would get one leg three times as long as the other."""
    biped = changed(TABLE_1, other_leg_length=0.3332, other_foot_mass=0.337, frame_mass=0.01, frame_com=0.02,
                    hip_stiffness=0.05)  # fmt: skip
    found, by = the_design(name, biped).biped, {"large": 3.0, "small": 0.25}[name]
    assert found.leg_lengths == pytest.approx(np.multiply(by, biped.leg_lengths), rel=1e-15)
    assert found.total_mass == pytest.approx(by**3 * biped.total_mass) and found.frame_com == by * biped.frame_com
    assert found.hip_stiffness == pytest.approx(by**4 * biped.hip_stiffness)


@pytest.mark.parametrize("name", ["detailed", "hip_spring", "large", "weak_gravity"])
def test_a_design_has_a_stable_gait_of_its_own(name):
    design = the_design(name)
    point = find_gait(design.biped, design.slope, 1e-10)[1]
    plain = find_gait(TABLE_1, SLOPE, 1e-10)[1]
    assert abs(point.floquet_multipliers).max() < 1 and abs(point.period - plain.period) > 1e-3


@pytest.mark.slow
def test_a_gait_is_described_with_units_and_walked_again_by_the_program(repository, tmp_path):
    gait = reference_gaits.described(the_design("rigid"), Asking())
    assert gait["parameters"]["leg_1"]["foot_mass"] == {"value": 0.335, "unit": "kg"}
    assert gait["parameters"]["hip"]["stiffness"]["unit"] == "N m/rad" and gait["period"]["unit"] == "s"
    low, high = map(float, gait["enclosures"]["period"]["between"])
    assert low <= gait["period"]["value"] + 1e-12 and gait["period"]["value"] - 1e-12 <= high
    assert [each["event"] for each in gait["events"]] == ["heel strike"]
    assert gait["events"][-1]["time"]["value"] == pytest.approx(gait["period"]["value"], abs=1e-12)
    units = {name: each["unit"] for name, each in gait["start"].items()}
    assert (units["stance_angle"], units["stance_length"], units["swing_rate"]) == ("rad", "m", "rad/s")
    path = tmp_path / "gaits.json"
    path.write_text(json.dumps({"gaits": [gait]}))
    ((name, period, state),) = scored(path, repository)
    assert name == "rigid" and float(period) < CLOSE and float(state) < CLOSE
    gait["parameters"]["leg_0"]["foot_mass"]["value"] *= 1 + 1e-6
    path.write_text(json.dumps({"gaits": [gait]}))
    assert float(scored(path, repository)[0][2]) > 100 * CLOSE, "another robot has another gait"


def test_what_cannot_be_proven_is_refused_and_a_design_without_a_gait_is_named():
    rubbing = dataclasses.replace(PARAMETERS, biped=changed(TABLE_1, hip_friction=0.01))
    with pytest.raises(WrongOption, match="hip_friction"):
        reference_gaits.ask(rubbing, reference_gaits.Options(), Asking())
    level = dataclasses.replace(SLOPE, slope_deg=0.0)
    with pytest.raises(NoGait, match=r"design plain \(the design itself\)"):
        reference_gaits.described(reference_gaits.Design("plain", "the design itself", TABLE_1, level), Asking())


@pytest.mark.slow
def test_the_program_of_the_page_walks_all_ten(repository, tmp_path):
    path = tmp_path / "gaits.json"
    reference_gaits.ask(PARAMETERS, reference_gaits.Options(file=path), Asking())
    found = scored(path, repository)
    assert [name for name, *_ in found] == [each.name for each in reference_gaits.designs(TABLE_1, SLOPE)]
    assert [row for row in found if max(float(row[1]), float(row[2])) > CLOSE] == []


def test_a_design_that_there_is_not_is_refused_by_name():
    with pytest.raises(WrongOption, match=r"only: there is no design flat; there are plain, rigid,"):
        reference_gaits.ask(PARAMETERS, reference_gaits.Options(only=("flat",)), Asking())


def test_gaits_that_were_proven_are_written_where_another_is_not(tmp_path, monkeypatch):
    """A gait that could not be proven took the file of the nine that were, and minutes of work."""
    enclosures = {"period": {"between": ["0.4", "0.5"], "unit": "s"}}

    def described(design, _asking):
        if design.name != "rigid":
            raise NoGait(f"design {design.name}: it falls")
        return {"name": design.name, "steps": 1, "stable": True, "enclosures": enclosures}

    monkeypatch.setattr(reference_gaits, "described", described)
    path = tmp_path / "gaits.json"
    answer = reference_gaits.ask(PARAMETERS, reference_gaits.Options(path, ("plain", "rigid")), Asking())
    assert [gait["name"] for gait in json.loads(path.read_text())["gaits"]] == ["rigid"]
    assert answer.no and answer.remark == "design plain: it falls"
    with pytest.raises(NoGait, match="design plain"):
        reference_gaits.ask(PARAMETERS, reference_gaits.Options(tmp_path / "none.json", ("plain",)), Asking())
    assert not (tmp_path / "none.json").exists()
