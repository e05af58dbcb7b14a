"""Leg angle, step length and times by leg of synthetic runs against their truth, with other seeds than the study's.

    python -m benchmarks.leg_motion [--seed 23 24] [--runs 30] [--walks FOLDER]

A table a seed: rms error, rms of the standard error that the ingest gives, and the share of 95 % intervals that hold.
What decides them (`onset_error_s`, `toe_off_error_s`, `rolling_error` in params/imu.yaml) was measured with seeds 21
and 22. --walks keeps walks in a folder of this machine for the next time.
"""

import argparse
from pathlib import Path

from benchmarks.trial_judgement import ROOT, campaign
from pipeline.study import locate
from stages.campaign.run import sensed_run
from stages.comparison.ingest_score import score_legs, shift_of
from stages.imu.run import run_of
from stages.imu.trial.trial import read_trials
from tests.imu.made_logs import made_log


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, nargs="+", default=[23, 24])
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--walks", type=Path)
    chosen = parser.parse_args()
    imu = locate(start=ROOT).parameters(("imu",))["imu"]
    print("| seed | quantity | rms error | standard error said | 95 % intervals that hold |\n|---|---|---|---|---|")
    for seed in chosen.seed:
        file = None if chosen.walks is None else chosen.walks / f"walks{seed}.pickle"
        parameters, walks = campaign(seed, chosen.runs, file)
        scored = []
        for number, walked in enumerate(walks):
            log = made_log(number, walked, parameters)
            trial = next(read_trials(log.experiment, log.recordings, imu))
            if trial.accepted:
                run, (_, truth, _) = run_of(trial), sensed_run(number, walked, parameters)
                scored.append((run, truth, shift_of(run, truth)))
        for name, rms, said, held in score_legs(scored, imu.settings.skipped_steps, imu.settings.gravity).rows():
            told, share = ("" if value != value else f"{value:.3g}" for value in (said, held))
            print(f"| {seed} | {name} | {rms:.3g} | {told} | {share} |", flush=True)


if __name__ == "__main__":
    main()
