"""What a worker process is asked for: a chain of stages at one point after another. A run is one stage at one point."""

from __future__ import annotations

import base64
import math
import pickle
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pipeline.cache.provenance import attributes
from pipeline.graph import Stage

if TYPE_CHECKING:
    from pipeline.cache.fingerprint import Ingredients
    from pipeline.study import Study

#: A file and the SHA-256 it must have.
File = tuple[str, str]
#: Of each stage its parameters, and the files that they name, by key.
Point = Mapping[str, tuple[Any, Mapping[str, File]]]
#: A point's number and the point as text.
Task = tuple[int, str]


@dataclass(frozen=True)
class Job:
    """All a worker needs to compute points, on this machine or, where `files` is empty, on another.

    `files` are results as they lie here, `contents` results that are carried along, both by their paths in the study.
    `code` (file -> meaning) is what the results' keys were made from. With `provenance` the last stage's files are
    written into the worker's folder; without it, its numbers are told.
    """

    package: str
    code_root: str
    root: str
    stages: tuple[Stage, ...]
    code: Mapping[str, str]
    files: Mapping[str, File] = field(default_factory=dict)
    provenance: Mapping[str, str] | None = None
    contents: Mapping[str, bytes] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    writer: str = ""
    time_limit_s: float = math.inf
    start_limit_s: float = 0.0


def job_of(study: Study, parts: Ingredients, files: Mapping[str, File]) -> Job:
    """The job to compute the stage of `parts` once, and to keep its files; `files` are the results it reads."""
    stage = study.graph.stages[parts["stage"]]
    about = attributes(parts, study.requests)
    return Job(study.package, str(study.code_root), str(study.root), (stage,), parts["code"], files, about)


def task_of(study: Study, values: Mapping[str, Any], index: int = 0) -> Task:
    """The task to compute the stages in `values` (name -> parameters) as point number `index`."""
    return index, packed({name: (each, study.named_files(each)) for name, each in values.items()})


def packed(value: Any) -> str:
    """A value as one line of text for another process of this program."""
    return base64.b64encode(pickle.dumps(value)).decode()


def unpacked(text: str | bytes) -> Any:
    """The value of a line that `packed` made."""
    return pickle.loads(base64.b64decode(text))


def beneath(name: str, paths: Iterable[str]) -> list[str]:
    """Those of `paths` that are the file `name`, or lie in the folder `name`."""
    return [path for path in paths if path == name or path.startswith(name + "/")]
