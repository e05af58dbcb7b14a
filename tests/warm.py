"""Runs Python code like `python -c`, in a process of its own that begins with large packages loaded: it takes less.

Such a process is forked from one that this test session starts once, or from another that has less. It has the
packages below, and the engine; of the stages it has nothing, as studies of tests bring their own. The server that forks
its workers is forked from it in turn, so all begin in the environment that the engine gives to workers. `Toy.start` has
processes that begin with nothing.
"""

from __future__ import annotations

import atexit
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
import traceback
import types
from collections.abc import Mapping
from multiprocessing import forkserver
from pathlib import Path
from typing import NoReturn

from pipeline.cache import processor
from pipeline.execution.process import _SETTINGS

HOME = Path(__file__).resolve().parents[1]
#: What every command of a study can need, and what the stages of this one need beside.
LIGHT = (
    "h5py", "jinja2", "rich.progress", "yaml", "pipeline.cache.untouched", "pipeline.changes.command", "pipeline.cli",
    *(f"pipeline.commands.{name}" for name in ("house", "show", "status")),
    "pipeline.execution.executor", "pipeline.execution.fork_server", "pipeline.questions.asking",
    "pipeline.questions.command",
    "pipeline.report.figures", "pipeline.report.page", "pipeline.sweep.sweep",
)  # fmt: skip
HEAVY = ("matplotlib.figure", "numba", "scipy.interpolate", "scipy.ndimage", "scipy.signal")
_MEMORY, _ROOM = "/dev/shm", 4e9
_servers: dict[bool, forkserver.ForkServer] = {}


def run(
    code: str, *arguments: str, cwd: Path, env: Mapping[str, str], timeout: float = 300.0, anew: bool = False,
    light: bool = False,
) -> subprocess.CompletedProcess[str]:  # fmt: skip
    """What comes of `python -c code arguments` in this folder and environment; its standard input is empty.

    `anew`, nothing is loaded before: for variables that packages read when they are. `light` is for studies of tests,
    whose stages need little: a process with numba and SciPy takes three times as long to fork, and to end.
    """
    command = [sys.executable, "-c", code, *arguments]
    if anew or "forkserver" not in multiprocessing.get_all_start_methods():
        return subprocess.run(command, cwd=cwd, env=env, text=True, capture_output=True, timeout=timeout)
    context = multiprocessing.get_context("forkserver")
    forkserver.connect_to_new_process = _server(light).connect_to_new_process
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / name for name in ("out", "errors")]
        process = context.Process(target=_run, args=(code, arguments, cwd, dict(env), *files))
        before = dict(os.environ)
        os.environ.update({**_SETTINGS, **processor.environment()})
        process.start()
        os.environ.clear()
        os.environ.update(before)
        process.join(timeout)
        if process.exitcode is None:
            process.kill()
            process.join()
            raise subprocess.TimeoutExpired(command, timeout)
        out, errors = (path.read_text() if path.exists() else "" for path in files)
    return subprocess.CompletedProcess(command, process.exitcode, out, errors)


def _server(light: bool) -> forkserver.ForkServer:
    if light not in _servers:
        _servers[light] = forkserver.ForkServer()
        _servers[light].set_forkserver_preload([*LIGHT, *(() if light else HEAVY), "tests.warmed"])
    return _servers[light]


def keep_files_in_memory() -> None:
    """Let temporary files lie in memory where there is room and TMPDIR says nothing else: on a disk, with each file and
    folder flushed to it, the tests of the cache take 40 s by the clock for 18. What is called is the same in both.
    """
    if "TMPDIR" not in os.environ and os.access(_MEMORY, os.W_OK):
        found = os.statvfs(_MEMORY)
        if found.f_bavail * found.f_frsize > _ROOM and not found.f_flag & os.ST_NOEXEC:
            os.environ["TMPDIR"] = tempfile.tempdir = _MEMORY


def stop() -> None:
    """End the processes that the others are forked from, and wait for them, so that their time counts."""
    for server in _servers.values():
        server._stop()


def _run(code: str, arguments: tuple[str, ...], cwd: Path, env: dict[str, str], out: Path, errors: Path) -> NoReturn:
    os.environ.clear()
    os.environ.update(env)
    for number, path, flags in ((0, Path(os.devnull), os.O_RDONLY), (1, out, os.O_WRONLY | os.O_CREAT | os.O_APPEND),
                                (2, errors, os.O_WRONLY | os.O_CREAT | os.O_APPEND)):  # fmt: skip
        os.dup2(os.open(path, flags), number)
    sys.stdin, sys.stdout, sys.stderr = (os.fdopen(number, mode, closefd=False) for number, mode in enumerate("rww"))
    os.chdir(cwd)
    sys.argv = ["-c", *arguments]
    _fork_servers()
    sys.path[:0] = ["", *filter(None, env.get("PYTHONPATH", "").split(os.pathsep))]
    ended = 1
    try:
        exec(compile(code, "<string>", "exec"), {"__name__": "__main__"})
        ended = 0
    except SystemExit as end:
        ended = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        traceback.print_exc()
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(ended)


def _fork_servers() -> None:
    """Let the server of workers be forked from this process."""
    from pipeline.execution import process

    process.subprocess = types.SimpleNamespace(**{**vars(subprocess), "Popen": _Server})


class _Server:
    """`python -m pipeline.execution.fork_server`, as far as it is used like a `subprocess.Popen`."""

    def __init__(self, _: object, *, stdin: int, cwd: Path, env: Mapping[str, str], **__: object) -> None:
        sys.stdout.flush()
        self.pid, self.code = os.fork(), None
        if not self.pid:
            from pipeline.execution import fork_server

            os.setsid()
            os.chdir(cwd)
            os.environ.clear()
            os.environ.update(env)
            null = os.open(os.devnull, os.O_RDWR)
            for number, file in enumerate((stdin, null, null)):
                os.dup2(file, number)
            os.closerange(3, 1024)
            fork_server.main()

    def wait(self, timeout: float | None = None) -> int:
        end = time.monotonic() + (3600.0 if timeout is None else timeout)
        while self.code is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self.code = os.waitstatus_to_exitcode(status)
            elif time.monotonic() > end:
                raise subprocess.TimeoutExpired("server", timeout or 0.0)
            else:
                time.sleep(0.005)
        return self.code

    def kill(self) -> None:
        os.kill(self.pid, 9)
