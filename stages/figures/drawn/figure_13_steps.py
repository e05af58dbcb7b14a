"""Figure 13: six consecutive steps of the twin on its ramp, each at the same phase."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.biped.accuracy.scales import size
from stages.biped.walk import Walk
from stages.drawing import style
from stages.figures import view
from stages.figures.entry import Entry, Given
from stages.figures.view import SMALL, of_twin
from stages.twin.ramp import laid

STEPS = 6
AZIMUTH, ELEVATION = np.radians(24.0), np.radians(14.0)
#: Half the width of what one picture shows, and how far it goes below and above the ground [m] for Table 1's leg;
#: farther where the robot needs it.
WINDOW, BELOW, ABOVE = 0.165, 0.085, 0.40
#: When a step is shown: this part of it after its heel strike.
PHASE = 0.2


def moments(walk: Walk) -> np.ndarray:
    """Times of the same phase of consecutive steps, the first after the first heel strike [s]."""
    strikes = walk.heel_strike_time[: STEPS + 1]
    return np.asarray(strikes[:-1] + PHASE * np.diff(strikes))


def draw(given: Given) -> Figure:
    """A picture a step; the camera goes along."""
    walk, twin, biped = given.twin.walk, given.parameters.twin, given.parameters.biped
    ramp = laid(twin, given.analytic.gait.step_length_m)
    camera = view.Camera(AZIMUTH, ELEVATION, given.parameters.slope.angle)
    bodies, natural, large = of_twin(twin, biped, SMALL), biped.leg_length + twin.outsole, size(biped)
    poses = [view.pose_at(walk, float(time), natural) for time in moments(walk)]
    robots = [pose.robot(bodies) for pose in poses]
    middles = [camera.page(np.array([pose.hip[0], 0.0, 0.0])) for pose in poses]  # on the page, on the ground
    reach = [camera.page(robot.corners) - middle for robot, middle in zip(robots, middles)]
    half = 1.02 * max([WINDOW * large / 1.02, *(abs(each[..., 0]).max() for each in reach)])
    below = 1.02 * max([BELOW * large / 1.02, *(-each[..., 1].min() for each in reach)])
    above = 1.02 * max([ABOVE * large / 1.02, *(each[..., 1].max() for each in reach)])
    edge = ramp.tracks[1] + 0.8 * ramp.width
    figure, panels = plt.subplots(1, STEPS, figsize=(style.TWO_COLUMNS, 1.95))
    for number, (axes, time) in enumerate(zip(panels, moments(walk)), 1):
        x, (centre, ground) = poses[number - 1].hip[0], middles[number - 1]
        near = max(0, int(np.ceil((x - 3 * half) / ramp.step))), int((x + 3 * half) / ramp.step)
        board = view.deck(x - 0.6 * half / WINDOW, x + 0.6 * half / WINDOW, edge)
        view.paint(axes, camera, [board, view.blocks(ramp, *near), robots[number - 1]])
        view.frame(axes)
        axes.set(xlim=(centre - half, centre + half), ylim=(ground - below, ground + above))
        axes.set_title(f"step {number}, {time - walk.time[0]:.2f} s", fontsize=7)
    for axes in panels[len(moments(walk)) :]:
        axes.set_axis_off()
    return figure


def caption(given: Given) -> str:
    walk = given.twin.walk
    durations = np.diff(walk.heel_strike_time[: STEPS + 1])
    spread = f", their durations from {durations.min():.4f} to {durations.max():.4f} s" if len(durations) else ""
    return (
        f"The twin in {len(moments(walk))} consecutive steps from its start, each {100 * PHASE:.0f} % after its heel "
        f"strike{spread}. The camera goes along; blocks are those of the ramp."
    )


FIGURE = Entry("Figure 13: six consecutive steps", 13, ("twin", "analytic"), draw, caption, claims=("twin_settles",))
