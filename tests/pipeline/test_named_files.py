"""Files that a parameter names are inputs like any other: their content decides what is current."""

import contextlib
import hashlib
import os
import shutil
import stat
from pathlib import Path

import pytest

from pipeline.cache import disk
from pipeline.errors import StudyError


def test_the_content_of_a_named_file_decides(toy):
    table, setting = toy.root / "lab.txt", "side.table=lab.txt"
    table.write_text("41")
    assert toy.outcomes(setting, names=("side",))[0].summary == "number 41"
    assert toy.run(setting, names=("side",)) == {"side": "current"}
    table.write_text("42")
    again = toy.outcomes(setting, names=("side",))[0]
    assert (again.how, again.summary, again.reasons) == ("computed", "number 42", ("input table changed",))
    table.write_text("41")
    assert toy.run(setting, names=("side",)) == {"side": "restored"}
    assert toy.run(names=("side",)) == {"side": "computed"}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
@pytest.mark.parametrize(("name", "said"), [
    ("lab.txt", r'side.yaml: table = "lab.txt": there is no such file'), (".", "is a folder, not a file"),
    ('"a\\0b"', "no file can have this name"), ("pipe", "is a pipe, device or socket, not a file"),
    ("/dev/zero", "is a pipe, device or socket, not a file"),
])  # fmt: skip
def test_what_is_no_file_is_refused_at_once_by_its_name(toy, name, said):
    os.mkfifo(toy.root / "pipe")
    toy.fails(f"side.table={name}", names=("side",), said=said)


def test_a_large_file_changed_in_place_with_its_time_kept_is_seen(tmp_path):
    file = tmp_path / "large"
    file.write_bytes(b"one")
    before = file.stat()
    first = disk.checked_digest(file, "large")
    with file.open("r+b") as opened:
        opened.write(b"two")
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert disk.checked_digest(file, "large") == hashlib.sha256(b"two").hexdigest() != first


@pytest.mark.skipif(not Path("/proc/self/mem").exists(), reason="needs a file that cannot be read at its beginning")
@pytest.mark.parametrize("read", [disk.read, disk.file_digest])
def test_an_error_of_reading_names_the_file(read):
    with pytest.raises(OSError, match="Input/output error: '/proc/self/mem'"):
        read(Path("/proc/self/mem"))


@pytest.fixture
def no_files(tmp_path):
    """A pipe, a link to it and, where this user may make one, a device; named as a table, picture and page may be."""
    (folder := tmp_path / "apart").mkdir()
    pipe, link, device = folder / "pipe.png", folder / "link.png", folder / "device.png"
    os.mkfifo(pipe)
    link.symlink_to(pipe)
    with contextlib.suppress(PermissionError):
        os.mknod(device, stat.S_IFCHR | 0o600, os.makedev(1, 3))
    return [path for path in (pipe, link, device) if path.exists()]


def test_a_link_to_a_file_is_replaced_as_ever_and_a_file_is_no_folder(tmp_path):
    (tmp_path / "file").write_text("kept")
    (tmp_path / "link").symlink_to("file")
    with pytest.raises(StudyError, match="file: is not a folder, so no file is written there"):
        disk.replaceable(tmp_path / "file/below")
    disk.write(disk.replaceable(tmp_path / "link"), b"new")
    assert not (tmp_path / "link").is_symlink()
    assert [(tmp_path / name).read_text() for name in ("file", "link")] == ["kept", "new"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_every_command_that_writes_a_named_file_refuses_a_pipe_or_a_device(ran, no_files):
    (ran.root / "points.yaml").write_text("stage: fall\nkind: grid\nvary: {fall.steps: [2, 5]}\n")
    shutil.copytree(ran.root / "results", ran.root / "before")
    words = "report --into", "compare before --page", "tally --figure", "claims --into", "sweep points.yaml --out"
    for typed, (code, _, errors) in ran.answers(*(f"{each} {path}" for each in words for path in no_files)).items():
        assert code == 2 and "is a pipe, device or socket" in errors and errors.count("error:") == 1, (typed, errors)
    assert not any(stat.S_ISREG(path.lstat().st_mode) for path in no_files)
    assert sorted(no_files) == sorted(no_files[0].parent.iterdir()), "nothing half-written beside it"
