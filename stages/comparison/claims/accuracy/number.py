"""One number that a claim was judged by, with its numerical error."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stages.biped.quantity import quantity


@dataclass(frozen=True)
class Number:
    """One number that a claim was judged by."""

    name: str = quantity("-", "field of the claim's numbers, with places inside of it")
    unit: str = quantity("-", "unit of value and error")
    value: float = quantity("-", "value")
    error: float = quantity("-", "numerical error; NaN if unknown")

    def __str__(self) -> str:
        error = "" if math.isnan(self.error) else f" ± {self.error:.1g}"
        return f"{self.name} {self.value:.6g}{error}"
