"""The stage as a whole, from a stand-in for the analytic result."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from stages.biped.design import BeyondModel
from stages.planar.run import FELL, STALLED
from stages.twin.machine.contact import COUNT, ROLL, YAW, Z
from stages.twin.parameters import SIGNALS
from stages.twin.result import Settling, with_doubt
from stages.twin.run import Inputs, run
from stages.twin.walking.measures import SETTLED_STEPS, settling, transient_left
from stages.twin.walking.record import Record
from tests.changed import changed


@pytest.fixture(scope="module")
def analytic(rough):
    return SimpleNamespace(mid_stance=rough, walk=SimpleNamespace(standing_force=9.4),
                           limp=SimpleNamespace(feet_apart_m=np.full(2, 0.12)))  # fmt: skip


@pytest.fixture(scope="module")
def result(parameters, analytic):
    return run(changed(parameters, steps=4, signals=SIGNALS), Inputs(analytic))


def of_one_step(parameters, analytic, **settings):
    """A shorter run, with other settings."""
    return run(changed(parameters, steps=1, tolerance=1e-5, **settings), Inputs(analytic))


@pytest.fixture(scope="module")
def short(parameters, analytic):
    return of_one_step(parameters, analytic, signals=SIGNALS)


def test_it_walks_and_says_so(result):
    assert result.outcome == "completed" and result.steps == 4
    assert "4 steps" in result.summary() and "\n" not in result.summary()
    assert len(result.walk.heel_strike_time) == 4 and len(result.settling.step_period) == 3
    assert result.energy.relative_residual < 1e-4


def test_a_design_in_detail_walks_and_its_bill_is_that_of_its_plain_one(parameters, analytic, short):
    biped = dataclasses.replace(parameters.biped, other_foot_mass=0.34, hip_stiffness=0.02, frame_mass=0.03,
                                frame_com=0.03)  # fmt: skip
    found = of_one_step(dataclasses.replace(parameters, biped=biped), analytic, signals=SIGNALS)
    assert found.outcome == "completed" and found.parts == short.parts and found.sums == short.sums
    assert abs(found.walk.hip_position[-1] - short.walk.hip_position[-1]).max() > 1e-5


def test_feet_that_are_put_down_at_a_time_are_refused(parameters, analytic):
    timed = dataclasses.replace(parameters.biped, legs="rigid", feet_retract=True, strike_time=0.45)
    with pytest.raises(BeyondModel, match="strike_time"):
        of_one_step(dataclasses.replace(parameters, biped=timed), analytic)


def test_signals_share_one_grid(result, parameters):
    n, signals = len(result.walk.time), result.signals
    spacing = np.diff(result.walk.time)
    assert spacing.min() > 0 and spacing.max() <= 1.000001 / parameters.settings.sampling_rate_hz
    for sensor in ("hip", "foot"):
        for what in ("specific_force", "angular_velocity"):
            assert getattr(signals, f"{sensor}_imu_{what}").shape == (n, 3)
    assert signals.roll.shape == signals.yaw.shape == signals.lateral.shape == (n,)
    values = (signals.coordinates, signals.foot_force, *vars(result.walk).values())
    assert all(np.isfinite(value).all() for value in values)


WHERE = {"imu_in_space": "foot_imu_angular_velocity", "attitude": "roll", "coordinates": "coordinates",
         "foot_force": "foot_force"}  # fmt: skip


@pytest.mark.parametrize("name", SIGNALS)
def test_a_signal_left_out_is_not_in_the_result_and_the_others_are(short, parameters, analytic, name):
    """The walk is the same to the bit; the artefact is smaller."""
    named = tuple(other for other in SIGNALS if other != name)
    less = of_one_step(parameters, analytic, signals=named)
    rows = {other: len(getattr(less.signals, field)) for other, field in WHERE.items()}
    rows |= {"ground_reaction": len(less.walk.ground_reaction), "imu": len(less.walk.foot_specific_force)}
    assert rows == {other: 0 if other == name else len(less.walk.time) for other in SIGNALS}
    assert less.inventory.sampled_bytes < short.inventory.sampled_bytes
    assert less.inventory.recorded_bytes == short.inventory.recorded_bytes
    assert np.array_equal(less.walk.hip_position, short.walk.hip_position)
    for field in ("hip_specific_force", "ground_reaction", "leg_rate"):
        if len(getattr(less.walk, field)):
            assert np.array_equal(getattr(less.walk, field), getattr(short.walk, field))


def test_the_spike_of_a_heel_strike_does_not_depend_on_the_rate(short, parameters, analytic):
    """It is some 20 us wide; samples 50 us apart show between a half and all of it."""
    dense = of_one_step(parameters, analytic, signals=("imu",), sampling_rate_hz=1e5)
    for name in ("hip_specific_force", "foot_specific_force"):
        peaks = [np.abs(getattr(walk, name)).max() for walk in (short.walk, dense.walk)]
        assert peaks[0] == pytest.approx(peaks[1], rel=0.02)


def test_snapshots_show_legs_of_the_right_length(result):
    poses = result.snapshots
    along = np.einsum("kij,kij->ki", poses.leg_top - poses.foot_centre, poses.leg_up)
    assert along + poses.foot_radius == pytest.approx(0.333, abs=0.01)
    assert poses.foot_centre[:, :, 1].min() > 0.9 * poses.foot_radius[0]


def test_tables_name_every_part_and_every_sum(result, parameters):
    (_, columns, bill), (_, _, sums), (_, _, steps) = result.tables()
    assert [row[0] for row in bill] == [part.name for part in parameters.settings.parts]
    assert all(len(row) == len(columns) for row in bill)
    assert len(sums) == 7 and len(steps) == 3
    for row, part in zip(bill, result.parts, strict=True):  # g of kg, mm of m, kg mm2 of kg m2
        known = [1e3 * size for size in (part.mass, part.x, part.y, part.z)]
        assert [float(cell) for cell in row[5:9]] == pytest.approx(known, abs=0.051), row
        moments = [1e6 * moment for moment in (part.inertia_x, part.inertia_y, part.inertia_z)]
        assert [float(cell) for cell in row[9:]] == pytest.approx(moments, abs=0.0051), row
    settling = result.settling
    assert [float(cell) for row in steps for cell in row[1:]] == pytest.approx(
        np.column_stack([settling.step_period, 1e3 * settling.step_length]).ravel(), abs=6e-4)


def test_a_fall_is_a_result(parameters, rough, analytic):
    slow = dataclasses.replace(rough, stance_rate=-0.4, swing_rate=0.0)
    result = run(parameters, Inputs(SimpleNamespace(**{**vars(analytic), "mid_stance": slow})))
    assert result.outcome in (FELL, STALLED) and result.reason and result.reason in result.summary()
    assert np.isnan(result.settling.period_s) and len(result.walk.time) > 10 and result.steps < 5
    assert np.isfinite(result.walk.hip_position).all()


@pytest.mark.slow
def test_it_walks_a_hundred_steps(parameters, analytic):
    result = run(changed(parameters, steps=100), Inputs(analytic))
    assert result.outcome == "completed" and result.steps == 100
    assert 0 <= result.settling.steps_to_settle < 20


# --- How a walk settles, of one that is made up.


def settled(periods, lengths, legs=(0, 1)):
    """What is said of steps of these periods [s] and lengths [m] of a twin that turns, and its strikes [s]."""
    strikes = 0.3 + np.concatenate(([0.0], np.cumsum(periods)))
    time, position = np.linspace(0.0, strikes[-1] + 0.2, 4001), np.zeros((4001, COUNT))
    position[:, 0] = np.interp(time, strikes, 0.7 + np.concatenate(([0.0], np.cumsum(lengths))))
    position[:, Z], position[:, YAW] = 0.02 - 0.01 * time, 0.3 + 0.1 * time
    position[:, ROLL] = np.where(time < strikes[-5:][0] - 2e-3, 0.2, -0.03 * np.sin(40.0 * time) ** 2)
    walk = SimpleNamespace(heel_strike_time=strikes, heel_strike_leg=np.resize(legs, len(strikes)),
                           double_stance=lambda of: (of[0], of[-1]))  # fmt: skip
    zero = np.zeros_like(position)
    record = Record(time, position, zero, zero, (True, True), (), None, None, None, "", "", len(strikes), 0,
                    exact_acceleration=False)  # fmt: skip
    return settling(record, walk), strikes


def test_a_walk_has_settled_from_the_step_on_that_is_like_the_last_four():
    periods, lengths = np.array([0.6, 0.52, 0.501, 0.499, 0.501, 0.499]), np.full(6, 0.16)
    found, strikes = settled(periods, lengths)
    walked = strikes[-1] + 0.2
    assert (found.steps_to_settle, found.double_stance_s) == (2, (strikes[-5], strikes[-2]))
    measured = (found.period_s, found.step_frequency_hz, found.step_length_m, found.speed_m_s)
    assert measured == pytest.approx((0.5, 2.0, 0.16, 0.32), rel=1e-4)
    np.testing.assert_allclose(found.step_period, periods)
    np.testing.assert_allclose(found.step_length, lengths, atol=1e-4)  # samples are .3 mm apart
    assert found.largest_roll == pytest.approx(0.03, rel=1e-2), "of the last four steps, to whichever side"
    assert found.inner_outer_difference == pytest.approx(0.004), "a step that the inner pair's landing begins is longer"
    assert (found.yaw_change, found.lateral_drift) == pytest.approx((0.1 * walked, -0.01 * walked))
    assert settled(periods, lengths, legs=(1, 0))[0].inner_outer_difference == pytest.approx(-0.004)
    assert settled(periods[1:], lengths[1:])[0].steps_to_settle == 1
    assert settled(periods[2:], lengths[2:])[0].steps_to_settle == 0
    late = settled(periods, np.array([0.16, 0.16, 0.16, 0.19, 0.16, 0.16]))[0]
    assert late.steps_to_settle == -1, "its last four are not alike"
    limps = np.array([0.7, 0.46, 0.504, 0.464, 0.504, 0.464, 0.504])
    for walked in (limps, limps[:-1]):
        assert settled(walked, np.full(len(walked), 0.16))[0].steps_to_settle == 1, "legs differ, and so do their steps"
    short = settled(periods[:3], lengths[:3])[0]
    assert short.steps_to_settle == -1 and np.isnan(short.period_s) and short.yaw_change > 0.1
    assert len(settled([], [])[0].step_period) == 0


# --- What is left of a transient in the mean of a walk's last steps, and how it is told.


STEPS, DRAWN, LIMP = 13, 400, 0.3


def faded(rng, multipliers, steps=STEPS):
    """Two measures (steps,) of a walk that settles at zero, but for a limp that stays, by these two multipliers."""
    waves = np.array(multipliers)[:, None] ** np.arange(steps)
    pair = waves[0].imag.any()
    return [
        (waves[0] * complex(*rng.normal(size=2))).real + LIMP * (-1.0) ** np.arange(steps) if pair
        else rng.normal(size=2) @ waves.real + LIMP * (-1.0) ** np.arange(steps) for _ in (0, 1)
    ]  # fmt: skip


def drawn(rng):
    """Two real multipliers of any sign, or a complex pair, up to .85."""
    if rng.random() < 0.5:
        return rng.uniform(-0.85, 0.85, 2).astype(complex)
    one = rng.uniform(0.2, 0.85) * np.exp(1j * rng.uniform(0.1, 3.0))
    return np.array([one, one.conjugate()])


def test_a_gait_lies_within_what_the_transient_leaves():
    rng, covered, shares = np.random.default_rng(7), 0, []
    for _ in range(DRAWN):
        measures = faded(rng, drawn(rng))
        for measure, left in zip(measures, transient_left(*measures), strict=True):
            off = abs(measure[-SETTLED_STEPS:].mean())
            covered += not off > left
            shares.append(off / left)
    assert covered > 0.99 * 2 * DRAWN
    assert np.nanmedian(shares) > 0.02, "a bound that covers all by its size tells nothing"


#: Steps [s] and [m] of a twin with multipliers -.982 and .68, and its gait by the ladder: as what is to go of its limp
#: fades, mean durations and lengths go on rising after the faster transient that hid it.
LIMPING = (
    ([0.5740807, 0.5588021, 0.5727677, 0.5577617, 0.5719916, 0.5575046, 0.5714693, 0.5575942, 0.5710831, 0.5578269,
      0.5707746, 0.5581088, 0.5705130, 0.5583991], 0.564864),
    ([0.1751787, 0.1747192, 0.1737676, 0.1737536, 0.1731394, 0.1733179, 0.1728682, 0.1731295, 0.1727638, 0.1730568,
      0.1727365, 0.1730373, 0.1727436, 0.1730414], 0.173218))  # fmt: skip


def test_a_limp_that_fades_slowly_leaves_more_than_the_means_change_by():
    measures = [np.array(steps) for steps, _ in LIMPING]
    for measure, (_, gait), left in zip(measures, LIMPING, transient_left(*measures), strict=True):
        assert 0.1 * left < abs(measure[-SETTLED_STEPS:].mean() - gait) < left


def test_a_limp_moves_the_mean_by_its_square_alone():
    """What is to go of this one is a thousandth: its square counts for nothing beside the transient of the mean."""
    steps = np.arange(STEPS)
    mean, limp = 0.5 + 0.01 * 0.8**steps, 1e-3 * (-0.95) ** steps
    assert transient_left(mean + limp) == pytest.approx(transient_left(mean), rel=0.2)


def test_one_that_does_not_fade_and_a_short_walk_are_unknown():
    rng = np.random.default_rng(8)
    growing = faded(rng, 1.05 * np.exp([1.0j, -1.0j]))
    assert np.isnan(transient_left(*growing)).all()
    assert np.isnan(transient_left(*faded(rng, [0.5 + 0j, 0.2 + 0j], steps=9))).all()


@pytest.mark.parametrize(("value", "left", "text"), [
    (2.04205, 6.2e-4, "2.0421 ± 0.0007"), (160.31, 0.11, "160.31 ± 0.11"), (750.2, 3.0, "750 ± 3"),
    (1982.378, float("nan"), "1982 (what is left of the transient is unknown)"),
])
def test_a_mean_is_told_with_the_digits_that_the_transient_leaves(value, left, text):
    assert with_doubt(value, left) == text


def test_a_frequency_is_as_unsure_as_its_period():
    nothing = np.zeros(0)
    gait = Settling(nothing, nothing, 1, 0.5, 2.0, 0.16, period_transient_s=2.4e-4, step_length_transient_m=1e-4)
    assert gait.last_four() == "2.0000 ± 0.0010 Hz and 160.00 ± 0.10 mm"
    gait = dataclasses.replace(gait, period_transient_s=float("nan"), step_length_transient_m=float("nan"))
    assert gait.last_four() == "2 Hz and 160 mm (what is left of the transient is unknown)", "said once, after the unit"
    assert Settling(nothing, nothing, -1).last_four() == "there are fewer", "of a twin that fell it was nan Hz"
