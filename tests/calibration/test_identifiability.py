"""What runs can tell: the scale of mass is not seen, the clock limits the length, and what trials outside had found."""

import dataclasses
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.parameters import yaml_text
from pipeline.questions.command import Described
from stages.analytic.errors import NoGait
from stages.analytic.gait.design_point import DesignPoint
from stages.biped.question import WrongOption
from stages.calibration.estimation.least_squares import Known
from stages.calibration.estimation.request import Request
from stages.calibration.following.robot_file import FittedRobot
from stages.calibration.information import identifiability as identifiability_of
from stages.calibration.information.identifiability import (
    described,
    experiments,
    first_model,
    gains,
    identifiability,
    is_scale_of_mass,
    planned_equations,
    weighed,
)
from stages.calibration.questions.calibrate import Options, ask
from stages.calibration.reports import angle_report, identifiability_report, sensor_report
from tests import commands
from tests.calibration.runs import PARAMETERS
from tests.study import ROOT

#: The foot sensor's place is known, as in the trial.
KNOWN = dataclasses.replace(PARAMETERS, given=dataclasses.replace(PARAMETERS.settings, lever_arm_sd=1e-6))
#: Shares in % that an independent trial found for the same run (hip weighed; the study's own Fisher information).
TRIAL = {"biped.foot_mass": 0.053, "biped.leg_length": 0.041, "biped.foot_radius": 0.063, "biped.foot_com": 0.064,
         "biped.stiffness": 0.071, "biped.damping": 0.066, "ground.slope_deg": 0.057}


@pytest.fixture(scope="module")
def planned():
    return planned_equations(KNOWN)


def of(planned, known, runs=1):
    return identifiability(*planned, known, runs)


def test_the_scale_of_mass_alone_is_not_seen(planned):
    found = of(planned, ())
    units = [planned[0].unit(name) for name in found.names]
    assert len(found.unseen) == 1
    assert is_scale_of_mass(found.unseen[0], units, found.values)
    sentence = described(found.unseen[0], found.names, units, found.values)
    assert "weigh the robot" in sentence
    assert all(word in sentence for word in ("hip_mass", "foot_mass", "stiffness", "damping", "leg_inertia"))
    massless = {"biped.leg_length", "biped.foot_radius", "biped.foot_com", "ground.slope_deg"}
    assert {name for name, sd in zip(found.names, found.sd, strict=True) if np.isfinite(sd)} == massless


def test_a_number_below_zero_has_a_standard_deviation_above(planned):
    """A mass behind the leg's line is as well known as one as far ahead of it."""
    of_each = []
    for offset in (2e-4, -2e-4):
        there = planned_equations(dataclasses.replace(
            KNOWN, biped=dataclasses.replace(KNOWN.biped, foot_offset=offset)))
        found = of(there, (weighed(KNOWN.biped),))
        of_each.append((found.sd, found.sd_without, np.abs(found.unseen)))
    assert (of_each[1][0] > 0.0).all() and (of_each[1][1] > 0.0).all()
    assert of_each[1][0] == pytest.approx(of_each[0][0], rel=0.1)


def test_a_planned_run_of_legs_that_differ_strikes_with_each_in_its_turn(monkeypatch):
    """Around the strikes that its walk makes samples are left out; its steps last 20 ms more and less in turn."""
    runs, really = [], identifiability_of.run_equations

    def seen(design, own, unknowns, run, model):
        runs.append(run)
        return really(design, own, unknowns, run, model)

    monkeypatch.setattr(identifiability_of, "run_equations", seen)
    biped = dataclasses.replace(KNOWN.biped, other_foot_mass=0.34)
    _, equations, _ = planned_equations(dataclasses.replace(KNOWN, biped=biped))
    [run] = runs
    assert np.ptp(np.diff(run.strikes)) > 0.04 and np.ptp(run.strikes[2:] - run.strikes[:-2]) < 1e-9
    walked = equations.predicted.strikes[:, 0]
    assert len(walked) > 5 and run.strikes[1 : len(walked) + 1] == pytest.approx(walked, abs=1e-7)


def test_once_the_hip_is_weighed_the_shares_are_those_of_the_trial(planned):
    hip = Known("biped.hip_mass", PARAMETERS.biped.hip_mass, 1e-7)
    found = of(planned, (hip,))
    shares = dict(zip(found.names, 100 * found.sd / found.scales, strict=True))
    for name, share in TRIAL.items():
        assert share / 1.3 < shares[name] < 1.3 * share


def test_a_worse_clock_limits_the_leg_length_and_runs_do_not_mend_what_is_common(planned):
    worse = dataclasses.replace(KNOWN, given=dataclasses.replace(KNOWN.settings, clock_sd=2e-3))
    known = (weighed(KNOWN.biped),)
    row = of(planned, known).names.index("biped.leg_length")
    good = of(planned, known)
    bad = of(planned_equations(worse), known)
    assert bad.sd[row] > 4 * good.sd[row]
    assert bad.partners[row].endswith("_clock")
    assert abs(bad.correlations[row]) > 0.95


def test_a_known_length_and_more_runs_tell_more_and_never_less(planned):
    known = (weighed(KNOWN.biped),)
    before = of(planned, known, 2)
    for what, sd, _ in experiments(KNOWN, known, 2)[:4]:
        assert (gains(sd, before) > 1 - 1e-6).all(), what
    many = of(planned, known, 200)
    row = many.names.index("biped.foot_radius")
    assert before.sd[row] / many.sd[row] == pytest.approx(10.0, rel=0.02)


def test_what_is_planned_is_the_fit_that_will_be_made():
    """Without what is fixed; with a lab's gravity, as which lengths go; and what is known is looked for."""
    mass = weighed(PARAMETERS.biped)

    def found(known, fixed=()):
        return identifiability_report.answered(PARAMETERS, Request(known, fixed=fixed), 1).plain["parameters"]

    usual, fixed = found((mass,)), found((mass,), ("biped.leg_inertia",))
    assert {*usual} - {*fixed} == {"biped.leg_inertia"}
    assert fixed["biped.foot_mass"]["sd"] < 0.5 * usual["biped.foot_mass"]["sd"]
    length = found((mass, Known("ground.gravity", 9.81, 0.005)))["biped.leg_length"]
    assert length["sd"] == pytest.approx(np.hypot(usual["biped.leg_length"]["sd"], 0.333 * 0.005 / 9.81), rel=0.1)
    with pytest.raises(WrongOption, match=r"known\.leg_inertia: is not looked for"):
        found((Known("biped.leg_inertia", 8e-4, 1e-5),), ("biped.leg_inertia",))


def test_the_command_says_what_runs_tell_without_any_recording(tmp_path):
    done = commands.run("calibrate", "--identifiability", "--runs", 2, "--json", "--results", tmp_path,
                        "--set", "biped.leg_inertia=8.576e-4", cwd=ROOT)  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert "weigh the robot" in found["not_seen"][0]["in_words"]
    assert found["parameters"]["biped.hip_mass"]["sd_not_weighed"] is None
    assert found["parameters"]["biped.leg_length"]["sd"] < found["parameters"]["biped.leg_length"]["sd_one_run"]


def test_the_command_goes_by_what_is_recorded_and_a_robot_goes_on_with_sensors_alone(monkeypatch):
    """Of each way only what it is given is looked at here: encoders' angles, sensors, sensors of a robot, a plan."""
    done = []
    plan = identifiability_report
    for way, name in ((angle_report, "calibrated"), (sensor_report, "calibrated"), (plan, "answered")):
        monkeypatch.setattr(way, name, lambda *given, of=way: done.append((of, given)))
    monkeypatch.setattr(angle_report, "answered", lambda found: found)
    monkeypatch.setattr(FittedRobot, "read", lambda path, option: (path, option))
    asking = SimpleNamespace(progress=lambda share, what: None, reading="reading")

    def asked(text="", **options):
        about = Described(yaml_text.parse(text, "known.yaml"), "known.yaml") if text else None
        ask(PARAMETERS, Options(about=about, **options), asking)
        return done.pop()

    of_angles = PARAMETERS.biped, PARAMETERS.slope, None, Path("steps.CSV"), "reading"
    assert asked(source="steps.CSV") == (angle_report, of_angles)
    for robot, before in ((None, None), ("mine", (Path("mine"), "continue"))):
        of, (*_, recorded, _, known) = asked(source="lab.sqlite", robot=robot)
        assert (of, recorded, known) == (sensor_report, Path("lab.sqlite"), before)
    of, (*_, request, runs) = asked("free: [hip_mass]", source="steps.csv", identifiability=True, runs=7)
    assert (of, request.free, runs) == (plan, ("biped.hip_mass",), 7)
    assert asked(identifiability=True)[1][-1] == PARAMETERS.settings.planned_runs
    goes_on = "goes on with recordings of sensors at hip and foot alone"
    for refused, said in (({}, "name the recordings"), ({"robot": "mine", "source": "a.c3d"}, goes_on),
                          ({"robot": "mine"}, goes_on), ({"robot": "mine", "identifiability": True}, goes_on),
                          *(({"robot": "mine", "source": "lab.sqlite", "text": f"{key}: {value}"}, f"{key} is that of")
                            for key, value in (("free", "[hip_mass]"), ("fixed", "[hip_mass]"), ("design", "parts")))):
        with pytest.raises(WrongOption, match=said):
            asked(**refused)


def test_a_lever_arm_that_is_not_measured_leaves_the_inertia_open_and_the_length_as_it_is(planned):
    """Where the foot sensor sits and the lower legs' inertia show nearly the same."""
    known = (weighed(KNOWN.biped),)
    measured = of(planned, known)
    open_ = of(planned_equations(PARAMETERS), known)
    wider = dict(zip(measured.names, open_.sd / measured.sd, strict=True))
    assert wider["biped.leg_inertia"] > 5.0 and wider["biped.foot_com"] > 3.0 and wider["biped.leg_length"] < 1.1
    assert open_.partners[measured.names.index("biped.leg_inertia")] == "foot_place"


def test_a_first_guess_without_a_gait_is_said_to_be_one_with_where_it_stands():
    """Whatever the recording shows: a fit begins with its walk."""
    flat = DesignPoint(PARAMETERS.biped, dataclasses.replace(PARAMETERS.slope, slope_deg=0.3))
    with pytest.raises(NoGait, match=r"first guess has no gait.* 0\.3 deg \(ground\.slope_deg\).*params/biped\.yaml.*"
                                     r"--set biped\.KEY=VALUE.* lost at 0\.45"):  # fmt: skip
        first_model(flat, ("biped.foot_mass",), PARAMETERS)
