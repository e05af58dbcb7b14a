"""What is seen of the twin: the parts of its bill, and what joins them."""

from __future__ import annotations

from stages.biped.design import Biped
from stages.twin.machine.parts import FEET, FRAMES, Part
from stages.twin.parameters import Settings

#: Chord of an outsole as a share of the foot's diameter.
SOLE = 0.67


def guides(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """Thin rods down the legs and into the feet: the bill leaves open what a leg slides on, and parts would float."""
    ankle, radius = biped.leg_length - biped.foot_radius, 0.95 * biped.foot_radius
    return tuple(
        Part("guide", group, "steel", "cylinder", "y", (thick, length), 1.0, (0.0, -top - length / 2, lane), 2)
        for groups, thick, top, length in ((FRAMES, 0.0025, 0.0, ankle), (FEET, 0.004, ankle, radius))
        for group, lane in zip(groups, (settings.inner_lane, settings.outer_lane))
        if length > 0.0
    )


def outsoles(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """The rubber on top of Table 1's feet, if there is any."""
    radius = biped.foot_radius + settings.outsole
    size = (radius, settings.outsole, settings.foot_width, SOLE * 2.0 * radius)
    height = biped.foot_radius - biped.leg_length
    return tuple(
        Part("outsole", group, "rubber", "arc", "z", size, 1.0, (0.0, height, lane), 2)
        for group, lane in zip(FEET, (settings.inner_lane, settings.outer_lane))
        if settings.outsole > 0.0
    )


def what_is_drawn(settings: Settings, biped: Biped) -> str:
    """What `shown_parts` are, in words."""
    rule = settings.bill_rule(biped)
    if settings.inertia == "planar":
        return "its point masses on legs, with its feet"
    return f"every part of its bill{' (' * bool(rule)}{rule}{')' * bool(rule)}"


def shown_parts(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """All that is seen of the robot; masses of what is not in the bill mean nothing."""
    return (*settings.bill(biped), *guides(settings, biped), *outsoles(settings, biped))
