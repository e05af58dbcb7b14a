"""Numbers of claims are those of the walks and studies they are taken from."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.commands.claims import Claim as Shown, as_text
from stages.comparison.claims import calibration, contact, figure_8, gait, judge, measurement, numerics, twin
from stages.comparison.claims.judge import SAFE, judged
from stages.comparison.claims.paper import STANDARD_GRAVITY
from stages.comparison.determinants import Determinants, digits_of, of_walk
from stages.comparison.result import FAILS, HOLDS, UNDECIDED, UNKNOWN, BipedSummary, tables_of
from stages.comparison.tables import side_by_side
from stages.contact_study.result import FrictionVariation
from stages.error_budget.result import CREEP, EFFECTS, SLIP, Split
from stages.rough_ground.result import CONSTRAINT, PENALTY
from stages.studies.result import COMPLETED
from stages.tradeoff.result import Errors, Row
from stages.twin_ladder.result import Result as Ladder, RungGait
from tests.comparison.made_up import make_budget, make_step, make_study, make_walk
from tests.comparison.test_claims import CASES, PARAMETERS, of

RADIUS = 0.08
LEGS = np.full(2, RADIUS), np.full(2, 0.333)


def rolling(steps=12, step=0.16, speed=0.32, count=20_001):
    """A walk on rigid legs of 0.333 m whose standing feet roll and stand `step` apart; the legs change at once."""
    period = step / speed
    time = np.linspace(0.0, steps * period, count)
    place = speed * time  # of the hip
    number = np.floor(time / period + 0.5).astype(int)  # of the stance, the first at mid-stance
    hip, centre = place - number * step, np.zeros((count, 2))
    angle = np.zeros((count, 2))
    # a foot that rolls: its centre is at number * step + RADIUS theta, and the hip (L - r) sin(theta) ahead of that
    lean = np.interp(hip, RADIUS * (grid := np.linspace(-1, 1, 20_001)) + 0.253 * np.sin(grid), grid)
    for leg in (0, 1):
        stands = number % 2 == leg
        angle[:, leg] = np.where(stands, -lean, lean)
        centre[:, leg] = np.where(stands, number * step + RADIUS * lean, place)
    strikes = (np.arange(steps) + 0.5) * period
    walk = make_walk()
    pair = np.zeros((count, 2))
    return dataclasses.replace(
        walk, time=time, hip_position=np.column_stack([place, RADIUS + 0.253 * np.cos(lean)]),
        hip_velocity=np.column_stack([np.full(count, speed), np.zeros(count)]), leg_angle=angle,
        leg_rate=np.gradient(angle, time, axis=0), leg_length=pair + 0.333, leg_length_rate=pair,
        heel_strike_time=strikes, heel_strike_leg=(np.arange(steps) + 1) % 2,
        toe_off_time=strikes + 1e-9, toe_off_leg=np.arange(steps) % 2,
    )  # fmt: skip


def test_feet_that_stand_one_step_apart_reach_as_far_as_they_roll():
    walk = rolling()
    reach, rolls = twin.block_reach(walk, (RADIUS, RADIUS), 0.16, 11)
    assert rolls == pytest.approx(2 * reach, rel=1e-3)
    assert reach == pytest.approx(RADIUS * np.abs(walk.leg_angle).max(), rel=3e-3)
    off, _ = twin.block_reach(walk, (RADIUS, RADIUS), 0.15, 11)
    assert off == pytest.approx(reach + 10 * 0.01, rel=1e-2), "ten steps of 10 mm too much"
    assert math.isnan(twin.block_reach(rolling(steps=6), (RADIUS, RADIUS), 0.16, 11)[0])


def test_determinants_of_a_known_walk():
    found = of_walk(rolling(), *LEGS, 9.81)
    assert found.step_length == pytest.approx(0.16, rel=1e-6) and found.speed == pytest.approx(0.32, rel=1e-6)
    assert found.step_frequency == pytest.approx(2.0, rel=1e-9)
    assert found.duty_factor == pytest.approx(0.5, abs=1e-6), "legs that change at once"
    assert found.froude_number == pytest.approx(0.32**2 / (9.81 * 0.333))
    widest = math.degrees(np.abs(rolling().leg_angle).max())
    assert found.strike_angle == pytest.approx(widest, rel=1e-2)
    assert found.swing_range == pytest.approx(2 * widest, rel=1e-2)
    assert found.speed_variation == 0.0 and found.scuff_depth == pytest.approx(0.0, abs=1e-4)
    assert found.leg_compression == pytest.approx(0.0, abs=1e-12)
    longer = dataclasses.replace(rolling(), toe_off_time=rolling().heel_strike_time + 0.05)
    assert of_walk(longer, *LEGS, 9.81).duty_factor == pytest.approx(0.55)


def test_determinants_reach_a_last_heel_strike_after_the_last_sample():
    """As in the constraint model's walk, which ends with a heel strike and is sampled at even times."""
    walk = rolling(count=2_000)
    known = walk.time < walk.heel_strike_time[-1]
    assert walk.heel_strike_time[-1] - walk.time[known][-1] > 1e-3
    names = "time", "hip_position", "hip_velocity", "leg_angle", "leg_length"
    rows = {name: getattr(walk, name)[known] for name in names}
    found = of_walk(dataclasses.replace(walk, **rows), *LEGS, 9.81)
    assert found.step_length == pytest.approx(0.16, rel=1e-9) and found.speed == pytest.approx(0.32, rel=1e-9)
    assert found.strike_angle == pytest.approx(math.degrees(np.abs(walk.leg_angle).max()), rel=1e-3)


def test_determinants_of_legs_that_differ_are_of_each_by_its_own_numbers():
    walk, (radii, lengths) = rolling(), LEGS
    foot = np.array([0.0, 0.02])
    found = of_walk(
        dataclasses.replace(walk, leg_length=walk.leg_length - foot), radii - foot, lengths - foot, 9.81)
    assert found.leg_compression == pytest.approx(0.0, abs=1e-12)
    assert found.foot_clearance == pytest.approx(0.02, abs=1e-4), "of the smaller foot on as long a leg above it"
    assert found.froude_number == pytest.approx(0.32**2 / (9.81 * 0.323))
    half = of_walk(dataclasses.replace(walk, leg_angle=walk.leg_angle * [1.0, 0.5]), *LEGS, 9.81)
    assert half.swing_range == pytest.approx(1.5 * math.degrees(np.abs(walk.leg_angle).max()), rel=1e-2)


def test_a_foot_that_leaves_as_the_other_lands_has_no_double_stance():
    """Rigid legs change at once; the next toe-off of the leg that leaves is a stride later."""
    walk = rolling()
    found = of_walk(dataclasses.replace(walk, toe_off_time=walk.heel_strike_time), *LEGS, 9.81)
    assert found.double_stance == 0.0 and found.duty_factor == 0.5


def test_what_a_gait_does_not_tell_stays_empty():
    title, columns, rows = side_by_side("title", {"one": Determinants(step_frequency=2.0), "two": Determinants()})
    assert (title, columns) == ("title", ("", "one", "two"))
    assert rows == [("step frequency [Hz]", "2", "")], "what is known of none has no row"
    assert of_walk(make_walk(steps=2), *LEGS, 9.81).speed_variation != 0, "NaN"


def test_a_table_has_numbers_for_people():
    found = Determinants(step_frequency=12345.6, step_length=5e-14, froude_number=5e-14, foot_clearance=0.0,
                         duty_factor=math.inf)  # fmt: skip
    rows = dict(side_by_side("title", {"one": found})[2])
    assert (rows["step frequency [Hz]"], rows["step length [mm]"]) == ("12346", "< 0.001")
    assert rows["largest clearance of the swing foot [mm]"] == "0"
    assert rows["duty factor, a leg's stance over its stride"] == "no bound"


def test_the_gait_turns_with_the_velocity_and_the_factor_at_which_it_changes_most():
    lengths = {"stiction_velocity": (0.1616, 0.16, 0.1568), "friction_velocity": (0.16, 0.16, 0.16)}
    rows = [FrictionVariation(key, factor, 0.48, length)
            for key, found in lengths.items() for factor, length in zip((0.5, 1.0, 2.0), found)]  # fmt: skip
    study = SimpleNamespace(default_friction_variations=tuple(rows), default=make_step(creep=4e-3))
    results = SimpleNamespace(contact_study=study)
    limits = SimpleNamespace(settings=SimpleNamespace(unaffected_limit=0.005))
    found = contact.friction_velocities(SimpleNamespace(parameters=limits, results=results))
    velocity, turning, halved, doubled, creep = found
    assert (velocity, creep) == ("stiction_velocity", 4e-3)
    assert (halved, doubled) == pytest.approx((0.01, -0.02))
    assert turning == pytest.approx(2**0.25), "doubling moves it by four times the limit"


def test_step_frequency_takes_its_uncertainty_from_the_model():
    def given(*uncertainties):
        analytic = SimpleNamespace(gait=SimpleNamespace(step_frequency_hz=2.07), uncertainties=uncertainties)
        return SimpleNamespace(results=SimpleNamespace(analytic=analytic))

    own = SimpleNamespace(
        name="step_frequency_hz", worst=7e-3, decisive="biped.foot_com", decisive_part=3e-3,
        slope_least=2.05, slope_most=2.08)
    found = gait.step_frequency(given(SimpleNamespace(name="period_s"), own))
    assert found == (2.07, 7e-3, "biped.foot_com", 3e-3, (2.05, 2.08))
    assert gait.step_frequency(given()) == (2.07, 0.0, "", 0.0, (2.07, 2.07)), "all values are exact"


def test_sensors_are_asked_for_specific_forces_over_g_and_degrees_a_second():
    g = STANDARD_GRAVITY
    spikes = [SimpleNamespace(hip_peak=peak, time_above_range=time) for peak, time in ((15 * g, 2e-3), (160 * g, 1e-3))]
    spikes.append(SimpleNamespace(hip_peak=math.nan, time_above_range=math.nan))
    runs = [SimpleNamespace(hip=SimpleNamespace(peak_filtered=peak * g)) for peak in (2.0, 3.0, 7.0)]
    walked = SimpleNamespace(peak_specific_force=3 * g, peak_foot_specific_force=4 * g, peak_rate=math.pi,
                             time_above_range=2e-3, step_frequency=2.0)  # fmt: skip
    for made, family, behind in ((SimpleNamespace(spikes=spikes, runs=runs), ((15, 160), (1e-3, 2e-3)), 3),
                                 (SimpleNamespace(spikes=[], runs=[]), ((math.nan,) * 2,) * 2, math.nan)):  # fmt: skip
        found = measurement.sensor_range(SimpleNamespace(results=SimpleNamespace(campaign=made), twin=walked))
        assert found[:5] == pytest.approx((3, 4, 180, 2e-3, 0.5))
        np.testing.assert_allclose(found[5:7], family)
        assert found[7] == pytest.approx(behind, nan_ok=True)


@pytest.mark.parametrize("unknown", ["ingest", "leg", ""])
def test_a_path_has_its_errors_where_the_truth_is_known_and_its_steps_where_legs_are_seen(unknown):
    steps = SimpleNamespace(**{name: SimpleNamespace(step_length=length)
                               for name, length in (("runs", 0.16), ("twin", 0.161), ("simple", 0.162))})
    steps.step_length_error = 1e-3
    leg = SimpleNamespace(way=np.array([1.0, 2.0]), twice=np.array([0.3, math.nan, -0.4]), step=np.array([0.01]),
                          angle=np.full(2, math.nan))  # fmt: skip
    evidence = SimpleNamespace(ingest=None if unknown == "ingest" else SimpleNamespace(leg=leg),
                               measured=SimpleNamespace(origin="here", leg=None if unknown == "leg" else steps))
    origin, *numbers = measurement.hip_path_drifts(evidence)
    truth = [math.nan] * 4 if unknown == "ingest" else [1.5, math.sqrt(0.125), 0.01, math.nan]
    seen = [math.nan] * 4 if unknown == "leg" else [0.16, 1e-3, 0.161, 0.162]
    np.testing.assert_allclose(numbers, truth + seen)
    assert origin == "here"


@pytest.mark.parametrize("of", [1, 2])
def test_growth_is_that_of_the_unluckiest_disturbance_in_each_cycle(of):
    """A shear enlarges one before it fades: |A^n| of A = [[1/2, 2], [0, 1/2]] by its singular values. Where legs differ
    A is of two steps, and the walk has half as many."""
    analytic = SimpleNamespace(gait=SimpleNamespace(largest_multiplier=0.5, steps=of),
                               walk=SimpleNamespace(heel_strike_time=np.arange(6.0)),
                               monodromy_matrix=np.array([[0.5, 2.0], [0.0, 0.5]]))  # fmt: skip
    multiplier, most, left, steps = gait.chaos_amplifies(SimpleNamespace(results=SimpleNamespace(analytic=analytic)))
    # A^n = 2^-n [[1, 4n], [0, 1]], whose norm is 2^-n (2n + sqrt(4n^2 + 1))
    norms = [0.5**n * (2 * n + math.sqrt(4 * n**2 + 1)) for n in range(1, 6 // of + 1)]
    assert (multiplier, most, left) == pytest.approx((0.5, max(norms), norms[-1])) and steps == 6


def test_the_least_multiplier_of_neighbours_names_its_change():
    rows = [SimpleNamespace(name=name, change=0.05, multiplier_below=below, multiplier_above=above)
            for name, below, above in (("hip_mass", math.nan, 0.6), ("foot_com", 0.5, 0.7))]  # fmt: skip
    analytic = SimpleNamespace(gait=SimpleNamespace(largest_multiplier=0.64), variations=rows)
    evidence = SimpleNamespace(results=SimpleNamespace(analytic=analytic))
    assert gait.multipliers_minimised(evidence) == (0.64, 0.5, "foot_com -5 %")
    analytic.variations = rows[:1]
    assert gait.multipliers_minimised(evidence)[1:] == (0.6, "hip_mass +5 %")
    analytic.variations = []
    assert math.isnan(gait.multipliers_minimised(evidence)[1])


def test_an_outsole_is_compared_with_the_gait_without_it_and_over_pairs_that_are_known():
    layer = SimpleNamespace(thickness=2e-3, frequency_without_mass=2.02, frequency_with_mass=1.98, mass=0.01,
                            turning_mass=4e-3)  # fmt: skip
    pairs = [SimpleNamespace(longer=2e-3, longer_sd=1e-4, slower=slower, slower_sd=sd, true_slower=-3e-3)
             for slower, sd in ((-2e-3, 1e-3), (-4e-3, 3e-3), (math.nan, 1.0))]
    analytic = SimpleNamespace(outsole=layer, gait=SimpleNamespace(step_frequency_hz=2.0))
    for known, told in ((pairs, (2e-3, 1.96e-4, -3e-3, 3.92e-3, -3e-3)), ((), (math.nan,) * 5)):
        results = SimpleNamespace(analytic=analytic, calibrated_twin=SimpleNamespace(pairs=known))
        runs = SimpleNamespace(origin="here")
        found = calibration.outsole_slows(SimpleNamespace(results=results, measured=runs))
        assert found[:5] == pytest.approx((2e-3, 0.01, -0.01, 0.01, 4e-3)) and found[5:7] == ("here", 2 if known else 0)
        assert found[7:] == pytest.approx(told, rel=1e-3, nan_ok=True)


def test_the_least_change_of_the_stiffness_that_helps_is_found_and_the_hip_is_compared_at_all():
    study = make_study()
    rows, force = study.variations.rows("contact_stiffness"), study.variations.normal_force.copy()
    results = SimpleNamespace(contact_study=study, analytic=SimpleNamespace(gait=SimpleNamespace(period_s=0.48)))
    evidence = SimpleNamespace(results=results)
    assert contact.contact_set_figure_8(evidence) == pytest.approx((1e-3, 5e4, 4e-3, 4e-3 * 0.48, 1e-3, 0.05))
    for forces, told in (((0.2, 0.05), (0.05, 2.0, 0.05, 2.0)), ((0.09, math.nan), (0.09, 0.5, 0.09, 0.5)),
                         ((0.3, 0.2), (0.2, 2.0, 0.2, 2.0))):  # fmt: skip
        force[rows] = forces
        results.contact_study = dataclasses.replace(
            study, variations=dataclasses.replace(study.variations, normal_force=force))
        assert contact.contact_set(evidence) == pytest.approx((0.1, *told))


def test_the_twins_own_gait_is_the_ladders_where_it_has_one():
    settled = SimpleNamespace(step_period=[0.5], period_s=0.49, steps_to_settle=1, frequency_text=lambda: "2 Hz")
    runs = [SimpleNamespace(failed_attempts=number) for number in (0, 2, 1)]
    own = RungGait("twin", COMPLETED, 0.48, 0.16, 0.0, "", True, np.array([[0.42, 0.56]]), np.array([[0.3, 0.4]]), 0.0,
                   1.0, 1)  # fmt: skip
    for rungs, steps, of_gait, pushed in (
        ((), 1, (0.49, math.nan), (math.nan, math.nan)), ((own,), 1, (0.48, 0.7), (0.7, 0.5)),
        ((own,), 2, (0.48, math.sqrt(0.7)), (math.sqrt(0.7), math.sqrt(0.5))),
    ):  # fmt: skip
        results = SimpleNamespace(
            twin=SimpleNamespace(settling=settled), twin_ladder=Ladder(0.48, 0.16, rungs, 0.49, 0.16, steps=steps),
            campaign=SimpleNamespace(runs=runs), twin_pushes=SimpleNamespace(limits=lambda: [("yaw", "rad", 0.1, 0.2)]))
        found = twin.twin_settles(SimpleNamespace(results=results))
        assert found[:2] == (1, 0.5) and found[4] == "2 Hz" and found[2:4] == pytest.approx(of_gait, nan_ok=True)
        found = twin.push_converges(SimpleNamespace(results=results))
        assert found[:3] == (3, 3, (("yaw", "rad", 0.1, 0.2),)) and found[3:] == pytest.approx(pushed, nan_ok=True)


def test_the_twin_is_compared_by_the_details_up_to_it_and_by_forward_up_and_rate():
    def rung(name, period, is_twin=False):
        return RungGait(name, COMPLETED, period, 0.16, 0.0, "", is_twin, *[np.zeros((2, 2))] * 2, 0.0, 1.0, 1)

    rungs = (rung("planar", 0.481), rung("inertia", 0.484), rung("leg", 0.482, True), rung("outsole", 0.49))
    ladder = Ladder(0.48, 0.16, rungs, 0.48, 0.16)
    for twins, upto in ((rungs, 2), (tuple(dataclasses.replace(one, is_twin=False) for one in rungs), 3)):
        for inertia in ("parts", "planar"):
            found = twin.twin_like_simple(SimpleNamespace(
                results=SimpleNamespace(twin_ladder=dataclasses.replace(ladder, rungs=twins)),
                parameters=SimpleNamespace(twin=SimpleNamespace(inertia=inertia)),
                twin=SimpleNamespace(normalised_rms=np.arange(1.0, 7.0))))  # fmt: skip
            assert found[:3] == (1.0, 2.0, 3.0) and found[4:] == (0.48, inertia == "parts")
            assert [name for name, _ in found[3]] == ["inertia", "leg", "outsole"][:upto]
            assert [change for _, change in found[3]] == pytest.approx([3e-3, -2e-3, 8e-3][:upto])


def test_the_ramp_is_passed_on_the_highest_blocks_that_both_models_walked():
    def row(model, height, chance):
        return SimpleNamespace(model=model, block_height_rms=height, ramp_steps=10, ramp_chance=chance,
                               ramp_low=chance - 0.02, ramp_high=chance + 0.01)  # fmt: skip

    rows = [row(model, height, chance - less) for model, less in ((CONSTRAINT, 0.0), (PENALTY, 0.1))
            for height, chance in ((2e-4, 0.97), (4e-4, 0.93), (6e-4, 0.49), (8e-4, 0.2))]  # fmt: skip
    for passing, height, chance in ((0.9, 4e-4, 0.93), (0.95, 2e-4, 0.97), (0.99, 2e-4, 0.97)):
        found = SimpleNamespace(of=lambda model: [one for one in rows if one.model == model])
        evidence = SimpleNamespace(results=SimpleNamespace(rough_ground=found), parameters=SimpleNamespace(
            settings=SimpleNamespace(passing_chance=passing)))  # fmt: skip
        assert twin.ramp_passed(evidence) == pytest.approx(
            (11, height, chance, chance - 0.02, chance + 0.01, chance - 0.12, chance - 0.09, 6e-4, 8e-4))


def test_eleven_sets_need_ten_steps_and_a_block():
    walked = SimpleNamespace(analytic=SimpleNamespace(gait=SimpleNamespace(step_length_m=0.16)),
                             twin=SimpleNamespace(walk=rolling()))  # fmt: skip
    for given, step in ((None, 0.16), (0.15, 0.15)):
        chosen = SimpleNamespace(twin=SimpleNamespace(expected_step=given, outsole=0.0), biped=SimpleNamespace(
            foot_radii=(RADIUS, RADIUS)), blocks=SimpleNamespace(block_length=0.08))  # fmt: skip
        found = twin.ramp_length(SimpleNamespace(parameters=chosen, results=walked))
        assert found[:2] == pytest.approx((step, 10 * step + 0.08)) and found[4] == 0.08
        assert found[2:4] == twin.block_reach(rolling(), (RADIUS, RADIUS), step, 11)


def test_tightest_and_usual_tolerances_are_those_of_the_studys_own_way():
    def row(tolerance, error, cost, way="own", mark="", outcome="completed"):
        return Row(numerics.ROLLING, way, "", mark, outcome, Errors(error, 0, 0, 0), cost, tolerance, math.nan,
                   Errors(1e-13, 0, 0, 0))  # fmt: skip

    rows = [row(1e-7, 1e-6, 100.0, mark="default"), row(1e-12, 2e-12, 400.0), row(1e-13, 1e-12, 450.0),
            row(1e-14, 0.0, 1.0, outcome="fell"), row(1e-15, 0.0, 1.0, way="another")]  # fmt: skip
    tradeoff = SimpleNamespace(rows=tuple(rows))
    evidence = SimpleNamespace(results=SimpleNamespace(tradeoff=tradeoff))
    assert numerics.tight_tolerances(evidence) == ("own", 1e-13, 1e-12, 2e-12, 1e-7, 4.5, 1e-13)
    tradeoff.rows = tuple(rows[:1])
    assert numerics.tight_tolerances(evidence)[0] == "no way" and math.isnan(numerics.tight_tolerances(evidence)[2])
    evidence.results.contact_study = make_study()
    assert math.isnan(numerics.constraints_reduce_effort(evidence)[0]), "the paper's way is not there"
    tradeoff.rows = (*rows[:3], dataclasses.replace(row(1e-6, 1e-6, 5e3, "BDF", "paper"), model=numerics.PENALTY))
    assert numerics.constraints_reduce_effort(evidence) == pytest.approx((1e-6, 100.0, 5e3, 1.0, 2.0))
    assert all(map(math.isnan, numerics.stiff_and_explicit(tradeoff.rows, numerics.ROLLING))), "none is the paper's"


def test_least_work_is_that_of_the_cheapest_way_at_the_error():
    def row(way, error, cost, outcome="completed"):
        return Row("model", way, "", "paper" if way == "BDF" else "", outcome, Errors(error, 0, 0, 0), cost, 1e-6, 1e-3)

    rows = [row("slow", 1e-4, 300.0), row("slow", 1e-8, 900.0), row("BDF", 1e-6, 200.0), row("fell", 1e-9, 1.0, "fell")]
    assert numerics.least_work(rows, 1e-6) == 200.0
    assert numerics.least_work(filter(numerics.explicit, rows), 1e-6) == pytest.approx(300 * 3**0.5)
    assert math.isnan(numerics.least_work(rows, 1e-12))
    assert numerics.of_the_paper(rows, "model").way == "BDF" and numerics.of_the_paper(rows, "other") is None


def test_ends_name_the_parts_that_count():
    parts = {name: (value, spread) for name, value, spread in figure_8.ends(make_budget().step.split)}
    assert parts[SLIP] == pytest.approx((3e-4 * 0.48, 0.0))
    assert parts[CREEP] == pytest.approx((-5e-4 * 0.48, 5e-5 * 0.48)), "with its interval"
    assert len(parts) == 3, "neither integration nor what is left unexplained"


def test_pushes_correlate_with_frequencies_that_follow_them():
    random = np.random.default_rng(1)
    pushes = random.normal(1, 0.04, (30, 2))
    truths = [SimpleNamespace(name=str(i), stance_push=a, swing_push=b) for i, (a, b) in enumerate(pushes)]
    follows = {run.name: 2.0 + run.stance_push for run in truths}
    found = calibration.pushes_and_frequency(truths, follows)
    assert found[0] == pytest.approx(1.0) and found[2] == pytest.approx(1.0)
    assert found[1] == pytest.approx(0.361, abs=5e-4), "the 5 % level of 30 pairs in any table"
    other = random.normal(0, 0.04, 30)
    other -= (terms := np.column_stack([np.ones(30), pushes])) @ np.linalg.pinv(terms) @ other  # is of no push
    half = {run.name: 2.0 + run.stance_push + off for run, off in zip(truths, other, strict=True)}
    assert calibration.pushes_and_frequency(truths, half)[2] == pytest.approx(
        np.var(pushes[:, 0]) / (np.var(pushes[:, 0]) + np.var(other)))
    alone = calibration.pushes_and_frequency(truths, {run.name: float(random.normal()) for run in truths})
    assert abs(alone[0]) < 0.5 and alone[2] < 0.3
    assert all(math.isnan(value) for value in calibration.pushes_and_frequency(truths, {**follows, "a lab's": 2.0}))


def test_digits_leave_the_same_share_of_every_model_open():
    def one(name, value, worst, least, most):
        return SimpleNamespace(name=name, value=value, worst=worst, slope_least=least, slope_most=most)

    determinants = {"constraint model": Determinants(step_frequency=2.0, step_length=0.16),
                    "twin": Determinants(step_frequency=2.2, step_length=0.08)}
    numbers = [one("step_frequency_hz", 2.0, 0.01, 1.9, 2.1), one("step_length_m", 0.16, 8e-4, 0.12, 0.18)]
    found = digits_of(numbers, determinants)
    assert (found["constraint model"].step_frequency, found["twin"].step_frequency) == pytest.approx((0.01, 0.011))
    assert found["twin"].least_step_length == pytest.approx(0.06) and math.isnan(found["twin"].speed)
    exact = digits_of([], determinants)["twin"]
    assert math.isnan(exact.step_frequency), "nothing is left open"
    biped = BipedSummary(*[math.nan] * 18)
    assert [len(tables_of(biped, determinants, digits)) for digits in (found, digits_of([], determinants))] == [3, 2]



def test_slip_between_cycles_leaves_out_the_instants_of_impacts():
    """At a heel strike velocities jump: round-off would say whether the jump counts."""
    parts = np.zeros((len(EFFECTS), 5, 4))
    slip = parts[EFFECTS.index(SLIP)]
    slip[:, 0], slip[:, 2] = [1e-4, 2e-4, 3e-4, 2e-4, 5e-4], [0.9, 1e-3, -3e-3, 1e-3, 0.9]
    split = Split(parts, np.zeros((5, 4)), np.array([False, True, True, True, False]))
    results = SimpleNamespace(error_budget=SimpleNamespace(cycle=SimpleNamespace(split=split)))
    found = figure_8.slip_between_cycles(SimpleNamespace(results=results))
    assert found == pytest.approx((5e-4, 3e-3), rel=1e-12)


# --- Numerical errors of claims: a verdict that they could change is not decided, all others stand.


STABLE = CASES[3][0]


def beside(measured, **changes):
    """What closer solvers measure where the errors are these."""
    return of(measured, **{key: measured.numbers[key] + error / SAFE for key, error in changes.items()})


def test_a_verdict_that_its_error_could_change_is_not_decided():
    far, near, above = (of(STABLE, multibody=value) for value in (0.985, 0.995, 1.02))
    for error in (1e-2, -1e-2):
        assert judged(PARAMETERS, far, far, beside(far, multibody=error)).verdict == HOLDS
        claim = judged(PARAMETERS, near, near, beside(near, multibody=error))
        assert claim.verdict == UNDECIDED and not claim.condition
        assert "multibody = 0.995 has a numerical error of 0.01, within which the verdict could" in claim.causes[-1]
        assert judged(PARAMETERS, above, above, beside(above, multibody=error)).verdict == FAILS
    assert judged(PARAMETERS, near, near, beside(near, multibody=1e-3)).verdict == HOLDS


def test_numbers_carry_what_they_differ_by_and_none_where_closer_solvers_have_none():
    claim = judged(PARAMETERS, STABLE, STABLE, beside(STABLE, constraint=2e-9, multibody=-6e-7))
    assert [number.error for number in claim.numbers] == pytest.approx([2e-9, 6e-7])
    assert "± 6e-07" in str(claim.numbers[1]) and (claim.verdict, claim.beside) == (HOLDS, "")
    for both in ((), (STABLE, of(STABLE, multibody=math.nan))):
        claim = judged(PARAMETERS, STABLE, *both)
        assert math.isnan(claim.numbers[1].error) and "±" not in str(claim.numbers[1])
        assert (claim.verdict, claim.beside) == (HOLDS, UNKNOWN)
    shown = as_text(Shown(**{**dataclasses.asdict(claim), "numbers": []}), 80)
    assert "stable_gait: holds (errors unknown here)\n" in shown


def test_a_claim_stands_where_closer_solvers_do_not_get_there():
    assert judge.measured_of(STABLE.about, None) == ()
    assert judge.measured_of(STABLE.about, (object(), object())) == (), "an error that nobody foresaw"
    other = SimpleNamespace(cycle=SimpleNamespace(largest_multiplier=0.642))
    both = tuple(SimpleNamespace(results=SimpleNamespace(
        analytic=SimpleNamespace(gait=SimpleNamespace(largest_multiplier=value)), multibody=other))
        for value in (0.64, 0.64 + 1e-9))  # fmt: skip
    assert judge.measured_of(STABLE.about, both) == (STABLE, of(STABLE, constraint=0.64 + 1e-9))


def test_a_number_inside_of_a_tuple_is_named_and_changed():
    ladder = next(case[0] for case in CASES if case[0].about.id == "twin_like_simple")
    names, details = dict(judge.named(ladder.numbers)), ladder.numbers["details"]
    assert names["details.1.1"] == details[1][1]
    changed = judge.with_number(ladder, "details.1.1", 0.5)
    now = changed.numbers["details"]
    assert now[1] == (details[1][0], 0.5) and now[0] == details[0]
    assert of(changed, details=details) == ladder
