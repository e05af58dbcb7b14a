"""Rows that are followed as they come: faults are said once, and they tell of the walk they came from."""

import json

import numpy as np
import pytest

from stages.analytic.errors import StepFailed
from stages.biped.question import WrongOption
from stages.calibration.estimation.least_squares import NotIdentified
from stages.calibration.following.stream import STAMP, Stream, rows_of
from stages.calibration.observation.measured_run import SIDES
from stages.calibration.observation.prediction import walk
from tests.calibration.runs import PARAMETERS
from tests.calibration.test_following import follower, made, model

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
        times = run.sampling.of(side) + run.sampling.late + AT
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
    times = clock * (times - run.sampling.late) + run.sampling.late
    truth, lie = walk(design, (), unknowns, layout, run.sampling, times[-1] + 0.1, 1e-9).states(times)
    return np.array([(one.state - state[:, 0]) / np.sqrt(np.diag(one.covariance))
                     for one, state, stretch in zip(found, truth, lie, strict=True) if stretch.stance_leg == one.leg])


def test_rows_tell_of_the_walk_that_they_came_from_and_are_taken_up_again():
    """Twice: from a stand on, and from the middle of the walk on with the mounting that was found first."""
    run, design, unknowns = made(5, 18)
    lines = lines_of(run, 6)
    stream, found = followed(lines, ABOUT)
    assert len(found) > 500 and np.sqrt((off(found, run, design, unknowns) ** 2).mean(axis=0)).max() < 2.0
    mounting = json.loads(json.dumps({side: one.plain() for side, one in stream.mounted.items()}))
    _, again = followed([lines[0], *lines[-1000:]], {**ABOUT, "mounting": mounting})
    assert 150 < len(again) < 500 and np.sqrt((off(again, run, design, unknowns) ** 2).mean(axis=0)).max() < 2.0
    with pytest.raises(NotIdentified, match="rows end before a walk is found: no still stand"):
        followed([lines[0], *lines[-1000:]], ABOUT)


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


def test_rows_need_their_columns_and_a_clock_that_goes_on():
    with pytest.raises(WrongOption, match="lacks place, device_stamp, ay"):
        list(rows_of(["ax,az,gx,gy,gz"], print, PERIODS))
    rows = [",".join(COLUMNS), *(f"0,hip,0,9,0,0,0,{time}" for time in [*range(30), *range(25)])]
    with pytest.raises(StepFailed, match="the clock of the hip was set back by 1"):
        list(rows_of(rows, lambda text: None, PERIODS))
    (row,) = rows_of([rows[0], "0,HIP,0,9,,0,0,1"], print, PERIODS)
    assert row.place == "hip" and np.isnan(row.readings[2])
    for wrong in ({"devices": [{"place": "hip", "forward_axis": "w"}]}, {"mounting": {"hip": {"rotation": [1]}}}):
        with pytest.raises(WrongOption, match="with: "):
            Stream(follower(), wrong, PARAMETERS)
