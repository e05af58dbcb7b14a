"""Figure 12: the robot on its ramp with stepping blocks, and where its sensors are."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.biped.accuracy.scales import size
from stages.drawing import style
from stages.figures import view
from stages.figures.entry import Entry, Given
from stages.figures.view import SMALL, of_twin
from stages.twin.ramp import laid

AZIMUTH, ELEVATION = np.radians(46.0), np.radians(20.0)
#: Where the robot stands, as a part of the ramp's steps.
ALONG = 0.55
#: Of a sensor: its name, and where its words stand from it on the page [m], for a leg of `following.LEG_LENGTH`.
WORDS = {"hip sensor": (0.16, 0.10), "foot sensor": (0.30, 0.10)}


def draw(given: Given) -> Figure:
    """The whole ramp with the robot on it."""
    walk, twin, biped = given.twin.walk, given.parameters.twin, given.parameters.biped
    ramp = laid(twin, given.analytic.gait.step_length_m)
    camera = view.Camera(AZIMUTH, ELEVATION, given.parameters.slope.angle)
    natural, large = biped.leg_length + twin.outsole, size(biped)
    moment = walk.time[0] + ALONG * (walk.time[-1] - walk.time[0])
    pose = view.pose_at(walk, float(moment), natural)
    stride = 2.0 * ramp.step
    back = stride * round((pose.hip[0] - ALONG * ramp.steps * ramp.step) / stride)
    pose = view.Pose(pose.hip - [back, 0.0], pose.angle, pose.slide)
    edge = ramp.tracks[1] + 0.8 * ramp.width
    figure, axes = plt.subplots(figsize=(style.TWO_COLUMNS, 3.3))
    spare = 0.5 * (ramp.length - ramp.steps * ramp.step)
    view.paint(axes, camera, [
        view.deck(-spare, ramp.steps * ramp.step + spare, edge),
        view.blocks(ramp),
        pose.robot(of_twin(twin, biped, SMALL)),
    ])  # fmt: skip
    for name, (ahead, above) in WORDS.items():
        words = large * ahead, large * above
        foot = name == "foot sensor"
        place = twin.foot_sensor(biped.foot_com - biped.leg_length) if foot else twin.hip_socket
        group = "inner_foot" if foot else "inner_frame"
        point = pose.point(place, group)
        axes.annotate(name, camera.spot(point), camera.spot(point, words), ha="center", va="bottom", fontsize=8,
                      arrowprops={"arrowstyle": "-|>", "linewidth": 0.7, "color": "black", "shrinkA": 0})  # fmt: skip
    for number in (0, ramp.sets - 1):
        x, y = camera.spot(np.array([number * ramp.step, 0.0, edge + 0.07 * large]))
        axes.text(x, y - 0.02 * large, f"set {number + 1}", ha="center", va="top", fontsize=8)
    start = np.array([0.35 * large, 0.0, edge + 0.14 * large])
    view.arrows(axes, camera, start, np.array([[0.4 * large], [0.0], [0.0]]), ("",), color="black", linewidth=0.8)
    x, y = camera.spot(start)
    axes.text(x - 0.02 * large, y, "walks", ha="right", va="center", fontsize=8)
    view.frame(axes)
    return figure


def caption(given: Given) -> str:
    twin = given.parameters.twin
    ramp = laid(twin, given.analytic.gait.step_length_m)
    return (
        f"The ramp of {ramp.length:.4g} m at {np.degrees(given.parameters.slope.angle):.3g}° with {ramp.sets} sets "
        f"of stepping blocks, {1e3 * ramp.step:.0f} mm apart, for inner and outer feet in turn: a swinging foot goes "
        "down through the gaps of its own lanes. One sensor is at the hip, one on an inner foot."
    )


FIGURE = Entry("Figure 12: the robot on the ramp", 12, ("twin", "analytic"), draw, caption, claims=("ramp_length",))
