"""Stored results and checked parameters of a study; gaits and walks of a design, by the constraint model."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.commands import status
from pipeline.errors import StudyError
from pipeline.study import Study, locate

if TYPE_CHECKING:
    from stages.analytic.gait.gait_report import GaitReport
    from stages.biped.walk import Walk

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
    found.there(found.graph.stage(stage).artefact)
    status.say(found, stage)
    return found.result(stage)


def parameters(stage: str, *settings: Setting, study: str | Path | None = None) -> Any:
    """The checked parameters of a stage; `settings` are texts as `--set` takes them, "biped.hip_mass=0.4", or mappings
    of values, {"biped.hip_mass": 0.4}.

    Raises `StudyError` with a sentence for each value that is not allowed.
    """
    return _located(study, *(text for each in settings for text in _texts(each))).parameters((stage,))[stage]


def gait(*settings: Setting, study: str | Path | None = None) -> GaitReport:
    """The most stable gait of a design: its measures, energy audit and what it asks of the ground, in SI units.

        >>> import bipedstudy as bs
        >>> round(bs.gait("biped.hip_mass=0.4").gait.step_frequency_hz, 4)
        1.9997

    `settings` are changes of parameters as `--set` takes them, or {"biped.hip_mass": 0.4}. Raises `StudyError` for a
    value that is not allowed, `NoGait` if the design has none.
    """
    from stages.analytic.gait.gait_report import report_gait

    own, walker, point = _found(settings, study)
    return report_gait(walker, point, own.settings.tolerance, own.friction.static_friction)


def walk(*settings: Setting, steps: int | None = None, study: str | Path | None = None) -> Walk:
    """A walk of a design in its most stable gait, from mid-stance: hip, legs, ground reaction, sensors over time.

        >>> import bipedstudy as bs
        >>> bs.walk(steps=2).hip_position.shape[1]
        2

    `settings` as for `gait`; `steps` (default: analytic.steps) is how many steps are walked.
    """
    from stages.analytic.walk.sampling import walk_from_mid_stance

    own, walker, point = _found((*settings, *([] if steps is None else [f"analytic.steps={steps}"])), study)
    about = own.settings
    return walk_from_mid_stance(walker, point.z, about.steps, about.tolerance, about.sampling_rate_hz)[0]


def _found(settings: Sequence[Setting], study: str | Path | None) -> tuple[Any, Any, Any]:
    """A design's parameters, its walker, and its most stable gait."""
    from stages.analytic.gait.gait_search import find_gait

    own = parameters("analytic", *settings, study=study)
    return own, *find_gait(own.biped, own.slope, own.settings.tolerance, own.limited_friction)


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
