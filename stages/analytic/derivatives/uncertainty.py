"""How far the numbers of a gait may be off because the values of its design are known to a last digit only.

Linear, by exact derivatives: all half-widths at their worst together, and as independent errors (root of the sum of
squares). The slope, which is not the design's, apart and solved for. Multipliers are derived only by values that are
not exact.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

import numpy as np

from stages.analytic.derivatives.gait import VariedGait
from stages.analytic.derivatives.multipliers import MultiplierDerivatives, multiplier_derivatives
from stages.analytic.derivatives.slope_range import MEASURES, SLOPE, over_slopes
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import describe
from stages.analytic.model.walker import Vector
from stages.analytic.result import Elasticities, Uncertainty
from stages.biped.gait import Gait, StanceState


def elasticities_of(gait: VariedGait, half_widths: Mapping[str, float]) -> tuple[Elasticities, ...]:
    """How the gait answers to each parameter; `half_widths` by file.key, none for an exact value."""
    changes, shares = gait.changes, gait.elasticities()
    return tuple(
        Elasticities(
            parameter=name,
            unit=changes.units[row],
            value=float(changes.values[row]),
            half_width=half_widths.get(name, 0.0),
            scale=float(changes.scales[row]),
            period=float(shares["period_s"][row]),
            step_length=float(shares["step_length_m"][row]),
            speed=float(shares["speed_m_s"][row]),
        )
        for row, name in enumerate(changes.names)
    )


def uncertainties_of(
    design: DesignPoint, gait: VariedGait, half_widths: Mapping[str, float],
    multipliers: MultiplierDerivatives | None = None,
) -> tuple[Uncertainty, ...]:  # fmt: skip
    """How far measures, leading multipliers and fixed point of the design's gait may be off; none if all is exact.

    `multipliers` are its derivatives by the same parameters where they are known already.
    """
    names = [name for name in gait.changes.names if half_widths.get(name)]
    inexact = gait.only(names)
    if not names:
        return ()
    known = multiplier_derivatives(inexact) if multipliers is None else multipliers.only(gait.rows(names))
    widths = np.array([half_widths[name] for name in inexact.changes.names]) / inexact.changes.scales
    slopes = over_slopes(design, inexact, half_widths[SLOPE], len(known.values)) if SLOPE in names else {}
    return tuple(
        uncertainty(name, unit, value, dict(zip(inexact.changes.names, change * widths, strict=True)),
                    slopes.get(name, (value, value)))
        for name, unit, value, change in numbers_of(inexact, known))


def uncertainty(
    name: str, unit: str, value: float, parts: Mapping[str, float], slopes: tuple[float, float]
) -> Uncertainty:
    """One number that each parameter may move by its part, and that lies between `slopes` on slopes that may be."""
    sizes = {each: abs(float(part)) for each, part in parts.items() if each != SLOPE}
    of_design = np.array(list(sizes.values()))
    known = bool(np.isfinite(of_design).all())
    decisive = max(sizes, key=lambda each: sizes[each], default="") if known else ""
    return Uncertainty(name, unit, value, float(of_design.sum()), float(np.sqrt((of_design**2).sum())), decisive,
                       sizes.get(decisive, 0.0 if known else float("nan")), *slopes)


def numbers_of(gait: VariedGait, multipliers: MultiplierDerivatives) -> list[tuple[str, str, float, Vector]]:
    """Name, unit, value and derivatives (n,) for whole shares of the parameters, of every number that has them."""
    described, shares = describe(gait.walker, gait.point), gait.elasticities()
    units = {field.name: field.metadata["unit"] for cls in (Gait, StanceState) for field in fields(cls)}
    found = [(name, units[name], float(getattr(described, name))) for name in MEASURES]
    numbers = [(name, unit, value, value * shares[name]) for name, unit, value in found]
    for index, (value, row) in enumerate(zip(multipliers.values, multipliers.elasticities(), strict=True), 1):
        numbers.append((f"multiplier_{index}", "1", float(abs(value)), float(abs(value)) * row))
    names = [field.name for field in fields(StanceState)]
    for name, row in zip(names[::2] if gait.walker.rigid else names, gait.walker.scales()[:, None] * gait.state,
                         strict=True):  # fmt: skip
        numbers.append((name, units[name], float(getattr(described.fixed_point, name)), row))
    return numbers
