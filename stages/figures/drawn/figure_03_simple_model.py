"""Figure 3: the simplified model as Exudyn walks it: two legs with round feet in one plane."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.biped.accuracy.scales import size
from stages.biped.design import Biped
from stages.drawing import style
from stages.figures import view
from stages.figures.entry import Entry, Given
from stages.figures.view import LONGEST, Faces, by_group
from stages.twin.machine.parts import FEET, FRAMES, Part

AZIMUTH, ELEVATION = np.radians(28.0), np.radians(16.0)
#: The legs are drawn this far to either side of their plane [m], so that both are seen; for Table 1's leg.
ASIDE, THICK = 0.016, 0.02
#: When in the walk it is shown: this part of the step after the second heel strike.
PHASE = 0.3


def parts(biped: Biped) -> tuple[Part, ...]:
    """Each leg above and below its spring, its round foot and the mass below the spring; the hip's mass."""
    radius, centre = biped.foot_radius, biped.foot_radius - biped.leg_length
    middle, mass, large = 0.55 * centre, biped.foot_com - biped.leg_length, size(biped)
    aside, thick = large * ASIDE, large * THICK
    low = min(0.014 * large, max(biped.foot_com, 0.008 * biped.leg_length))  # stays above the ground
    hip = 0.022 * large, 3.2 * aside
    shown = [Part("hip", FRAMES[0], "aluminium", "cylinder", "z", hip, 1.0, (0.0, 0.0, 0.0), 1)]
    for frame, foot, z in zip(FRAMES, FEET, (aside, -aside), strict=True):
        def one(group: str, shape: str, size: tuple[float, ...], y: float, material: str = "", z: float = z) -> Part:
            return Part("", group, material, shape, "y" if shape == "cylinder" and len(size) == 2 and material == ""
                        else "z", size, 1.0, (0.0, y, z), 1)  # fmt: skip

        shown += [
            one(frame, "cylinder", (0.007 * large, -middle), middle / 2),
            one(foot, "cylinder", (0.0045 * large, middle - centre), (middle + centre) / 2),
            one(foot, "cylinder", (low, 1.2 * thick), mass, "steel"),
        ]
        if radius > 0.0:
            shown.append(one(foot, "tube", (radius, 0.86 * radius, thick), centre, "rim"))
    return tuple(shown)


def draw(given: Given) -> Figure:
    """The model on its plane, and its axes."""
    walk, biped = given.multibody.walk, given.parameters.biped
    camera = view.Camera(AZIMUTH, ELEVATION, given.parameters.slope.angle)
    pose = view.pose_at(walk, view.moment(walk, PHASE), biped.leg_length)
    x = pose.hip[0]
    figure, axes = plt.subplots(figsize=(style.ONE_COLUMN, 2.7))
    large = size(biped)
    floor = view.deck(x - 0.3 * large, x + 0.3 * large, 0.15 * large)
    level = np.array([0.0, float(floor.corners[..., 1].max()), 0.0])
    view.paint(axes, camera, [Faces(floor.corners - level, floor.normals, floor.colours),
                              pose.robot(by_group(parts(biped), 40, LONGEST * large))])  # fmt: skip
    corner = np.array([x - 0.24 * large, 0.0, 0.1 * large])
    view.arrows(axes, camera, corner, 0.09 * large * np.eye(3), ("x", "y", "z"), color="black", linewidth=0.9)
    low = (0.0, biped.foot_com - biped.leg_length, ASIDE * large)
    for name, place, group, (ahead, above) in (
        ("M", (0.0, 0.0, 0.0), FRAMES[0], (0.07, 0.035)), ("m", low, FEET[0], (-0.16, 0.1))
    ):  # fmt: skip
        point, words = pose.point(place, group), (ahead * large, above * large)
        axes.annotate(f"${name}$", camera.spot(point), camera.spot(point, words), fontsize=9, ha="center", va="center",
                      arrowprops={"arrowstyle": "-", "linewidth": 0.6, "shrinkA": 1, "shrinkB": 0})  # fmt: skip
    top = np.array([x + 0.22 * large, 0.26 * large, 0.0])
    axes.annotate("$g$", camera.spot(top, (0.0, -0.09 * large)), camera.spot(top), ha="center", va="bottom", fontsize=9,
                  arrowprops={"arrowstyle": "-|>", "linewidth": 0.9, "color": "black"})  # fmt: skip
    view.frame(axes)
    return figure


def caption(given: Given) -> str:
    biped = given.parameters.biped
    return (
        f"The planar model as it stands in Exudyn: hip of {biped.hip_mass:g} kg, two legs on springs with "
        f"{biped.foot_mass:g} kg below each and feet of {1e3 * biped.foot_radius:g} mm. It moves in the x-y plane; its "
        "legs are drawn side by side so that both are seen."
    )


FIGURE = Entry("Figure 3: the simplified model", 3, ("multibody",), draw, caption)
