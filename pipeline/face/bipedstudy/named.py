"""Arrays of a result with their names, units and dimensions; a figure of them, a view for xarray where there is one."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.cache.hdf5.dimensions import names
from pipeline.errors import StudyError, nearest

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
    """
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
    if name not in known:
        raise StudyError(f'there is no array "{name}" in this result{nearest(name, known)}')
    return known[name]


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

    Raises `StudyError` for a name that the walk does not have.
    """
    import matplotlib.pyplot as plt

    from stages.drawing import style

    shown = [array(walk, name) for name in names or ("hip_position", "leg_angle")]
    with style.drawing():
        figure, axes = plt.subplots(
            len(shown), 1, sharex=True, squeeze=False, figsize=(style.TWO_COLUMNS, 1.0 + 1.4 * len(shown))
        )
        for panel, item in zip(axes[:, 0], shown):
            columns = item.values.reshape(len(item.values), -1)
            for number, colour in zip(range(columns.shape[1]), (style.ANALYTIC, style.MULTIBODY, *style.SEQUENCE)):
                panel.plot(walk.time, columns[:, number], color=colour, label=f"column {number}")
            panel.set_ylabel(f"{item.name.replace('_', ' ')} [{item.unit}]")
            if columns.shape[1] > 1:
                panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        axes[-1, 0].set_xlabel("time [s]")
    return figure
