"""Figure 10: the twin walking down its ramp, every part where the walk has it, and its phase portraits."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.biped.accuracy.scales import size
from stages.drawing import style
from stages.figures import view
from stages.figures.entry import Entry, Given
from stages.figures.view import COLOURS, SMALL, of_twin
from stages.twin.exports.solids import what_is_drawn
from stages.twin.ramp import laid

LEG_COLOURS = tuple(COLOURS.values())
LEG_NAMES = ("inner legs", "outer legs")
#: Poses, and steps from one to the next: not whole, so that each shows another part of the step.
POSES, STEPS_APART = 5, 2.2
AZIMUTH, ELEVATION = np.radians(14.0), np.radians(13.0)


def draw_walk(axes: Axes, given: Given) -> None:
    """The ramp with poses of the walk where they were, each with its time."""
    walk, twin, biped = given.twin.walk, given.parameters.twin, given.parameters.biped
    ramp = laid(twin, given.analytic.gait.step_length_m)
    camera = view.Camera(AZIMUTH, ELEVATION, given.parameters.slope.angle)
    period = given.twin.settling.step_frequency_hz**-1
    times = walk.time[0] + STEPS_APART * period * np.arange(POSES)
    times = times[times <= walk.time[-1]]
    bodies, natural, large = of_twin(twin, biped, SMALL), biped.leg_length + twin.outsole, size(biped)
    end = ramp.steps * ramp.step
    poses = [pose for pose in (view.pose_at(walk, time, natural) for time in times) if pose.hip[0] <= end]
    edge = ramp.tracks[1] + 0.6 * ramp.width
    view.paint(axes, camera, [view.deck(-0.16 * large, end + 0.1 * large, edge), view.blocks(ramp)])
    for pose, time in zip(poses, times):
        view.paint(axes, camera, [pose.robot(bodies)])
        x, y = camera.spot(np.array([pose.hip[0], 0.0, edge + 0.02 * large]))
        axes.text(x, y - 0.075 * large, f"{time - walk.time[0]:.2f} s", ha="center", va="top", fontsize=7)
    view.frame(axes)


def draw(given: Given) -> Figure:
    """Poses on the ramp, and the phase portrait of the whole walk."""
    walk = given.twin.walk
    figure = plt.figure(figsize=(style.TWO_COLUMNS, 5.1))
    parts: Any = figure.subfigures(2, 1, height_ratios=(1.0, 1.0))
    upper, lower = parts
    scene = upper.subplots()
    draw_walk(scene, given)
    for colour, name in zip(LEG_COLOURS, LEG_NAMES, strict=True):
        scene.plot([], [], color=colour, linewidth=4, label=name)
    upper.legend(loc="outside upper right", ncols=2)
    portraits = lower.subplots(1, 2, sharey=True)
    strikes = walk.heel_strike_time[walk.heel_strike_leg == 0]
    begin, end = strikes[-2:] if len(strikes) > 1 else (np.inf, np.inf)
    settled = (walk.time >= begin) & (walk.time <= end)
    for pair, (axes, name) in enumerate(zip(portraits, LEG_NAMES, strict=True)):
        angle, rate = np.degrees(walk.leg_angle[:, pair]), walk.leg_rate[:, pair]
        axes.plot(angle, rate, color="#BBBBBB", linewidth=0.6, label="transient")
        axes.plot(angle[settled], rate[settled], color=LEG_COLOURS[pair], linewidth=1.4, label="last stride")
        axes.plot(angle[0], rate[0], "o", color=style.ANALYTIC, markersize=4, label="start: simple model's gait")
        axes.set_xlabel(f"angle of the {name} [°]")
        if pair == 0:
            axes.legend(loc="center", bbox_to_anchor=(0.5, 0.66))
    style.panel_labels((scene, *portraits))
    portraits[0].set_ylabel("rate [rad/s]")
    return figure


def caption(given: Given) -> str:
    settling = given.twin.settling
    settled = settling.steps_to_settle >= 0
    when = f"settles to 1 % after step {settling.steps_to_settle}" if settled else "does not settle"
    twin, biped = given.parameters.twin, given.parameters.biped
    bodies = "" if twin.inertia == "planar" else ", bodies with inertia from an assumed bill of parts"
    return (
        f"Poses {STEPS_APART:g} steps apart on the ramp's stepping blocks, where the walk had them: "
        f"{what_is_drawn(twin, biped).rstrip(',')}. Four feet, paired legs{bodies}. From the simple model's gait the "
        f"twin {when}; its last four steps: {settling.frequency_text()}."
    )


FIGURE = Entry("Figure 10: the digital twin", 10, ("twin", "analytic"), draw, caption, claims=("twin_settles",))
