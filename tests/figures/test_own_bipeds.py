"""Own bipeds through the whole study: each gets its report, with every figure or the reason why there is none."""

import re
import subprocess
import sys

import pytest
import yaml

from stages.biped.design import DETAILS
from stages.figures.drawn import figure

pytestmark = pytest.mark.slow

#: biped.yaml and ground.yaml of robots that walk and are stable, and stages that do not apply to them.
OWN = {
    "heavy legs where gravity is stronger": ({
        "hip_mass": 1.396, "foot_mass": 1.91, "leg_length": 0.4727, "foot_radius": 0.09928, "foot_com": 0.1866,
        "stiffness": 35000.0, "damping": 250.0, "slope_deg": 2.83, "gravity": 15.43}, set()),
    "short legs of another density": ({
        "hip_mass": 0.02, "foot_mass": 0.025, "leg_length": 0.1, "foot_radius": 0.025, "foot_com": 0.03,
        "stiffness": 700.0, "damping": 7.5, "slope_deg": 2.0, "gravity": 9.81}, set()),
    "frames where gravity is weak": ({
        "hip_mass": 0.04765, "foot_mass": 0.0469, "leg_length": 0.1848, "foot_radius": 0.04, "foot_com": 0.05437,
        "stiffness": 150.0, "damping": 3.5, "frame_mass": 0.006, "frame_com": 0.02, "frame_inertia": 1e-6,
        "slope_deg": 2.5, "gravity": 1.65}, set()),
    "legs that differ and springs at the hip": ({
        "other_foot_mass": 0.338, "hip_stiffness": 0.02, "hip_damping": 1e-4}, set()),
    "a hip that rubs": ({"hip_friction": 2e-4}, {"error_budget"}),
}
#: Stages that run in a study of one's own when they are named.
OF_PROGRAM = {"extremes", "tradeoff"}


def bipedstudy(folder, *arguments):
    return subprocess.run([sys.executable, "-m", "bipedstudy", *arguments], cwd=folder, capture_output=True, text=True)


def lay_out(folder, values):
    assert bipedstudy(folder, "init", "own").returncode == 0
    study = folder / "own"
    for name in ("biped", "ground"):
        path = study / "params" / f"{name}.yaml"
        text = path.read_text()
        for key, value in values.items():
            text = re.sub(rf"^{key}: +\{{value: [^,]+,([^}}]*?)(, printed: \"[^\"]*\")?\}}$",
                          rf"{key}: {{value: {value},\1}}", text, flags=re.MULTILINE)  # fmt: skip
        more = [f"{key}: {value}\n" for key, value in values.items() if name == "biped" and key in DETAILS]
        path.write_text(text + "".join(more))
    return study


@pytest.mark.parametrize("which", OWN)
def test_each_has_its_report_and_says_what_is_missing(which, tmp_path):
    values, lacks = OWN[which]
    study = lay_out(tmp_path, values)
    done = bipedstudy(study, "run-all", "--accuracy", "draft")
    results = study / "results"
    assert done.returncode == (3 if lacks else 0) and "unexpected" not in done.stderr, done.stderr
    page = (results / "report.html").read_text(encoding="utf-8")
    captions = yaml.safe_load((results / "captions.yaml").read_text(encoding="utf-8"))["figures"]
    drawn = {path.stem for path in (results / "figures").iterdir()}
    for caption in captions:
        missing = lacks.intersection(caption["shows"]).difference(figure(caption["name"]).without)
        left_out = OF_PROGRAM.intersection(caption["shows"])
        assert (caption["name"] in drawn) == (not missing and not left_out), caption
        assert not missing or re.fullmatch(
            "Not drawn: (there is no [a-z_]+: )?the constraint model does not know Coulomb friction at the hip[.]",
            caption["text"]), caption
        assert not left_out or "dvc.yaml leaves it out" in caption["text"]
        assert f'id="{caption["name"]}"' in page
    assert {path.stem for path in results.glob("*.h5")}.isdisjoint(lacks | OF_PROGRAM)
    assert all(f"<li>{stage}: " in page for stage in lacks)
    told = bipedstudy(study, "run-all", "--accuracy", "draft")
    assert told.returncode == done.returncode and "computed" not in told.stdout, "a no is not computed again"
