"""Contact laws as machine code: the texts of this folder, compiled for the types of their numbers.

A compiled function that calls `law.force` or `law.coefficient` is compiled for the law's type, a NamedTuple, and so
calls that law's own method: there is no number or name of a law that could be mistaken for another.
"""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
import numpy as np
from numba import types
from numba.extending import overload, overload_method

from stages.biped import quantity
from stages.biped.machine_code import MachineCode, folder_of
from stages.ground.friction import Operations, friction_slope, signed_coefficient

F = TypeVar("F", bound=Callable[..., Any])
GROUND = Path(__file__).parent
#: Numba's own annotations are partly wrong.
njit: Any = numba.njit
compiled_method: Any = overload_method
compiled_for: Any = overload


def sources(folder: Path) -> tuple[Path, ...]:
    """The folders that compiled functions of this one, which call contact laws, are made from."""
    return folder, GROUND, folder_of(quantity)


def kept_with_ground(folder: Path) -> Callable[[F], F]:
    """A decorator for compiled functions of this folder's sources that call contact laws."""
    return MachineCode(f"{folder.parent.name}-{folder.name}", *sources(folder)).compiled


def _force(self: Any, penetration: Any, rate: Any, ops: Any) -> Any:
    return getattr(self.instance_class, "force", None)


def _coefficient(self: Any, speed: Any, ops: Any) -> Any:
    return getattr(self.instance_class, "coefficient", None)


def entries(pattern: Any, numbers: Any, start: Any) -> Any:
    """A tuple of as many numbers as `pattern` has, from `start` on."""
    return tuple(numbers[start : start + len(pattern)])


def _entries(pattern: Any, numbers: Any, start: Any) -> Any:
    """For machine code a tuple's length is part of its type, so it is put together by one number at a time."""

    def none(pattern: Any, numbers: Any, start: Any) -> Any:
        return ()

    def some(pattern: Any, numbers: Any, start: Any) -> Any:
        return (numbers[start], *entries(pattern[1:], numbers, start + 1))

    return some if len(pattern) else none


def _like(self: Any, numbers: Any, start: Any) -> Any:
    kind = self.instance_class

    def like(self: Any, numbers: Any, start: Any) -> Any:
        return kind(*entries(self, numbers, start))

    return like


compiled_for(entries)(_entries)
#: law.like(numbers, start): a law of the same kind with other numbers, of an array from `start`.
compiled_method(types.BaseNamedTuple, "like", strict=False)(_like)
compiled_method(types.BaseNamedTuple, "force", strict=False, inline="always")(_force)
compiled_method(types.BaseNamedTuple, "coefficient", strict=False, inline="always")(_coefficient)


def operation(function: F) -> F:
    """An operation as machine code, for whatever numbers it is given."""
    found: F = njit(function)
    return found


@operation
def _minimum(x: Any, limit: Any) -> Any:
    return limit if x.real >= limit else x


@operation
def _maximum(x: Any, limit: Any) -> Any:
    return limit if x.real <= limit else x


@operation
def _step(x: Any, width: float, height: Any) -> Any:
    s = _minimum(_maximum(x / width, 0.0), 1.0)
    return height * s * s * (3.0 - 2.0 * s)


@operation
def _rise(x: Any, width: float, height: Any) -> Any:
    u = _minimum(_maximum(x / width, -1.0), 1.0)
    return height * 0.5 * u * (3.0 - u * u)


@operation
def _creep(x: Any, width: float, height: Any) -> Any:
    u = x / width
    return height * 0.5 * (3.0 - u * u) / width if u.real < 1.0 else height / x


@operation
def _tangent_power(x: complex, exponent: complex) -> complex:
    if x.real <= 0.0:
        return complex(0.0, 0.0)
    value, slope = x.real**exponent.real, exponent.real * x.real ** (exponent.real - 1.0)
    change = slope * x.imag
    if exponent.imag != 0.0:
        change += value * math.log(x.real) * exponent.imag
    return complex(value, change)


COMPILED = Operations(
    sign=njit(lambda x: math.copysign(1.0, x.real) if x.real != 0.0 else 0.0),
    absolute=njit(lambda x: -x if x.real < 0.0 else x),
    round=njit(lambda x: np.rint(x.real)),
    power=njit(lambda x, exponent: x**exponent),
    minimum=_minimum,
    maximum=_maximum,
    step=_step,
    rise=_rise,
    creep=_creep,
    length=njit(lambda x, z: np.sqrt(x * x + z * z)),
)
#: The same on numbers x + i dx with a dx so small that its square is lost: the imaginary part of a result is its
#: derivative times dx, exact to round-off (complex step; Squire and Trapp, SIAM Review 40, 1998). A law whose own
#: numbers are of this kind gives its derivative by them.
TANGENTS = COMPILED._replace(power=_tangent_power)
#: `friction_slope` and `signed_coefficient` for compiled functions.
compiled_slope = njit(friction_slope)
compiled_coefficient = njit(signed_coefficient, inline="always")
