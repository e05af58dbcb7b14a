"""Walks of the penalty walker by themselves: energy, convergence, how they end, what they record."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.phases.motion import SINGLE_STANCE
from stages.analytic.walk.recording import crossing_state, record
from stages.analytic.walk.sampling import sample_walk
from stages.biped.walk import StanceState
from stages.ground.contact_law import family_member
from stages.ground.friction import static_penetration
from stages.ground.slope import Friction
from stages.penalty.model.walker import build_penalty
from stages.penalty.motion import feet
from stages.penalty.walk import Settings, simulate
from stages.planar.energy import energy_balance
from stages.planar.run import FELL, STALLED, STEP_FLOOR, rolling_state
from stages.planar.sampling import find_events
from stages.planar.signals import GROUND_REACTION

#: Coefficient of friction where contact hardens.
FRICTION = 3.0
#: Standing on one leg, nearly at rest.
STILL = StanceState(0.0, 0.331, -0.1, 0.333, 0.01, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def walked(biped, slope, contact, start):
    return simulate(biped, slope, contact, start, Settings(1e-11, 2), steps=2)


def test_energy_is_accounted_for(walked, biped, slope, contact):
    """Over two steps, gravity's work against the losses in leg dampers, contact damping and friction."""
    assert walked.completed and walked.heel_strikes == 2
    balance = energy_balance(walked.trajectory, biped, slope, contact, 0.0, float(walked.trajectory.time[-1]))
    assert balance.relative_residual < 1e-7
    assert min(balance.leg_damper_loss, balance.contact_damping_loss, balance.friction_loss) > 1e-3


def test_a_tighter_tolerance_comes_nearer(walked, biped, slope, contact, start):
    """Errors in tolerances, their geometric mean over five of them: a step over a corner of the contact now and then
    passes for a good one; where, the last bits of the start decide.
    """
    end = walked.trajectory.position[-1]
    errors = []
    for tolerance in (1e-6, 1e-7, 1e-8, 1e-9, 1e-10):
        run = simulate(biped, slope, contact, start, Settings(tolerance), steps=2, signals=())
        errors.append(np.abs(run.trajectory.position[-1] - end).max() / tolerance)
    assert np.exp(np.log(errors).mean()) < 40, errors


def test_what_is_not_asked_for_is_not_recorded(walked, biped, slope, contact, start):
    bare = simulate(biped, slope, contact, start, Settings(1e-7), steps=1, signals=())
    assert bare.trajectory.ground_reaction.shape[1:] == (0, 2) and bare.trajectory.foot_acceleration.shape[1] == 0
    some = simulate(biped, slope, contact, start, Settings(1e-7), steps=1, signals=(GROUND_REACTION,))
    # the depth is a difference of numbers as large as the leg, after ten roundings: a condition number times round-off
    amplified = contact.contact_exponent * biped.leg_length / static_penetration(contact, 9.4)
    assert some.trajectory.ground_reaction[0, 0, 1] == pytest.approx(9.4, rel=10 * amplified * np.finfo(float).eps / 2)
    assert walked.trajectory.foot_acceleration.shape == (len(walked.trajectory.time), 2)


def test_a_walk_of_a_given_time_ends_there(walked, biped, slope, contact, start):
    for end in (0.1, 0.35, 0.6):
        run = simulate(biped, slope, contact, start, Settings(1e-11), duration=end, signals=())
        assert run.completed and run.trajectory.time[-1] == end
        known = walked.trajectory.at(np.array([end]))[0][0]
        assert run.trajectory.position[-1] == pytest.approx(known, abs=1e-9)


def test_how_walks_end_early(biped, slope, contact, start):
    back = dataclasses.replace(start, hip_velocity=(-0.6, 0.0), leg_rate=(2.0, 0.0))
    run = simulate(biped, slope, contact, back, Settings(1e-8), steps=1)
    assert run.outcome == FELL and "the walker fell at t =" in run.message
    hung = dataclasses.replace(slope, slope_deg=0.0)
    still = rolling_state(biped, contact, STILL, 9.4)
    run = simulate(biped, hung, contact, still, Settings(1e-8, longest_step=0.05), steps=1)
    assert run.outcome == STALLED and run.message.startswith("no heel strike for 0.05 s")
    run = simulate(biped, slope, contact, start, Settings(1e-8, most_solver_steps=20), steps=1)
    assert run.outcome == STEP_FLOOR and "gets nowhere after 20 steps" in run.message


def test_events_lie_between_the_switches(walked, biped):
    """Each leg goes out of play at or after it has left the ground, comes into play ahead, and lands after that."""
    found = find_events(walked.trajectory, biped.foot_radii)
    outs = {leg: time for time, leg, acts in walked.trajectory.switches if not acts}
    ins = {leg: time for time, leg, acts in walked.trajectory.switches if acts and time > 0.0}
    assert len(found.heel_strike_time) == 2 and set(outs) == {0, 1}
    for leg in (0, 1):
        off = found.toe_off_time[found.toe_off_leg == leg]
        assert off[0] <= outs[leg] + 1e-9
    assert ins[0] < found.heel_strike_time[found.heel_strike_leg == 0][-1]


@pytest.mark.parametrize("legs", ["compliant", "rigid"])
def test_as_contact_hardens_it_walks_as_the_constraint_model_does(biped, slope, contact, legs):
    """With Coulomb's transition; what sets it apart is of first order in the share of contact's effects.

    The coefficient is one at which little is of the orders between: extrapolated in whole ones, .02 of it is left.
    """
    machine = dataclasses.replace(biped, legs=legs)
    friction = Friction(FRICTION, FRICTION)
    walker, point = find_gait(machine, slope, 1e-11, friction)
    upright = crossing_state(walker, point.z, 1e-11)
    phase = SINGLE_STANCE if legs == "compliant" else 0
    walk = sample_walk(walker, record(walker, upright, 2, 1e-11, phase), 5000.0)
    base = dataclasses.replace(
        contact, static_friction=FRICTION, dynamic_friction=FRICTION, stiction_velocity=0.02)
    time = walk.time[(walk.time < 0.45) & (np.abs(walk.time - walk.heel_strike_time[0]) > 5e-3)]
    away = []
    for share in (0.1, 0.05, 0.025):
        law = family_member(base, share)
        state = rolling_state(machine, law, walker.stance_state(upright), walk.standing_force)
        run = simulate(machine, slope, law, state, Settings(1e-9), duration=0.47, signals=())
        hip = run.trajectory.at(time)[0][:, :2]
        away.append(np.abs(hip - walk.hip_position[np.isin(walk.time, time)]).max())
    far, middle, near = away
    assert abs(8.0 * near - 6.0 * middle + far) / 3.0 < 0.1 * near


@pytest.mark.parametrize("ahead", [0.1, -0.1])
def test_a_foot_is_in_the_air_once_it_is_above_the_ground_by_a_millionth_of_its_leg(biped, slope, contact, ahead):
    """However little it clears: ahead of the other foot the ground acts on it again, behind it no longer."""
    p, y = build_penalty(biped, slope.gravity_vector, contact, 0.5), np.zeros(12)
    reach = biped.leg_length - biped.foot_radius
    y[2:4], y[4:6] = (np.arcsin(ahead / reach), 0.0), biped.leg_length
    y[8] = 1.0  # it swings forward
    phase = feet.phase_of(feet.OUT if ahead > 0 else feet.LANDED, feet.LANDED, 0)
    for above, flies in ((1e-6, True), (-1e-6, False)):
        y[1] = biped.foot_radius + reach * np.cos(y[2]) + above * biped.leg_length
        assert (feet.leg_guard(phase, y, p, 0, y, 0)[0] < 0) == flies
