"""A map proposed from a file's head reads the file: ten layouts of loggers, made of one synthetic run."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pytest
import yaml

from stages.imu.judgement.verdict import REFUSED
from stages.imu.sources.column_map import CsvSource
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.proposal import proposal
from stages.imu.sources.units import scale_of
from stages.imu.trial.trial import Trial, read_trial
from tests.imu.made_logs import Log, made_log
from tests.imu.made_walks import campaign_parameters, stand_in_walks
from tests.imu.stand_in import PARAMETERS

Table = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
Written = tuple[str | bytes, str | bytes | None]


def read_as_proposed(path: Path, log: Log, table: Table) -> tuple[list[str], Trial]:
    """What --propose told of a file whose map, with place, mounting and slope filled in, reads the run; its trial."""
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
    return told, trial


@pytest.fixture(scope="module")
def log() -> Log:
    parameters = campaign_parameters()
    return made_log(0, stand_in_walks(1, parameters)[0], parameters)


@pytest.fixture(scope="module")
def table(log: Log) -> Table:
    """Sample number, time [s], specific force [m/s^2] and rate [rad/s] of the hip, losses included."""
    hip = log.recordings[0]
    scale = scale_of(hip.device)
    number = np.round((hip.device_stamp - hip.device_stamp[0]) * 100).astype(int)
    return number, 0.01 * number, hip.acceleration * scale.acceleration, hip.angular_rate * scale.angular_rate


def lines(head: list[str], rows: list[list[str]], delimiter: str = ",") -> str:
    return "\n".join([*head, *(delimiter.join(row) for row in rows)]) + "\n"


def text(values: np.ndarray, digits: int = 6) -> list[str]:
    return [f"{value:.{digits}f}" for value in values]


def clock(seconds: float) -> str:
    return (datetime(2021, 3, 4, 10, tzinfo=timezone.utc) + timedelta(seconds=float(seconds))).isoformat()


def x_io(t: Table) -> Written:
    axes = [f"{kind} {axis} ({unit})" for kind, unit in (("Gyroscope", "deg/s"), ("Accelerometer", "g"))
            for axis in "XYZ"]  # fmt: skip
    rows = [[f"{s:.2f}", *text(np.degrees(w)), *text(a / 9.80665)] for s, a, w in zip(*t[1:])]
    return lines([",".join(["Time (s)", *axes])], rows), None


def xsens(t: Table) -> Written:
    names = ["PacketCounter", *(f"{kind}_{axis}" for kind in ("Acc", "Gyr") for axis in "XYZ"), "Mag_X"]
    head = ["Acquisition frequency: 100 Hz", "\t".join(names)]
    return lines(head, [[f"{n}.0", *text(a), *text(w), "0.1"] for n, _, a, w in zip(*t)], "\t"), None


def dot(t: Table) -> Written:
    head = ["DeviceTag:,hip", "FirmwareVersion:,1.6.0", "",
            "PacketCounter,SampleTimeFine,Euler_X,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z"]  # fmt: skip
    rows = [[str(n), f"{s * 1e6:.0f}", "1.0", *text(a), *text(np.degrees(w))] for n, s, a, w in zip(*t)]
    return lines(head, rows), None


def two_files(t: Table) -> Written:
    """A file a sensor, stamps since 1970 in ms and written as well."""
    def one(head: str, values: np.ndarray) -> str:
        rows = [[f"{1.6e12 + 1e3 * s:.0f}", clock(s), f"{s:.3f}", *text(v)] for s, v in zip(t[1], values)]
        return lines([head], rows)

    force = one("epoc (ms),timestamp (+0000),elapsed (s),x-axis (g),y-axis (g),z-axis (g)", t[2] / 9.80665)
    return force, one("epoc (ms),timestamp (+0000),elapsed (s),x-axis (deg/s),y-axis (deg/s),z-axis (deg/s)",
                      np.degrees(t[3]))  # fmt: skip


def units_row(t: Table) -> Written:
    head = ["\t".join(["Timestamp", *(f"Accel_LN_{a}_CAL" for a in "XYZ"), *(f"Gyro_{a}_CAL" for a in "XYZ")]),
            "\t".join(["ms", *["m/(s^2)"] * 3, *["deg/s"] * 3])]  # fmt: skip
    rows = [[f"{1e3 * s:.1f}", *text(a), *text(np.degrees(w))] for s, a, w in zip(*t[1:])]
    return lines(head, rows, "\t"), None


def decimal_comma(t: Table) -> Written:
    head = ["Zeit;Time (s);Acc X (m/s²);Acc Y (m/s²);Acc Z (m/s²);Gyro X (rad/s);Gyro Y (rad/s);Gyro Z (rad/s)"]
    rows = [[str(n), f"{s:.2f}", *text(a), *text(w)] for n, s, a, w in zip(*t)]
    return lines(head, [[cell.replace(".", ",") for cell in row] for row in rows], ";"), None


def utf_16(t: Table) -> Written:
    return str(xsens(t)[0]).encode("utf-16"), None


def nanoseconds(t: Table) -> Written:
    head = ["time,seconds_elapsed,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z"]
    rows = [[str(1_600_000_000_000_000_000 + 10_000_000 * n), f"{s:.2f}", *text(w), *text(a)] for n, s, a, w in zip(*t)]
    return lines(head, rows), None


def iso(t: Table) -> Written:
    head = ["received_at,ax,ay,az,gx,gy,gz,counter"]
    rows = [[clock(s), *text(a / 9.80665e-3, 2), *text(np.degrees(w)), str(n)] for n, s, a, w in zip(*t)]
    return lines(head, rows), None


def quoted(t: Table) -> Written:
    head = ['"Sample number","Time (s)","Acceleration x (m/s^2)","Acceleration y (m/s^2)","Acceleration z (m/s^2)",'
            '"Angular velocity x (rad/s)","Angular velocity y (rad/s)","Angular velocity z (rad/s)"']  # fmt: skip
    return lines(head, [[str(n), f"{s:.2f}", *text(a), *text(w)] for n, s, a, w in zip(*t)]), None


def mdps(t: Table) -> Written:
    """As data logs of ST's sensors have it: kinds by their units, thousandths of both."""
    head = ["T [ms],A_x [mg],A_y [mg],A_z [mg],GyrX(mdps),GyrY(mdps),GyrZ(mdps)"]
    rows = [[f"{1e3 * s:.0f}", *text(a / 9.80665e-3), *text(1e3 * np.degrees(w))] for s, a, w in zip(*t[1:])]
    return lines(head, rows), None


def exponents(t: Table) -> Written:
    head = ['"Time (s)";"Acc X (g)";"Acc Y (g)";"Acc Z (g)";"Gyro X (°/s)";"Gyro Y (°/s)";"Gyro Z (°/s)"']
    rows = [[f"{value:.9E}".replace(".", ",") for value in (s, *(a / 9.80665), *np.degrees(w))] for s, a, w in
            zip(*t[1:])]  # fmt: skip
    return lines(head, rows, ";"), None


LAYOUTS = (x_io, xsens, dot, two_files, units_row, decimal_comma, utf_16, nanoseconds, iso, quoted, mdps, exponents)


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda one: one.__name__)
def test_a_proposed_map_reads_the_file(
    layout: Callable[[Table], Written], table: Table, log: Log, tmp_path: Path
) -> None:
    """Only place, mounting and slope are filled in, which no file holds; then the run is read and used."""
    for name, content in zip(("log_acc.csv", "log_gyr.csv"), layout(table)):
        if content is not None:
            (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    told, trial = read_as_proposed(tmp_path / "log_acc.csv", log, table)
    assert not [line for line in told if "guess" in line and "rate" not in line]
    assert trial.frequency.value == pytest.approx(1 / np.median(np.diff(log.strike_time)), rel=0.02)


@pytest.mark.parametrize("units", [("cm/s^2", "deg/s"), ("mm/s²", "rad/s"), ("g", "mrad/s"), ("g", "rpm")])
def test_a_unit_that_is_not_read_is_not_guessed(units: tuple[str, str], table: Table, tmp_path: Path) -> None:
    """981 cm/s^2 would pass for 981 mg."""
    names = [f"{kind} {axis} [{unit}]" for kind, unit in zip(("Acc", "Gyro"), units) for axis in "XYZ"]
    rows = [[f"{s:.2f}", *text(100 * a), *text(1e3 * w)] for s, a, w in zip(*table[1:])]
    (tmp_path / "log.csv").write_text(lines([",".join(["Time (s)", *names])], rows))
    with pytest.raises(SourceRefused, match="is in a unit that is not read: bring it to"):
        proposal(tmp_path / "log.csv")


def test_what_is_no_table_is_refused(tmp_path: Path) -> None:
    for content in ("", "a letter to a friend\n" * 50, "1,2\n" * 50, "a,b,c,d,e\n" * 50):
        (tmp_path / "log.csv").write_text(content)
        with pytest.raises(SourceRefused):
            proposal(tmp_path / "log.csv")
