"""What runs can tell, as text, JSON and picture."""

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.biped.question import Answer
from stages.calibration.estimation.least_squares import TOTAL_MASS
from stages.calibration.estimation.request import Request
from stages.calibration.information.identifiability import (
    Identifiability,
    described,
    experiments,
    free_names,
    gains,
    identifiability,
    listed,
    planned_equations,
    short,
    weighed,
)
from stages.calibration.parameters import Parameters

#: A correlation from which on two errors are hard to distinguish, and a gain that is worth a line.
STRONG, WORTH = 0.9, 1.25


def answered(parameters: Parameters, request: Request, runs: int) -> Answer:
    """What `runs` planned runs tell, with the values known. Raises NoGait."""
    design = DesignPoint(parameters.biped, parameters.slope)
    looked_for = request.looked_for(free_names(design))
    request.check(looked_for, design)
    planned = _, equations, model = planned_equations(parameters, names=looked_for)
    names = model.of_design
    units = [design.unit(name) for name in names]
    known = request.known
    plain = identifiability(*planned, known, runs)
    not_seen = [described(one, names, units, plain.values) for one in plain.unseen]
    lines = not_seen.copy()
    with_scale = plain
    if len(plain.unseen) and not any(one.name == TOTAL_MASS for one in known):
        known = (*known, weighed(parameters.biped))
        with_scale = identifiability(*planned, known, runs)
        lines.append(f"the table assumes a total mass known to {known[-1].sd:.2g} kg")
    single = identifiability(*planned, known, 1)
    lines += _weak(with_scale)
    tried = experiments(parameters, known, runs, looked_for)
    gained = [(what, gains(sd, with_scale) if sd.size else sd, why) for what, sd, why in tried]
    lines += _helped(gained, names)
    more = [[what, *(f"{each:.2f}" for each in gain)] if gain.size else [what, why, *[""] * (len(names) - 1)]
            for what, gain, why in gained]
    counted = f"{runs} run" if runs == 1 else f"{runs} runs"
    return Answer(
        lines=lines,
        tables=[
            (f"What {counted} of {parameters.settings.planned_steps} steps can determine: standard deviations",
             ["parameter", "value", "unit", "one run", counted, "goes with", "correlation", "were it known"],
             [[short(name), f"{with_scale.values[row]:.6g}", units[row], _share(single, row, single.sd),
               _share(with_scale, row, with_scale.sd), short(with_scale.partners[row]),
               f"{with_scale.correlations[row]:+.3f}", _share(with_scale, row, with_scale.sd_without)]
              for row, name in enumerate(with_scale.names)]),
            ("What would help: standard deviations shrink by", ["measurement", *map(short, names)], more),
        ],
        plain={
            "runs": runs,
            "readings": equations.count,
            "parameters": _parameters(with_scale, single, plain, units),
            "not_seen": [{"in_words": words, "shares": dict(zip(names, one.tolist(), strict=True))}
                         for words, one in zip(not_seen, plain.unseen, strict=True)],
            "would_help": [{"what": what, "why_not": why, "gains": dict(zip(names, gain.tolist()))}
                           for what, gain, why in gained],
        },
        draw=partial(_draw, with_scale, single, tried),
    )  # fmt: skip


def _weak(found: Identifiability) -> list[str]:
    """What goes along with something else."""
    return [f"weak: {short(name)} goes with {short(found.partners[row])} (correlation {found.correlations[row]:+.3f}); "
            f"were that known, {short(name)} would be known to {_share(found, row, found.sd_without)}"
            for row, name in enumerate(found.names) if abs(found.correlations[row]) >= STRONG]  # fmt: skip


def _parameters(
    found: Identifiability, single: Identifiability, plain: Identifiability, units: Sequence[str]
) -> dict[str, Any]:
    """The same for JSON, and without the scale."""
    return {name: {"value": found.values[row], "unit": units[row], "sd": float(found.sd[row]),
                   "sd_one_run": float(single.sd[row]), "sd_not_weighed": float(plain.sd[row]),
                   "goes_with": found.partners[row], "correlation": float(found.correlations[row])}
            for row, name in enumerate(found.names)}  # fmt: skip


def _helped(gained: Iterable[tuple[str, np.ndarray, str]], names: Sequence[str]) -> Iterator[str]:
    """What each measurement helps most; nothing of one that does not help."""
    for what, gain, _ in gained:
        most = np.nan_to_num(gain, posinf=1e9)
        words = [f"{short(names[row])} {most[row]:.1f} times" for row in np.argsort(-most)[:3] if most[row] >= WORTH]
        if words:
            yield f"would help: {what}: {listed(words)} as well known"


def _share(found: Identifiability, row: int, sd: np.ndarray) -> str:
    value = sd[row] / abs(found.scales[row])
    return "not determined" if math.isinf(value) else f"{100 * value:.2g} %"


def _draw(
    found: Identifiability, single: Identifiability, tried: Sequence[tuple[str, np.ndarray, str]], save: Any
) -> None:
    """Standard deviations of each parameter: one run, all runs, and with each further measurement."""
    import matplotlib.pyplot as plt

    from stages.drawing import style

    with style.drawing():
        figure, axis = plt.subplots(figsize=(style.TWO_COLUMNS, 0.8 + 0.32 * len(found.names)))
        places = np.arange(len(found.names))
        for rows, colour, label, marker in ((single, style.MEASURED, "one run", "o"),
                                            (found, style.ANALYTIC, f"{found.runs} runs, robot weighed", "s")):
            axis.plot(100 * rows.sd / np.abs(rows.scales), places, marker, color=colour, label=label)
        for colour, (what, sd, _) in zip(("#009E73", "#CC79A7", "#D55E00", "#E69F00", "#8C6D46", "#440154", "#000000"),
                                         [one for one in tried if one[1].size], strict=False):
            axis.plot(100 * sd / np.abs(found.scales), places, "|", color=colour, label=what, markersize=9)
        axis.set_xscale("log")
        style.few_ticks(axis.xaxis, sorted(axis.dataLim.intervalx))
        axis.set_yticks(places, [short(name).replace("_", " ") for name in found.names])
        axis.invert_yaxis()
        axis.set_xlabel("standard deviation [% of the parameter]")
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        save(figure)
