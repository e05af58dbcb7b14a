"""`bipedstudy ingest`: the report on the screen and as JSON, its exit codes, and silence about connections."""

import contextlib
import csv
import json
import shutil
import sqlite3
from pathlib import Path

import numpy as np
import pytest
import yaml

from stages.imu.sources import schema
from stages.imu.sources.databases import SqliteSource
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.reading import kept
from tests import commands
from tests.imu.stand_in import make_database, make_run

ACCELERATION, RATE = ("ax", "ay", "az"), ("gx", "gy", "gz")


@pytest.fixture(scope="module")
def database(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("lab") / "lab.sqlite"
    path.write_bytes(make_database([make_run(seed, steps=9, rest_s=1.5) for seed in (0, 3)]))
    return path


def ingest(repository: Path, *arguments: object, by_itself: dict[str, str] | None = None) -> tuple[int, str, str]:
    """Exit code, answer and errors; `by_itself` is the environment of a process of its own."""
    done = (commands.run("ingest", *arguments, cwd=repository) if by_itself is None
            else commands.afresh("ingest", *arguments, cwd=repository, **by_itself))  # fmt: skip
    assert "Traceback" not in done.stderr
    return done.returncode, done.stdout, done.stderr


def test_the_report_and_a_stored_copy(repository: Path, database: Path, tmp_path: Path) -> None:
    before = database.read_bytes()
    copy = tmp_path / "copy.sqlite"
    code, out, errors = ingest(repository, database, "--store", copy, by_itself={})
    assert code == 0 and "2 of 2 runs can be used" in errors
    assert [line.split()[0] for line in out.splitlines() if "(synthetic)" in line] == [
        "Rows", "Clocks", "Sensors", "Runs", "Legs,"
    ]  # fmt: skip
    assert database.read_bytes() == before
    _, again, _ = ingest(repository, copy)
    assert again == out
    code, _, errors = ingest(repository, database, "--store", copy)
    assert code == 2 and "is there already" in errors


def test_the_rows_of_a_long_run_need_no_file_to_be_sorted_in(repository: Path, database: Path, tmp_path: Path) -> None:
    """Who reads may write none: two sensors' 200 s ended with "cannot be opened read-only"."""
    long = tmp_path / "long.sqlite"
    shutil.copy(database, long)
    columns = ", ".join(name for name, _, _ in schema.TABLES["sample"][1:])
    with contextlib.closing(sqlite3.connect(long)) as opened:
        while opened.execute("SELECT count(*) FROM sample WHERE experiment_id = 1").fetchone()[0] < 40_000:
            opened.execute(f"INSERT INTO sample ({columns}) SELECT {columns} FROM sample WHERE experiment_id = 1")
        opened.commit()
    code, _, errors = ingest(repository, long)
    assert code == 0 and "2 of 2 runs can be used" in errors  # rows that are there again are left out


def test_rows_that_cannot_be_kept_are_said_of_the_copy(database: Path, tmp_path: Path, monkeypatch) -> None:
    """A disk that is full is one to SQLite: as a file that may have a few pages."""
    statements = schema.create_statements
    monkeypatch.setattr(schema, "create_statements", lambda keys: (*statements(keys), "PRAGMA max_page_count = 9"))
    with (pytest.raises(SourceRefused, match=r"^--store: the rows cannot be written \(database or disk is full\)$"),
          SqliteSource(database) as source):  # fmt: skip
        list(kept(source, str(tmp_path / "copy.sqlite")))


def test_files_with_a_column_map_as_json(repository: Path, tmp_path: Path) -> None:
    """A sensor that never moves: every item is reported, and the run is rejected."""
    names = ("count", *ACCELERATION, *RATE)
    rows = [f"{i},{0.01 * (i % 2)},9.81,0,0,0,0.001" for i in range(0, 400) if i % 50]
    (tmp_path / "hip.csv").write_text("\n".join([",".join(names), *rows]))
    device = {"place": "hip", "rate_hz": 100, "accelerometer_unit": "m/s^2", "gyroscope_unit": "rad/s"}
    columns = {"packet": "count", **{name: name for name in (*ACCELERATION, *RATE)}}
    run = {"experiment": {"name": "still"}, "files": [{"file": "hip.csv", "device": device, "columns": columns}]}
    (tmp_path / "map.yaml").write_text(yaml.safe_dump({"runs": [run]}))
    code, out, _ = ingest(repository, tmp_path, "--map", tmp_path / "map.yaml", "--json")
    assert code == 3
    answer = json.loads(out)
    (sensor,), (whole,) = answer["sensors"], answer["runs"]
    assert (sensor["rows"], sensor["lost_packets"], sensor["gaps"]) == (392, 7, 7)
    assert sensor["dead_axes"] == ["ay", "az", "gx", "gy", "gz"]
    assert not sensor["accepted"] and sensor["reasons"] == [
        "dead axes: ay, az, gx, gy, gz: look for columns of one value; a broken sensor is left out"]  # not what follows
    assert (sensor["acceleration_unit"], sensor["acceleration_step"]) == ("m/s^2", pytest.approx(0.01))
    assert (whole["name"], whole["accepted"], whole["overlap"]) == ("still", False, None)
    _, out, _ = ingest(repository, tmp_path, "--map", tmp_path / "map.yaml")
    assert "nan" not in out.split(), "what is not known is a dash"


@pytest.mark.parametrize(("line", "wrong", "said"), [
    (10, "device: {place: foot, rate_hz: fast}", "runs.1.files.0.device: rate_hz is 'fast', must be a number above 0"),
    (11, "columns: {ax: X, blood: B}", "runs.1.files.0.columns.blood: unknown key 'blood'; known are "),
    (11, "delimeter: tab", "runs.1.files.0.delimeter: unknown key 'delimeter'; known are columns, "),
    (9, "", "runs.1.files.0: must be a mapping"),
])
def test_what_is_wrong_in_a_map_is_named_with_file_and_line(
    repository: Path, tmp_path: Path, line: int, wrong: str, said: str
) -> None:  # fmt: skip
    run = ["- experiment: {name: one}", "  files:", "  - file: one.csv",
           "    device: {place: foot, rate_hz: 100, accelerometer_unit: g, gyroscope_unit: deg/s}",
           "    columns: {ax: X, ay: Y, az: Z, gx: P, gy: Q, gz: R}"]  # fmt: skip
    lines = ["runs:", *run, *run]
    lines[line - 1] = f"    {wrong}" if line > 9 else "  - pipe"
    (tmp_path / "columns.yaml").write_text("\n".join(lines if line > 9 else lines[:9]))
    code, _, errors = ingest(repository, tmp_path, "--map", tmp_path / "columns.yaml")
    assert code == 2 and f"columns.yaml:{line}: {said}" in " ".join(errors.split())


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("nothing.sqlite", "cannot be read"),
        ("README.md", "is not an SQLite database; ingest --propose looks into"),
        ("params", "is a folder; --map FILE must say what its files hold, and --propose FILE writes a first one"),
        ("env:BIPEDSTUDY_NOT_SET", "is not set"),
    ],
)
def test_bad_sources(repository: Path, source: str, words: str) -> None:
    code, out, errors = ingest(repository, source)
    assert (code, out) == (2, "")
    assert words in errors and len(errors.splitlines()) == 1


@pytest.mark.slow
def test_a_connection_string_is_never_told(repository: Path, tmp_path: Path) -> None:
    """Neither on the screen nor in any file, whether it comes as an argument or by its variable."""
    secret = "postgresql://anna:swordfish@host.invalid/gait"
    for arguments in ((secret,), ("env:LAB",)):
        code, out, errors = ingest(
            repository, *arguments, "--results", tmp_path / "results", by_itself={"LAB": secret})
        assert code == 2 and out == "" and len(errors.splitlines()) == 1
        assert not [part for part in ("anna", "swordfish", "invalid", "gait") if part in errors], errors
    assert not [path for path in tmp_path.rglob("*") if path.is_file() and b"swordfish" in path.read_bytes()]


def test_what_a_lab_takes_away(repository: Path, database: Path, tmp_path: Path) -> None:
    """Tables with a unit in every column's name that agree with the report, curves, and a picture of the first run."""
    code, out, errors = ingest(
        repository, database, "--json", "--export", tmp_path / "out", "--figure", tmp_path / "run.png"
    )
    assert code == 0, errors
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    tables = {name: list(csv.DictReader((tmp_path / "out" / f"{name}.csv").open()))
              for name in ("runs", "events", "times", "steps", "leg", "hip_path", "strides")}  # fmt: skip
    report = json.loads(out)["runs"]
    shown = [(row["name"], float(row["step_frequency [Hz]"])) for row in tables["runs"]]
    assert shown == [(one["name"], one["step_frequency"]) for one in report]
    kinds = [row["event"] for row in tables["events"]]
    assert kinds.count("heel strike") == sum(one["heel_strikes"] for one in report)
    assert set(kinds) == {"heel strike"}, "no slide of the stand-in shows when its foot is let go"
    assert all(0.3 < float(row["inner_step [s]"]) < 0.7 for row in tables["times"])
    assert len(tables["hip_path"]) == 51 * len(tables["steps"])
    assert all(0.1 < float(row["length [m]"]) < 0.2 for row in tables["steps"])
    assert len(tables["strides"]) == 101 * sum(one["strides"] for one in report)
    with np.load(tmp_path / "out/curves.npz") as curves:
        assert curves["strides"].shape == (sum(one["strides"] for one in report), 101, 6)
        assert (curves["signals"][2], len(curves["hip_path_m"])) == ("hip_lateral_rate [rad/s]", len(tables["steps"]))
    code, _, errors = ingest(repository, database, "--export", tmp_path / "out")
    assert code == 2 and "is there already" in errors


def test_a_map_is_proposed(repository: Path, tmp_path: Path) -> None:
    rows = [f"{0.01 * i:.2f},0.1,9.8,{i % 7 / 100},0.01,0.02,{i % 5 / 50}" for i in range(200)]
    folder = tmp_path / f"läufe-{60 * 'x'}"
    folder.mkdir()
    remark = "# of the lab, by A, B, C, on the hip, day 1, run 2"
    (folder / "log.csv").write_text("\n".join([remark, "time (s),ax,ay,az,gx,gy,gz", *rows]))
    (tmp_path / ".map.yaml.7-0.part").touch()
    code, out, errors = ingest(repository, folder / "log.csv", "--propose", tmp_path / "map.yaml")
    assert code == 0 and "rate 100 Hz" in out
    assert ".map.yaml.7-0.part was left by a command that was killed" in " ".join(errors.split())
    assert " ".join(out.split()).endswith(f"up_axis; then: bipedstudy ingest '{folder}' --map FILE"), "whole"
    (run,) = yaml.safe_load((tmp_path / "map.yaml").read_text())["runs"]
    assert run["files"][0]["columns"]["az"] == "az"
    code, out, _ = ingest(repository, folder, "--map", tmp_path / "map.yaml", "--json")
    assert code == 3 and json.loads(out)["sensors"][0]["rows"] == 200
    code, _, errors = ingest(repository, folder / "log.csv", "--map", tmp_path / "map.yaml")
    assert code == 2 and errors.endswith("log.csv: is a file; --map FILE wants the folder that holds it\n")
    code, _, errors = ingest(repository, tmp_path / "none.csv", "--propose", tmp_path / "other.yaml")
    assert code == 2 and "cannot be read" in errors and not (tmp_path / "other.yaml").exists()


def test_no_run_is_a_formula_in_a_spreadsheet(repository: Path, database: Path, tmp_path: Path) -> None:
    """Whoever names a run would run something on the computer of whoever opens the tables."""
    shutil.copy(database, tmp_path / "hostile.sqlite")
    with contextlib.closing(sqlite3.connect(tmp_path / "hostile.sqlite")) as connection, connection:
        connection.execute("""UPDATE experiment SET name = '=HYPERLINK("http://host.invalid","' || name || '")'""")
    code, out, errors = ingest(repository, tmp_path / "hostile.sqlite", "--csv", "--export", tmp_path / "out")
    assert code == 0, errors
    tables = [out, *(path.read_text() for path in (tmp_path / "out").glob("*.csv"))]
    cells = [[cell for row in csv.reader(text.splitlines()) for cell in row] for text in tables]
    assert len(tables) == 8 and all(any("HYPERLINK" in cell for cell in found) for found in cells)
    assert not [cell for found in cells for cell in found if cell.startswith(("=", "+", "@")) or cell[:2] == "-="]
    assert [float(cell) for found in cells for cell in found if cell.startswith("-")], "numbers stay numbers"
