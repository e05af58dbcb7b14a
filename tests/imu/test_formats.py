"""The same readings in the forms that loggers write: every one gives the same recording, or one clear sentence."""

import math
import re
from collections.abc import Callable
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io
import yaml

from stages.imu.judgement.verdict import REFUSED
from stages.imu.sources import opening
from stages.imu.sources.cells import in_seconds, moment, unit_of
from stages.imu.sources.column_map import CsvSource
from stages.imu.sources.head import MAKERS as KNOWN
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.proposal import proposal
from stages.imu.sources.schema import Recording
from stages.imu.sources.units import scale_of
from stages.imu.trial.trial import read_trials
from tests.imu.exports import LAYOUTS, MAKERS, SINGLE, Export, G, Table, delsys, names
from tests.imu.made_logs import Log
from tests.imu.rewritings import UNITS
from tests.imu.stand_in import PARAMETERS

ROWS, START = 200, 1_614_852_000.25
TIME = START + 0.01 * np.arange(ROWS)
VALUES = np.round(np.random.default_rng(4).normal(size=(ROWS, 6)), 4)
NAMES = ["t", "ax", "ay", "az", "gx", "gy", "gz"]
DEVICE = {"place": "hip", "rate_hz": 100, "accelerometer_unit": "m/s^2", "gyroscope_unit": "rad/s"}
COLUMNS = {"phone_stamp": "t", **{name: name for name in NAMES[1:]}}


def as_text(stamp: Callable[[float], str], delimiter: str = ",", header: bool = True) -> str:
    rows = [delimiter.join([stamp(t), *(f"{value:.4f}" for value in row)]) for t, row in zip(TIME, VALUES)]
    return "\n".join([delimiter.join(NAMES), *rows] if header else rows) + "\n"


def written(format: str, zone: timezone = timezone.utc) -> Callable[[float], str]:
    def one(t: float) -> str:
        return (datetime(1970, 1, 1, tzinfo=timezone.utc) + timedelta(seconds=round(t, 6))).astimezone(zone).strftime(
            format
        )

    return one


def read(path: Path, columns: dict[str, str] = COLUMNS, **layout: Any) -> Recording:
    """What a file is read as whose map says these columns and this layout."""
    entry = {"file": path.name, "device": DEVICE, "columns": columns, **layout}
    ((_, (found,)),) = CsvSource({"files": [entry]}, path.parent).runs()
    return found


def recording(folder: Path, text: str | bytes, columns: dict[str, str] = COLUMNS, **layout: Any) -> Recording:
    (folder / "log.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    return read(folder / "log.csv", columns, **layout)


def proposed(path: Path) -> tuple[dict[str, Any], list[str]]:
    """The one file of a proposed map, and what is told of it."""
    said, told = proposal(path)
    ((file,),) = (run["files"] for run in yaml.safe_load(said)["runs"])
    return file, told


def same(found: Recording, start: float = START, exact: float = 2e-6) -> None:
    np.testing.assert_allclose(found.phone_stamp, TIME - START + start, rtol=0, atol=exact)
    np.testing.assert_array_equal(np.hstack((found.acceleration, found.angular_rate)), VALUES)


EAST, MIDNIGHT = timezone(timedelta(hours=2)), 86400 * 18_690
NUMBERED = {value: str(NAMES.index(name) + 1) for value, name in COLUMNS.items()}


def seconds(t: float) -> str:
    return f"{t:.3f}"


PLAIN, COMMA = as_text(seconds), as_text(seconds, ";").replace(".", ",")
EXPONENTS = "\n".join([";".join(f'"{name}"' for name in NAMES), *[
    ";".join(f"{value:.12E}".replace(".", ",") for value in (t, *row)) for t, row in zip(TIME, VALUES)]])
ALIGNED = "\n".join(" ".join(f"{cell:>20}" for cell in line.split(",")) for line in PLAIN.splitlines()) + "\n"
#: Ways to write the same: stamps of every kind, and layouts with what a map says of them.
WRITTEN: dict[str, tuple[str | bytes, dict[str, Any]]] = {
    "s": (PLAIN, {}),
    "ms": (as_text(lambda t: f"{t * 1e3:.0f}"), {}),
    "us": (as_text(lambda t: f"{t * 1e6:.0f}"), {}),
    "ns": (as_text(lambda t: f"{t * 1e9:.0f}"), {}),
    "ISO Z": (as_text(written("%Y-%m-%dT%H:%M:%S.%fZ")), {}),
    "ISO zone": (as_text(written("%Y-%m-%dT%H:%M:%S.%f%z", EAST)), {}),
    "database": (as_text(written("%Y-%m-%d %H:%M:%S.%f")), {}),
    "points": (as_text(written("%d.%m.%Y %H:%M:%S.%f")), {}),
    "nine digits": (as_text(lambda t: written("%Y-%m-%dT%H:%M:%S.%f")(t) + "000"), {}),
    "a row of units": (PLAIN.replace("\n", "\ns,m/s2,m/s2,m/s2,rad/s,rad/s,rad/s\n", 1), {}),
    "decimal comma": (COMMA, {"delimiter": "semicolon", "decimal": "comma"}),
    "decimal comma, told by the numbers": (COMMA, {"delimiter": "semicolon"}),
    "quoted decimal comma between commas": (re.sub("[^;\n]+", r'"\g<0>"', COMMA).replace(";", ","), {}),
    "quoted exponents": (EXPONENTS, {"delimiter": "semicolon"}),
    "no header": (as_text(seconds, "\t", header=False), {"columns": NUMBERED, "delimiter": "tab", "header": False}),
    "columns in line": (ALIGNED, {"delimiter": "space"}),
    "columns in line, its last row cut off": (ALIGNED + ALIGNED.splitlines()[-1][:30], {"delimiter": "space"}),
    "a head": ("Made by a logger\nSerial 7\n" + PLAIN, {"header_rows": 2}),
    "rows of another longer column": (PLAIN + 50 * (6 * "," + "\n"), {}),
    **{encoding: (PLAIN.encode(encoding), {}) for encoding in ("utf-16", "utf-16-le", "utf-16-be", "utf-8-sig")},
    "Windows-1252": (PLAIN.replace("ax", "a [m/s²]", 1).encode("cp1252"), {"columns": {**COLUMNS, "ax": "a [m/s²]"}}),
}


@pytest.mark.parametrize("form", WRITTEN)
def test_readings_are_the_same_however_they_are_written(form: str, tmp_path: Path) -> None:
    content, said = WRITTEN[form]
    same(recording(tmp_path, content, **said))


@pytest.mark.parametrize("block", [1000, 1 << 20])
def test_a_time_of_day_goes_on_over_midnight(block: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever it is in a file that is read in blocks; a row from before it may come late."""
    monkeypatch.setattr(opening, "BLOCK", block)
    head, *rows = as_text(lambda t: written("%H:%M:%S.%f")(t - START + MIDNIGHT - 0.5)).splitlines()
    same(recording(tmp_path, "\n".join([head, *rows])), 86400 - 0.5)
    rows[49:52] = rows[50], rows[49], rows[51]
    stamp = recording(tmp_path, "\n".join([head, *rows])).phone_stamp
    np.testing.assert_allclose(np.sort(stamp), TIME - START + 86400 - 0.5, rtol=0, atol=2e-6)


def test_a_few_cells_that_are_no_number_are_left_out_of_any_block(tmp_path: Path) -> None:
    lines = PLAIN.splitlines()
    lines[7] = lines[7].replace(lines[7].split(",")[2], "abc")
    lines[9] = lines[9].rsplit(",", 1)[0]
    found = recording(tmp_path, "\n".join(lines))
    assert np.isnan(found.acceleration[6, 1]) and np.isnan(found.angular_rate[8, 2])
    assert np.isfinite(found.acceleration).sum() == 3 * ROWS - 1


def stamped(stamp: str) -> str:
    """The plain table with this in the place of every stamp."""
    head, *rows = PLAIN.splitlines()
    return "\n".join([head, *(f"{stamp},{row.split(',', 1)[1]}" for row in rows)])


@pytest.mark.parametrize(("text", "layout", "words"), [
    (PLAIN.replace(".", "#"), {}, "the column 't' cannot be read"),
    (stamped("x"), {}, r"the column 't' cannot be read \('x' is no time\)"),
    (stamped(""), {}, "the column 't' is empty"),
    (COMMA, {"delimiter": "semicolon", "decimal": "point"}, "cannot be read"),
    ("\n".join([";".join(NAMES), *[";".join([f"1,{i + 100}"] * 7) for i in range(50)]]), {"delimiter": "semicolon"},
     "cannot be read"),
], ids=["no number", "no time", "nothing", "another decimal sign", "thousands"])  # fmt: skip
def test_a_column_that_cannot_be_read_is_refused(text: str, layout: dict[str, str], words: str, tmp_path: Path) -> None:
    """Thousands that are parted by commas are no decimals."""
    with pytest.raises(SourceRefused, match=words):
        recording(tmp_path, text, **layout)


def test_accelerometer_and_gyroscope_in_two_files(tmp_path: Path) -> None:
    """By packet number exactly; by stamp between the gyroscope's own samples, and not over its holes."""
    late = 0.004
    force = [f"{t:.4f},{i},{a:.4f},{b:.4f},{c:.4f}" for i, (t, (a, b, c)) in enumerate(zip(TIME, VALUES[:, :3]))]
    ramp = np.column_stack([TIME - START, 2 * (TIME - START), 0 * TIME])
    turn = [f"{t + late:.4f},{i},{a + late:.4f},{b + 2 * late:.4f},{c:.4f}"
            for i, (t, (a, b, c)) in enumerate(zip(TIME, ramp)) if not 100 <= i < 110]  # fmt: skip
    (tmp_path / "log.csv").write_text("\n".join(["t,n,x,y,z", *force]))
    (tmp_path / "gyr.csv").write_text("\n".join(["t,n,x,y,z", *turn]))

    def both(stamp: dict[str, str]) -> Recording:
        gyroscope = {"file": "gyr.csv", "columns": {**stamp, "gx": "x", "gy": "y", "gz": "z"}}
        found = read(tmp_path / "log.csv", {**stamp, "ax": "x", "ay": "y", "az": "z"}, gyroscope=gyroscope)
        np.testing.assert_array_equal(found.acceleration, VALUES[:, :3])
        return found

    known = np.ones(ROWS, dtype=bool)
    known[100:110] = False
    by_packet = both({"packet": "n"}).angular_rate
    np.testing.assert_allclose(by_packet[known], ramp[known] + [late, 2 * late, 0], atol=1e-4)
    assert np.isnan(by_packet[~known]).all()
    by_stamp = both({"device_stamp": "t"}).angular_rate
    known[[0, 110]] = False
    np.testing.assert_allclose(by_stamp[known], ramp[known], atol=2e-4)
    assert np.isnan(by_stamp[100:110]).all()
    with pytest.raises(SourceRefused, match="neither packet numbers nor a stamp in common"):
        both({})


UNITS_TOLD = {1: "s", 1e3: "ms", 1e6: "us", 1e9: "ns", 0.4: "s", 2.5: "s",
              **dict.fromkeys((1 / 3.5, 3.5, 4, 10, 30, 250))}  # fmt: skip


@pytest.mark.parametrize(("scale", "told"), UNITS_TOLD.items())
def test_a_unit_is_told_where_the_rate_confirms_it_within_a_factor_of_three(scale: float, told: str | None) -> None:
    """Stamps that advance ten times as fast as the nominal rate says are in no unit: they are refused later."""
    assert unit_of(scale * 0.01 * np.arange(100), 100.0) == told


@pytest.mark.parametrize(("unit", "bits"), [(1e6, 32), (1e6, 31), (1e3, 16), (1e3, 24), (1e9, 32)])
def test_a_counter_that_begins_anew_goes_on(unit: float, bits: int) -> None:
    """A row from before it may come late. Losses, pauses as long as a count and a sensor that restarts are none."""
    true = 0.01 * np.delete(np.arange(300), [120, 121, 122, 200])
    true[[150, 151]] = true[[151, 150]]
    count = np.round(unit * true + 2.0**bits - unit * true[150])
    found = in_seconds(count % 2.0**bits, 100.0)
    np.testing.assert_allclose(found - found[0], true - true[0], atol=1.0 / unit)
    restarted = np.round(unit * np.append(true, true))
    np.testing.assert_allclose(in_seconds(restarted, 100.0), restarted / unit)
    paused = np.round(unit * true + np.where(true > 1.0, 2.0**bits, 0.0))
    np.testing.assert_allclose(in_seconds(paused, 100.0), paused / unit)


def test_stamps_that_stand_or_pause_have_the_unit_that_their_rows_tell() -> None:
    stamp = 0.01 * np.arange(100)
    assert unit_of(np.full(100, 5.0), 100.0) is None
    np.testing.assert_array_equal(in_seconds(30 * stamp, 100.0), 30 * stamp)
    pauses = np.repeat(7200.0 * np.arange(4), 100) + 0.01 * np.arange(400)
    assert unit_of(1e3 * pauses, 100.0) == "ms", "two hours between runs are not milliseconds of anything"


def test_an_empty_row_is_the_place_of_a_lost_sample_if_it_has_a_number(tmp_path: Path) -> None:
    by_number = {name: name for name in NAMES[1:]}
    rows = PLAIN.splitlines()
    for cell, found in (("", ROWS - 1), ("0", ROWS)):  # csv has no empty row
        rows[5] = cell + 6 * ","
        assert recording(tmp_path, "\n".join(rows), by_number).rows == found


@pytest.mark.parametrize("name", ["log.c3d", "log.feather", "log.arrow", "log.xls", "log.ods"])
def test_a_format_that_is_not_read_is_named(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(b"ARROW1" + bytes(200))
    for reading in (read, proposal):
        with pytest.raises(SourceRefused, match="which is not read: save it as CSV"):
            reading(tmp_path / name)


@pytest.mark.parametrize("units", [("m/s^2", "rad/s"), ("g", "deg/s"), ("mg", "mdps")])
def test_a_struct_of_matlab_is_proposed_and_read(units: tuple[str, str], tmp_path: Path) -> None:
    """Its units by their size; a struct whose arrays are no three columns is passed over."""
    force = np.column_stack((VALUES[:, 0] / 9, 1 + VALUES[:, 1] / 99, VALUES[:, 2] / 9)) * 9.80665
    acc, gyr = (values * UNITS[unit] for values, unit in zip((force, VALUES[:, 3:]), units))
    data = {"trial": {"hip": {"time": TIME - START, "accel": acc, "gyro": gyr}, "note": "left",
                      "odd": {"acc_x": acc[:, 0], "gyr_x": gyr[:, 0]}}}  # fmt: skip
    scipy.io.savemat(tmp_path / "log.mat", data)
    file, told = proposed(tmp_path / "log.mat")
    assert (file["device"]["accelerometer_unit"], file["device"]["gyroscope_unit"]) == units, told
    ((_, (found,)),) = CsvSource({"files": [file]}, tmp_path).runs()
    np.testing.assert_allclose(found.angular_rate, gyr)


def test_what_is_no_time_is_none() -> None:
    assert all(math.isnan(moment(cell)) for cell in ("", "abc", "12", "25 o'clock", None, "2021-13-40 00:00:00"))
    ways = (".25", ",25Z", ".2500+02:00", ",250000000+0200", ".25+02", ".25-0930")
    shifts = [moment("2026-02-28 12:00:00") + 0.25 - moment(f"2026-02-28T12:00:00{way}") for way in ways]
    assert shifts == [0, 0, 7200, 7200, 7200, -9.5 * 3600]


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

    for name in ("log.mat", "log.h5", "new.mat"):
        same(read(tmp_path / name, columns))
        for wrong, words in (("imu/mag[1]", "has no array"), ("imu/acc[4]", "must name one of 3 columns"),
                             ("imu/acc", "must name one of 3 columns"), ("imu", "no (array|table)")):  # fmt: skip
            with pytest.raises(SourceRefused, match=words):
                read(tmp_path / name, columns | {"ax": wrong})
    for content in (b"", b"MATLAB" * 100, b"\x89HDF\r\n\x1a\n" + b"x" * 600):
        (tmp_path / "broken.mat").write_bytes(content)
        with pytest.raises(SourceRefused, match="no MATLAB or HDF5 file"):
            read(tmp_path / "broken.mat", columns)


# --- A map proposed from a file's head reads the file and names its maker: layouts and exports of one synthetic
# run.


@pytest.fixture(scope="module")
def table(log: Log) -> Table:
    """What the hip's sensor read, losses included."""
    hip = log.recordings[0]
    scale = scale_of(hip)
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
    scale = scale_of(recordings[0])
    whole = np.isfinite(recordings[0].angular_rate).all(axis=1)
    assert whole.mean() > 0.95
    np.testing.assert_allclose(recordings[0].acceleration * scale.acceleration, table[2], atol=1e-3)
    np.testing.assert_allclose((recordings[0].angular_rate * scale.angular_rate)[whole], table[3][whole], atol=1e-4)
    trial = next(read_trials(experiment, recordings, PARAMETERS))
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
    assert name != "x-io" or not any("names as" in line for line in told), told
    assert not [line for line in told if "guess" in line and (name not in LAYOUTS or "rate" not in line)], told


@pytest.mark.parametrize(("unit", "size"), [("m/s^2", 1.0), ("g", 1 / G), ("mg", 1e3 / G)])
def test_gravity_is_looked_for_as_it_is_where_the_robot_walks(unit: str, size: float, tmp_path: Path) -> None:
    moon = 1.62
    values = np.hstack([moon * size * np.array([[0.1, -0.2, 0.97]] * 50), np.zeros((50, 3))])
    lines = [f"{0.02 * row},{','.join(map(str, each))}" for row, each in enumerate(values)]
    (tmp_path / SINGLE).write_text("\n".join(["time,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z", *lines]))
    said, _ = proposal(tmp_path / SINGLE, moon)
    assert f"accelerometer_unit: {unit}\n" in said
    assert "accelerometer_unit: counts\n" in proposal(tmp_path / SINGLE)[0]


@pytest.mark.parametrize("names_there", [
    "t,rot_x,rot_y,rot_z,a_x,a_y,a_z,w_x,w_y,w_z", "t,x,y,z,hip_ax,hip_ay,hip_az,hip_gx,hip_gy,hip_gz",
    "t,mx,my,mz,a.x,a.y,a.z,g.x,g.y,g.z"])  # fmt: skip
def test_axes_that_say_what_they_are_of_come_before_those_that_do_not(names_there: str, tmp_path: Path) -> None:
    rows = [",".join([f"{0.01 * row}", *["3"] * 3, "0", "0", "9.8", *["0.1"] * 3]) for row in range(50)]
    (tmp_path / SINGLE).write_text("\n".join([names_there, *rows]))
    file, told = proposed(tmp_path / SINGLE)
    assert list(file["columns"].values()) == ["t", *names_there.split(",")[4:]]
    assert "acceleration in m/s^2: gravity reads 9.8" in told


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


@pytest.mark.parametrize("packet", [1, 20])
def test_a_gap_makes_a_sensor_no_slower(packet: int, tmp_path: Path) -> None:
    """Stamps of single samples, or of packets; a second is missing in twelve."""
    times = 0.01 * packet * (np.arange(1200) // packet)
    times[700:] += 1.0
    lines = [f"{time:.3f},0,0,9.8,0,0,0.1" for time in times]
    (tmp_path / SINGLE).write_text("\n".join(["time,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z", *lines]))
    assert proposed(tmp_path / SINGLE)[0]["device"]["rate_hz"] == 100


def test_every_maker_has_an_export_here() -> None:
    assert all(any(maker.name.startswith(known) for known in (*MAKERS, "Delsys")) for maker in KNOWN)


@pytest.mark.parametrize("units", [("cm/s^2", "deg/s"), ("mm/s²", "rad/s"), ("g", "mrad/s"), ("g", "rpm")])
def test_a_unit_that_is_not_read_is_not_guessed(units: tuple[str, str], table: Table, tmp_path: Path) -> None:
    """981 cm/s^2 would pass for 981 mg."""
    head = names("Time (s)", f"Acc * [{units[0]}]", f"Gyro * [{units[1]}]")
    (tmp_path / SINGLE).write_bytes(Export(head, "s:.2f cm/s^2 mrad").of(table))
    with pytest.raises(SourceRefused, match="is in a unit that is not read: bring it to"):
        proposal(tmp_path / SINGLE)


@pytest.mark.parametrize("stamp", ["unix_us", "micros"])
def test_a_second_sensors_columns_are_said_to_be_left_out(stamp: str, tmp_path: Path) -> None:
    """Hip and foot in one table: the foot was passed over without a word, and so were these stamps."""
    head = [stamp, *(f"{place}_{kind}{axis}" for place in ("hip", "foot") for kind in "ag" for axis in "xyz")]
    rows = [head, *([str(10_000 * row), *["0", "0", "9.81", "0", "0", "1"] * 2] for row in range(50))]
    (tmp_path / SINGLE).write_text("\n".join(map(",".join, rows)))
    said, told = proposal(tmp_path / SINGLE)
    assert any(line.startswith("left out") and "'foot_ax'" in line and "hip" not in line for line in told)
    assert f'device_stamp: "{stamp}"' in said


def test_degrees_in_german_are_no_radians(table: Table, tmp_path: Path) -> None:
    (tmp_path / SINGLE).write_bytes(Export(names("Time (s)", "Acc * [g]", "Gyr * [Grad/s]"), "s:.2f g deg").of(table))
    assert "angular rate in deg/s: written in the file" in proposal(tmp_path / SINGLE)[1]


@pytest.mark.parametrize(("content", "of", "said"), [
    *((content, SINGLE, ".") for content in ("", "a letter to a friend\n" * 50, "1,2\n" * 50, "a,b,c,d,e\n" * 50)),
    ("a,b,c,d\n1,2,3,4\n2,3,4,5\n", ".", f"has no file with an inertial sensor: '{SINGLE}' has no axis .* propose")])
def test_what_is_no_table_of_a_sensor_is_refused(content: str, of: str, said: str, tmp_path: Path) -> None:
    (tmp_path / SINGLE).write_text(content)
    with pytest.raises(SourceRefused, match=said):
        proposal(tmp_path / of)


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
