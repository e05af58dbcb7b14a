"""How a stage reports how far it has come."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[float, str], None]
"""Called with the fraction done (0 to 1) and a few words on what is being computed."""


def ignore(fraction: float, what: str) -> None:
    """Report to no one: the default of every stage's `run`."""
