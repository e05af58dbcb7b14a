"""`sensitivity`: how the gait answers to each parameter of its design."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stages.biped.question import Answer, Asking, Question, as_plain as plain, elasticity, option, refuse

if TYPE_CHECKING:
    from stages.analytic.derivatives.gait import GaitTangents
    from stages.analytic.derivatives.multipliers import MultiplierDerivatives
    from stages.analytic.parameters import Parameters
    from stages.analytic.result import OnBlocks, Uncertainty

#: Measures with a word for the head of their column, and their units.
HEADS = {"period_s": "period", "step_frequency_hz": "freq.", "step_length_m": "length", "speed_m_s": "speed"}
UNITS = {"period_s": "s", "step_frequency_hz": "Hz", "step_length_m": "m", "speed_m_s": "m/s"}
#: So many multipliers have a column; JSON has all that lead.
COLUMNS = 3


@dataclass(frozen=True)
class Options:
    """Options of `sensitivity`."""

    parameters: tuple[str, ...] = option(
        "-", "Parameter to differentiate by, instead of all that the gait depends on; repeatable", default=(),
        metavar="FILE.KEY")


@dataclass(frozen=True)
class Sensitivity:
    """The gait with all its derivatives, its measures in SI units, and what is left of the rules of dimensions."""

    gait: GaitTangents
    multipliers: MultiplierDerivatives
    measures: dict[str, float]
    left: float | None
    uncertainties: tuple[Uncertainty, ...]
    on_blocks: OnBlocks | None


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Derivatives of the most stable gait. Raises NoGait, WrongOption."""
    from stages.analytic.derivatives.gait import gait_derivatives
    from stages.analytic.derivatives.multipliers import multiplier_derivatives
    from stages.analytic.derivatives.numbers import sensitive_names
    from stages.analytic.derivatives.on_blocks import on_blocks
    from stages.analytic.derivatives.uncertainty import uncertainties_of
    from stages.analytic.gait.design_point import DesignPoint
    from stages.analytic.gait.gait_search import describe, find_gait

    friction, tolerance = parameters.limited_friction, parameters.settings.tolerance
    design = DesignPoint(parameters.biped, parameters.slope, friction)
    every = sensitive_names(design, {*parameters.half_widths, *options.parameters})
    names = tuple(dict.fromkeys(options.parameters)) or every
    refuse(*((name not in every, f"--parameters {name}: this gait has no such number; it has {', '.join(every)}")
             for name in names))
    walker, point = find_gait(parameters.biped, parameters.slope, tolerance, friction)
    asking.progress(0.5, "derivatives")
    gait = gait_derivatives(design, point, names, tolerance)
    asking.progress(0.8, "multipliers")
    described = describe(walker, point)
    measures = {name: float(getattr(described, name)) for name in HEADS}
    multipliers = multiplier_derivatives(gait)
    open_to = uncertainties_of(design, gait, parameters.half_widths, multipliers, parameters.correlations)
    found = Sensitivity(gait, multipliers, measures, what_is_left(gait) if names == every else None, open_to,
                        on_blocks(walker, point, tolerance))

    def draw(save: Any) -> None:
        from stages.analytic.pictures import gaits
        from stages.drawing import style

        with style.drawing():
            save(gaits.draw_elasticities(gait, found.multipliers))

    idle = (f"{name}: +- {width:g} not counted, as there is no derivative by it at 0"
            for name, width in parameters.half_widths.items() if name not in every and not design.value(name))
    plain = as_plain(found)
    rows = [{"parameter": name, **row} for name, row in plain["parameters"].items()]
    return Answer([*lines(found), *idle], plain, rows=rows, draw=draw)


def what_is_left(gait: GaitTangents) -> float:
    """The most that any measure's elasticities leave of the rules that dimensions set."""
    import numpy as np

    from stages.analytic.derivatives.numbers import left_by_dimensions

    shares = np.where(gait.changes.values == 0, 0.0, 1.0)
    return max(
        float(np.abs(left_by_dimensions(shares * values, gait.changes.units, UNITS[name])).max())
        for name, values in gait.elasticities().items())


def lines(found: Sensitivity) -> Iterator[str]:
    """The answer in words, at most 80 columns wide."""
    from stages.analytic.derivatives.multipliers import shown

    changes, measures, multipliers = found.gait.changes, found.measures, found.multipliers
    yield (f"gait: {measures['step_frequency_hz']:.5g} Hz, steps of {measures['step_length_m']:.5g} m, "
           f"{measures['speed_m_s']:.5g} m/s")
    of = " of two steps" if len(found.gait.point.steps) > 1 else ""
    yield f"leading multipliers{of}: {', '.join(map(shown, multipliers.values))}"
    yield ""
    yield "Elasticities: by how many percent a measure changes for 1 % of a parameter."
    shares = found.gait.elasticities()
    columns = {head: shares[name] for name, head in HEADS.items()}
    columns |= {f"|mu{i + 1}|": row for i, row in enumerate(multipliers.elasticities()[:COLUMNS])}
    yield f"{'':23}" + "".join(f"{head:>8}" for head in columns)
    for row, name in enumerate(changes.names):
        if changes.values[row] != 0:
            yield f"{name:23}" + "".join(elasticity(values[row], 8) for values in columns.values())
    for row, name in enumerate(changes.names):
        if changes.values[row] == 0:
            yield f"{name} is 0; with it, in {changes.units[row]}:"
            for measure, values in shares.items():
                slope = measures[measure] * values[row] / changes.scales[row]
                yield f"  {measure:21}{slope:>+12.4g} {UNITS[measure]}"
    if found.left is not None:
        yield f"dimensions: masses, lengths and times add up as they must, to {found.left:.1g}"
    if found.on_blocks is not None:
        yield "On blocks of drawn heights, to first order, by the rms height of blocks:"
        yield f"  spread of a step's duration {found.on_blocks.sensitivity_norm:>12.4g} s/m (gait sensitivity norm)"
        yield f"  spread of its length        {found.on_blocks.step_length_spread:>12.4g}"
    yield from multipliers.refused
    yield from open_lines(found.uncertainties)


def open_lines(uncertainties: Sequence[Uncertainty]) -> Iterator[str]:
    """What rounded or uncertain values leave open, in words."""
    of_gait = [one for one in uncertainties if one.name in UNITS or one.name.startswith("multiplier")]
    if of_gait:
        yield ""
        yield "Uncertainty from rounded or uncertain values: +- for all at their worst, and as"
        yield "independent errors, or as they were fitted (linear); by which most; over slopes."
        yield f"{'':17}{'value':>9}{'worst':>9}{'indep.':>9}  {'most by':18}{'over slopes'}"
    for one in of_gait:
        name = one.name.replace("multiplier_", "|mu") + ("|" if one.name not in UNITS else "")
        slopes = ("" if one.slope_least == one.slope_most else "no gait on some" if math.isnan(one.slope_least)
                  else f"{one.slope_least:.4g} .. {one.slope_most:.4g}")
        key, sizes = one.decisive.partition(".")[2], one.worst > 0.0
        of_design = f"{one.worst:>9.2g}{one.independent:>9.2g}  {key:18}" if sizes else f"{'':38}"
        yield f"{name:17}{one.value:>9.4g}{of_design}{slopes}".rstrip()


def as_plain(found: Sensitivity) -> dict[str, Any]:
    """The answer as JSON: for each parameter elasticities (none for one that is zero) and derivatives per unit."""
    changes, multipliers = found.gait.changes, found.multipliers
    shares, of_multipliers = found.gait.elasticities(), multipliers.elasticities()
    by_parameter = {}
    for row, name in enumerate(changes.names):
        scale, is_zero = float(changes.scales[row]), changes.values[row] == 0
        by_parameter[name] = {
            "value": float(changes.values[row]),
            "unit": changes.units[row],
            "elasticities": None if is_zero else {
                **{measure: float(values[row]) for measure, values in shares.items()},
                "multipliers": [known(values[row]) for values in of_multipliers]},
            "derivatives": {
                **{measure: found.measures[measure] * float(values[row]) / scale for measure, values in shares.items()},
                "multipliers": [[known(value.real), known(value.imag)] for value in
                                multipliers.derivatives[:, row] / scale]},
        }  # fmt: skip
    return {
        "gait": found.measures,
        "multipliers": [[float(value.real), float(value.imag)] for value in multipliers.values],
        "multiplier_steps": len(found.gait.point.steps),
        "parameters": by_parameter,
        "refused": list(multipliers.refused),
        "left_by_dimensions": found.left,
        "uncertainties": [plain(one) for one in found.uncertainties],
        "on_blocks": None if found.on_blocks is None else plain(found.on_blocks),
    }


def known(value: float) -> float | None:
    """A number for JSON, none for NaN."""
    return float(value) if value == value else None


QUESTION = Question(
    "sensitivity",
    """Print by how many percent the gait changes for 1 % of each parameter, by exact derivatives.

    Period, step frequency, step length, speed and the leading multipliers of the most stable gait, by every parameter
    of the design, slope, gravity and, with analytic.transition=coulomb, friction. Last comes the uncertainty from
    rounded parameters, with the one that contributes most. --json and --csv add derivatives in SI units.
    """,
    Options,
    ask,
    examples=("bipedstudy sensitivity --parameters biped.foot_radius",),
    draws=True,
    rows=True,
)
