"""How often the ingest accepts what is wrong: families of wrong logs on walks of the twin, against their truth.

    python -m benchmarks.trial_judgement [--seed 13] [--runs 30] [--times 1 3 10] [--walks FILE] [FAMILY ...]

The walks are those of the campaign with another seed than the study's; --walks keeps them in a file of this machine
for the next time. Each run's sensors have their errors so many times as large. A family (tests/imu/wrong_logs.py) does
one wrong thing to each log. Cells: accepted / accepted with remarks / refused; the last two columns have a count for
each size of the errors. A run is *unsaid* if it is accepted and a quantity is wrong (tests/imu/made_logs.py) that
no remark names. The second table is of the clocks alone: the true error of the sample times less their mean, and the
error that is reported.
"""

import argparse
import dataclasses
import pickle
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pipeline.study import locate
from stages.analytic.run import run as run_analytic
from stages.campaign.parameters import Parameters
from stages.campaign.twin_run import TwinRun, first_state, walk_twin
from stages.imu.judgement.verdict import ACCEPTED, REFUSED, WITH_REMARKS
from stages.imu.parameters import Parameters as Ingest
from stages.imu.trial.sensor import trace_sensor
from stages.imu.trial.trial import read_trials
from tests.imu import wrong_logs
from tests.imu.made_logs import Log, made_log, with_errors, wrong_quantities

ROOT = Path(__file__).resolve().parent.parent


def good(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """Nothing is wrong."""
    return log


def campaign(seed: int, runs: int, file: Path | None) -> tuple[Parameters, list[TwinRun]]:
    """The campaign's parameters with another seed, and its walks: a second or two each, or out of `file`."""
    every = locate(start=ROOT).parameters(("analytic", "campaign"))
    parameters: Parameters = every["campaign"]
    parameters = dataclasses.replace(parameters, runs=dataclasses.replace(parameters.runs, seed=seed, runs=runs))
    if file is not None and file.exists():
        walks: list[TwinRun] = pickle.loads(file.read_bytes())
        return parameters, walks
    state, force = first_state(run_analytic(every["analytic"]).walk)
    walks = [walk_twin(number, state, force, parameters) for number in range(runs)]
    if file is not None:
        file.write_bytes(pickle.dumps(walks))
    return parameters, walks


def judged(
    family: wrong_logs.Family, times: float, parameters: Parameters, walks: Sequence[TwinRun], imu: Ingest
) -> Counter[str]:
    """Counts over the runs: outcomes, and accepted runs with something wrong, named or unsaid."""
    count: Counter[str] = Counter()
    for number, walked in enumerate(walks):
        rng = np.random.default_rng([parameters.runs.seed, number])
        log = family(made_log(number, walked, with_errors(parameters, times)), walks, rng)
        trial = next(read_trials(log.experiment, log.recordings, imu))
        count[trial.verdict.outcome] += 1
        wrong = set(wrong_quantities(log, trial)) if trial.accepted else set()
        count["wrong"] += bool(wrong)
        count["unsaid"] += bool(wrong - set(trial.verdict.not_trusted))
    return count


def clocks(
    family: wrong_logs.Family, parameters: Parameters, walks: Sequence[TwinRun], imu: Ingest
) -> tuple[int, int, float, float, float, int]:
    """Recordings, those whose clock is used, their largest true error and median reported error [ms], the largest
    ratio of true to reported, and how many are off by more than the tolerance though a smaller error is reported."""
    true, said = [], []
    for number, walked in enumerate(walks):
        log = family(made_log(number, walked, parameters), walks, np.random.default_rng([parameters.runs.seed, number]))
        for recording in log.recordings:
            trace = trace_sensor(recording, imu.settings)
            kept_rows = trace.indexed.recording
            true.append(float(np.std(trace.time - kept_rows.true_time)))  # type: ignore[attr-defined]
            said.append(trace.clock.clock_error_s)
    off, told, limit = np.array(true), np.array(said), imu.settings.clock_tolerance_s
    used, known = ~(told > limit), np.isfinite(told)
    false = int((known & used & (off > np.maximum(limit, told))).sum())
    ratio = float(np.max(off[known & used] / np.maximum(told[known & used], 1e-3), initial=0.0))
    middle = float(np.median(told[known & used])) if (known & used).any() else float("nan")
    return len(off), int(used.sum()), 1e3 * float(off[used].max(initial=0.0)), 1e3 * middle, ratio, false


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=13)
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--times", type=float, nargs="+", default=[1.0, 3.0, 10.0])
    parser.add_argument("--walks", type=Path)
    parser.add_argument("family", nargs="*")
    chosen = parser.parse_args()
    parameters, walks = campaign(chosen.seed, chosen.runs, chosen.walks)
    imu = locate(start=ROOT).parameters(("imu",))["imu"]
    families = {"good": good, **wrong_logs.WRONG, **wrong_logs.LATER, **wrong_logs.CLOCKS, **wrong_logs.LAST,
                **wrong_logs.SILENT}  # fmt: skip
    families = {name: one for name, one in families.items() if not chosen.family or name in chosen.family}
    sizes = " | ".join(f"errors x {times:g}" for times in chosen.times)
    print(f"| family | {sizes} | wrong and accepted | not reported |\n" + "|---" * (len(chosen.times) + 3) + "|")
    for name, family in families.items():
        counts = [judged(family, times, parameters, walks, imu) for times in chosen.times]
        cells = ["/".join(str(count[one]) for one in (ACCEPTED, WITH_REMARKS, REFUSED)) for count in counts]
        cells += ["/".join(str(count[one]) for count in counts) for one in ("wrong", "unsaid")]
        print(f"| {name.replace('_', ' ')} | {' | '.join(cells)} |", flush=True)
    print("\n| clock | recordings | used | true ms, worst | reported ms, median | true over reported, worst | falsely "
          "confident |\n|---|---|---|---|---|---|---|")  # fmt: skip
    for name, family in families.items():
        if name == "good" or name in wrong_logs.CLOCKS:
            total, used, true, said, ratio, false = clocks(family, parameters, walks, imu)
            print(f"| {name.replace('_', ' ')} | {total} | {used} | {true:.2f} | {said:.2f} | {ratio:.2f} "
                  f"| {false} |", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
