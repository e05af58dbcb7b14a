"""Whole studies of robots that are not Table 1's come to an end: every stage, every figure, the report."""

import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow


def draft(folder, *changes):
    """A new study of another robot, run as a draft from nothing."""
    program = [sys.executable, "-m", "bipedstudy"]
    subprocess.run([*program, "init", "study"], cwd=folder, check=True)
    settings = [word for change in changes for word in ("--set", change)]
    return subprocess.run([*program, "run-all", "--accuracy", "draft", *settings], cwd=folder / "study", text=True,
                          capture_output=True)


@pytest.mark.parametrize("changes", [
    ["biped.legs=rigid", "ground.slope_deg=0.8"],
    ["biped.stiffness=9000", "biped.damping=120"],
    ["ground.normal_force=restitution"],
    ["analytic.transition=coulomb", "biped.foot_radius=0.05"],
    ["twin.inertia=planar", "biped.hip_mass=1.0", "biped.foot_com=0.06"],
])
def test_a_study_of_another_robot_comes_to_its_end(tmp_path, changes):
    done = draft(tmp_path, *changes)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "study/results/report.html").stat().st_size > 100_000


def test_an_unstable_gait_has_its_report_and_no_steps_on_blocks(tmp_path):
    done = draft(tmp_path, "ground.slope_deg=4.5")
    assert done.returncode == 3
    (refused,) = done.stderr.splitlines()
    assert refused.startswith("error: stage rough_ground: the gait is unstable")
    assert (tmp_path / "study/results/report.html").stat().st_size > 100_000


def test_a_ramp_too_flat_to_walk_on_is_an_honest_no(tmp_path):
    done = draft(tmp_path, "ground.slope_deg=0.2")
    assert done.returncode == 3
    assert "no periodic gait" in done.stderr and "Traceback" not in done.stderr


def test_no_compiled_line_reads_beyond_an_array(tmp_path, monkeypatch, repository):
    """The whole draft study of Table 1 with numba's check of bounds, all compiled anew."""
    monkeypatch.setenv("NUMBA_BOUNDSCHECK", "1")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    command = [sys.executable, "-m", "bipedstudy", "run-all", "--accuracy", "draft", "--results", tmp_path / "results"]
    done = subprocess.run(command, cwd=repository, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr
