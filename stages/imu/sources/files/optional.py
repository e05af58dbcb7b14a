"""Readers of formats that not every lab has: libraries that are installed apart."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

from stages.imu.errors import SourceRefused, printable


def library(name: str, extra: str, path: Path) -> Any:
    """A library. Raises SourceRefused, naming the extra that brings it, where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise SourceRefused(
            f"{printable(path.name)}: to read it, {name.partition('.')[0]} is needed: pip install 'bipedstudy[{extra}]'"
        ) from None


def no_columns(path: Path, wanted: str, has: object) -> SourceRefused:
    """That a file lacks a column; `has` are the names it has."""
    names = [str(one) for one in has] if isinstance(has, (list, tuple)) else []
    return SourceRefused(
        f"{printable(path.name)} has no column {printable(wanted)}; it has {printable(', '.join(names[:12]), 200)}"
    )
