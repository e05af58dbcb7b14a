"""Runs commands of the study: as a user's shell does, or in this process, where one of its own tells no more."""

import contextlib
import io
import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from unittest import mock

from pipeline.cli import main

HOME = Path(__file__).resolve().parents[1]


def run(*arguments: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    """What comes of `bipedstudy arguments` in this folder. Errors that are no sentences are raised here."""
    command, before, folder = ["bipedstudy", *map(str, arguments)], signal.getsignal(signal.SIGTERM), Path.cwd()
    ended, (out, errors) = 0, (io.StringIO(), io.StringIO())
    with (contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors), mock.patch.object(sys, "argv", command),
          mock.patch.dict(os.environ)):  # fmt: skip
        os.chdir(cwd)
        try:
            main(command[1:])
        except SystemExit as end:
            assert isinstance(end.code, int)
            ended = end.code
        finally:
            os.chdir(folder)
            signal.signal(signal.SIGTERM, before)
    assert "unexpected" not in errors.getvalue(), errors.getvalue()
    return subprocess.CompletedProcess(command, ended, out.getvalue(), errors.getvalue())


def python(
    code: str, *arguments: str, cwd: Path, env: Mapping[str, str] | None = None, timeout: float = 300.0, **more: str
) -> subprocess.CompletedProcess[str]:
    """What comes of `python -c code arguments` in this folder, with nothing to read; its environment is `env`, or this
    process's with this checkout's code and some `more` variables.
    """
    env = {**os.environ, "PYTHONPATH": str(HOME), **more} if env is None else env
    return subprocess.run([sys.executable, "-c", code, *arguments], cwd=cwd, env=env, text=True, capture_output=True,
                          stdin=subprocess.DEVNULL, timeout=timeout)  # fmt: skip


def afresh(*words: object, cwd: Path, timeout: float = 300.0, **more: str) -> subprocess.CompletedProcess[str]:
    """What comes of a command in a process of its own, as `python` has it."""
    return python("from pipeline.cli import main; main()", *map(str, words), cwd=cwd, timeout=timeout, **more)


#: Runs each of its arguments as a command, and prints what came of each as JSON.
_EACH = """
import contextlib, io, json, shlex, sys
from pipeline.cli import main
told = []
for words in sys.argv[1:]:
    sys.argv, out, errors = ["bipedstudy"], io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        try:
            main(shlex.split(words))
        except SystemExit as end:
            told.append((words, (end.code, out.getvalue(), errors.getvalue())))
sys.__stdout__.write("\\n" + json.dumps(told))
"""


def each(
    *typed: str, cwd: Path, env: Mapping[str, str] | None = None, **more: str
) -> dict[str, tuple[int, str, str]]:
    """Exit code, standard output and errors of commands as they are typed, one after another in one process of its own.

    For what computes nothing: most of such a command's time goes into its start.
    """
    done = python(_EACH, *typed, cwd=cwd, env=env, **more)
    assert done.returncode == 0, done.stderr
    return {words: tuple(told) for words, told in json.loads(done.stdout.splitlines()[-1])}
