"""Files made to read others, to never end, or to fill memory: each is refused in one sentence, and in bounds."""

import contextlib
import os
import random
import re
import sqlite3
import subprocess
import sys
import threading
import zipfile
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import yaml
from scipy.io import savemat

from stages.imu.sources.formats import COLUMNS
from stages.imu.sources.schema import create_statements
from tests import commands

#: What stands in the file beside, which no output may hold: as text, and as the numbers that its bytes are.
SECRET = b"0.123456789,SECRETS-OF-ANOTHER-FILE-" * 4000
NUMBERS = np.frombuffer(SECRET[:64])
MARKS = (b"SECRETS-OF", b"123456789", *(f"{one:.6g}".encode() for one in NUMBERS),
         *(one.byteswap().tobytes() for one in NUMBERS))  # fmt: skip
NAMES = ("ax", "ay", "az", "gx", "gy", "gz")
FORMATS = (".csv", ".txt", ".sqlite", "-wal.sqlite", ".xlsx", ".parquet", ".bag", ".db3", ".mcap", ".c3d", ".mat",
           ".h5")  # fmt: skip
ROWS = 400
MAGIC = {".parquet": b"PAR1", ".bag": b"#ROSBAG V2.0\n", ".mcap": b"\x89MCAP0\r\n", ".c3d": b"\x02\x50",
         ".db3": b"SQLite format 3\x00", ".mat": b"MATLAB 5.0 MAT-file"}  # fmt: skip


def values() -> dict[str, np.ndarray]:
    """An honest sensor's columns."""
    random_values = np.random.default_rng(1)
    return {name: random_values.normal(9.81 * (name == "az"), 0.1, ROWS) for name in NAMES}


def table(path: Path) -> None:
    """An honest text table."""
    columns = values()
    rows = [",".join(f"{columns[name][row]:.5f}" for name in NAMES) for row in range(ROWS)]
    path.write_text("\n".join([",".join(NAMES), *rows]))


def database(path: Path, *statements: str, wal: bool = False) -> None:
    """A database of the schema, with what else is said; in write-ahead mode its log stays."""
    with contextlib.closing(sqlite3.connect(path)) as connection:
        connection.execute(f"PRAGMA journal_mode = {'WAL' if wal else 'DELETE'}")
        for statement in (*create_statements(), *statements):
            connection.execute(statement)
        connection.commit()
        if wal:
            kept = {ending: path.with_name(path.name + ending).read_bytes() for ending in ("-wal", "-shm")}
            content = path.read_bytes()
    if wal:
        path.write_bytes(content)
        for ending, content in kept.items():
            path.with_name(path.name + ending).write_bytes(content)


ENDLESS = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i AS rowid, i AS sample_id, 1 AS " \
          "experiment_id, 1 AS device_id, i AS packet, 0 AS position, .01 * i AS device_stamp, 0 AS phone_stamp, " \
          "0 AS server_stamp, 0 AS ax, 0 AS ay, 9.81 AS az, 0 AS gx, 0 AS gy, 0 AS gz FROM n"  # fmt: skip
SAMPLE = "sample_id, experiment_id, device_id, packet, position, device_stamp, phone_stamp, server_stamp, " \
         "ax, ay, az, gx, gy, gz"  # fmt: skip
DEVICE = "INSERT INTO device VALUES (1, 'x', 'hip', 100, 40, 16, 2000, 'm/s^2', 'rad/s', 16, 10, 256, '+x', '+z')"
OVER_A_VIEW = ("DROP TABLE sample", f"CREATE VIEW endless AS {ENDLESS}",
               f"CREATE VIRTUAL TABLE sample USING fts5({SAMPLE}, content='endless', content_rowid='sample_id')",
               DEVICE)  # fmt: skip
A_VIEW = ("DROP TABLE sample", f"CREATE VIEW sample AS {ENDLESS}", DEVICE)
LARGE = ("INSERT INTO experiment VALUES (1, hex(zeroblob(50000000)), 'measured', 0)", DEVICE)


def book(path: Path, sheet: str, count: int, before: str = "") -> None:
    """A sheet of so many equal rows, as small as zip makes it."""
    kinds = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
    office = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
    package = "http://schemas.openxmlformats.org/package/2006"
    written = "application/vnd.openxmlformats-officedocument.spreadsheetml"
    row = "".join(f'<c t="inlineStr"><is><t>{name}</t></is></c>' for name in NAMES)

    def part(name: str, kind: str) -> str:
        return f'<Override PartName="/xl/{name}" ContentType="{written}.{kind}+xml"/>'

    def related(kind: str, target: str) -> str:
        return (f'<Relationships xmlns="{package}/relationships"><Relationship Id="a" Type="{office}/{kind}" '
                f'Target="{target}"/></Relationships>')  # fmt: skip

    parts = {
        "[Content_Types].xml": f'<Types xmlns="{package}/content-types"><Default Extension="rels" '
        'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
        f'{part("workbook.xml", "sheet.main")}{part("worksheets/sheet1.xml", "worksheet")}</Types>',
        "_rels/.rels": related("officeDocument", "xl/workbook.xml"),
        "xl/_rels/workbook.xml.rels": related("worksheet", "worksheets/sheet1.xml"),
        "xl/workbook.xml": f'<workbook xmlns="{kinds}" xmlns:r="{office}"><sheets>'
        '<sheet name="a" sheetId="1" r:id="a"/></sheets></workbook>',
    }  # fmt: skip
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
        for name, text in parts.items():
            file.writestr(name, text)
        with file.open("xl/worksheets/sheet1.xml", "w", force_zip64=True) as out:
            out.write(f'<?xml version="1.0"?>{before}<worksheet xmlns="{kinds}"><sheetData><row>{row}</row>'.encode())
            block = f"<row>{sheet}</row>".encode() * 1000
            for _ in range(count // 1000):
                out.write(block)
            out.write(b"</sheetData></worksheet>")


def arrays(path: Path, how: str, secret: Path) -> None:
    """An HDF5 file whose first column comes from another file, or is too large."""
    with h5py.File(path, "w", libver="latest") as file:
        for name, column in values().items():
            if name != "ax" and how != "bomb":
                file[name] = column
        if how.startswith("external"):
            file.create_dataset("ax", (ROWS,), "f8", external=[(str(secret), 0, 8 * ROWS)])
        elif how.startswith("virtual"):
            layout = h5py.VirtualLayout((ROWS,), "f8")
            layout[:] = h5py.VirtualSource(str(secret), "x", (ROWS,))
            file.create_virtual_dataset("ax", layout)
        elif how.startswith("link"):
            file["ax"] = h5py.ExternalLink(str(secret), "/x")
        elif how == "soft":
            file["there"] = h5py.ExternalLink(str(secret), "/")
            file["ax"] = h5py.SoftLink("/there/x")
        elif how == "group":
            file["ax"] = values()["ax"]
            file.create_group("deep/deeper")["other"] = h5py.ExternalLink(str(secret), "/x")
        else:
            for name in NAMES:
                file.create_dataset(name, (20_000_000,), "f8", chunks=(1_000_000,), compression="gzip",
                                    compression_opts=9, fillvalue=1.0)[:] = 1.0  # fmt: skip


def pressed(path: Path, rows: int) -> None:
    """A MATLAB file of constant columns."""
    savemat(path, dict.fromkeys(NAMES, np.ones(rows)), do_compression=True)


def other_file(folder: Path, how: str) -> Path:
    """The file beside: a plain one, an HDF5 file with the secret in it, or a pipe."""
    place = folder.parent / f"beside-{how}"
    if how.endswith("pipe"):
        with contextlib.suppress(FileExistsError):
            os.mkfifo(place)
    elif how.startswith("external"):
        place.write_bytes(SECRET)
    else:
        with h5py.File(place, "w") as file:
            file["x"] = np.frombuffer(SECRET[: 8 * ROWS])
    return place


def damaged(path: Path, of: random.Random) -> None:
    """Bytes changed, cut off or put in."""
    content = bytearray(path.read_bytes())
    for _ in range(of.choice((1, 30))):
        content[of.randrange(len(content))] = of.randrange(256)
    path.write_bytes(bytes(content[: of.choice((len(content), len(content) // 2))]))


def honest(path: Path, kind: str) -> None:
    """An honest file of the kind, to be damaged; where its library is missing, what only begins like one."""
    if kind in (".csv", ".txt"):
        table(path)
    elif "sqlite" in kind:
        database(path, DEVICE, "INSERT INTO sample VALUES (1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 9.81, 0, 0, 0)",
                 wal=kind.startswith("-wal"))  # fmt: skip
    elif kind == ".xlsx":
        book(path, "<c><v>1</v></c>" * 6, 1000)
    elif kind == ".h5":
        with h5py.File(path, "w") as file:
            file.update(values())
    elif kind == ".mat":
        savemat(path, values())
    elif kind == ".parquet":
        try:
            import pyarrow.parquet

            pyarrow.parquet.write_table(pyarrow.table(values()), path)
        except ImportError:
            path.write_bytes(MAGIC[kind] + bytes(1000) + MAGIC[kind])
    else:
        path.write_bytes(MAGIC[kind] + np.random.default_rng(2).bytes(3000))


def special(folder: Path, kind: str) -> list[Callable[[Path], None]]:
    """The tricks that a format has of its own."""
    inside = ("external", "virtual", "link", "soft", "group", "external-pipe", "virtual-pipe", "link-pipe", "bomb")
    found: list[Callable[[Path], None]] = []
    if kind in (".h5", ".mat"):
        found = [lambda path, how=how: arrays(path, how, other_file(folder, how)) for how in inside]  # type: ignore[misc]
    if kind == ".mat":
        found[5:] = [lambda path: pressed(path, 20_000_000), lambda path: pressed(path, 2_500_000)]
    if "sqlite" in kind:
        wal = kind.startswith("-wal")
        found = [lambda path, all=all: database(path, *all, wal=wal) for all in (OVER_A_VIEW, A_VIEW, LARGE)]  # type: ignore[misc]
        found.append(lambda path: (honest(path, kind), os.mkfifo(f"{path}-journal"))[0])
    if kind == ".xlsx":
        entity = f'<!DOCTYPE a [<!ENTITY x SYSTEM "file://{folder.parent}/beside">]>'
        laughs = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10 if n else "ha" * 50}">' for n in range(10))
        cell = '<c t="inlineStr"><is><t>{}</t></is></c>'
        found = [lambda path: book(path, "<c><v>1</v></c>" * 6, 7_500_000),
                 lambda path: book(path, cell.format("&x;") * 6, 1000, entity),
                 lambda path: book(path, cell.format("&l9;") * 6, 1000, f"<!DOCTYPE a [{laughs}]>"),
                 lambda path: book(path, "<c><v>1</v></c>" * 6, 2_000_000)]  # fmt: skip
    if kind in (".csv", ".txt"):
        found = [lambda path: path.symlink_to(folder.parent / "beside"),
                 lambda path: path.write_bytes(b"\x00" * 3_000_000),
                 lambda path: path.write_text(",".join(NAMES) + "\n" + "1," * 400_000)]  # fmt: skip
    if kind == ".db3":
        def bag(path: Path) -> None:
            path.mkdir()
            about = {"version": 5, "storage_identifier": "sqlite3", "relative_file_paths": ["../../beside"],
                     "duration": {"nanoseconds": 1}, "starting_time": {"nanoseconds_since_epoch": 0},
                     "message_count": 1, "topics_with_message_count": [], "compression_format": "",
                     "compression_mode": ""}  # fmt: skip
            (path / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": about}))

        found = [bag]
    return found


def hostile(folder: Path, seed: int) -> tuple[str, ...]:
    """Make the file of a seed in a new folder, with a map of it; the command that reads it, without `bipedstudy`."""
    folder.mkdir()
    (folder.parent / "beside").write_bytes(SECRET)
    of, kind = random.Random(seed), FORMATS[seed % len(FORMATS)]
    path, way = folder / f"log{kind}", seed // len(FORMATS)
    tricks = special(folder, kind)
    if way < len(tricks):
        tricks[way](path)
    elif way == len(tricks):
        os.mkfifo(path)
    elif way == len(tricks) + 1:
        path.symlink_to("/dev/zero")
    else:
        honest(path, kind)
        damaged(path, of)
    of_ros = kind in (".bag", ".db3", ".mcap")
    columns = {one: f"/imu:{COLUMNS[one]}" if of_ros else one for one in NAMES}
    device = {"place": "hip", "rate_hz": 100, "accelerometer_unit": "m/s^2", "gyroscope_unit": "rad/s"}
    name = "../beside" if kind == ".txt" and way % 2 else path.name
    files = [{"file": name, "device": device, "columns": columns}]
    (folder.parent / f"{folder.name}.yaml").write_text(yaml.safe_dump({"files": files}))
    if "sqlite" in kind:
        return "ingest", str(path), "--store", f"{folder}-store"
    if kind == ".c3d":
        return "calibrate", str(path)
    if way % 3 == 2:
        return "ingest", str(path), "--propose", f"{folder}-store"
    return "ingest", str(folder), "--map", f"{folder}.yaml", "--store", f"{folder}-store"


# --- Each is refused in one sentence, and in bounds.


pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo") or not hasattr(os, "wait4"), reason="uses pipes and wait4")
#: One of each trick of HDF5 and MATLAB files and databases, whose readers are always there.
SOME = (0, 2, 10, 11, 13, 22, 23, 34, 35, 38, 47, 59, 71, 83, 95)
SECONDS, MEGABYTES = 10.0, 1000.0
#: Of what reads an honest file of that kind.
USUAL_MB = 250.0


def left(folder: Path) -> bytes:
    return b"".join(path.read_bytes() for path in folder.parent.glob("*-store*") if path.is_file())


def sentences(said: str) -> list[str]:
    """What is said of the file; a slow machine is told how far the command is."""
    return [line for line in said.splitlines() if not re.match(r"note: |\d+ %: ", line)]


@pytest.mark.parametrize("seed", SOME, ids=lambda seed: f"{seed}{FORMATS[seed % len(FORMATS)]}")
def test_a_hostile_file_is_refused_in_one_sentence(seed: int, repository: Path, tmp_path: Path) -> None:
    done = commands.run(*hostile(tmp_path / "lab", seed), cwd=repository)
    said = sentences(done.stderr)
    assert done.returncode == 2 and len(said) == 1 and said[0].startswith("error: ")
    assert not any(mark in part for mark in MARKS for part in (done.stdout.encode(), done.stderr.encode()))
    assert not left(tmp_path / "lab")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(9 * len(FORMATS)), ids=lambda seed: f"{seed}{FORMATS[seed % len(FORMATS)]}")
def test_none_of_a_hundred_takes_more_than_its_time_and_memory(seed: int, repository: Path, tmp_path: Path) -> None:
    """Some are damaged so little that they are read; those say nothing or what is wrong with the runs."""
    made = "import sys; from pathlib import Path; from tests.imu.test_hostile import hostile; " \
           "print(*hostile(Path(sys.argv[1]), int(sys.argv[2])), sep='\\n')"  # fmt: skip
    words = commands.python(made, str(tmp_path / "lab"), str(seed), cwd=repository).stdout.split()
    with open(tmp_path / "out", "wb") as out, open(tmp_path / "errors", "wb") as errors:
        command = [sys.executable, "-c", "from pipeline.cli import main; main()", *words]
        process = subprocess.Popen(command, cwd=repository, stdout=out, stderr=errors)
        patience = threading.Timer(120.0, process.kill)
        patience.start()
        _, status, used = os.wait4(process.pid, 0)
        patience.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
    said = (tmp_path / "errors").read_bytes()
    content = (tmp_path / "out").read_bytes() + said + left(tmp_path / "lab")
    lines = sentences(said.decode())
    assert process.returncode in (0, 2, 3) and len(lines) <= 1 and b"Traceback" not in said
    assert not any(mark in content for mark in MARKS)
    assert used.ru_utime + used.ru_stime < SECONDS
    assert used.ru_maxrss / 1000 < USUAL_MB + MEGABYTES
