"""A first map of files that nothing is known about: what their heads show, and what only a person can know.

Names show the columns, brackets or a row of units the units, and where they do not, the size of gravity does. Each
guess is said beside the map, and what no file holds (place, mounting, slope) is left to be filled in.
"""

import re
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from stages.biped.accuracy.scales import GRAVITY
from stages.imu.sources.cells import UNITS, counted_on, moments
from stages.imu.sources.formats import ARRAY_FILE, BAG, COLUMNS, IMU, format_of, groups_of, read, topics
from stages.imu.sources.head import APDM, OTHER_UNITS, Head, Maker, head_of, maker_of
from stages.imu.sources.opening import SourceRefused, printable, refuse
from stages.imu.sources.schema import ACCELERATION_UNITS, NANOSECONDS
from stages.imu.sources.text_table import Layout

USUAL_RATES = (10.0, 5000.0)  # Hz
ACCELERATIONS = ("m/s^2", "g", "mg")
STANDING = 0.4  # a moving sensor's median reading is gravity to that share
FASTEST_RAD_S = 35.0  # 2000 deg/s: a gyroscope that reads more does not read rad/s
FASTEST_DEG_S = 4000.0  # the widest range that is sold
TURNS = ("deg/s", "mdps", "rad/s")
FORCES, RATES = ("ax", "ay", "az"), ("gx", "gy", "gz")
LACKS = "not found by name, fill in: "
NO_AXES = LACKS + ", ".join((*FORCES, *RATES))

_FORCE = re.compile(r"acc(?!urac)|specific.?force", re.I)
_RATE = re.compile(r"gyr|angular.?(vel|rate)|omega|rot.*rate", re.I)
_OTHER = re.compile(r"mag|quat|euler|free|lin|user|grav|temp|roll|pitch|yaw", re.I)
_AXIS = re.compile(r"(?:^|[^a-z])([xyz])(?:[^a-z]|$)|(?:acc|gyro?|a|g|w)([xyz])(?:[^a-z]|$)", re.I)
_LETTER = re.compile(r"(?:^|[^a-z])([agw])[\W_]?[xyz](?:[^a-z]|$)", re.I)
_PACKET = re.compile(r"packet|counter|sample.?(number|index|no)|frame(?!.?id)|^seq", re.I)
_STAMP = re.compile(r"time|stamp|epoc|unix|elapsed|clock|date|^t$|^millis|^micros", re.I)
_SECONDS = re.compile(r"[\[(]\s*(s|sec|ms|us|µs|ns)\s*[\])]", re.I)
_NANOSECONDS, _WHOLE_SECONDS = re.compile(r"n(ano)?sec(onds|s)?$", re.I), re.compile(r"(?<![a-z])sec(onds|s)?$", re.I)
_TICKS = re.compile("SampleTimeFine", re.I)  # of a length that only its maker knows
_ARRIVED = re.compile(r"phone|host|receiv|arriv", re.I)
_PLACE = re.compile(r"(?<![a-z])(hip|waist|pelvis|trunk|lumbar|foot|feet|ankle|shoe|toe)(?![a-z])[\W_]?", re.I)
_AT_THE_FOOT = re.compile("foot|feet|ankle|shoe|toe", re.I)
_HZ = re.compile(r"(\d+(?:\.\d+)?)\s*Hz", re.I)


Proposed = tuple[list[str], list[str]]


def proposal(path: Path, gravity: float = GRAVITY) -> tuple[str, list[str]]:
    """The text of a map of a file, or of a folder's files, and a line for each thing that was read, guessed or is to
    be filled in. `gravity` [m/s^2] is that where the measurement was made.

    Files of a folder whose names differ only in a place of the body are the sensors of one run. Raises SourceRefused
    where there is no table, bag or array file with an inertial sensor.
    """
    folder = path.is_dir() and format_of(path) is not BAG
    runs, remarks = (
        _of_folder(path, gravity) if folder else ({_run_of(path): (one := _of_file(path, gravity))[0]}, one[1]))
    whose = "files' heads" if folder else "file's head"
    lines = [f"# Proposed from the {whose}; lines that end in ? are to be filled in or confirmed", "runs:"]
    for name, entries in runs.items():
        lines += [f"  - experiment: {{name: {_quoted(name)}, origin: measured, slope_deg: null}}  # the ramp's slope ?",
                  "    files:", *entries]  # fmt: skip
    to_fill = ["slope_deg", *(["place"] if any(line.endswith("foot ?") for line in lines) else []), "forward_axis"]
    place = shlex.quote(str(path if folder else path.parent))
    return "\n".join(lines) + "\n", [
        *remarks, f"to be filled in: {', '.join(to_fill)} and up_axis; then: bipedstudy ingest {place} --map FILE"]


def proposals(path: Path, gravity: float) -> Iterator[tuple[str, list[str]]]:
    """That alone, as another process hands it over."""
    yield proposal(path, gravity)


def _of_file(path: Path, gravity: float) -> Proposed:
    """Entries and lines for a file. Raises SourceRefused."""
    kind = format_of(path)
    return _of_bag(path) if kind is BAG else (_of_arrays if kind is ARRAY_FILE else _of_table)(path, gravity)


def _of_folder(path: Path, gravity: float) -> tuple[dict[str, list[str]], list[str]]:
    """Entries of each run of a folder's files, and lines for all. Raises SourceRefused if none has a sensor."""
    runs, remarks, left_out, beside = dict[str, list[str]](), list[str](), list[str](), set[Path]()
    for file in sorted(one for one in path.iterdir() if one.is_file()):
        if file in beside:
            continue
        try:
            entries, said = _of_file(file, gravity)
            refuse((NO_AXES in said, f"{printable(file.name)} has no axis of an inertial sensor, by its names: propose "
                                     "it alone to fill its columns in"))  # fmt: skip
        except SourceRefused as refused:
            left_out.append(f"left out: {refused}")
            continue
        other = _gyroscope_beside(file)
        if other is not None and any(other.name in line for line in entries):
            beside.add(other)
        runs.setdefault(_run_of(file), []).extend(entries)
        remarks += [f"{file.name}: {line}" for line in said]
    refuse((not runs, f"{printable(path.name)} has no file with an inertial sensor"
                      + "".join(line.replace("left out", "", 1) for line in left_out[:1])))  # fmt: skip
    return runs, remarks + left_out


def _run_of(path: Path) -> str:
    """The name of the run that a file is of: its own without the place of the body, where it has one."""
    return re.sub(r"[\W_]+$|^[\W_]+", "", _PLACE.sub("", path.stem)) or path.parent.name


def _entry(path: Path, layout: Sequence[str], rate: float, units: tuple[str, str], columns: str) -> list[str]:
    """A file's entry in a map."""
    return [
        f"      - file: {_quoted(path.name)}",
        *layout,
        "        device:",
        f"          place: {_place(path)}",
        f"          rate_hz: {rate:g}  # nominal rate by the data sheet ?",
        f"          accelerometer_unit: {units[0]}",
        f"          gyroscope_unit: {units[1]}",
        "          forward_axis: null  # sensor axis nearest to forward, such as +x ?",
        "          up_axis: null  # sensor axis nearest to up ?",
        f"        columns: {columns}",
    ]


def _place(path: Path) -> str:
    """The place of a sensor by the name of its file; else one of them, to be confirmed."""
    named = _PLACE.search(path.stem)
    return "hip  # or foot ?" if named is None else "foot" if _AT_THE_FOOT.search(named[0]) else "hip"


def _of_table(path: Path, gravity: float) -> Proposed:
    """Entries and lines for a text table, a spreadsheet or a parquet file."""
    head = head_of(path)
    maker = maker_of(head.names, head.before)
    columns = columns_of(head, maker=maker)
    rate, said = _rate(head, columns)
    force, rates = (_unit(head, columns, kind, maker, gravity) for kind in ("a", "g"))
    missing = [name for name in (*FORCES, *RATES) if name not in columns]
    lacks = f"{LACKS}{', '.join(missing)}" if missing else ""
    remarks = list(filter(None, (*_layout_remarks(head, maker), said, force[1], rates[1], lacks,
                                  _left_out(head, columns))))  # fmt: skip
    beside = _gyroscope_beside(path) if tuple(missing) == RATES else None
    other = head if beside is None else head_of(beside)
    found = {} if beside is None else columns_of(other, "g", maker)
    if beside is not None and not rates[0]:
        rates = _unit(other, found, "g", maker, gravity)
        remarks.append(rates[1])
    own = columns.pop("gyroscope's stamp", None)
    if _stands_twice(head, columns):
        head = replace(head, names=(), header_rows=head.header_rows + 1 + bool(head.units))
        remarks.append("names stand there more than once: columns are called by number")
    if own is not None:
        beside, other = path, head
        found = {"device_stamp": own, **{name: columns.pop(name) for name in RATES}}
    entries = _entry(path, _layout(head, 8), rate, (force[0], rates[0] or "deg/s"), _columns(head, columns))
    if beside is not None:
        remarks.append("the gyroscope has times of its own" if own is not None
                    else f"the gyroscope's file beside it: {beside.name}")  # fmt: skip
        entries += ["        gyroscope:", f"          file: {_quoted(beside.name)}", *_layout(other, 10),
                    f"          columns: {_columns(other, found)}"]  # fmt: skip
    return entries, remarks


def _left_out(head: Head, columns: dict[str, int]) -> str:
    """That other columns are named as axes too; empty where none is."""
    alike = [printable(name) for column, name in enumerate(head.names) if column not in columns.values()
             and _value_named(head, column, "", False) in (*FORCES, *RATES)]  # fmt: skip
    return f"left out, as another sensor's or the same in another unit: {', '.join(alike)}" if alike else ""


def _stands_twice(head: Head, columns: dict[str, int]) -> bool:
    """Whether a name of one of these columns is another column's as well."""
    names = list(head.names)
    return any(names.count(names[column]) > 1 for column in columns.values() if names)


def _layout_remarks(head: Head, maker: Maker | None) -> list[str]:
    """Lines on how a table is laid out, and by which maker."""
    layout = [
        f"{head.delimiter}-separated" if head.delimiter else "",
        f"{head.header_rows} rows before the names",
        "decimal comma" if head.decimal_comma else "",
        "" if head.names else "no names: columns are called by number",
        f"sheet {head.sheet!r}" if head.sheet else "",
    ]
    note = f": {maker.note}" if maker and maker.note else ""
    return [", ".join(filter(None, layout)), *([f"names as {maker.name} writes them{note}"] if maker else [])]


def _of_bag(path: Path) -> Proposed:
    """Entries and lines for a bag of ROS or an MCAP file: one a topic of an inertial sensor."""
    entries, remarks = [], []
    for topic, count in topics(path):
        name = f"{topic}:stamp"
        rate, said = _rate_of(read(path, Layout(), [name], ())[name], ("s",), name)
        columns = {value: f"{topic}:{field}" for value, field in COLUMNS.items()}
        entries += _entry(path, (), rate, ("m/s^2", "rad/s"), _mapped(columns))
        remarks += [f"{topic}: {count} messages of {IMU}, m/s^2 and rad/s by its definition", said]
    refuse((not entries, f"{printable(path.name)} has no topic of {IMU}"))
    return entries, remarks


def _of_arrays(path: Path, gravity: float) -> Proposed:
    """Entries and lines for an HDF5 or MATLAB file: one a group with an accelerometer's and a gyroscope's array."""
    entries, remarks = [], []
    for group, names in groups_of(path).items():
        force, rates, time = (next(filter(pattern.search, names), "") for pattern in (_FORCE, _RATE, _STAMP))
        inside = f"{group}/" if group else ""
        found = {"device_stamp": f"{inside}{time}"} if time else {}
        found |= {f"{kind}{axis}": f"{inside}{name}[{i}]" for kind, name in (("a", force), ("g", rates))
                  for i, axis in enumerate("xyz", 1)}  # fmt: skip
        arrays = _arrays_of(path, list(found.values())) if force and rates else {}
        if not arrays:
            continue
        rate, said = _rate_of(arrays.get(found.get("device_stamp", ""), np.empty(0)), tuple(UNITS), time or "no stamps")
        kinds = (np.column_stack([arrays[found[name]] for name in kind]) for kind in (FORCES, RATES))
        of_force, of_rate = (_unit_by_size(values, kind, gravity) for values, kind in zip(kinds, "ag"))
        entries += _entry(path, (), rate, (of_force[0], of_rate[0]), _mapped(found))
        remarks += [f"{group or 'arrays'}: {force} and {rates}, as {APDM} has them", of_force[1], of_rate[1], said]
    refuse((
        not entries, f"{printable(path.name)} has no group with an accelerometer's and a gyroscope's array"
    ))
    return entries, remarks


def _arrays_of(path: Path, wanted: Sequence[str]) -> dict[str, np.ndarray]:
    """These columns, or none where arrays are not three columns as long as the others."""
    try:
        return dict(read(path, Layout(), wanted, ()))
    except SourceRefused:
        return {}


def columns_of(head: Head, alone: str = "a", maker: Maker | None = None) -> dict[str, int]:
    """Column by value of table `sample`, as the names show; axes without a kind are those of `alone` ("a" or "g").

    What the maker names in words of its own comes first, axes without a kind last.
    """
    names, own = list(head.names), maker.columns if maker else {}
    times = [column for column in range(len(names)) if _holds_times(head, column)]
    places = [(value, column) for value, pattern in own.items() for column, name in enumerate(names)
              if re.search(pattern, name, re.I)]  # fmt: skip
    places += [(_value_named(head, column, kind, column in times), column)
               for kind in ("", alone) for column in range(len(names))]  # fmt: skip
    found: dict[str, int] = {}
    for value, column in places:
        found.setdefault(value, column)
    found.pop("", None)
    beside = {kind: found[f"{kind}x"] - 1 for kind in "ag" if found.get(f"{kind}x", 0) - 1 in times}
    if "a" in beside and "device_stamp" not in own:
        if not _ARRIVED.search(head.name(beside["a"])):
            found["device_stamp"] = beside["a"]  # of several times the one that stands with the accelerometer
        first, last = (_stamps(head, beside.get(kind, beside["a"])) for kind in "ag")
        if not np.array_equal(first, last, equal_nan=True):
            found["gyroscope's stamp"] = beside["g"]
    return found | _in_two_columns(names)


def _in_two_columns(names: Sequence[str]) -> dict[str, int]:
    """A stamp of seconds with nanoseconds beside them, if there is one."""
    return next(({"device_stamp": column, NANOSECONDS: column + 1} for column, pair in enumerate(pairwise(names))
                 if _WHOLE_SECONDS.search(pair[0]) and _NANOSECONDS.search(pair[1])), {})  # fmt: skip


def _holds_times(head: Head, column: int) -> bool:
    """Whether a column is one of times by its name, and most of what it holds."""
    name = head.name(column)
    named = (_STAMP.search(name) or _SECONDS.search(name)) and not _TICKS.search(name)
    filled = np.mean([bool(cell.strip()) for cell in head.texts(column)]) if head.rows else 0.0
    return bool(named) and bool(np.isfinite(_stamps(head, column)).mean() > 0.5 * filled)


def _value_named(head: Head, column: int, alone: str, is_time: bool) -> str:
    """Which value of table `sample` a column's name shows, such as "ax"; empty for none."""
    name = head.name(column)
    if is_time:
        return "phone_stamp" if _ARRIVED.search(name) else "device_stamp"
    axis = _AXIS.search(name)
    if not axis or _OTHER.search(name):
        return "packet" if _PACKET.search(name) else ""
    kind = _kind_named(head, column, name) or alone
    return f"{kind}{(axis[1] or axis[2]).lower()}" if kind else ""


def _kind_named(head: Head, column: int, name: str) -> str:
    """"a" of an acceleration, "g" of an angular rate: by its words, its unit or its letter; empty where none says."""
    letter = _LETTER.search(name)
    shown = (("a", _FORCE.search(name)), ("g", _RATE.search(name)), ("a", head.stated_unit(column, ACCELERATIONS)),
             ("g", head.stated_unit(column, TURNS)), ("a", letter and letter[1] in "aA"), ("g", letter))
    return next((kind for kind, said in shown if said), "")


def _stamps(head: Head, column: int) -> np.ndarray:
    values = head.values(column)
    return values if np.isfinite(values).any() else moments(head.texts(column))


def _rate(head: Head, columns: dict[str, int]) -> tuple[float, str]:
    """The sampling rate [Hz], and where it comes from: what is written, or the first column of stamps."""
    stamp = next((column for value, column in columns.items() if value.endswith("_stamp")), None)
    written = _HZ.search(head.before)
    if written:
        return float(written[1]), f"rate {written[1]} Hz: written above the names"
    if stamp is None:
        return 100.0, "no stamps: the rate of 100 Hz is a guess"
    said, stamps = head.stated_unit(stamp, tuple(UNITS)), _stamps(head, stamp)
    if NANOSECONDS in columns:
        said, stamps = "s", stamps + 1e-9 * head.values(columns[NANOSECONDS])
    return _rate_of(stamps, (said,) if said else tuple(UNITS), head.name(stamp))


def _rate_of(stamps: np.ndarray, units: Sequence[str], name: str) -> tuple[float, str]:
    """The rate [Hz] at which a column of stamps (n,) advances in the first of the units in which it is a usual one.

    It is the median's over eighths of it, from packet to packet, so that a gap does not make the sensor slower.
    """
    values = counted_on(stamps)[np.isfinite(stamps)]
    begins = np.flatnonzero(np.diff(values, prepend=-np.inf))  # of packets, whose samples share a stamp
    far = max(len(begins) // 8, 1)
    last, first = begins[far:], begins[:-far]
    step = float(np.median((values[last] - values[first]) / (last - first))) if len(last) else 0.0
    for unit in units:
        rate = 1 / (step * UNITS[unit]) if step > 0 else 0.0
        if USUAL_RATES[0] <= rate <= USUAL_RATES[1]:
            return float(f"{rate:.3g}"), f"rate {rate:.4g} Hz: column {name!r} advances so, in {unit}"
    return 100.0, f"column {name!r} advances at no usual rate: 100 Hz is a guess"


def _unit(
    head: Head, columns: dict[str, int], kind: str, maker: Maker | None, gravity: float
) -> tuple[str, str]:
    """Unit of acceleration ("a") or angular rate ("g"), and where it comes from; empty where there is no column."""
    mine = [columns[f"{kind}{axis}"] for axis in "xyz" if f"{kind}{axis}" in columns]
    what, known = ("acceleration", ACCELERATIONS) if kind == "a" else ("angular rate", TURNS)
    if not mine:
        return ("m/s^2", "no accelerometer found") if kind == "a" else ("", "")
    refuse((
        any(map(OTHER_UNITS.search, head.stated(mine[0]))),
        f"the column {printable(head.name(mine[0]))} is in a unit that is not read: bring it to "
        f"{', '.join(known[:-1])} or {known[-1]}",
    ))
    said = head.stated_unit(mine[0], known)
    if said:
        return said, f"{what} in {said}: written in the file"
    if maker is not None:
        unit = maker.acceleration if kind == "a" else maker.rate
        return unit, f"{what} in {unit}: {maker.name} has it so"
    return _unit_by_size(np.column_stack([head.values(column) for column in mine]), kind, gravity)


def _unit_by_size(values: np.ndarray, kind: str, gravity: float) -> tuple[str, str]:
    """The same from the readings (n, k) alone."""
    what, size = "acceleration" if kind == "a" else "angular rate", np.linalg.norm(values, axis=1)
    size = size[np.isfinite(size)]
    if kind == "g":
        largest = float(size.max(initial=0.0))
        unit = "rad/s" if largest <= FASTEST_RAD_S else "deg/s" if largest <= FASTEST_DEG_S else "mdps"
        return unit, f"{what} in {unit}: a guess by its size"
    usual = float(np.median(size)) if len(size) else 0.0
    for unit in ACCELERATIONS:
        if abs(usual * (ACCELERATION_UNITS[unit] or 0.0) / gravity - 1) < STANDING:
            return unit, f"{what} in {unit}: gravity reads {usual:.4g}"
    return "counts", f"{what} in counts: gravity reads {usual:.4g}; add accelerometer_range_g and bits"


def _gyroscope_beside(path: Path) -> Path | None:
    """The gyroscope's file of the same recording, by its name."""
    for here, there in (("acc", "gyr"), ("Acc", "Gyr"), ("ACC", "GYR")):
        pattern = re.sub(re.escape(here) + r"\w*", there + "*", path.name, count=1)
        match = next((one for one in sorted(path.parent.glob(pattern)) if one != path), None)
        if pattern != path.name and match is not None:
            return match
    others = [one for one in sorted(path.parent.iterdir()) if re.search("gyr", one.name, re.I) and one != path]
    return others[0] if len(others) == 1 and others[0].suffix == path.suffix else None


def _layout(head: Head, indent: int) -> list[str]:
    lines = (
        f"delimiter: {head.delimiter}" if head.delimiter else "",
        f"header_rows: {head.header_rows}",
        f"sheet: {_quoted(head.sheet)}" if head.sheet else "",
        "" if head.names else "header: false",
        "decimal: comma" if head.decimal_comma else "",
    )
    return [" " * indent + line for line in lines if line]


def _columns(head: Head, columns: dict[str, int]) -> str:
    return _mapped({value: head.name(column) for value, column in columns.items()})


def _mapped(columns: dict[str, str]) -> str:
    return "{" + ", ".join(f"{value}: {_quoted(name)}" for value, name in columns.items()) + "}"


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
