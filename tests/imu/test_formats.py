"""The same readings in the forms that loggers write: every one gives the same recording, or one clear sentence."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io
import yaml

from stages.imu.sources.cells import in_seconds, moment, moments, unit_of
from stages.imu.sources.column_map import CsvSource
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.proposal import proposal
from stages.imu.sources.schema import Recording
from tests.imu.rewritings import UNITS

ROWS, START = 200, 1_614_852_000.25
TIME = START + 0.01 * np.arange(ROWS)
VALUES = np.round(np.random.default_rng(4).normal(size=(ROWS, 6)), 4)
NAMES = ["t", "ax", "ay", "az", "gx", "gy", "gz"]
DEVICE = {"place": "hip", "rate_hz": 100, "accelerometer_unit": "m/s^2", "gyroscope_unit": "rad/s"}
COLUMNS = {"phone_stamp": "t", **{name: name for name in NAMES[1:]}}


def table(stamp: Callable[[float], str], delimiter: str = ",", header: bool = True) -> str:
    rows = [delimiter.join([stamp(t), *(f"{value:.4f}" for value in row)]) for t, row in zip(TIME, VALUES)]
    return "\n".join([delimiter.join(NAMES), *rows] if header else rows) + "\n"


def written(format: str, zone: timezone = timezone.utc) -> Callable[[float], str]:
    def one(t: float) -> str:
        return (datetime(1970, 1, 1, tzinfo=timezone.utc) + timedelta(seconds=round(t, 6))).astimezone(zone).strftime(
            format
        )

    return one


def recording(folder: Path, text: str | bytes, columns: dict[str, str] = COLUMNS, **layout: Any) -> Recording:
    (folder / "log.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    entry = {"file": "log.csv", "device": DEVICE, "columns": columns, **layout}
    ((_, (found,)),) = CsvSource({"files": [entry]}, folder).runs()
    return found


def same(found: Recording, start: float = START) -> None:
    np.testing.assert_allclose(found.phone_stamp, TIME - START + start, rtol=0, atol=2e-6)
    np.testing.assert_array_equal(np.hstack((found.acceleration, found.angular_rate)), VALUES)


EAST = timezone(timedelta(hours=2))


@pytest.mark.parametrize(
    "stamp",
    [
        lambda t: f"{t:.3f}",
        lambda t: f"{t * 1e3:.0f}",
        lambda t: f"{t * 1e6:.0f}",
        lambda t: f"{t * 1e9:.0f}",
        written("%Y-%m-%dT%H:%M:%S.%fZ"),
        written("%Y-%m-%dT%H:%M:%S.%f%z", EAST),
        written("%Y-%m-%d %H:%M:%S.%f"),
        written("%d.%m.%Y %H:%M:%S.%f"),
        lambda t: written("%Y-%m-%dT%H:%M:%S.%f")(t) + "000",
    ],
    ids=["s", "ms", "us", "ns", "ISO Z", "ISO zone", "database", "points", "nine digits"],
)
def test_stamps_of_every_kind(stamp: Callable[[float], str], tmp_path: Path) -> None:
    same(recording(tmp_path, table(stamp)))


def test_a_time_of_day_goes_on_over_midnight(tmp_path: Path) -> None:
    midnight = 86400 * 18_690
    late = table(lambda t: written("%H:%M:%S.%f")(t - START + midnight - 2))
    same(recording(tmp_path, late), 86400 - 2)


def test_layouts(tmp_path: Path) -> None:
    plain = table(lambda t: f"{t:.3f}")
    units = plain.replace("\n", "\ns,m/s2,m/s2,m/s2,rad/s,rad/s,rad/s\n", 1)
    same(recording(tmp_path, units))
    comma = table(lambda t: f"{t:.3f}", ";").replace(".", ",")
    same(recording(tmp_path, comma, delimiter="semicolon", decimal="comma"))
    bare = table(lambda t: f"{t:.3f}", "\t", header=False)
    by_number = {value: str(NAMES.index(name) + 1) for value, name in COLUMNS.items()}
    same(recording(tmp_path, bare, by_number, delimiter="tab", header=False))
    for encoding in ("utf-16", "utf-16-le", "utf-16-be", "utf-8-sig"):
        same(recording(tmp_path, plain.encode(encoding)))
    same(recording(tmp_path, "Made by a logger\nSerial 7\n" + plain, header_rows=2))


def test_a_few_cells_that_are_no_number_are_left_out_of_any_block(tmp_path: Path) -> None:
    lines = table(lambda t: f"{t:.3f}").splitlines()
    lines[7] = lines[7].replace(lines[7].split(",")[2], "abc")
    lines[9] = lines[9].rsplit(",", 1)[0]
    found = recording(tmp_path, "\n".join(lines))
    assert np.isnan(found.acceleration[6, 1]) and np.isnan(found.angular_rate[8, 2])
    assert np.isfinite(found.acceleration).sum() == 3 * ROWS - 1


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text.replace(".", "#"), "the column 't' cannot be read"),
        (lambda text: "\n".join([text.split("\n")[0], *("x," + line.split(",", 1)[1] for line in text.split()[1:])]),
         "the column 't' cannot be read ('x' is no time)"),
        (lambda text: "\n".join([text.split("\n")[0], *("," + line.split(",", 1)[1] for line in text.split()[1:])]),
         "the column 't' is empty"),
    ],
)  # fmt: skip
def test_a_column_that_cannot_be_read_is_refused(
    change: Callable[[str], str], words: str, tmp_path: Path
) -> None:
    with pytest.raises(SourceRefused, match=words.replace("(", r"\(").replace(")", r"\)")):
        recording(tmp_path, change(table(lambda t: f"{t:.3f}")))


def test_accelerometer_and_gyroscope_in_two_files(tmp_path: Path) -> None:
    """By packet number exactly; by stamp between the gyroscope's own samples, and not over its holes."""
    late = 0.004
    force = [f"{t:.4f},{i},{a:.4f},{b:.4f},{c:.4f}" for i, (t, (a, b, c)) in enumerate(zip(TIME, VALUES[:, :3]))]
    ramp = np.column_stack([TIME - START, 2 * (TIME - START), 0 * TIME])
    turn = [f"{t + late:.4f},{i},{a + late:.4f},{b + 2 * late:.4f},{c:.4f}"
            for i, (t, (a, b, c)) in enumerate(zip(TIME, ramp)) if not 100 <= i < 110]  # fmt: skip
    (tmp_path / "log.csv").write_text("\n".join(["t,n,x,y,z", *force]))
    (tmp_path / "gyr.csv").write_text("\n".join(["t,n,x,y,z", *turn]))

    def read(stamp: dict[str, str]) -> Recording:
        entry = {
            "file": "log.csv", "device": DEVICE, "columns": {**stamp, "ax": "x", "ay": "y", "az": "z"},
            "gyroscope": {"file": "gyr.csv", "columns": {**stamp, "gx": "x", "gy": "y", "gz": "z"}},
        }  # fmt: skip
        ((_, (found,)),) = CsvSource({"files": [entry]}, tmp_path).runs()
        np.testing.assert_array_equal(found.acceleration, VALUES[:, :3])
        return found

    known = np.ones(ROWS, dtype=bool)
    known[100:110] = False
    by_packet = read({"packet": "n"}).angular_rate
    np.testing.assert_allclose(by_packet[known], ramp[known] + [late, 2 * late, 0], atol=1e-4)
    assert np.isnan(by_packet[~known]).all()
    by_stamp = read({"device_stamp": "t"}).angular_rate
    known[[0, 110]] = False
    np.testing.assert_allclose(by_stamp[known], ramp[known], atol=2e-4)
    assert np.isnan(by_stamp[100:110]).all()
    with pytest.raises(SourceRefused, match="neither packet numbers nor a stamp in common"):
        read({})


def test_a_unit_is_told_only_where_the_rate_confirms_it() -> None:
    stamp = 0.01 * np.arange(100)
    assert [unit_of(scale * stamp, 100.0) for scale in (1, 1e3, 1e6, 1e9)] == ["s", "ms", "us", "ns"]
    assert [unit_of(factor * stamp, 100.0) for factor in (0.4, 2.5, 4, 10, 30, 250)] == ["s", "s", *[None] * 4]
    assert unit_of(np.full(100, 5.0), 100.0) is None
    np.testing.assert_array_equal(in_seconds(30 * stamp, 100.0), 30 * stamp)
    pauses = np.repeat(7200.0 * np.arange(4), 100) + 0.01 * np.arange(400)
    assert unit_of(1e3 * pauses, 100.0) == "ms", "two hours between runs are not milliseconds of anything"


@pytest.mark.parametrize(("factor", "told"), [(0.4, "s"), (2.5, "s"), (1 / 3.5, None), (3.5, None), (10.0, None)])
def test_a_unit_is_confirmed_within_a_factor_of_three(factor: float, told: str | None) -> None:
    """Stamps that advance ten times as fast as the nominal rate says are in no unit: they are refused later."""
    assert unit_of(0.01 * factor * np.arange(100), 100.0) == told


def test_a_decimal_comma_is_told_by_the_numbers(tmp_path: Path) -> None:
    """Where the map says nothing; thousands parted by commas are no decimals, and are refused."""
    comma = table(lambda t: f"{t:.3f}", ";").replace(".", ",")
    same(recording(tmp_path, comma, delimiter="semicolon"))
    with pytest.raises(SourceRefused, match="cannot be read"):
        recording(tmp_path, comma, delimiter="semicolon", decimal="point")
    thousands = "\n".join([";".join(NAMES), *[";".join([f"1,{i + 100}"] * 7) for i in range(50)]])
    with pytest.raises(SourceRefused, match="cannot be read"):
        recording(tmp_path, thousands, delimiter="semicolon")
    exponents = "\n".join([";".join(f'"{name}"' for name in NAMES), *[
        ";".join(f"{value:.12E}".replace(".", ",") for value in (t, *row)) for t, row in zip(TIME, VALUES)]])
    same(recording(tmp_path, exponents, delimiter="semicolon"))


def test_rows_of_another_longer_column_are_none_of_the_sensor_s(tmp_path: Path) -> None:
    """But without number or stamp an empty row is the place of a sample that was lost."""
    text = table(lambda t: f"{t:.3f}")
    same(recording(tmp_path, text + 50 * (6 * "," + "\n")))
    rows = text.splitlines()
    rows[5] = 6 * ","
    numbered = recording(tmp_path, "\n".join(rows), {name: name for name in NAMES[1:]})
    assert numbered.rows == ROWS - 1, "csv has no empty row"
    rows[5] = "0" + 6 * ","
    assert recording(tmp_path, "\n".join(rows), {name: name for name in NAMES[1:]}).rows == ROWS


@pytest.mark.parametrize("name", ["log.feather", "log.arrow", "log.xls", "log.ods"])
def test_a_format_that_is_not_read_is_named(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(b"ARROW1" + bytes(200))
    entry = {"file": name, "device": DEVICE, "columns": COLUMNS}
    with pytest.raises(SourceRefused, match="which is not read: save it as CSV"):
        list(CsvSource({"files": [entry]}, tmp_path).runs())
    with pytest.raises(SourceRefused, match="which is not read: save it as CSV"):
        proposal(tmp_path / name)


@pytest.mark.parametrize("units", [("m/s^2", "rad/s"), ("g", "deg/s"), ("mg", "mdps")])
def test_a_struct_of_matlab_is_proposed_and_read(units: tuple[str, str], tmp_path: Path) -> None:
    """Its units by their size; a struct whose arrays are no three columns is passed over."""
    force = np.column_stack((VALUES[:, 0] / 9, 1 + VALUES[:, 1] / 99, VALUES[:, 2] / 9)) * 9.80665
    acc, gyr = (values * UNITS[unit] for values, unit in zip((force, VALUES[:, 3:]), units))
    data = {"trial": {"hip": {"time": TIME - START, "accel": acc, "gyro": gyr}, "note": "left",
                      "odd": {"acc_x": acc[:, 0], "gyr_x": gyr[:, 0]}}}  # fmt: skip
    scipy.io.savemat(tmp_path / "log.mat", data)
    said, told = proposal(tmp_path / "log.mat")
    (run,) = yaml.safe_load(said)["runs"]
    (file,) = run["files"]
    assert (file["device"]["accelerometer_unit"], file["device"]["gyroscope_unit"]) == units, told
    ((_, (found,)),) = CsvSource({"files": [file]}, tmp_path).runs()
    np.testing.assert_allclose(found.angular_rate, gyr)


def test_what_is_no_time_is_none() -> None:
    assert all(math.isnan(moment(cell)) for cell in ("", "abc", "12", "25 o'clock", None, "2021-13-40 00:00:00"))
    assert moments(["23:59:59.5", "", "00:00:00.5"])[[0, 2]].tolist() == [86399.5, 86400.5]


def test_matlab_and_hdf5(tmp_path: Path) -> None:
    """Arrays and columns of an array; a .mat of version 7.3 is HDF5, with its arrays transposed."""
    data = {"t": TIME, "imu": {"acc": VALUES[:, :3], "gyr": VALUES[:, 3:]}}
    scipy.io.savemat(tmp_path / "log.mat", data)
    for name, turned in (("log.h5", False), ("new.mat", True)):
        with h5py.File(tmp_path / name, "w") as file:
            file["t"] = TIME
            for kind, columns in (("acc", VALUES[:, :3]), ("gyr", VALUES[:, 3:])):
                file[f"imu/{kind}"] = columns.T if turned else columns
    columns = {"phone_stamp": "t"} | {
        f"{kind[0]}{axis}": f"imu/{kind}[{number}]" for kind in ("acc", "gyr") for number, axis in enumerate("xyz", 1)
    }

    def read(name: str, **changed: str) -> Recording:
        entry = {"file": name, "device": DEVICE, "columns": columns | changed}
        ((_, (found,)),) = CsvSource({"files": [entry]}, tmp_path).runs()
        return found

    for name in ("log.mat", "log.h5", "new.mat"):
        same(read(name))
        for wrong, words in (("imu/mag[1]", "has no array"), ("imu/acc[4]", "must name one of 3 columns"),
                             ("imu/acc", "must name one of 3 columns"), ("imu", "no (array|table)")):  # fmt: skip
            with pytest.raises(SourceRefused, match=words):
                read(name, ax=wrong)
    for content in (b"", b"MATLAB" * 100, b"\x89HDF\r\n\x1a\n" + b"x" * 600):
        (tmp_path / "broken.mat").write_bytes(content)
        with pytest.raises(SourceRefused, match="no MATLAB or HDF5 file"):
            read("broken.mat")
