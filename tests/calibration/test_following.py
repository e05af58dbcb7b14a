"""A robot that is followed: its state, held against the walk that the recording was made from, and its file."""

import dataclasses
import hashlib
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait, step_length
from stages.biped.question import WrongOption
from stages.calibration.estimation.run_fit import design_sizes
from stages.calibration.following import track
from stages.calibration.following.follower import Follower
from stages.calibration.following.present import Present
from stages.calibration.following.robot_file import NAME, FittedRobot, Learned
from stages.calibration.following.step import Step
from stages.calibration.following.track import Track, follow, forecasts, lateness, samples_of, with_forecasts
from stages.calibration.information.identifiability import SLOPE, first_model
from stages.calibration.observation.measured_run import SIDES, MeasuredRun, layout_of, usable
from stages.calibration.observation.prediction import predict, walk
from stages.calibration.recordings import as_mounted
from stages.calibration.result import FittedRun
from stages.calibration.run import followed
from tests.calibration.runs import DESIGN, PARAMETERS, SETTINGS, disturbed
from tests.similar import similar

#: Spread of a robot's parameters about what a fit found, in usual changes (3 % of each).
KNOWN_TO = 0.02


def model():
    """What is not known of a run whose sensors have been fitted before."""
    names = ("biped.hip_mass", "biped.foot_mass", "biped.leg_length", "biped.foot_radius", "biped.foot_com",
             "biped.stiffness", "biped.damping")  # fmt: skip
    found = first_model(DESIGN, names, PARAMETERS)
    sd = design_sizes(DESIGN, found.of_design) * KNOWN_TO
    d = len(found.shared)
    mounting = np.array([[0.0, 1e-3], [0.0, 0.03]])
    values = np.array([DESIGN.value(name) for name in found.shared])
    robot = FittedRobot(DESIGN, found.shared, np.diag(sd[:d] ** 2), found.own, sd[d:], mounting, 1.0, 1.0, 0.0, 1e-3,
                        np.diag(sd[:d] ** -2), values, (), 9, 0.01, False,
                        {"slope_deg": (0.01, 0.1, 9.0)}, DESIGN)  # fmt: skip
    return robot, robot.model(found)


def made(seed, steps, **given):
    """A run of a robot that was drawn, its design, and its unknowns, some of which are `given`."""
    robot, fitted = model()
    rng = np.random.default_rng(seed)
    design = DESIGN.with_values(dict(zip(
        fitted.of_design, rng.multivariate_normal([DESIGN.value(name) for name in fitted.of_design], robot.of_design()),
        strict=True)))
    layout = fitted.layout
    unknowns = layout.middle + np.where(np.isfinite(layout.prior), layout.prior, layout.sizes) * rng.normal(
        size=len(layout.names))
    unknowns[layout.place("mid_stance")] = layout.middle[layout.place("mid_stance")]
    for name, value in given.items():
        unknowns[layout.place(name)] = value
    _, _, sampling = disturbed(seed, steps)
    found = predict(design, (), unknowns, layout, sampling, 1e-9)
    strikes = np.concatenate([[0.0], found.strikes[:, 0]]) / (1.0 + unknowns[layout.place("hip_clock")])
    strikes = strikes[strikes <= sampling.hip[-1]]
    samples = {side: found.samples[side][:, :, 0] + rng.normal(size=(len(sampling.of(side)), 3)) * fitted.noise
               for side in SIDES}  # fmt: skip
    first = float(sampling.hip[0])
    used = {side: usable(sampling.of(side), strikes, first, SETTINGS.before_strike_s, SETTINGS.after_strike_s)
            for side in SIDES}  # fmt: skip
    slope = design.value(SLOPE)
    run = MeasuredRun(f"drawn {seed}", sampling, samples, used, strikes, {SLOPE: (slope + 0.05 * rng.normal(), 0.05)})
    return run, design, unknowns


def clock(names):
    """That of the hip, which is right."""
    return len(names) + model()[1].layout.place("hip_clock"), 0.0, 0.0


def true_times(unknowns, times):
    """When the hip's clock shows times (m,) [s]; states and strikes are told by that."""
    return np.array(times) * (1.0 + unknowns[model()[1].layout.place("hip_clock")])


def follower():
    robot, fitted = model()
    return Follower(DESIGN, fitted, robot.of_design(), SETTINGS)


def errors(seed, steps):
    """Normalised squared errors of the states of a run, by component and of all together; strikes inside their 95 %
    intervals a tenth of a second before, of how many; and innovations."""
    run, design, unknowns = made(seed, steps)
    instants = list(follow(follower(), run))
    times = true_times(unknowns, [one.time for one in instants])
    truth, lie = walk(design, (), unknowns, model()[1].layout, run.sampling, run.duration, 1e-9).states(times)
    same = [(one, state[:, 0]) for one, state, stretch in zip(instants, truth, lie, strict=True)
            if stretch.stance_leg == one.leg]  # fmt: skip
    off = [one.state - state for one, state in same]
    alone = [error**2 / np.diag(one.covariance) for error, (one, _) in zip(off, same, strict=True)]
    joint = [error @ np.linalg.solve(one.covariance, error) / error.size
             for error, (one, _) in zip(off, same, strict=True)]  # fmt: skip
    inside = []
    for strike in run.strikes:
        before = [one for one in instants if strike - 0.2 < one.time < strike - 0.1]
        inside += [abs(before[-1].strike - strike) < 1.96 * before[-1].strike_sd] if before else []
    size = float(np.nanmean([one.innovation for one in instants]))
    return np.mean(alone, axis=0), float(np.mean(joint)), inside, size


def test_a_step_comes_to_rest_after_a_linearisation_or_two(monkeypatch):
    """Its angle at mid-stance is known for certain, and moves by what is rounded."""
    run, _, _ = made(7, 8)
    again, nearer = [], Follower.nearer
    monkeypatch.setattr(Follower, "nearer", lambda self, step, *until: again.append(step) or nearer(self, step, *until))
    assert list(follow(follower(), run))
    assert 5 <= len(again) <= 12


@pytest.mark.parametrize("period", [0.3, 0.9])
def test_a_step_is_walked_to_the_first_event_after_a_fifth_more_than_its_period(period):
    run, _, _ = made(7, 8)
    _, at = follower().begin(run)
    walked = follower().walked(at, run.sampling, period)
    *_, before, last = (float(one.start[0] + one.duration[0]) * walked.walker.time for one in walked.stretches)
    assert before <= 1.2 * period < last


class Bent:
    """A step with one unknown, which is known by its arctangent: whole steps of Gauss and Newton lead away from 1.4 on.
    """

    def __init__(self, at):
        bend = 1e-2 * (1.0 + at**2)
        self.at, self.cost = np.array([at]), (np.arctan(at) / 1e-2) ** 2
        self.known = SimpleNamespace(mean=self.at - 1e2 * bend * np.arctan(at), covariance=np.array([[bend**2]]))


def test_a_move_that_fits_worse_is_shortened():
    track, entered = Track.__new__(Track), []
    track._follower = SimpleNamespace(
        nearer=lambda step, period, until, share=1.0: Bent(float((step.at + share * (step.known.mean - step.at))[0])),
        onwards=lambda step, share=1.0: SimpleNamespace(mean=step.at + share * (step.known.mean - step.at)),
        mid_stance=lambda at: 0.0)  # fmt: skip
    track._step, track._period, track._usual, track._until = Bent(2.0), 0.5, 0.5, 1.0
    track._begun, track._enter = lambda estimate, at: at, entered.append
    list(track._settle())
    assert abs(entered[0][0]) < 1e-3


def test_what_a_step_costs_counts_each_sample_once(monkeypatch):
    """One after another as they came, or all again; and less is left of it where it is linearised again."""
    run, _, _ = made(7, 8)
    costs, nearer = [], Follower.nearer

    def seen(self, step, *until):
        found = nearer(self, step, *until)
        costs.append((step.cost, step.about(step.at, step.walked).cost, found.cost))
        return found

    monkeypatch.setattr(Follower, "nearer", seen)
    assert list(follow(follower(), run))
    taken, again, then = np.array(costs).T
    np.testing.assert_allclose(taken, again, rtol=1e-6)
    assert np.all(then < taken) and 20.0 < then.min() < taken.max()


def test_a_start_may_be_carried_on_from_where_it_was_linearised():
    track = Track(follower(), made(3, 5)[0])
    robot, step, places = track._follower, track._step, track._follower.start
    there, mean, half = (robot.onwards(step, share).mean for share in (0.0, 1.0, 0.5))
    np.testing.assert_allclose(there[places[:-1]], step.walked.next_start()[:-1, 0])
    np.testing.assert_allclose(half, 0.5 * (there + mean), rtol=1e-12)
    assert np.abs(mean - there).max() > 1e-4


def test_a_step_is_known_no_better_than_residuals_would_show_of_what_the_model_lacks():
    """Of a robot whose residuals are noise, by two runs or forty. Without it, of seven runs of a limping robot two had
    angles 2.3 and 6.7 standard errors off (rms), the others .8; with it all have .5 to .9."""
    robot, fitted = model()
    run, _, unknowns = made(3, 5)
    step = Track(follower(), run)._step

    def known(runs):
        learned = (Learned(run, np.zeros(1), unknowns),) * runs
        return Follower.of(dataclasses.replace(robot, learned=learned), fitted, SETTINGS).onwards(step).covariance

    places, none = follower().start[1:], known(0)
    sizes = follower().anywhere.layout.sizes[np.array(places) - len(fitted.of_design)]
    for runs in (2, 40):
        readings = runs * sum(run.used[side].sum() for side in SIDES)
        more = np.sqrt(np.maximum(np.diag(known(runs) - none)[places], 0.0)) / sizes
        assert more[:-1] == pytest.approx(0.06 * (2.0 / readings) ** 0.25, rel=1e-3)


def test_no_answer_waits_for_what_the_next_ones_need(monkeypatch):
    """Steps are linearised and drawn states walked after an answer, when the next sample is not there yet."""
    run, _, _ = made(7, 8)
    work, nearer, falls = [], Follower.nearer, Step.falls
    monkeypatch.setattr(Follower, "nearer", lambda self, *of: work.append("nearer") or nearer(self, *of))
    monkeypatch.setattr(Step, "falls", lambda self: work.append("falls") or falls(self))
    followed_run, answered, told = Track(follower(), run), 0, 0
    for sample in samples_of(run):
        before, answers = len(work), followed_run.take(sample)
        for instant in answers:
            assert len(work) == before
            answered, told = answered + 1, told + bool(instant.falls)
    assert answered > 200 and told == work.count("falls") > 3 and work.count("nearer") > 4


def test_the_next_mid_stance_takes_the_starts_place_with_exact_derivatives():
    """The walk goes on from there as it did, and what it is by the start and the design agrees with differences."""
    run, design, unknowns = made(1, 5)
    fitted = model()[1]
    names, layout = fitted.of_design, fitted.layout

    def onwards(values, start):
        there = design.with_values(dict(zip(names, map(float, values), strict=True)))
        return walk(there, names, start, layout, run.sampling, 0.7, 1e-11)

    values = np.array([design.value(name) for name in names])
    begun = onwards(values, unknowns)
    rows = begun.next_start()
    later = unknowns.copy()
    later[: layout.free], later[layout.place("mid_stance")] = rows[:-1, 0], rows[-1, 0]
    sampling = dataclasses.replace(run.sampling, first_leg=1 - run.sampling.first_leg)
    times = rows[-1, 0] + np.array([0.06, 0.1])
    np.testing.assert_allclose(walk(design, names, later, layout, sampling, 0.2, 1e-11).states(times)[0][:, :, 0],
                               begun.states(times)[0][:, :, 0], atol=1e-6)
    whole = np.concatenate([values, unknowns])
    sizes = np.concatenate([design_sizes(design, names), layout.sizes])
    for place in (0, 2, len(names) - 1, len(names), len(names) + 3):
        ends = []
        for sign in (1, -1):
            moved = whole.copy()
            moved[place] += sign * 1e-4 * sizes[place]
            ends.append(onwards(moved[: len(names)], moved[len(names) :]).next_start()[:, 0])
        np.testing.assert_allclose(rows[:, 1 + place], (ends[0] - ends[1]) / (2e-4 * sizes[place]), rtol=1e-5,
                                   atol=1e-5 * np.abs(rows[:, 1 + place]).max())  # fmt: skip


def test_a_walk_goes_on_from_anywhere_as_it_did():
    """After a push a step begins where the robot is, on either leg, at an angle that is one of its unknowns."""
    run, design, unknowns = made(1, 5)
    anywhere = follower().anywhere
    begun = walk(design, anywhere.of_design, np.append(0.0, unknowns), anywhere.layout, run.sampling, 0.9, 1e-11)
    for time in begun.strikes()[:2, 0] - np.array([0.1, 0.05]):
        rows, leg = begun.start_at(float(time))
        there = np.concatenate([rows[:-1, 0], unknowns[anywhere.layout.free - 1:]])
        there[anywhere.layout.place("mid_stance")] = time
        sampling = dataclasses.replace(run.sampling, first_leg=leg)
        again = walk(design, (), there, anywhere.layout, sampling, 0.3, 1e-11)
        times = time + np.array([0.02, 0.3])
        np.testing.assert_allclose(again.states(times)[0][:, :, 0], begun.states(times)[0][:, :, 0], atol=1e-6)
    number = next(number for number, stretch in enumerate(begun.stretches) if stretch.double)
    lands, stands = begun.begins()[0][number : number + 2] * begun.walker.time
    both = 0.5 * (lands + stands)
    rows, leg = begun.start_at(both)
    assert rows[-1, 0] == pytest.approx(stands) and leg == begun.stretches[number + 1].stance_leg
    ended = dataclasses.replace(begun, stretches=begun.stretches[: number + 1])  # before one leg alone stands
    assert ended.start_at(both)[0][-1, 0] == pytest.approx(both)


def test_a_state_is_known_as_well_as_it_says():
    """Two runs: the mean over many is one, that of a single run may be a few times as large."""
    found = [errors(seed, 8) for seed in (1, 2)]
    assert all(np.all(alone < 9.0) and joint < 4.0 for alone, joint, *_ in found)
    assert sum(sum(inside) for *_, inside, _ in found) >= 0.75 * sum(len(inside) for *_, inside, _ in found) > 4
    assert [innovation for *_, innovation in found] == pytest.approx([1.0, 1.0], abs=0.15)


def test_strikes_are_late_as_those_of_the_robots_own_runs_were_after_their_forecasts():
    robot, fitted = model()
    learned = []
    for seed in (1, 2):
        run, _, unknowns = made(seed, 8)
        found_late = run.strikes + np.where(run.strikes > 0.0, 2e-3, 0.0)
        learned.append(Learned(dataclasses.replace(run, strikes=found_late), np.zeros(1), unknowns))
    found = with_forecasts(dataclasses.replace(robot, learned=tuple(learned)), fitted, SETTINGS)
    assert found.late == pytest.approx(2e-3, abs=4e-4) and found.late_sd < 1e-3


def test_a_robot_is_followed_by_the_model_that_its_own_runs_were_followed_by():
    """About the gait that its fit began with: about the one that was found, a run of a rigid twin had typical
    innovations of 1.50 where 1.26 was kept of it."""
    robot, fitted = model()
    found = dataclasses.replace(robot, design=DESIGN.with_value("biped.foot_radius", 1.1 * DESIGN.biped.foot_radius))
    layout = Follower.of(found, found.fitted_by(PARAMETERS), SETTINGS).model.layout
    assert (layout.middle == fitted.layout.middle).all() and (layout.strike == fitted.layout.strike).all()


def test_only_strikes_that_were_forecast_show_how_late_they_come():
    """Of a robot that was hardly followed there may be none."""
    instants = [SimpleNamespace(time=0.1 * n + 0.05, strike=1.0 if n >= 8 else math.nan,
                                strike_sd=1e-3 if n >= 8 else math.nan) for n in range(12)]  # fmt: skip
    found = forecasts(instants, np.array([0.0, 0.5, 1.0]))
    assert found.tolist() == [[0.0, 1e-3]] and lateness([forecasts(instants[:8], np.array([0.0, 0.5]))]) == (0.0, 0.0)


@pytest.mark.parametrize("runs", [2, 9, 12])
def test_strikes_are_late_as_those_of_all_of_nine_runs_the_ones_held_out_among_them(runs, monkeypatch):
    robot, fitted = model()
    run, _, unknowns = made(1, 5)
    learned = (Learned(run, np.zeros(1), unknowns),) * runs
    followed_runs = []
    monkeypatch.setattr(track, "follow", lambda _, one: iter(followed_runs.append(one) or ()))
    held_out = [dataclasses.replace(run, name="held out")] * 3
    with_forecasts(dataclasses.replace(robot, learned=learned), fitted, SETTINGS, held_out)
    assert len(followed_runs) == min(runs + 3, 9) and followed_runs[-3:] == held_out


@pytest.mark.parametrize("runs", [3, 9])
def test_a_further_runs_strikes_are_as_late_as_runs_and_strikes_scatter(runs):
    """Of 2,000 robots whose runs differ as much as strikes do, or five times, and of ones whose runs are alike. Where
    first forecasts are vague, 95 % intervals of all held 87 %."""
    alike, limps = np.full(7, 3e-4), 1e-3 * np.array([4.8, 0.5, 1.1, 0.3, 1.0, 0.3, 0.8])
    for between, scatter, own in ((1e-2, 2e-3, alike), (2e-3, 2e-3, alike), (0.0, 2e-3, alike), (0.0, 1e-3, limps)):
        rng, inside = np.random.default_rng(3), []
        for _ in range(2000):
            late = 1e-3 + between * rng.normal(size=(runs + 1, 1)) + np.hypot(scatter, own) * rng.normal(
                size=(runs + 1, 7))
            mean, sd = lateness([np.column_stack([one, own]) for one in late[:-1]])
            inside.append(np.abs(late[-1] - mean) < 1.96 * np.hypot(sd, own))
        assert 0.925 < np.mean(inside) < 0.97, (between, np.mean(inside))
    assert lateness([]) == (0.0, 0.0)
    assert lateness([np.array([[2e-3, 0.0], [2e-3, 0.0]])])[1] > 2e-3  # a lone run does not say how others are


@pytest.mark.parametrize("clock", [-6e-4, 6e-4])
def test_strikes_are_told_by_the_hips_clock_however_long_it_is_wrong(clock):
    """As they are measured by it: after six seconds it is off by four milliseconds."""
    run, _, _ = made(6, 12, hip_clock=clock)
    found = forecasts(list(follow(follower(), run)), run.strikes)
    assert run.strikes[-1] > 5.0 and len(found) > 8
    assert np.abs(found[:, 0]).max() < 1e-3 and found[-3:, 1].max() < 1e-3


@pytest.mark.slow
def test_what_a_model_puts_wrong_widens_errors():
    """Those of all states, and of no heel strike less."""
    run, _, _ = made(2, 9)
    found = [list(follow(dataclasses.replace(follower(), wider=wider), run)) for wider in (1.0, 2.0)]
    for one, other in zip(*found, strict=False):
        wider = np.sqrt(np.diag(other.covariance) / np.diag(one.covariance))
        assert one.time == other.time and wider.min() > 1.0 and wider.max() > 2.0
        assert np.isnan(one.strike_sd) or other.strike_sd >= one.strike_sd


def test_how_sensors_of_a_fitted_robot_sit_is_its_own_whatever_the_settings_say():
    """So a robot that began with the bill of parts is followed as any other."""
    robot, fitted = model()
    other = robot.model(first_model(DESIGN, (*robot.names, *robot.own), as_mounted(PARAMETERS)))
    assert as_mounted(PARAMETERS).settings.lever_arm_sd < 0.01 * PARAMETERS.settings.lever_arm_sd
    for name in ("middle", "prior", "sizes", "strike"):
        assert np.array_equal(getattr(other.layout, name), getattr(fitted.layout, name))


@pytest.mark.slow
def test_over_many_runs_errors_have_the_size_that_is_said():
    found = [errors(seed, 12) for seed in range(1000, 1100)]
    inside = [one for *_, each, _ in found for one in each]
    assert 0.85 < np.mean([joint for _, joint, *_ in found]) < 1.15
    assert 0.92 < np.mean(inside) < 0.98


def test_only_samples_up_to_a_time_tell_of_it():
    """What comes later is taken away, and nothing before it changes."""
    run, _, _ = made(3, 7)
    whole = list(follow(follower(), run))
    part = list(follow(follower(), run.upto(whole[len(whole) // 2].time + 0.3)))
    assert len(part) > 40
    for one, other in zip(part, whole, strict=False):
        assert one.time == other.time and np.array_equal(one.state, other.state) and one.strike == other.strike


@pytest.mark.parametrize("late", [-0.02, 0.0015, 0.004, 0.02], ids=lambda late: f"{1e3 * late:g} ms after it")
def test_a_state_near_a_heel_strike_has_the_moments_of_walks_of_drawn_unknowns(late):
    """It is known when it comes to two thirds of a millisecond and much else better, as of a robot that is followed."""
    run, design, unknowns = made(1, 4)
    fitted = model()[1]
    names, layout = fitted.of_design, fitted.layout
    walked = walk(design, names, unknowns, layout, run.sampling, 0.6, 1e-10)
    sizes = np.concatenate([design_sizes(design, names) * 5e-4, layout.sizes * 0.01])
    sizes[len(names) + layout.free :] = 0.0
    sizes[len(names) + layout.place("mid_stance")] = 6e-4
    covariance = np.diag(sizes**2)
    time = float(walked.strikes()[0, 0]) + late
    told = Present(walked, 1e-8, clock(names)).at(time, np.zeros(len(sizes)), covariance, 0.0)
    assert 6e-4 < told.strike_sd < 8e-4 or late > 0.0
    rng, states = np.random.default_rng(4), []
    values = np.array([design.value(name) for name in names])
    for _ in range(300):
        moved = sizes * rng.normal(size=len(sizes))
        there = design.with_values(dict(zip(names, map(float, values + moved[: len(names)]), strict=True)))
        drawn = walk(there, (), unknowns + moved[len(names) :], layout, run.sampling, 0.6, 1e-10)
        found, (stretch,) = drawn.states(np.array([time]))
        if stretch.stance_leg == told.leg:
            states.append(found[0, :, 0])
    off = np.array(states) - told.state
    white = np.linalg.solve(np.linalg.cholesky(told.covariance), off.T)
    assert len(off) > 200
    np.testing.assert_allclose(white.mean(axis=1), 0.0, atol=0.25)
    assert np.all((white**2).mean(axis=1) < 1.4) and 0.7 < (white**2).mean() < 1.2


@pytest.mark.parametrize("sd", [0.3, 3.0])
def test_a_state_whose_time_is_hardly_known_is_like_those_of_the_walk(sd):
    """Powers that describe a stretch are not taken far beyond its ends, where they have no meaning."""
    run, design, unknowns = made(1, 4)
    fitted = model()[1]
    names, layout = fitted.of_design, fitted.layout
    walked = walk(design, names, unknowns, layout, run.sampling, 0.6, 1e-10)
    sizes = np.zeros(len(names) + len(layout.names))
    sizes[len(names) + layout.place("mid_stance")] = sd
    time = float(walked.strikes()[0, 0]) + 0.02
    told = Present(walked, 1e-8, clock(names)).at(time, np.zeros(len(sizes)), np.diag(sizes**2), 0.0)
    angles = [0, 2]  # theta and psi; by the clock they lie between those of steps
    assert np.abs(told.state[angles]).max() < 1.0


@pytest.mark.parametrize(("legs", "scale"), [("compliant", (1, 1, 1)), ("rigid", (1, 1, 1)), ("rigid", (8, 3, 4))])
def test_a_step_is_told_as_long_as_the_gaits_and_as_well_as_walks_of_drawn_starts_differ(legs, scale):
    """Rigid legs too, and another size and gravity."""
    design = DesignPoint(similar(dataclasses.replace(DESIGN.biped, legs=legs), scale), similar(DESIGN.slope, scale))
    walker, point = find_gait(design.biped, design.slope, 1e-9, None)
    layout, sampling = layout_of(walker, point.z, 1e-9, PARAMETERS.priors), made(1, 4)[0].sampling
    sizes = np.where(np.arange(len(layout.names)) < layout.free, 0.05 * layout.sizes, 0.0)
    sizes[layout.place("mid_stance")] = 1e-6
    rng, none = np.random.default_rng(5), np.zeros(len(layout.names))

    def told(unknowns, covariance):
        walked = walk(design, (), unknowns, layout, sampling, 0.01 * walker.time, 1e-9)
        return Present(walked, 1e-8, (layout.place("hip_clock"), 0.0, 0.0)).at(
            float(unknowns[layout.place("mid_stance")]), none, covariance, 0.0).step

    length, sd = told(layout.middle, np.diag(sizes**2))
    drawn = [told(layout.middle + sizes * rng.normal(size=len(sizes)), 1e-12 * np.diag(sizes**2))[0]
             for _ in range(100)]
    assert length == pytest.approx(walker.length * step_length(walker, point), rel=1e-6)
    assert np.mean(drawn) == pytest.approx(length, abs=0.5 * sd) and np.std(drawn) == pytest.approx(sd, rel=0.3)


def test_a_state_is_known_as_well_as_all_samples_until_then_allow():
    """Cramer and Rao's bound: of the whole run's equations about the truth, with the priors; by the hip's clock."""
    run, design, unknowns = made(4, 6)
    robot, fitted = model()
    names, layout = fitted.of_design, fitted.layout
    told = [one for one in follow(follower(), run) if 0.1 < (one.time % 0.5) < 0.12]
    prior = np.where(np.isfinite(layout.prior), layout.prior, 10 * layout.sizes)
    before = np.linalg.inv(np.diag(np.concatenate([np.diag(robot.of_design()), prior**2])))
    place = names.index(SLOPE)
    before[place, place] = 0.05**-2
    walked = walk(design, names, unknowns, layout, run.sampling, run.duration, 1e-9)
    times, clock = np.array([one.time for one in told]), layout.place("hip_clock")
    shown = walked.samples(run.sampling)
    sooner, states, later = (walked.states(times * (1.0 + unknowns[clock]) + off)[0] for off in (-1e-5, 0.0, 1e-5))
    states[:, :, 1 + len(names) + clock] += (later - sooner)[:, :, 0] / 2e-5 * times[:, None]
    for one, state in zip(told, states, strict=True):
        matrix = before.copy()
        for side in SIDES:
            used = run.used[side] & (run.sampling.of(side) <= one.time)[:, None]
            rows = (shown[side][:, :, 1:] / np.array(fitted.noise)[:, None])[used]
            matrix += rows.T @ rows
        bound = np.sqrt(np.diag(state[:, 1:] @ np.linalg.solve(matrix, state[:, 1:].T)))
        ratio = np.sqrt(np.diag(one.covariance)) / bound
        assert np.all((ratio > 0.9) & (ratio < 1.3))


def test_a_robot_is_read_as_it_was_left_and_one_that_was_changed_is_refused(tmp_path):
    robot, _ = model()
    file = tmp_path / NAME
    file.write_bytes(robot.content())
    again = FittedRobot.read(tmp_path)
    assert again.content() == robot.content() and again.design == robot.design
    changed = json.loads(robot.content())
    changed["design"]["biped"]["hip_mass"] = 0.4
    for content, sentence in ((json.dumps(changed), "was changed"), ("{", "is no fitted"), ("[]", "is no fitted")):
        file.write_text(content)
        with pytest.raises(WrongOption, match=sentence):
            FittedRobot.read(tmp_path)
    file.unlink()
    with pytest.raises(WrongOption, match=r"has no robot\.json, which calibrate --into leaves; fit the robot again"):
        FittedRobot.read(tmp_path)


@pytest.mark.parametrize(("where", "value", "sentence"), [
    (("design", "biped", "hip_mass"), -0.3, "design: hip_mass must be >= 0"),
    (("design", "biped", "hip_mass"), "heavy", "has not the rows and values of a fitted robot"),
    (("design", "slope", "gravity"), True, "has not the rows and values of a fitted robot"),
    (("names", 0), "biped.wings", "names must be numbers of the design"),
    (("covariance", 0, 0), -1.0, "standard errors must be > 0"),
    (("covariance", 1, 0), 1.0, "covariance must be that of numbers"),
    (("covariance", 0), [1.0], "has not the rows and values of a fitted robot"),
    (("mounting",), [[0.0, 1.0]], r"mounting must be numbers of the shape \(2, 2\)"),
    (("own_sd",), ["a", "b"], "has not the rows and values of a fitted robot"),
    (("wider",), 0, "standard errors must be > 0"),
    (("runs",), 0, "runs must be 1 or more"),
    (("own_sd",), None, "has not the rows and values of a fitted robot"),
    (("usual", "slope_deg"), [0.1], "has not the rows and values of a fitted robot"),
    (("learned", 0, "run", "samples", "hip"), [[0.0, 0.0, 0.0]], "learned must be numbers of the shape"),
    (("learned", 0, "unknowns"), [0.0], r"learned must be numbers of the shape \(27,\)"),
    (("more",), 1, "has not the rows and values of a fitted robot")],
    ids=lambda one: " ".join(map(str, one)) if isinstance(one, tuple) else None)  # fmt: skip
def test_a_robot_file_signed_anew_with_what_no_fit_leaves_is_refused(where, value, sentence, tmp_path):
    robot, fitted = model()
    run, _, unknowns = made(1, 4)
    own = np.zeros(len(fitted.own))
    plain = json.loads(dataclasses.replace(robot, learned=(Learned(run, own, unknowns),)).content())
    del plain["sha256"]
    inner = plain
    for key in where[:-1]:
        inner = inner[key]
    inner[where[-1]] = value
    digest = hashlib.sha256(json.dumps(plain).encode()).hexdigest()
    (tmp_path / NAME).write_text(json.dumps({**plain, "sha256": digest}))
    with pytest.raises(WrongOption, match=sentence):
        FittedRobot.read(tmp_path)


@pytest.mark.slow
def test_a_run_of_the_study_is_followed_beside_the_truth(monkeypatch):
    """Angles are off by as much as they say; without a truth there is none."""
    run, design, unknowns = made(5, 7)
    robot, fitted = model()
    values, d = np.array([design.value(name) for name in fitted.of_design]), len(fitted.shared)
    nothing = SimpleNamespace(time=np.empty(0), residual=np.empty((0, 3)))
    fit = FittedRun("drawn", "lab", values[:d], values[d:], unknowns, robot.covariance, values[:d], 1.0, 1.0, 1, True,
                    "", nothing, nothing, run.strikes)  # fmt: skip
    times = np.arange(0.6, run.duration, 0.005)
    begun = walk(design, (), unknowns, fitted.layout, run.sampling, run.duration, 1e-9)
    states, lie = begun.states(true_times(unknowns, times))
    angle = np.array([-state[0, 0] if one.stance_leg == 0 else state[2, 0] for state, one in zip(states, lie)])
    truth = SimpleNamespace(heel_strike_time=3.0 + np.concatenate([[-0.5], run.strikes]),
                            leg=SimpleNamespace(time=3.0 + times, angle=angle))  # fmt: skip
    found = followed(design, run, fit, fitted, SETTINGS, truth)
    off = (found.angle - np.interp(found.time, found.true_time, found.true_angle)) / found.angle_sd
    assert len(off) > 150 and np.abs(found.true_angle).max() > 0.2 and np.mean(off[5:-5] ** 2) < 4.0
    assert len(followed(design, run, fit, fitted, SETTINGS, None).true_time) == 0
    monkeypatch.setattr("stages.calibration.run.follow", lambda *given: (
        dataclasses.replace(one, strike=math.nan) for one in follow(*given)))  # fmt: skip
    assert followed(design, run, fit, fitted, SETTINGS, truth) is None, "lost before a strike is forecast"
