"""Blind campaigns of the constraint model: which 95 % intervals hold the truth, how wide they are, what a fit takes.

    python -m benchmarks.calibration --first 1000 --campaigns 200 --runs 1 [--keep FOLDER] [--page]
    python -m benchmarks.calibration --time 1 3 10 30 [--differences]

With --keep campaigns that are done stay in the folder, and a stopped command goes on. With --time one campaign of so
many runs is fitted on all cores and timed; with --differences derivatives are differences of walks. --page puts the
table into docs/calibration_tests.md.
"""

import argparse
import json
import os
import resource
import sys
import time
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a fit's matrices are small: threads only wait for each other


from benchmarks.marked import put
from pipeline.study import Study
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.blind_score import draw, model_of, score, summary
from stages.calibration.estimation import run_fit
from stages.calibration.estimation.campaign import fit_campaign
from stages.calibration.observation.measured_run import SIDES, Layout, Sampling
from stages.calibration.observation.prediction import Predicted, predict
from stages.calibration.parameters import Parameters

ROOT = Path(__file__).resolve().parent.parent
#: Step of a difference, as a share of a parameter, or of what is a small change of an unknown.
SHARE, SMALL = 1e-5, 1e-2


def differenced(
    design: DesignPoint, names: tuple[str, ...], unknowns: Vector, layout: Layout, sampling: Sampling, tolerance: float
) -> Predicted:
    """`predict` with derivatives by design and start as differences: a walk more for each. Sensors' stay exact."""
    base = predict(design, (), unknowns, layout, sampling, tolerance)
    exact = predict(design, names, unknowns, layout, sampling, tolerance)  # shapes, and the sensors' own columns
    d = len(names)
    for number in range(d + layout.free):
        there, moved = design, unknowns.copy()
        if number < d:
            step = SHARE * abs(design.value(names[number]))
            there = design.with_value(names[number], design.value(names[number]) + step)
        else:
            step = SMALL * layout.sizes[number - d]
            moved[number - d] += step
        found = predict(there, (), moved, layout, sampling, tolerance)
        both = min(len(found.strikes), len(base.strikes))
        for side in SIDES:
            exact.samples[side][:, :, 1 + number] = (found.samples[side] - base.samples[side])[:, :, 0] / step
        exact.strikes[:both, 1 + number] = (found.strikes[:both, 0] - base.strikes[:both, 0]) / step
    return exact


def campaigns(first: int, count: int, runs: int, parameters: Parameters, keep: Path | None) -> list[dict[str, Any]]:
    """The campaigns, those that are kept and the others."""
    file = keep / f"{first}-{runs}.jsonl" if keep else None
    done = {one["seed"]: one for one in map(json.loads, file.read_text().splitlines())} if (
        file and file.exists()) else {}
    missing = [seed for seed in range(first, first + count) if seed not in done]
    for one in score(missing, runs, parameters, lambda share, what: print(what, file=sys.stderr, flush=True)):
        done[one["seed"]] = one
        if file:
            file.parent.mkdir(parents=True, exist_ok=True)
            with file.open("a") as lines:
                lines.write(json.dumps(one) + "\n")
    return [done[seed] for seed in range(first, first + count)]


def table(all_scored: list[dict[str, Any]]) -> str:
    """Rows of Markdown for the page."""
    told = summary(all_scored)
    rows = [f"| {name.partition('.')[2]} | {100 * told['coverage'][name]:.1f} % | "
            f"{100 * told['median_sd_share'][name]:.3f} % | {told['median_width_over_bound'][name]:.3f} |"
            for name in told["coverage"]]  # fmt: skip
    head = ("| parameter | 95 % intervals that hold the truth | median sd | of the smallest possible |\n"
            "|---|---|---|---|")
    failed = "; ".join(f"{seed}: {why}" for seed, why in told["not_converged"].items()) or "none"
    return "\n".join([head, *rows, "", f"All together {100 * told['coverage_together']:.1f} % in "
                      f"{told['campaigns']} campaigns. Not converged: {failed}. Residuals {told['chi2'][0]:.2f} to "
                      f"{told['chi2'][1]:.2f} of the noise's square; {told['median_walks']:.0f} walks (median)."])


def timed(counts: list[int], seed: int, parameters: Parameters, differences: bool) -> str:
    """A row for each number of runs."""
    if differences:
        run_fit.predict = differenced
    drawing, model = model_of(parameters)
    rows = ["| runs | seconds | processor seconds | walks | converged |", "|---|---|---|---|---|"]
    for count in counts:
        campaign = draw(seed, count, parameters)
        begun, spent = time.monotonic(), _spent()
        fit = fit_campaign(drawing, campaign.runs, model, campaign.known)
        rows.append(f"| {count} | {time.monotonic() - begun:.1f} | {_spent() - spent:.1f} | {fit.evaluations} | "
                    f"{'yes' if fit.converged else fit.why} |")
        print(rows[-1], file=sys.stderr, flush=True)
    return "\n".join(rows)


def _spent() -> float:
    """Processor time of this process and of those it waited for [s]."""
    return sum(used.ru_utime + used.ru_stime for used in map(
        resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)))


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=1000, help="seed of the first campaign")
    parser.add_argument("--campaigns", type=int, default=20)
    parser.add_argument("--runs", type=int, default=1, help="runs of a campaign")
    parser.add_argument("--keep", type=Path, default=None)
    parser.add_argument("--time", type=int, nargs="+", default=None)
    parser.add_argument("--differences", action="store_true")
    parser.add_argument("--page", action="store_true")
    asked = parser.parse_args()
    settings = ("biped.leg_inertia=8.576e-4",)
    parameters = Study(ROOT, ROOT / "params", ROOT / "results", settings).parameters(["calibration"])["calibration"]
    if asked.time:
        name = "differences" if asked.differences else "time"
        text = timed(asked.time, asked.first, parameters, asked.differences)
    else:
        name = "one run" if asked.runs == 1 else "many runs"
        last = asked.first + asked.campaigns - 1
        text = (f"Runs of a campaign: {asked.runs}. Seeds {asked.first} to {last}.\n\n"
                + table(campaigns(asked.first, asked.campaigns, asked.runs, parameters, asked.keep)))
    print(text)
    if asked.page:
        put(ROOT / "docs/calibration_tests.md", name, text)


if __name__ == "__main__":
    main()
