"""Synthetic runs that closer solvers made once more, read anew beside those as they were."""

from dataclasses import fields, replace

import numpy as np
import pytest

from stages.campaign.result import DATABASE, Result as Campaign
from stages.comparison.evidence import Inputs
from stages.comparison.ingest_score import score_ingest
from stages.comparison.made_again import as_both_have_it
from stages.imu import run as ingest
from stages.imu.sources.opening import SourceRefused
from tests.imu.stand_in import EVERY, Run, make_database, make_run, result_of

PERIODS = 0.48, 0.481


def campaign(runs: list[Run]) -> Campaign:
    return Campaign("synthetic", tuple(truth for _, truth, _ in runs), (), (), {})


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Four runs, of which closer solvers made the first two once more, a little slower: their databases, and runs."""
    usual, anew = ([make_run(seed, period=period) for seed in range(count)]
                   for count, period in zip((4, 2), PERIODS, strict=True))  # fmt: skip
    paths = [tmp_path_factory.mktemp("runs") / DATABASE for _ in PERIODS]
    for path, runs in zip(paths, (usual, anew), strict=True):
        path.write_bytes(make_database(runs))
    return paths, usual, anew


@pytest.fixture(scope="module")
def made(recorded) -> tuple[Inputs, Inputs]:
    """What is compared, and what closer solvers gave in its place."""
    (path, other), usual, anew = recorded
    one, two = ingest.again(EVERY["imu"], ingest.Inputs(other, other), result_of(path))
    assert [run.report.name for run in one.runs] == [run.report.name for run in two.runs], "those that both have"
    others = dict.fromkeys(field.name for field in fields(Inputs) if field.name not in ("missing", "closer"))
    inputs = Inputs(**others | {"imu": result_of(path), "campaign": campaign(usual)})
    return inputs, replace(inputs, imu=two, campaign=campaign([*anew, *usual[2:]]))


def test_both_have_the_runs_that_were_made_once_more_each_with_its_own_truth(made):
    inputs, closer = made
    both = as_both_have_it(replace(inputs, closer=closer))
    frequencies = []
    for each in both:
        assert [run.report.name for run in each.imu.runs] == [run.name for run in inputs.campaign.runs[:2]]
        score = score_ingest(each.campaign, each.imu, 3, 9.81)
        assert np.abs(score.frequency_error).max() < 5e-4
        frequencies.append(each.imu.step_frequency)
    assert frequencies[1] / frequencies[0] == pytest.approx(PERIODS[0] / PERIODS[1], rel=1e-4)
    assert frequencies[0] != inputs.imu.step_frequency, "of two runs, not of four"


def test_where_no_run_was_made_once_more_recordings_are_as_they_were(made):
    inputs, closer = made
    assert as_both_have_it(inputs) is None
    both = as_both_have_it(replace(inputs, closer=replace(closer, imu=inputs.imu)))
    assert all(each.imu is inputs.imu and each.campaign is inputs.campaign for each in both)
    gone = replace(inputs, missing={"imu": "there is no imu"}, closer=closer)
    assert as_both_have_it(gone) == (gone, closer)


def test_recordings_of_a_lab_or_of_other_runs_are_not_read_once_more(recorded, tmp_path):
    (path, other), usual, _ = recorded
    read = ingest.Inputs(other, other, database=path)
    assert ingest.again(EVERY["imu"], read, result_of(path)) == ingest.ONCE
    apart = tmp_path / DATABASE
    apart.write_bytes(make_database(usual[2:]))
    assert "no run made once more" in ingest.again(EVERY["imu"], ingest.Inputs(other, other), result_of(apart))
    apart.write_bytes(make_database([]))
    with pytest.raises(SourceRefused):
        ingest.again(EVERY["imu"], ingest.Inputs(apart, apart), result_of(path))
