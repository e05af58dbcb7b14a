"""Robots of the model's kind that are pushed at a mid-stance: followed through it, and whether their fall is told."""

import contextlib
import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.errors import StepFailed
from stages.biped.question import WrongOption
from stages.calibration.estimation.least_squares import NotIdentified
from stages.calibration.estimation.request import Request
from stages.calibration.following import report
from stages.calibration.following.follower import Follower
from stages.calibration.following.robot_file import FittedRobot
from stages.calibration.following.step import Estimate, Step
from stages.calibration.following.stream import STAMP, Stream, rows_of
from stages.calibration.following.track import Track, follow
from stages.calibration.information.identifiability import SLOPE
from stages.calibration.observation.measured_run import SIDES, MeasuredRun
from stages.calibration.observation.prediction import predict, taken, walk
from stages.calibration.questions import follow as question
from stages.calibration.reports.sensor_report import _split
from stages.imu.sources.units import STANDARD_GRAVITY
from tests.calibration.runs import DESIGN, PARAMETERS, disturbed
from tests.calibration.test_following import follower, made, model, true_times

#: A blow that makes the leg turn faster by this share lets half of the robots fall, three heel strikes later.
HALF = 0.69
#: Steps before a push, and after one that are looked at.
BEFORE, AFTER = 4, 8
PERIOD = 0.51


def steps_of(design, start, layout, sampling, leg, count):
    """Starts of steps (unknowns and leg) from one on, their heel strikes, and whether the walk fell."""
    starts, strikes = [(start, leg)], []
    while len(strikes) < count:
        unknowns, leg = starts[-1]
        there = dataclasses.replace(sampling, first_leg=leg)
        try:
            walked = walk(design, (), unknowns, layout, there, 1.25 * PERIOD, 1e-9)
            following = walked.next_start()[:, 0]
        except StepFailed:
            last = walk(design, (), unknowns, layout, there, 0.05, 1e-9).strikes()
            return starts, [*strikes, *last[:1, 0]], True
        strikes.append(float(walked.strikes()[0, 0]))
        later = unknowns.copy()
        later[: layout.free], later[layout.place("mid_stance")] = following[:-1], following[-1]
        starts.append((later, 1 - leg))
    return starts, strikes, False


def pushed(seed, share=None):
    """A run up to the last heel strike, the time of the push, and whether the robot fell after it. The leg turns faster
    by a `share`, drawn where none is given; unknowns and the leg then are last."""
    robot, fitted = model()
    rng, layout = np.random.default_rng(seed), fitted.layout
    drawn = rng.multivariate_normal([DESIGN.value(name) for name in fitted.of_design], robot.of_design())
    design = DESIGN.with_values(dict(zip(fitted.of_design, drawn, strict=True)))
    spread = np.where(np.isfinite(layout.prior), layout.prior, layout.sizes) * rng.normal(size=len(layout.names))
    spread[layout.place("mid_stance")] = 0.0
    unknowns, (_, _, sampling) = layout.middle + spread, disturbed(seed, 4)
    starts, strikes, _ = steps_of(design, unknowns, layout, sampling, 1, BEFORE)
    start, leg = starts[-1]
    start[layout.place("start_theta_rate")] *= 1.0 + (HALF * rng.uniform(0.5, 2.0) if share is None else share)
    _, later, fell = steps_of(design, start, layout, sampling, leg, AFTER)
    times = {"hip": np.arange(float(sampling.hip[0]), later[-1] - 0.005, 0.01)}
    times["foot"] = times["hip"] + 0.003
    samples, first = {side: [] for side in SIDES}, {side: [] for side in SIDES}
    since = {side: taken(dict(zip(layout.names, start)), sampling, side, times[side]) for side in SIDES}
    for is_after, (begin, on) in enumerate(((unknowns, 1), (start, leg))):
        part = {side: times[side][(since[side] >= 0.0) == is_after] for side in SIDES}
        found = predict(design, (), begin, layout, dataclasses.replace(sampling, first_leg=on, **part), 1e-9).samples
        for side in SIDES:
            samples[side].append(found[side][:, :, 0])
            first[side].append(part[side])
    shown = {side: np.vstack(parts) for side, parts in samples.items()}
    shown = {side: one + rng.normal(size=one.shape) * fitted.noise for side, one in shown.items()}
    slope = design.value(SLOPE) + 0.05 * rng.normal()
    run = MeasuredRun("pushed", dataclasses.replace(sampling, **times), shown,
                      {side: np.ones(one.shape, dtype=bool) for side, one in shown.items()},
                      np.array([0.0, *strikes, *later]), {SLOPE: (slope, 0.05)})  # fmt: skip
    return run, float(start[layout.place("mid_stance")]), fell, (design, start, leg)


def told(run, since):
    """The largest probability to fall within three steps that is told before and after a time."""
    found = {False: 0.0, True: 0.0}
    try:
        for one in follow(follower(), run):
            if one.falls:
                found[one.time > since] = max(found[one.time > since], one.falls[-1])
    except StepFailed:
        pass  # a robot that falls is followed no further
    return found[False], found[True]


@pytest.mark.slow
def test_a_fall_is_told_a_step_ahead_and_none_where_there_is_none():
    """Two robots that fall and two that do not, and none of them before it is pushed."""
    found = []
    for seed in (3, 4, 5, 7):
        run, time, fell, _ = pushed(seed)
        before, after = told(run, time)
        found.append(fell)
        assert before < 0.05 and (after > 0.5) == fell
    assert len(set(found)) == 2


@pytest.mark.parametrize("share", [-1.3, -0.9, 1.0], ids=["turned round", "nearly stopped", "from behind"])
def test_a_robot_is_found_again_after_a_push(share):
    """Within a tenth of a second, as well as it says, before the heel strike that comes next."""
    run, time, _, (design, start, leg) = pushed(6, share)
    sampling = dataclasses.replace(run.sampling, first_leg=leg)
    walked = walk(design, (), start, model()[1].layout, sampling, 0.05, 1e-9)
    strike, seen = float(walked.strikes()[0, 0]), []
    with contextlib.suppress(StepFailed):
        seen.extend(one for one in follow(follower(), run.upto(strike - 0.02)) if one.time > time + 0.1)
    states, _ = walked.states(true_times(start, [one.time for one in seen]))
    assert seen and all(one.leg == leg for one in seen)
    for one, state in zip(seen, states[:, :, 0], strict=True):
        off = one.state - state
        assert off @ np.linalg.solve(one.covariance, off) / len(off) < 5.0 and np.sqrt(one.covariance[4, 4]) < 0.1


def test_a_step_whose_end_would_be_before_its_start_goes_on_as_long_as_usual(monkeypatch):
    """Right after a push so little is known that the next mid-stance may be told anywhere, as with rigid legs."""
    track = Track(follower(), made(3, 5)[0])
    begins = track._follower.mid_stance(track._step.at)
    before = track._follower.onwards(track._step)
    before.mean[track._follower.start[-1]] = begins - 0.2
    monkeypatch.setattr(Follower, "onwards", lambda *_: before)
    track._end()
    assert track._until == begins + track._period + track._follower.settings.settling_s


def test_a_robot_that_walks_on_where_the_likeliest_would_fall_is_followed():
    """A push leaves it at the brink of a fall; the samples that come show that it did not."""
    track = Track(follower(), made(3, 5)[0])
    step, robot, period = track._step, track._follower, track._period
    rate = robot.anywhere.names.index("start_psi_rate")
    mean, covariance = step.known.mean.copy(), step.known.covariance.copy()
    covariance[rate, rate] += (3.0 * mean[rate]) ** 2
    mean[rate] *= 6.0
    brink = Estimate(mean, covariance, step.sampling)
    with pytest.raises(StepFailed):
        robot.walked(mean, step.sampling, period)
    reached = robot.mid_stance(mean) + 0.2 * period
    for found in (robot.nearer(Step(robot.anywhere, robot.wrong, brink, mean, step.walked), period, reached),
                  track._begun(brink, mean)):
        assert found.at[rate] < mean[rate] and found.ends > reached
        off = found.at - mean
        assert off @ np.linalg.pinv(covariance) @ off < 3.0 * len(off)


@pytest.mark.slow
def test_of_many_pushed_robots_falls_are_told_and_few_others():
    found = [(fell, *told(run, time)) for run, time, fell, _ in map(pushed, range(1000, 1200))]
    falls, others = [one for one in found if one[0]], [one for one in found if not one[0]]
    assert min(len(falls), len(others)) > 40
    assert np.mean([after > 0.5 for _, _, after in falls]) >= 0.95
    assert np.mean([max(before, after) > 0.5 for _, before, after in others]) <= 0.05


# --- Rows that are followed as they come: faults are said once, and they tell of the walk they came from.


COLUMNS = ("gz", "place", "ax", "ay", "az", "gx", "gy", STAMP)
AXES = {"forward_axis": "+x", "up_axis": "+y"}
ABOUT = {"experiment": {"slope_deg": 2.0}, "devices": [{"place": side, **AXES} for side in SIDES]}
PERIODS = {"hip": 0.01, "foot": 0.01}
#: What a clock shows when the first heel strike of a run is, and how long the robot stands before it is seen to walk.
AT, STAND = 100.0, 150


def lines_of(run, seed):
    """A run's samples as rows of both sensors, after a stand, with their columns in an order of their own."""
    rng, noise = np.random.default_rng(seed), np.array(model()[1].noise)
    rows = []
    for side in SIDES:
        times = run.sampling.of(side) + run.sampling.late[side] + AT
        stand = times[0] - 0.01 * np.arange(STAND, 0, -1)
        still = np.array([-np.sin(np.radians(2.0)), np.cos(np.radians(2.0)), 0.0]) * PARAMETERS.slope.gravity
        values = np.vstack([still + rng.normal(size=(STAND, 3)) * noise, run.samples[side]])
        beside = rng.normal(size=(len(values), 3)) * noise[[1, 2, 2]]
        rows += [(time, f"{value[2]},{side},{value[0]},{value[1]},{','.join(map(str, other))},{time}")
                 for time, value, other in zip([*stand, *times], values, beside, strict=True)]  # fmt: skip
    return [",".join(COLUMNS), *(text for _, text in sorted(rows))]


def followed(lines, about, said=None):
    stream = Stream(follower(), about, PARAMETERS)
    note = (said if said is not None else []).append
    return stream, list(stream.follow(rows_of(lines, note, stream.periods)))


def off(found, run, design, unknowns):
    """Errors of states in their standard deviations, (n, size), where the leg is right."""
    layout = model()[1].layout
    clock = 1.0 + unknowns[layout.place("hip_clock")]
    times = np.array([one.time for one in found]) - AT
    times = clock * (times - run.sampling.late["hip"]) + run.sampling.late["hip"]
    truth, lie = walk(design, (), unknowns, layout, run.sampling, times[-1] + 0.1, 1e-9).states(times)
    return np.array([(one.state - state[:, 0]) / np.sqrt(np.diag(one.covariance))
                     for one, state, stretch in zip(found, truth, lie, strict=True) if stretch.stance_leg == one.leg])


@pytest.mark.slow
def test_rows_tell_of_the_walk_that_they_came_from_and_are_taken_up_again():
    """Twice: from a stand on, and from the middle of the walk on with the first answer alone, which has the units."""
    run, design, unknowns = made(5, 18)
    lines = lines_of(run, 6)
    g = [",".join([f"{float(cell) / STANDARD_GRAVITY:.9g}" if name in ("ax", "ay", "az") else cell
                   for name, cell in zip(COLUMNS, line.split(","), strict=True)]) for line in lines[1:]]
    lines = [lines[0], *g]
    about = {**ABOUT, "devices": [{**one, "accelerometer_unit": "g"} for one in ABOUT["devices"]]}
    stream, found = followed(lines, about)
    assert len(found) > 500 and np.sqrt((off(found, run, design, unknowns) ** 2).mean(axis=0)).max() < 2.0
    _, again = followed([lines[0], *lines[-1000:]], json.loads(json.dumps(stream.about())))
    assert 150 < len(again) < 500 and np.sqrt((off(again, run, design, unknowns) ** 2).mean(axis=0)).max() < 2.0
    with pytest.raises(NotIdentified, match="rows end before a walk is found: no still stand"):
        followed([lines[0], *lines[-1000:]], about)


def test_rows_lost_late_doubled_or_of_words_change_little_and_are_said_once():
    run, design, unknowns = made(5, 14)
    lines, rng, worse = lines_of(run, 6), np.random.default_rng(1), []
    for number, line in enumerate(lines):
        chance = rng.uniform() if number > 1000 else 1.0
        worse += {0: [], 1: [line, line], 2: ["x" + line], 3: [line, lines[number - 4]], 4: [line[:20]],
                  5: [line.replace(",", ",,", 1), line]}.get(int(50 * chance), [line])  # fmt: skip
    said: list[str] = []
    _, found = followed(worse, ABOUT, said)
    assert len(found) > 250 and np.sqrt((off(found, run, design, unknowns) ** 2).mean(axis=0)).max() < 2.0
    kinds = ("not a row", "given twice", "later than the one after it", "of the hip before it are lost",
             "of the foot before it are lost")  # fmt: skip
    assert [sum(kind in one for one in said) for kind in kinds] == [1] * 5 and len(said) == 5


@pytest.mark.parametrize(("hip_late", "foot_clock"), [(0.2, 0.0), (0.2, -1000.0)], ids=["late", "another clock"])
def test_rows_of_sensors_that_come_apart_tell_of_the_walk_all_the_same(hip_late, foot_clock):
    """A hip's that came .2 s after the foot's were given the next step's states, 275 standard errors off; and a foot's
    clock that showed less than the hip's by two minutes ended the search for a walk at its first row."""
    run, design, unknowns = made(5, 14)
    head, *lines = lines_of(run, 6)
    arrived = []
    for *cells, stamp in (line.split(",") for line in lines):
        late, shows = (hip_late, 0.0) if cells[1] == "hip" else (0.0, foot_clock)
        arrived.append((float(stamp) + late, ",".join([*cells, str(float(stamp) + shows)])))
    _, found = followed([head, *(line for _, line in sorted(arrived))], ABOUT)
    assert len(found) > 250 and np.sqrt((off(found, run, design, unknowns) ** 2).mean(axis=0)).max() < 2.0


@pytest.mark.parametrize(("silent", "since", "why"), [
    ("hip", AT + 4.0, "no samples of the hip for 2.0"), ("hip", 0.0, "there are no rows of the hip"),
    ("foot", AT + 4.0, "")])  # fmt: skip
def test_a_sensor_that_falls_silent_is_said_to_be_and_a_stream_without_a_hip_ends(silent, since, why):
    """It ended with 0 and no word."""
    lines = [line for line in lines_of(made(5, 14)[0], 6)
             if line.split(",")[1] != silent or float(line.split(",")[-1]) < since]
    said: list[str] = []
    with pytest.raises((StepFailed, NotIdentified), match=why) if why else contextlib.nullcontext():
        followed(lines, ABOUT, said)
    assert [("rows are all of the" in one and silent not in one) for one in said] == [True]


def test_rows_need_their_columns_and_a_clock_that_goes_on():
    with pytest.raises(WrongOption, match="lacks place, device_stamp, ay"):
        list(rows_of(["ax,az,gx,gy,gz"], print, PERIODS))
    rows = [",".join(COLUMNS), *(f"0,hip,0,9,0,0,0,{time / 100}" for time in [*range(30), *range(25)])]
    beside = [line for number, row in enumerate(rows[1:]) for line in (row, f"0,foot,0,9,0,0,0,{number / 100}")]
    for each in (rows, [rows[0], *beside]):  # of one sensor alone, too, which then said nothing any more
        with pytest.raises(StepFailed, match=r"the clock of the hip was set back by 0\.29 s"):  # a third of it
            list(rows_of(each, lambda text: None, PERIODS))
    (row,) = rows_of([rows[0], "0,HIP,0,9,,0,0,1"], print, PERIODS)
    assert row.side == "hip" and np.isnan(row.reading[2])
    said: list[str] = []
    quoted = "\ufeff" + rows[0].replace("ax", '"ax"')  # refused
    list(rows_of([quoted, *('0,"hip",0,9,0,0,0,' + stamp for stamp in ("0", ".03", ".05", "9"))], said.append, PERIODS))
    assert [note.split(": ")[2].partition(" of")[0] for note in said] == ["1 or more rows", "100 or more rows"]
    with pytest.raises(StepFailed, match="the last 100 lines are no rows of hip or foot with numbers"):  # 0, to the end
        list(rows_of([*rows[:9], *(["rotated", "a\rb", "\0", 200_000 * "a"] * 40)], lambda text: None, PERIODS))
    for wrong, why in (
        ({"devices": [{"place": "hip", "forward_axis": "w"}]}, "devices.0: forward_axis is"),
        ({"devices": [{"place": "hip", "rate": 50}]}, "devices.0.rate: unknown key 'rate'; known are .*rate_hz"),
        ({"devices": [{"place": "ankle"}]}, "devices.0.place is ankle, must be hip or foot"),
        ({"devices": 5}, "devices: must be a list"), ({"device": []}, "device: unknown key"),
        ({"experiment": {"slope_deg": "two"}}, "experiment.slope_deg is 'two', must be a number between"),
        ({"mounting": {"hip": {}}}, "mounting: needs both hip and foot"),
        ({"mounting": {"hip": {"rotation": [1]}, "foot": {}}}, "mounting.hip: needs rotation of 3 rows"),
    ):
        with pytest.raises(WrongOption, match=f"^--with: {why}"):
            Stream(follower(), wrong, PARAMETERS)


@pytest.mark.parametrize("place", [0, 20, 42])
def test_one_stamp_far_ahead_is_passed_over_and_a_clock_that_was_set_is_gone_on_with(place):
    """All later rows were before that stamp, which ended the stream; also where the columns have a quoted comma."""
    times = [number / 100 for number in range(60)]
    lines = [f'0,{side},0,9,0,0,0,{stamp},"a, b"' for stamp in times for side in ("hip", "foot")]
    wrong = [*lines]
    wrong[2 * place] = wrong[2 * place].replace(f",{times[place]},", ",99999.5,")
    said: list[str] = []
    found = list(rows_of([",".join((*COLUMNS, "remark")), *wrong], said.append, PERIODS))
    kept = {side: [row.time for row in found if row.side == side] for side in PERIODS}
    assert kept == {"hip": times[:place] + times[place + 1 :], "foot": times}
    assert any(f"line {2 * place + 4}: the row of the hip before it is stamped" in note for note in said)
    later = [*lines[: 2 * place], *(line.replace(",0.", ",70.") for line in lines[2 * place :])]
    assert len(list(rows_of([",".join((*COLUMNS, "remark")), *later], said.append, PERIODS))) == 120


def test_what_is_said_of_an_option_names_it_as_it_is_typed(tmp_path):
    """as: nothing has no robot.json, it said; and a run that is not there was said without the key that names it."""
    with pytest.raises(WrongOption, match=r"^--as: .* has no robot\.json"):
        FittedRobot.read(tmp_path)
    for key in ("held_out", "fitted"):
        with pytest.raises(WrongOption, match=f"^--with: {key}: no run 'walk 9' can be used; there are walk 1$"):
            _split([SimpleNamespace(name="walk 1")], Request(**{key: ("walk 9",)}), 3)


def test_a_dash_is_standard_input(monkeypatch):
    for name in ("streamed", "followed"):
        monkeypatch.setattr(report, name, lambda *given, name=name: name)
    for source, how in (("-", "streamed"), ("lab.sqlite", "followed")):
        options = SimpleNamespace(source=source, robot=".", runs=(), about=None)
        assert question.ask(PARAMETERS, options, None) == how
