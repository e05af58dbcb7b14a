from dataclasses import dataclass
from typing import ClassVar

from toystages.body.quantity import Bound, parameter


@dataclass(frozen=True)
class Settings:
    FILE: ClassVar[str] = "side"
    seed: int = parameter("1", "seed", bound=Bound(minimum=0))
    wait: float = parameter("s", "time it takes", bound=Bound(minimum=0))
    table: str | None = parameter("-", "a file of the user's", default=None, file=True)


@dataclass(frozen=True)
class Parameters:
    settings: Settings
