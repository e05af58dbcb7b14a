from dataclasses import dataclass
from typing import ClassVar

from toystages.body.quantity import Bound, Broken, parameter


@dataclass(frozen=True)
class Ground:
    FILE: ClassVar[str] = "ground"
    gravity: float = parameter("m/s^2", "gravity", symbol="g", bound=Bound(above=0, maximum=100))
    contact_stiffness: float = parameter("N/m", "stiffness", symbol="k", bound=Bound(above=0))
    static_friction: float = parameter("1", "static friction", bound=Bound(minimum=0))
    dynamic_friction: float = parameter("1", "dynamic friction", bound=Bound(minimum=0))

    def broken_rules(self):
        if self.dynamic_friction > self.static_friction:
            yield Broken("dynamic_friction", f"<= static_friction = {self.static_friction:g}")


@dataclass(frozen=True)
class Parameters:
    ground: Ground
