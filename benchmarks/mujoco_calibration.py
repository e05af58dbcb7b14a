"""The study's own calibration on MuJoCo's data: the robots of `mujoco_sysid`, walked by MuJoCo, fitted by this model.

    pip install "mujoco[sysid]"
    python -m benchmarks.mujoco_calibration [--trials 10] [--page]
    python -m benchmarks.mujoco_calibration --grounds [--trials 2] [--page]

The same exports, the same drawn factors of foot masses, springs and dampers. Sensors have the low pass and the noise of
campaign.yaml; heel strikes are the first contacts with each set of blocks, off by 2 ms as the ingest's are. The fit
begins with the bill of parts and knows the weighed mass; start, ramp, sensors and all other parameters are looked for.
"""

import argparse
import os
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import mujoco
import numpy as np

from benchmarks.marked import put
from benchmarks.mujoco_sysid import Robots
from pipeline.cache import artefact
from pipeline.study import Study
from stages.analytic.errors import StepFailed
from stages.calibration.estimation.least_squares import TOTAL_MASS, Known
from stages.calibration.information.identifiability import SLOPE, first_model
from stages.calibration.intervals.model_error import judged
from stages.calibration.observation.measured_run import SIDES, MeasuredRun, Sampling, usable
from stages.calibration.parameters import Parameters
from stages.calibration.recordings import drawn_design, first_steps, looked_for, mid_stance_of
from stages.calibration.result import HALF_WIDTH, Failed, FittedRun, Result
from stages.calibration.run import fitted_run
from stages.campaign.virtual_sensor import low_pass
from stages.imu.parameters import filter_delay
from stages.imu.trial.body import FORWARD, LATERAL, UP
from stages.twin.exports import mjcf

ROOT = Path(__file__).resolve().parent.parent
#: Standard deviations of detected heel strikes [s] and, relative, of the scale.
STRIKE_SD, SCALE = 0.002, 1e-3
#: MuJoCo's ground: time constant and the solver's step [s], its default first.
GROUNDS = ((0.02, 1e-3), (0.004, 5e-4), (0.002, 1e-4), (0.001, 2e-5))
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


def measured(
    walked: Walked, step: float, parameters: Parameters, mid_stance_of: Any, rng: np.random.Generator
) -> MeasuredRun:
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
        smooth = low_pass(walked.felt[side], 1.0 / step, sensor.bandwidth_hz)
        shown = np.column_stack([np.interp(times, since, column) for column in smooth.T])
        samples[side] = shown + np.asarray(parameters.noise) * rng.normal(size=shown.shape)
    sampling = Sampling(times, times, dict.fromkeys(SIDES, filter_delay(sensor.bandwidth_hz)),
                        dict.fromkeys(SIDES, sensor.bandwidth_hz), first_leg, below_hip=parameters.limits.lever_arm)
    used = dict.fromkeys(SIDES, mask)
    return MeasuredRun("MuJoCo's", sampling, samples, used, strikes,
                       {SLOPE: (parameters.slope.slope_deg, settings.slope_reading_sd_deg)})


@dataclass(frozen=True)
class Fit:
    """A robot's fit (d,) beside its truth (d,), with standard deviations (d,), and `seconds` of processor time."""

    found: FittedRun
    truth: np.ndarray
    sd: np.ndarray
    known: tuple[Known, ...]
    seconds: float


class Fits:
    """The study's own fit of robots walked by MuJoCo."""

    def __init__(self, seed: int) -> None:
        every = Study(ROOT, ROOT / "params", ROOT / "results", ()).parameters(["twin", "calibration"])
        self.seed, self.twin, self.parameters = seed, every["twin"], every["calibration"]
        self.design = drawn_design(self.parameters)
        self.model = first_model(self.design, looked_for(self.design), self.parameters)

    def of(self, robots: Robots, trial: int) -> Fit | str:
        """That of one robot, or why there is none."""
        factors = dict(zip(("biped.foot_mass", "biped.stiffness", "biped.damping"), robots.truth(trial), strict=True))
        truth = np.array([self.design.value(name) * factors.get(name, 1.0) for name in self.model.shared])
        rng = np.random.default_rng([self.seed, trial, 1])
        try:
            walked = walk(robots.model(trial), robots.exported.ramp.sets)
        except StepFailed as reason:
            return f"{trial}: {reason}"
        there = self.design.with_values(dict(zip(self.model.shared, truth.tolist(), strict=True)))
        mass = there.biped.total_mass * (1 + SCALE * rng.normal())
        known = (Known(TOTAL_MASS, mass, SCALE * mass, "weighed"),)
        run = measured(walked, robots.ground.step, self.parameters,
                       partial(mid_stance_of, self.design, self.model.layout), rng)
        begun = time.process_time()
        fit = fitted_run(self.design, "lab", (first_steps(run, self.parameters.settings.fitted_steps), known),
                         self.model)  # fmt: skip
        if isinstance(fit, Failed) or not fit.converged:
            return f"{trial}: {fit.why}"
        return Fit(fit, truth, np.sqrt(np.diag(fit.covariance)), known, time.process_time() - begun)


def of_trials(fits: Fits, trials: int) -> list[str]:
    """Errors and coverage of each parameter, as rows of Markdown."""
    stored = ROOT / "results/calibration.h5"
    told: tuple[Any, str] = (None, f"{stored.name} is not there")
    if stored.exists():
        told = artefact.decode(stored.read_bytes(), Result, stored.name), stored.name
    robots, model = Robots(fits.twin, fits.seed), fits.model
    every = [fits.of(robots, trial) for trial in range(trials)]
    done = [one for one in every if isinstance(one, Fit)]
    shares = np.array([100 * (one.found.design / one.truth - 1) for one in done])
    by_noise = np.array([np.abs(one.found.design - one.truth) <= HALF_WIDTH * one.sd for one in done])
    by_misses = []
    for one in done:
        less = judged(model.shared, one.found.design, one.sd, one.known, fits.design,
                      fits.parameters.settings.lever_arm_sd, model.layout.pull(one.found.unknowns), told)
        by_misses.append(np.abs(less.values - one.truth) <= HALF_WIDTH * less.sd)
    lines = ["| parameter | error, mean, % | scatter, % | noise and residuals hold | with the Exudyn twin's misses |",
             "|---|---|---|---|---|"]
    for row, name in enumerate(model.shared):
        lines.append(f"| {name.partition('.')[2]} | {shares[:, row].mean():+.2f} | {shares[:, row].std():.2f} | "
                     f"{by_noise[:, row].sum()} of {len(done)} | "
                     f"{np.array(by_misses)[:, row].sum()} of {len(done)} |")
    why = "; ".join(one for one in every if isinstance(one, str))
    sigmas = [one.found.sigmas for one in done]
    return [*lines, "", f"{len(done)} of {trials} runs of {fits.parameters.settings.fitted_steps} steps fitted"
            + (f" ({why})" if why else "") + f", residuals {min(sigmas):.2f} to {max(sigmas):.2f} times the noise, "
            f"{np.median([one.seconds for one in done]):.1f} s of processor time a fit (median)."]


def of_grounds(fits: Fits, trials: int) -> list[str]:
    """Residuals and largest error over MuJoCo's ground, from its default to hard, as rows of Markdown."""
    lines = ["| time constant of the ground, ms | residuals, in noises | largest error, % | of |", "|---|---|---|---|"]
    for constant, step in GROUNDS:
        robots = Robots(fits.twin, fits.seed, mjcf.Ground(time_constant=constant, step=step))
        for one in (fits.of(robots, trial) for trial in range(1, trials + 1)):
            if isinstance(one, str):
                lines.append(f"| {1e3 * constant:g} | none: {one} | | |")
                continue
            share = 100 * (one.found.design / one.truth - 1)
            worst = int(np.abs(share).argmax())
            lines.append(f"| {1e3 * constant:g} | {one.found.sigmas:.2f} | {share[worst]:+.1f} | "
                         f"{fits.model.shared[worst].partition('.')[2]} |")
    return lines


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--seed", type=int, default=7000)
    parser.add_argument("--grounds", action="store_true", help="the same on softer and harder ground")
    parser.add_argument("--page", action="store_true", help="put the table into docs/calibration_tests.md")
    asked = parser.parse_args()
    fits = Fits(asked.seed)
    text = "\n".join((of_grounds if asked.grounds else of_trials)(fits, asked.trials))
    print(text)
    if asked.page:
        put(ROOT / "docs/calibration_tests.md", "mujoco grounds" if asked.grounds else "mujoco ours", text)


if __name__ == "__main__":
    main()
