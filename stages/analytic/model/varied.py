"""A walker whose own numbers vary: each of the last variations of a state goes along with a change of the parameters.

Compiled code is chosen by these types as by those of `kinds`, so what carries changes of the parameters is compiled
only for a walker that asks for them. What such a walker does where stands in `stages.analytic.derivatives`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from stages.analytic.compiled import ByKind, compiled
from stages.analytic.model.kinds import (
    Kind,
    Limited,
    Rigid,
    Rolling,
    RubbingRigid,
    RubbingRolling,
    StiffDetailedLimited,
    StiffDetailedRolling,
    StiffLimited,
    StiffRolling,
)
from stages.analytic.model.walker import Vector


class VariedRigid(NamedTuple):
    """Rigid legs: `plain` walker; `along` (n, fields of `plain`), the change of its numbers that goes with each of the
    last n variations; `delays` (columns,), by how much every variation delays the events so far, which integration adds
    up.
    """

    plain: Rigid
    along: np.ndarray
    delays: Vector


class VariedRubbing(NamedTuple):
    """The same with friction at the hip."""

    plain: RubbingRigid
    along: np.ndarray
    delays: Vector


class VariedRolling(NamedTuple):
    """The same with compliant legs and feet that roll."""

    plain: Rolling
    along: np.ndarray
    delays: Vector


class VariedRubbingRolling(NamedTuple):
    """The same with compliant legs, feet that roll, and friction at the hip."""

    plain: RubbingRolling
    along: np.ndarray
    delays: Vector


class VariedLimited(NamedTuple):
    """The same with compliant legs and limited friction."""

    plain: Limited
    along: np.ndarray
    delays: Vector


class StiffVariedRolling(VariedRolling):
    """The same for stiff legs."""

    __slots__ = ()


class StiffVariedLimited(VariedLimited):
    """The same for stiff legs."""

    __slots__ = ()


StiffVaried = StiffVariedRolling | StiffVariedLimited
VariedCompliant = VariedRolling | VariedRubbingRolling | VariedLimited
#: Rigid legs, whatever their hip does; kinds without friction at the hip; all of them.
VariedRigidLegs = VariedRigid | VariedRubbing
VariedSmooth = VariedRigid | VariedRolling | VariedLimited
Varied = VariedRigidLegs | VariedCompliant
#: The varied kind of each kind.
VARIED: dict[Any, type[Varied]] = {
    StiffRolling | StiffDetailedRolling: StiffVariedRolling, StiffLimited | StiffDetailedLimited: StiffVariedLimited,
    RubbingRigid: VariedRubbing, RubbingRolling: VariedRubbingRolling, Rigid: VariedRigid, Rolling: VariedRolling,
    Limited: VariedLimited}


def varied(p: Kind, along: np.ndarray, columns: int) -> Varied:
    """The walker with `along` (n, fields) for the last n of the `columns` variations that are carried."""
    numbers = np.ascontiguousarray(along, dtype=float)
    kind = next(found for kinds, found in VARIED.items() if isinstance(p, kinds))
    return kind(p, numbers, np.zeros(columns))  # type: ignore[arg-type]


@compiled
def itself(p: Kind) -> Kind:
    """`plain` of a plain walker."""
    return p


@compiled
def without_changes(p: Varied) -> Kind:
    """`plain` of a varied walker."""
    return p.plain


@compiled
def forget_delay(p: Kind, start: int, delay: float) -> None:
    """`keep_delay` of a plain walker."""


@compiled
def add_delay(p: Varied, start: int, delay: float) -> None:
    """`keep_delay` of compliant legs."""
    p.delays[start // 8 - 1] += delay


@compiled
def add_rigid_delay(p: VariedRigidLegs, start: int, delay: float) -> None:
    """`keep_delay` of rigid legs."""
    p.delays[start // 4 - 1] += delay


#: The walker's numbers as they are: plain(p).
plain: Callable[..., Any] = ByKind({Kind: itself, Varied: without_changes})
#: By how much the variation stored from `start` delays an event: keep_delay(p, start, delay).
keep_delay: Callable[..., None] = ByKind({
    Kind: forget_delay, VariedRigidLegs: add_rigid_delay, VariedCompliant: add_delay})
