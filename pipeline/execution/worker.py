"""Runs one stage in a process of its own: reads its inputs, calls `run`, writes its files into a given folder.

The order comes as one line of JSON on standard input; messages go back as lines of JSON. Standard input stays open as
long as the parent lives: when it closes, the worker ends, so that no killed run leaves a stage computing.
"""

from __future__ import annotations

import base64
import json
import os
import pickle
import sys
import threading
import time
import traceback
from pathlib import Path
from typing import Any, TextIO

from pipeline.cache import artefact, durable
from pipeline.errors import StudyError, is_answer
from pipeline.execution.observed_import import ObservedSources
from pipeline.execution.order import Order
from pipeline.execution.process import end_group
from pipeline.stage_modules import result_class, stage_module

_REPORT_EVERY_S = 0.1


class Refusal(Exception):
    """A sentence for the user; the parent adds the stage's name."""


def main() -> None:
    """Entry of `python -m pipeline.execution.worker`."""
    messages = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    order = Order(**json.loads(sys.stdin.buffer.readline()))
    threading.Thread(target=_end_with_parent, daemon=True).start()
    code = 0
    try:
        _send(messages, {"done": _carry_out(order, messages)})
    except BaseException as error:
        code = 1
        traceback.print_exc()
        _send(messages, {"failed": _failure(error, order.package)})
    sys.stderr.flush()
    os._exit(code)  # no library's exit handler may turn a finished stage into a crash


def _carry_out(order: Order, messages: TextIO) -> dict[str, Any]:
    observed = ObservedSources(Path(order.code_root), order.package)
    observed.install()
    inputs = {Path(path).stem: _input(order, path, Path(file), sha256) for path, file, sha256 in order.inputs}
    stage = stage_module(order.package, order.stage, "run")
    parameters = pickle.loads(base64.b64decode(order.parameters))
    result = stage.run(parameters, inputs, _reporter(messages))
    for _, file, sha256 in order.inputs:
        if durable.digest(durable.read(Path(file)) or b"") != sha256:
            raise Refusal(
                f"its input {Path(file).name} was changed while it ran, so its result was not kept; run again"
            )
    _check_code(order, observed)
    files = _files(order, result)
    content = {name: durable.digest(data) for name, data in files.items()}
    content[order.artefact] = durable.digest(artefact.encode(result, {}))
    files[order.artefact] = artefact.encode(result, order.provenance)
    for name, data in files.items():
        durable.write(Path(order.folder) / name, data)
    outs = {
        name: {"sha256": durable.digest(data), "size": len(data), "content": content[name]}
        for name, data in sorted(files.items())
    }
    return {"outs": outs, "summary": " ".join(str(result.summary()).split())}


def _input(order: Order, path: str, file: Path, sha256: str) -> Any:
    content = durable.read(file)
    if content is None or durable.digest(content) != sha256:
        raise Refusal(f"its input {path} was changed by someone else meanwhile; run again")
    if not path.endswith(".h5"):
        return file
    cls = result_class(order.package, file.stem)
    return artefact.decode(content, cls, path)


def _check_code(order: Order, observed: ObservedSources) -> None:
    """The code that ran must be the code the key was made from."""
    for name, meaning in observed.meanings().items():
        if name not in order.code:
            raise Refusal(f"it imports {name} in a way that cannot be seen in the text; import it by name")
        if order.code[name] != meaning:
            raise Refusal(f"{name} was edited while it ran, so its result was not kept; run again")


def _files(order: Order, result: Any) -> dict[str, bytes]:
    """The files beside the artefact; they must be those that dvc.yaml declares, no more and no fewer."""
    files = {f"results/{name}": bytes(data) for name, data in getattr(result, "files", {}).items()}
    declared = [out for out in order.outs if out != order.artefact]
    for name in files:
        if ".." in Path(name).parts or not any(name == out or name.startswith(out + "/") for out in declared):
            raise Refusal(f"it returned the file {name}, which dvc.yaml does not list among its outs")
    for out in declared:
        if not any(name == out or name.startswith(out + "/") for name in files):
            raise Refusal(f"it did not return {out}, which dvc.yaml lists among its outs")
    return files


def _reporter(messages: TextIO) -> Any:
    last = [0.0]

    def report(fraction: float, what: str) -> None:
        now = time.monotonic()
        if now - last[0] >= _REPORT_EVERY_S:
            last[0] = now
            _send(messages, {"progress": [min(1.0, max(0.0, float(fraction))), str(what)]})

    return report


def _failure(error: BaseException, package: str) -> dict[str, Any]:
    """Kind and sentence. A class of the stages' own is a reasoned refusal; everything else is unexpected."""
    text = " ".join(str(error).split())
    if isinstance(error, (Refusal, StudyError)):
        return {"kind": "refused", "text": text}
    if is_answer(error, package):
        return {"kind": "answer", "text": text}
    if isinstance(error, OSError) and error.errno is not None:
        return {"kind": "system", "text": os.strerror(error.errno)}
    if isinstance(error, MemoryError):
        return {"kind": "system", "text": "not enough memory"}
    return {"kind": "unexpected", "text": f"{type(error).__name__}: {text}" if text else type(error).__name__}


def _send(messages: TextIO, message: dict[str, Any]) -> None:
    messages.write(json.dumps(message) + "\n")
    messages.flush()


def _end_with_parent() -> None:
    while os.read(0, 4096):
        pass
    end_group()


if __name__ == "__main__":
    main()
