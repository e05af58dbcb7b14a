"""State of the planar biped in the terms both assemblies share."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stages.biped.accuracy.scales import scales_of
from stages.biped.design import Biped
from stages.biped.gait import StanceState
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import static_penetration
from stages.ground.slope import Slope

#: Coulomb's friction at the hip is proportional to the hip's rate below this rate, in the design's scales, or it
#: would jump: a hip that should stick creeps, at this rate at most.
HIP_CREEP = 2e-4


def hip_creep(biped: Biped, slope: Slope) -> float:
    """That rate [rad/s]."""
    return HIP_CREEP / scales_of(biped, slope.gravity).time


@dataclass(frozen=True)
class PlanarState:
    """Hip point and both legs in the slope frame; SI units; leg 0 is the inner leg.

    Angles are positive with the foot ahead of the hip. `in_play` tells for each leg whether the ground acts on its
    foot, see `stages.multibody.walking.scuffing`.
    """

    hip_position: tuple[float, float]
    hip_velocity: tuple[float, float]
    leg_angle: tuple[float, float]
    leg_rate: tuple[float, float]
    leg_length: tuple[float, float]
    leg_length_rate: tuple[float, float]
    in_play: tuple[bool, bool]


def rolling_state(biped: Biped, contact: ContactLaw, stance: StanceState, normal_force: float) -> PlanarState:
    """State with leg 0 standing: rolling without slip, pressed into the ground by `normal_force` [N], eqs. (7) and (8).

    The foot's centre lies at x = r theta, so that the foot stands at x = 0 when the leg is upright. The swing foot is
    out of play. Velocities are those of the rolling foot on rigid ground: the penetration starts at rest.
    """
    r = biped.foot_radius
    theta, length = stance.stance_angle, stance.stance_length
    rate, length_rate = stance.stance_rate, stance.stance_length_rate
    sine, cosine = math.sin(theta), math.cos(theta)
    sunk = static_penetration(contact, max(normal_force, 0.0))
    return PlanarState(
        hip_position=(r * theta + (length - r) * sine, r + (length - r) * cosine - sunk),
        hip_velocity=(
            r * rate + length_rate * sine + rate * (length - r) * cosine,
            length_rate * cosine - rate * (length - r) * sine,
        ),
        leg_angle=(-theta, stance.swing_angle),
        leg_rate=(-rate, stance.swing_rate),
        leg_length=(length, stance.swing_length),
        leg_length_rate=(length_rate, stance.swing_length_rate),
        in_play=(True, False),
    )
