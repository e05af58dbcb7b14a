"""A robot, its runs and its sensors, drawn at random and walked by the constraint model: what a fit is tried on.

Nobody who fits may look at what was drawn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import poincare_map
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.equations import Model
from stages.calibration.estimation.first_guess import guessed_mid_stance
from stages.calibration.estimation.known import TOTAL_MASS, Known
from stages.calibration.information.plan import SLOPE, first_model, free_names
from stages.calibration.observation.measured_run import MeasuredRun, usable
from stages.calibration.observation.prediction import Sampling, predict
from stages.calibration.observation.unknowns import SIDES, layout_of, mid_stance
from stages.calibration.parameters import Parameters

#: Spread of each parameter about the drawing's, relative; of the inertia; of a run's start about its gait; of a ramp
#: that is set again for each run and of its reading [deg]; error of the scale, relative; of detected strikes, in
#: sampling periods.
SPREAD, SPREAD_OF_INERTIA, SPREAD_OF_START, RAMP_DEG, READING_DEG, SCALE = 0.03, 0.5, 0.02, 0.05, 0.05, 1e-3
STRIKE_ERROR = 0.2
FINER = 1e-9
MOST_DRAWS = 50


@dataclass(frozen=True)
class Drawn:
    """A campaign: its runs and what a lab knows; and the truth, `design` and the `slopes` [deg] and `unknowns` of the
    runs, for whoever judges."""

    runs: tuple[MeasuredRun, ...]
    known: tuple[Known, ...]
    design: DesignPoint
    slopes: Vector
    unknowns: tuple[Vector, ...]


def model_of(parameters: Parameters) -> tuple[DesignPoint, Model]:
    """What a lab starts from: the drawing's design, and the model that is fitted. Raises NoGait."""
    design = DesignPoint(parameters.biped, parameters.slope)
    return design, first_model(design, free_names(design), parameters)


def drawn_robot(design: DesignPoint, names: tuple[str, ...], rng: np.random.Generator) -> DesignPoint:
    """A robot built by the drawing `design`, not quite."""
    spread = {name: SPREAD_OF_INERTIA if name.endswith("leg_inertia") else SPREAD for name in names}
    return design.with_values(
        {name: design.value(name) * max(0.05, 1.0 + spread[name] * rng.normal()) for name in names})


def draw(seed: int, runs: int, parameters: Parameters) -> Drawn:
    """A campaign of `runs` runs. Raises NoGait where no drawn robot walks."""
    rng = np.random.default_rng([seed, runs])
    drawing, model = model_of(parameters)
    for _ in range(MOST_DRAWS):
        robot = drawn_robot(drawing, model.shared, rng)
        try:
            find_gait(robot.biped, robot.slope, 1e-9, None)
            made = [_run(robot, drawing, model, parameters, number, rng) for number in range(runs)]
        except (NoGait, StepFailed):
            continue
        mass = robot.biped.total_mass
        known = (Known(TOTAL_MASS, mass * (1 + SCALE * rng.normal()), SCALE * mass, "scale"),)
        slopes = np.array([slope for _, slope, _ in made])
        return Drawn(tuple(run for run, _, _ in made), known, robot, slopes, tuple(u for _, _, u in made))
    raise NoGait("no drawn robot walks")


def _run(
    robot: DesignPoint, drawing: DesignPoint, model: Model, parameters: Parameters, number: int,
    rng: np.random.Generator,
) -> tuple[MeasuredRun, float, Vector]:
    """One run, its true slope and its true unknowns. Raises StepFailed, NoGait."""
    settings, sensor, layout = parameters.settings, parameters.sensor, model.layout
    late_by = STRIKE_ERROR / sensor.rate_hz
    slope = robot.value(SLOPE) + RAMP_DEG * rng.normal()
    there = robot.with_value(SLOPE, slope)
    walker, point = find_gait(there.biped, there.slope, 1e-9, None)
    unknowns = np.where(np.isfinite(layout.believed), layout.believed, 0.0) * rng.normal(size=len(layout.names))
    pushed = point.z * (1 + SPREAD_OF_START * rng.normal(size=point.z.size))
    pushed[1:3] = point.z[1:3]  # a hand moves angles and speeds; legs are as long as their springs have them
    begin = mid_stance(walker, poincare_map(walker, pushed, FINER).z, FINER)
    truth = layout_of(walker, begin, parameters.beliefs).middle
    unknowns[: layout.free] = truth[: layout.free]
    unknowns[layout.place("mid_stance")] = truth[layout.place("mid_stance")] - late_by * rng.normal()
    period = point.steps[0].period * walker.time
    late = float(np.sqrt(2.0) / (2.0 * np.pi * sensor.bandwidth_hz))
    first_leg, shift = int(rng.integers(2)), rng.uniform(0, 0.5 / sensor.rate_hz)
    end = np.array([(settings.planned_steps - 0.2) * period])
    walked = predict(there, (), unknowns, layout, Sampling(end, end, late, sensor.bandwidth_hz, first_leg), FINER)
    later = walked.strikes[walked.strikes < end]
    seen = np.concatenate([[0.0], later + late_by * rng.normal(size=len(later))])
    begun = guessed_mid_stance(drawing, layout)(seen, first_leg) + settings.settling_s
    times = np.arange(begun, float(end[0]), 1.0 / sensor.rate_hz)
    sampling = Sampling(times, times + shift, late, sensor.bandwidth_hz, first_leg)
    found = predict(there, (), unknowns, layout, sampling, FINER)
    noise = np.asarray(model.noise)
    samples = {side: found.samples[side] + noise * rng.normal(size=found.samples[side].shape) for side in SIDES}
    used = {}
    for side in SIDES:
        mask = usable(getattr(sampling, side), seen, begun, settings.before_strike_s, settings.after_strike_s)
        used[side] = np.repeat(mask[:, None], 3, axis=1)
    reading = slope + READING_DEG * rng.normal()
    run = MeasuredRun(f"blind {number + 1}", sampling, samples, used, seen, {SLOPE: (reading, READING_DEG)})
    return run, slope, unknowns
