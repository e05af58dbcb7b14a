"""Columns of a file of any kind: a format is an entry, with its endings and how columns are read.

Spreadsheets and parquet files have columns by name. A MATLAB or HDF5 file has named arrays of one length, or columns of
one array. Bags of ROS 1 and ROS 2, and MCAP, have messages `sensor_msgs/Imu`, whose columns are named by topic and
field, such as "/imu/hip:linear_acceleration.x". Besides a message's own fields there are `stamp`, its header's, by the
sensor's clock, and `received`, when it was recorded.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import islice
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from stages.imu.sources import text_table
from stages.imu.sources.cells import text_of
from stages.imu.sources.opening import library, opening, place_of, printable, refuse
from stages.imu.sources.text_table import Layout, names_of

Columns = Mapping[str, np.ndarray]


@contextmanager
def _book(path: Path) -> Iterator[Any]:
    with opening(path, "spreadsheet that can be read"):
        book = library("openpyxl", "files", path).load_workbook(path, read_only=True, data_only=True)
        try:
            yield book
        finally:
            book.close()


def sheets_of(path: Path) -> list[str]:
    """Names of a book's sheets. Raises SourceRefused."""
    with _book(path) as book:
        return [sheet.title for sheet in book.worksheets]


def rows_of(path: Path, sheet: str) -> Iterator[tuple[Any, ...]]:
    """The cells of a sheet, row by row, one in memory at a time. Raises SourceRefused."""
    with _book(path) as book:
        yield from book[sheet].iter_rows(values_only=True)


def _sheet_meant(path: Path, layout: Layout, wanted: Sequence[str]) -> str:
    """The sheet that the layout names, or the only one that has the columns wanted. Raises SourceRefused."""
    sheets, name = sheets_of(path), printable(path.name)
    if layout.sheet:
        has = f"it has {printable(', '.join(sheets), 200)}"
        refuse((layout.sheet not in sheets, f"{name} has no sheet {printable(layout.sheet)}; {has}"))
        return layout.sheet
    heads = {sheet: next(islice(rows_of(path, sheet), layout.header_rows, None), ()) for sheet in sheets}
    having = [sheet for sheet, head in heads.items() if set(wanted) <= set(names_of(head, layout))]
    refuse((
        len(having) > 1,
        f"{name} has these columns in the sheets {printable(', '.join(having), 200)}: say which by the key sheet",
    ))
    return having[0] if having else sheets[0]


def _of_book(path: Path, layout: Layout, wanted: Sequence[str], stamps: Sequence[str]) -> Columns:
    """Columns by the names in the row after `header_rows`, or by number from 1; as those of a text."""
    rows = islice(rows_of(path, _sheet_meant(path, layout, wanted)), layout.header_rows, None)
    return text_table.columns_of(path.name, [list(map(text_of, row)) for row in rows], layout, wanted, stamps)


def parquet_file(path: Path) -> Any:
    """The file, opened. Raises SourceRefused."""
    with opening(path, "parquet file that can be read"):
        return library("pyarrow.parquet", "files", path).ParquetFile(path)


def _of_parquet(path: Path, layout: Layout, wanted: Sequence[str], stamps: Sequence[str]) -> Columns:
    """Columns of numbers, of moments, or of text, which is read as in a text table."""
    file = parquet_file(path)
    names = list(file.schema_arrow.names)
    for one in wanted:
        place_of(path.name, one, names)
    with opening(path, "parquet file that can be read"):
        table = file.read(columns=list(wanted))
        columns = [table.column(one).to_numpy() for one in wanted]
    columns = [one if one.dtype == object else seconds_or_numbers(one) for one in columns]
    if not any(one.dtype == object for one in columns):
        return dict(zip(wanted, columns))
    rows = [list(map(text_of, row)) for row in zip(*columns)]
    return text_table.columns_of(path.name, [wanted, *rows], Layout(""), wanted, stamps)


def seconds_or_numbers(values: np.ndarray) -> np.ndarray:
    """Numbers (n,); moments as seconds since 1970, durations in seconds. Raises ValueError for anything else."""
    if values.dtype.kind not in "mM":
        return np.asarray(values, dtype=float)
    known = ~np.isnat(values)
    since = values[known] - np.datetime64(0, "s") if values.dtype.kind == "M" else values[known]
    seconds = np.full(len(values), np.nan)
    seconds[known] = since / np.timedelta64(1, "s")
    return seconds


_COLUMN = re.compile(r"(.*)\[(\d+)\]$")


@contextmanager
def _arrays(path: Path) -> Iterator[Any]:
    """A MATLAB file as nested mappings, or an HDF5 file, which a .mat of version 7.3 is as well."""
    with opening(path, "MATLAB or HDF5 file that can be read"):
        with path.open("rb") as file:
            is_hdf5 = b"\x89HDF\r\n\x1a\n" in file.read(520)
        if is_hdf5:
            import h5py

            with h5py.File(path, "r") as opened:
                yield opened
        else:
            from scipy.io import loadmat

            yield loadmat(path, simplify_cells=True)


def _array(whole: Any, name: str) -> Any:
    """The array of this name, None where there is none; MATLAB stores those of an HDF5 file transposed."""
    if not isinstance(whole, dict):
        found = whole.get(name)
        values: Any = found[()] if hasattr(found, "shape") else None
        return values.T if str(whole.filename).endswith(".mat") and np.ndim(values) == 2 else values
    value: Any = whole
    for part in name.split("/"):
        value = value[part] if isinstance(value, Mapping) and part in value else None
    return value


def _of_arrays(path: Path, layout: Layout, wanted: Sequence[str], stamps: Sequence[str]) -> Columns:
    """Columns by the names of arrays: "acc_x" is one, "imu/acc[2]" the second column of an array in a group."""
    with _arrays(path) as whole:
        found = {one: _column(path.name, one, whole) for one in wanted}
    lengths = [len(column) for column in found.values()]
    refuse((
        len(set(lengths)) > 1,
        f"{printable(path.name)}: its columns are {min(lengths, default=0)} to {max(lengths, default=0)} long",
    ))
    return found


def _column(file: str, wanted: str, whole: Any) -> np.ndarray:
    """One column (n,) of an array."""
    values, place, column = _array(whole, wanted), 1, _COLUMN.match(wanted)
    if values is None and column:
        values, place = _array(whole, column[1]), int(column[2])
    table = np.asarray(values)
    table = table.reshape(-1, 1) if table.ndim < 2 or 1 in table.shape else table
    refuse(
        (values is None, f"{printable(file)} has no array {printable(wanted)}"),
        (table.dtype.kind not in "fiu" or table.ndim > 2,
         f"{printable(file)}: {printable(wanted)} is no table of numbers"),
        (not 1 <= place <= table.shape[1] or (table.shape[1] > 1 and not column),
         f"{printable(file)}: {printable(wanted)} must name one of {table.shape[1]} columns, such as "
         f"{printable(wanted.partition('[')[0])}[1]"),
    )
    return np.asarray(table[:, place - 1], dtype=float)


def groups_of(path: Path) -> dict[str, list[str]]:
    """Names of the arrays in each group of an HDF5 file, or struct of a MATLAB file. Raises SourceRefused."""
    found: dict[str, list[str]] = {}
    with _arrays(path) as whole:
        if isinstance(whole, dict):
            return _groups_in(whole, "")

        def seen(name: str, item: Any) -> None:
            group, _, last = name.rpartition("/")
            if hasattr(item, "shape"):
                found.setdefault(group, []).append(last)

        whole.visititems(seen)
    return found


def _groups_in(struct: Mapping[str, Any], group: str) -> dict[str, list[str]]:
    """Names of the arrays in a struct, and in those inside of it."""
    found = {group: [name for name, value in struct.items() if isinstance(value, np.ndarray) and value.dtype != object]}
    for name, value in struct.items():
        if isinstance(value, Mapping):
            found |= _groups_in(value, f"{group}/{name}" if group else name)
    return found


IMU = "sensor_msgs/msg/Imu"
#: What a map calls each value that a message of an inertial sensor has.
COLUMNS = {
    "device_stamp": "stamp", "phone_stamp": "received",
    **{f"a{axis}": f"linear_acceleration.{axis}" for axis in "xyz"},
    **{f"g{axis}": f"angular_velocity.{axis}" for axis in "xyz"},
}  # fmt: skip


@contextmanager
def _recording(path: Path) -> Iterator[Any]:
    """The recording, read only. Raises SourceRefused, also for what its reader stumbles over."""
    with opening(path, "recording of ROS or MCAP that can be read", or_folder=True):
        reader, types = (library(f"rosbags.{name}", "files", path) for name in ("highlevel", "typesys"))
        # The types of one release, for recordings that bring no definitions; Imu is the same in all.
        with reader.AnyReader([path], default_typestore=types.get_typestore(types.Stores.ROS2_HUMBLE)) as opened:
            yield opened


def topics(path: Path) -> list[tuple[str, int]]:
    """Topics of inertial sensors with the number of their messages. Raises SourceRefused."""
    with _recording(path) as reader:
        return [(one.topic, one.msgcount) for one in reader.connections if one.msgtype == IMU]


def _of_bag(path: Path, layout: Layout, wanted: Sequence[str], stamps: Sequence[str]) -> Columns:
    """Columns of one topic; stamps in seconds."""
    topic, fields = wanted[0].rpartition(":")[0], [one.rpartition(":")[2] for one in wanted]
    known = [f"{topic or '/TOPIC'}:{field}" for field in COLUMNS.values()]
    for name in wanted:
        place_of(path.name, name, known)
    rows: list[list[float]] = []
    with _recording(path) as reader:
        sensors = [one for one in reader.connections if one.msgtype == IMU]
        used = [one for one in sensors if one.topic == topic]
        place_of(path.name, topic, list(dict.fromkeys(one.topic for one in sensors)))
        for connection, received, raw in reader.messages(connections=used):
            message = reader.deserialize(raw, connection.msgtype)
            at = message.header.stamp
            times = {"stamp": at.sec + 1e-9 * at.nanosec, "received": 1e-9 * received}
            rows.append([times[one] if one in times else attrgetter(one)(message) for one in fields])
    return dict(zip(wanted, np.array(rows, dtype=float).reshape(-1, len(wanted)).T))


#: A format: what reads columns (n,) of such a file by name, given layout and stamps.
Format = Callable[[Path, Layout, Sequence[str], Sequence[str]], Columns]
BOOK, PARQUET, ARRAY_FILE, BAG, TEXT = _of_book, _of_parquet, _of_arrays, _of_bag, text_table.read
#: Formats by the endings that show them; others are texts.
FORMATS: dict[str, Format] = {
    ".xlsx": BOOK, ".xlsm": BOOK, ".parquet": PARQUET, ".pq": PARQUET, ".mat": ARRAY_FILE, ".h5": ARRAY_FILE,
    ".hdf5": ARRAY_FILE, ".bag": BAG, ".mcap": BAG, ".db3": BAG}
#: Formats of tables that are not read, and what writes them as one that is.
UNREAD = {".c3d": "motion capture", ".feather": "feather", ".arrow": "Arrow", ".xls": "a spreadsheet of before 2007",
          ".ods": "OpenDocument"}


def format_of(path: Path) -> Format:
    """The kind of a file by its ending, or by what a ROS 2 recorder leaves in a folder; others are text tables.

    Raises SourceRefused for a table of a format that is known and not read.
    """
    ending = path.suffix.lower()
    kind = UNREAD.get(ending)
    refuse((
        kind is not None, f"{printable(path.name)} is {kind}, which is not read: save it as CSV, .xlsx or parquet"
    ))
    return FORMATS.get(ending) or (BAG if (path / "metadata.yaml").is_file() else TEXT)


def read(path: Path, layout: Layout, wanted: Sequence[str], stamps: Sequence[str]) -> Columns:
    """The columns `wanted` (n,) each; those among `stamps` may be written dates or times of day.

    Raises SourceRefused for a file, or a column, that is not there or cannot be read.
    """
    return format_of(path)(path, layout, wanted, stamps)
