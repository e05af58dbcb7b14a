"""The whole ingest, blind, against the truth of stand-in runs: what issue E asks for."""

from pathlib import Path

import numpy as np
import pytest

from stages.imu.parameters import Parameters
from stages.imu.result import Result
from stages.imu.run import run
from tests.imu.scoring import Score, score
from tests.imu.stand_in import RADIO, ROUGH_RADIO, SETTINGS, Truth, make_database, make_run

RUNS = 10


@pytest.fixture(scope="module", params=["usual radio", "5 % lost, 10 % stalls"])
def ingested(request, tmp_path_factory) -> tuple[Result, dict[str, Truth]]:
    radio = RADIO if request.param == "usual radio" else ROUGH_RADIO
    runs = [make_run(seed, radio) for seed in range(RUNS)]
    path: Path = tmp_path_factory.mktemp("log") / "measurements.sqlite"
    path.write_bytes(make_database(runs))
    return run(Parameters(SETTINGS), {"measurements": path}), {one.name: truth for one, truth in runs}


@pytest.fixture(scope="module")
def scores(ingested) -> list[Score]:
    result, truth = ingested
    return [score(one, truth[one.report.name]) for one in result.runs]


def test_every_run_is_used(ingested) -> None:
    result, _ = ingested
    assert len(result.runs) == RUNS
    assert result.rejected == ()
    assert all(report.accepted for report in result.reports)


def test_clock_after_the_constant_delay(scores: list[Score]) -> None:
    assert np.sqrt(np.mean([one.clock_rms**2 for one in scores])) <= 1e-3


def test_frames(scores: list[Score]) -> None:
    assert max(one.frame_deg for one in scores) <= 0.5


def test_heel_strikes(scores: list[Score]) -> None:
    assert np.mean([one.recall for one in scores]) >= 0.99
    assert np.mean([one.precision for one in scores]) >= 0.99
    assert all(one.legs_right for one in scores)


def test_step_frequency(scores: list[Score]) -> None:
    assert max(abs(one.frequency_error) for one in scores) <= 1e-3


def test_origin_is_passed_on(ingested) -> None:
    result, _ = ingested
    assert result.origin == "synthetic"
    assert "synthetic" in result.summary()
    assert all("synthetic" in title for title, _, _ in result.tables())


def test_sensors_sit_where_they_sit(ingested) -> None:
    """The foot sensor is 0.233 m below the hip sensor."""
    result, _ = ingested
    assert np.median([one.report.lever_arm for one in result.runs]) == pytest.approx(0.233, abs=0.01)


def test_registered_strides_are_the_motion(ingested) -> None:
    """At phase 0 and 1 the inner leg lands; in between it stands for about half the stride, turning backward."""
    result, _ = ingested
    rate = result.ensemble.mean[:, result.signals.index("hip_lateral_rate")]
    assert (rate[10:40] < 0).all()
    assert (rate[60:90] > 0).all()
    up = result.ensemble.mean[:, result.signals.index("hip_up_force")]
    assert np.nanmean(up) == pytest.approx(9.81, abs=0.5)
    lower, upper = result.ensemble.lower, result.ensemble.upper
    inside = np.isfinite(result.ensemble.mean)
    assert (lower[inside] <= result.ensemble.mean[inside] + 1e-12).all()
    assert (result.ensemble.mean[inside] <= upper[inside] + 1e-12).all()


def test_same_database_same_bits(ingested, tmp_path: Path) -> None:
    path = tmp_path / "again.sqlite"
    path.write_bytes(make_database([make_run(3)]))
    first, second = (run(Parameters(SETTINGS), {"measurements": path}) for _ in range(2))
    assert first.ensemble.mean.tobytes() == second.ensemble.mean.tobytes()
    assert first.step_frequency == second.step_frequency


def test_tables_have_as_many_cells_as_columns(ingested) -> None:
    result, _ = ingested
    for _, columns, rows in result.tables():
        assert rows
        assert {len(row) for row in rows} == {len(columns)}
