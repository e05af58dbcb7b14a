"""A design as one object whose parameters are reached by name: what continuation and design search vary."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import Field, dataclass, fields, replace
from functools import cache
from typing import Any, get_type_hints

from stages.analytic.model.walker import Walker, build_walker
from stages.biped.design import DETAILS, Biped
from stages.biped.quantity import Bound, faults
from stages.ground.slope import Friction, Slope

_DETAILS = frozenset(f"{Biped.FILE}.{key}" for key in DETAILS)


@dataclass(frozen=True)
class DesignPoint:
    """A biped on a slope, with the friction of its trailing foot where that is limited.

    Names are those of the parameter files: "biped.hip_mass", "ground.slope_deg". A design is `detailed` from when one
    of its details is changed, so that its walker's kind does not change where the detail passes zero.
    """

    biped: Biped
    slope: Slope
    friction: Friction | None = None
    detailed: bool = False

    def walker(self) -> Walker:
        """The design as the integrator sees it."""
        return build_walker(self.biped, self.slope, self.friction, detailed=self.detailed)

    def value(self, name: str) -> float:
        """Value of a parameter, also of one that is not given. Raises KeyError with the known names."""
        owner, key = self._owner(name)
        return owner.number(key) if isinstance(owner, Biped) else float(getattr(owner, key))

    def with_value(self, name: str, value: float) -> DesignPoint:
        """The design with one parameter changed; no rule is checked. Raises KeyError with the known names."""
        return self.with_values({name: value})

    def with_values(self, values: Mapping[str, float]) -> DesignPoint:
        """The design with some parameters changed; no rule is checked. Raises KeyError with the known names."""
        changes: dict[str, dict[str, Any]] = {Biped.FILE: {}, Slope.FILE: {}}
        for name, value in values.items():
            owner, key = self._owner(name)
            changes[owner.FILE][key] = float(value)
        biped, slope = changes[Biped.FILE], changes[Slope.FILE]
        return DesignPoint(
            replace(self.biped, **biped) if biped else self.biped,
            replace(self.slope, **slope) if slope else self.slope,
            self.friction,
            self.having(values).detailed,
        )

    def having(self, names: Iterable[str]) -> DesignPoint:
        """The same design, as a detailed one where a detail is among the parameters `names`, also if that is zero."""
        return replace(self, detailed=self.detailed or not _DETAILS.isdisjoint(names))

    def bound(self, name: str) -> Bound:
        """The range the parameter files allow. Raises KeyError with the known names."""
        bound: Bound = self._field(name).metadata["bound"]
        return bound

    def unit(self, name: str) -> str:
        """Unit of a parameter. Raises KeyError with the known names."""
        return str(self._field(name).metadata["unit"])

    def is_legal(self) -> bool:
        """Whether every value lies in its bounds and all rules hold."""
        return not any(True for owner in (self.biped, self.slope) for _ in faults(owner))

    def _field(self, name: str) -> Field[float]:
        owner, key = self._owner(name)
        return next(field for field in fields(owner) if field.name == key)

    def _owner(self, name: str) -> tuple[Biped | Slope, str]:
        file, _, key = name.partition(".")
        for owner in (self.biped, self.slope):
            if file == owner.FILE and f"{file}.{key}" in parameter_names():
                return owner, key
        raise KeyError(f"{name}: not a number of the design; known are {', '.join(parameter_names())}")


@cache
def parameter_names() -> tuple[str, ...]:
    """Every numeric design parameter that can be varied; looked up for every design of a map."""
    return tuple(
        f"{owner.FILE}.{name}"
        for owner in (Biped, Slope)
        for name, kind in get_type_hints(owner).items()
        if kind in (float, float | None)
    )
