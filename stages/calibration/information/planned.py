"""A run that is planned: what its sensors would show of the design's own gait, as equations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stages.analytic.derivatives.numbers import sensitive_names
from stages.analytic.errors import NoGait
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.walker import Walker
from stages.calibration.estimation.run_fit import Equations, Model, run_equations
from stages.calibration.observation.measured_run import SIDES, MeasuredRun, Sampling, layout_of, mid_stance, usable
from stages.calibration.parameters import Parameters
from stages.imu.trial.sensor import filter_delay

SLOPE = "ground.slope_deg"
#: Looked for in each run by itself: the ramp is set again, and legs that are put on again differ by another tenth of a
#: millimetre, which a walk shows.
EACH_RUNS = (SLOPE, "biped.other_leg_length")
#: Known well enough everywhere.
KNOWN_EVERYWHERE = ("ground.gravity",)
#: Tolerance of the gait that a run is planned on.
FINE = 1e-9


@dataclass(frozen=True)
class Plan:
    """How a run would be made: its design, the priors of a run and its sensors, the foot sensor's `place` [m] above the
    foot's mass centre, and its length in steps."""

    design: DesignPoint
    priors: Mapping[str, float]
    steps: int
    place: float = 0.0


def plan_of(parameters: Parameters) -> Plan:
    """The run that the parameters describe."""
    design = DesignPoint(parameters.biped, parameters.slope)
    return Plan(design, parameters.priors, parameters.settings.planned_steps)


def free_names(design: DesignPoint) -> tuple[str, ...]:
    """The parameters of a design that a calibration looks for."""
    return tuple(name for name in sensitive_names(design) if name not in KNOWN_EVERYWHERE)


def planned_equations(plan: Plan, parameters: Parameters) -> tuple[Equations, Model]:
    """What one planned run would say. Raises NoGait where the design does not walk."""
    design, settings, sensor = plan.design, parameters.settings, parameters.sensor
    walker, point = find_gait(design.biped, design.slope, FINE, None)
    if len(point.steps) > 1:
        raise NoGait("the gait takes two steps to repeat")
    begin = mid_stance(walker, point.z, FINE)
    layout = layout_of(walker, begin, plan.priors)
    first = begin.time * walker.time + settings.settling_s
    strikes = point.steps[0].period * walker.time * np.arange(plan.steps + 1)
    times = np.arange(0.0, float(strikes[-1]), 1.0 / sensor.rate_hz)
    times = times[times >= first]
    mask = usable(times, strikes, first, settings.before_strike_s, settings.after_strike_s)
    model = Model(tuple(name for name in free_names(design) if name != SLOPE), (SLOPE,), layout, parameters.noise,
                  settings.tolerance)
    run = MeasuredRun(
        name="planned",
        sampling=Sampling(times, times, filter_delay(sensor.bandwidth_hz), sensor.bandwidth_hz, 1, plan.place),
        samples=dict.fromkeys(SIDES, np.zeros((len(times), 3))), used=dict.fromkeys(SIDES, mask), strikes=strikes,
        own={})  # fmt: skip
    return run_equations(design, np.array([design.value(SLOPE)]), layout.middle, run, model), model


def first_model(
    design: DesignPoint, names: Sequence[str], parameters: Parameters, gait: tuple[Walker, FixedPoint] | None = None
) -> Model:
    """The model in which the parameters `names` of a design are looked for, some of them for each run by itself.

    Raises NoGait where the design's `gait` has to be looked for and there is none.
    """
    walker, point = gait or find_gait(design.biped, design.slope, FINE, None)
    layout = layout_of(walker, mid_stance(walker, point.z, FINE), parameters.priors)
    own = (SLOPE, *(name for name in names if name in EACH_RUNS and name != SLOPE))
    return Model(tuple(name for name in names if name not in own), own, layout, parameters.noise,
                 parameters.settings.tolerance, parameters.settings.robust_sigmas)
