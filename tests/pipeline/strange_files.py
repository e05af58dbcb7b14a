"""Makers of strange files: what no program should hang on, believe, or meet with a traceback. Each is given a path."""

import os
import random
import socket
import sqlite3
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

from pipeline.cache import artefact

Maker = Callable[[Path], object]


def written(content: bytes | str) -> Maker:
    """A file with this content."""
    data = content if isinstance(content, bytes) else content.encode("utf-8", "surrogatepass")
    return lambda path: path.write_bytes(data)


def linked(target: str) -> Maker:
    """A link; an empty target is the link itself."""
    return lambda path: path.symlink_to(target or path.name)


def listening(path: Path) -> None:
    """A socket; its name must be short, so it is made in its folder."""
    here = Path.cwd()
    os.chdir(path.parent)
    try:
        socket.socket(socket.AF_UNIX).bind(path.name)
    finally:
        os.chdir(here)


def sparse(path: Path) -> None:
    """5 GB that take no room."""
    with open(path, "wb") as file:
        file.truncate(5_000_000_000)


def forbidden(path: Path) -> None:
    """A file that its owner may not read."""
    path.write_text("1")
    path.chmod(0)


#: What any file can be instead of one.
ANY: dict[str, Maker] = {
    "pipe": os.mkfifo,
    "socket": listening,
    "folder": Path.mkdir,
    "link to itself": linked(""),
    "link to nowhere": linked("nowhere"),
    "link to /dev/zero": linked("/dev/zero"),
    "no permission": forbidden,
    "sparse": sparse,
    "random bytes": written(random.Random(1).randbytes(10_000)),
    "zeros": written(bytes(1000)),
}
BOMB = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{new}: &{new} [{', '.join([f'*{old}'] * 9)}]\n" for old, new in zip("abcdefgh", "bcdefghi")
)
#: What a YAML file can be.
YAML: dict[str, Maker] = {
    **ANY,
    "empty": written(""),
    "UTF-16": written("height: 2.0\n".encode("utf-16")),
    "Latin-1": written("höhe: 2.0\n".encode("latin-1")),
    "deeply nested": written("[" * 100_000),
    "alias bomb": written(BOMB),
    "alias inside itself": written("height: &a [*a]\n"),
    "tag": written("height: !!python/object/apply:os.system [true]\n"),
    "byte order mark": written(b"\xef\xbb\xbf"),
    "long line": written("height: " + "9" * 10_000_000),
    "control signs": written("height: \x01\x02\n"),
    "two documents": written("height: 1\n---\nheight: 2\n"),
    "key twice": written("height: 1\nheight: 2\n"),
    "tabs": written("height:\n\tvalue: 2\n"),
    "merge key": written("base: &b {value: 2}\nheight: {<<: *b}\n"),
    "too large a number": written("height: 1e999\nsteps: 1e400\n"),
    "surrogate": written('height: "\\ud800"\n'),
    "list as key": written("? [height]\n: 2\n"),
    "null as key": written("~: 2\n"),
    "word": written("height"),
    "negative zero and not a number": written("height: .nan\nsteps: -0\n"),
}


def hdf5(make: Callable[[h5py.File], object], form: str = artefact.FORMAT) -> Maker:
    """An HDF5 file that calls itself an artefact."""

    def maker(path: Path) -> None:
        with h5py.File(path, "w") as file:
            file.attrs["format"] = form
            file.create_group("provenance").attrs["key"] = "0" * 32
            make(file)

    return maker


def _huge(file: h5py.File) -> None:
    file.create_dataset("height", shape=(10**12,), dtype="f8", chunks=(1 << 16,))


def _loop(file: h5py.File) -> None:
    file["height"] = h5py.SoftLink("/height")
    file["group"] = file["/"]


#: What an artefact can be.
ARTEFACT: dict[str, Maker] = {
    **ANY,
    "empty": written(b""),
    "HDF5 cut short": written(b"\x89HDF\r\n\x1a\n" + bytes(90)),
    "HDF5 of no study": hdf5(lambda file: None, "other"),
    "HDF5 of a newer form": hdf5(lambda file: None, "bipedstudy artefact 99999"),
    "HDF5 with a link to another file": hdf5(
        lambda file: file.__setitem__("height", h5py.ExternalLink("/etc/passwd", "/"))
    ),
    "HDF5 with links in a circle": hdf5(_loop),
    "HDF5 with a table of a terabyte": hdf5(_huge),
    "HDF5 with text for a number": hdf5(lambda file: file.create_dataset("height", data=b"\xff\xfe")),
    "HDF5 with lists of any length": hdf5(
        lambda file: file.create_dataset("height", (2,), dtype=h5py.vlen_dtype(np.float64))
    ),
    "HDF5 with a group for a number": hdf5(lambda file: file.create_group("height")),
}
#: What a file of the cache can be.
JSON: dict[str, Maker] = {
    **ANY,
    "empty": written(""),
    "deeply nested": written("[" * 100_000),
    "list": written("[]"),
    "number of ten thousand digits": written('{"seal": ' + "9" * 10_000 + "}"),
    "surrogates": written('{"seal": "\\ud800", "entry": {"\\ud800": NaN}}'),
}


def _database(*statements: str) -> Maker:
    def maker(path: Path) -> None:
        with sqlite3.connect(path) as connection:
            for statement in statements:
                connection.execute(statement)

    return maker


_ENDLESS = "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT x AS experiment_id FROM n"
#: What a database of measurements can be.
DATABASE: dict[str, Maker] = {
    **ANY,
    "empty": written(b""),
    "cut short": written(b"SQLite format 3\0" + bytes(40)),
    "another schema": _database("CREATE TABLE sample (x)"),
    "view without an end": _database(
        f"CREATE VIEW experiment AS {_ENDLESS}",
        f"CREATE VIEW device AS {_ENDLESS}",
        f"CREATE VIEW sample AS {_ENDLESS}",
    ),
    "tables without columns that are needed": _database(
        "CREATE TABLE experiment (experiment_id)", "CREATE TABLE device (device_id)", "CREATE TABLE sample (sample_id)"
    ),
}
#: What a log in columns can be.
LOG: dict[str, Maker] = {
    **ANY,
    "empty": written(""),
    "UTF-16": written("Counter,AccX\n1,2\n".encode("utf-16")),
    "one line without an end": written("Counter," + "9" * 5_000_000),
    "quote that is never closed": written('Counter,AccX,AccY,AccZ,GyrX,GyrY,GyrZ\n"1,2,3\n' + "4,5\n" * 50_000),
    "null bytes among numbers": written("Counter,AccX,AccY,AccZ,GyrX,GyrY,GyrZ\n1,\0,3,4,5,6,7\n" * 100),
}
