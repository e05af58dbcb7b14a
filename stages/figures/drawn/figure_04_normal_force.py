"""Figure 4: the normal force laws: hardening spring, damping ramp, and the whole force when loading and unloading."""

from __future__ import annotations

import dataclasses

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.drawing import style
from stages.figures.entry import Entry, Given
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import normal_force

EXPONENTS = (1.0, 1.5, 2.2, 3.0)
RATE = 0.02  # m/s, so slow that the ground still pushes when it lets the foot out


def spring_force(law: ContactLaw, exponent: float, penetration: np.ndarray) -> np.ndarray:
    """Force [N] at rest, of the law with another exponent and the same stiffness in N/mm^e."""
    return np.asarray(normal_force(dataclasses.replace(law, contact_exponent=exponent), penetration, 0.0))


def damping(law: ContactLaw, penetration: np.ndarray) -> np.ndarray:
    """Damping coefficient [N s/m] of the impact law at a penetration [m]: its force at 1 m/s less that at rest."""
    impact = dataclasses.replace(law, normal_force="impact")
    return np.asarray(normal_force(impact, penetration, 1.0) - normal_force(impact, penetration, 0.0))


def draw(given: Given) -> Figure:
    """The laws with the values of ground.yaml."""
    law = given.parameters.contact
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
    ramp.annotate(
        "$d$", (1e3 * law.damping_depth, 0.0), xytext=(3, 3), textcoords="offset points", color="#555555"
    )
    ramp.axhline(1e-3 * law.contact_damping, color=style.MEASURED, linewidth=0.7, linestyle=":")
    ramp.annotate(
        "$c_{max}$", (-0.3e3 * law.damping_depth, 1e-3 * law.contact_damping), xytext=(2, -10),
        textcoords="offset points", color="#555555",
    )  # fmt: skip
    ramp.set(xlabel="penetration $p$ [mm]", ylabel="damping $c$ [N s/mm]")

    for name, colour in (("impact", style.MULTIBODY), ("restitution", style.ANALYTIC)):
        one = dataclasses.replace(law, normal_force=name)
        for rate, line in ((RATE, "-"), (0.0, ":"), (-RATE, "--")):
            label = name if rate > 0 else None
            force = normal_force(one, depth, np.full_like(depth, rate))
            whole.plot(1e3 * depth, 1e-3 * force, line, color=colour, label=label)
    whole.set(xlabel="penetration $p$ [mm]", ylabel="normal force $F_N$ [kN]")
    for line, what in (("-", f"in at {1e3 * RATE:g} mm/s"), (":", "at rest"), ("--", "out at the same")):
        whole.plot([], [], line, color="#555555", label=what)
    whole.legend(loc="upper left")
    style.panel_labels((spring, ramp, whole))
    return figure


def caption(given: Given) -> str:
    law = given.parameters.contact
    return (
        f"The law of the normal force as ground.yaml sets it: k_c = {law.contact_stiffness:g} N/mm^e, "
        f"e = {law.contact_exponent:g}, c_max = {1e-3 * law.contact_damping:g} N s/mm, complete at "
        f"d = {1e3 * law.damping_depth:g} mm. The force never pulls."
    )


FIGURE = Entry("Figure 4: law of the normal force", 4, (), draw, caption)
