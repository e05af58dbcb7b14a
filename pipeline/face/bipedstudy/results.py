"""Results and parameters of a study, gaits and walks of a design, and their arrays with names, units and dimensions."""

from __future__ import annotations

import dataclasses
import itertools
import json
from collections.abc import Mapping, Sequence
from operator import methodcaller
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.cache.hdf5 import names
from pipeline.commands import status
from pipeline.errors import StudyError, nearest
from pipeline.parameters.value import declared
from pipeline.study import Study, locate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stages.analytic.gait.gait_report import GaitReport
    from stages.biped.walk import Walk

#: Changes of parameters, as `--set` takes them, or values by "file.key".
Setting = str | Mapping[str, Any]


def stages(study: str | Path | None = None) -> tuple[str, ...]:
    """Names of the study's stages, in the order in which they run."""
    return tuple(located(study).graph.stages)


def load(stage: str, study: str | Path | None = None) -> Any:
    """The stored result of a stage, a frozen dataclass whose fields carry unit and description.

        >>> import bipedstudy as bs
        >>> bs.load("analytic").gait.step_frequency_hz  # doctest: +SKIP
        2.0717...

    `study` is a folder in a study (default: the working folder). Raises `StudyError` for an unknown stage, a result
    that is not there yet, or a damaged file.
    """
    found = located(study)
    if found.borrowed:
        raise StudyError(f"there is no study in {Path.cwd()} or above it to load from; name one: study=DIR")
    found.there(found.graph.stage(stage).artefact)
    status.say(found, stage)
    return found.result(stage)


def parameters(stage: str, *settings: Setting, study: str | Path | None = None) -> Any:
    """The checked parameters of a stage; `settings` are texts as `--set` takes them, "biped.hip_mass=0.4", or mappings
    of values, {"biped.hip_mass": 0.4}; of a key that one file has alone, {"hip_mass": 0.4}.

    Raises `StudyError` with a sentence for each value that is not allowed.
    """
    found = located(study)
    return dataclasses.replace(found, settings=resolved(found, stage, *settings)).parameters((stage,))[stage]


def gait(*settings: Setting, study: str | Path | None = None, **values: Any) -> GaitReport:
    """The most stable gait of a design: its measures, energy audit and what it asks of the ground, in SI units.

        >>> import bipedstudy as bs
        >>> round(bs.gait("biped.hip_mass=0.4").gait.step_frequency_hz, 4)
        1.9997

    `settings` are changes of parameters as `--set` takes them, or {"biped.hip_mass": 0.4}; `values` are parameters by
    name, hip_mass=0.4. Raises `StudyError` for a value that is not allowed, `NoGait` if the design has none.
    """
    from stages.analytic.gait.gait_report import report_gait

    own, walker, point = _found((*settings, values), study)
    return report_gait(walker, point, own.settings.tolerance, own.friction.coefficients.static_friction)


def walk(*settings: Setting, steps: int | None = None, study: str | Path | None = None, **values: Any) -> Walk:
    """A walk of a design in its most stable gait, from mid-stance: hip, legs, ground reaction, sensors over time.

        >>> import bipedstudy as bs
        >>> bs.walk(steps=2).hip_position.shape[1]
        2

    `settings` and `values` as for `gait`; `steps` (default: analytic.steps) is how many steps are walked.
    """
    from stages.analytic.walk.sampling import walk_from_mid_stance

    own, walker, point = _found((*settings, values, {} if steps is None else {"analytic.steps": steps}), study)
    about = own.settings
    return walk_from_mid_stance(walker, point.z, about.steps, about.tolerance, about.sampling_rate_hz)[0]


def _found(settings: Sequence[Setting], study: str | Path | None) -> tuple[Any, Any, Any]:
    """A design's parameters, its walker, and its most stable gait."""
    from stages.analytic.gait.gait_search import find_gait

    own = parameters("analytic", *settings, study=study)
    return own, *find_gait(own.biped, own.slope, own.settings.tolerance, own.limited_friction)


def resolved(study: Study, stage: str, *settings: Setting) -> tuple[str, ...]:
    """Settings of a stage as `--set` takes them, "file.key=value". Raises `StudyError` for a key in several files."""
    files: dict[str, list[str]] = {}
    for _, section in declared(study.parameters_classes()[study.graph.stage(stage).name]).values():
        for key in declared(section) if hasattr(section, "FILE") else ():
            files.setdefault(key, []).append(f"{section.FILE}.{key}")
    texts = []
    for text in (text for each in settings for text in _texts(each)):
        key, _, value = text.partition("=")
        if "." not in key and key not in files:
            raise StudyError(f'there is no parameter "{key}" of stage {stage}{nearest(key, files)}')
        known = files.get(key, [key])
        if len(set(known)) > 1:
            raise StudyError(f"{key} is a key of several files; name one: {', '.join(known)}")
        texts.append(f"{known[0]}={value}")
    return tuple(texts)


def _texts(setting: Setting) -> list[str]:
    """Settings as `--set` takes them; of NumPy's numbers and arrays the values. Raises `StudyError`."""
    if isinstance(setting, str):
        return [setting]
    if not isinstance(setting, Mapping):
        raise StudyError(f'{setting!r} is no setting; it is a text, "biped.hip_mass=0.4", or {{"biped.hip_mass": 0.4}}')
    try:
        return [f"{key}={value if isinstance(value, str) else json.dumps(value, default=methodcaller('tolist'))}"
                for key, value in setting.items()]  # fmt: skip
    except (AttributeError, TypeError) as error:
        raise StudyError(f"{dict(setting)!r} holds what is no value of a parameter ({error})") from None


def located(study: str | Path | None) -> Study:
    """The study around a folder; around the working folder, or else the installed one, if none is named. Raises
    `StudyError`."""
    found = locate(start=None if study is None else Path(study))
    if study is not None and (found.borrowed or not Path(study).is_dir()):
        raise StudyError(f"there is no study in {study} or above it")
    return found


@dataclasses.dataclass(frozen=True)
class Array:
    """Values with what they mean. `dimensions` names each axis; the first of a sampled signal is its time."""

    values: np.ndarray
    name: str
    unit: str
    symbol: str
    description: str
    dimensions: tuple[str, ...]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.asarray(self.values, dtype=dtype)

    def __repr__(self) -> str:
        shape = " x ".join(f"{name} {size}" for name, size in zip(self.dimensions, self.values.shape)) or "one number"
        return f"{self.name} [{self.unit}] ({shape}): {self.description}"


def arrays(result: Any) -> dict[str, Array]:
    """Every array and number of a result's own fields, by name.

        >>> import bipedstudy as bs
        >>> bs.arrays(bs.gait().gait)["period_s"].unit
        's'

    Raises `StudyError` for what is no result.
    """
    if not dataclasses.is_dataclass(result) or isinstance(result, type):
        raise StudyError(f"{result!r:.60} is no result: give what bs.gait, bs.walk or bs.load gave, or a part of it")
    own = {field.name: getattr(result, field.name) for field in dataclasses.fields(result)}
    about = {field.name: field.metadata for field in dataclasses.fields(result)}
    shapes = {name: np.shape(value) if isinstance(value, (np.ndarray, float, int)) else None
              for name, value in own.items()}  # fmt: skip
    axes = names(shapes, {name: said.get("dimensions", ()) for name, said in about.items()})
    return {name: Array(np.asarray(value), name, about[name]["unit"], about[name]["symbol"],
                        about[name]["description"], axes[name])
            for name, value in own.items() if shapes[name] is not None and not isinstance(value, bool)}  # fmt: skip


def array(result: Any, name: str) -> Array:
    """One array of a result by its name. Raises `StudyError` with the nearest name for an unknown one.

        >>> import bipedstudy as bs
        >>> bs.array(bs.walk(steps=1), "hip_position").unit
        'm'
    """
    known = arrays(result)
    if str(name) not in known:
        raise StudyError(f'there is no array "{name}" in this result{nearest(name, known)}')
    return known[str(name)]


def dataset(result: Any) -> Any:
    """The arrays of a result as an `xarray.Dataset`, with units as attributes and time as a coordinate.

    Raises `StudyError` where xarray is not installed.
    """
    try:
        import xarray
    except ImportError:
        raise StudyError("a dataset needs xarray: pip install xarray; bs.arrays(result) does without") from None
    variables = {
        name: (item.dimensions, item.values,
               {"units": item.unit, "symbol": item.symbol, "long_name": item.description})
        for name, item in arrays(result).items() if item.values.size
    }  # fmt: skip
    made = xarray.Dataset(variables)
    return made.set_coords("time") if "time" in made else made


def plot(walk: Any, *names: str) -> Figure:
    """A figure in the study's look, a panel for each signal of a walk by its field's name; axes carry symbol and unit.

        >>> import bipedstudy as bs
        >>> len(bs.plot(bs.walk(steps=1), "hip_position", "leg_angle").axes)
        2

    Raises `StudyError` for a name that the walk does not have, or that is no signal over its time.
    """
    import matplotlib.pyplot as plt

    from stages.biped.walk import ALONG
    from stages.drawing import style

    shown = [array(walk, name) for name in names or ("hip_position", "leg_angle")]
    for one in shown:
        if one.dimensions[:1] != ("time",):
            raise StudyError(f"{one!r} is no signal over time")
    with style.drawing():
        figure, axes = plt.subplots(
            len(shown), 1, sharex=True, squeeze=False, figsize=(style.TWO_COLUMNS, 1.0 + 1.4 * len(shown))
        )
        for panel, item in zip(axes[:, 0], shown):
            named = [", ".join(one) for one in itertools.product(*(ALONG[name] for name in item.dimensions[1:]))]
            columns = item.values.reshape(len(item.values), len(named)).T
            colours = style.ANALYTIC, style.MULTIBODY, style.SECOND, style.THIRD
            for column, name, colour in zip(columns, named, colours):
                panel.plot(walk.time, column, color=colour, label=name)
            panel.set_ylabel(f"{item.name.replace('_', ' ')}\n[{item.unit.replace('^2', '²')}]")
            if len(named) > 1:
                panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        axes[-1, 0].set_xlabel("time [s]")
    return figure
