"""The numbers of a walker, in a type that says what kind of walker it is.

Compiled code takes them as `p`, asks for them by the paper's symbols, `p.r`, and is compiled for the type: what a kind
does not need is not compiled for it. All are dimensionless: total mass, leg length and pendulum time are one.
"""

from __future__ import annotations

from typing import NamedTuple


class Rigid(NamedTuple):
    """Legs of fixed length: the trailing foot leaves the ground at heel strike, no double stance."""

    M: float
    m: float
    L_nat: float
    r: float
    l: float  # noqa: E741
    I: float  # noqa: E741
    g_x: float
    g_y: float


class Rolling(NamedTuple):
    """Compliant legs; a foot on the ground rolls, whatever friction that takes."""

    M: float
    m: float
    L_nat: float
    r: float
    l: float  # noqa: E741
    k: float
    b: float
    I: float  # noqa: E741
    g_x: float
    g_y: float


class Limited(NamedTuple):
    """Compliant legs; the trailing foot has friction mu_s at rest and mu_d in motion, so that it may slip and rise."""

    M: float
    m: float
    L_nat: float
    r: float
    l: float  # noqa: E741
    k: float
    b: float
    I: float  # noqa: E741
    g_x: float
    g_y: float
    mu_s: float
    mu_d: float


class StiffRolling(Rolling):
    """A rolling walker whose legs are stiff to an explicit integrator."""

    __slots__ = ()


class StiffLimited(Limited):
    """A walker with limited friction whose legs are stiff to an explicit integrator."""

    __slots__ = ()


Compliant = Rolling | Limited
Stiff = StiffRolling | StiffLimited
Kind = Rigid | Compliant
