"""The gait as an animation for the report: every model's walk over the others', with the forces of the ground.

A fragment of a page without any outside reference; the report puts it in. Numbers are rounded to what a screen shows.
"""

import json
import math
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

import numpy as np

from stages.biped.accuracy.scales import size
from stages.biped.design import Biped
from stages.biped.walk import Walk
from stages.drawing import style
from stages.figures.entry import Entry, Given
from stages.ground.slope import Slope

FRAME_RATE = 100  # Hz
#: The three walks, which all start in the same mid-stance state: name, and how their lines look, colours on light and
#: dark ground, dashes on canvas and in CSS.
LOOKS: tuple[dict[str, Any], ...] = (
    {"name": "constraint model", "light": style.ANALYTIC, "dark": "#56B4E9", "dash": [], "swatch": "solid"},
    {"name": "penalty contact (Exudyn)", "light": style.MULTIBODY, "dark": "#E69F00", "dash": [7, 5],
     "swatch": "dashed"},
    {"name": "digital twin", "light": style.TWIN, "dark": "#F0F0F0", "dash": [2, 4], "swatch": "dotted"},
)


def resolution(biped: Biped, gravity: float) -> dict[str, float]:
    """What positions and lengths [m], angles [rad] and forces [N] of a robot are stored in whole numbers of."""
    return {"length": 1e-5 * size(biped), "angle": 1e-4, "force": 1e-3 * biped.weighed_mass * gravity}


def frames(walk: Walk, time: np.ndarray, units: Mapping[str, float]) -> dict[str, list[int]]:
    """Poses and ground forces at given times [s], row by row: hip x, y; angles, lengths of the legs; force (leg, x y).

    Whole numbers of `units`, a `resolution`.
    """

    def whole(signal: np.ndarray, unit: float) -> list[int]:
        columns = signal.reshape(len(walk.time), -1).T
        values = np.column_stack([np.interp(time, walk.time, column) for column in columns])
        rounded: list[int] = np.round(values / unit).astype(int).ravel().tolist()
        return rounded

    return {
        "hip": whole(walk.hip_position, units["length"]),
        "angle": whole(walk.leg_angle, units["angle"]),
        "length": whole(walk.leg_length, units["length"]),
        "force": whole(walk.ground_reaction, units["force"]),
    }


def content(walks: Sequence[Walk], biped: Biped, slope: Slope) -> dict[str, Any]:
    """What the animation shows: all walks, as `LOOKS` has them, over the time they have in common. An arrow's length is
    in metres a newton, marks on the ground in metres, those of forces in newtons.
    """
    large, units = size(biped), resolution(biped, slope.gravity)
    end = min(float(walk.time[-1]) for walk in walks)
    time = np.arange(int(end * FRAME_RATE) + 1) / FRAME_RATE
    moving = [frames(walk, time, units) for walk in walks]
    loads = units["force"] * np.concatenate([np.reshape(one["force"], (-1, 2, 2))[:, :, 1].ravel() for one in moving])
    # Impacts reach hundreds of newtons for a millisecond: on that scale nothing else could be seen. Even times, because
    # the walks have most of their samples around impacts.
    highest = 1.25 * float(np.percentile(loads[loads > 0], 98))
    step = 0.5 * 10.0 ** math.floor(math.log10(highest))
    limit = float(step * np.ceil(highest / step))
    return {
        "size": large,
        "units": units,
        "arrow": 0.24 * large / limit,
        "gap": step * math.ceil(limit / step / 8),
        "mark": nice(0.1 * large),
        "rate": FRAME_RATE,
        "count": len(time),
        "radius": list(biped.foot_radii),
        "slope": round(slope.angle, 9),
        "limit": limit,
        "sources": [look | one for look, one in zip(LOOKS, moving, strict=True)],
    }


def nice(value: float) -> float:
    """1, 2 or 5 times a power of ten, the largest that is not above a value."""
    power = 10.0 ** math.floor(math.log10(value * (1.0 + 1e-9)))
    return max(share * power for share in (1, 2, 5) if share * power <= value * (1.0 + 1e-9))


def draw(given: Given) -> str:
    """The animation as a fragment of a page."""
    page = files("stages.figures.drawn").joinpath("gait_animation.html").read_text(encoding="utf-8")
    walks = given.analytic.walk, given.multibody.walk, given.twin.walk
    moving = content(walks, given.parameters.biped, given.parameters.slope)
    page = page.replace("@ARROW@", f"{1e3 * moving['arrow']:.3g}").replace("@LONGEST@", f"{300 * moving['size']:.0f}")
    data = json.dumps(moving, separators=(",", ":")).replace("<", "\\u003c")
    before, _, after = page.partition(">DATA<")
    return f"{before}>{data}<{after}"


def caption(given: Given) -> str:
    gait, cycle, settling = given.analytic.gait, given.multibody.cycle, given.twin.settling
    why = given.multibody.unsettled and f" ({given.multibody.unsettled})"
    penalty = "no whole step" if math.isnan(cycle.period_s) else (
        f"{cycle.step_frequency_hz:.4f} Hz and {1e3 * cycle.step_length_m:.1f} mm{why}")
    return (
        "All three start in the constraint model's mid-stance state and drift apart into gaits of their own. "
        f"Step frequency and length: {gait.step_frequency_hz:.4f} Hz and {1e3 * gait.step_length_m:.1f} mm with "
        f"constraints, {penalty} with penalty contact. "
        f"The twin's last four steps: {settling.last_four()}."
    )


FIGURES = {
    "gait_animation": Entry(
        "The gait in three models",
        0,
        ("analytic", "multibody", "twin"),
        draw,
        caption,
        claims=("step_frequency",),
    )
}
