"""Synthetic runs that closer solvers made once more, read anew beside those as they were."""

from dataclasses import fields, replace

import numpy as np
import pytest

from stages.campaign.result import DATABASE
from stages.campaign.result import Result as Campaign
from stages.comparison.evidence import Inputs
from stages.comparison.ingest_score import score_ingest
from stages.comparison.made_again import as_both_have_it
from tests.comparison.test_measure import PARAMETERS
from tests.imu.stand_in import Run, make_database, make_run, result_of

PERIODS = 0.48, 0.481


def campaign(runs: list[Run], database: bytes = b"") -> Campaign:
    return Campaign("synthetic", tuple(truth for _, truth, _ in runs), (), (), {DATABASE: database} if database else {})


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> tuple[Inputs, Inputs]:
    """Four runs, of which closer solvers made the first two once more, a little slower; as they were, and closer."""
    usual, anew = ([make_run(seed, period=period) for seed in range(count)]
                   for count, period in zip((4, 2), PERIODS, strict=True))  # fmt: skip
    path = tmp_path_factory.mktemp("runs") / DATABASE
    path.write_bytes(make_database(usual))
    others = dict.fromkeys(field.name for field in fields(Inputs) if field.name not in ("missing", "closer"))
    inputs = Inputs(**others | {"imu": result_of(path), "campaign": campaign(usual)})
    return inputs, replace(inputs, campaign=campaign([*anew, *usual[2:]], make_database(anew)))


def test_both_have_the_runs_that_were_made_once_more_each_with_its_own_truth(made):
    inputs, closer = made
    both = as_both_have_it(PARAMETERS, replace(inputs, closer=closer))
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
    assert as_both_have_it(PARAMETERS, inputs) is None
    for files in ({}, {DATABASE: make_database([])}):
        without = replace(closer, campaign=replace(closer.campaign, files=files))
        both = as_both_have_it(PARAMETERS, replace(inputs, closer=without))
        assert all(each.imu is inputs.imu and each.campaign is inputs.campaign for each in both)
    lab = replace(inputs, imu=replace(inputs.imu, origin="measured"), closer=closer)
    assert as_both_have_it(PARAMETERS, lab)[1].imu.origin == "measured"
    gone = replace(inputs, missing={"imu": "there is no imu"}, closer=closer)
    assert as_both_have_it(PARAMETERS, gone) == (gone, closer)
