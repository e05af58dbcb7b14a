"""The rigid bodies of a leg."""

from __future__ import annotations

from typing import NamedTuple

from stages.biped.leg import Leg


class PlanarBody(NamedTuple):
    """Mass [kg], mass centre [m] forward and up the leg from some point on its line, inertia about it [kg m^2]."""

    mass: float
    forward: float
    upward: float
    inertia: float


def below_spring(leg: Leg) -> PlanarBody:
    """The foot with all that moves with it, seen from the foot's centre."""
    return PlanarBody(leg.foot_mass, leg.foot_offset, leg.foot_com - leg.foot_radius, leg.leg_inertia)


def above_spring(leg: Leg) -> PlanarBody | None:
    """The frame, seen from the hip; None if the leg has none."""
    if not (leg.frame_mass or leg.frame_inertia):
        return None
    return PlanarBody(leg.frame_mass, leg.frame_offset, -leg.frame_com, leg.frame_inertia)


def joined(one: PlanarBody, other: PlanarBody | None) -> PlanarBody:
    """One rigid body of two seen from the same point, or the first alone."""
    if other is None:
        return one
    mass = one.mass + other.mass
    forward, upward = (
        (one.mass * here + other.mass * there) / mass for here, there in zip(one[1:3], other[1:3], strict=True)
    )
    apart = (one.forward - other.forward) ** 2 + (one.upward - other.upward) ** 2
    return PlanarBody(mass, forward, upward, one.inertia + other.inertia + one.mass * other.mass / mass * apart)
