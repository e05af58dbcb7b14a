"""The register of contact laws: an entry here is all that a new law needs beside its own file.

A law is a NamedTuple of the numbers it needs, made from the parameters by `of`, with its formula as a method over
`Operations`. That one text serves the planar model's symbols, numpy and the twin's machine code, which knows the law by
the tuple's type. Every normal force at rest is eq. (9)'s spring k_c p^e, and none pulls; friction is given for a foot
that slides: below the stiction velocity every law lets the foot creep alike (`stages.ground.friction`). The tests run
over these two tables.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from stages.ground.coulomb import Coulomb
from stages.ground.frictionless import Frictionless
from stages.ground.impact import Impact
from stages.ground.restitution import Restitution
from stages.ground.stribeck import Stribeck

if TYPE_CHECKING:
    from stages.ground.contact_law import ContactLaw
    from stages.ground.operations import Operations


class NormalForce(Protocol):
    """A law of the normal force."""

    @classmethod
    def of(cls, contact: ContactLaw) -> NormalForce:
        """The law with these parameters."""

    def force(self, penetration: Any, rate: Any, ops: Operations) -> Any:
        """Normal force [N], never negative, zero out of contact; penetration [m] positive in contact, rate [m/s]."""


class FrictionLaw(Protocol):
    """A law of friction."""

    @classmethod
    def of(cls, contact: ContactLaw) -> FrictionLaw:
        """The law with these parameters."""

    def coefficient(self, speed: Any, ops: Operations) -> Any:
        """Friction coefficient of a foot that slides with this speed [m/s], not negative."""


NORMAL_FORCES: dict[str, type[NormalForce]] = {"impact": Impact, "restitution": Restitution}
FRICTIONS: dict[str, type[FrictionLaw]] = {"stribeck": Stribeck, "coulomb": Coulomb, "none": Frictionless}


class PointLaw(NamedTuple):
    """The chosen laws in numbers, as one contact point feels them."""

    normal: NormalForce
    friction: FrictionLaw
    stiction_velocity: float
