"""How the walker's numbers change with the parameters of a design, and which parameters there are.

The units stay those of the design: a longer leg changes L_nat alone, not the unit of length. So parameters of all
dimensions move numbers of their own, and the sum rules that dimensions set are not built in.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import MISSING, Field, dataclass, fields, replace
from typing import Any

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.kinds import present
from stages.analytic.model.walker import Vector, Walker
from stages.biped.accuracy.scales import powers
from stages.biped.design import Biped
from stages.ground.slope import Friction, Slope


@dataclass(frozen=True)
class Changes:
    """Parameters and what a share of each does to the walker's numbers.

    `names` as in the parameter files; `values` and `units` of the parameters; `scales` (n,): a whole share of each, its
    value, or where that is zero a size it could have; `along` (n, fields of the numbers): their change for that.
    """

    names: tuple[str, ...]
    values: Vector
    units: tuple[str, ...]
    scales: Vector
    along: np.ndarray

    def only(self, rows: Sequence[int]) -> Changes:
        """Some of the parameters."""
        names, units = (tuple(each[row] for row in rows) for each in (self.names, self.units))
        chosen = list(rows)
        return Changes(names, self.values[chosen], units, self.scales[chosen], self.along[chosen])


def sensitive_names(design: DesignPoint, uncertain: Collection[str] = ()) -> tuple[str, ...]:
    """Every parameter on which the gait of a design of this kind depends, of the details those that are there, or that
    are among the `uncertain`."""
    every = _fields(design.having(uncertain))
    return tuple(name for owner, field in every if (name := f"{owner.FILE}.{field.name}") in uncertain
                 or field.default is MISSING or getattr(owner, field.name) != field.default)


def changes_of(design: DesignPoint, names: Iterable[str]) -> Changes:
    """What shares of the parameters `names` do to the walker's numbers. Raises KeyError with the known names."""
    known = {f"{owner.FILE}.{field.name}": (owner, field) for owner, field in _fields(design)}
    walker = design.walker()
    values, units, scales, rows = [], [], [], []
    chosen = tuple(names)
    for name in chosen:
        if name not in known:
            raise KeyError(f"{name}: the gait of this design has no such parameter; it has {', '.join(known)}")
        owner, field = known[name]
        value = float(getattr(owner, field.name))
        scale = value or sizes(design.biped, design.slope)[field.metadata["unit"]]
        values.append(value)
        units.append(field.metadata["unit"])
        scales.append(scale)
        rows.append(_row(design, walker, field, scale))
    width = len(walker.p._fields)
    return Changes(chosen, np.array(values), tuple(units), np.array(scales), np.array(rows).reshape(-1, width))


def moved(walker: Walker, change: Vector) -> Walker:
    """The walker with its numbers changed, in the same units."""
    numbers: Any = type(walker.p)
    return replace(walker, p=numbers(*(np.array(walker.p) + change).tolist()))


def _fields(design: DesignPoint) -> list[tuple[Any, Field[Any]]]:
    """The numbers of the design that move the walker's, with the object that holds each. The angle at which a hip's
    spring is relaxed sets legs apart that are alike: to first order it does to one step the opposite of the next.
    """
    numbers = {*present(design.walker().p), "a", "g"} - ({"phi_h"} if design.biped.alike else set())
    owners = (design.biped, design.slope, *((design.friction,) if design.friction else ()))
    return [(owner, field) for owner in owners for field in fields(owner)
            if field.metadata["symbol"] in numbers and getattr(owner, field.name) is not None
            and (not isinstance(owner, Friction) or any(owner.moved_by(field.name)))]


def sizes(biped: Biped, slope: Slope) -> dict[str, float]:
    """By unit, a size that a parameter could have which is zero."""
    mass, length = biped.foot_mass, biped.leg_length
    torque = mass * slope.gravity * length / 10
    return {"kg": mass, "m": length, "kg m^2": mass * (length / 10) ** 2, "deg": 1.0, "1": 1.0, "rad": 1.0,
            "N s/m": math.sqrt(biped.stiffness * mass), "N m/rad": torque, "N m": torque / 10,
            "N m s/rad": torque * math.sqrt(length / slope.gravity)}  # fmt: skip


def _row(design: DesignPoint, walker: Walker, field: Field[Any], change: float) -> Sequence[float]:
    """Change of the walker's numbers with one parameter, in units of the design."""
    slope, mass, length, time = design.slope, walker.mass, walker.length, walker.time
    inertia, symbol = mass * length**2, field.metadata["symbol"]
    units = {"M": mass, "M_g": mass, "m": mass, "m_f": mass, "L_nat": length, "r": length, "l": length, "e": length,
             "l_f": length, "e_f": length, "k": mass / time**2, "b": mass / time, "I": inertia, "I_f": inertia,
             "k_h": inertia / time**2, "b_h": inertia / time, "tau_h": inertia / time**2, "phi_h": -1.0,
             "T": time}
    if symbol == "a":
        turn = math.radians(change)
        moved = {"g_x": turn * math.cos(slope.angle), "g_y": turn * math.sin(slope.angle)}
    elif symbol == "g":
        share = change / slope.gravity
        moved = {"g_x": share * math.sin(slope.angle), "g_y": -share * math.cos(slope.angle)}
    elif design.friction and symbol in ("mu_s", "mu_d"):
        static, dynamic = design.friction.moved_by(field.name)
        moved = {"mu_s": static * change, "mu_d": dynamic * change}
    else:
        moved = dict.fromkeys(_moved(design.biped, field), change / units[symbol.removesuffix("_2")])
    return [moved.get(name, 0.0) for name in walker.p._fields]


def _moved(biped: Biped, field: Field[Any]) -> tuple[str, ...]:
    """The walker's numbers that a parameter of the design is: of both legs, where the other one gives none."""
    symbol = field.metadata["symbol"]
    if symbol == "M" and biped.hip_gravity_mass is None:
        return "M", "M_g"
    if getattr(biped, f"other_{field.name}", 0.0) is None:
        return symbol, f"{symbol}_2"
    return (symbol,)


def left_by_dimensions(elasticities: Vector, units: Sequence[str], unit: str) -> Vector:
    """What the elasticities (n,) of a measure in `unit` leave of the rules of mass, length and time, (3,): no more than
    errors.

    `units` (n,) are those of the parameters, which must be all that have a unit. Raises KeyError for another unit.
    """
    of_each = np.array([powers(each) for each in units], dtype=float).reshape(-1, 3)
    return np.asarray(of_each.T @ np.asarray(elasticities) - np.array(powers(unit), dtype=float))
