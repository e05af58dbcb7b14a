"""What runs can tell, as text, JSON and picture."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stages.biped.question import Answer
from stages.calibration.estimation.asked import Asked
from stages.calibration.estimation.known import TOTAL_MASS
from stages.calibration.information.experiments import Experiment, experiments, gains, weighed
from stages.calibration.information.identifiability import Identifiability, identifiability
from stages.calibration.information.plan import plan_of, planned_equations
from stages.calibration.information.words import described, listed, short
from stages.calibration.parameters import Parameters

#: A correlation from which on two errors are hard to tell apart, and a gain that is worth a line.
STRONG, WORTH = 0.9, 1.25


def told(parameters: Parameters, asked: Asked, runs: int) -> Answer:
    """What `runs` planned runs tell, with the values known. Raises NoGait."""
    plan = plan_of(parameters)
    equations, model = planned_equations(plan, parameters)
    names = (*model.shared, *model.own)
    units = [plan.design.unit(name) for name in names]
    plain = identifiability(plan.design, equations, model, asked.known, runs)
    lines = [described(one, names, units, plain.values) for one in plain.unseen]
    known = asked.known
    if len(plain.unseen) and not any(one.name == TOTAL_MASS for one in known):
        known = (*known, weighed(plan))
        with_scale = identifiability(plan.design, equations, model, known, runs)
        lines.append(f"the table takes the robot as weighed to {known[-1].sd:.2g} kg")
    else:
        with_scale = plain
    single = identifiability(plan.design, equations, model, known, 1)
    for row, partner in enumerate(with_scale.partners):
        if abs(partner.correlation) >= STRONG:
            lines.append(
                f"weak: {short(names[row])} goes with {short(partner.name)} (correlation {partner.correlation:+.3f}); "
                f"were that known, {short(names[row])} would be to {_share(with_scale, row, partner.sd_without)}")
    tried = experiments(plan, known, runs, parameters)
    best = _best(tried, with_scale)
    lines += best
    rows = [
        [short(name), f"{with_scale.values[row]:.6g}", units[row], _share(single, row), _share(with_scale, row),
         short(partner.name), f"{partner.correlation:+.3f}", _share(with_scale, row, partner.sd_without)]
        for row, (name, partner) in enumerate(zip(names, with_scale.partners, strict=True))
    ]
    more = [[one.what, *(f"{gain:.2f}" for gain in gains(one, with_scale))] if one.sd.size else
            [one.what, one.why, *[""] * (len(names) - 1)] for one in tried]
    counted = "run" if runs == 1 else "runs"
    return Answer(
        lines=lines,
        tables=[
            (f"What {runs} {counted} of {plan.steps} steps tell: standard deviations",
             ["parameter", "value", "unit", "one run", f"{runs} {counted}", "goes with", "correlation",
              "were it known"],
             rows),
            ("What would help: standard deviations shrink by", ["measurement", *map(short, names)], more),
        ],
        plain={
            "runs": runs,
            "readings": equations.count,
            "parameters": {
                name: {"value": with_scale.values[row], "unit": units[row], "sd": _finite(with_scale.sd[row]),
                       "sd_one_run": _finite(single.sd[row]), "sd_not_weighed": _finite(plain.sd[row]),
                       "goes_with": with_scale.partners[row].name,
                       "correlation": with_scale.partners[row].correlation}
                for row, name in enumerate(names)
            },
            "not_seen": [{"in_words": described(one, names, units, plain.values),
                          "shares": dict(zip(names, one.tolist(), strict=True))} for one in plain.unseen],
            "would_help": [{"what": one.what, "why_not": one.why,
                            "gains": dict(zip(names, map(_finite, gains(one, with_scale)), strict=True)) if one.sd.size
                            else {}} for one in tried],
        },
        draw=lambda save: _draw(with_scale, single, tried, save),
    )  # fmt: skip


def _best(tried: list[Experiment], before: Identifiability) -> list[str]:
    """For each measurement that helps: what it helps most."""
    lines = []
    for one in tried:
        if not one.sd.size:
            continue
        gain = np.nan_to_num(gains(one, before), posinf=1e9)
        helped = [row for row in np.argsort(-gain) if gain[row] >= WORTH]
        if helped:
            words = [f"{short(before.names[row])} {gain[row]:.1f} times" for row in helped[:3]]
            lines.append(f"would help: {one.what}: {listed(words)} as well known")
    return lines


def _share(found: Identifiability, row: int, sd: float | None = None) -> str:
    value = (found.sd[row] if sd is None else sd) / found.scales[row]
    return "not seen" if math.isinf(value) else f"{100 * value:.2g} %"


def _finite(value: Any) -> float | None:
    return float(value) if math.isfinite(value) else None


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
        axis.set_yticks(places, [short(name).replace("_", " ") for name in found.names])
        axis.invert_yaxis()
        axis.set_xlabel("standard deviation [% of the parameter]")
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        save(figure)
