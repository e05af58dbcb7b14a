"""Blind campaigns fitted and held against their truth: which intervals hold it, and how wide they are."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import poincare_map
from stages.analytic.model.walker import Vector
from stages.biped.processes import Progress, each_in_a_process, ignore
from stages.calibration.estimation.campaign import fit_campaign
from stages.calibration.estimation.least_squares import TOTAL_MASS, Known, information_of
from stages.calibration.estimation.run_fit import Model, run_equations
from stages.calibration.information.identifiability import SLOPE, first_model, free_names
from stages.calibration.observation.measured_run import SIDES, MeasuredRun, Sampling, layout_of, usable
from stages.calibration.observation.prediction import predict
from stages.calibration.parameters import Parameters
from stages.calibration.recordings import mid_stance_of
from stages.calibration.result import HALF_WIDTH
from stages.imu.parameters import filter_delay

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
    """A campaign of `runs` runs. Raises NoGait where no sampled robot walks."""
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
    raise NoGait("no sampled robot walks")


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
    unknowns = np.where(np.isfinite(layout.prior), layout.prior, 0.0) * rng.normal(size=len(layout.names))
    pushed = point.z * (1 + SPREAD_OF_START * rng.normal(size=point.z.size))
    pushed[1:3] = point.z[1:3]  # a hand moves angles and speeds; legs are as long as their springs have them
    truth = layout_of(walker, poincare_map(walker, pushed, FINER).z, FINER, parameters.priors).middle
    unknowns[: layout.free] = truth[: layout.free]
    unknowns[layout.place("mid_stance")] = truth[layout.place("mid_stance")] - late_by * rng.normal()
    period = point.steps[0].period * walker.time
    low_pass = (dict.fromkeys(SIDES, filter_delay(sensor.bandwidth_hz)), dict.fromkeys(SIDES, sensor.bandwidth_hz))
    first_leg, shift = int(rng.integers(2)), rng.uniform(0, 0.5 / sensor.rate_hz)
    end = np.array([(settings.planned_steps - 0.2) * period])
    walked = predict(there, (), unknowns, layout, Sampling(end, end, *low_pass, first_leg), FINER)
    later = walked.strikes[walked.strikes[:, 0] < end, 0]
    seen = np.concatenate([[0.0], later + late_by * rng.normal(size=len(later))])
    begun = mid_stance_of(drawing, layout, seen, first_leg) + settings.settling_s
    times = np.arange(begun, float(end[0]), 1.0 / sensor.rate_hz)
    sampling = Sampling(times, times + shift, *low_pass, first_leg)
    found = predict(there, (), unknowns, layout, sampling, FINER)
    noise = np.asarray(model.noise)
    shown = {side: found.samples[side][:, :, 0] for side in SIDES}
    samples = {side: shown[side] + noise * rng.normal(size=shown[side].shape) for side in SIDES}
    used = {side: usable(sampling.of(side), seen, begun, settings.before_strike_s, settings.after_strike_s)
            for side in SIDES}  # fmt: skip
    reading = slope + READING_DEG * rng.normal()
    run = MeasuredRun(f"blind {number + 1}", sampling, samples, used, seen, {SLOPE: (reading, READING_DEG)})
    return run, slope, unknowns


def scored(seed: int, runs: int, parameters: Parameters) -> dict[str, Any]:
    """Draw a campaign, fit it without a look at the truth, and compare, as JSON has it: its seed, whether it converged,
    or `why` not; for each of `names` the truth, the estimate, its standard deviation and the smallest one there can be
    (n,), the `bound` by the information at the truth; chi2 per reading; walks.
    """
    campaign = draw(seed, runs, parameters)
    drawing, model = model_of(parameters)
    names = model.shared
    row = {"seed": seed, "names": list(names), "truth": [campaign.design.value(name) for name in names]}
    try:
        fit = fit_campaign(drawing, campaign.runs, model, campaign.known)
    except StepFailed as reason:
        return {**row, "converged": False, "why": str(reason)}
    information = information_of(campaign.known, names)
    for run, slope, unknowns in zip(campaign.runs, campaign.slopes, campaign.unknowns, strict=True):
        at_truth = run_equations(campaign.design, np.array([slope]), unknowns, run, model)
        information = information + at_truth.eliminated(len(names))[0]
    bound = np.sqrt(np.diag(np.linalg.inv(information)))
    return {**row, "converged": fit.converged, "why": fit.why, "estimate": fit.design.tolist(),
            "sd": np.sqrt(np.diag(fit.covariance)).tolist(), "bound": bound.tolist(), "chi2": fit.chi2 / fit.count,
            "evaluations": fit.evaluations}


def score(
    seeds: Sequence[int], runs: int, parameters: Parameters, progress: Progress = ignore
) -> Iterator[dict[str, Any]]:
    """Many campaigns, on all cores, as they get ready."""
    for done, (_, one) in enumerate(
            each_in_a_process(partial(scored, runs=runs, parameters=parameters), list(seeds)), 1):
        progress(done / len(seeds), f"blind campaign {done} of {len(seeds)}")
        yield one


def summary(all_scored: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Coverage of each parameter and together, median width over the bound, and what did not converge."""
    done = [one for one in all_scored if one["converged"]]
    truth, estimate, sd, bound = (np.array([one[key] for one in done]) for key in ("truth", "estimate", "sd", "bound"))
    errors = (estimate - truth) / sd
    holds, widths, names = np.abs(errors) <= HALF_WIDTH, np.median(sd / bound, axis=0), all_scored[0]["names"]
    return {
        "campaigns": len(all_scored),
        "not_converged": {one["seed"]: one["why"] for one in all_scored if not one["converged"]},
        "coverage": dict(zip(names, holds.mean(axis=0).tolist(), strict=True)),
        "coverage_together": float(holds.mean()),
        "median_width_over_bound": dict(zip(names, widths.tolist(), strict=True)),
        "mean_error_in_sd": dict(zip(names, errors.mean(axis=0).tolist(), strict=True)),
        "median_sd_share": dict(zip(names, np.median(sd / np.abs(truth), axis=0).tolist(), strict=True)),
        "chi2": [min(one["chi2"] for one in done), max(one["chi2"] for one in done)],
        "median_walks": float(np.median([one["evaluations"] for one in done])),
    }
