"""The compiled penalty walker against Exudyn's model: one step, ten steps, solved cycles, by a seed, hard sets too."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from stages.multibody.parameters import Settings as ExudynSettings
from stages.multibody.walking.walk import simulate as exudyn_walk
from stages.penalty.settings import Settings
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import foot_acceleration, simulate
from stages.planar.limit_cycle import gait_near
from stages.planar.run import rolling_state
from stages.planar.section import NoLimitCycle
from stages.studies import walks
from stages.studies.walks import COMPILED, EXUDYN, Machine, between_cycles, over_a_walk
from tests.penalty.drawn import drawn_designs, drawn_sets

LAWS = ("impact", "restitution")
#: Seeds of the draws: of many, and of one, which Exudyn's solver walks in few steps.
SEED, OF_ONE = 20, 24


@pytest.fixture(scope="module")
def placed(biped, slope, rough):
    """A machine on a contact set, and its start."""

    def on(contact, **changed):
        machine, stance = dataclasses.replace(biped, **changed), rough
        if machine.legs == "rigid":
            stance = dataclasses.replace(rough, stance_length=biped.leg_length, swing_length=biped.leg_length)
        return Machine(machine, slope, contact), rolling_state(machine, contact, stance, 9.4)

    return on


@pytest.mark.parametrize("law", LAWS)
def test_one_step_is_the_same_to_a_nanometre(placed, contact, law):
    drawn = next(drawn_sets(contact, OF_ONE, 1, law))
    machine, start = placed(drawn)
    distance = over_a_walk("a step", dataclasses.replace(machine, tolerance=1e-9), start)
    assert distance.fine and distance.distance < 1e-9, drawn


@pytest.mark.parametrize("off", ["compiled", "exudyn"])
def test_over_one_step_a_tighter_walk_tells_what_a_moment_s_touch_is_worth(biped, slope, contact, off):
    def walked(astray):
        def at(time):
            return np.full((len(time), 6), 5e-9 if astray else 0.0), None
        return SimpleNamespace(outcome="completed", trajectory=SimpleNamespace(time=np.array([0.0, 1.0]), at=at))

    class Touching(Machine):
        def compiled(self, state, tolerance, steps, duration):
            return walked(off == "compiled" and tolerance == COMPILED)

        def exudyn(self, state, tolerance, steps, duration):
            return walked(off == "exudyn" and tolerance == EXUDYN)

    distance = over_a_walk("a step", Touching(biped, slope, contact), None)
    assert distance.fine and distance.distance == 0.0


@pytest.mark.parametrize("truly", [False, True])
def test_two_errors_that_are_alike_by_chance_do_not_pass_for_a_difference(monkeypatch, biped, slope, contact, truly):
    class Taker:
        def __init__(self, *parts):
            self.tolerance = parts[4].tolerance

        def derivative(self, numbers):
            return None

    class OfExudyn(Taker):
        pass

    def corrected(walker, near, derivative):
        off = 5e-9 * isinstance(walker, OfExudyn) * (truly or walker.tolerance > 2e-9)
        return SimpleNamespace(step=SimpleNamespace(length=0.1 + off, duration=1.0), numbers=np.zeros(10))

    for name, put in (("PenaltyStepper", Taker), ("SectionWalker", OfExudyn), ("corrected", corrected),
                      ("fixed_point", lambda walker, numbers: SimpleNamespace(numbers=numbers))):
        monkeypatch.setattr(walks, name, put)
    assert between_cycles("a cycle", Machine(biped, slope, contact, 1e-8), None, np.zeros(10)).fine is not truly


def test_rigid_legs_and_legs_with_inertia_are_the_same_too(placed, contact):
    for changed in ({"legs": "rigid"}, {"leg_inertia": 5e-4}):
        distance = over_a_walk("a step", *placed(contact, **changed), duration=0.3)
        assert distance.fine, (changed, distance)


@pytest.mark.parametrize(("seed", "drawn"), [(OF_ONE, 1), pytest.param(SEED, 3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("legs", ["compliant", "rigid"])
def test_detailed_designs_are_the_same_too(biped, slope, contact, rough, legs, seed, drawn):
    """Frames, masses off the line, legs that differ, the hip's spring, damper, friction and weight; drawn by a seed."""
    for design, ground in zip(drawn_designs(dataclasses.replace(biped, legs=legs), seed, drawn),
                              drawn_sets(contact, seed, drawn, "impact"), strict=True):  # fmt: skip
        assert design.detailed and not design.alike
        lengths = [design.leg(leg).leg_length for leg in (0, 1)]
        stance = rough if legs == "compliant" else dataclasses.replace(
            rough, stance_length=lengths[0], swing_length=lengths[1])
        state = rolling_state(design, ground, stance, 9.4)
        duration = None if legs == "compliant" else 0.3
        distance = over_a_walk("a step", Machine(design, slope, ground), state, duration=duration)
        assert distance.fine and distance.distance < 1e-9, (design, ground, distance)


def test_the_sensor_of_a_foot_off_its_line_is_the_same(biped, slope, contact, rough):
    design = next(drawn_designs(biped, SEED, 1))
    state = rolling_state(design, contact, rough, 9.4)
    other = exudyn_walk(design, slope, contact, state, ExudynSettings.of_one_step(1e-8, 2e-4), steps=1)
    ours = simulate(design, slope, contact, state, Settings(COMPILED), steps=1)
    time = np.linspace(1e-3, 0.25, 400)
    one, two = (
        np.array([np.interp(time, run.trajectory.time, column) for column in run.trajectory.foot_acceleration.T])
        for run in (ours, other)
    )
    plain = dataclasses.replace(design, foot_offset=0.0)
    shifted = foot_acceleration(ours.trajectory.position, ours.trajectory.velocity, ours.trajectory.acceleration, plain)
    assert np.median(np.abs(one - two)) < 1e-5 * np.abs(one).max()
    assert np.abs(shifted - ours.trajectory.foot_acceleration).max() > 1e-3 * np.abs(one).max()


def test_the_cycle_of_legs_that_differ_is_the_same(biped, slope, contact, rough):
    design = dataclasses.replace(
        next(drawn_designs(biped, SEED, 1)), hip_stiffness=0.0, hip_rest_angle=0.0, hip_friction=0.0,
        other_leg_length=biped.leg_length + 1e-4, other_foot_mass=None, other_frame_mass=None)
    state = rolling_state(design, contact, rough, 9.4)
    stepper = PenaltyStepper(design, slope, contact, state, Settings(1e-7))
    cycle = gait_near(stepper, state)
    assert stepper.steps_a_cycle == 2
    distance = between_cycles("a cycle", Machine(design, slope, contact, 1e-8), state, cycle.section_state)
    assert distance.distance < 1e-8, distance  # the tolerance of Exudyn's steps, of which some 20 % is seen


def test_forces_and_the_foot_sensor_are_the_same(placed, contact, biped, slope):
    _, start = placed(contact)
    other = exudyn_walk(biped, slope, contact, start, ExudynSettings.of_one_step(1e-8, 2e-4), steps=1)
    ours = simulate(biped, slope, contact, start, Settings(COMPILED), steps=1)
    assert ours.completed and other.completed and ours.heel_strikes == other.heel_strikes == 1
    time = np.linspace(1e-3, 0.45, 400)
    for name in ("ground_reaction", "foot_acceleration", "acceleration"):
        one, two = (
            np.array([np.interp(time, run.trajectory.time, column) for column in getattr(run.trajectory, name).reshape(
                len(run.trajectory.time), -1).T])
            for run in (ours, other)
        )  # fmt: skip
        assert np.median(np.abs(one - two)) < 1e-5 * np.abs(one).max(), name


def test_the_cycle_is_the_same(placed, contact, gait):
    machine, start = placed(contact)
    distance = between_cycles("a cycle", dataclasses.replace(machine, tolerance=1e-9), start, gait.section_state)
    assert distance.fine and 0.0 < distance.own_error < 1e-8


def test_a_walk_that_ends_otherwise_is_not_fine(placed, contact):
    """Its own check must be able to fail: it does so for another machine."""
    machine, start = placed(contact)
    heavier = dataclasses.replace(machine, biped=dataclasses.replace(machine.biped, foot_mass=0.33501))

    class Mixed(Machine):
        def exudyn(self, *given):
            return heavier.exudyn(*given)

    mixed = Mixed(machine.biped, machine.slope, machine.contact)
    assert not over_a_walk("a step", mixed, start, duration=0.1).fine


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_twenty_sets_over_a_step_and_between_cycles(placed, contact, law):
    cycles = 0
    for drawn in drawn_sets(contact, SEED, 20, law):
        machine, start = placed(drawn)
        assert over_a_walk("a step", machine, start).fine, drawn
        stepper = PenaltyStepper(machine.biped, machine.slope, drawn, start, Settings(1e-9))
        try:
            cycle = gait_near(stepper, start)
            distance = between_cycles("a cycle", machine, start, cycle.section_state)
        except NoLimitCycle:
            continue
        assert distance.fine, (drawn, distance)
        cycles += 1
    assert cycles >= 15


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_ten_steps_differ_by_the_models_own_errors(placed, contact, law):
    for drawn in drawn_sets(contact, SEED, 3, law):
        distance = over_a_walk("a step", *placed(drawn), steps=10)
        assert distance.fine, (drawn, distance)
