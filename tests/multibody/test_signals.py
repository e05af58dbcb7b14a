"""A signal that is not named is not recorded, has no sensor, and costs nothing; the walk stays the same."""

from types import SimpleNamespace

import numpy as np
import pytest

from stages.biped.walk import NotRecorded, require
from stages.multibody.assembly.inventory import bytes_of, take_inventory
from stages.multibody.parameters import Parameters
from stages.multibody.run import Inputs, run
from stages.multibody.walking.cycle import walked_cycle
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
    gait = SimpleNamespace(step_length_m=0.16, fixed_point=rough)
    inputs = Inputs(SimpleNamespace(walk=force, mid_stance=rough, gait=gait))
    chosen = {name: tuple(other for other in SIGNALS if other != name) for name in SIGNALS}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stages.multibody.run.solve", awaited)
        return {
            name: run(Parameters(*vars(loose.but(signals=signals)).values()), inputs)
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
