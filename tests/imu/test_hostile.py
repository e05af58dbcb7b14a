"""Files made to read others, to never end, or to fill memory: each is refused in one sentence, and in bounds."""

import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from tests import commands
from tests.imu.hostile import FORMATS, MARKS, hostile

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
    made = "import sys; from pathlib import Path; from tests.imu.hostile import hostile; " \
           "print(*hostile(Path(sys.argv[1]), int(sys.argv[2])), sep='\\n')"  # fmt: skip
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(repository), os.environ.get("PYTHONPATH", "")])}
    words = commands.python(made, str(tmp_path / "lab"), str(seed), cwd=repository, env=environment).stdout.split()
    with open(tmp_path / "out", "wb") as out, open(tmp_path / "errors", "wb") as errors:
        command = [sys.executable, "-c", "from pipeline.cli import main; main()", *words]
        process = subprocess.Popen(command, cwd=repository, env=environment, stdout=out, stderr=errors)
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
