"""What is seen of the twin: the parts of its bill, or its point masses, and what joins them."""

from __future__ import annotations

from stages.biped.accuracy.scales import size
from stages.biped.design import Biped
from stages.twin.machine.parts import FEET, FRAMES, Part
from stages.twin.parameters import Settings

#: Chord of an outsole as a share of the foot's diameter.
SOLE = 0.67


def points(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """The machine without parts: a mass at the hip, on its axis, and of each leg its mass and its round foot."""
    radius, large = biped.foot_radius, size(biped)
    low = min(0.014 * large, max(biped.foot_com, 0.008 * biped.leg_length))  # stays above the ground
    lanes = (settings.inner_lane, settings.outer_lane)
    shown = [Part("hip mass", FRAMES[0], "steel", "cylinder", "z", (0.022 * large, settings.inner_lane), 1.0,
                  (0.0, 0.0, 0.0), 1)]  # fmt: skip
    for frame, foot, lane in zip(FRAMES, FEET, lanes, strict=True):
        shown += [
            Part("hip axis", frame, "steel", "cylinder", "z", (0.004 * large, 2 * lane), 1.0, (0.0, 0.0, 0.0), 1),
            Part("foot mass", foot, "steel", "cylinder", "z", (low, settings.foot_width), 1.0,
                 (0.0, biped.foot_com - biped.leg_length, lane), 2),
        ]  # fmt: skip
        if radius > 0.0:
            rim = (radius, 0.14 * radius, settings.foot_width, SOLE * 2.0 * radius)
            shown.append(Part("foot", foot, "ABS", "arc", "z", rim, 1.0, (0.0, radius - biped.leg_length, lane), 2))
    return tuple(shown)


def guides(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """Thin rods down the legs and into the feet: the bill leaves open what a leg slides on, and parts would float."""
    ankle = biped.leg_length - biped.foot_radius
    end, below, large = min(ankle, 0.9 * biped.leg_length), ankle + 0.95 * biped.foot_radius, size(biped)
    return tuple(
        Part("guide", group, "steel", "cylinder", "y", (thick * large, length), 1.0, (0.0, -top - length / 2, lane), 2)
        for groups, thick, top, length in ((FRAMES, 0.0025, 0.0, end), (FEET, 0.004, end, below - end))
        for group, lane in zip(groups, (settings.inner_lane, settings.outer_lane))
    )


def outsoles(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """The rubber on top of the design's feet, if there is any."""
    radius = biped.foot_radius + settings.outsole
    sector = (radius, settings.outsole, settings.foot_width, SOLE * 2.0 * radius)
    height = biped.foot_radius - biped.leg_length
    return tuple(
        Part("outsole", group, "rubber", "arc", "z", sector, 1.0, (0.0, height, lane), 2)
        for group, lane in zip(FEET, (settings.inner_lane, settings.outer_lane))
        if settings.outsole > 0.0
    )


def what_is_drawn(settings: Settings, biped: Biped) -> str:
    """What `shown_parts` are, in words."""
    if settings.inertia == "planar":
        return "its point masses, legs and round feet, as it has no parts,"
    return "every part of its bill, made to fit the design," if settings.bill_rule(biped) else "every part of its bill"


def solid_parts(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """The parts of the bill; of a machine without a bill its point masses and feet."""
    return points(settings, biped) if settings.inertia == "planar" else settings.bill(biped)


def shown_parts(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """All that is seen of the robot; masses of what is not in the bill mean nothing."""
    return (*solid_parts(settings, biped), *guides(settings, biped), *outsoles(settings, biped))
