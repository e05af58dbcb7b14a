"""Figure 15: axes of the sensors, as they lie in their sockets and as the ingest turns them."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.biped.accuracy.scales import size
from stages.drawing import style
from stages.figures import view
from stages.figures.entry import Entry, Given
from stages.figures.view import of_twin

AZIMUTH, ELEVATION = np.radians(35.0), np.radians(20.0)
#: When in the walk the robot is shown: this part of the step after the second heel strike.
PHASE = 0.25
#: Half the width of a close view, and length of an arrow in it and in the whole [m], for Table 1's leg.
WINDOW, CLOSE, WHOLE = 0.062, 0.036, 0.085
#: Length of the sensors' own axes in a close view [m]: shorter, as one may lie on one of the others.
OWN_LENGTH = 0.024
NAMES = ("forward", "up", "lateral")
OWN = "#5A5A5A"


def draw(given: Given) -> Figure:
    """The robot with both frames, then each sensor from near, with the axes it was found to have."""
    walk, twin, biped = given.twin.walk, given.parameters.twin, given.parameters.biped
    camera = view.Camera(AZIMUTH, ELEVATION, given.parameters.slope.angle)
    pose = view.pose_at(walk, view.moment(walk, PHASE), biped.leg_length + twin.outsole)
    robot = pose.robot(of_twin(twin, biped))
    large, window = size(biped), size(biped) * WINDOW
    run, foot = given.imu.runs[0], twin.foot_sensor(biped.foot_com - biped.leg_length)
    sensors = (
        ("foot sensor", pose.point(foot, "inner_foot"), run.foot.rotation),
        ("hip sensor", pose.point(twin.hip_socket, "inner_frame"), run.hip.rotation),
    )
    figure, (whole, *near) = plt.subplots(1, 3, figsize=(style.TWO_COLUMNS, 2.9), width_ratios=(0.9, 1.0, 1.0))
    view.paint(whole, camera, [robot], strength=0.45)
    for _, place, _ in sensors:
        view.arrows(whole, camera, place, large * WHOLE * pose.axes(0), NAMES, color="black", linewidth=0.9)
    view.frame(whole)
    for axes, (name, place, rotation) in zip(near, sensors, strict=True):
        view.paint(axes, camera, [robot], strength=0.5)
        own = large * OWN_LENGTH * pose.axes(0) @ rotation
        view.arrows(axes, camera, place, own, ("x", "y", "z"), beside=True, color=OWN, linewidth=0.8,
                    linestyle="--")  # fmt: skip
        view.arrows(axes, camera, place, large * CLOSE * pose.axes(0), NAMES, color="black", linewidth=1.1)
        view.frame(axes)
        x, y = camera.spot(place)
        axes.set(xlim=(x - window, x + window), ylim=(y - window, y + window), title=name)
    style.panel_labels((whole, *near))
    near[0].plot([], [], "--", color=OWN, linewidth=0.8, label="axes of the sensor")
    near[0].plot([], [], color="black", linewidth=1.1, label="after the ingest")
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def caption(given: Given) -> str:
    run = given.imu.runs[0]
    turned = [np.degrees(np.arccos(np.clip(0.5 * (np.trace(sensor.rotation) - 1.0), -1.0, 1.0)))
              for sensor in (run.foot, run.hip)]  # fmt: skip
    return (
        "Both sensors sit on the inner legs and measure specific force and angular velocity on the axes forward, up "
        f"the leg and lateral. Dashed: a sensor's own axes, which the ingest found turned by {turned[0]:.1f}° at the "
        f"foot and {turned[1]:.1f}° at the hip in the first run ({given.imu.origin})."
    )


FIGURE = Entry("Figure 15: axes of the sensors", 15, ("twin", "imu"), draw, caption)
