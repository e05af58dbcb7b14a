"""The process that reads files from outside: what it cannot do, what it may take, and what it says of both."""

import contextlib
import os
import signal
import socket
import sqlite3
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import numpy as np
import pytest

from pipeline.commands.house import confined
from pipeline.errors import StudyError
from pipeline.room import confine, reading
from pipeline.room.reading import Limits, read

linux = pytest.mark.skipif(sys.platform != "linux", reason="Landlock and seccomp are Linux's")


@pytest.fixture(params=["forked", "afresh"])
def begun(request, monkeypatch):
    """Both ways in which the process begins."""
    if request.param == "forked" and not reading.FORKED:
        pytest.skip("processes are not forked here")
    monkeypatch.setattr(reading, "FORKED", request.param == "forked")
    return request.param


@pytest.fixture
def source(tmp_path):
    (tmp_path / "beside").write_text("a secret")
    (tmp_path / "log").write_text("said")
    return tmp_path / "log"


def kinds(source, *given):
    """A reader of all that can be handed over; what it prints is no part of that."""
    os.write(1, b"as a library does")
    yield {"text": source.read_text(), "given": given, "rows": np.arange(6.0).reshape(2, 3), "none": np.empty((0, 2))}
    yield [1, None, float("nan"), {"deep": (np.array([1, 2], dtype="i2"), np.array(True), np.array([True, False]))}]


def test_what_a_reader_yields_comes_back_as_it_was(source, begun):
    first, (one, none, nan, deep) = read(kinds, source, 1, "x")
    assert first["text"] == "said" and first["given"] == [1, "x"] and first["none"].shape == (0, 2)
    np.testing.assert_array_equal(first["rows"], np.arange(6.0).reshape(2, 3))
    assert (one, none, nan != nan) == (1, None, True)
    assert deep["deep"][0].dtype == "i2" and deep["deep"][1].shape == () and bool(deep["deep"][2][0])


def test_a_source_without_a_name_is_read_by_its_own(source, begun, monkeypatch):
    monkeypatch.chdir(source.parent)
    with pytest.raises(StudyError, match=f"^'{source.parent.name}' cannot be read .IsADirectoryError"):
        [*read(kinds, Path())]


def attempts(source, place, port):
    """A reader that tries what it must not: the name of each that succeeds."""
    tries = {
        "read": lambda: Path(place, "beside").read_text(), "list": lambda: [*Path(place).iterdir()],
        "write": lambda: Path(place, "new").write_text("x"), "change": lambda: source.write_text("x"),
        "remove": lambda: source.unlink(), "home": lambda: [*Path.home().iterdir()],
        "passwords": lambda: Path("/etc/passwd").read_text(), "run": lambda: os.posix_spawn("/bin/echo", ["echo"], {}),
        "tcp": lambda: socket.create_connection(("127.0.0.1", port), 1),
        "udp": lambda: socket.socket(type=socket.SOCK_DGRAM), "local": lambda: socket.socket(socket.AF_UNIX),
        "url": lambda: urllib.request.urlopen(f"http://127.0.0.1:{port}"),
        "debug": lambda: confine._libc().ptrace(16, os.getppid(), 0, 0) and (_ for _ in ()).throw(PermissionError),
    }  # fmt: skip
    done = []
    for name, attempt in tries.items():
        with contextlib.suppress(OSError):
            attempt()
            done.append(name)
    yield done


def attempted(source):
    """What a reader in the room succeeds in."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        (done,) = read(attempts, source, str(source.parent), server.getsockname()[1])
    return {*done}


@linux
def test_the_process_is_confined(source, begun):
    """It tries a neighbour's file, a socket and more: none of it succeeds, or the room is none."""
    assert attempted(source) == set()
    assert source.read_text() == "said" and not (source.parent / "new").exists()
    assert {state for _, state, _ in confined()} == {"good"}


@linux
def test_a_python_of_the_systems_own_lies_beside_all_programs_and_starts_none(source, monkeypatch):
    beneath = confine.of_python() | {Path("/usr")}
    monkeypatch.setattr(confine, "of_python", lambda: beneath)
    assert attempted(source) == set()


@linux
def test_without_landlock_the_rest_holds_and_it_is_said(source, monkeypatch):
    monkeypatch.setattr(confine, "landlock", lambda: 0)
    done = attempted(source)
    assert {"read", "list"} <= done and not {"write", "change", "tcp", "udp", "local", "url", "debug"} & done
    (_, state, text), stages = confined()
    assert state == "warning" and "files: not confined; sockets: seccomp; memory: limit" in text
    assert stages == ("stages", "warning", "files: not confined; sockets: seccomp")


@linux
def test_without_seccomp_there_is_no_tcp_and_it_is_said(source, monkeypatch):
    if confine.landlock() < 4:
        pytest.skip("this Landlock knows no TCP")
    monkeypatch.setattr(confine, "_without_sockets", lambda: False)
    done = attempted(source)
    assert {"udp", "local"} <= done and not {"tcp", "url", "read", "write", "passwords"} & done
    assert all("sockets: not confined" in said and state == "warning" for _, state, said in confined())


def spinning(source):
    yield os.getpid()
    while True:
        pass


def sleeping(source):
    yield time.sleep(1000)


def hungry(source):
    yield len(bytearray(2_000_000_000))


def hungry_beneath(source):
    """As a library says that something is wrong, whatever it is."""
    try:
        yield len(bytearray(2_000_000_000))
    except MemoryError:
        raise ValueError("is broken") from None


def long(source):
    yield np.zeros(Limits(4).rows + 1, dtype="i1")


def many(source):
    while True:
        yield np.zeros((1000, 10_000))


def crashing(source):
    os.kill(os.getpid(), signal.SIGSEGV)
    yield


def wrong(source):
    raise KeyError("a key")
    yield


@pytest.mark.parametrize(("reader", "says"), [
    (spinning, "takes more than 1.0 s of processor time to read, the limit for"),
    (hungry, "takes more than 768 MB of memory to read, the limit for"),
    (hungry_beneath, "takes more than 768 MB of memory to read, the limit for"),
    (long, "has a table of more than 1000004 rows, the limit for"),
    (many, "unpacks to more than 768 MB, the limit for"),
    (crashing, "its reader ended by itself (SIGSEGV)"), (wrong, "cannot be read (KeyError: 'a key')"),
], ids=lambda each: getattr(each, "__name__", ""))  # fmt: skip
@linux
def test_each_limit_ends_it_by_name(reader, says, source, monkeypatch):
    monkeypatch.setattr(Limits, "seconds", 1.0)
    if reader in (hungry, hungry_beneath, many):
        monkeypatch.setattr(Limits, "seconds", 5.0)
    with pytest.raises(StudyError) as refused:
        list(read(reader, source))
    (sentence,) = refused.value.sentences
    assert sentence.startswith("'log' ") and says in sentence and "\n" not in sentence


def test_where_the_system_has_no_limits_the_clock_ends_it(source, monkeypatch):
    """A process that only waits needs no processor, and so does one on a system without limits."""
    monkeypatch.setattr(confine, "_limit", lambda *limits: None)
    monkeypatch.setattr(Limits, "seconds", 0.05)
    for reader in (spinning, sleeping):
        began = time.monotonic()
        with pytest.raises(StudyError, match=r"takes more than 1.5 s by the clock"):
            list(read(reader, source))
        assert time.monotonic() - began < 10
    assert "memory: bounded by the size of the answer alone; time: ended by the clock" in next(confined())[2]


def rows(source):
    """What a database shows a reader."""
    with contextlib.closing(sqlite3.connect(f"{source.as_uri()}?mode=ro", uri=True, timeout=1)) as connection:
        yield [row[0] for row in connection.execute("SELECT value FROM sample")]


WRITER = """
import sqlite3, sys
writer = sqlite3.connect(sys.argv[1])
writer.execute(f"PRAGMA journal_mode = {sys.argv[2]}")
writer.execute("CREATE TABLE sample (value)")
writer.execute("INSERT INTO sample VALUES (1)")
writer.commit()
writer.execute("INSERT INTO sample VALUES (2)")
print("written", flush=True)
input()
writer.commit()
print("written", flush=True)
input()
"""


@pytest.mark.parametrize(("mode", "name", "begun"), [
    ("DELETE", "log.sqlite", "forked"), ("WAL", "by a link.sqlite", "forked"), ("WAL", "log.sqlite", "afresh"),
], indirect=["begun"])  # fmt: skip
def test_a_database_is_read_while_it_is_written(mode, name, tmp_path, begun):
    """With its journal, or its log and the index of that: what is committed is seen, and what is not is not."""
    (tmp_path / "kept").mkdir()
    path = tmp_path / "kept/log.sqlite"
    (tmp_path / "by a link.sqlite").symlink_to(path)
    named = path if name == path.name else tmp_path / name
    command = [sys.executable, "-c", WRITER, str(path), mode]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as writer:
        writer.stdout.readline()
        beside = {each.name: each.read_bytes() for each in path.parent.iterdir() if not each.name.endswith("shm")}
        assert len(beside) == 2
        assert [*read(rows, named)] == [[1]]
        assert {each: (path.parent / each).read_bytes() for each in beside} == beside
        print(file=writer.stdin, flush=True)
        writer.stdout.readline()
        assert [*read(rows, named)] == [[1, 2]]
        print(file=writer.stdin, flush=True)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
@pytest.mark.parametrize("place", ["pipe", "pipe/log", "link", "device", "missing", "file/log"])
def test_pipes_and_devices_are_refused_wherever_they_stand_in_a_path(place, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    (tmp_path / "device").symlink_to("/dev/zero")
    (tmp_path / "file").touch()
    says = {"missing": "No such file", "file/log": "Not a directory"}.get(place, "is a pipe, device or socket, not")
    with pytest.raises(StudyError, match=says):
        list(read(kinds, tmp_path / place))


@linux
def test_a_reader_that_is_left_is_ended(source):
    found = read(spinning, source)
    process = next(found)
    os.kill(process, 0)
    found.close()
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)
