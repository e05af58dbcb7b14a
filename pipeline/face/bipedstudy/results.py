"""Stored results and checked parameters of a study."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline.cache import artefact, disk
from pipeline.errors import StudyError
from pipeline.report import standing
from pipeline.stage_modules import importable, result_class
from pipeline.study import Study, locate, shown

#: Changes of parameters, as `--set` takes them, or values by "file.key".
Setting = str | Mapping[str, Any]


def stages(study: str | Path | None = None) -> tuple[str, ...]:
    """Names of the study's stages, in the order in which they run."""
    return tuple(_located(study).graph.stages)


def load(stage: str, study: str | Path | None = None) -> Any:
    """The stored result of a stage, a frozen dataclass whose fields carry unit and description.

        >>> import bipedstudy as bs
        >>> bs.load("analytic").gait.step_frequency_hz  # doctest: +SKIP
        2.0717...

    `study` is a folder in a study (default: the working folder). Raises `StudyError` for an unknown stage, a result
    that is not there yet, or a damaged file.
    """
    found = _located(study)
    if found.borrowed:
        raise StudyError(f"there is no study in {Path.cwd()} or above it to load from; name one: study=DIR")
    place = found.store.place(found.graph.stage(stage).artefact)
    if not place.exists():
        raise found.absent(stage, place)
    disk.check(place, shown(place), disk.ARTEFACT)
    standing.say(found, stage)
    importable(found.package, found.code_root)
    return artefact.load(place, result_class(found.package, stage))


def parameters(stage: str, *settings: Setting, study: str | Path | None = None) -> Any:
    """The checked parameters of a stage; `settings` are texts as `--set` takes them, "biped.hip_mass=0.4", or mappings
    of values, {"biped.hip_mass": 0.4}.

    Raises `StudyError` with a sentence for each value that is not allowed.
    """
    return _located(study, *(text for each in settings for text in _texts(each))).parameters((stage,))[stage]


def _texts(setting: Setting) -> list[str]:
    """Settings as `--set` takes them; of NumPy's numbers and arrays the values."""
    if isinstance(setting, str):
        return [setting]
    if not isinstance(setting, Mapping):
        raise StudyError(f'{setting!r} is no setting; it is a text, "biped.hip_mass=0.4", or {{"biped.hip_mass": 0.4}}')
    return [f"{key}={value if isinstance(value, str) else json.dumps(value, default=lambda part: part.tolist())}"
            for key, value in setting.items()]  # fmt: skip


def _located(study: str | Path | None, *settings: str) -> Study:
    return locate(settings=settings, start=Path(study) if study is not None else None)
