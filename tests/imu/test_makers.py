"""Exports of common makers, made of one synthetic run: --propose names the maker, and its map reads the file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import datetime, timedelta, timezone
from pathlib import Path

import h5py
import numpy as np
import pytest
import yaml

from stages.imu.sources.column_map import CsvSource
from stages.imu.sources.head import MAKERS
from stages.imu.sources.proposal import proposal
from tests.imu.made_logs import Log
from tests.imu.test_proposal import (
    Table,
    dot,
    lines,
    log,
    read_as_proposed,
    table,
    text,
    two_files,
    units_row,
    xsens,
)

__all__ = ["log", "table"]  # fixtures
G = 9.80665
Files = Mapping[str, str]


def one(written: tuple[str | bytes, str | bytes | None]) -> Files:
    names = ("log_acc.csv", "log_gyr.csv")
    return {name: content for name, content in zip(names, written) if isinstance(content, str)}


def phyphox(t: Table) -> Files:
    kinds = (("Acceleration", "m/s^2"), ("Gyroscope", "rad/s"))
    names = ["Time (s)", *(f"{kind} {axis} ({unit})" for kind, unit in kinds for axis in "xyz")]
    head = ",".join(f'"{name}"' for name in names)
    return {"Raw Data.csv": lines([head], [[f"{s:.9E}", *text(a, 9), *text(w, 9)] for s, a, w in zip(*t[1:])])}


def sensor_logger(t: Table) -> Files:
    def file(values: np.ndarray) -> str:
        stamps = ((f"{1_600_000_000_000_000_000 + 10_000_000 * n}", f"{s:.9f}") for n, s in zip(t[0], t[1]))
        rows = [[*stamp, *text(row[::-1], 9)] for stamp, row in zip(stamps, values)]
        return lines(["time,seconds_elapsed,z,y,x"], rows)

    return {"TotalAcceleration.csv": file(t[2]), "Gyroscope.csv": file(t[3])}


def axivity(t: Table) -> Files:
    head = ["Time,Accel-X (g),Accel-Y (g),Accel-Z (g),Gyro-X (d/s),Gyro-Y (d/s),Gyro-Z (d/s)"]
    first = datetime(2021, 3, 4, 10, tzinfo=timezone.utc)
    rows = [[(first + timedelta(seconds=float(s))).strftime("%Y-%m-%d %H:%M:%S.%f")[:-3], *text(a / G),
             *text(np.degrees(w))] for s, a, w in zip(*t[1:])]  # fmt: skip
    return {"6012345_0000000001.csv": lines(head, rows)}


def physics_toolbox(t: Table) -> Files:
    rows = [[f"{s:.3f}", *text(a / G), *text(w)] for s, a, w in zip(*t[1:])]
    return {"walk.csv": lines(["time,gFx,gFy,gFz,wx,wy,wz"], rows)}


def noraxon(t: Table) -> Files:
    part = "Noraxon MyoMotion-Segments-Foot RT"
    kinds = ("Accel Sensor A{} (mG)", "Gyroscope-{} (deg/s)")
    names = ["time", *(f"{part}-{kind.format(axis)}" for kind in kinds for axis in "xyz")]
    rows = [[f"{s:.4f}", *text(1e3 * a / G), *text(np.degrees(w))] for s, a, w in zip(*t[1:])]
    return {"trial.csv": lines([",".join(names)], rows)}


def mt_manager(t: Table) -> Files:
    """As of 2022: ticks of 100 us, where the tracker has any."""
    head = ["// General information: ", "//  MT Manager version: 2022.2.0 ", "//  Update Rate: 100.0 Hz",
            "PacketCounter\tSampleTimeFine\tYear\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z"]
    return {"MT_00B42D4F.txt": lines(head, [[str(n), f"{100 * n}", "NaN", *text(a), *text(w)]
                                            for n, _, a, w in zip(*t)], "\t")}  # fmt: skip


def delsys(t: Table) -> Files:
    """A column of times before each channel; muscles are read oftener, so their columns are longer."""
    kinds = [(f"Avanti sensor 1: {kind}.{axis} 1", i) for i, (kind, axis) in
             enumerate((kind, axis) for kind in ("ACC", "GYRO") for axis in "XYZ")]  # fmt: skip
    head = ["Application: EMGworks", "Collection Length (seconds): 7",
            ",".join(f'X[s],"{name}"' for name in ("Avanti sensor 1: EMG 1", *(name for name, _ in kinds)))]
    values = np.hstack((t[2] / G, np.degrees(t[3])))
    rows = []
    for n in range(2 * len(t[1])):
        known = n < len(t[1])
        cells = [f"{0.005 * n:.4f}", "0.00001"]
        for _, i in kinds:
            cells += [f"{t[1][n]:.4f}", f"{values[n, i]:.6f}"] if known else ["", ""]
        rows.append(cells)
    return {"walk.csv": lines(head, rows)}


EXPORTS: dict[str, Callable[[Table], Files]] = {
    "Xsens DOT": lambda t: one(dot(t)),
    "Xsens MTw": lambda t: one(xsens(t)),
    "Xsens MTw (MT Manager)": mt_manager,
    "Delsys": delsys,
    "Shimmer": lambda t: one(units_row(t)),
    "phyphox": phyphox,
    "Sensor Logger": sensor_logger,
    "MetaWear": lambda t: one(two_files(t)),
    "Axivity": axivity,
    "Physics Toolbox": physics_toolbox,
    "Noraxon": noraxon,
}


@pytest.mark.parametrize("maker", EXPORTS)
def test_a_makers_export_is_named_and_read(maker: str, table: Table, log: Log, tmp_path: Path) -> None:
    files = EXPORTS[maker](table)
    for name, content in files.items():
        (tmp_path / name).write_text(content)
    told, _ = read_as_proposed(tmp_path / next(iter(files)), log, table)
    assert any(f"names as {maker}" in line for line in told), told
    assert not [line for line in told if "guess" in line], told


def test_a_gyroscope_with_times_of_its_own_is_brought_to_the_accelerometer_s(table: Table, tmp_path: Path) -> None:
    """As Trigno Discover writes channels that are read at other rates: here 4 ms later, and a ramp."""
    names = [f"{kind} {axis}" for kind in ("ACC", "GYRO") for axis in "XYZ"]
    units = ["G"] * 3 + ["deg/s"] * 3
    head = ",".join(f"{name} Time Series (s),{name} ({unit})" for name, unit in zip(names, units))
    rows = [[f"{s + late:.4f},{value:.6f}" for late, value in ((0.0, a[0] / G), (0.0, a[1] / G), (0.0, a[2] / G),
                                                             *[(0.004, 10 * (s + 0.004))] * 3)]
            for _, s, a, _ in zip(*table)]  # fmt: skip
    (tmp_path / "log.csv").write_text(lines([head], rows))
    said, told = proposal(tmp_path / "log.csv")
    assert "the gyroscope has times of its own" in told and "acceleration in g: written in the file" in told
    (run,) = yaml.safe_load(said)["runs"]
    ((_, (found,)),) = CsvSource(run, tmp_path).runs()
    known = np.isfinite(found.angular_rate[:, 0])
    assert known.mean() > 0.9
    np.testing.assert_allclose(found.angular_rate[known, 0], 10 * found.device_stamp[known], atol=1e-3)


@pytest.mark.parametrize("unit", [1.0, 180 / np.pi])
def test_xsens_without_a_head_is_told_by_size(unit: float, table: Table, log: Log, tmp_path: Path) -> None:
    """MT Manager and DOT write the same names, and units a factor of 57 apart."""
    head = ["PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z"]
    rows = [[str(n), f"{100 * n}", *text(a), *text(unit * w)] for n, _, a, w in zip(*table)]
    (tmp_path / "log.csv").write_text(lines(head, rows))
    told, _ = read_as_proposed(tmp_path / "log.csv", log, table)
    assert any(f"angular rate in {'rad' if unit == 1 else 'deg'}/s: a guess by its size" in line for line in told), told


def test_an_hdf5_export_of_apdm(table: Table, log: Log, tmp_path: Path) -> None:
    with h5py.File(tmp_path / "20210304-walk.h5", "w") as file:
        group = file.create_group("Sensors/4231")
        group["Time"] = 1_614_852_000_000_000 + 10_000 * table[0]
        group["Accelerometer"], group["Gyroscope"] = table[2], table[3]
        group["Magnetometer"] = np.zeros_like(table[3])
    told, _ = read_as_proposed(tmp_path / "20210304-walk.h5", log, table)
    assert any("Sensors/4231" in line and "APDM" in line for line in told)


def test_every_maker_has_an_export_here() -> None:
    assert all(any(maker.name.startswith(known) for known in EXPORTS) for maker in MAKERS)
