"""A signal that is not named is not recorded, has no sensor, and costs nothing; the walk stays the same."""

import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from stages.biped.walk import NotRecorded, require
from stages.ground.friction import Lane
from stages.multibody.assembly.inventory import bytes_of, take_inventory
from stages.multibody.assembly.system import VERSION
from stages.multibody.parameters import Parameters, Settings
from stages.multibody.run import Inputs, run
from stages.multibody.walking.cycle import walked_cycle
from stages.multibody.walking.walk import simulate
from stages.planar.sampling import sample
from stages.planar.signals import SIGNALS

#: Signal -> (attribute of the result, attribute of its walk).
WHERE = {"ground_reaction": (None, "ground_reaction"), "imu": (None, "foot_specific_force"),
         "slip": ("slip_velocity", None), "penetration": ("penetration", None)}  # fmt: skip
NUMBERS_A_ROW = {"tree": {(): 21, ("imu",): 25, ("ground_reaction",): 29, SIGNALS: 33},
                 "joints": {(): 24, ("imu",): 36, ("ground_reaction",): 32, SIGNALS: 44}}  # fmt: skip


@pytest.mark.parametrize("assembly", ["tree", "joints"])
def test_exudyn_records_what_is_named_and_solves_the_same(scene, start, assembly):
    """Numbers a row: 7 for coordinates (4 for each of three bodies), as many for rates; 4 for a force or a foot."""
    chosen, found = scene.but(assembly=assembly), {}
    for signals in NUMBERS_A_ROW[assembly]:
        machine = chosen.build(signals=signals)
        done = chosen.walk(start, duration=0.03, assembly=machine)
        found[signals] = done, take_inventory(machine.mbs), len(machine.mbs.GetSensorStoredData(0))
    full, held, _ = found[SIGNALS]
    for signals, (done, own, rows) in found.items():
        assert own.recorded_bytes == 8 * NUMBERS_A_ROW[assembly][signals] * rows
        assert own.sensors < held.sensors or signals == SIGNALS
        assert (own.bodies, own.contact_pairs) == (held.bodies, held.contact_pairs)
        assert done.solver_steps == full.solver_steps
        for name in ("time", "position", "velocity"):
            assert np.array_equal(getattr(done.trajectory, name), getattr(full.trajectory, name))


def awaited(model, state, run, walk):
    return walked_cycle(run, walk, model.contact, model.biped.foot_radii), None, ""


@pytest.fixture(scope="module")
def results(scene, rough):
    """The stage's result for all signals, for all but one, and for none."""
    loose = scene.but(tolerance=1e-4, largest_step=2e-3, sampling_rate_hz=500.0)
    force = SimpleNamespace(standing_force=9.4)
    gait, limp = SimpleNamespace(step_length_m=0.16), SimpleNamespace(feet_apart_m=np.full(2, 0.12))
    inputs = Inputs(SimpleNamespace(walk=force, mid_stance=rough, gait=gait, limp=limp))
    chosen = {name: tuple(other for other in SIGNALS if other != name) for name in SIGNALS}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stages.multibody.run.solve", awaited)
        return {
            name: run(Parameters(**vars(loose.but(signals=signals))), inputs)
            for name, signals in {"all": SIGNALS, "none": (), **chosen}.items()
        }


@pytest.mark.parametrize("name", SIGNALS)
def test_a_signal_left_out_is_not_in_the_result_and_the_others_are(results, name):
    full, less = results["all"], results[name]
    for other, (own, of_walk) in WHERE.items():
        rows = len(getattr(less, own) if own else getattr(less.walk, of_walk))
        assert rows == (0 if other == name else len(less.walk.time))
    assert less.inventory.sampled_bytes < full.inventory.sampled_bytes
    assert np.array_equal(less.walk.hip_position, full.walk.hip_position)


def test_motion_alone_gives_the_same_gait(results):
    full, bare = results["all"], results["none"]
    assert bare.cycle.period_s == full.cycle.period_s and bare.energy == full.energy
    assert np.isnan(bare.cycle.peak_normal_force) and full.cycle.peak_normal_force > 9.4
    assert bare.inventory.sensors == 3
    assert full.inventory.sampled_bytes == bytes_of(full.walk, full.penetration, full.slip_velocity)


def test_the_rate_asked_for_is_the_rate_sampled(two_steps, slope, biped):
    """Away from heel strikes, where it is denser."""
    for rate in (200.0, 1000.0):
        walk = sample(two_steps.trajectory, biped, slope, rate)
        assert np.median(np.diff(walk.time[walk.time < walk.heel_strike_time[0] - 2e-3])) == pytest.approx(1 / rate)


def test_a_missing_signal_is_told_by_name():
    with pytest.raises(NotRecorded, match=r"multibody\.signals leaves out imu"):
        require("multibody", {"imu": np.zeros((0, 2)), "slip": np.zeros((3, 2))})


def test_a_signal_named_twice_is_refused(scene):
    assert not list(scene.settings.broken_rules())
    assert [broken.key for broken in scene.but(signals=("imu", "imu")).settings.broken_rules()] == ["signals"]


# --- A scene holds what is named and no more, and what it leaves out costs nothing.


LANES = Lane(0.0, 0.32, 0.08), Lane(0.16, 0.32, 0.08)


@pytest.mark.parametrize(("changes", "lanes", "held"), [
    ({}, None, (3, 6, 6, 2, 2)),
    ({"legs": "rigid"}, None, (3, 4, 4, 0, 2)),
    ({"assembly": "joints"}, None, (3, 9, 2, 2, 2)),
    ({"legs": "rigid", "assembly": "joints"}, None, (3, 9, 2, 0, 2)),
    ({}, LANES, (3, 6, 6, 2, 2)),
    ({"friction": "none"}, None, (3, 6, 6, 2, 2)),
    ({"friction": "coulomb"}, None, (3, 6, 6, 2, 2)),
    ({"normal_force": "restitution"}, None, (3, 6, 6, 2, 2)),
])
def test_each_assembly_holds_what_is_named(scene, changes, lanes, held):
    """Hip and two feet; two coordinates of the hip and one or two a leg; rigid legs bring no spring and no slide.

    Blocks and laws change the law of the contacts that are there.
    """
    found = take_inventory(scene.but(**changes).build(lanes).mbs)
    assert (found.bodies, found.coordinates, found.joints, found.springs, found.contact_pairs) == held


def test_what_a_scene_leaves_out_costs_nothing(scene, start):
    """Values of laws and scenes that are not chosen change neither the solver's steps nor a bit of the walk."""
    coarse = scene.but(tolerance=1e-5, largest_step=2e-3)
    idle = coarse.but(rolling_step=1e-3, impact_step=5e-4, impact_window=0.05, restitution=0.7,
                      impact_speed=2.0)  # fmt: skip
    usual, other = (each.walk(start, steps=1) for each in (coarse, idle))
    assert other.solver_steps == usual.solver_steps
    assert np.array_equal(other.trajectory.position, usual.trajectory.position)


# --- Exudyn's fast build, which has no range checks, walks as the checked one does.


#: Two steps with the contact set and the solver of `conftest`; an attribute of sys refuses the fast build.
WALK = """
import json, sys
sys.exudynFast = False
from stages.biped.design import Biped
from stages.biped.walk import StanceState
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.parameters import Settings
from stages.multibody.assembly.system import VERSION
from stages.planar.run import (rolling_state)
from stages.multibody.walking.walk import simulate
biped = Biped("compliant", 0.316, 0.335, 0.333, 0.083, 0.1, 2800.0, 58.35, 0.0)
contact = ContactLaw(1e5, 2.2, 1e4, 1e-4, 1.1, 1.0, 0.1, 1.0)
start = rolling_state(biped, contact, StanceState(0.0, 0.331, 0.27, 0.334, 0.71, 0.0, 1.8, 0.0), normal_force=9.4)
run = simulate(biped, Slope(2.0, 9.81), contact, start, Settings.of_one_step(1e-9, 5e-4), duration=0.9)
end = run.trajectory.at(run.trajectory.time[-1:])
print(json.dumps([VERSION, run.outcome, run.solver_steps, *end[0][0], *end[1][0]]))
"""


def test_the_fast_build_walks_as_the_checked_one(biped, slope, contact, start):
    answer = subprocess.run([sys.executable, "-c", WALK], capture_output=True, text=True, check=True)
    version, outcome, steps, *end = json.loads(answer.stdout)  # nothing but that: the build prints nothing of its own
    assert version.endswith("(checked build)") and "checked" not in VERSION
    run = simulate(biped, slope, contact, start, Settings.of_one_step(1e-9, 5e-4), duration=0.9)
    assert outcome == run.outcome == "completed"
    assert abs(steps - run.solver_steps) <= 5
    position, velocity = run.trajectory.at(run.trajectory.time[-1:])
    assert np.abs(np.subtract(end, [*position[0], *velocity[0]])).max() < 1e-8
