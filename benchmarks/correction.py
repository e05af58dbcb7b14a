"""What a correction step by the Exudyn twin takes off the constraint model's bias, with outsole and without.

python -m benchmarks.correction --runs 8 --seed 7
"""

import argparse
import dataclasses
import json
import tempfile
import time
from pathlib import Path

import numpy as np

from pipeline.study import Study
from stages.analytic.result import Inputs as WalkInputs
from stages.analytic.run import run as run_analytic
from stages.calibrated_twin.run import Inputs as TwinInputs, run as run_calibrated_twin
from stages.calibration.run import Inputs, run
from stages.campaign.run import Inputs as CampaignInputs, run as run_campaign
from stages.twin.run import run as run_twin

ROOT = Path(__file__).resolve().parent.parent
STAGES = ["analytic", "twin", "campaign", "calibration", "calibrated_twin"]


def main() -> None:
    """Print, of each parameter, errors before and after in percent, and what is left of the bias, as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=8)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--steps", type=int, default=None, help="steps of a run that are fitted")
    asked = parser.parse_args()
    every = Study(ROOT, ROOT / "params", ROOT / "results", ()).parameters(STAGES)
    runs = dataclasses.replace(every["campaign"].runs, seed=asked.seed, runs=asked.runs, bare_runs=asked.runs)
    settings = dataclasses.replace(
        every["calibration"].settings, fitted_runs=asked.runs, corrected_runs=asked.runs, held_out_runs=0,
        fitted_steps=asked.steps or every["calibration"].settings.fitted_steps)  # fmt: skip
    campaign = run_campaign(dataclasses.replace(every["campaign"], runs=runs),
                            CampaignInputs(run_twin(every["twin"], WalkInputs(run_analytic(every["analytic"])))))
    with tempfile.TemporaryDirectory() as folder:
        paths = []
        for name, content in campaign.files.items():
            paths.append(Path(folder) / name)
            paths[-1].write_bytes(content)
        begun = time.process_time()
        calibration = run(dataclasses.replace(every["calibration"], given=settings), Inputs(*paths, campaign))
        fitted = time.process_time()
        twin = run_calibrated_twin(dataclasses.replace(every["calibrated_twin"], given=settings, runs=runs),
                                   TwinInputs(calibration, *paths, campaign))
        ended = time.process_time()
    report: dict[str, object] = {"fit_s": fitted - begun, "correct_s": ended - fitted, "reasons": twin.reasons,
                                 "failed": [one.why for one in calibration.failed]}  # fmt: skip
    errors: dict[str, np.ndarray] = {}
    for robot in twin.robots:
        fits = calibration.of_kind(robot.kind)
        before = np.array([one.design - one.truth for one in fits])
        truth = np.array([one.truth for one in fits])
        own = before - robot.biases if len(robot.biases) == len(fits) else np.full_like(before, np.nan)
        first = before - robot.biases[0]
        errors[robot.kind] = first
        report[robot.kind] = {
            name: {"mean_before_%": _share(before, truth, row)[0], "rms_before_%": _share(before, truth, row)[1],
                   "mean_own_%": _share(own, truth, row)[0], "rms_own_%": _share(own, truth, row)[1],
                   "rms_first_%": _share(first, truth, row)[1],
                   "left": float(np.sqrt((first[:, row] ** 2).mean() / (robot.biases[:, row] ** 2).mean()))}
            for row, name in enumerate(calibration.names)
        }
        noise = np.sqrt(np.mean([np.diag(one.covariance) for one in fits], axis=0))
        report[f"sd_%, {robot.kind}"] = dict(zip(calibration.names, (100 * noise / truth.mean(axis=0)).tolist()))
    if len(errors) == 2:
        usual, bare = errors.values()
        count = min(len(usual), len(bare))
        apart = usual[:count] - bare[:count]
        bias = 0.5 * np.abs(twin.robots[0].biases.mean(axis=0) + twin.robots[1].biases.mean(axis=0))
        report["between"] = {name: {"rms_%": _share(apart, truth[:count], row)[1],
                                    "left": float(np.sqrt((apart[:, row] ** 2).mean()) / bias[row])}
                             for row, name in enumerate(calibration.names)}  # fmt: skip
    report["pairs"] = [dataclasses.asdict(one) for one in twin.pairs]
    report["robots"] = [[dataclasses.asdict(one) for one in robot.numbers] for robot in twin.robots]
    print(json.dumps(report, indent=1, default=float))


def _share(errors: np.ndarray, truth: np.ndarray, row: int) -> tuple[float, float]:
    """Mean and root mean square in percent of the truth."""
    shares = 100 * errors[:, row] / truth[:, row]
    return float(shares.mean()), float(np.sqrt((shares**2).mean()))


if __name__ == "__main__":
    main()
