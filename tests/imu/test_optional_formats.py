"""Spreadsheets, parquet, bags of ROS 1 and 2, and MCAP give the recording that the same rows give as CSV."""

import sys
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import pytest

from stages.imu.sources import formats
from stages.imu.sources.column_map import CsvSource
from stages.imu.sources.opening import SourceRefused
from tests.imu.test_formats import COLUMNS, NAMES, ROWS, TIME, VALUES, proposed, read, same

WHY = "comes with the extra [files]"


def add_rows(sheet: object, head: list[list[str]], stamps: list[object], sign: float = 1.0) -> None:
    """Rows of a spreadsheet: its head, and the readings times a sign."""
    for row in [*head, *([stamp, *map(float, values)] for stamp, values in zip(stamps, sign * VALUES))]:
        sheet.append(row)  # type: ignore[attr-defined]


@pytest.mark.parametrize("stamp", ["seconds", "moments"])
def test_a_spreadsheet(stamp: str, tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl", reason=WHY)
    book, head = openpyxl.Workbook(), [["exported", "by a lab"], NAMES, ["s", *["m/s^2"] * 3, *["rad/s"] * 3]]
    moments = [datetime.fromtimestamp(t, timezone.utc).replace(tzinfo=None) for t in TIME]
    add_rows(book.active, head, moments if stamp == "moments" else TIME.tolist())
    book.save(tmp_path / "log.xlsx")
    same(read(tmp_path / "log.xlsx", header_rows=1), exact=1e-3)
    file, told = proposed(tmp_path / "log.xlsx")
    assert file["columns"] | {"phone_stamp": "t"} == {**COLUMNS, "device_stamp": "t"}
    assert file["header_rows"] == 1
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
            add_rows(made.create_sheet(name), [NAMES], TIME.tolist(), sign)
        made.save(path)

    book(walk=1)
    same(read(path))
    assert proposed(path)[0]["sheet"] == "walk"
    book(foot=-1, hip=1)
    same(read(path, sheet="hip"))
    for named, said in (({}, "in the sheets 'foot, hip': say which by the key sheet"),
                        ({"sheet": "knee"}, "has no sheet 'knee'; it has 'notes, foot, hip'")):  # fmt: skip
        with pytest.raises(SourceRefused, match=said):
            read(path, **named)


@pytest.mark.parametrize("pandas_there", [True, False])
def test_nanoseconds_in_parquet(pandas_there: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Moments finer than Python's, and times from the start, as pandas writes them."""
    pyarrow, parquet = (pytest.importorskip(name, reason=WHY) for name in ("pyarrow", "pyarrow.parquet"))
    if not pandas_there:
        monkeypatch.setitem(sys.modules, "pandas", None)
    at = np.round(1e9 * (TIME - TIME[0])).astype("int64") + 7
    since = at.astype("timedelta64[ns]")
    moments = np.datetime64(int(TIME[0]), "s").astype("datetime64[ns]") + since
    names = [f"{kind} {axis} [{unit}]" for kind, unit in (("Acc", "g"), ("Gyr", "mdps")) for axis in "XYZ"]
    for stamp in (moments, since):
        columns = dict(zip(["time", *names], (stamp, *VALUES.T)))
        parquet.write_table(pyarrow.table(columns), tmp_path / "log.parquet")
        file, told = proposed(tmp_path / "log.parquet")
        assert (file["device"]["rate_hz"], file["device"]["gyroscope_unit"]) == (100, "mdps"), told
        ((_, (found,)),) = CsvSource({"files": [file]}, tmp_path).runs()
        np.testing.assert_allclose(found.device_stamp - found.device_stamp[0], TIME - TIME[0], atol=1e-6)


@pytest.mark.parametrize("stamp", ["seconds", "moments", "written"])
def test_parquet(stamp: str, tmp_path: Path) -> None:
    pyarrow, parquet = (pytest.importorskip(name, reason=WHY) for name in ("pyarrow", "pyarrow.parquet"))
    at = (1e9 * TIME).astype("int64").astype("datetime64[ns]") if stamp != "seconds" else TIME
    at = at.astype(str) if stamp == "written" else at
    columns = dict(zip(NAMES, (at, *VALUES.T)))
    parquet.write_table(pyarrow.table(columns | {"words": ["x"] * ROWS}), tmp_path / "log.parquet", row_group_size=64)
    same(read(tmp_path / "log.parquet"))
    assert proposed(tmp_path / "log.parquet")[0]["columns"]["gz"] == "gz"
    for name, said in (("words", "'words' cannot be read"), ("nothing", "no column 'nothing'")):
        with pytest.raises(SourceRefused, match=said):
            read(tmp_path / "log.parquet", COLUMNS | {"ax": name})


def ros(kind: str, folder: Path) -> Path:
    """A recording of two topics, one of an inertial sensor."""
    pytest.importorskip("rosbags", reason=WHY)
    from rosbags.rosbag1 import Writer as Ros1
    from rosbags.rosbag2 import StoragePlugin, Writer as Ros2
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
    found = read(path, columns)
    same(found)
    np.testing.assert_allclose(found.device_stamp, TIME, rtol=0, atol=2e-6)
    file, told = proposed(path)
    assert (file["columns"], file["device"]["rate_hz"]) == (columns, 100)
    assert any("/imu/hip" in line for line in told)
    others = {value: name.replace("hip", "foot") for value, name in columns.items()}
    for wrong, said in ((others, "/imu/hip"), (columns | {"ax": "/imu/hip:__class__"}, "no column")):
        with pytest.raises(SourceRefused, match=said):
            read(path, wrong)


BROKEN = {"log.xlsx": "openpyxl", "log.parquet": "pyarrow"}
BROKEN |= dict.fromkeys(("log.bag", "log.mcap", "log.db3"), "rosbags")


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_none_of_these_is_refused(name: str, tmp_path: Path) -> None:
    pytest.importorskip(BROKEN[name], reason=WHY)
    for content in (b"", b"PK\x03\x04 broken", b"a,b\n1,2\n"):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(SourceRefused, match="log"):
            read(tmp_path / name)


@pytest.mark.parametrize("name", ["log.xlsx", "log.parquet", "log.mcap"])
def test_a_library_that_is_not_there_is_named(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for library in ("openpyxl", "pyarrow.parquet", "rosbags.highlevel"):
        monkeypatch.setitem(sys.modules, library, None)
    (tmp_path / name).write_bytes(b"anything")
    with pytest.raises(SourceRefused, match=r"bipedstudy\[files\]"):
        formats.read(tmp_path / name, formats.Layout(), ["t:stamp"], [])
