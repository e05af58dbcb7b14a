"""A lab's intervals with what the model puts wrong in them, as far as the study's own runs tell it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.known import TOTAL_MASS, Known
from stages.calibration.information.words import listed, short
from stages.calibration.intervals.discrepancy import Discrepancy
from stages.calibration.result import Result

#: Drawings whose numbers differ by less are the same.
SAME = 1e-6
ALONE = "intervals hold noise and residuals alone, and not what the model puts wrong in every step"


@dataclass(frozen=True)
class Judged:
    """A design (d,) with standard deviations (d,), as wide as Gaussian ones of the same 95 % intervals; what to say of
    them, and by how many runs they are told what the model puts wrong (0: they are not)."""

    values: Vector
    sd: Vector
    words: str
    other_runs: int = 0


def judged(
    names: Sequence[str], values: Vector, sd: Vector, known: Sequence[Known], design: DesignPoint,
    pull: float, told: tuple[Any, str],
) -> Judged:
    """What was found (d,) with noise `sd` (d,), less what fits of the study's runs miss on average and widened by
    their scatter, where the study has made fits of this kind; else as it is, and why.

    `pull`: by how much the fit moved clocks. `told` is the study's own calibration and its file, or none and why.
    """
    study, source = told
    why = source if study is None else unfit(names, known, design, study, source)
    if why:
        return Judged(values, sd, f"{ALONE}: {why}")
    term = Discrepancy.of(study.names, study.misses.shares, study.misses.pulls)
    order = [study.names.index(name) for name in names]
    off = term.expected(study.drawn, pull)[order]
    wide = np.sqrt(np.diag(term.spread(study.drawn, pull))[order])
    first, last = study.misses.runs[0], study.misses.runs[-1]
    largest = int(np.argmax(np.abs(off / values)))
    return Judged(
        values - off, np.hypot(sd, wide),
        f"intervals hold what the model puts wrong, by fits of {term.count} runs of other machines made by the Exudyn "
        f"twin ({source}, {first} to {last}): what they miss where clocks are pulled as far is taken off "
        f"({short(names[largest])} by {-100 * off[largest] / values[largest]:+.2f} %), their scatter is in the "
        "intervals. That holds for a robot as near to its drawing as those machines, on ground like the twin's",
        term.count)


def unfit(
    names: Sequence[str], known: Sequence[Known], design: DesignPoint, study: Result, source: str
) -> str:
    """Why a study's fits do not tell what these miss; nothing where they do."""
    if Discrepancy.told(study.names, study.misses) is None:
        return (f"{source} has {len(study.misses.runs) or 'no'} fits of other machines' runs, which is too few "
                "(calibration.discrepancy_runs)")
    if set(names) != set(study.names):
        return (f"{source} tells it of fits that look for {listed([short(name) for name in study.names])}; the bill of "
                "parts begins such a fit (design: parts)")
    if {one.name for one in known} != {TOTAL_MASS}:
        return f"{source} tells it of robots of which the mass is known and nothing else"
    other = [short(name) for name, drawn in zip(study.names, study.drawn, strict=True)
             if abs(design.value(name) - drawn) > SAME * abs(drawn)]
    return f"{source} is of a robot with another {listed(other)}" if other else ""
