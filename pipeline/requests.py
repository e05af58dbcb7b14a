"""Options that ask something of several stages, as one stage declares them: `--accuracy`, where a study has it.

A stage's module `request` declares one: NAME of the option and of the key it stands for, METAVAR, HELP, FORM and
`words()` for messages, FILES that have the key, FREE, its value with which nothing is asked, `parsed(text)`, and
`level(value)`, the study's level that goes with it. With VERIFY_HELP, `verified(asked, result)` and `line(found)` tell
what a run reached.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import click
import yaml

from pipeline.cache import disk
from pipeline.errors import StudyError
from pipeline.stage_modules import result_class
from pipeline.study import Study, shown

_SEAL = "seal: "
Request = ModuleType
#: The request, a stage, and what is asked of it.
Asked = tuple[Request, str, Any]


def all_requested(study: Study, values: Mapping[str, Any]) -> Iterator[Asked]:
    """What requests ask of stages; `values` is stage -> parameters."""
    for stage, own in values.items():
        for request in study.requests:
            section = next((section for section in vars(own).values() if stage == section.FILE), None)
            requested = getattr(section, request.NAME, request.FREE)
            if stage in request.FILES and requested != request.FREE:
                yield request, stage, requested


def to_verify(study: Study, stages: Iterable[str]) -> list[Asked]:
    """What is asked of these stages. Raises `StudyError` if nothing is."""
    names = [study.graph.stage(name).name for name in stages]
    found = list(all_requested(study, study.parameters(names)))
    if not found:
        options = " or ".join(f"--{request.NAME}" for request in study.requests)
        raise StudyError(f"--verify estimates an error that was asked for, and none is asked of {', '.join(names)}; "
                         f"give {options}, or its key in the stage's parameter file")  # fmt: skip
    return found


def verify(study: Study, chosen: list[Asked], *, show: bool) -> None:
    """Keep what each stage's result tells of its request beside the artefact and, if `show`, print it.

    Holds the lock.
    """
    from pipeline.cache import artefact  # with h5py, which takes its time

    with disk.locked(study.results, shown(study.results), "bipedstudy --verify", True, click.echo):
        for request, stage, requested in chosen:
            path = study.graph.stages[stage].artefact
            content = disk.content(study.store.place(path), shown(study.store.place(path)))
            key = artefact.provenance(content, path)["key"]
            result = artefact.decode(content, result_class(study.package, stage), path)
            found = {"stage": stage, "artefact_key": key, **request.verified(requested, result)}
            place, text = record_of(study, request, stage), yaml.safe_dump(found, sort_keys=False)
            disk.inside(study.results, place, shown(place))
            disk.write(place, f"{text}{_SEAL}{disk.digest(text.encode())}\n".encode())
            if show:
                click.echo(f"{request.line(found)}; {shown(place)}")


def record_of(study: Study, request: Request, stage: str) -> Path:
    """Where the verification of a stage's artefact is kept: results/<request>/<stage>.yaml."""
    return study.results / str(request.NAME) / f"{stage}.yaml"


def kept(study: Study, about: Mapping[str, str]) -> Iterator[str]:
    """Of each request that an artefact's provenance tells of: its verification, or else what was asked."""
    for request in study.requests:
        if request.NAME not in about:
            continue
        line = f"{request.NAME} {about[request.NAME]}"
        with contextlib.suppress(yaml.YAMLError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
            record = record_of(study, request, about.get("stage", ""))
            text, _, seal = (disk.read(record, disk.TEXT) or b"").decode().rpartition(_SEAL)
            found = yaml.safe_load(text)
            if seal.strip() == disk.digest(text.encode()) and found["artefact_key"] == about.get("key"):
                line = request.line(found)
        yield line
