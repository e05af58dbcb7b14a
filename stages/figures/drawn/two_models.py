"""The constraint model beside penalty contact: forces, snapshots, motion of the hip (figures 2, 7 and 8)."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from stages.biped.accuracy.scales import scales_of, size
from stages.biped.quantity import mm
from stages.biped.walk import Walk
from stages.comparison.agreement import overlay
from stages.comparison.result import DOES_NOT_APPLY
from stages.comparison.stride import NoEvidence, there
from stages.drawing import style
from stages.figures.entry import Entry, Given
from stages.multibody.result import in_newtons

# Figure 2: ground reaction of one foot from its heel strike to its toe-off.

LEG = 1


#: The impact as it is shown, and when it is over, in pendulum times from heel strike.
IMPACT, OVER = (-0.005, 0.065), 0.1086


def contact(walk: Walk, leg: int, which: int) -> tuple[np.ndarray, np.ndarray]:
    """The `which`-th whole contact of a leg, from its heel strike to its toe-off, counted from 0 (-1 is the last): time
    since heel strike (n,) [s], ground reaction (n, 2) [N]."""
    strikes = walk.heel_strike_time[walk.heel_strike_leg == leg]
    lifts = walk.toe_off_time[walk.toe_off_leg == leg]
    whole = [(start, lifts[lifts > start][0]) for start in strikes if (lifts > start).any()]
    if not whole:
        raise NoEvidence("a model's walk ends before that foot has landed and left once")
    start, end = whole[which]
    # the penalty model touches and leaves a little earlier and later than its events: a margin shows the zeros
    inside = (walk.time >= start - 0.01) & (walk.time <= end + 0.02)
    return walk.time[inside] - start, walk.ground_reaction[inside, leg]


def draw_ground_reaction(given: Given) -> Figure:
    """Normal and friction force of both models over one contact; a second row shows the impact at its own scale."""
    walk = given.multibody.walk
    limps = given.analytic.gait.steps > 1  # then one leg strikes harder: that one, as its peak is the caption's
    leg = int(np.argmax(walk.ground_reaction[:, :, 1].max(axis=0))) if limps else LEG
    ours, theirs = contact(given.analytic.walk, leg, 0), contact(walk, leg, -1)
    time = scales_of(given.parameters.biped, given.parameters.slope.gravity).time
    figure, axes = plt.subplots(2, 2, figsize=(style.TWO_COLUMNS, 3.9), sharex="col")
    for row, (column, name) in enumerate(((1, "normal force $F_N$ [N]"), (0, "friction force $F_T$ [N]"))):
        whole, impact = axes[row]
        for part, milliseconds in ((whole, False), (impact, True)):
            scale = 1e3 if milliseconds else 1.0
            for shown, look in (
                (ours, {"color": style.ANALYTIC, "label": "constraint model", "zorder": 3}),
                (theirs, {"color": style.MULTIBODY, "label": "penalty contact (Exudyn)", "linewidth": 0.9}),
            ):
                part.plot(scale * shown[0], shown[1][:, column], **look)
        contact_phase = ours[1][ours[0] > OVER * time, column]
        low, high = contact_phase.min(), contact_phase.max()
        margin = 0.6 * (high - low)
        whole.set(ylim=(min(low - margin, 0 - 0.1 * margin), high + margin), ylabel=name)
        whole.margins(x=0.02)
        style.mark_beyond(whole)
        impact.set(xlim=[1e3 * time * end for end in IMPACT], ylabel=name)
    style.panel_labels(axes.T.ravel())
    axes[0, 0].legend(loc="lower center")
    axes[1, 0].set_xlabel("time since heel strike [s]")
    axes[1, 1].set_xlabel("time since heel strike [ms]")
    axes[0, 1].set_title("impact, full scale")
    axes[0, 0].set_title("wedges: beyond the axis")
    return figure


def caption_ground_reaction(given: Given) -> str:
    gait, cycle = given.analytic.gait, given.multibody.cycle
    return (
        "Ground reaction of one foot from heel strike to toe-off. Penalty contact peaks at "
        f"{in_newtons(cycle.peak_normal_force)} with {1e6 * cycle.largest_penetration:.0f} µm of penetration; the "
        f"constraint model has an impulse instead. Both feet are down for {1e3 * gait.double_stance_s:.2f} ms a step "
        f"with constraints and {1e3 * cycle.double_stance_s:.2f} ms with penalty contact."
    )


# Figure 7: snapshots of the multibody model walking down the slope.

SNAPSHOTS = 8
LEG_COLOURS = (style.ANALYTIC, style.MULTIBODY)
FOOT_ARC_DEG = 40  # drawn part of the round foot on either side of the leg


def rotated(points: np.ndarray, slope: float) -> np.ndarray:
    """Points (n, 2) of the slope frame turned so that gravity points down the page."""
    cos, sin = np.cos(slope), np.sin(slope)
    return np.asarray(points @ np.array([[cos, -sin], [sin, cos]]))


def draw_biped(
    axes: Axes, hip: np.ndarray, angles: np.ndarray, lengths: np.ndarray, radii: Sequence[float], slope: float
) -> None:
    """Hip, two legs and their round feet at one instant."""
    for leg, (colour, radius) in enumerate(zip(LEG_COLOURS, radii, strict=True)):
        along = np.array([np.sin(angles[leg]), -np.cos(angles[leg])])
        centre = hip + (lengths[leg] - radius) * along
        line = rotated(np.array([hip, centre]), slope)
        axes.plot(line[:, 0], line[:, 1], color=colour, linewidth=1.4, solid_capstyle="round")
        turn = angles[leg] + np.radians(np.linspace(-FOOT_ARC_DEG, FOOT_ARC_DEG, 40))
        sole = rotated(centre + radius * np.column_stack([np.sin(turn), -np.cos(turn)]), slope)
        axes.plot(sole[:, 0], sole[:, 1], color=colour, linewidth=2.2, solid_capstyle="round")
        for end in (sole[0], sole[-1]):
            axes.plot([line[1, 0], end[0]], [line[1, 1], end[1]], color=colour, linewidth=0.7)
    top = rotated(hip[None, :], slope)[0]
    axes.plot(*top, "o", color=style.TWIN, markersize=4, zorder=4)


def draw_snapshots(given: Given) -> Figure:
    """Snapshots at equal times over the last three steps of the walk."""
    walk, slope = given.multibody.walk, given.parameters.slope.angle
    strikes = walk.heel_strike_time
    if len(strikes) < 4:
        raise NoEvidence(f"Exudyn's walk has no three whole steps: {given.multibody.summary()}")
    times = np.linspace(strikes[-4], strikes[-1], SNAPSHOTS)
    rows = np.searchsorted(walk.time, times).clip(max=len(walk.time) - 1)
    figure, panels = plt.subplots(1, 2, figsize=(style.TWO_COLUMNS, 1.9), sharex=True, sharey=True)
    large = size(given.parameters.biped)
    spread = 0.10 * large  # consecutive snapshots overlap on the page: each moves on by so much more than it walked
    for axes, part in zip(panels, np.array_split(rows, 2), strict=True):
        origin = walk.hip_position[part[0], 0]
        for number, row in enumerate(part):
            hip = walk.hip_position[row] - np.array([origin, 0.0]) + np.array([number * spread, 0.0])
            draw_biped(axes, hip, walk.leg_angle[row], walk.leg_length[row], given.parameters.biped.foot_radii, slope)
            ((x, y),) = rotated(np.array([[hip[0], -0.045 * large]]), slope)
            axes.text(x, y, f"{walk.time[row] - walk.time[rows[0]]:.2f} s", ha="center", va="top", fontsize=7)
        ground = rotated(np.array([[-0.25 * large, 0.0], [hip[0] + 0.25 * large, 0.0]]), slope)
        axes.plot(ground[:, 0], ground[:, 1], color=style.GROUND, linewidth=2)
        axes.set_aspect("equal")
        axes.grid(False)
        axes.set_axis_off()
    axes.plot([], [], color=LEG_COLOURS[0], label="inner leg")
    axes.plot([], [], color=LEG_COLOURS[1], label="outer leg")
    figure.legend(loc="outside upper center", ncols=2)
    return figure


def caption_snapshots(given: Given) -> str:
    cycle = given.multibody.cycle
    return (
        f"Exudyn's model on the slope of {np.degrees(given.parameters.slope.angle):.3g}°: "
        f"{cycle.speed_m_s:.4f} m/s, a step in {cycle.period_s:.4f} s. Three steps, from left to right; snapshots "
        f"stand {100 * size(given.parameters.biped):.0f} mm further apart than they were."
    )


# Figure 8: hip motion of both models from the same mid-stance state, with their difference on its own axis.

CLAIMS = ("hip_displacement", "hip_velocity", "integration_tolerance")
PANELS = (
    ("hip_position", 0, "$x_{hip}$ [m]", 1e3, "[mm]"),
    ("hip_position", 1, "$y_{hip}$ [m]", 1e3, "[mm]"),
    ("hip_velocity", 0, r"$\dot x_{hip}$ [m/s]", 1e3, "[mm/s]"),
    ("hip_velocity", 1, r"$\dot y_{hip}$ [m/s]", 1e3, "[mm/s]"),
)


def draw_hip_motion(given: Given) -> Figure:
    """Both models over two steps; grey bands are the paper's largest differences, for its own biped, bars the ones
    measured here, drawn over the span that they are measured over: the first step."""
    analytic, multibody = given.analytic.walk, given.multibody.walk
    limits, period, same = stated(given), given.analytic.gait.period_s, there(given.comparison.models).same_start
    time, position, velocity = overlay(analytic, multibody, 2 * period)
    count = len(time)
    figure, axes = plt.subplots(4, 2, figsize=(style.TWO_COLUMNS, 5.6), sharex=True, height_ratios=(2, 1, 2, 1))
    for index, (name, column, label, scale, unit) in enumerate(PANELS):
        row, side = 2 * (index // 2), index % 2
        curve, difference = axes[row, side], axes[row + 1, side]
        curve.plot(time, getattr(analytic, name)[:count, column], color=style.ANALYTIC, label="constraint model")
        shown = multibody.time <= time[-1]
        theirs = getattr(multibody, name)[shown, column]
        curve.plot(multibody.time[shown], theirs, "--", color=style.MULTIBODY, label="penalty contact (Exudyn)")
        values = position if name == "hip_position" else velocity
        limit = limits[name]
        difference.axhspan(-scale * limit, scale * limit, color="#EEEEEE", zorder=0)
        difference.plot(time, scale * values[:, column], color=style.TWIN, linewidth=0.9)
        # impact instants differ by a fraction of a millisecond: those spikes would hide the rest
        extent = np.percentile(np.abs(scale * values[:, column]), 98)
        largest = scale * (same.position if name == "hip_position" else same.velocity)[column]
        difference.set_ylim(*(np.array([-1.3, 1.3]) * max(extent, 1.2 * scale * limit, largest)))
        difference.hlines([-largest, largest], 0.0, period, color=style.TWIN, linestyle=":", linewidth=0.9)
        difference.axvline(period, color="#888888", linewidth=0.6)  # the first step's end
        style.mark_beyond(difference)
        curve.set_ylabel(label)
        difference.set_ylabel(f"difference\n{unit}")
    style.panel_labels(axes[::2].ravel())
    for side in (0, 1):
        axes[3, side].set_xlabel("time from the common mid-stance state [s]")
    handles, _ = axes[0, 0].get_legend_handles_labels()
    handles.append(Line2D([], [], color=style.TWIN, linestyle=":", label="largest over the first step"))
    if any(limits.values()):
        handles.append(Patch(color="#EEEEEE", label="the paper's largest"))
    figure.legend(handles=[*handles, style.wedge(style.TWIN)], loc="outside upper center", ncols=3)
    return figure


def stated(given: Given) -> dict[str, float]:
    """The largest differences [m, m/s] that the paper states of its biped; 0 for another one."""
    settings = given.parameters.settings
    its_own = (CLAIMS[0], DOES_NOT_APPLY) not in {(claim.id, claim.verdict) for claim in given.comparison.claims}
    return {"hip_position": its_own * settings.position_limit, "hip_velocity": its_own * settings.velocity_limit}


def caption_hip_motion(given: Given) -> str:
    same, (position, velocity) = there(given.comparison.models).same_start, stated(given).values()
    _, apart, _ = overlay(given.analytic.walk, given.multibody.walk, 2 * given.analytic.gait.period_s)
    later = np.abs(apart).max(axis=0)
    paper = f"; the paper states {1e3 * position:g} mm and {1e3 * velocity:g} mm/s" if position else ""
    return (
        "The same mid-stance state walks on in both models. Over the first step, up to the grey line, the hips differ "
        "by at most "
        f"{mm(same.position[0])} in x and {mm(same.position[1])} in y, "
        f"{mm(same.velocity[0])}/s and {mm(same.velocity[1])}/s outside the impacts{paper}. Over "
        f"both steps drawn they come to {mm(later[0])} in x and {mm(later[1])} in y: each model's cycle has its "
        "own period."
    )


FIGURES = {
    "figure_02_ground_reaction": Entry(
        "Figure 2: ground reaction",
        2,
        ("analytic", "multibody"),
        draw_ground_reaction,
        caption_ground_reaction,
        claims=("rolling_without_slip",),
    ),
    "figure_07_snapshots": Entry("Figure 7: snapshots", 7, ("multibody",), draw_snapshots, caption_snapshots),
    "figure_08_hip_motion": Entry(
        "Figure 8: hip motion of both models",
        8,
        ("analytic", "multibody", "comparison"),
        draw_hip_motion,
        caption_hip_motion,
        claims=CLAIMS,
    ),
}
