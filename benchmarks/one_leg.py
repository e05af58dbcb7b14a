"""Robots of which one leg's radius, mass or stiffness is 3 % off, that number fitted: does its interval hold the truth?

python -m benchmarks.one_leg --robots 20 --runs 2
"""

import argparse
import json
from typing import Any

import numpy as np

from benchmarks.same_robot import settings
from stages.analytic.errors import NoGait, StepFailed
from stages.calibration.blind_score import MOST_DRAWS, SCALE, _run, drawn_robot, model_of
from stages.calibration.estimation.campaign import fit_campaign
from stages.calibration.estimation.held_out import explained
from stages.calibration.estimation.least_squares import TOTAL_MASS, Known
from stages.calibration.information.identifiability import SLOPE, first_model
from stages.calibration.intervals.left_out import with_all
from stages.calibration.intervals.model_error import widening
from stages.calibration.parameters import Parameters
from stages.calibration.result import HALF_WIDTH

OFF, SEED = 0.03, 4100
NAMES = ("biped.other_foot_radius", "biped.other_foot_mass", "biped.other_stiffness")


def one(number: int, runs: int, parameters: Parameters) -> dict[str, Any]:
    """One robot: what was found of its other leg's number beside the truth, and a run that was not fitted."""
    rng, name = np.random.default_rng([SEED, number]), NAMES[number % len(NAMES)]
    drawing, plain = model_of(parameters)
    begin = with_all(drawing, [name])
    model = first_model(begin, (*plain.shared, name), parameters)
    for _ in range(MOST_DRAWS):
        robot = with_all(drawn_robot(drawing, plain.shared, rng), [name])
        truth = robot.value(name) * (1.0 + OFF * rng.choice([-1.0, 1.0]))
        robot = robot.with_value(name, truth)
        try:
            made = [_run(robot, drawing, model, parameters, each, rng)[0] for each in range(runs + 1)]
            break
        except (NoGait, StepFailed):
            continue
    mass = robot.biped.total_mass
    known = (Known(TOTAL_MASS, mass * (1 + SCALE * rng.normal()), SCALE * mass, "scale"),)
    row: dict[str, Any] = {"number": number, "name": name, "truth": truth}
    try:
        fit = fit_campaign(begin, made[:-1], model, known)
        found = model.robot(begin, fit.design, fit.own.mean(axis=0)).with_value(SLOPE, begin.value(SLOPE))
        out = explained(found, made[-1], model, parameters.settings.begun_s)
    except StepFailed as reason:
        return {**row, "why": str(reason)}
    _, wider = widening(fit.equations)
    at = fit.names.index(name)
    sd = wider * float(np.sqrt(fit.covariance[at, at]))
    return {**row, "found": float(fit.design[at]), "sd": sd, "converged": fit.converged,
            "holds": bool(abs(fit.design[at] - truth) < HALF_WIDTH * sd), "held_out": out.sigmas,
            "forecast": [out.foretold_force / model.noise[0], out.foretold_rate / model.noise[2]]}  # fmt: skip


def main() -> None:
    """Print each robot as it is done, and how many intervals hold."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--runs", type=int, default=2, help="runs of each robot that are fitted")
    parser.add_argument("--steps", type=int, default=7)
    parser.add_argument("--set", action="append", default=[])
    asked = parser.parse_args()
    parameters, rows = settings(asked.steps, asked.set), []
    for number in range(asked.robots):
        rows.append(one(number, asked.runs, parameters))
        print(json.dumps(rows[-1]), flush=True)
    done = [row for row in rows if "holds" in row]
    print(f"{sum(row['holds'] for row in done)} of {len(done)} intervals hold the truth; runs that were not fitted: "
          f"{np.median([row['held_out'] for row in done]):.2f} noises")


if __name__ == "__main__":
    main()
