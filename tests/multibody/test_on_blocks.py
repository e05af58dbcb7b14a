"""Walks over blocks of drawn heights: each model falls on the same block, and events and energy know the heights."""

import math
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from pipeline.parameters.loading import load
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import start_state
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.biped.accuracy.scales import scales_of
from stages.ground.blocks import Blocks, BlocksDoNotFit
from stages.ground.friction import lanes
from stages.penalty.walk import Settings as PenaltySettings
from stages.penalty.walk import begin, numbers_of
from stages.planar.energy import energy_balance
from stages.planar.run import COMPLETED, FELL, rolling_state
from stages.planar.sampling import find_events
from stages.stability.blocks.walks import Rough, heights_of, walk_on
from stages.stability.parameters import Parameters as Stability
from stages.twin.machine.machine import build as build_machine
from stages.twin.parameters import Parameters as Twin
from stages.twin.ramp import lay_blocks
from stages.twin.walking.measures import energy_balance as spatial_balance
from stages.twin.walking.record import find_events as spatial_events
from stages.twin.walking.simulate import rolling_start, simulate_twin

#: Heights over which Table 1 walks some steps, and a walk of it.
HIGH, WALK, MOST = 6e-4, 2, 30


@pytest.fixture(scope="module")
def hard(scene):
    """On ground as hard as the study's the models fall in the same step: on Adams' soft one they need not."""
    return scene.but(contact_stiffness=3e5, contact_damping=3e4, stiction_velocity=0.03)


@pytest.fixture(scope="module")
def gait(biped, slope):
    walker, point = find_gait(biped, slope, 1e-9)
    walk, upright = walk_from_mid_stance(walker, point.z, 1, 1e-9, 1000.0)
    apart = walker.stance_state(start_state(walker, point.z)).feet_apart(biped.foot_radii)
    return walker, point, upright, walk.standing_force, apart


def test_feet_of_the_gait_land_so_far_apart(biped, gait):
    walker, point, *_, apart = gait
    assert Rough(walker, point.z, 0.0, 0.1).middle * walker.length == pytest.approx(apart, rel=1e-12)
    with pytest.raises(BlocksDoNotFit, match=r"ground.block_length = 0.3 m .* allowed: < 0.2414 m"):
        Blocks(HIGH, block_length=0.3).under(0, apart)
    assert Blocks().under(0, apart) is None


def test_planar_models_fall_in_the_same_step(hard, biped, slope, gait):
    (walker, point, upright, force, apart), contact = gait, hard.contact
    start, laid = rolling_state(biped, contact, upright, force), Blocks(HIGH).under(WALK, apart)
    rough = Rough(walker, point.z, HIGH / walker.length, Blocks().block_length / walker.length)
    made = walk_on(rough, islice(heights_of(0, WALK), MOST)).steps
    penalty = begin(
        numbers_of(biped, slope, contact), scales_of(biped, slope.gravity), start, PenaltySettings(1e-7), MOST, laid)
    penalty.go_on()
    run = hard.but(tolerance=1e-6, largest_step=1e-3).walk(start, steps=MOST, blocks=laid)
    assert (penalty.outcome, penalty.heel_strikes) == (run.outcome, run.heel_strikes) == (FELL, made) and made > 3
    assert penalty.time == pytest.approx(float(run.trajectory.time[-1]), abs=3e-3)


@pytest.mark.parametrize("rows", [False, True])
def test_events_and_energy_know_the_heights(scene, biped, slope, contact, gait, rows):
    *_, upright, force, apart = gait
    start, laid = rolling_state(biped, contact, upright, force), Blocks(3e-4).under(WALK, apart)
    lying = lanes(0.1612, 0.08) if rows else None
    run = scene.walk(start, steps=3, blocks=laid, lanes=lying)
    strikes = find_events(run.trajectory, biped.foot_radii).heel_strike_time
    assert run.outcome == COMPLETED and len(strikes) == 3
    heights = np.diag(run.trajectory.under(strikes)[:, [1, 0, 1]])
    assert heights == pytest.approx([laid.height(number) for number in range(3)])
    balance = energy_balance(run.trajectory, biped, slope, contact, float(strikes[0]), float(strikes[2]))
    assert balance.relative_residual < 1e-5


@pytest.mark.parametrize("rows", [False, True])
def test_the_twin_walks_on_them_too(repository, gait, rows):
    *_, upright, force, apart = gait
    given = load(repository / "params", [], {"twin": Twin}, [Twin, Stability])["twin"]
    machine, laid = build_machine(given.biped, given.settings), Blocks(3e-4).under(WALK, apart)
    ramp = lay_blocks(given.settings, Blocks(), 0.1612) if rows else None
    start = rolling_start(machine, given.contact, upright, force)
    record = simulate_twin(
        machine, given.slope, given.contact, start, given.settings, steps=3, ramp=ramp, blocks=laid)
    events = spatial_events(record)
    assert record.outcome == COMPLETED and len(events.heel_strike_time) == 3
    heights = record.under(events.heel_strike_time)[np.arange(3), events.heel_strike_leg]
    assert heights == pytest.approx([laid.height(number) for number in range(3)])
    first, last = events.heel_strike_time[[0, 2]]
    assert spatial_balance(record, float(first), float(last)).relative_residual < 1e-4


def test_a_foot_that_lands_beyond_its_block_has_fallen(scene, biped, slope, contact, gait):
    *_, upright, force, apart = gait
    short = replace(Blocks(1e-4).under(WALK, apart), ends=0.9 * apart)
    start = rolling_state(biped, contact, upright, force)
    run = scene.but(tolerance=1e-6, largest_step=1e-3).walk(start, steps=2, blocks=short)
    penalty = begin(
        numbers_of(biped, slope, contact), scales_of(biped, slope.gravity), start, PenaltySettings(1e-7), 2, short)
    penalty.go_on()
    for outcome, message in ((run.outcome, run.message), (penalty.outcome, penalty.message)):
        assert outcome == FELL and "came down beyond its block" in message
    assert math.isclose(penalty.time, float(run.trajectory.time[-1]), abs_tol=3e-3)
