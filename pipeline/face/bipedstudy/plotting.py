"""Signals of a walk over time, in the study's look."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bipedstudy.named import array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot(walk: Any, *names: str) -> Figure:
    """A figure with a panel for each signal of a walk, by the names of its fields; axes carry symbols and units.

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
