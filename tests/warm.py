"""Runs Python code like `python -c`, in a process of its own that begins with large packages loaded: it takes less.

Such a process is forked from one that this test session starts once. It has the packages below, and the engine; of the
stages it has nothing, as studies of tests bring their own.
"""

from __future__ import annotations

import atexit
import multiprocessing
import os
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import NoReturn

HOME = Path(__file__).resolve().parents[1]
LOADED = (
    "h5py", "jinja2", "matplotlib.figure", "numba", "rich.progress", "scipy.interpolate", "scipy.ndimage",
    "scipy.signal", "yaml", "pipeline.cli", "pipeline.commands.running", "pipeline.questions.command",
    "pipeline.report.content", "tests.warm_numba",
)  # fmt: skip


def run(
    code: str, *arguments: str, cwd: Path, env: Mapping[str, str], timeout: float = 300.0, anew: bool = False
) -> subprocess.CompletedProcess[str]:
    """What comes of `python -c code arguments` in this folder and environment; its standard input is empty.

    `anew`, nothing is loaded before: for variables that packages read when they are.
    """
    command = [sys.executable, "-c", code, *arguments]
    if anew or "forkserver" not in multiprocessing.get_all_start_methods():
        return subprocess.run(command, cwd=cwd, env=env, text=True, capture_output=True, timeout=timeout)
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([*LOADED])
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / name for name in ("out", "errors")]
        process = context.Process(target=_run, args=(code, arguments, cwd, dict(env), *files))
        process.start()
        process.join(timeout)
        if process.exitcode is None:
            process.kill()
            process.join()
            raise subprocess.TimeoutExpired(command, timeout)
        out, errors = (path.read_text() if path.exists() else "" for path in files)
    return subprocess.CompletedProcess(command, process.exitcode, out, errors)


def stop() -> None:
    """End the process that the others are forked from, and wait for it, so that its time counts."""
    from multiprocessing import forkserver

    forkserver._forkserver._stop()


def _run(code: str, arguments: tuple[str, ...], cwd: Path, env: dict[str, str], out: Path, errors: Path) -> NoReturn:
    os.environ.clear()
    os.environ.update(env)
    for number, path, flags in ((0, Path(os.devnull), os.O_RDONLY), (1, out, os.O_WRONLY | os.O_CREAT | os.O_APPEND),
                                (2, errors, os.O_WRONLY | os.O_CREAT | os.O_APPEND)):  # fmt: skip
        os.dup2(os.open(path, flags), number)
    sys.stdin, sys.stdout, sys.stderr = (os.fdopen(number, mode, closefd=False) for number, mode in enumerate("rww"))
    os.chdir(cwd)
    sys.argv = ["-c", *arguments]
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
