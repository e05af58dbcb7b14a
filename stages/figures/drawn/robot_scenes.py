"""The robot in its scenes: the simplified model, the twin on its ramp and step by step, its sensors."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from stages.biped.accuracy.scales import size
from stages.biped.design import Biped
from stages.biped.walk import Walk
from stages.comparison.stride import NoEvidence
from stages.drawing import style
from stages.figures import view
from stages.figures.entry import Entry, Given
from stages.figures.view import COLOURS, LONGEST, SMALL, Faces, by_group, of_twin
from stages.twin.exports.solids import what_is_drawn
from stages.twin.machine.parts import FEET, FRAMES, Part
from stages.twin.ramp import laid

#: Azimuth and elevation of each figure's camera [deg].
CAMERAS = {
    "simple_model": (28.0, 16.0),
    "twin": (14.0, 13.0),
    "ramp": (46.0, 20.0),
    "steps": (24.0, 14.0),
    "sensors": (35.0, 20.0),
}


def camera_of(name: str, given: Given) -> view.Camera:
    """The camera of a figure on the study's slope."""
    azimuth, elevation = np.radians(CAMERAS[name])
    return view.Camera(azimuth, elevation, given.parameters.slope.angle)


# Figure 3: the simplified model as Exudyn walks it: two legs with round feet in one plane.

#: The legs are drawn this far to either side of their plane [m], so that both are seen; for Table 1's leg.
ASIDE, THICK = 0.016, 0.02
#: When in the walk it is shown: this part of the step after the second heel strike.
MODEL_PHASE = 0.3


def parts(biped: Biped) -> tuple[Part, ...]:
    """Each leg above and below its spring, its round foot and the mass below the spring; the hip's mass."""
    large = size(biped)
    aside, thick = large * ASIDE, large * THICK
    hip = 0.022 * large, 3.2 * aside
    shown = [Part("hip", FRAMES[0], "aluminium", "cylinder", "z", hip, 1.0, (0.0, 0.0, 0.0), 1)]
    for number, (frame, foot, z) in enumerate(zip(FRAMES, FEET, (aside, -aside), strict=True)):
        leg = biped.leg(number)
        radius, centre, mass = leg.foot_radius, leg.foot_radius - leg.leg_length, leg.foot_com - leg.leg_length
        middle, low = 0.55 * centre, min(0.014 * large, max(leg.foot_com, 0.008 * leg.leg_length))  # above the ground

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


def draw_simple_model(given: Given) -> Figure:
    """The model on its plane, and its axes."""
    walk, biped = given.multibody.walk, given.parameters.biped
    camera = camera_of("simple_model", given)
    pose = view.pose_at(walk, view.moment(walk, MODEL_PHASE), biped.leg_lengths)
    x = pose.hip[0]
    figure, axes = plt.subplots(figsize=(style.ONE_COLUMN, 2.7))
    large = size(biped)
    floor = view.deck(x - 0.3 * large, x + 0.3 * large, 0.15 * large, large)
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


def caption_simple_model(given: Given) -> str:
    biped = given.parameters.biped
    other = biped.leg(1)
    masses, radii = dict.fromkeys([biped.foot_mass, other.foot_mass]), dict.fromkeys(biped.foot_radii)
    return (
        f"The planar model as it stands in Exudyn: hip of {biped.hip_mass:g} kg, two legs "
        f"{'on springs' if biped.legs == 'compliant' else 'without springs'} with "
        f"{' and '.join(f'{mass:g}' for mass in masses)} kg below {'each' if len(masses) == 1 else 'them'} and feet of "
        f"{' and '.join(f'{1e3 * radius:g}' for radius in radii)} mm. It moves in the x-y plane; its "
        "legs are drawn side by side so that both are seen."
    )


# Figure 10: the twin walking down its ramp, every part where the walk has it, and its phase portraits.

LEG_COLOURS = tuple(COLOURS.values())
LEG_NAMES = ("inner legs", "outer legs")
#: Poses, and steps from one to the next: not whole, so that each shows another part of the step.
POSES, STEPS_APART = 5, 2.2


def draw_walk(axes: Axes, given: Given) -> None:
    """The ramp with poses of the walk where they were, each with its time."""
    walk, twin, biped = given.twin.walk, given.parameters.twin, given.parameters.biped
    ramp = laid(twin, given.parameters.blocks, given.analytic.gait.step_length_m)
    camera = camera_of("twin", given)
    period = given.twin.settling.step_frequency_hz**-1
    times = walk.time[0] + STEPS_APART * period * np.arange(POSES)
    times = times[times <= walk.time[-1]]
    bodies, natural, large = of_twin(twin, biped, SMALL), view.unloaded(twin, biped), size(biped)
    end = ramp.steps * ramp.step
    poses = [pose for pose in (view.pose_at(walk, time, natural) for time in times) if pose.hip[0] <= end]
    edge = ramp.tracks[1] + 0.6 * ramp.width
    view.paint(axes, camera, [view.deck(-0.16 * large, end + 0.1 * large, edge, large), view.blocks(ramp, large)])
    for pose, time in zip(poses, times):
        view.paint(axes, camera, [pose.robot(bodies)])
        x, y = camera.spot(np.array([pose.hip[0], 0.0, edge + 0.02 * large]))
        axes.text(x, y - 0.075 * large, f"{time - walk.time[0]:.2f} s", ha="center", va="top", fontsize=7)
    view.frame(axes)


def draw_twin(given: Given) -> Figure:
    """Poses on the ramp, and the phase portrait of the whole walk."""
    walk = given.twin.walk
    figure = plt.figure(figsize=(style.TWO_COLUMNS, 3.9))
    parts: Any = figure.subfigures(1, 2)
    left, right = parts
    scene = left.subplots()
    draw_walk(scene, given)
    for colour, name in zip(LEG_COLOURS, LEG_NAMES, strict=True):
        scene.plot([], [], color=colour, linewidth=4, label=name)
    left.legend(loc="outside upper center", ncols=2)
    portraits = right.subplots(2, 1, sharex=True)
    strikes = walk.heel_strike_time[walk.heel_strike_leg == 0]
    begin, end = strikes[-2:] if len(strikes) > 1 else (np.inf, np.inf)
    settled = (walk.time >= begin) & (walk.time <= end)
    for pair, (axes, name) in enumerate(zip(portraits, LEG_NAMES, strict=True)):
        angle, rate = np.degrees(walk.leg_angle[:, pair]), walk.leg_rate[:, pair]
        axes.plot(angle, rate, color="#BBBBBB", linewidth=0.6, label="transient")
        axes.plot(angle[settled], rate[settled], color=LEG_COLOURS[pair], linewidth=1.4, label="last stride")
        axes.plot(angle[0], rate[0], "o", color=style.ANALYTIC, markersize=4, label="start: simple model's gait")
        axes.set_ylabel(f"rate of the {name} [rad/s]")
        if pair == 0:
            axes.legend(loc="center", bbox_to_anchor=(0.5, 0.66))
    portraits[-1].set_xlabel("angle of the legs [°]")
    style.panel_labels((scene, *portraits))
    return figure


def caption_twin(given: Given) -> str:
    settling = given.twin.settling
    settled = settling.steps_to_settle >= 0
    when = f"settles to 1 % after step {settling.steps_to_settle}" if settled else "does not settle"
    twin, biped = given.parameters.twin, given.parameters.biped
    bodies = "" if twin.inertia == "planar" else ", bodies with inertia from an assumed bill of parts"
    return (
        f"Poses {STEPS_APART:g} steps apart on the ramp's stepping blocks, where the walk had them: "
        f"{what_is_drawn(twin, biped).rstrip(',')}. Four feet, paired legs{bodies}. From the simple model's gait the "
        f"twin {when}; its last four steps: {settling.last_four()}."
    )


# Figure 12: the robot on its ramp with stepping blocks, and where its sensors are.

#: Where the robot stands, as a part of the ramp's steps.
ALONG = 0.55
#: Of a sensor: its name, and where its words stand from it on the page [m], for a leg of `scales.LEG_LENGTH`.
WORDS = {"hip sensor": (0.16, 0.10), "foot sensor": (0.30, 0.10)}
#: How high such words are on the page [m], for the same leg.
HIGH = 0.06


def draw_ramp(given: Given) -> Figure:
    """The whole ramp with the robot on it."""
    walk, twin, biped = given.twin.walk, given.parameters.twin, given.parameters.biped
    ramp = laid(twin, given.parameters.blocks, given.analytic.gait.step_length_m)
    camera = camera_of("ramp", given)
    natural, large = view.unloaded(twin, biped), size(biped)
    moment = walk.time[0] + ALONG * (walk.time[-1] - walk.time[0])
    pose = view.pose_at(walk, float(moment), natural)
    stride = 2.0 * ramp.step
    back = stride * round((pose.hip[0] - ALONG * ramp.steps * ramp.step) / stride)
    pose = view.Pose(pose.hip - [back, 0.0], pose.angle, pose.slide)
    edge = ramp.tracks[1] + 0.8 * ramp.width
    figure, axes = plt.subplots(figsize=(style.ONE_COLUMN, 2.2))
    spare = 0.5 * (ramp.length - ramp.steps * ramp.step)
    view.paint(axes, camera, [
        view.deck(-spare, ramp.steps * ramp.step + spare, edge, large),
        view.blocks(ramp, large),
        pose.robot(of_twin(twin, biped, SMALL)),
    ])  # fmt: skip
    for name, (ahead, above) in WORDS.items():
        words = large * ahead, large * above
        foot = name == "foot sensor"
        place = twin.foot_sensor(biped.foot_com - biped.leg_length) if foot else twin.hip_socket
        group = "inner_foot" if foot else "inner_frame"
        point = pose.point(place, group)
        axes.update_datalim([camera.spot(point, (words[0], words[1] + HIGH * large))])  # its words stay in the picture
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


def caption_ramp(given: Given) -> str:
    twin = given.parameters.twin
    ramp = laid(twin, given.parameters.blocks, given.analytic.gait.step_length_m)
    rolls = given.analytic.gait.step_length_m - float(given.analytic.limp.feet_apart_m.mean())
    short = ("" if rolls <= ramp.lanes[0].length else f" A foot rolls over {1e3 * rolls:.0f} mm, farther than a block "
             f"of {1e3 * ramp.lanes[0].length:.0f} mm carries it (ground.block_length).")
    return (
        f"The ramp of {ramp.length:.4g} m at {np.degrees(given.parameters.slope.angle):.3g}° with {ramp.sets} sets "
        f"of stepping blocks, {1e3 * ramp.step:.0f} mm apart, for inner and outer feet in turn: a swinging foot goes "
        "down through the gaps of its own lanes. One sensor is at the hip, one on an inner foot." + short
    )


# Figure 13: six consecutive steps of the twin on its ramp, each at the same phase.

STEPS = 6
#: Half the width of what one picture shows, and how far it goes below and above the ground [m] for Table 1's leg;
#: farther where the robot needs it.
STEP_WINDOW, BELOW, ABOVE = 0.165, 0.085, 0.40
#: When a step is shown: this part of it after its heel strike.
STEP_PHASE = 0.2


def moments(walk: Walk) -> np.ndarray:
    """Times of the same phase of consecutive steps, the first after the first heel strike [s]."""
    strikes = walk.heel_strike_time[: STEPS + 1]
    return np.asarray(strikes[:-1] + STEP_PHASE * np.diff(strikes))


def draw_steps(given: Given) -> Figure:
    """A picture a step; the camera goes along."""
    walk, twin, biped = given.twin.walk, given.parameters.twin, given.parameters.biped
    ramp = laid(twin, given.parameters.blocks, given.analytic.gait.step_length_m)
    if not len(moments(walk)):
        raise NoEvidence(f"the twin makes no whole step: {given.twin.reason}")
    camera = camera_of("steps", given)
    bodies, natural, large = of_twin(twin, biped, SMALL), view.unloaded(twin, biped), size(biped)
    poses = [view.pose_at(walk, float(time), natural) for time in moments(walk)]
    robots = [pose.robot(bodies) for pose in poses]
    middles = [camera.page(np.array([pose.hip[0], 0.0, 0.0])) for pose in poses]  # on the page, on the ground
    reach = [camera.page(robot.corners) - middle for robot, middle in zip(robots, middles)]
    half = 1.02 * max([STEP_WINDOW * large / 1.02, *(abs(each[..., 0]).max() for each in reach)])
    below = 1.02 * max([BELOW * large / 1.02, *(-each[..., 1].min() for each in reach)])
    above = 1.02 * max([ABOVE * large / 1.02, *(each[..., 1].max() for each in reach)])
    edge = ramp.tracks[1] + 0.8 * ramp.width
    figure, panels = plt.subplots(1, STEPS, figsize=(style.TWO_COLUMNS, 2.15))
    for number, (axes, time) in enumerate(zip(panels, moments(walk)), 1):
        x, (centre, ground) = poses[number - 1].hip[0], middles[number - 1]
        near = max(0, int(np.ceil((x - 3 * half) / ramp.step))), int((x + 3 * half) / ramp.step)
        board = view.deck(x - 0.6 * half / STEP_WINDOW, x + 0.6 * half / STEP_WINDOW, edge, large)
        view.paint(axes, camera, [board, view.blocks(ramp, large, *near), robots[number - 1]])
        view.frame(axes)
        axes.set(xlim=(centre - half, centre + half), ylim=(ground - below - 0.15 * large, ground + above))
        axes.set_title(f"step {number}, {time - walk.time[0]:.2f} s", fontsize=7)
    for axes in panels[len(moments(walk)) :]:
        axes.set_axis_off()
    # a scale, as the camera sees what lies along the ramp
    (across, up), (centre, ground) = camera.page(np.array([ramp.step, 0.0, 0.0])), middles[0]
    low = ground - below - 0.04 * large
    panels[0].plot(centre + 0.5 * across * np.array([-1, 1]), low + 0.5 * up * np.array([-1, 1]), "|-",
                   color="black", linewidth=1.0, markersize=5)  # fmt: skip
    panels[0].text(centre, low - 0.03 * large, f"a step, {1e3 * ramp.step:.0f} mm", ha="center", va="top", fontsize=7)
    handles = [Line2D([], [], color=colour, linewidth=4, label=name)
               for colour, name in zip(LEG_COLOURS, LEG_NAMES, strict=True)]  # fmt: skip
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


def caption_steps(given: Given) -> str:
    walk = given.twin.walk
    durations = np.diff(walk.heel_strike_time[: STEPS + 1])
    spread = f", their durations from {durations.min():.4f} to {durations.max():.4f} s" if len(durations) else ""
    return (
        f"The twin in {len(moments(walk))} consecutive steps from its start, each {100 * STEP_PHASE:.0f} % after its "
        f"heel strike{spread}. The camera goes along; blocks are those of the ramp."
    )


# Figure 15: axes of the sensors, as they lie in their sockets and as the ingest turns them.

#: When in the walk the robot is shown: this part of the step after the second heel strike.
SENSORS_PHASE = 0.25
#: Half the width of a close view, and length of an arrow in it and in the whole [m], for Table 1's leg.
CLOSE_WINDOW, CLOSE, WHOLE = 0.062, 0.036, 0.085
#: Length of the sensors' own axes in a close view [m]: shorter, as one may lie on one of the others.
OWN_LENGTH = 0.024
NAMES = ("forward", "up", "lateral")
OWN = "#5A5A5A"


def draw_sensors(given: Given) -> Figure:
    """The robot with both frames, then each sensor from near, with the axes it was found to have."""
    walk, twin, biped = given.twin.walk, given.parameters.twin, given.parameters.biped
    camera = camera_of("sensors", given)
    pose = view.pose_at(walk, view.moment(walk, SENSORS_PHASE), view.unloaded(twin, biped))
    robot = pose.robot(of_twin(twin, biped))
    large, window = size(biped), size(biped) * CLOSE_WINDOW
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


def caption_sensors(given: Given) -> str:
    run = given.imu.runs[0]
    turned = [np.degrees(np.arccos(np.clip(0.5 * (np.trace(sensor.rotation) - 1.0), -1.0, 1.0)))
              for sensor in (run.foot, run.hip)]  # fmt: skip
    return (
        "Both sensors sit on the inner legs and measure specific force and angular velocity on the axes forward, up "
        f"the leg and lateral. Dashed: a sensor's own axes, which the ingest found turned by {turned[0]:.1f}° at the "
        f"foot and {turned[1]:.1f}° at the hip in the first run ({given.imu.origin})."
    )


FIGURES = {
    "figure_03_simple_model": Entry(
        "Figure 3: the simplified model", 3, ("multibody",), draw_simple_model, caption_simple_model
    ),
    "figure_10_twin": Entry(
        "Figure 10: the digital twin", 10, ("twin", "analytic"), draw_twin, caption_twin, claims=("twin_settles",)
    ),
    "figure_12_ramp": Entry(
        "Figure 12: the robot on the ramp", 12, ("twin", "analytic"), draw_ramp, caption_ramp, claims=("ramp_length",)
    ),
    "figure_13_steps": Entry(
        "Figure 13: six consecutive steps",
        13,
        ("twin", "analytic"),
        draw_steps,
        caption_steps,
        claims=("twin_settles",),
    ),
    "figure_15_sensors": Entry("Figure 15: axes of the sensors", 15, ("twin", "imu"), draw_sensors, caption_sensors),
}
