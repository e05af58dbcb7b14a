"""The study's own parameters, as its files have them."""

from pathlib import Path
from typing import Any

from pipeline.study import locate

ROOT = Path(__file__).resolve().parents[1]


def parameters_of(stage: str, *settings: str) -> Any:
    """The parameters of a stage with some set, as `--set` takes them. Raises StudyError."""
    return locate(settings=settings, start=ROOT).parameters((stage,))[stage]
