"""The stage as a whole beside the constraint model, and the study's own choice."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.cache import artefact
from stages.analytic.errors import NoGait
from stages.analytic.gait.gait_search import gaits_kept
from stages.biped.accuracy.scales import scales_of, size
from stages.contact_study import rigid_limit, run as stage
from stages.contact_study.one_step import (
    NO_HEEL_STRIKE,
    Scene,
    constraint_model,
    cost,
    landing_force,
    measure,
    take_step,
)
from stages.contact_study.result import Result
from stages.contact_study.rigid_limit import Ruler, choose, same_set
from stages.contact_study.run import Inputs, checked, curve_times, one_at_a_time, run
from stages.ground.friction import static_penetration
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings
from stages.planar.run import STEP_FLOOR, rolling_state
from stages.planar.sampling import sample
from stages.planar.section import section_numbers
from stages.studies.result import EnginesDisagree
from stages.studies.walks import Machine
from tests.changed import changed
from tests.planar_start import rough
from tests.similar import EXPONENT, differences, factor, similar
from tests.study import parameters_of


@pytest.fixture(scope="module")
def analytic(constraints):
    """What the stage reads of an analytic result."""
    rolling, _ = constraints
    return SimpleNamespace(
        walk=rolling.walk, mid_stance=rolling.mid_stance, gait=SimpleNamespace(period_s=rolling.period))


def test_what_is_null_is_as_large_in_each_robots_own_scales():
    """Sets and limits of Table 1's size were tried on a robot of 5 mm of leg and one of 5 m alike."""
    usual, scale = parameters_of("contact_study"), (8.0, 4.0, 2.0)
    masses, lengths = ("hip_mass", "foot_mass"), ("leg_length", "foot_radius", "foot_com")
    large = parameters_of("contact_study", "contact_study.searched_depth=[7e-5]", *(
        f"biped.{key}={by * getattr(usual.biped, key)!r}" for keys, by in ((masses, 8.0), (lengths, 4.0))
        for key in keys))  # fmt: skip
    assert usual.default_set.law(usual.contact).contact_stiffness == 1e5 and usual.settings.impact_window == 1e-3
    assert large.settings.searched_depth == (7e-5,), "a size that is given stands"
    for one, other in ((usual.default_set, large.default_set), (usual.settings, large.settings)):
        for field in dataclasses.fields(one):
            value, found = getattr(one, field.name), getattr(other, field.name)
            if value is not None and field.name != "searched_depth":
                wanted = np.multiply(value, factor(field.metadata["unit"], scale, 2.2))
                assert found == pytest.approx(wanted, rel=1e-13), field.name


@pytest.fixture(scope="module")
def result(small, analytic):
    return run(small, Inputs(analytic))


@pytest.fixture
def unchecked(result, monkeypatch):
    """The check against Exudyn takes most of a run: this one leaves it out and takes what that of `result` found."""

    def known(scene, laws, cycles, count, tolerance):
        assert laws and cycles and count == 2 and tolerance > 0.0
        return result.engines

    monkeypatch.setattr(stage, "checked", known)


def test_rows_and_curves_belong_together(result):
    rows = result.variations
    assert (rows.key, rows.value.tolist()) == (("contact_stiffness", "stiction_velocity"), [3e5, 0.05])
    assert rows.outcome == ("completed", "completed") and len(result.candidates.outcome) == 2
    assert rows.force.shape == (2, len(result.time), 2)
    assert result.default_force.shape == result.chosen_force.shape == (len(result.time), 2)


def test_the_choice_is_among_the_candidates_and_at_the_head_of_its_family(result, default):
    limit, depth = result.limit, result.chosen.law.damping_depth
    chosen = dataclasses.replace(default, stiction_velocity=0.03, damping_depth=depth)
    assert result.chosen.law == limit.chosen.law == chosen and limit.finalists == (limit.chosen,)
    assert limit.family[0] is limit.chosen
    assert [one.law.stiction_velocity for one in limit.family] == [0.03, 0.015]
    assert limit.family[1].position_parts.sum() < limit.family[0].position_parts.sum()
    assert limit.chosen.evaluations <= limit.most_evaluations


def test_it_says_whether_the_ground_is_its_choice(result, small, analytic, unchecked):
    assert not result.ground_is_choice and "ground.yaml holds another" in result.summary()
    assert result.limit.ground.law == small.contact != result.limit.chosen.law
    other = run(dataclasses.replace(small, contact=result.chosen.law), Inputs(analytic))
    assert other.ground_is_choice and "ground.yaml holds it" in other.summary()
    assert other.limit.ground.score == other.limit.chosen.score == pytest.approx(result.limit.chosen.score)


@pytest.mark.slow
def test_runs_give_the_same_bytes_and_survive_storage(result, small, analytic, unchecked):
    content = artefact.encode(result, {})
    gaits_kept.cache_clear()  # this run searches as well
    assert artefact.encode(run(small, Inputs(analytic)), {}) == content
    read = artefact.decode(content, Result, "contact_study.h5")
    assert read.chosen.law == result.chosen.law and np.array_equal(read.variations.force, result.variations.force)
    assert read.limit.finalists[0].law == result.limit.finalists[0].law


def test_tables_show_all_variations_the_family_and_the_best_sets(result):
    tables = result.tables()
    assert all(len(row) == len(columns) for _, columns, rows in tables for row in rows)
    varied, measured, tried, *friction, checks = (rows for *_, rows in tables)
    assert [len(rows) for rows in (varied, measured, tried, checks)] == [1 + 2 + 2, 1 + 3 + 1 + 2, 2, 3]
    assert all(len(rows) == 14 for rows in friction) and tried[0][-1] <= tried[1][-1]


def test_the_study_is_within_a_nanometre_of_exudyn_and_fails_if_it_is_not(
    result, small, default, beside_rolling, monkeypatch
):
    step, _, cycle = result.engines.distances
    assert step.allowed == pytest.approx(3e-9 * 0.333) and "step with" in step.what and "cycle with" in cycle.what
    assert result.engines.largest < 1e-9 and "of Exudyn at 3 sampled points" in result.summary()
    assert {one.outcome for one in result.engines.distances} == {"completed"}

    def other(machine, state, tolerance, steps, duration):
        """In Exudyn's place the compiled walker, on ground that is stiffer by a hundred-thousandth."""
        stiffer = dataclasses.replace(machine.contact, contact_stiffness=(1 + 1e-5) * machine.contact.contact_stiffness)
        return dataclasses.replace(machine, contact=stiffer).compiled(state, 1e-12, steps, duration)

    monkeypatch.setattr(Machine, "exudyn", other)
    with pytest.raises(EnginesDisagree, match="disagree on a step with contact_stiffness"):
        checked(beside_rolling, [(default, 1)], (), 1, small.checked_tolerance)


def test_without_a_gait_with_slipping_feet_there_is_no_choice_but_a_result(
    small, analytic, default, unchecked, monkeypatch
):
    def none(*given):
        raise NoGait("the trailing foot slips away")

    monkeypatch.setattr(rigid_limit, "constraint_model", none)
    found = run(small, Inputs(analytic))
    assert found.limit is None and found.candidates is None and not found.ground_is_choice
    assert found.chosen.law == default and found.variations.outcome == ("completed", "completed")
    assert "the trailing foot slips away" in found.summary() and len(found.tables()) == 4
    assert artefact.decode(artefact.encode(found, {}), Result, "contact_study.h5").limit is None


def test_a_hip_that_rubs_leaves_the_choice_out_and_says_what_is_known(small, analytic, unchecked):
    """The rigid limit has a trailing foot that slips, which the constraint model does not know with such a hip."""
    found = run(changed(small, hip_friction=1e-4), Inputs(analytic))
    assert found.limit is None and found.variations.outcome == ("completed", "completed")
    assert "hip_damping" in found.summary() and "transition" not in found.summary()


@pytest.mark.slow
def test_ground_yaml_holds_the_choice_of_the_study(parameters):
    """The whole study from the analytic gait: is the set that every stage uses still the one the criterion chooses?"""
    from stages.analytic import run as analytic

    result = run(parameters, Inputs(analytic.run(parameters_of("analytic"))))
    assert result.ground_is_choice and same_set(parameters.contact, result.chosen.law), result.summary()
    best, second = result.limit.finalists[:2]
    assert best.score < 0.9 * second.score, "by more than a tenth"
    assert best.evaluations <= result.limit.most_evaluations
    assert result.limit.family[-1].position_parts.sum() < 0.1 * best.position_parts.sum(), "an eighth of both effects"


# --- A step is measured right: no difference from itself, creep as the friction law says, failures as rows.


def test_differences_of_forces_are_of_time_and_not_of_samples(parameters, scene_of, scene, default):
    """A foot on hard ground bounces for a tenth of a millisecond each time, which samples see by chance."""
    run = take_step(scene, default)
    hard = dataclasses.replace(default, contact_stiffness=100.0 * default.contact_stiffness)
    walks = [sample(run.trajectory, parameters.biped, parameters.slope, rate) for rate in (2000.0, 6500.0)]
    one, other = (measure(beside, hard, take_step(beside, hard)) for beside in (
        scene_of(walk, scene.mid_stance, scene.period) for walk in walks))  # fmt: skip
    assert one.normal_force == pytest.approx(other.normal_force, rel=0.02) and one.normal_force > 1.0
    assert one.friction_force == pytest.approx(other.friction_force, rel=0.02)


def test_a_step_does_not_differ_from_itself(scene, default):
    run = take_step(scene, default)
    step = measure(scene, default, run)
    assert step.outcome == "completed" and abs(step.heel_strike_lead) < 1e-7
    # not exactly none: the stand-in stood on its own static penetration, under a force 1e-6 different
    assert step.hip_position.max() < 1e-7 and step.hip_velocity.max() < 1e-5
    assert step.normal_force < 1e-2
    dense = dataclasses.replace(scene, solver=dataclasses.replace(scene.solver, between=60))
    sampled = take_step(dense, default).trajectory.ground_reaction[:, 1, 1].max()
    assert step.peak_force == pytest.approx(sampled, rel=2e-5), "between the solver's steps"
    assert step.peak_force > 1.0001 * run.trajectory.ground_reaction[:, 1, 1].max()


def measured(scene, law):
    return measure(scene, law, take_step(scene, law))


def test_a_known_difference_is_found(scene, default):
    moved = dataclasses.replace(scene.walk, hip_position=scene.walk.hip_position - np.array([2e-3, 1e-3]))
    step = measured(dataclasses.replace(scene, walk=moved), default)
    for found in (step.hip_position, step.end_position):
        assert found == pytest.approx([2e-3, 1e-3], abs=1e-6)


def test_creep_is_what_the_slope_of_the_friction_law_asks_for(scene, default):
    """v = (F_T / F_N) v_s / (1.5 mu_s) while the friction used is small: halving v_s halves the creep."""
    fast, slow = (measured(scene, dataclasses.replace(default, stiction_velocity=share * default.stiction_velocity))
                  for share in (1.0, 0.5))  # fmt: skip
    assert fast.creep_velocity / slow.creep_velocity == pytest.approx(2.0, rel=0.03)
    alone = scene.walk.time < scene.heel_strike - 0.005
    time, force = scene.walk.time[alone], scene.walk.ground_reaction[alone, 0]
    used = np.trapezoid(np.abs(force[:, 0] / force[:, 1]), time) / time[-1]
    expected = used * default.stiction_velocity / (1.5 * default.static_friction)
    assert fast.creep_velocity == pytest.approx(expected, rel=0.05)


def test_a_cost_at_the_tolerance_of_the_walk_is_the_walks_own(scene, default):
    walked = take_step(scene, default, signals=())
    for tolerance in (1e-4, scene.solver.tolerance):
        coarse = dataclasses.replace(scene, cost_tolerance=tolerance)
        assert cost(coarse, default, walked) == cost(coarse, default)
        assert (cost(coarse, default) == walked.evaluations) == (tolerance == scene.solver.tolerance)
        assert cost(coarse, default) <= walked.evaluations


def test_the_force_curve_is_the_recorded_force(scene, default):
    run, time = take_step(scene, default), curve_times(0.184)
    curve = landing_force(scene, run, time)
    assert np.all(np.diff(time) > 0.0) and curve.shape == (len(time), 2)
    assert np.all(curve[time < -1e-3] == 0.0), "in the air"
    peak = run.trajectory.ground_reaction[:, 1, 1].max()
    assert curve[:, 1].max() == pytest.approx(peak, rel=0.05), "50 us show a peak of half a millisecond"


def test_a_solver_that_gets_nowhere_is_a_row_with_its_reason(scene, default):
    """Hard and sharply damped ground drives the step size down; the run is given up, not waited for."""
    hopeless = dataclasses.replace(default, contact_stiffness=1e9, contact_damping=1e7, damping_depth=1e-8)
    hurried = dataclasses.replace(scene, solver=dataclasses.replace(scene.solver, most_solver_steps=1000))
    run = take_step(hurried, hopeless)
    step = measure(hurried, hopeless, run)
    assert step.outcome == STEP_FLOOR and "gets nowhere after 1000 steps" in step.message
    assert np.isnan([step.normal_force, step.penetration, *step.hip_position, *step.end_position]).all()
    assert np.isnan(landing_force(hurried, run, curve_times(0.184))[-1]).all()
    assert np.isfinite(run.trajectory.position).all()


def test_a_step_without_a_heel_strike_is_told(scene, default):
    assert measured(dataclasses.replace(scene, period=0.05), default).outcome == NO_HEEL_STRIKE


# --- A study knows no metre: similar robots have the same choices, and numbers that differ by their units alone.


__all__ = ["rough"]  # a fixture

#: Masses, lengths, times: gravity stays, or is a quarter.
ALIKE = pytest.mark.parametrize("scale", [(8.0, 4.0, 2.0), (1.0, 1.0, 2.0)], ids=["four times", "gravity a quarter"])
#: Units of the section's numbers.
SECTION = ("m", "rad", "m", "m", "m/s", "m/s", "rad/s", "rad/s", "m/s", "m/s")
#: What rounding of powers leaves, over what the ground makes of it.
ROUND_OFF = 1e-9


@pytest.fixture
def exact(small):
    """Ground of which a similar robot's is exact."""
    return changed(small, contact_exponent=EXPONENT, default_exponent=EXPONENT)


def searched(parameters, rough):
    """The search over a step among two sets, from a mid-stance: what it chooses and what it tries."""
    biped, slope, settings = parameters.biped, parameters.slope, parameters.settings
    coulomb = constraint_model(
        biped, slope, parameters.contact.coefficients, rough, 1e-10, settings.sampling_rate_hz)
    scene = Scene(biped, slope, Settings(1e-6), 1e-6, coulomb.walk, rough, coulomb.period, settings.impact_window)
    ruler, law = Ruler(scene, coulomb, settings), parameters.default_set.law(parameters.contact)
    return choose(ruler.over_a_step(law), settings, ruler.over_a_step, lambda found: found)


@ALIKE
def test_the_search_tries_and_chooses_the_same(exact, rough, scale):
    chosen, _, tried = searched(exact, rough)
    other, _, others = searched(similar(exact, scale), similar(rough, scale))
    assert np.isfinite(chosen.step_score) and chosen.law.damping_depth in exact.settings.searched_depth
    assert other.evaluations == chosen.evaluations and (others.evaluations == tried.evaluations).all()
    assert others.outcome == tried.outcome
    assert max(differences(chosen, other, scale).values()) < ROUND_OFF


@ALIKE
def test_another_exponent_is_alike(parameters, scale):
    """A foot sinks in by the same share of the leg, under the weight of either robot."""
    shares = []
    for one in (parameters, dataclasses.replace(similar(parameters, scale), settings=parameters.settings)):
        default = dataclasses.replace(
            one.default_set, **dict.fromkeys(("default_stiffness", "default_depth", "default_damping"), None))
        law = default.of(own := scales_of(one.biped, one.slope.gravity)).law(one.contact)
        shares.append([static_penetration(varied, own.size("N")) / own.length for key, varied in one_at_a_time(
            law, parameters.settings, size(one.biped)) if key == "contact_exponent"])  # fmt: skip
    assert len(shares[0]) == 4 and shares[0] == pytest.approx(shares[1], rel=1e-9)


@ALIKE
def test_steps_and_their_derivatives_are_alike(exact, rough, scale):
    """As many evaluations, and every entry by its unit."""
    ends = []
    for parameters, stance in ((exact, rough), (similar(exact, scale), similar(rough, scale))):
        start = rolling_state(parameters.biped, parameters.contact, stance, 9.4 * parameters.biped.total_mass
                              * parameters.slope.gravity / (exact.biped.total_mass * exact.slope.gravity))
        stepper = PenaltyStepper(parameters.biped, parameters.slope, parameters.contact, start, Settings(1e-8))
        numbers = section_numbers(start)
        ends.append((stepper.step(numbers), stepper.derivative(numbers)))
    (step, matrix), (other, grown) = ends
    units = np.array([factor(unit, scale) for unit in SECTION])
    assert other.solver_steps == step.solver_steps
    assert other.numbers == pytest.approx(step.numbers * units, rel=ROUND_OFF)
    assert other.duration == pytest.approx(step.duration * scale[2], rel=ROUND_OFF)
    assert grown / units[:, None] * units == pytest.approx(matrix, rel=1e-7, abs=1e-7 * np.abs(matrix).max())
