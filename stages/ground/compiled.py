"""Contact laws as machine code: the texts of this folder, compiled for the types of their numbers.

A compiled function that calls `law.force` or `law.coefficient` is compiled for the law's type, a NamedTuple, and so
calls that law's own method: there is no number or name of a law that could be mistaken for another.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba import types
from numba.extending import overload_method

from stages.biped import quantity
from stages.biped.machine_code import MachineCode, folder_of
from stages.ground.friction import friction_slope
from stages.ground.operations import Operations

F = TypeVar("F", bound=Callable[..., Any])
GROUND = Path(__file__).parent
#: Numba's own annotations are partly wrong.
njit: Any = numba.njit
compiled_method: Any = overload_method


def sources(folder: Path) -> tuple[Path, ...]:
    """The folders that compiled functions of this one, which call contact laws, are made from."""
    return folder, GROUND, folder_of(quantity)


def kept_with_ground(folder: Path) -> Callable[[F], F]:
    """A decorator for compiled functions of this folder's sources that call contact laws."""
    code = MachineCode(f"{folder.parent.name}-{folder.name}", *sources(folder))

    def compiled(function: F) -> F:
        return cast(F, code.keep(njit(function)))

    return compiled


def _force(self: Any, penetration: Any, rate: Any, ops: Any) -> Any:
    return getattr(self.instance_class, "force", None)


def _coefficient(self: Any, speed: Any, ops: Any) -> Any:
    return getattr(self.instance_class, "coefficient", None)


compiled_method(types.BaseNamedTuple, "force", strict=False)(_force)
compiled_method(types.BaseNamedTuple, "coefficient", strict=False)(_coefficient)


def _step(x: float, width: float, height: float) -> float:
    s = min(max(x / width, 0.0), 1.0)
    return height * s * s * (3.0 - 2.0 * s)


def _rise(x: float, width: float, height: float) -> float:
    u = min(max(x / width, -1.0), 1.0)
    return height * 0.5 * u * (3.0 - u * u)


def _creep(x: float, width: float, height: float) -> float:
    u = x / width
    return height * 0.5 * (3.0 - u * u) / width if u < 1.0 else height / x


COMPILED = Operations(
    sqrt=njit(lambda x: math.sqrt(x)),
    sign=njit(lambda x: math.copysign(1.0, x) if x != 0.0 else 0.0),
    absolute=njit(lambda x: abs(x)),
    round=njit(lambda x: np.rint(x)),
    power=njit(lambda x, exponent: x**exponent),
    minimum=njit(lambda x, limit: min(x, limit)),
    maximum=njit(lambda x, limit: max(x, limit)),
    step=njit(_step),
    rise=njit(_rise),
    creep=njit(_creep),
    length=njit(lambda x, z: math.sqrt(x * x + z * z)),
)

#: `friction_slope` for compiled functions.
compiled_slope = njit(friction_slope)
