"""The study's own calibration on MuJoCo's data: the robots of `mujoco_sysid`, walked by MuJoCo, fitted by this model.

    pip install "mujoco[sysid]"
    python -m benchmarks.mujoco_calibration [--trials 10] [--page]

The same exports, the same drawn factors of foot masses, springs and dampers. Sensors have the low pass and the noise of
campaign.yaml; heel strikes are the first contacts with each set of blocks, off by 2 ms as the ingest's are. The fit
begins with the bill of parts and knows the weighed mass; start, ramp, sensors and all other parameters are looked for.
"""

from __future__ import annotations

import argparse
import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import mujoco
import numpy as np

from benchmarks.marked import put
from benchmarks.mujoco_sysid import GROUND, Robots
from pipeline.cache import artefact
from pipeline.study import Study
from stages.analytic.errors import StepFailed
from stages.calibration.estimation.first_guess import guessed_mid_stance
from stages.calibration.estimation.known import TOTAL_MASS, Known
from stages.calibration.information.plan import SLOPE, first_model
from stages.calibration.observation.measured_run import MeasuredRun, usable
from stages.calibration.observation.prediction import Sampling
from stages.calibration.observation.unknowns import SIDES
from stages.calibration.parameters import Parameters
from stages.calibration.reports.known_misses import judged
from stages.calibration.result import HALF_WIDTH, Failed, Result
from stages.calibration.study.blind_fit import fitted_run
from stages.calibration.study.drawing import drawn_design, looked_for
from stages.calibration.study.recorded import Recorded, first_steps
from stages.campaign.virtual_sensor import low_pass
from stages.imu.trial.places import FORWARD, LATERAL, UP
from stages.imu.trial.sensor import filter_delay

ROOT = Path(__file__).resolve().parent.parent
#: Standard deviations of detected heel strikes [s] and, relative, of the scale.
STRIKE_SD, SCALE = 0.002, 1e-3
#: No walk over the ramp lasts longer [s].
LONGEST = 8.0


@dataclass(frozen=True)
class Walked:
    """A walk by MuJoCo: times (n,) [s], by side the samples (n, 3) forward, up [m/s^2], rate [rad/s], first contact
    with each set of blocks (s,) [s]."""

    time: np.ndarray
    felt: dict[str, np.ndarray]
    strikes: np.ndarray


def walk(model: Any, sets: int) -> Walked:
    """From the keyframe to the first contact with the last set. Raises StepFailed where the robot falls."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    high = data.qpos[1]
    of = np.array([int(name.split()[1]) if (name := model.geom(geom).name).startswith("block") else 0
                   for geom in range(model.ngeom)])  # fmt: skip
    names = [model.sensor(number).name for number in range(model.nsensor)]
    first: dict[int, float] = {}
    times, rows = [], []
    while sets not in first:
        mujoco.mj_step(model, data)
        if data.time > LONGEST or data.qpos[1] < 0.5 * high:
            raise StepFailed(f"MuJoCo's walk ends after {len(first)} sets of blocks")
        if data.ncon:
            first.setdefault(int(max(of[pair].max() for pair in data.contact.geom)), data.time)
        times.append(data.time)
        rows.append(data.sensordata.copy())
    shown = dict(zip(names, np.array(rows).reshape(len(rows), -1, 3).transpose(1, 0, 2), strict=True))
    felt = {}
    for side in SIDES:
        force, rate = (next(value for name, value in shown.items() if side in name and what in name)
                       for what in ("specific force", "angular velocity"))
        felt[side] = np.column_stack([force[:, FORWARD], force[:, UP], rate[:, LATERAL]])
    return Walked(np.array(times), felt, np.array([first[number] for number in sorted(first) if number > 1]))


def measured(walked: Walked, parameters: Parameters, mid_stance_of: Any, rng: np.random.Generator) -> MeasuredRun:
    """What sensors show of a walk from its first mid-stance after the first heel strike on."""
    settings, sensor = parameters.settings, parameters.sensor
    strikes = walked.strikes - walked.strikes[0]
    strikes[1:] += STRIKE_SD * rng.normal(size=len(strikes) - 1)
    first_leg = 1  # the outer pair lands on the second set
    first = mid_stance_of(strikes, first_leg) + settings.settling_s
    since = walked.time - walked.strikes[0]
    times = np.arange(first, strikes[-1], 1.0 / sensor.rate_hz)
    mask = usable(times, strikes, first, settings.before_strike_s, settings.after_strike_s)
    samples = {}
    for side in SIDES:
        smooth = low_pass(walked.felt[side], 1.0 / GROUND.step, sensor.bandwidth_hz)
        shown = np.column_stack([np.interp(times, since, column) for column in smooth.T])
        samples[side] = shown + np.asarray(parameters.noise) * rng.normal(size=shown.shape)
    sampling = Sampling(times, times, filter_delay(sensor.bandwidth_hz), sensor.bandwidth_hz, first_leg,
                        below_hip=parameters.limits.lever_arm)
    used = {side: np.repeat(mask[:, None], 3, axis=1) for side in SIDES}
    return MeasuredRun("MuJoCo's", sampling, samples, used, strikes,
                       {SLOPE: (parameters.slope.slope_deg, settings.slope_reading_sd_deg)})


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--seed", type=int, default=7000)
    parser.add_argument("--page", action="store_true", help="put the table into docs/calibration.md")
    asked = parser.parse_args()
    every = Study(ROOT, ROOT / "params", ROOT / "results", ()).parameters(["twin", "calibration"])
    parameters: Parameters = every["calibration"]
    robots = Robots(every["twin"], asked.seed)
    design = drawn_design(parameters)
    model = first_model(design, looked_for(design), parameters)
    drawn = np.array([design.value(name) for name in model.shared])
    mid_stance_of = guessed_mid_stance(design, model.layout)
    stored = ROOT / "results/calibration.h5"
    told = (artefact.load(stored, Result), stored.name) if stored.exists() else (None, f"{stored.name} is not there")
    errors, held, other, sigmas, spent = [], [], [], [], []
    reasons = []
    for trial in range(asked.trials):
        factors = dict(zip(("biped.foot_mass", "biped.stiffness", "biped.damping"), robots.truth(trial), strict=True))
        truth = drawn * [factors.get(name, 1.0) for name in model.shared]
        rng = np.random.default_rng([asked.seed, trial, 1])
        try:
            walked = walk(robots.model(trial), robots.exported.ramp.sets)
        except StepFailed as reason:
            reasons.append(f"{trial}: {reason}")
            continue
        there = design.with_values(dict(zip(model.shared, truth.tolist(), strict=True)))
        mass = there.biped.total_mass * (1 + SCALE * rng.normal())
        known = (Known(TOTAL_MASS, mass, SCALE * mass, "weighed"),)
        run = first_steps(measured(walked, parameters, mid_stance_of, rng), parameters.settings.fitted_steps)
        begun = time.process_time()
        fit = fitted_run(design, Recorded("lab", run, known), model)
        spent.append(time.process_time() - begun)
        if isinstance(fit, Failed) or not fit.converged:
            reasons.append(f"{trial}: {fit.why}")
            continue
        sd = np.sqrt(np.diag(fit.covariance))
        known_misses = judged(model.shared, fit.design, sd, known, design, model.layout.pull(fit.unknowns), told)
        errors.append(fit.design / truth - 1)
        held.append(np.abs(fit.design - truth) <= HALF_WIDTH * sd)
        other.append(np.abs(known_misses.values - truth) <= HALF_WIDTH * known_misses.sd)
        sigmas.append(fit.sigmas)
        print(f"trial {trial}: {spent[-1]:.1f} s, {fit.sigmas:.2f} noises, errors % "
              f"{np.round(100 * errors[-1], 2).tolist()}", flush=True)
    count = len(errors)
    lines = ["| parameter | error, mean, % | scatter, % | noise and residuals hold | with the Exudyn twin's misses |",
             "|---|---|---|---|---|"]
    for row, name in enumerate(model.shared):
        off = 100 * np.array([one[row] for one in errors])
        lines.append(f"| {name.partition('.')[2]} | {off.mean():+.2f} | {off.std():.2f} | "
                     f"{sum(one[row] for one in held)} of {count} | {sum(one[row] for one in other)} of {count} |")
    lines += ["", f"{count} of {asked.trials} runs of {parameters.settings.fitted_steps} steps fitted"
              + (f" ({'; '.join(reasons)})" if reasons else "") + f", residuals {min(sigmas):.2f} to {max(sigmas):.2f} "
              f"times the noise, {np.median(spent):.1f} s of processor time a fit (median)."]
    print("\n".join(lines))
    if asked.page:
        put(ROOT / "docs/calibration.md", "mujoco ours", "\n".join(lines))


if __name__ == "__main__":
    main()
