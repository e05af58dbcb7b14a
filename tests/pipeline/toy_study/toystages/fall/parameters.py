from dataclasses import dataclass
from typing import ClassVar

from toystages.body.quantity import Bound, parameter


@dataclass(frozen=True)
class Gravity:
    FILE: ClassVar[str] = "ground"
    gravity: float = parameter("m/s^2", "gravity", symbol="g", bound=Bound(above=0, maximum=100))


@dataclass(frozen=True)
class Part:
    name: str = parameter("-", "name")
    mass: float = parameter("kg", "mass", bound=Bound(above=0))


@dataclass(frozen=True)
class Settings:
    FILE: ClassVar[str] = "fall"
    steps: int = parameter("1", "samples", bound=Bound(minimum=1))
    height: float = parameter("m", "height", bound=Bound(minimum=0))
    behaviour: str = parameter(
        "-", "what happens", choices=("well", "raise", "answer", "crash", "exit", "sleep", "extra", "hidden", "disk")
    )
    marks: tuple[float, ...] = parameter("m", "marks", bound=Bound(minimum=0))
    parts: tuple[Part, ...] = parameter("1", "parts")
    label: str = parameter("-", "label", default="none")


@dataclass(frozen=True)
class Parameters:
    gravity: Gravity
    settings: Settings
