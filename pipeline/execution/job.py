"""What a worker process is to do: a chain of stages at one point after another. A run is one stage at one point.

The parts of a question's answer are the same with a function in place of the stages, its arguments in place of points.

It is sent as JSON: names of stages, values and digests. No object of this program is pickled, so that whoever receives
a job runs no code that came with it.
"""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from pipeline.cache.fingerprint import Ingredients, attributes, entry_modules
from pipeline.graph import Stage
from pipeline.home import code_of, engine
from pipeline.parameters import loading
from pipeline.study import Study

#: In a worker's folder, what stages mean to throw away.
TEMPORARY = "tmp"
#: A file and the SHA-256 it must have; in place of one that is not there "", and why it is not.
File = tuple[str, str]
#: Of each stage its parameters, file -> key -> plain value, and the files that they name, by key.
Point = Mapping[str, tuple[Mapping[str, Mapping[str, Any]], Mapping[str, File]]]
#: A point's number and the point, or the argument of a function.
Task = tuple[int, Any]


def named_files(tasks: Iterable[Task]) -> set[str]:
    """The files that parameters name at these points."""
    return {place for _, point in tasks if isinstance(point, dict) for _, chosen in point.values()
            for place, _ in chosen.values() if place}  # fmt: skip


@dataclass(frozen=True)
class Job:
    """All a worker needs to compute points, on this machine or, where `files` is empty, on another.

    `files` are results as they lie here, `contents` results that are carried along, both by their paths in the study.
    `code` (file -> meaning) is what the results' keys were made from, `engine` what this program itself is made of.
    With `provenance` the last stage's files are written into the worker's folder, `about` in its artefact, and numbers
    have errors; without it, its numbers are sent.

    A job with a `function` of a question has no stages: the `name` of one in a `module`. It is given the parameters of
    `stage`, read from `parameters` (file -> key -> plain value), then what is `shared` by all calls, then its argument.
    """

    package: str
    code_root: str
    root: str
    stages: Sequence[Stage]
    code: Mapping[str, str]
    files: Mapping[str, File] = field(default_factory=dict)
    provenance: Mapping[str, str] | None = None
    about: Mapping[str, str] = field(default_factory=dict)
    contents: Mapping[str, bytes] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    engine: Mapping[str, str] = field(default_factory=dict)
    time_limit_s: float = math.inf
    start_limit_s: float = 0.0
    function: Mapping[str, Any] = field(default_factory=dict)

    @property
    def modules(self) -> tuple[str, ...]:
        """What a worker imports of the package."""
        if self.function:
            return f"{self.package}.{self.function['stage']}.parameters", self.function["module"]
        return tuple(module for stage in self.stages for module in entry_modules(stage, self.package))

    def text(self) -> str:
        """The job as one line of JSON."""
        contents = {path: base64.b64encode(content).decode() for path, content in self.contents.items()}
        return json.dumps({**asdict(self), "contents": contents})

    @classmethod
    def of(cls, text: str) -> Job:
        """The job of a line that `text` gave."""
        plain = json.loads(text)
        plain["stages"] = [Stage(**each) for each in plain["stages"]]
        plain["contents"] = {path: base64.b64decode(content) for path, content in plain["contents"].items()}
        return cls(**plain)


def job_of(study: Study, parts: Ingredients, files: Mapping[str, File], above: Iterable[Ingredients] = ()) -> Job:
    """The job to compute the stage of `parts` once, and to keep its files; it reads `files` and rests on `above`."""
    stage = study.graph.stages[parts["stage"]]
    about = {**study.about, "stage": stage.name}
    made = attributes(parts, study.requests, above) | {"program": study.about["source"]}
    return Job(study.package, str(study.code_root), str(study.root), (stage,), parts["code"], files, made, about)


def task_of(study: Study, values: Mapping[str, Any], index: int = 0) -> Task:
    """The task to compute the stages in `values` (name -> parameters) as point number `index`."""
    return index, {name: (loading.as_plain(each), study.named_files(each)) for name, each in values.items()}


def engine_code() -> dict[str, str]:
    """What this program is made of: file -> digest, whatever ends its lines."""
    return code_of(engine() / "pipeline")
