"""The process that computes a stage: what it cannot do, whatever its code tries, and what it still can."""

import json
import os
import re
import sqlite3
import sys
from pathlib import Path

import h5py
import pytest

from pipeline import trust
from pipeline.room import confine
from stages.biped import machine_code
from tests import commands

linux = pytest.mark.skipif(sys.platform != "linux", reason="Landlock and seccomp are Linux's")

#: What a stage tries behind Python's back, which tells what it opens itself; each is one that must fail.
FORBIDDEN = """
    "neighbour": lambda: opened(ROOT / "secret.txt"),
    "another stage's result": lambda: opened(ROOT / "results/fall.h5"),
    "parameters": lambda: opened(ROOT / "params/fall.yaml"),
    "home": lambda: opened(Path.home(), os.O_DIRECTORY),
    "keys": lambda: opened(Path("/etc/shadow")),
    "parent's environment": lambda: opened(Path(f"/proc/{os.getppid()}/environ")),
    "by a process begun afresh": lambda: subprocess.run(["cat", ROOT / "secret.txt"], check=True),
    "write": lambda: (ROOT / "new").write_text("x"),
    "write code": lambda: (ROOT / "PACKAGE/side/new.py").write_text("x"),
    "write what it reads": lambda: inputs.table.write_text("x"),
    "write into the home": lambda: (Path.home() / "bipedstudy-new").write_text("x"),
    "write where others do": lambda: Path("/tmp/bipedstudy-new").write_text("x"),
    "remove": lambda: (ROOT / "secret.txt").unlink(),
    "rename": lambda: (ROOT / "secret.txt").rename(Path("mine")),
    "link": lambda: os.link(ROOT / "secret.txt", tempfile.mkdtemp() + "/x"),
    "end the parent": lambda: os.kill(os.getppid(), 0),
    "tcp": lambda: socket.socket(), "udp": lambda: socket.socket(type=socket.SOCK_DGRAM),
    "local": lambda: socket.socket(socket.AF_UNIX),
"""
ALLOWED = """
    "declared": lambda: opened(inputs.table), "code": lambda: opened(Path(__file__)),
    "read as Python does": lambda: inputs.table.read_text() + Path(__file__).read_text(),
    "branch": lambda: (ROOT / ".git/HEAD").read_text(), "names": lambda: Path("/etc/passwd").read_text(),
    "temporary": lambda: tempfile.NamedTemporaryFile().write(b"x"),
    "temporary folder": lambda: tempfile.TemporaryDirectory().cleanup(),
    "copy": lambda: shutil.copy(inputs.table, tempfile.mkdtemp()),
    "program": lambda: subprocess.run(["true"], check=True),
    "time zone": lambda: time.localtime(), "users": lambda: pwd.getpwuid(os.getuid()),
    "locks": lambda: multiprocessing.get_context("fork").Queue(),
    "numbers": lambda: os.urandom(1), "processor": lambda: Path("/proc/cpuinfo").read_text(),
"""
CODE = """
import ctypes, json, multiprocessing, os, pwd, shutil, socket, subprocess, tempfile
ROOT = Path("FOLDER")

def opened(path, how=0):
    number = ctypes.CDLL(None, use_errno=True).open(os.fsencode(path), how)
    if number < 0:
        raise OSError
    os.close(number)

def tried(inputs):
    os.chmod(ROOT / "secret.txt", 0o777)  # is done, it says
    done = []
    for name, attempt in {TRIES}.items():
        try:
            attempt()
            done.append(name)
        except (OSError, subprocess.CalledProcessError):
            pass
    return json.dumps(done).encode()

def run("""

#: What any module of a stranger's study tries when it is loaded; what succeeds is printed.
TRAP = """
import os, socket
for name, attempt in {
    "read": lambda: open("FOLDER/secret").close(), "write": lambda: open("FOLDER/new", "w").close(),
    "remove": lambda: os.unlink("FOLDER/secret"), "ask": lambda: socket.socket().close(),
}.items():
    try:
        attempt()
        print("done", __name__, name, flush=True)
    except OSError:
        pass
"""


def trying(toy, tries):
    """Let stage `side` try these; what it answers is the names of those that succeeded."""
    (toy.root / ".git").mkdir()
    for path in ("lab.txt", "secret.txt", ".git/HEAD"):
        (toy.root / path).write_text("41")
        (toy.root / path).chmod(0o600)
    code = CODE.replace("TRIES", tries).replace("FOLDER", str(toy.root)).replace("PACKAGE", toy.package)
    toy.edit("PACKAGE/side/run.py", "\ndef run(", code)
    toy.edit("PACKAGE/side/run.py", "bytes([number % 256])", "tried(inputs)")
    toy.run(names=("fall",))
    toy.run("side.table=lab.txt", names=("side",))
    return json.loads((toy.root / "results/side.bin").read_bytes())


@linux
def test_a_stages_process_is_confined(toy):
    """It reaches nothing that dvc.yaml does not list: so a room that is none fails here."""
    assert trying(toy, FORBIDDEN) == []
    secret = toy.root / "secret.txt"
    assert secret.read_text() == "41" and secret.stat().st_mode & 0o777 == 0o600
    assert not (toy.root / "new").exists() and not Path("/tmp/bipedstudy-new").exists()


@linux
def test_a_stage_can_do_what_programs_do(toy):
    assert trying(toy, ALLOWED) == re.findall(r'"([A-Za-z ]+)": lambda', ALLOWED)


@pytest.mark.parametrize("way", [
    "socket.create_connection(('127.0.0.1', 9), 1)", "socket.getaddrinfo('localhost', 80)",
    "socket.socket(type=socket.SOCK_DGRAM).sendto(b'x', ('127.0.0.1', 9))",
    "with contextlib.suppress(OSError): socket.getaddrinfo('localhost', 80)",
])  # fmt: skip
def test_a_stage_that_asks_the_network_is_told(toy, way):
    toy.edit("PACKAGE/side/run.py", "import random\n", "import contextlib\nimport random\nimport socket\n")
    toy.edit("PACKAGE/side/run.py", "    time.sleep(", f"    {way}\n    time.sleep(")
    toy.fails(names=("side",), said=r"stage side: it asked the network, which no stage may")



@linux
@pytest.mark.skipif(os.geteuid() != 0, reason="gives files to another user")
def test_a_run_in_a_strangers_study_touches_nothing_of_yours(toy_with_commands, tmp_path_factory):
    """Not even by code that the command itself loads: parameters and results."""
    toy, mine = toy_with_commands, tmp_path_factory.mktemp("mine")
    (mine / "secret").write_text("41")
    trap = TRAP.replace("FOLDER", str(mine))
    for source in toy.path("stages").rglob("*.py"):
        if source.name in ("run.py", "result.py", "parameters.py"):
            source.write_text(f"{source.read_text()}\n{trap}")
    toy.give_away()
    (mine / "settings").mkdir()
    own = {"HOME": str(mine), "XDG_CACHE_HOME": "", "XDG_CONFIG_HOME": str(mine / "settings"), trust.VARIABLE: ""}
    code, out, errors = toy.command("--trust", "run", "bounce", environment=own)
    assert (code, "done" in out + errors) == (0, False), out + errors
    assert (mine / "secret").read_text() == "41" and not (mine / "new").exists()
    assert {path.stem for path in (toy.root / "results").glob("*.h5")} == {"fall", "bounce"}


@linux
@pytest.mark.skipif(os.geteuid() != 0, reason="gives files to another user")
@pytest.mark.parametrize("there", [True, False])
def test_a_command_in_a_strangers_study_says_where_landlock_is_missing(toy_with_commands, there):
    """What still holds is what Python tells, and that no socket is opened."""
    toy = toy_with_commands
    toy.give_away()
    without = "" if there else "from pipeline.room import confine; confine.landlock = int\n"
    done = commands.python(f"{without}from pipeline.cli import main; main(['--trust', 'status'])", cwd=toy.root,
                           **{trust.VARIABLE: ""})  # fmt: skip
    said = [line for line in done.stderr.splitlines() if "Landlock" in line]
    missing = f"note: without Landlock what lies in {toy.root} can read and change all that you can"
    assert done.returncode == 0 and said == ([] if there else [missing])


def test_machine_code_lies_where_stages_leave_it(monkeypatch, tmp_path):
    """The engine knows nothing of stages, and yet lets them write there."""
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        for value in (str(tmp_path), "", "relative"):
            monkeypatch.setenv(name, value)
            assert machine_code.home() == confine.machine_code() or sys.platform != "linux"
            monkeypatch.delenv(name)


# --- A stage that reads a file that dvc.yaml does not list is told by name, in whatever way it opens it.


WAYS = {
    "open": "open(FILE).read()",
    "from the study": "open('lab.txt').read()",
    "by a link": "open('link').read()",
    "caught": "contextlib.suppress(Exception).__enter__(); open(FILE).read()",
    "sqlite": "sqlite3.connect(FILE).close()",
    "sqlite as a URI": "sqlite3.connect(f'file:{FILE}?mode=ro', uri=True).close()",
    "hdf5": "h5py.File(FILE)",
    "forked": "(lambda process: (process.start(), process.join()))"
              "(multiprocessing.get_context('fork').Process(target=Path(FILE).read_bytes))",
}


def reading(toy, way, file):
    """Let stage `side` read a file so."""
    head = "import contextlib\nimport multiprocessing\nimport sqlite3\nimport tempfile\n\nimport h5py\n"
    toy.edit("PACKAGE/side/run.py", "import random\n", f"import random\n{head}FILE = {str(file)!r}\n")
    toy.edit("PACKAGE/side/run.py", "    time.sleep(", f"    {way}\n    time.sleep(")


@pytest.mark.parametrize("way", WAYS)
def test_an_undeclared_file_is_named_with_its_stage(toy, way):
    if way == "forked" and not hasattr(os, "fork"):
        pytest.skip("no process is forked here")
    file = toy.root / "lab.txt"
    if way == "hdf5":
        h5py.File(file, "w").close()
    elif way.startswith("sqlite"):
        sqlite3.connect(file).close()
    file.touch()
    (toy.root / "link").symlink_to(file)
    reading(toy, WAYS[way], file)
    toy.fails(names=("side",), said=r"stage side.*it read lab\.txt, which dvc\.yaml does not list")
    assert not (toy.root / "results/side.h5").exists()


def test_another_stages_result_and_parameters_are_undeclared_too(toy):
    toy.run(names=("fall",))
    way = ("for file in (FILE, 'params/fall.yaml'):\n        with contextlib.suppress(PermissionError):\n"
           "            open(file, 'rb').read()")  # fmt: skip
    reading(toy, way, toy.root / "results/fall.h5")
    toy.fails(names=("side",), said=r"it read results/fall\.h5, params/fall\.yaml, which")
