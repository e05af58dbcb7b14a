"""What the package of stages says of the errors of single numbers stands beside them, in the file and in `show`."""

from __future__ import annotations

import json

import h5py

from stages.about import computed_how

ABOUT = '''
ATTRIBUTES = {"title": "toy"}


def numerical_errors(stage, parameters):
    assert "ground.gravity = " in parameters
    return {"height": 0.25, "nothing": 1.0, "time": 3.0} if stage == "fall" else {}
'''


def test_a_number_carries_its_error_and_show_prints_it(toy_with_commands):
    toy = toy_with_commands
    toy.path("PACKAGE/about.py").write_text(ABOUT)
    assert toy.command("run", "bounce")[0] == 0
    with h5py.File(toy.root / "results/fall.h5") as file:
        assert file["height"].attrs["numerical_error"] == 0.25 and "nothing" not in file
    lines = toy.command("show", "fall")[1].splitlines()
    assert " +- 2e-01 m" in next(line for line in lines if line.split()[:1] == ["height"])
    fields = {field["path"]: field for field in json.loads(toy.command("show", "fall", "--json")[1])["fields"]}
    assert fields["height"]["numerical_error"] == 0.25
    with h5py.File(toy.root / "results/bounce.h5") as file:
        assert not any("numerical_error" in item.attrs for item in file.values())


def test_how_a_stage_computed_does_not_depend_on_the_machine():
    one = "biped.hip_mass = 1\nground.gravity = 9.81\nanalytic.tolerance = 1e-10"
    assert computed_how(one) == computed_how(one.replace("9.81", "1.62")) != computed_how(one.replace("1e-10", "1e-9"))
