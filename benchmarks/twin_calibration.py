"""Blind calibrations of the Exudyn twin: robots built at random, walked, sensed, sent, ingested and fitted.

    python -m benchmarks.twin_calibration --keep FOLDER [--seed 6001 --runs 24] [--against 5001 --blind 40]
    python -m benchmarks.twin_calibration --keep FOLDER --model frames --seed 8001 --against 7001 --page untouched

Each run has a build, an outsole, a ramp, a push and sensors of its own, as campaign.yaml has them, and is fitted
without a look at them. What fits of the first seed's runs miss is the discrepancy of the model; those of the other seed
are held against their truth. The lower legs' inertia keeps the drawing's value: runs tell it and the place of mass only
together. With --keep what is done stays, and a stopped command goes on.
"""

import argparse
import dataclasses
import json
import os
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a fit's matrices are small: threads only wait for each other

import numpy as np

from benchmarks.marked import put
from benchmarks.sandwich import noise_covariance, sandwich_covariance
from pipeline.study import Study
from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.run import run as run_analytic
from stages.biped.design import Biped
from stages.biped.processes import each_in_a_process
from stages.biped.walk import StanceState
from stages.calibration.estimation.least_squares import TOTAL_MASS, Known
from stages.calibration.estimation.run_fit import fit_run
from stages.calibration.information.identifiability import first_model
from stages.calibration.intervals.model_error import Discrepancy, structure
from stages.calibration.parameters import Parameters as CalibrationParameters
from stages.calibration.recordings import drawn_design, guess, run_of, table_value
from stages.calibration.result import HALF_WIDTH
from stages.campaign.parameters import Parameters as CampaignParameters
from stages.campaign.twin_run import NoWalk, TwinRun, first_state, generator, walk_twin
from stages.imu.trial.trial import Trial, read_trials
from stages.twin.machine.projection import machine_of, project
from tests.imu.made_logs import Log, made_log

ROOT = Path(__file__).resolve().parent.parent
#: Models that are fitted: without frames above the springs, and with the drawing's.
PLAIN, FRAMES = "plain", "frames"
TITLES = {PLAIN: "Without frames in the model", FRAMES: "With the frames of the nominal design"}
COMMON = ("foot_mass", "leg_length", "foot_radius", "foot_com", "stiffness", "damping")
CLOCKS = ("hip_clock", "foot_clock")
OWN = ("ground.slope_deg", *CLOCKS)
GEOMETRY = ("leg_length", "foot_radius", "foot_com", *OWN)
#: Relative error of the scale, and its stream of random numbers.
SCALE, SCALE_STREAM = 1e-3, 1500


def drawn(kind: str, calibration: CalibrationParameters, campaign: CampaignParameters) -> DesignPoint:
    """What a lab starts from: the drawing without its outsole, as either model has it."""
    if kind == FRAMES:
        return drawn_design(calibration)
    whole = project(machine_of(campaign.biped, campaign.twin))
    return guess(dataclasses.replace(
        calibration, biped=dataclasses.replace(campaign.biped, leg_inertia=whole.leg_inertia)))


def truth_of(name: str, machine: Biped) -> float:
    """A parameter as Table 1 counts it; leg 0's length, as each run looks for the other's."""
    return machine.leg_length if name == "leg_length" else table_value(machine, f"biped.{name}")


def clock_of(side: str, trial: Trial, log: Log) -> float:
    """How much longer a second really is than the ingest thinks, relative."""
    trace = trial.sensors[side].trace
    true = trace.indexed.recording.true_time  # type: ignore[attr-defined]
    return float(np.polyfit(trace.time - trace.time[0], true, 1)[0]) - 1.0


def blind(
    number: int, seed: int, state: StanceState, force: float, calibration: CalibrationParameters,
    campaign: CampaignParameters, kinds: Sequence[str] = (PLAIN, FRAMES),
) -> dict[str, Any]:
    """One robot and one run of it, fitted with these models; what was found beside the truth, in plain values."""
    campaign = dataclasses.replace(campaign, runs=dataclasses.replace(campaign.runs, seed=seed))
    try:
        walked = walk_twin(number, state, force, campaign)
    except NoWalk as reason:
        return {"seed": seed, "number": number, "why": str(reason)}
    log = made_log(number, walked, campaign)
    trial = next(read_trials(log.experiment, log.recordings, calibration.ingest))
    if not trial.accepted:
        return {"seed": seed, "number": number, "why": "turned down by the ingest"}
    return {"seed": seed, "number": number, "outsole": walked.variation.build.outsole,
            **{kind: fitted(kind, seed, number, walked, log, trial, calibration, campaign)
               for kind in kinds}}


def fitted(
    kind: str, seed: int, number: int, walked: TwinRun, log: Log, trial: Trial, calibration: CalibrationParameters,
    campaign: CampaignParameters,
) -> dict[str, Any]:
    """The run fitted with one model."""
    design = drawn(kind, calibration, campaign)
    mass = "hip_mass" if kind == PLAIN else "frame_mass"
    names = tuple(f"biped.{name}" for name in (mass, *COMMON))
    model = first_model(design, (*names, "biped.other_leg_length"), calibration)
    run = run_of(trial, design, model.layout, calibration.settings, calibration.limits.lever_arm)
    if isinstance(run, str):
        return {"why": run}
    machine = project(machine_of(campaign.biped, campaign.twin, walked.variation.build))
    weighed = machine.total_mass * (1 + SCALE * generator(seed, number, SCALE_STREAM).normal())
    known = (Known(TOTAL_MASS, weighed, SCALE * weighed, "scale"),)
    try:
        fit = fit_run(design, run, model, known)
    except StepFailed as reason:
        return {"why": str(reason)}
    d, k = len(model.shared), len(model.layout.names)
    rows = [*range(d), d + k, *(d + model.layout.place(f"{side}_clock") for side in ("hip", "foot"))]
    values = np.concatenate([fit.design, fit.unknowns, fit.own])[rows]
    covariances = (noise_covariance(fit.equations, model, known),
                   sandwich_covariance(run, fit.equations, model, known))
    sds = [np.sqrt(np.diag(one)[rows]) for one in covariances]
    size = np.ones(len(rows))
    size[0] = 1.0 if kind == PLAIN else 2.0  # both frames together are the hip of Table 1
    truth = [*(truth_of(name, machine) for name in ("hip_mass", *COMMON)), walked.variation.slope_deg,
             *(clock_of(side, trial, log) for side in ("hip", "foot"))]
    scales = [abs(design.value(name)) for name in model.shared] + [design.value(OWN[0]), 1.0, 1.0]
    return {
        "names": ["hip_mass", *COMMON, *OWN], "truth": truth, "estimate": (values * size).tolist(),
        "noise": (sds[0] * size).tolist(), "sandwich": (sds[1] * size).tolist(), "scales": (scales * size).tolist(),
        "sigmas": float(np.sqrt(fit.equations.chi2 / fit.equations.count)), "converged": fit.converged, "why": fit.why,
        "walks": fit.evaluations,
        "structure": [dataclasses.asdict(one) | {"means": one.means.tolist()} for one in
                      structure(run, fit.equations)],
    }


def kept(folder: Path | None, seed: int) -> dict[int, dict[str, Any]]:
    """Runs of a seed that are done."""
    file = folder / f"{seed}.jsonl" if folder else None
    if file is None or not file.exists():
        return {}
    return {one["number"]: one for one in map(json.loads, file.read_text().splitlines())}


def all_runs(folder: Path | None, seed: int, count: int, calibration: CalibrationParameters,
             campaign: CampaignParameters, start: tuple[StanceState, float], kinds: Sequence[str]
             ) -> list[dict[str, Any]]:  # fmt: skip
    """Runs of a seed, those that are kept and the others, on all cores."""
    done = kept(folder, seed)
    missing = [number for number in range(count) if number not in done]
    one = partial(blind, seed=seed, state=start[0], force=start[1], calibration=calibration, campaign=campaign,
                  kinds=kinds)
    for place, found in each_in_a_process(one, missing):
        done[missing[place]] = found
        print(f"run {missing[place]} of seed {seed}, {len(done)} of {count} done", file=sys.stderr, flush=True)
        if folder:
            with (folder / f"{seed}.jsonl").open("a") as file:
                file.write(json.dumps(found, default=float) + "\n")
    return [done[number] for number in range(count) if number in done]


def usable(runs: Sequence[dict[str, Any]], kind: str) -> list[dict[str, Any]]:
    """Fits of one model that came to rest."""
    return [run[kind] for run in runs if kind in run and "names" in run[kind] and run[kind]["converged"]]


def table(
    kind: str, own: Sequence[dict[str, Any]], runs: Sequence[dict[str, Any]], clock_sd: float
) -> list[str]:
    """Bias and coverage of each parameter as rows of Markdown."""
    fits = usable(runs, kind)
    names = tuple(fits[0]["names"])
    estimate, truth, noise, sandwich, scales = (
        np.array([one[key] for one in fits]) for key in ("estimate", "truth", "noise", "sandwich", "scales"))
    share = (estimate - truth) / scales
    trained = usable(own, kind)
    pulls, own_pulls = (np.array([np.mean([one["estimate"][names.index(clock)] for clock in CLOCKS]) for one in each])
                        for each in (fits, trained))
    term = Discrepancy.of(np.array([(np.array(one["estimate"]) - one["truth"]) / one["scales"]
                                           for one in trained]), own_pulls)  # fmt: skip
    centred = np.array([one - term.expected(*each) for one, *each in zip(estimate, scales, pulls, strict=True)])
    half = np.array([HALF_WIDTH * np.sqrt(np.diag(term.spread(*each))) for each in zip(scales, pulls, strict=True)])
    clocks = [names.index(clock) for clock in CLOCKS]  # a fit that is pulled tells nothing of them: the ingest does
    centred[:, clocks], half[:, clocks] = 0.0, HALF_WIDTH * clock_sd
    holds = [np.abs(estimate - truth) <= HALF_WIDTH * noise, np.abs(estimate - truth) <= HALF_WIDTH * sandwich,
             np.abs(centred - truth) <= half]
    lines = ["| parameter | mean error, % | scatter, % | noise holds | sandwich holds | discrepancy holds | "
             "its half width, % | error left, rms, % |", "|---|---|---|---|---|---|---|---|"]
    for row, name in enumerate(names):
        counts = " | ".join(f"{int(one[:, row].sum())}/{len(fits)}" for one in holds)
        after = np.sqrt((((centred - truth) / scales)[:, row] ** 2).mean())
        lines.append(f"| {name} | {100 * share[:, row].mean():+.3f} | {100 * share[:, row].std():.3f} | {counts} | "
                     f"{100 * np.median((half / scales)[:, row]):.3f} | {100 * after:.3f} |")
    sound = [row for row, name in enumerate(names) if name in GEOMETRY]
    rest = [row for row in range(len(names)) if row not in sound]
    lines.append("")
    for what, rows in (("geometry, slope and clocks", sound), ("masses and springs", rest)):
        shares = ", ".join(f"{how} {100 * one[:, rows].mean():.1f} %" for how, one in
                           zip(("noise", "sandwich", "discrepancy"), holds, strict=True))
        lines.append(f"Intervals that hold the truth, {what}: {shares}.")
    sigmas = [one["sigmas"] for one in fits]
    not_noise = [np.mean([min(each["by_phase"], each["white"]) < 1e-3 for each in one["structure"]]) for one in fits]
    lines.append(f"{len(fits)} of {len(runs)} fits converged, and {len(trained)} of the {len(own)} for the "
                 f"discrepancy. Residuals are {min(sigmas):.2f} to {max(sigmas):.2f} "
                 f"times the noise; {100 * np.mean(not_noise):.0f} % of the signals are not noise by one of the tests.")
    return lines


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=6001)
    parser.add_argument("--runs", type=int, default=24)
    parser.add_argument("--against", type=int, nargs="+", default=[5001])
    parser.add_argument("--blind", type=int, default=40)
    parser.add_argument("--keep", type=Path, default=None)
    parser.add_argument("--model", choices=(PLAIN, FRAMES), default=None, help="one model alone (default: both)")
    parser.add_argument("--page", default=None, metavar="MARK", help="put the tables into its page there")
    parser.add_argument("--only-table", action="store_true", help="tell of what is kept, run nothing")
    asked = parser.parse_args()
    kinds = (asked.model,) if asked.model else (PLAIN, FRAMES)
    every = Study(ROOT, ROOT / "params", ROOT / "results", ()).parameters(["analytic", "calibration", "campaign"])
    clock_sd = every["calibration"].settings.clock_sd
    if asked.only_table:
        own, runs = ([one for seed in seeds for one in kept(asked.keep, seed).values()]
                     for seeds in ([asked.seed], asked.against))
    else:
        start = first_state(run_analytic(every["analytic"]).walk)
        if asked.keep:
            asked.keep.mkdir(parents=True, exist_ok=True)
        own, runs = ([one for seed in seeds for one in all_runs(
                         asked.keep, seed, count, every["calibration"], every["campaign"], start, kinds)]
                     for seeds, count in (([asked.seed], asked.runs), (asked.against, asked.blind)))
    text = f"Seeds {asked.seed} (the discrepancy) and {', '.join(map(str, asked.against))} (blind)."
    for kind in kinds:
        text += f"\n\n{TITLES[kind]}:\n\n" + "\n".join(table(kind, own, runs, clock_sd))
    print(text)
    if asked.page:
        put(ROOT / "docs/calibration_tests.md", asked.page, text)


if __name__ == "__main__":
    main()
