"""Figure 6: the friction law, the friction force it gives, and what its two transition velocities do."""

from __future__ import annotations

import dataclasses

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.drawing import style
from stages.figures.drawn.figure_05_contact_parameters import CONSTRAINT, constraint_force, differences
from stages.figures.entry import Entry, Given
from stages.ground.friction import friction_coefficient

VELOCITIES = (
    ("stiction_velocity", "$v_s$", "o-", style.MULTIBODY),
    ("friction_velocity", "$v_d$", "s--", style.SECOND),
)


def draw(given: Given) -> Figure:
    """Law, force over the stance, and sensitivity of the hip's motion and of the creep."""
    study = given.contact_study
    figure, ((law, force), (hip, creep)) = plt.subplots(2, 2, figsize=(style.TWO_COLUMNS, 4.2))
    default, chosen = study.default.law, study.chosen.law
    slip = np.linspace(-1.5, 1.5, 3001) * default.friction_velocity
    for one, colour, label in (
        (default, style.TWIN, "Adams' transitions, defaults"),
        (chosen, style.MULTIBODY, "Adams' transitions, chosen"),
        (dataclasses.replace(chosen, friction="coulomb"), style.ANALYTIC, "regularised Coulomb"),
    ):
        line = "--" if one.friction == "coulomb" else "-"
        law.plot(slip, friction_coefficient(one, slip), line, color=colour, label=label, linewidth=1.0)
    law.set(ylim=(-1.25, 2.0), xlabel="slip velocity $v$ [m/s]", ylabel=r"friction coefficient $\mu$ [1]")
    law.legend(loc="upper left", fontsize=6)

    exact = constraint_force(given.analytic.walk)
    shown = exact[0] <= study.time[-1]
    force.plot(exact[0][shown], exact[1][shown, 0], color=CONSTRAINT, linewidth=4, label="constraint model")
    for curve, colour, label in (
        (study.default_force, style.TWIN, "defaults"), (study.chosen_force, style.MULTIBODY, "chosen set")
    ):  # fmt: skip
        force.plot(study.time, curve[:, 0], color=colour, linewidth=0.9, label=label)
    force.set_xlim(-0.01, study.time[-1])
    quiet = exact[1][shown & (exact[0] > 0.02), 0]
    reach = max(np.ptp(quiet), 0.1 * np.abs(quiet).max()) or 1.0
    force.set(ylim=(quiet.min() - 0.5 * reach, quiet.max() + 0.5 * reach), xlabel="time from heel strike [s]",
              ylabel="friction force $F_T$ [N]")
    force.legend(loc="lower right")

    for key, symbol, line, colour in VELOCITIES:
        values, found = differences(study, key)
        hip.loglog(values, 1e3 * found, line, color=colour, markersize=3, label=f"{symbol} changed alone")
        rows = study.variations.rows(key)
        speeds = np.array([study.default.creep_velocity, *study.variations.creep_velocity[rows]])
        order = np.argsort([getattr(default, key), *study.variations.value[rows]])
        creep.loglog(values, 1e3 * speeds[order], line, color=colour, markersize=3, label=f"{symbol} changed alone")
    for panel, size in ((hip, study.chosen.hip_position.max()), (creep, study.chosen.creep_velocity)):
        panel.plot(chosen.stiction_velocity, 1e3 * size, "*", color=style.TWIN, markersize=9, label="chosen set")
        panel.set_xlabel("transition velocity [m/s]")
        panel.legend(loc="lower right")
        style.round_ticks(panel.yaxis)
    hip.set_ylabel("largest hip difference [mm]")
    creep.set_ylabel("creep in stance [mm/s]")
    style.panel_labels((law, force, hip, creep))
    return figure


def caption(given: Given) -> str:
    study = given.contact_study
    return (
        "Below the stiction velocity a loaded foot creeps: at "
        f"{1e3 * study.default.creep_velocity:.2f} mm/s with Adams' defaults and "
        f"{1e3 * study.chosen.creep_velocity:.2f} mm/s with the chosen set."
    )


FIGURE = Entry("Figure 6: friction", 6, ("contact_study", "analytic"), draw, caption, claims=("friction_velocities",))
