"""The laws of the ground, and what each of their parameters does to a step: figures 4, 5 and 6."""

import dataclasses
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from stages.biped.accuracy.scales import scales_of
from stages.biped.quantity import mm
from stages.biped.walk import Walk
from stages.comparison.stride import NoEvidence
from stages.contact_study.result import Result
from stages.drawing import style
from stages.figures.drawn.two_models import OVER
from stages.figures.entry import Entry, Given
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import friction_coefficient, normal_force

# Figure 4: the normal force laws: hardening spring, damping ramp, and the whole force when loading and unloading.

EXPONENTS = (1.0, 1.5, 2.2, 3.0)
RATE = 0.01107  # leg lengths in a pendulum time, so slow that the ground still pushes when it lets the foot out


def spring_force(law: ContactLaw, exponent: float, penetration: np.ndarray) -> np.ndarray:
    """Force [N] at rest, of the law with another exponent and the same stiffness in N/mm^e."""
    return np.asarray(normal_force(dataclasses.replace(law, contact_exponent=exponent), penetration, 0.0))


def damping(law: ContactLaw, penetration: np.ndarray) -> np.ndarray:
    """Damping coefficient [N s/m] of the impact law at a penetration [m]: its force at 1 m/s less that at rest."""
    impact = dataclasses.replace(law, normal_force="impact")
    return np.asarray(normal_force(impact, penetration, 1.0) - normal_force(impact, penetration, 0.0))


def draw_normal_force(given: Given) -> Figure:
    """The laws with the values of ground.yaml."""
    law = given.parameters.contact
    speed = RATE * scales_of(given.parameters.biped, given.parameters.slope.gravity).size("m/s")
    figure, (spring, ramp, whole) = plt.subplots(1, 3, figsize=(style.TWO_COLUMNS, 2.4))
    depth = np.linspace(0.0, 1.3e-3, 400)
    for exponent, colour in zip(EXPONENTS, style.SEQUENCE):
        force = spring_force(law, exponent, depth)
        spring.plot(1e3 * depth, 1e-3 * force, color=colour, label=f"$e$ = {exponent:g}")
    spring.axvline(1.0, color=style.MEASURED, linewidth=0.7, linestyle=":")
    spring.set(xlabel="penetration $p$ [mm]", ylabel="spring force $F_k$ [kN]")
    spring.legend(loc="upper left")

    depth = np.linspace(-0.3, 2.0, 400) * law.damping_depth
    ramp.plot(1e3 * depth, 1e-3 * damping(law, depth), color=style.MULTIBODY)
    ramp.axvline(1e3 * law.damping_depth, color=style.MEASURED, linewidth=0.7, linestyle=":")
    ramp.annotate("$d$", (1e3 * law.damping_depth, 0.0), xytext=(3, 3), textcoords="offset points", color="#555555")
    ramp.axhline(1e-3 * law.contact_damping, color=style.MEASURED, linewidth=0.7, linestyle=":")
    ramp.annotate(
        "$c_{max}$", (-0.3e3 * law.damping_depth, 1e-3 * law.contact_damping), xytext=(2, -10),
        textcoords="offset points", color="#555555",
    )  # fmt: skip
    ramp.set(xlabel="penetration $p$ [mm]", ylabel="damping $c$ [N s/mm]")

    for name, colour in (("impact", style.MULTIBODY), ("restitution", style.ANALYTIC)):
        one = dataclasses.replace(law, normal_force=name)
        for rate, line in ((speed, "-"), (0.0, ":"), (-speed, "--")):
            label = name if rate > 0 else None
            force = normal_force(one, depth, np.full_like(depth, rate))
            whole.plot(1e3 * depth, 1e-3 * force, line, color=colour, label=label)
    whole.set(xlabel="penetration $p$ [mm]", ylabel="normal force $F_N$ [kN]")
    for line, what in (("-", f"in at {1e3 * speed:.2g} mm/s"), (":", "at rest"), ("--", "out at the same")):
        whole.plot([], [], line, color="#555555", label=what)
    whole.legend(loc="upper left")
    style.panel_labels((spring, ramp, whole))
    return figure


def caption_normal_force(given: Given) -> str:
    law = given.parameters.contact
    damping = (
        f"c_max = {1e-3 * law.contact_damping:g} N s/mm, complete at d = {1e3 * law.damping_depth:g} mm"
        if law.normal_force == "impact" else
        f"with a damping that returns {law.restitution:g} of an impact at {law.impact_speed:g} m/s")
    return (
        f"The law of the normal force as ground.yaml sets it: k_c = {law.contact_stiffness:g} N/mm^e, "
        f"e = {law.contact_exponent:g}, {damping}. The force never pulls."
    )


# Figure 5: the normal force at heel strike as each contact parameter is changed alone, over the constraint model's.

LANDING = 1
CHOSEN, LIMIT = style.MULTIBODY, style.SECOND
VALUES = (*style.SEQUENCE[:3], style.THIRD)  # from low to high; the last of the sequence is the chosen set's colour
CONSTRAINT = "#B8CFE8"  # the constraint model as a broad pale band behind the curves
#: Parameter, its symbol, the unit it is shown in and the factor to that unit.
ROWS = (
    ("contact_stiffness", "$k_c$", "$10^5$ N/mm$^e$", 1e-5),
    ("contact_exponent", "$e$", "1", 1.0),
    ("contact_damping", "$c_{max}$", "N s/mm", 1e-3),
    ("damping_depth", "$d$", "mm", 1e3),
)


def constraint_force(walk: Walk) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] from the first heel strike and the force (n, 2) [N] on the foot that lands there; NaN at the jump."""
    strike = float(walk.heel_strike_time[0])
    after = int(np.searchsorted(walk.time, strike, side="right"))
    time = np.insert(walk.time - strike, after, 0.0)
    return time, np.insert(walk.ground_reaction[:, LANDING], after, np.nan, axis=0)


def walked(study: Result) -> Result:
    """A study in which some set of contact parameters walks its step. Raises NoEvidence."""
    sizes = [study.default.hip_position, study.chosen.hip_position, *study.variations.hip_position]
    if not np.isfinite(sizes).any():
        raise NoEvidence(f"with no set of contact parameters the walker makes a step: {study.default.outcome}")
    return study


def draw_contact_parameters(given: Given) -> Figure:
    """A row for each parameter: the impact, and the force after it; below, the hip difference over all four."""
    study, scales = walked(given.contact_study), scales_of(given.parameters.biped, given.parameters.slope.gravity)
    milliseconds, weight = 1e3 * scales.time, scales.size("N")
    figure = plt.figure(figsize=(style.TWO_COLUMNS, 8.4))
    parts: Any = figure.subfigures(2, 1, height_ratios=(4.0, 1.2))
    upper, lower = parts
    axes = upper.subplots(4, 2, sharex="col", sharey=True, width_ratios=(1.25, 1.0))
    exact = constraint_force(given.analytic.walk)
    for (key, symbol, unit, factor), (impact, after) in zip(ROWS, axes, strict=True):
        for panel in (impact, after):
            panel.plot(1e3 * exact[0], exact[1][:, 1], color=CONSTRAINT, linewidth=4)
            panel.plot(1e3 * study.time, study.default_force[:, 1], color="black", label=_value(study, key, factor))
            for variation, colour in zip(study.variations.rows(key), VALUES):
                label = f"{factor * study.variations.value[variation]:g}"
                force = study.variations.force[variation, :, 1]
                panel.plot(1e3 * study.time, force, color=colour, linewidth=0.8, label=label)
            if not study.undecided:
                panel.plot(1e3 * study.time, study.chosen_force[:, 1], "--", color=CHOSEN, linewidth=1.2)
        after.legend(title=f"{symbol} [{unit}]", loc="center left", bbox_to_anchor=(1.0, 0.5))
        impact.set_ylabel("normal force [N]")
    impact.set(xlim=(-0.004 * milliseconds, 0.01 * milliseconds), xlabel="time from heel strike [ms]")
    after.set(xlim=(0, 0.2 * milliseconds), xlabel="time from heel strike [ms]")
    after.set_yscale("symlog", linthresh=weight)  # a foot that lifts off has no force, an impact that of a hundred
    after.set_ylim(bottom=-0.1 * weight)
    tens = 10.0 ** np.arange(np.ceil(np.log10(weight) - 0.3), np.log10(after.get_ylim()[1]))
    after.set_yticks([0.0, *tens], ["0", *(f"{ten:g}" for ten in tens)], minor=False)
    axes[0, 0].set_title("heel strike")
    axes[0, 1].set_title("after it")
    difference, key = lower.subplots(1, 2, width_ratios=(1.0, 1.3))
    _differences(difference, study)
    key.set_axis_off()
    key.legend(*difference.get_legend_handles_labels(), loc="center left")
    style.panel_labels((*axes.flat, difference))
    upper.legend(
        handles=[
            Line2D([], [], color=CONSTRAINT, linewidth=4, label="constraint model, rolling feet"),
            Line2D([], [], color="black", label="starting set"),
            Line2D([], [], color=CHOSEN, linestyle="--", label="chosen set"),
        ][: 2 if study.undecided else 3],
        loc="outside upper center",
        ncols=3,
    )
    return figure


def differences(study: Result, key: str) -> tuple[np.ndarray, np.ndarray]:
    """Values of a parameter, rising, the starting set's among them, and the largest hip differences [m] or NaN."""
    rows = study.variations.rows(key)
    values = np.array([getattr(study.default.law, key), *study.variations.value[rows]])
    found = np.array([study.default.hip_position.max(), *study.variations.hip_position[rows].max(axis=1)])
    order = np.argsort(values)
    return values[order], found[order]


def _differences(axes: Axes, study: Result) -> None:
    """Hip differences over each parameter's value; the chosen set's, and the limit that no contact set passes."""
    for (key, symbol, _, _), colour, mark in zip(ROWS, VALUES, "osD^", strict=True):
        values, found = differences(study, key)
        axes.plot(values / getattr(study.default.law, key), 1e3 * found, f"{mark}-", color=colour, markersize=3.5,
                  label=f"{symbol} alone")  # fmt: skip
    if not study.undecided:
        axes.axhline(1e3 * study.chosen.hip_position.max(), color=CHOSEN, linestyle="--", label="chosen set")
    far = 0.0 if study.limit is None else 1e3 * study.limit.hard.hip_position.max()
    if far > 0.0:  # rigid legs' own limit is rolling feet; a logarithmic axis has no zero
        axes.axhline(far, color=LIMIT, linestyle=":", label="rigid limit")
    axes.set(xscale="log", yscale="log", xlabel="value over that of the starting set [1]",
             ylabel="largest hip difference\nover a step [mm]")  # fmt: skip
    style.round_ticks(axes.yaxis)


def _value(study: Result, key: str, factor: float) -> str:
    return f"{factor * getattr(study.default.law, key):g}"


def caption_contact_parameters(given: Given) -> str:
    study = given.contact_study
    text = (
        "Each contact parameter changed alone. From the starting set the hip differs from the constraint model's by "
        f"{mm(study.default.hip_position.max())} over a step; "
    ) + (
        "no set was chosen" if study.candidates is None or study.undecided else
        f"with the set chosen from {len(study.candidates.outcome)} tried, by "
        f"{mm(study.chosen.hip_position.max())}"
    )
    if study.limit is None:
        return f"{text}."
    far = study.limit.hard.hip_position.max()
    if not far:
        return f"{text}. The rigid limit, Coulomb's transition instead of rolling feet, is the same walk as theirs."
    return (
        f"{text}. The rigid limit, Coulomb's transition instead of rolling feet, differs by {mm(far)}. Sets that "
        "differ less have errors that cancel out."
    )


# Figure 6: the friction law, the friction force it gives, and what its two transition velocities do.

VELOCITIES = (
    ("stiction_velocity", "$v_s$", "o-", style.MULTIBODY),
    ("friction_velocity", "$v_d$", "s--", style.SECOND),
)


def draw_friction(given: Given) -> Figure:
    """Law, force over the stance, and sensitivity of the hip's motion and of the creep."""
    study = walked(given.contact_study)
    figure, ((law, force), (hip, creep)) = plt.subplots(2, 2, figsize=(style.TWO_COLUMNS, 4.2))
    default, chosen = study.default.law, study.chosen.law
    sets = [(study.default, study.default_force, style.TWIN, "starting set")]
    sets += [(study.chosen, study.chosen_force, style.MULTIBODY, "chosen set")] * (not study.undecided)
    slip = np.linspace(-1.5, 1.5, 3001) * default.friction_velocity
    for one, _, colour, label in sets:
        law.plot(slip, friction_coefficient(one.law, slip), color=colour, label=label, linewidth=1.0)
    coulomb = dataclasses.replace(chosen, friction="coulomb")
    law.plot(slip, friction_coefficient(coulomb, slip), "--", color=style.ANALYTIC, label="by Coulomb's law",
             linewidth=1.0)  # fmt: skip
    most = max(one.law.static_friction for one, *_ in sets)
    law.set(ylim=(-1.25 / 1.1 * most, 2.0 / 1.1 * most), xlabel="slip velocity $v$ [m/s]",
            ylabel=r"friction coefficient $\mu$ [1]")  # fmt: skip
    law.legend(loc="upper left")

    exact = constraint_force(given.analytic.walk)
    shown = exact[0] <= study.time[-1]
    time = scales_of(given.parameters.biped, given.parameters.slope.gravity).time
    force.plot(exact[0][shown], exact[1][shown, 0], color=CONSTRAINT, linewidth=4, label="constraint model")
    for _, curve, colour, label in sets:
        force.plot(study.time, curve[:, 0], color=colour, linewidth=0.9, label=label)
    force.set_xlim(-0.01, study.time[-1])
    quiet = exact[1][shown & (exact[0] > OVER * time), 0]
    reach = max(np.ptp(quiet), 0.1 * np.abs(quiet).max()) or 1.0
    force.set(
        ylim=(quiet.min() - 0.5 * reach, quiet.max() + 0.5 * reach),
        xlabel="time from heel strike [s]",
        ylabel="friction force $F_T$ [N]",
    )
    force.legend(loc="lower right")

    for key, symbol, line, colour in VELOCITIES:
        values, found = differences(study, key)
        hip.loglog(values, 1e3 * found, line, color=colour, markersize=3, label=f"{symbol} changed alone")
        rows = study.variations.rows(key)
        speeds = np.array([study.default.creep_velocity, *study.variations.creep_velocity[rows]])
        order = np.argsort([getattr(default, key), *study.variations.value[rows]])
        creep.loglog(values, 1e3 * speeds[order], line, color=colour, markersize=3, label=f"{symbol} changed alone")
    for panel, size in ((hip, study.chosen.hip_position.max()), (creep, study.chosen.creep_velocity)):
        if not study.undecided:
            panel.plot(chosen.stiction_velocity, 1e3 * size, "*", color=style.TWIN, markersize=9, label="chosen set")
        panel.set_xlabel("transition velocity [m/s]")
        panel.legend(loc="lower right")
        style.round_ticks(panel.yaxis)
    hip.set_ylabel("largest hip difference [mm]")
    creep.set_ylabel("creep in stance [mm/s]")
    style.panel_labels((law, force, hip, creep))
    return figure


def caption_friction(given: Given) -> str:
    study = given.contact_study
    chosen = f" and {mm(study.chosen.creep_velocity)}/s with the chosen set" * (not study.undecided)
    return (
        "Below the stiction velocity a loaded foot slides slowly (creeps): at "
        f"{mm(study.default.creep_velocity)}/s with the starting set{chosen}."
    )


FIGURES = {
    "figure_04_normal_force": Entry(
        "Figure 4: law of the normal force", 4, (), draw_normal_force, caption_normal_force
    ),
    "figure_05_contact_parameters": Entry(
        "Figure 5: contact parameters",
        5,
        ("contact_study", "analytic"),
        draw_contact_parameters,
        caption_contact_parameters,
        claims=("contact_set", "contact_set_figure_8"),
    ),
    "figure_06_friction": Entry(
        "Figure 6: friction",
        6,
        ("contact_study", "analytic"),
        draw_friction,
        caption_friction,
        claims=("friction_velocities",),
    ),
}
