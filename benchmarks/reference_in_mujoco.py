"""Reference gaits in MuJoCo, whose ground only pushes: the gait it settles on, for grounds of growing hardness.

    bipedstudy reference-gaits --file gaits.json
    python -m benchmarks.reference_in_mujoco gaits.json plain rigid

Two legs in a plane, a sphere for each foot. As on stepping blocks the ground does not act on a foot that swings forward
behind the other one. `docs/reference_gaits.md` has what comes out.
"""

import json
import math
import sys
from typing import Any

import mujoco
import numpy as np

#: Time constant and damping ratio of `solref`, friction, and step of the solver [s]. Critical damping (ratio 1) throws
#: a landing mass back with e^-2 of its speed at any time constant. MuJoCo's contact is convex: a foot that slides as it
#: rises is pushed as well, the more so the larger the friction.
GROUNDS = ((4e-3, 1, 100, 2e-4), (1e-3, 1, 100, 5e-5), (2e-4, 1, 100, 1e-5), (2e-4, 10, 100, 2e-5), (2e-4, 10, 1, 2e-5))
STEPS = 24


def model(gait: dict[str, Any], constant: float, ratio: float, friction: float, step: float) -> mujoco.MjModel:
    """The biped in the slope frame, x down the slope, z normal to it; leg angles positive with the foot ahead."""
    parts = gait["parameters"]
    ground, hip = ({name: each["value"] for name, each in parts[key].items() if isinstance(each, dict)}
                   for key in ("ground", "hip"))  # fmt: skip
    angle = math.radians(ground["slope_deg"])
    legs = []
    for place in (0, 1):
        leg = {name: each["value"] for name, each in parts[f"leg_{place}"].items()}
        inertia = leg["leg_inertia"] + 1e-9 * leg["foot_mass"] * leg["leg_length"] ** 2
        slide = (f'<joint type="slide" axis="0 0 -1" stiffness="{leg["stiffness"]!r}" damping="{leg["damping"]!r}"/>'
                 if parts["hip"]["legs"] == "compliant" else "")  # fmt: skip
        legs.append(
            f'<body name="leg{place}"><joint type="hinge" axis="0 -1 0"/>{slide}<inertial mass="{leg["foot_mass"]!r}" '
            f'pos="0 0 {leg["foot_com"] - leg["leg_length"]!r}" diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>'
            f'<geom name="foot{place}" type="sphere" size="{leg["foot_radius"]!r}" '
            f'pos="0 0 {leg["foot_radius"] - leg["leg_length"]!r}" contype="1" conaffinity="0"/></body>')  # fmt: skip
    gravity = ground["gravity"]
    return mujoco.MjModel.from_xml_string(f"""
    <mujoco><compiler angle="radian"/>
    <option timestep="{step}" gravity="{gravity * math.sin(angle)!r} 0 {-gravity * math.cos(angle)!r}" cone="elliptic"
            integrator="implicitfast" impratio="100" tolerance="1e-14" iterations="100"/>
    <default><geom friction="{friction} 0 0" solref="{constant} {ratio}" solimp="0.999 0.9999 1e-6"/></default>
    <worldbody><geom type="plane" size="0 0 1" contype="0" conaffinity="1"/>
    <body name="hip"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
    <inertial mass="{hip["mass"]!r}" pos="0 0 0" diaginertia="1e-6 1e-6 1e-6"/>{"".join(legs)}</body></worldbody>
    </mujoco>""")


def strikes(gait: dict[str, Any], constant: float, ratio: float, friction: float, step: float) -> np.ndarray:
    """Times of heel strikes (STEPS,) [s], from the gait's start on."""
    found, built = list[float](), model(gait, constant, ratio, friction, step)
    data, start = mujoco.MjData(built), {name: each["value"] for name, each in gait["start"].items()}
    radius = built.geom("foot0").size[0]
    theta, length, rate, along = (start[f"stance_{name}"] for name in ("angle", "length", "rate", "length_rate"))
    compliant, arm = built.nq == 6, length - radius
    natural = [gait["parameters"][f"leg_{place}"]["leg_length"]["value"] for place in (0, 1)]
    legs = [-theta, length - natural[0], start["swing_angle"], start["swing_length"] - natural[1]]
    rates = [-rate, along, start["swing_rate"], start["swing_length_rate"]]
    data.qpos[:] = [radius * theta + arm * math.sin(theta), radius + arm * math.cos(theta),
                    *legs[:: 1 if compliant else 2]]  # fmt: skip
    down, up = radius + arm * math.cos(theta), math.sin(theta)
    data.qvel[:] = [down * rate + up * along, -arm * up * rate + math.cos(theta) * along,
                    *rates[:: 1 if compliant else 2]]  # fmt: skip
    mujoco.mj_forward(built, data)
    feet, hinge = [built.geom(f"foot{place}").id for place in (0, 1)], [2, 4 if compliant else 3]
    before, last = np.zeros(2), 0
    while len(found) < STEPS and data.time < 3 * STEPS * gait["period"]["value"]:
        mujoco.mj_step(built, data)
        heights = data.geom_xpos[feet, 2] - radius
        for place, foot in enumerate(feet):
            ahead, acts = data.geom_xpos[foot, 0] > data.geom_xpos[feet[1 - place], 0], built.geom_contype[foot]
            if acts and not ahead and heights[place] > 0 and data.qvel[hinge[place]] > 0:
                built.geom_contype[foot] = 0
            elif not acts and ahead and heights[place] > 0:
                built.geom_contype[foot] = 1
            elif acts and ahead and before[place] > 0 >= heights[place] and place != last:
                share = heights[place] / (heights[place] - before[place])
                found.append(data.time - step * share)
                last = place
        before = heights.copy()
    return np.array(found)


def main(path: str, *names: str) -> None:
    with open(path) as file:
        gaits = [gait for gait in json.load(file)["gaits"] if gait["name"] in names]
    for gait in gaits:
        for ground in GROUNDS:
            durations, period = np.diff(strikes(gait, *ground), prepend=0.0), gait["period"]["value"]
            first, last = durations[0] / period - 1, durations[-6:].mean() / period - 1
            spread = np.ptp(durations[-6:]) / period
            print(f"{gait['name']}, ground {ground}: {len(durations)} steps, first {1e2 * first:+.3f} %, "
                  f"settled {1e2 * last:+.3f} % (spread {1e2 * spread:.3f} %)", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
