"""The compiled penalty walker against Exudyn's model: one step, ten steps, solved cycles, by a seed, hard sets too."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from stages.multibody.parameters import Settings as ExudynSettings
from stages.multibody.walking.walk import simulate as exudyn_walk
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings, foot_acceleration, simulate
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

    def on(contact, design=biped, **changed):
        machine, stance = dataclasses.replace(design, **changed), rough
        if machine.legs == "rigid":
            lengths = [machine.leg(leg).leg_length for leg in (0, 1)]
            stance = dataclasses.replace(rough, stance_length=lengths[0], swing_length=lengths[1])
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
        return SimpleNamespace(step=SimpleNamespace(length=0.1 + off, duration=1.0, numbers=np.zeros(10)))

    for name, put in (("PenaltyStepper", Taker), ("SectionWalker", OfExudyn), ("corrected", corrected),
                      ("fixed_point", lambda walker, numbers: SimpleNamespace(numbers=numbers))):
        monkeypatch.setattr(walks, name, put)
    assert between_cycles("a cycle", Machine(biped, slope, contact, 1e-8), None, np.zeros(10)).fine is not truly


@pytest.mark.parametrize("changed", [{"legs": "rigid"}, {"leg_inertia": 5e-4}])
def test_rigid_legs_and_legs_with_inertia_are_the_same_too(placed, contact, changed):
    distance = over_a_walk("a step", *placed(contact, **changed), duration=0.3)
    assert distance.fine, distance


@pytest.mark.parametrize(("seed", "drawn"), [(OF_ONE, 1), pytest.param(SEED, 3, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("legs", "duration"), [("compliant", None), ("rigid", 0.3)])
def test_detailed_designs_are_the_same_too(placed, biped, contact, legs, duration, seed, drawn):
    """Frames, masses off the line, legs that differ, the hip's spring, damper, friction and weight; drawn by a seed."""
    for design, ground in zip(drawn_designs(dataclasses.replace(biped, legs=legs), seed, drawn),
                              drawn_sets(contact, seed, drawn, "impact"), strict=True):  # fmt: skip
        assert design.detailed and not design.alike
        distance = over_a_walk("a step", *placed(ground, design), duration=duration)
        assert distance.fine and distance.distance < 1e-9, (design, ground, distance)


@pytest.mark.parametrize(("detailed", "end", "names"), [
    (False, 0.45, ("ground_reaction", "foot_acceleration", "acceleration")), (True, 0.25, ("foot_acceleration",))])
def test_forces_and_the_foot_sensor_are_the_same(placed, biped, contact, detailed, end, names):
    """Also the sensor of a foot off its line, which feels that it is."""
    machine, start = placed(contact, next(drawn_designs(biped, SEED, 1)) if detailed else biped)
    model = machine.biped, machine.slope, contact
    other = exudyn_walk(*model, start, ExudynSettings.of_one_step(1e-8, 2e-4), steps=1)
    ours = simulate(*model, start, Settings(COMPILED), steps=1)
    assert ours.completed and other.completed and ours.heel_strikes == other.heel_strikes == 1
    time, own = np.linspace(1e-3, end, 400), ours.trajectory
    for name in names:
        one, two = (
            np.array([np.interp(time, run.time, column) for column in getattr(run, name).reshape(len(run.time), -1).T])
            for run in (own, other.trajectory)
        )
        assert np.median(np.abs(one - two)) < 1e-5 * np.abs(one).max(), name
    straight = dataclasses.replace(machine.biped, foot_offset=0.0)
    moved = np.abs(foot_acceleration(own.position, own.velocity, own.acceleration, straight) - own.foot_acceleration)
    assert (moved.max() > 1e-3 * np.abs(own.foot_acceleration).max()) == detailed


@pytest.mark.slow
def test_the_cycle_of_legs_that_differ_is_the_same(placed, biped, contact):
    machine, state = placed(
        contact, next(drawn_designs(biped, SEED, 1)), hip_stiffness=0.0, hip_rest_angle=0.0, hip_friction=0.0,
        other_leg_length=biped.leg_length + 1e-4, other_foot_mass=None, other_frame_mass=None)
    stepper = PenaltyStepper(machine.biped, machine.slope, contact, state, Settings(1e-7))
    near = gait_near(stepper, state).section_state
    assert stepper.steps_a_cycle == 2
    distance = between_cycles("a cycle", dataclasses.replace(machine, tolerance=1e-8), state, near)
    assert distance.distance < 1e-8, distance  # the tolerance of Exudyn's steps, of which some 20 % is seen


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
