"""One leg of the biped: what can differ between the two."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from stages.biped.quantity import Broken


@dataclass(frozen=True)
class Leg:
    """The numbers of one leg under their names in `Biped`, SI units.

    Below the spring: `foot_mass` at `foot_com` above the foot's bottom and `foot_offset` forward of the leg's line,
    with `leg_inertia` about it. Above: `frame_mass` at `frame_com` below the hip and `frame_offset` forward, with
    `frame_inertia`. The foot's centre is on the leg's line.
    """

    foot_mass: float
    leg_length: float
    foot_radius: float
    foot_com: float
    stiffness: float
    damping: float
    leg_inertia: float
    foot_offset: float
    frame_mass: float
    frame_com: float
    frame_offset: float
    frame_inertia: float


def leg_rules(leg: Leg, prefix: str, given: Collection[str] = ()) -> Iterator[Broken]:
    """Rules between a leg's values; a key to blame is one of those that are `given`, if not all are."""

    def to_blame(*names: str) -> str:
        return prefix + next(name for name in names if not given or name in given)

    def at_fault(*names: str) -> bool:
        return not given or bool({*names} & {*given})

    for name in ("foot_radius", "foot_com"):
        if getattr(leg, name) >= leg.leg_length and at_fault(name, "leg_length"):
            key = to_blame(name, "leg_length")
            limit = (f"< {prefix if 'leg_length' in given else ''}leg_length = {leg.leg_length:g} m"
                     if key.endswith(name) else f"> {name} = {getattr(leg, name):g} m")
            yield Broken(key, limit)
    if leg.frame_mass == 0:
        for name in ("frame_com", "frame_offset"):
            if getattr(leg, name) != 0 and at_fault(name):
                yield Broken(prefix + name, "0 m without frame_mass")
