"""How far the numbers of a gait may be off because the values of its design are known to a last digit only.

Linear, by exact derivatives: all half-widths at their worst together, and as independent errors (root of the sum of
squares); those of fitted values in both as they go together. The slope, which is not the design's, apart and solved
for. Multipliers are derived only by values that are not exact.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import fields
from types import MappingProxyType

import numpy as np

from stages.analytic.derivatives.gait import GaitTangents
from stages.analytic.derivatives.multipliers import MultiplierDerivatives, multiplier_derivatives
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import describe
from stages.analytic.gait.poincare import SEARCH_TOLERANCE, FixedPoint, fixed_point
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.result import Elasticities, Uncertainty
from stages.biped.walk import Gait, StanceState

SLOPE = "ground.slope_deg"
#: The numbers of a gait with an elasticity.
MEASURES = ("period_s", "step_frequency_hz", "step_length_m", "speed_m_s")
#: Gaits solved on the way to either edge, and the least part of it that is tried where a gait is lost.
PARTS, LEAST_PART = 8, 1 / 128
#: What round-off may leave of a sum of squares, in shares of it.
ROUNDED = 1e-9
#: Errors of which none goes with another.
INDEPENDENT: Mapping[tuple[str, str], float] = MappingProxyType({})


def numbers_at(walker: Walker, point: FixedPoint, multipliers: int) -> dict[str, float]:
    """Measures, magnitudes of the first multipliers, and the state just after heel strike, in SI units."""
    described = describe(walker, point)
    numbers = {name: float(getattr(described, name)) for name in MEASURES}
    magnitudes = np.abs(point.floquet_multipliers[:multipliers])
    numbers |= {f"multiplier_{index}": float(value) for index, value in enumerate(magnitudes, 1)}
    return numbers | vars(described.fixed_point)


def towards(
    design: DesignPoint, gait: GaitTangents, changes: Mapping[str, float]
) -> Iterator[tuple[float, Walker, FixedPoint]]:
    """Gaits on the way to the design with parameters changed by so much, and the share of the way at each.

    Of `PARTS`, smaller ones where the gait is about to be lost; the tangent and then the last two lead to the next.
    """
    sizes = np.array([changes.get(name, 0.0) for name in gait.changes.names]) / gait.changes.scales
    z, tangent, way, part = gait.point.z, gait.z @ sizes, 0.0, 1.0 / PARTS
    while way < 1.0 and part >= LEAST_PART:
        ahead = min(way + part, 1.0)
        there = design.with_values({name: design.value(name) + ahead * change for name, change in changes.items()})
        point = None
        if there.is_legal() and there.slope.angle > 0.0:
            walker = there.walker()
            tolerance = attainable_tolerance(walker.p, SEARCH_TOLERANCE)
            point = fixed_point(walker, z + (ahead - way) * tangent, tolerance)
        if point is None:
            part /= 2.0
            continue
        tangent = (point.z - z) / (ahead - way)
        z, way = point.z, ahead
        yield way, walker, point


def over_slopes(
    design: DesignPoint, gait: GaitTangents, half_width: float, multipliers: int
) -> dict[str, tuple[float, float]]:
    """Least and most of each number of the gait on slopes within `half_width` [deg]; NaN if the gait is lost there.

    Multipliers by their rank.
    """
    seen = [numbers_at(gait.walker, gait.point, multipliers)]
    for edge in (-half_width, half_width):
        found = list(towards(design, gait, {SLOPE: edge}))
        seen += [numbers_at(walker, point, multipliers) for _, walker, point in found]
        if not found or found[-1][0] < 1.0:
            return dict.fromkeys(seen[0], (np.nan, np.nan))
    return {name: (min(one[name] for one in seen), max(one[name] for one in seen)) for name in seen[0]}


def elasticities_of(gait: GaitTangents, half_widths: Mapping[str, float]) -> tuple[Elasticities, ...]:
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
    design: DesignPoint, gait: GaitTangents, half_widths: Mapping[str, float],
    multipliers: MultiplierDerivatives | None = None, correlations: Mapping[tuple[str, str], float] = INDEPENDENT,
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
                    slopes.get(name, (value, value)), correlations)
        for name, unit, value, change in numbers_of(inexact, known))


def uncertainty(
    name: str, unit: str, value: float, parts: Mapping[str, float], slopes: tuple[float, float],
    correlations: Mapping[tuple[str, str], float] = INDEPENDENT,
) -> Uncertainty:  # fmt: skip
    """One number that each parameter may move by its part, and that lies between `slopes` on slopes that may be."""
    of_values = {each: float(part) for each, part in parts.items() if each != SLOPE}
    sizes = {each: abs(part) for each, part in of_values.items()}
    tied = {each for pair in correlations for each in pair}
    at_worst = [together({each: part for each, part in of_values.items() if each in tied}, correlations),
                *(size for each, size in sizes.items() if each not in tied)]  # fmt: skip
    known = all(map(math.isfinite, sizes.values()))
    decisive = max(sizes, key=lambda each: sizes[each], default="") if known else ""
    return Uncertainty(name, unit, value, math.fsum(at_worst), together(of_values, correlations), decisive,
                       sizes.get(decisive, 0.0 if known else float("nan")), *slopes)


def together(parts: Mapping[str, float], correlations: Mapping[tuple[str, str], float]) -> float:
    """Root of the sum of squares of parts by the names of their parameters, whose errors may go together; NaN of errors
    that cannot go together so."""
    squares = math.fsum(part**2 for part in parts.values())
    total = math.fsum((squares, *(2.0 * parts[one] * parts[other] * share for (one, other), share in
                                  correlations.items() if one in parts and other in parts)))  # fmt: skip
    return math.sqrt(max(total, 0.0)) if total >= -ROUNDED * squares else math.nan


def numbers_of(gait: GaitTangents, multipliers: MultiplierDerivatives) -> list[tuple[str, str, float, Vector]]:
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
