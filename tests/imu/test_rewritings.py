"""One log written down in many ways gives one verdict and the same curves, within rounding of what is written."""

from __future__ import annotations

from pathlib import Path

import pytest

from stages.imu.trial.trial import Trial, read_trial
from tests.imu.made_logs import Log
from tests.imu.rewritings import REWRITINGS, differs, rewritten
from tests.imu.stand_in import PARAMETERS

QUICK = ("mg, mdps", "1000 s later", "clocks an hour apart", "decimal comma, exponents, quoted")


@pytest.fixture(scope="module")
def as_made(log: Log) -> Trial:
    return read_trial(log.experiment, log.recordings, PARAMETERS)


@pytest.mark.parametrize(
    "name", [one if one in QUICK else pytest.param(one, marks=pytest.mark.slow) for one in REWRITINGS])
def test_nothing_depends_on_how_a_log_is_written_down(name: str, log: Log, as_made: Trial, tmp_path: Path) -> None:
    """Stamps since 1970 are rounded to 2.4e-7 s, in which a strike's force changes by some 1e-4 of its size."""
    trial = rewritten(log, REWRITINGS[name], tmp_path, PARAMETERS)
    assert trial.verdict.findings == as_made.verdict.findings == ()
    assert differs(as_made, trial) < 3e-4


@pytest.mark.parametrize(("first", "last"), [pytest.param(0.5, 0.0, marks=pytest.mark.slow), (0.0, 0.15)])
def test_a_log_that_begins_late_or_ends_early_is_as_good(first: float, last: float, log: Log) -> None:
    """The still stand is longer than what is cut, and no step is needed."""
    at = [one.phone_stamp - log.recordings[0].phone_stamp.min() for one in log.recordings]
    end = min(one.max() for one in at)
    cut = tuple(one.take((t >= first) & (t <= end - last)) for one, t in zip(log.recordings, at))
    assert read_trial(log.experiment, cut, PARAMETERS).verdict.findings == ()
