"""The gait as a fixed point with its multipliers, and walks that do not settle, which are called so."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.recording import crossing_state
from stages.ground.contact_law import ContactLaw
from stages.multibody.result import Result
from stages.multibody.walking.cycle import COARSE, Model, limit_cycle, search, solve, solved_cycle, unsettled
from stages.multibody.walking.walk import simulate
from stages.penalty.settings import Settings as PenaltySettings
from stages.penalty.step_map import PenaltyStepper
from stages.planar.limit_cycle import by_differences, fixed_point, gait_near
from stages.planar.run import rolling_state
from stages.planar.sampling import sample
from stages.planar.section import NoLimitCycle, SectionStep, section_state
from tests.planar_start import SCALES

FIXED = np.linspace(0.2, 1.1, 10) * SCALES
BASIS = np.eye(10) + 0.1 * np.random.default_rng(3).normal(size=(10, 10))
MULTIPLIERS = np.array([-1.9, 0.6, 0.3, 0.01, *np.zeros(6)])
MAP = BASIS @ np.diag(MULTIPLIERS) @ np.linalg.inv(BASIS)


class MadeUp:
    """Takes the steps of a made-up map, and keeps where from."""

    steps_a_cycle, scales = 1, SCALES

    def __init__(self, step, size, tolerance=1e-6):
        self.map, self.size, self.tolerance, self.taken = step, size, tolerance, []

    def step(self, numbers):
        self.taken.append(numbers)
        return SectionStep(self.map(numbers), None, 0.5, 0.16, 100)

    @property
    def steps_walked(self):
        return len(self.taken)

    def derivative(self, numbers, after=None):
        return by_differences(self.step, numbers, self.size * SCALES, after)


def bent(numbers):
    """A step map with the multipliers above, not linear."""
    off = (numbers - FIXED) / SCALES
    return FIXED + SCALES * (MAP @ off + 0.5 * off**2)


def test_an_unstable_fixed_point_of_a_bent_map_is_found():
    found = fixed_point(MadeUp(bent, 1e-6, 1e-10), FIXED + 0.02 * SCALES)
    assert found.residual < 1e-10
    assert found.numbers / SCALES == pytest.approx(FIXED / SCALES, abs=1e-9)


def test_a_kept_derivative_is_corrected_on_the_way():
    walker = MadeUp(bent, 1e-6, 1e-8)
    similar = 1.05 * MAP * SCALES[:, None] / SCALES
    found = fixed_point(walker, FIXED + 0.02 * SCALES, similar)
    assert found.numbers / SCALES == pytest.approx(FIXED / SCALES, abs=1e-7)
    assert len(walker.taken) < 10  # a derivative alone would take ten


@pytest.mark.parametrize(("central", "steps", "within"), [(True, 20, 1e-9), (False, 10, 1e-6)])
def test_multipliers_at_a_gait_are_those_of_the_map(start, central, steps, within):
    """Central differences have no error of the size of the difference, forward ones have, and cost half."""
    walker = MadeUp(bent, 1e-6, 1e-10)
    found = gait_near(walker, section_state(FIXED, start), central=central)
    assert len(walker.taken) == 1 + steps and np.array_equal(found.section_state, FIXED)
    assert found.floquet_multipliers[:4, 0] == pytest.approx(MULTIPLIERS[:4], abs=within)


def test_a_search_ends_where_the_steps_own_error_does():
    """A made-up error of fifty tolerances, which no residual gets below for long: what is found is within it.

    Without the error the residual falls to the tolerance, however far beyond what a walk of the same steps needs.
    """
    tolerance = 1e-8

    def rough(numbers):
        return bent(numbers) + 50.0 * tolerance * SCALES * np.sin(1e12 * numbers)

    for step, within in ((bent, tolerance), (rough, 100.0 * tolerance)):
        walker = MadeUp(step, 1e-6, tolerance)
        found = fixed_point(walker, FIXED + 0.02 * SCALES, MAP * SCALES[:, None] / SCALES)
        assert found.residual == np.abs((step(found.numbers) - found.numbers) / SCALES).max() <= within
        assert np.abs((found.numbers - FIXED) / SCALES).max() < 10.0 * within and len(walker.taken) < 10


def test_a_derivative_that_leads_away_is_made_anew_before_its_change_is_taken():
    """Nearly singular in one direction: its first change is ten times the distance, and the bent map leads on."""
    poor = BASIS @ np.diag([*MULTIPLIERS[:3], 0.999, *MULTIPLIERS[4:]]) @ np.linalg.inv(BASIS)
    walker = MadeUp(bent, 1e-6, 1e-10)
    found = fixed_point(walker, FIXED + 0.02 * SCALES, poor * SCALES[:, None] / SCALES)
    assert np.abs((found.numbers - FIXED) / SCALES).max() < 1e-9
    away = [np.abs((taken - FIXED) / SCALES).max() for taken in walker.taken]
    assert sum(far > 0.1 for far in away) == 1 and len(walker.taken) < 30


@pytest.mark.parametrize("derivative", [None, np.eye(10), (1.0 - 1e-14) * np.eye(10)])
def test_a_map_without_fixed_point_is_told(derivative):
    """Its derivative is one but for the round-off of differences, and Newton's change is infinite or nearly so."""
    with pytest.raises(NoLimitCycle, match="no fixed point in reach"):
        fixed_point(MadeUp(lambda numbers: numbers + SCALES, 1e-4), FIXED, derivative)


def test_a_map_that_moves_every_state_is_told():
    """Each number by its scale at least, and by more the further away: Newton's method goes to and fro."""
    walker = MadeUp(lambda numbers: numbers + SCALES * (1.0 + ((numbers - FIXED) / SCALES) ** 2), 1e-4)
    with pytest.raises(NoLimitCycle, match="no fixed point within 16 iterations, residual"):
        fixed_point(walker, FIXED + 0.5 * SCALES)


@pytest.fixture(scope="module")
def from_gait(biped, slope, contact, settings):
    """Model, mid-stance of the constraint model's gait and a walk from it, for changes of biped, slope or ground.

    `before`: steps of the compiled walker that lead from there to where the walk begins, nearer to the gait.
    """

    def prepared(steps, slope_deg=2.0, contact=contact, before=0, largest_step=settings.largest_step, **changed):
        machine, ground = dataclasses.replace(biped, **changed), dataclasses.replace(slope, slope_deg=slope_deg)
        walker, point = find_gait(machine, ground, 1e-9, None)
        upright = walker.stance_state(crossing_state(walker, point.z, 1e-9))
        state = rolling_state(machine, contact, upright, 9.4)
        if before:
            state = PenaltyStepper(machine, ground, contact, state, PenaltySettings(1e-7)).walk(state, before).state
        coarse = dataclasses.replace(settings, tolerance=1e-7, largest_step=largest_step)
        model = Model(machine, ground, contact, coarse)
        walked = simulate(machine, ground, contact, state, model.settings, steps=steps)
        return model, state, walked, sample(walked.trajectory, machine, ground, 500.0)

    return prepared


@pytest.fixture(scope="module")
def settled(from_gait):
    """The study's gait: model, mid-stance, eight steps from there, their samples, and what `solve` says of them.

    The tolerance is one for which multipliers come from forward differences, and the walk nearly settles: so the gait
    is looked for where it ends, and one derivative does.
    """
    model, state, walked, walk = from_gait(8, before=6, largest_step=1e-3)
    return model, state, walked, walk, solve(model.at(2e-7), state, walked, walk)


def test_a_step_from_the_cycle_ends_on_it_and_a_walk_settles_there(settled):
    model, state, _, walk, (cycle, found, reason) = settled
    assert cycle.solved and not reason
    assert cycle.residual < COARSE
    gait = found.section_state
    again = model.walker(state).step(gait)
    assert np.abs((again.numbers - gait) / SCALES).max() < 1e-5
    periods = np.diff(walk.heel_strike_time)
    shrunk = abs(periods[-1] - cycle.period_s) / abs(periods[1] - cycle.period_s)
    assert 0.0 < shrunk < 2.0 * cycle.largest_multiplier ** (len(periods) - 2)
    assert cycle.peak_normal_force > 9.4 and cycle.double_stance_s == pytest.approx(
        walk.double_stance(walk.heel_strike_time[-2:]), rel=0.02
    )


def test_the_cycle_is_that_of_another_walker_at_a_far_finer_tolerance(settled):
    model, state, _, _, (cycle, _, _) = settled
    other = gait_near(PenaltyStepper(model.biped, model.slope, model.contact, state, PenaltySettings(1e-12)), state)
    assert (cycle.period_s, cycle.step_length_m) == pytest.approx((other.period_s, other.step_length_m), abs=3e-8)


def test_a_short_walk_has_not_settled_yet(settled):
    model, state, _, whole, (cycle, _, _) = settled
    far = dataclasses.replace(state, hip_velocity=(1.1 * state.hip_velocity[0], state.hip_velocity[1]))
    walked = simulate(model.biped, model.slope, model.contact, far, model.settings, steps=2)
    walk = sample(walked.trajectory, model.biped, model.slope, 500.0)
    assert "stable, but after 2 steps the last one still differs by" in unsettled(walked, walk, cycle, "")
    away = dataclasses.replace(cycle, floquet_multipliers=np.array([[-1.05, 0.0], [0.6, 0.0]]))
    assert unsettled(walked, whole, away, "") == "its gait is unstable, largest multiplier 1.050 in magnitude"


@pytest.mark.parametrize("changed", [
    pytest.param({"slope_deg": 6.0}, marks=pytest.mark.slow),
    pytest.param({"damping": 0.0}, marks=pytest.mark.slow),
    pytest.param({"leg_inertia": 0.003}, marks=pytest.mark.slow),
])
def test_a_walk_that_does_not_settle_is_called_so(from_gait, changed):
    """Twelve steps of these are finished on this ground, with periods that differ by 17 to 21 %.

    The tolerance is one for which multipliers come from forward differences.
    """
    ground = ContactLaw(3e5, 2.2, 3e4, 1e-4, 1.1, 1.0, 0.03, 1.0)
    model, state, walked, walk = from_gait(3, contact=ground, **changed)
    assert walked.completed
    cycle, found, reason = solve(model.at(2e-7), state, walked, walk)
    assert cycle.solved and cycle.residual < 1e-5
    assert np.array_equal(found.floquet_multipliers, cycle.floquet_multipliers)
    assert cycle.largest_multiplier > 1.05 and reason.startswith("its gait is unstable, largest multiplier")


@pytest.mark.slow
def test_a_gait_that_is_not_found_is_told(from_gait):
    """Undamped legs on softer ground: the constraint model's gait is no start from which one is found."""
    model, state, walked, walk = from_gait(3, damping=0.0)
    cycle, found, reason = solve(model, state, walked, walk)
    assert not cycle.solved and found is None and reason.startswith("no fixed point of its step was found (")


def test_without_a_fixed_point_the_walk_is_measured(settled, monkeypatch):
    """Over its last four steps."""
    model, state, walked, walk, _ = settled

    def none(*_):
        raise NoLimitCycle("the walker fell")

    monkeypatch.setattr("stages.multibody.walking.cycle.search", none)
    cycle, found, reason = solve(model, state, walked, walk)
    assert not cycle.solved and found is None and reason == "no fixed point of its step was found (the walker fell)"
    assert cycle.period_s == pytest.approx(np.diff(walk.heel_strike_time[-5:]).mean(), rel=1e-9)
    assert np.isnan(cycle.largest_multiplier) and np.isnan(cycle.residual)
    given = {field.name: None for field in dataclasses.fields(Result)}
    energy = SimpleNamespace(relative_residual=1e-8)
    said = {"outcome": "completed", "steps": 8, "settled": False, "unsettled": reason, "cycle": cycle, "energy": energy}
    assert "does not settle: no fixed point" in Result(**(given | said)).summary()


@pytest.mark.slow
def test_a_rough_search_begins_where_a_walk_ends(from_gait):
    """The same gait, its multipliers to half a hundredth (.0025 is found), for less than half the steps."""
    model, state, walked, _ = from_gait(12)
    rough, full = search(model.at(1e-6), state, walked), search(model, state)
    assert rough.steps_walked <= 15 < 30 <= full.steps_walked
    assert rough.floquet_multipliers[:2, 0] == pytest.approx(full.floquet_multipliers[:2, 0], abs=5e-3)
    assert np.abs((rough.section_state - full.section_state) / SCALES).max() < 1e-4


@pytest.mark.slow
def test_multipliers_agree_with_fine_central_differences(from_gait):
    model, state, _, _ = from_gait(1)
    found = search(model, state)
    fine = dataclasses.replace(model.settings, tolerance=1e-10)
    full = limit_cycle(model.biped, model.slope, model.contact, state, fine)
    assert found.floquet_multipliers[:3, 0] == pytest.approx(full.floquet_multipliers[:3, 0], abs=5e-4)
    assert found.period_s == pytest.approx(full.period_s, abs=1e-6)
    walk = sample(simulate(model.biped, model.slope, model.contact, state, fine, steps=1).trajectory, model.biped,
                  model.slope, 500.0)  # fmt: skip
    assert solved_cycle(dataclasses.replace(model, settings=fine), state, found, walk).period_s == pytest.approx(
        full.period_s, abs=5e-7
    )
