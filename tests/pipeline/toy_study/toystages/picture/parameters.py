from dataclasses import dataclass
from typing import ClassVar

from toystages.body.quantity import parameter


@dataclass(frozen=True)
class Settings:
    FILE: ClassVar[str] = "picture"
    title: str = parameter("-", "title")
    extra: bool = parameter("1", "a second figure")


@dataclass(frozen=True)
class Parameters:
    settings: Settings
