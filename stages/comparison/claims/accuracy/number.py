"""One number that a claim was judged by, with its numerical error."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stages.biped.quantity import quantity


@dataclass(frozen=True)
class Number:
    """One number that a claim was judged by."""

    name: str = quantity("-", "field of the claim's numbers, with places inside of it")
    value: float = quantity("1", "value, in the unit of its field")
    error: float = quantity("1", "numerical error, same unit; NaN if unknown")

    def __str__(self) -> str:
        error = "" if math.isnan(self.error) else f" ± {self.error:.1g}"
        return f"{self.name} {self.value:.6g}{error}"
