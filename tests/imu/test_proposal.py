"""A map proposed from a file's head reads the file and names its maker: layouts and exports of one synthetic run."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
import yaml

from stages.imu.judgement.verdict import REFUSED
from stages.imu.sources.column_map import CsvSource
from stages.imu.sources.head import MAKERS as KNOWN
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.proposal import proposal
from stages.imu.sources.units import scale_of
from stages.imu.trial.trial import read_trial
from tests.imu.exports import LAYOUTS, MAKERS, SINGLE, Export, G, Table, delsys, names
from tests.imu.made_logs import Log
from tests.imu.stand_in import PARAMETERS


@pytest.fixture(scope="module")
def table(log: Log) -> Table:
    """What the hip's sensor read, losses included."""
    hip = log.recordings[0]
    scale = scale_of(hip.device)
    number = np.round((hip.device_stamp - hip.device_stamp[0]) * 100).astype(int)
    return number, 0.01 * number, hip.acceleration * scale.acceleration, hip.angular_rate * scale.angular_rate


def read_as_proposed(path: Path, log: Log, table: Table) -> list[str]:
    """What is told of a file whose map, with place, mounting and slope filled in, reads the run, which is then used."""
    said, told = proposal(path)
    description = yaml.safe_load(said)
    (run,) = description["runs"]
    run["experiment"]["slope_deg"] = log.experiment.slope_deg
    run["files"][0]["device"] |= {"place": "hip", "forward_axis": "+y", "up_axis": "-x", "bandwidth_hz": 40}
    ((experiment, recordings),) = CsvSource(description, path.parent).runs()
    scale = scale_of(recordings[0].device)
    whole = np.isfinite(recordings[0].angular_rate).all(axis=1)
    assert whole.mean() > 0.95
    np.testing.assert_allclose(recordings[0].acceleration * scale.acceleration, table[2], atol=1e-3)
    np.testing.assert_allclose((recordings[0].angular_rate * scale.angular_rate)[whole], table[3][whole], atol=1e-4)
    trial = read_trial(experiment, recordings, PARAMETERS)
    assert trial.verdict.outcome != REFUSED, trial.verdict.findings
    assert trial.frequency[0] == pytest.approx(1 / np.median(np.diff(log.strike_time)), rel=0.02)
    return told


@pytest.mark.parametrize("name", [*LAYOUTS, *MAKERS, "Delsys"])
def test_a_proposed_map_reads_the_file_and_names_its_maker(name: str, table: Table, log: Log, tmp_path: Path) -> None:
    """Only place, mounting and slope are filled in, which no file holds; of a maker's file nothing is guessed."""
    files = {file: one.of(table) for file, one in {**LAYOUTS, **MAKERS}.get(name, {}).items()}
    files = files or {"walk.csv": delsys(table)}
    for file, content in files.items():
        (tmp_path / file).write_bytes(content)
    told = read_as_proposed(tmp_path / next(iter(files)), log, table)
    assert name in LAYOUTS or any(f"names as {name}" in line for line in told), told
    assert not [line for line in told if "guess" in line and (name not in LAYOUTS or "rate" not in line)], told


def test_a_folder_is_proposed_as_runs_with_the_sensors_of_each(table: Table, log: Log, tmp_path: Path) -> None:
    content = next(iter(next(iter(LAYOUTS.values())).values())).of(table)
    for name in ("walk 1_hip.csv", "walk 1_foot.csv", "walk 2_ankle.csv", "walk 2_pelvis.csv"):
        (tmp_path / name).write_bytes(content)
    (tmp_path / "notes.txt").write_text("measured on a Monday")
    (tmp_path / "steps.csv").write_text("a,b,c,d\n1,2,3,4\n2,3,4,5\n")
    said, told = proposal(tmp_path)
    description = yaml.safe_load(said)
    assert [run["experiment"]["name"] for run in description["runs"]] == ["walk 1", "walk 2"]
    places = [[file["device"]["place"] for file in run["files"]] for run in description["runs"]]
    assert places == [["foot", "hip"], ["foot", "hip"]]
    assert {line.split()[2] for line in told if line.startswith("left out: ")} == {"'notes.txt'", "'steps.csv'"}
    for run in description["runs"]:
        run["experiment"]["slope_deg"] = log.experiment.slope_deg
        for file in run["files"]:
            file["device"] |= {"forward_axis": "+y", "up_axis": "-x", "bandwidth_hz": 40}
    read = [recordings for _, recordings in CsvSource(description, tmp_path).runs()]
    assert [len(recordings) for recordings in read] == [2, 2]


def test_a_folder_without_a_sensor_is_refused(tmp_path: Path) -> None:
    (tmp_path / "steps.csv").write_text("a,b,c,d\n1,2,3,4\n2,3,4,5\n")
    with pytest.raises(SourceRefused, match="has no file with an inertial sensor"):
        proposal(tmp_path)


def test_every_maker_has_an_export_here() -> None:
    assert all(any(maker.name.startswith(known) for known in (*MAKERS, "Delsys")) for maker in KNOWN)


@pytest.mark.parametrize("units", [("cm/s^2", "deg/s"), ("mm/s²", "rad/s"), ("g", "mrad/s"), ("g", "rpm")])
def test_a_unit_that_is_not_read_is_not_guessed(units: tuple[str, str], table: Table, tmp_path: Path) -> None:
    """981 cm/s^2 would pass for 981 mg."""
    head = names("Time (s)", f"Acc * [{units[0]}]", f"Gyro * [{units[1]}]")
    (tmp_path / SINGLE).write_bytes(Export(head, "s:.2f cm/s^2 mrad").of(table))
    with pytest.raises(SourceRefused, match="is in a unit that is not read: bring it to"):
        proposal(tmp_path / SINGLE)


@pytest.mark.parametrize("content", ["", "a letter to a friend\n" * 50, "1,2\n" * 50, "a,b,c,d,e\n" * 50])
def test_what_is_no_table_is_refused(content: str, tmp_path: Path) -> None:
    (tmp_path / SINGLE).write_text(content)
    with pytest.raises(SourceRefused):
        proposal(tmp_path / SINGLE)


def test_a_gyroscope_with_times_of_its_own_is_brought_to_the_accelerometer_s(table: Table, tmp_path: Path) -> None:
    """As Trigno Discover writes channels that are read at other rates: here 4 ms later, and a ramp."""
    channels = {f"{kind} {axis}": unit for kind, unit in (("ACC", "G"), ("GYRO", "deg/s")) for axis in "XYZ"}
    head = ",".join(f"{name} Time Series (s),{name} ({unit})" for name, unit in channels.items())
    rows = [",".join([*(f"{s:.4f},{value:.6f}" for value in a / G), *[f"{s + 0.004:.4f},{10 * (s + 0.004):.6f}"] * 3])
            for _, s, a, _ in zip(*table)]  # fmt: skip
    (tmp_path / SINGLE).write_text("\n".join([head, *rows]))
    said, told = proposal(tmp_path / SINGLE)
    assert "the gyroscope has times of its own" in told and "acceleration in g: written in the file" in told
    (run,) = yaml.safe_load(said)["runs"]
    ((_, (found,)),) = CsvSource(run, tmp_path).runs()
    known = np.isfinite(found.angular_rate[:, 0])
    assert known.mean() > 0.9
    np.testing.assert_allclose(found.angular_rate[known, 0], 10 * found.device_stamp[known], atol=1e-3)


@pytest.mark.parametrize(("rate", "unit"), [("w", "rad"), ("deg", "deg")])
def test_xsens_without_a_head_is_told_by_size(rate: str, unit: str, table: Table, log: Log, tmp_path: Path) -> None:
    """MT Manager and DOT write the same names, and units a factor of 57 apart."""
    head = names("PacketCounter", "SampleTimeFine", "Acc_*", "Gyr_*")
    (tmp_path / SINGLE).write_bytes(Export(head, f"n:d ticks:d a {rate}").of(table))
    told = read_as_proposed(tmp_path / SINGLE, log, table)
    assert any(f"angular rate in {unit}/s: a guess by its size" in line for line in told), told


def test_an_hdf5_export_of_apdm(table: Table, log: Log, tmp_path: Path) -> None:
    with h5py.File(tmp_path / "20210304-walk.h5", "w") as file:
        group = file.create_group("Sensors/4231")
        group["Time"] = 1_614_852_000_000_000 + 10_000 * table[0]
        group["Accelerometer"], group["Gyroscope"] = table[2], table[3]
        group["Magnetometer"] = np.zeros_like(table[3])
    told = read_as_proposed(tmp_path / "20210304-walk.h5", log, table)
    assert any("Sensors/4231" in line and "APDM" in line for line in told)
