"""What the last digits of Table 1 leave open: linear, against gaits solved anew at the edges and at random."""

import dataclasses
import math
from functools import partial

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.derivatives.multipliers import multiplier_derivatives
from stages.analytic.derivatives.numbers import sensitive_names
from stages.analytic.derivatives.uncertainty import elasticities_of, numbers_of, together, uncertainties_of
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import describe
from stages.analytic.gait.poincare import fixed_point
from stages.analytic.parameters import DesignDigits, Parameters, Settings, SlopeDigits
from stages.analytic.questions.sensitivity import open_lines
from stages.analytic.run import neighbour, outsole_effect, zero_of
from stages.biped.rubber import soled
from tests.analytic.designs import FRICTION, RUBBER, SLOPE, TABLE_1, TABLE_1_RIGID, changed, found_gait, run_alone

DIGITS = {"hip_mass": 5e-4, "foot_mass": 5e-4, "leg_length": 5e-4, "foot_radius": 5e-4, "foot_com": 5e-4,
          "stiffness": 5e-3, "damping": 5e-4}
WIDTHS = {**{f"biped.{name}": width for name, width in DIGITS.items()}, "ground.slope_deg": 0.5}
DESIGN = DesignPoint(TABLE_1, SLOPE)


@pytest.fixture(scope="module")
def gait():
    _, point = found_gait(TABLE_1)
    return gait_derivatives(DESIGN, point, sensitive_names(DESIGN), 1e-11)


@pytest.fixture(scope="module")
def uncertainties(gait):
    return {one.name: one for one in uncertainties_of(DESIGN, gait, WIDTHS)}


def measures(design, z):
    """The numbers of the gait near `z` of another design, as `numbers_of` names them."""
    walker = design.walker()
    point = fixed_point(walker, z, 1e-10)
    found = describe(walker, point)
    numbers = {name: getattr(found, name) for name in ("period_s", "step_frequency_hz", "step_length_m", "speed_m_s")}
    numbers |= {f"multiplier_{i + 1}": abs(value) for i, value in enumerate(point.floquet_multipliers[:2])}
    return numbers | dataclasses.asdict(found.fixed_point)


@pytest.mark.parametrize("name", DIGITS)
def test_each_parameter_moves_every_number_as_far_as_gaits_at_its_edges_say(name, gait, uncertainties):
    """To a hundredth of the number's change, or of what all digits do to it."""
    parameter, width = f"biped.{name}", DIGITS[name]
    upper, lower = (measures(DESIGN.with_value(parameter, DESIGN.value(parameter) + sign * width), gait.point.z)
                    for sign in (1, -1))
    alone = {one.name: one for one in uncertainties_of(DESIGN, gait, {parameter: width})}
    for each, one in alone.items():
        found = abs(upper[each] - lower[each]) / 2
        assert one.worst == one.independent == one.decisive_part and one.decisive == parameter
        assert one.slope_least == one.slope_most == one.value
        assert abs(one.worst - found) <= 0.01 * max(found, uncertainties[each].worst), each
    assert len(alone) == 4 + 2 + 8


def test_the_slopes_half_degree_is_solved_for(gait, uncertainties):
    """Linear it would be +-.026 Hz; to 1.5 degrees the frequency hardly changes. Least and most are those of gaits."""
    design = DESIGN.with_value("ground.slope_deg", 2.5)
    walker = design.walker()
    point = fixed_point(walker, gait.point.z, 1e-10)
    steeper = describe(walker, point)
    assert uncertainties["step_frequency_hz"].slope_least == pytest.approx(steeper.step_frequency_hz, rel=1e-6)
    assert uncertainties["step_length_m"].slope_most == pytest.approx(steeper.step_length_m, rel=1e-6)
    largest = uncertainties["multiplier_1"]
    assert largest.slope_least < largest.value < largest.slope_most < 1
    lost = next(iter(uncertainties_of(DESIGN, gait, {"ground.slope_deg": 1.999})))
    assert np.isnan([lost.slope_least, lost.slope_most]).all(), "no gait on slopes of nearly nothing"
    *_, line = open_lines([lost])
    assert line.endswith("no gait on some"), "it was: nan .. nan"


def test_exact_values_leave_nothing_open_and_are_not_derived_by_twice(gait):
    assert uncertainties_of(DESIGN, gait, {}) == ()
    alone = uncertainties_of(DESIGN, gait, {"ground.slope_deg": 0.5})
    assert all(one.worst == 0.0 and one.decisive == "" and one.slope_least < one.slope_most for one in alone)
    alone = gait.only(["biped.foot_com"])
    assert len(numbers_of(alone, multiplier_derivatives(alone))[0][3]) == 1


def test_errors_that_go_together_are_added_so_and_impossible_ones_are_not_known(gait, uncertainties):
    one, other = "biped.foot_com", "biped.leg_length"
    found = uncertainties_of(DESIGN, gait, WIDTHS, correlations={(one, other): 0.9, (one, "ground.slope_deg"): 1.0})
    mixed = next(each for each in found if each.name == "period_s")
    alone = [uncertainties["period_s"].independent, *(
        next(iter(uncertainties_of(DESIGN, gait, {name: WIDTHS[name]}))).worst for name in (one, other))]
    crossed = mixed.independent**2 - alone[0] ** 2
    assert abs(crossed) == pytest.approx(2 * 0.9 * alone[1] * alone[2])
    tied = math.sqrt(alone[1] ** 2 + alone[2] ** 2 + crossed)  # a worst that the fit rules out was fifty times as large
    assert mixed.worst == pytest.approx(uncertainties["period_s"].worst - alone[1] - alone[2] + tied)
    parts, whole = {"a": 1.0, "b": -1.0, "c": 1.0}, dict.fromkeys([("a", "b"), ("b", "c")], 1.0)
    assert together(parts, {("a", "b"): 1.0}) == pytest.approx(1.0)
    assert math.isnan(together(parts, whole | {("a", "c"): -1.0}))


@pytest.mark.parametrize(("biped", "key", "width"), [
    (TABLE_1, "leg_inertia", 1e-5), (changed(TABLE_1_RIGID, frame_mass=0.05), "hip_damping", 1e-5),
    (TABLE_1, "foot_offset", 1e-6), (TABLE_1_RIGID, "hip_stiffness", 1e-5),
], ids=["of every design", "a detail", "a detail of a design without any", "the same with rigid legs"])  # fmt: skip
def test_a_parameter_that_is_zero_may_be_uncertain_too(biped, key, width):
    settings = Settings(tolerance=1e-10, steps=1, sampling_rate_hz=200.0)
    result = run_alone(Parameters(biped, SLOPE, FRICTION, RUBBER, settings, design_digits=DesignDigits({key: width})))
    one = next(each for each in result.uncertainties if each.name == "step_frequency_hz")
    there = DesignPoint(biped, SLOPE).with_value(f"biped.{key}", width)
    assert one.worst == pytest.approx(abs(one.value - measures(there, found_gait(biped)[1].z)["step_frequency_hz"]),
                                      rel=0.02)  # fmt: skip


def test_an_angle_at_which_the_hips_spring_is_relaxed_moves_mean_steps_by_its_square_alone():
    """It sets alike legs apart, and is no parameter of their gait: five times the angle does 25 times as much."""
    biped, name = changed(TABLE_1, hip_stiffness=0.05), "biped.hip_rest_angle"
    design = DesignPoint(biped, SLOPE)
    assert name not in sensitive_names(design, {name})
    assert name in sensitive_names(design.with_value(name, 0.01))
    z = found_gait(biped)[1].z
    none, small, large = (measures(design.with_value(name, angle), z)["period_s"] for angle in (0.0, 0.01, 0.05))
    assert (large - none) / (small - none) == pytest.approx(25, rel=0.03)


def test_the_stage_tells_elasticities_of_all_and_uncertainties_of_what_is_given(gait, uncertainties):
    settings = Settings(tolerance=1e-7, steps=1, sampling_rate_hz=200.0)
    result = run_alone(Parameters(TABLE_1, SLOPE, FRICTION, RUBBER, settings, design_digits=DesignDigits(DIGITS)))
    assert [one.parameter for one in result.elasticities] == list(sensitive_names(DESIGN))
    assert {one.parameter: one.half_width for one in result.elasticities if one.half_width} == {
        f"biped.{name}": width for name, width in DIGITS.items()}
    assert all(one.slope_least == one.slope_most == one.value for one in result.uncertainties)
    again = uncertainties_of(DESIGN, gait, WIDTHS, multiplier_derivatives(gait))
    assert again == tuple(uncertainties.values()), "multipliers known already are not derived again"
    assert result.uncertainties[0].value == result.gait.period_s
    exact = run_alone(Parameters(TABLE_1_RIGID, SLOPE, FRICTION, RUBBER, settings))
    names = sensitive_names(DesignPoint(TABLE_1_RIGID, SLOPE))
    assert exact.uncertainties == () and len(exact.elasticities) == len(names) > 0


def test_elasticities_are_those_of_the_derivatives(gait):
    shares = gait.elasticities()
    for row, one in enumerate(elasticities_of(gait, WIDTHS)):
        assert (one.period, one.step_length, one.speed) == tuple(
            shares[name][row] for name in ("period_s", "step_length_m", "speed_m_s"))
        assert one.scale == (one.value or one.scale) > 0


@pytest.mark.slow
def test_linear_uncertainty_is_that_of_ten_thousand_designs(gait, uncertainties):
    """Every digit rounded anew, evenly: spread, extremes and every design, of measures and multipliers."""
    rng, names = np.random.default_rng(7), list(DIGITS)
    draws = rng.uniform(-1, 1, (10_000, len(names)))
    inexact = gait.only([f"biped.{name}" for name in names])
    numbers = numbers_of(inexact, multiplier_derivatives(inexact))
    linear = {name: (value, row) for name, _, value, row in numbers}
    scales = np.array([TABLE_1.__dict__[name] for name in names])
    shares = draws * np.array([DIGITS[name] for name in names]) / scales
    dz = inexact.z
    wanted = ("period_s", "step_frequency_hz", "step_length_m", "speed_m_s", "multiplier_1", "multiplier_2")
    found = {name: np.empty(len(draws)) for name in wanted}
    for index, share in enumerate(shares):
        design = dataclasses.replace(DESIGN, biped=dataclasses.replace(
            TABLE_1, **dict(zip(names, (scales * (1 + share)).tolist()))))
        solved = measures(design, gait.point.z + dz @ share)
        for name in wanted:
            found[name][index] = solved[name]
    for name in wanted:
        value, row = linear[name]
        one, moved = uncertainties[name], found[name] - value
        assert np.abs(moved - shares @ row).max() <= 0.02 * one.worst, name
        assert moved.std() == pytest.approx(one.independent / np.sqrt(3), rel=0.02), name
        assert np.abs(moved).max() <= 1.02 * one.worst, name
        assert np.abs(moved).max() > 0.7 * one.worst, name


# --- An outsole quickens the gait by its length and slows it by its mass.


def test_the_sign_turns_where_the_frequency_is_the_bare_feets():
    _, point = found_gait(TABLE_1)
    near = partial(neighbour, DesignPoint(TABLE_1, SLOPE), point.z, 1e-10)
    usual = near(TABLE_1)[1]
    found = outsole_effect(near, TABLE_1, RUBBER, 0.002)
    assert found.mass == pytest.approx(9.856e-3)
    assert found.frequency_with_mass < usual < found.frequency_without_mass
    assert 0.0 < found.turning_mass < found.mass
    assert near(soled(TABLE_1, RUBBER, 0.002, found.turning_mass))[1] == pytest.approx(usual, abs=1e-8)
    # most of what the mass does it does as inertia about the leg's mass centre, which Table 1 does not have
    weighed = soled(TABLE_1, RUBBER, 0.002, found.mass)
    as_points = near(dataclasses.replace(weighed, leg_inertia=0.0))[1]
    assert found.frequency_with_mass < as_points < usual


def test_a_layer_that_slows_without_mass_has_no_turning_mass():
    assert math.isnan(zero_of(lambda mass: -1.0 - mass, (0.0, -1.0), (0.01, -1.01)))
    assert zero_of(lambda mass: 1.0 - 100.0 * mass, (0.0, 1.0), (0.02, -1.0)) == pytest.approx(0.01)


def test_legs_that_hardly_differ_leave_as_much_of_a_disturbance_in_a_step_as_legs_alike():
    """Their multipliers are of two steps: .41 of .64 a step, which report, headline and claims gave as a step's."""
    settings = Settings(tolerance=1e-8, steps=1, sampling_rate_hz=200.0)
    other = dataclasses.replace(TABLE_1, other_foot_mass=TABLE_1.foot_mass * (1 + 1e-7))
    design = DesignDigits({name: width for name, width in DIGITS.items() if name != "foot_mass"})
    digits = {"design_digits": design, "slope_digits": SlopeDigits({"slope_deg": 0.05})}
    alike, differing = (run_alone(Parameters(biped, SLOPE, FRICTION, RUBBER, settings, **digits))
                        for biped in (TABLE_1, other))  # fmt: skip
    assert (alike.gait.steps, differing.gait.steps) == (1, 2)
    assert differing.gait.largest_multiplier == pytest.approx(alike.gait.largest_multiplier, abs=1e-5)
    assert alike.gait.largest_multiplier == np.hypot(*alike.gait.floquet_multipliers[0])
    assert differing.summary() == alike.summary()
    one, two = (next(row for row in found.uncertainties if row.name == "multiplier_1") for found in (alike, differing))
    of_one = two.of_a_step(2)
    assert one.of_a_step(1) == one and of_one.decisive == one.decisive
    for name in ("value", "worst", "independent", "decisive_part", "slope_least", "slope_most"):
        assert getattr(of_one, name) == pytest.approx(getattr(one, name), rel=2e-3), name
