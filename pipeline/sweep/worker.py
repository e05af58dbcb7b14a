"""Computes the points it is given, one after another, in a process that stays: start-up is paid once, not per point.

The first line on standard input is the job, the second a folder for files, every further line a chunk of points; each
point is announced before it begins, so that whoever listens knows which one a crash or a hang belongs to. When standard
input closes, it ends.
"""

from __future__ import annotations

import base64
import json
import os
import pickle
import queue
import sys
import threading
import time
import traceback
from pathlib import Path
from typing import Any, TextIO

from pipeline.cache import artefact, durable, fingerprint
from pipeline.cache.distributions import versions
from pipeline.errors import is_answer
from pipeline.execution.observed_import import ObservedSources
from pipeline.execution.process import end_group
from pipeline.parameters.loading import files
from pipeline.stage_modules import home_of, importable, result_class, stage_module
from pipeline.sweep.chain import Job, Link
from pipeline.sweep.row import COMPUTED, ERROR, NO_ANSWER, columns


class Unfit(Exception):
    """Why this process cannot compute the job's points: other code, other versions."""


def main() -> None:
    """Entry of `python -m pipeline.sweep.worker`."""
    messages = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(lines,), daemon=True).start()
    try:
        job = pickle.loads(base64.b64decode(lines.get()))
        points = Computing(job, Path(lines.get().decode().rstrip("\n")))
        while True:
            for index, text in json.loads(lines.get()):
                _send(messages, {"began": index})
                _send(messages, {"index": index, **points.row(pickle.loads(base64.b64decode(text)))})
    except Unfit as unfit:
        _send(messages, {"unfit": str(unfit)})
    os._exit(1)


class Computing:
    """The chain of stages of one job. What an upstream stage made is kept as long as its parameters stay."""

    def __init__(self, job: Job, scratch: Path) -> None:
        self.job, self.scratch = job, scratch
        root = home_of(job.package, Path(job.code_root))
        here = versions([*job.versions])
        other = [f"{name} {here.get(name)} instead of {version}" for name, version in job.versions.items()
                 if here.get(name) != version]  # fmt: skip
        if other:
            raise Unfit(f"this machine has {other[0]}; all machines of a sweep need the same versions")
        self.observed = ObservedSources(root, job.package)
        if self.observed.sources.memo.meaning(fingerprint.WRITER.read_bytes()).tree != job.writer:
            raise Unfit("pipeline/cache/artefact.py differs from the one the sweep was started with")
        importable(root)
        self.observed.install()
        self.checked = 0
        self.kept: dict[str, tuple[bytes, dict[str, bytes]]] = {}

    def row(self, parameters: dict[str, Any]) -> dict[str, Any]:
        """Outcome, reason, values and seconds of one point."""
        began = time.perf_counter()
        try:
            values, outcome, reason = columns(self._result(parameters)), COMPUTED, ""
        except Exception as error:
            values, reason = {}, " ".join(str(error).split())
            outcome = NO_ANSWER if is_answer(error, self.job.package) else ERROR
            if outcome == ERROR:
                last = traceback.extract_tb(error.__traceback__)[-1]
                reason = f"{type(error).__name__}: {reason} ({Path(last.filename).name}:{last.lineno})"
        seconds = time.perf_counter() - began
        self._check_code()
        return {"outcome": outcome, "reason": reason, "values": values, "seconds": round(seconds, 6)}

    def _result(self, parameters: dict[str, Any]) -> Any:
        made = dict(self.job.fixed)
        token = b""
        for link in self.job.links[:-1]:
            token = durable.digest(token + pickle.dumps(parameters[link.stage])).encode()
            if self.kept.get(link.stage, (b"", {}))[0] != token:
                self.kept[link.stage] = token, self._files(link, self._run(link, parameters, made))
            made.update(self.kept[link.stage][1])
        return self._run(self.job.links[-1], parameters, made)

    def _run(self, link: Link, parameters: dict[str, Any], made: dict[str, bytes]) -> Any:
        stage = stage_module(self.job.package, link.stage, "run")
        inputs = {
            Path(path).stem: self._input(path, content)
            for path, content in made.items()
            if any(path == name or path.startswith(name + "/") for name in link.inputs)
        }
        values = parameters[link.stage]
        inputs |= {key: Path(self.job.root) / name for key, (_, name) in files(values).items()}
        return stage.run(values, inputs, lambda fraction, what: None)

    def _input(self, path: str, content: bytes) -> Any:
        if path.endswith(".h5"):
            cls = result_class(self.job.package, Path(path).stem)
            return artefact.decode(content, cls, path)
        file = self.scratch / path
        if durable.read(file) != content:
            durable.write(file, content)
        return file

    def _files(self, link: Link, result: Any) -> dict[str, bytes]:
        beside = {f"results/{name}": bytes(data) for name, data in getattr(result, "files", {}).items()}
        return {**beside, f"results/{link.stage}.h5": artefact.encode(result, {})}

    def _check_code(self) -> None:
        """The code that ran must be the code the points' keys were made from."""
        if len(self.observed.loaded) == self.checked:
            return
        for name, meaning in self.observed.meanings().items():
            if self.job.code.get(name) != meaning:
                raise Unfit(f"{name} differs from what the sweep was started with, or cannot be seen to be imported")
        self.checked = len(self.observed.loaded)


def _send(messages: TextIO, message: dict[str, Any]) -> None:
    messages.write(json.dumps(message) + "\n")
    messages.flush()


def _listen(lines: queue.SimpleQueue[bytes]) -> None:
    for line in sys.stdin.buffer:
        lines.put(line)
    end_group()


if __name__ == "__main__":
    main()
