"""What runs can tell, as text, JSON and picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from stages.biped.question import Answer
from stages.calibration.estimation.least_squares import TOTAL_MASS
from stages.calibration.estimation.request import Request
from stages.calibration.information.identifiability import (
    Experiment,
    Identifiability,
    described,
    experiments,
    finite,
    gains,
    identifiability,
    listed,
    plan_of,
    planned_equations,
    short,
    weighed,
)
from stages.calibration.parameters import Parameters

#: A correlation from which on two errors are hard to tell apart, and a gain that is worth a line.
STRONG, WORTH = 0.9, 1.25


def planned(parameters: Parameters, request: Request, runs: int) -> Answer:
    """What `runs` planned runs tell, with the values known. Raises NoGait."""
    plan = plan_of(parameters)
    equations, model = planned_equations(plan, parameters)
    names = model.of_design
    units = [plan.design.unit(name) for name in names]
    known = request.known
    plain = identifiability(plan.design, equations, model, known, runs)
    not_seen = [described(one, names, units, plain.values) for one in plain.unseen]
    lines = not_seen.copy()
    with_scale = plain
    if len(plain.unseen) and not any(one.name == TOTAL_MASS for one in known):
        known = (*known, weighed(plan))
        with_scale = identifiability(plan.design, equations, model, known, runs)
        lines.append(f"the table assumes a total mass known to {known[-1].sd:.2g} kg")
    single = identifiability(plan.design, equations, model, known, 1)
    lines += _weak(with_scale)
    tried = experiments(plan, known, runs, parameters)
    gained = [(one, gains(one, with_scale) if one.sd.size else None) for one in tried]
    lines += [line for one, gain in gained if gain is not None for line in _helped(one, gain, names)]
    more = [_row_of(one, gain, len(names)) for one, gain in gained]
    counted = f"{runs} run" if runs == 1 else f"{runs} runs"
    return Answer(
        lines=lines,
        tables=[
            (f"What {counted} of {plan.steps} steps can determine: standard deviations",
             ["parameter", "value", "unit", "one run", counted, "goes with", "correlation", "were it known"],
             _rows(with_scale, single, units)),
            ("What would help: standard deviations shrink by", ["measurement", *map(short, names)], more),
        ],
        plain={
            "runs": runs,
            "readings": equations.count,
            "parameters": _parameters(with_scale, single, plain, units),
            "not_seen": [{"in_words": words, "shares": dict(zip(names, one.tolist(), strict=True))}
                         for words, one in zip(not_seen, plain.unseen, strict=True)],
            "would_help": [_as_plain(one, gain, names) for one, gain in gained],
        },
        draw=partial(_draw, with_scale, single, tried),
    )  # fmt: skip


def _weak(found: Identifiability) -> list[str]:
    """What goes along with something else."""
    return [f"weak: {short(name)} goes with {short(one.name)} (correlation {one.correlation:+.3f}); were that known, "
            f"{short(name)} would be to {_share(found, row, one.sd_without)}"
            for row, (name, one) in enumerate(zip(found.names, found.partners, strict=True))
            if abs(one.correlation) >= STRONG]  # fmt: skip


def _rows(found: Identifiability, single: Identifiability, units: Sequence[str]) -> list[list[str]]:
    """The table's rows."""
    return [[short(name), f"{found.values[row]:.6g}", units[row], _share(single, row), _share(found, row),
             short(one.name), f"{one.correlation:+.3f}", _share(found, row, one.sd_without)]
            for row, (name, one) in enumerate(zip(found.names, found.partners, strict=True))]  # fmt: skip


def _parameters(
    found: Identifiability, single: Identifiability, plain: Identifiability, units: Sequence[str]
) -> dict[str, Any]:
    """The same for JSON, and without the scale."""
    return {name: {"value": found.values[row], "unit": units[row], "sd": finite(found.sd[row]),
                   "sd_one_run": finite(single.sd[row]), "sd_not_weighed": finite(plain.sd[row]),
                   "goes_with": one.name, "correlation": one.correlation}
            for row, (name, one) in enumerate(zip(found.names, found.partners, strict=True))}  # fmt: skip


def _row_of(tried: Experiment, gain: np.ndarray | None, count: int) -> list[str]:
    """A measurement and what it gains, or why it gains nothing, as a row of the table."""
    return [tried.what, tried.why, *[""] * (count - 1)] if gain is None else [tried.what, *(f"{g:.2f}" for g in gain)]


def _as_plain(tried: Experiment, gain: np.ndarray | None, names: Sequence[str]) -> dict[str, Any]:
    """A measurement and what it gains, for JSON."""
    gains_of = {} if gain is None else dict(zip(names, map(finite, gain), strict=True))
    return {"what": tried.what, "why_not": tried.why, "gains": gains_of}


def _helped(tried: Experiment, gain: np.ndarray, names: tuple[str, ...]) -> list[str]:
    """What a measurement helps most; nothing of one that does not help."""
    gain = np.nan_to_num(gain, posinf=1e9)
    words = [f"{short(names[row])} {gain[row]:.1f} times" for row in np.argsort(-gain)[:3] if gain[row] >= WORTH]
    return [f"would help: {tried.what}: {listed(words)} as well known"] if words else []


def _share(found: Identifiability, row: int, sd: float | None = None) -> str:
    value = (found.sd[row] if sd is None else sd) / found.scales[row]
    return "not determined" if math.isinf(value) else f"{100 * value:.2g} %"


def _draw(found: Identifiability, single: Identifiability, tried: list[Experiment], save: Any) -> None:
    """Standard deviations of each parameter: one run, all runs, and with each further measurement."""
    import matplotlib.pyplot as plt

    from stages.drawing import style

    with style.drawing():
        figure, axis = plt.subplots(figsize=(style.TWO_COLUMNS, 0.8 + 0.32 * len(found.names)))
        places = np.arange(len(found.names))
        for rows, colour, label, marker in ((single, style.MEASURED, "one run", "o"),
                                            (found, style.ANALYTIC, f"{found.runs} runs, robot weighed", "s")):
            axis.plot(100 * rows.sd / rows.scales, places, marker, color=colour, label=label)
        for colour, one in zip(("#009E73", "#CC79A7", "#D55E00", "#E69F00", "#8C6D46", "#440154", "#000000"),
                               [one for one in tried if one.sd.size], strict=False):
            axis.plot(100 * one.sd / found.scales, places, "|", color=colour, label=one.what, markersize=9)
        axis.set_xscale("log")
        style.few_ticks(axis.xaxis, sorted(axis.dataLim.intervalx))
        axis.set_yticks(places, [short(name).replace("_", " ") for name in found.names])
        axis.invert_yaxis()
        axis.set_xlabel("standard deviation [% of the parameter]")
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        save(figure)
