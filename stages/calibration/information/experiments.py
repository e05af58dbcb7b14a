"""What further measurement would tell more: each one's standard deviations beside those of the planned runs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.known import TOTAL_MASS, Known
from stages.calibration.information.identifiability import Identifiability, identifiability
from stages.calibration.information.plan import SLOPE, Plan, planned_equations, with_slope
from stages.calibration.parameters import Parameters

#: What the suggested measurements reach: scale and caliper relative, clock against the one believed, ramp and hip mass.
WEIGHED, CALIPER_M, CLOCK, STEEPER_DEG, HEAVIER = 1e-3, 1e-4, 0.1, 1.0, 1.5


@dataclass(frozen=True)
class Experiment:
    """A measurement in words, and the standard deviations (n,) that the same runs have with it; NaN where there is no
    gait to plan with, and `why`."""

    what: str
    sd: Vector
    why: str = ""


def weighed(plan: Plan, share: float = WEIGHED) -> Known:
    """The robot on a scale that is right to a share."""
    mass = plan.design.biped.total_mass
    return Known(TOTAL_MASS, mass, share * mass, "planned")


def experiments(plan: Plan, known: tuple[Known, ...], runs: int, parameters: Parameters) -> list[Experiment]:
    """What each suggested measurement would make of `runs` runs and the `known` values."""
    beliefs, design = plan.beliefs, plan.design
    length = Known("biped.leg_length", design.biped.leg_length, CALIPER_M, "planned")
    heavier = design.with_value("biped.hip_mass", HEAVIER * design.biped.hip_mass)
    higher = 0.5 * (design.biped.leg_length - design.biped.foot_com)
    steeper = design.value(SLOPE) + STEEPER_DEG
    asked: list[tuple[str, Plan, tuple[Known, ...], int]] = [
        (f"ten times the runs ({10 * runs})", plan, known, 10 * runs),
        (f"leg_length measured to {1e3 * CALIPER_M:g} mm", plan, (*known, length), runs),
        (f"clock known to {CLOCK * beliefs.clock:g} instead of {beliefs.clock:g}",
         replace(plan, beliefs=replace(beliefs, clock=CLOCK * beliefs.clock)), known, runs),
        (f"a ramp of {steeper:g} deg", with_slope(plan, steeper), known, runs),
        (f"{100 * (HEAVIER - 1):.0f} % more mass at the hip", replace(plan, design=heavier), known, runs),
        (f"foot sensor {1e3 * higher:.0f} mm higher on the leg", replace(plan, place=higher), known, runs),
        ("walks of twice the steps", replace(plan, steps=2 * plan.steps), known, runs),
    ]
    share = min((one.sd / one.value for one in known if one.name == TOTAL_MASS), default=10 * WEIGHED) / 10
    asked.insert(0, (f"the robot weighed to {100 * share:.2g} %", plan, (*known, weighed(plan, share)), runs))
    return [_experiment(*one, parameters) for one in asked]


def _experiment(what: str, plan: Plan, known: tuple[Known, ...], runs: int, parameters: Parameters) -> Experiment:
    try:
        equations, model = planned_equations(plan, parameters)
    except (NoGait, StepFailed) as reason:
        return Experiment(what, np.array([]), str(reason))
    return Experiment(what, identifiability(plan.design, equations, model, known, runs).sd)


def gains(experiment: Experiment, before: Identifiability) -> Vector:
    """By how much standard deviations shrink, (n,): 2 is half; infinite for one that is seen now and was not."""
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.asarray(before.sd / experiment.sd)
    return np.where(np.isinf(before.sd) & np.isinf(experiment.sd), 1.0, ratio)
