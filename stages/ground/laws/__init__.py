"""The register of contact laws: an entry here is all that a new law needs beside its own file.

A law is a NamedTuple of the numbers it needs, made from the parameters by `of`, with its formula as a method over
`Operations`. That one text serves the planar model's symbols, numpy and the twin's machine code, which knows the law by
the tuple's type. The tests run over these two tables.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from stages.ground.laws.coulomb import Coulomb, Frictionless
from stages.ground.laws.impact import Impact
from stages.ground.laws.restitution import Restitution
from stages.ground.laws.stribeck import Stribeck

#: `force(penetration, rate, ops)` [N], never negative, and zero out of contact: penetration [m] is positive in contact,
#: its rate in m/s. At rest every law carries eq. (9)'s spring force k_c p^e.
NORMAL_FORCES: dict[str, Any] = {"impact": Impact, "restitution": Restitution}
#: `coefficient(speed, ops)` of a foot that slides with this speed [m/s], not negative. Below the stiction velocity each
#: law lets the foot creep alike, see `stages.ground.friction`.
FRICTIONS: dict[str, Any] = {"stribeck": Stribeck, "coulomb": Coulomb, "none": Frictionless}


class PointLaw(NamedTuple):
    """The chosen laws in numbers, as one contact point feels them."""

    normal: Any
    friction: Any
    stiction_velocity: float
