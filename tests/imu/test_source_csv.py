"""CSV sources: what the column map may say, and what is said back."""

import functools
import operator
import os
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stages.imu.sources.column_map import CsvSource
from stages.imu.sources.opening import SourceRefused

TEXT = "made by a device\nN;X;Y;Z;P;Q;R\n1;0;0;9.81;0.1;0;0\n2;0;;9.8;0;0;0\n\n4;0;0;abc;0;0\n"
DESCRIPTION: dict[str, Any] = {
    "experiment": {"name": "one", "slope_deg": 2},
    "files": [
        {
            "file": "one.csv",
            "delimiter": "semicolon",
            "header_rows": 1,
            "device": {"place": "hip", "rate_hz": 100, "accelerometer_unit": "m/s2", "gyroscope_unit": "rad/s"},
            "columns": {"packet": "N", "ax": "X", "ay": "Y", "az": "Z", "gx": "P", "gy": "Q", "gz": "R"},
        }
    ],
}


def test_cells_become_numbers_or_nothing(tmp_path: Path) -> None:
    (tmp_path / "one.csv").write_text(TEXT)
    ((experiment, (recording,)),) = CsvSource(DESCRIPTION, tmp_path).runs()
    assert experiment.slope_deg == 2
    assert recording.packet.tolist() == [1, 2, 4]
    np.testing.assert_array_equal(recording.acceleration[:, 1:], [[0, 9.81], [np.nan, 9.8], [0, np.nan]])
    assert np.isnan(recording.angular_rate[2, 2]) and np.isnan(recording.phone_stamp).all()


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("files",), [], "list of files"),
        (("files",), "one.csv", "list of files"),
        (("files", 0, "file"), "two.csv", "cannot be read"),
        (("files", 0, "file"), 7, "name of a file"),
        (("files", 0, "delimiter"), "pipe", "delimiter"),
        (("files", 0, "header_rows"), -1, "header_rows"),
        (("files", 0, "surprise"), 1, "unknown key 'surprise'"),
        (("files", 0, "device"), None, "mapping"),
        (("files", 0, "device", "rate_hz"), "fast", "rate_hz"),
        (("files", 0, "device", "accelerometer_unit"), "furlong", "accelerometer_unit"),
        (("files", 0, "columns"), {"ax": "X"}, "columns lack ay"),
        (("files", 0, "columns", "az"), "W", "no column 'W'"),
        (("files", 0, "columns", "blood"), "W", "unknown key 'blood'"),
    ],
)
def test_what_is_wrong_is_named(path: tuple, value: object, words: str, tmp_path: Path) -> None:
    (tmp_path / "one.csv").write_text(TEXT)
    description = deepcopy(DESCRIPTION)
    functools.reduce(operator.getitem, path[:-1], description)[path[-1]] = value
    with pytest.raises(SourceRefused, match=words):
        list(CsvSource(description, tmp_path).runs())


@pytest.mark.parametrize("content", [b"", b"\x00" * 100, b"\xff\xfe\x00N;X", b'"' * 200_000, b"N;N;X;Y;Z;P;Q;R\n"])
def test_no_table(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "one.csv").write_bytes(content)
    with pytest.raises(SourceRefused):
        list(CsvSource(DESCRIPTION, tmp_path).runs())


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
@pytest.mark.parametrize(("kind", "words"), [
    ("pipe", "a pipe, device or socket, not a file"), ("device", "a pipe, device or socket, not a file"),
    ("sparse", "a line of more than 1,000,000 characters"),
])  # fmt: skip
def test_a_pipe_a_device_and_a_sparse_file_are_refused_at_once(kind: str, words: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "device").symlink_to("/dev/zero")
    with open(tmp_path / "sparse", "wb") as file:
        file.truncate(50_000_000_000)
    (tmp_path / kind).rename(tmp_path / "one.csv")
    with pytest.raises(SourceRefused, match=words):
        list(CsvSource(DESCRIPTION, tmp_path).runs())


def test_several_experiments_in_one_description(tmp_path: Path) -> None:
    (tmp_path / "one.csv").write_text(TEXT)
    second = deepcopy(DESCRIPTION) | {"experiment": {"name": "two"}}
    source = CsvSource({"runs": [DESCRIPTION, second]}, tmp_path)
    assert [(experiment.name, len(recordings)) for experiment, recordings in source.runs()] == [("one", 1), ("two", 1)]
    for wrong in ([], "one", [3], [DESCRIPTION | {"blood": 1}]):
        with pytest.raises(SourceRefused):
            CsvSource({"runs": wrong}, tmp_path)


@pytest.mark.parametrize("name", ["x' OR 1 -- DROP TABLE sample", "\x1b[31m", "💥", "%s{0}", "a\tb"])
def test_hostile_column_names_are_names(name: str, tmp_path: Path) -> None:
    """They are found where they are, shown harmlessly where they are not, and the files stay as they were."""
    content = TEXT.replace("Z;P", f"{name};P").encode()
    (tmp_path / "one.csv").write_bytes(content)
    description = deepcopy(DESCRIPTION)
    description["files"][0]["columns"]["az"] = name
    ((_, (recording,)),) = CsvSource(description, tmp_path).runs()
    assert recording.acceleration[0, 2] == 9.81
    (tmp_path / "one.csv").write_text(TEXT)
    with pytest.raises(SourceRefused) as refused:
        list(CsvSource(description, tmp_path).runs())
    assert str(refused.value).isprintable()
    assert (tmp_path / "one.csv").read_text() == TEXT
    assert [child.name for child in tmp_path.iterdir()] == ["one.csv"]
