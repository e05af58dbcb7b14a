"""Spreadsheets, parquet, bags of ROS 1 and 2, and MCAP give the recording that the same rows give as CSV."""

from __future__ import annotations

import sys
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import pytest
import yaml

from stages.imu.sources import formats
from stages.imu.sources.column_map import CsvSource
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.proposal import proposal
from stages.imu.sources.schema import Recording
from tests.imu.test_formats import COLUMNS, DEVICE, NAMES, ROWS, TIME, VALUES

WHY = "comes with the extra [files]"


def recording(path: Path, columns: dict[str, str] = COLUMNS, **layout: object) -> Recording:
    described = {"files": [{"file": path.name, "device": DEVICE, "columns": columns, **layout}]}
    ((_, (found,)),) = CsvSource(described, path.parent).runs()
    return found


def check(found: Recording, exact: float = 1e-6) -> None:
    np.testing.assert_allclose(found.phone_stamp, TIME, atol=exact)
    np.testing.assert_allclose(np.hstack((found.acceleration, found.angular_rate)), VALUES, atol=1e-12)


@pytest.mark.parametrize("stamp", ["seconds", "moments"])
def test_a_spreadsheet(stamp: str, tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl", reason=WHY)
    book = openpyxl.Workbook()
    book.active.append(["exported", "by a lab"])
    book.active.append(NAMES)
    book.active.append(["s", *["m/s^2"] * 3, *["rad/s"] * 3])
    for t, row in zip(TIME, VALUES):
        at = datetime.fromtimestamp(t, timezone.utc).replace(tzinfo=None) if stamp == "moments" else float(t)
        book.active.append([at, *map(float, row)])
    book.save(tmp_path / "log.xlsx")
    check(recording(tmp_path / "log.xlsx", header_rows=1), 1e-3)
    said, told = proposal(tmp_path / "log.xlsx")
    (run,) = yaml.safe_load(said)["runs"]
    assert run["files"][0]["columns"] | {"phone_stamp": "t"} == {**COLUMNS, "device_stamp": "t"}
    assert run["files"][0]["header_rows"] == 1
    assert any("m/s^2" in line for line in told)


def test_the_sheet_that_has_the_columns_is_read(tmp_path: Path) -> None:
    """Not the first; of two with the same columns the one that is named."""
    openpyxl = pytest.importorskip("openpyxl", reason=WHY)
    path = tmp_path / "log.xlsx"

    def book(**sheets: float) -> None:
        made = openpyxl.Workbook()
        made.active.title = "notes"
        made.active.append(["who", "when"])
        for name, sign in sheets.items():
            rows = made.create_sheet(name)
            rows.append(NAMES)
            for t, row in zip(TIME, sign * VALUES):
                rows.append([float(t), *map(float, row)])
        made.save(path)

    book(walk=1)
    check(recording(path))
    said, _ = proposal(path)
    assert yaml.safe_load(said)["runs"][0]["files"][0]["sheet"] == "walk"
    book(foot=-1, hip=1)
    check(recording(path, sheet="hip"))
    with pytest.raises(SourceRefused, match="in the sheets 'foot, hip': say which by the key sheet"):
        recording(path)
    with pytest.raises(SourceRefused, match="has no sheet 'knee'; it has 'notes, foot, hip'"):
        recording(path, sheet="knee")


@pytest.mark.parametrize("pandas_there", [True, False])
def test_nanoseconds_in_parquet(pandas_there: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Moments finer than Python's, and times from the start, as pandas writes them."""
    pyarrow = pytest.importorskip("pyarrow", reason=WHY)
    parquet = pytest.importorskip("pyarrow.parquet", reason=WHY)
    if not pandas_there:
        monkeypatch.setitem(sys.modules, "pandas", None)
    at = np.round(1e9 * (TIME - TIME[0])).astype("int64") + 7
    since = at.astype("timedelta64[ns]")
    moments = np.datetime64(int(TIME[0]), "s").astype("datetime64[ns]") + since
    names = [f"{kind} {axis} [{unit}]" for kind, unit in (("Acc", "g"), ("Gyr", "mdps")) for axis in "XYZ"]
    for stamp in (moments, since):
        columns = dict(zip(["time", *names], (stamp, *VALUES.T)))
        parquet.write_table(pyarrow.table(columns), tmp_path / "log.parquet")
        said, told = proposal(tmp_path / "log.parquet")
        (file,) = yaml.safe_load(said)["runs"][0]["files"]
        assert (file["device"]["rate_hz"], file["device"]["gyroscope_unit"]) == (100, "mdps"), told
        ((_, (found,)),) = CsvSource({"files": [file]}, tmp_path).runs()
        np.testing.assert_allclose(found.device_stamp - found.device_stamp[0], TIME - TIME[0], atol=1e-6)


@pytest.mark.parametrize("stamp", ["seconds", "moments"])
def test_parquet(stamp: str, tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow", reason=WHY)
    parquet = pytest.importorskip("pyarrow.parquet", reason=WHY)
    at = (1e9 * TIME).astype("int64").astype("datetime64[ns]") if stamp == "moments" else TIME
    columns = dict(zip(NAMES, (at, *VALUES.T)))
    parquet.write_table(pyarrow.table(columns | {"words": ["x"] * ROWS}), tmp_path / "log.parquet", row_group_size=64)
    check(recording(tmp_path / "log.parquet"))
    said, _ = proposal(tmp_path / "log.parquet")
    assert yaml.safe_load(said)["runs"][0]["files"][0]["columns"]["gz"] == "gz"
    with pytest.raises(SourceRefused, match="holds no numbers"):
        recording(tmp_path / "log.parquet", COLUMNS | {"ax": "words"})
    with pytest.raises(SourceRefused, match="no column 'nothing'"):
        recording(tmp_path / "log.parquet", COLUMNS | {"ax": "nothing"})


def ros(kind: str, folder: Path) -> Path:
    """A recording of two topics, one of an inertial sensor."""
    pytest.importorskip("rosbags", reason=WHY)
    from rosbags.rosbag1 import Writer as Ros1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Ros2
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS1_NOETIC if kind == "ros1" else Stores.ROS2_HUMBLE)
    path = folder / ("log.bag" if kind == "ros1" else "log")
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    with Ros1(path) if kind == "ros1" else Ros2(path, version=9, storage_plugin=plugin) as writer:
        topic = writer.add_connection("/imu/hip", formats.IMU, typestore=types)
        writer.add_connection("/camera", "std_msgs/msg/String", typestore=types)
        for t, row in zip(TIME, VALUES):
            message = imu_message(types, t, row)
            packed = types.serialize_ros1 if kind == "ros1" else types.serialize_cdr
            writer.write(topic, round(1e9 * t), packed(message, formats.IMU))
    return next(path.glob("*.mcap")) if kind == "mcap" else path


def imu_message(types: object, t: float, row: np.ndarray) -> object:
    of, no = types.types, np.zeros(9)  # type: ignore[attr-defined]
    vector, header = of["geometry_msgs/msg/Vector3"], of["std_msgs/msg/Header"]
    counted = {"seq": 0} if "seq" in header.__dataclass_fields__ else {}
    stamp = of["builtin_interfaces/msg/Time"](sec=int(t), nanosec=round(1e9 * (t % 1)) % 1_000_000_000)
    axes = [vector(**dict(zip("xyz", map(float, part)))) for part in (row[:3], row[3:])]
    still = of["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    return of[formats.IMU](header=header(**counted, stamp=stamp, frame_id="imu"), orientation=still,
                       orientation_covariance=no, angular_velocity=axes[1], angular_velocity_covariance=no,
                       linear_acceleration=axes[0], linear_acceleration_covariance=no)  # fmt: skip


@pytest.mark.parametrize("kind", ["ros1", "ros2", "mcap"])
def test_bags(kind: str, tmp_path: Path) -> None:
    path = ros(kind, tmp_path)
    columns = {value: f"/imu/hip:{field}" for value, field in formats.COLUMNS.items()}
    found = recording(path, columns)
    check(found)
    np.testing.assert_allclose(found.device_stamp, TIME, atol=1e-6)
    said, told = proposal(path)
    (run,) = yaml.safe_load(said)["runs"]
    assert run["files"][0]["columns"] == columns
    assert run["files"][0]["device"]["rate_hz"] == 100
    assert any("/imu/hip" in line for line in told)
    with pytest.raises(SourceRefused, match="/imu/hip"):
        recording(path, {value: name.replace("hip", "foot") for value, name in columns.items()})
    with pytest.raises(SourceRefused, match="no column"):
        recording(path, columns | {"ax": "/imu/hip:__class__"})


BROKEN = {"log.xlsx": "openpyxl", "log.parquet": "pyarrow"}
BROKEN |= dict.fromkeys(("log.bag", "log.mcap", "log.db3"), "rosbags")


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_none_of_these_is_refused(name: str, tmp_path: Path) -> None:
    pytest.importorskip(BROKEN[name], reason=WHY)
    for content in (b"", b"PK\x03\x04 broken", b"a,b\n1,2\n"):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(SourceRefused, match="log"):
            recording(tmp_path / name)


@pytest.mark.parametrize("name", ["log.xlsx", "log.parquet", "log.mcap"])
def test_a_library_that_is_not_there_is_named(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for library in ("openpyxl", "pyarrow.parquet", "rosbags.highlevel"):
        monkeypatch.setitem(sys.modules, library, None)
    (tmp_path / name).write_bytes(b"anything")
    with pytest.raises(SourceRefused, match=r"bipedstudy\[files\]"):
        formats.read(tmp_path / name, formats.Layout(), ["t:stamp"], [])
