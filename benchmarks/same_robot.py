"""How often `same` calls a robot another one that is not, finds a part that has changed, and names it.

python -m benchmarks.same_robot --robots 6 --unchanged 25 --changed 6 --keep same.jsonl
python -m benchmarks.same_robot --robots 1 --unchanged 12 --changed 0 --twin

Robots are drawn and fitted on nine runs of the model's own kind; their further runs are held to them one by one. A part
changes by 1 %, up or down, or by what the Fisher information finds with a power of .97 where that is more. With --twin
runs are those of the Exudyn twin as drawn, sensed, sent and ingested.
"""

import argparse
import contextlib
import dataclasses
import json
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import ndtr, ndtri, stdtrit

from pipeline.study import Study
from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.calibration.blind_score import Drawn, _run, draw, model_of
from stages.calibration.estimation.campaign import fit_campaign
from stages.calibration.estimation.least_squares import TOTAL_MASS, Known
from stages.calibration.following.change import Comparison
from stages.calibration.following.fitted import fitted_robot
from stages.calibration.following.score_test import LEVEL, PARTS, Part
from stages.calibration.information.identifiability import SLOPE, first_model, free_names
from stages.calibration.intervals.left_out import FRICTION
from stages.calibration.intervals.model_error import Judged, widening
from stages.calibration.observation.measured_run import SIDES, MeasuredRun
from stages.calibration.observation.prediction import predict
from stages.calibration.parameters import Parameters
from stages.calibration.recordings import as_mounted, drawn_design, guess, looked_for, read_runs
from stages.campaign.parameters import Parameters as Campaign
from stages.campaign.run import MOUNTING, database_bytes, device, sensed_run
from stages.campaign.twin_run import first_state, walk_twin

ROOT = Path(__file__).resolve().parent.parent
SHARE, POWER, FITTED, SEED, PUSHES = 0.01, 0.97, 9, 4200, 5
#: Inertia of a leg of Table 1's robot about its own mass centre, which its file does not give [kg m^2].
INERTIA = "biped.leg_inertia=8.576e-4"
#: Runs of the twin are of one machine: nothing is put on again.
ONE_MACHINE = ("campaign.tolerance_sd=0", "campaign.length_sd=0")


def settings(steps: int, given: list[str], params: Path = ROOT / "params") -> Parameters:
    """The study's, with legs that have an inertia and sensors that stay where they are."""
    every = Study(ROOT, params, ROOT / "results", (INERTIA, *given))
    found: Parameters = every.parameters(["calibration"])["calibration"]
    return as_mounted(dataclasses.replace(found, given=dataclasses.replace(found.settings, planned_steps=steps)))


def robot_of(runs: tuple[MeasuredRun, ...], known: tuple[Known, ...], parameters: Parameters, twin: bool) -> Comparison:
    """The robot that its first runs are fitted by."""
    design = drawn_design(parameters) if twin else guess(parameters)
    model = first_model(design, looked_for(design) if twin else free_names(design), parameters)
    fit = fit_campaign(design, runs, model, known)
    sigmas, wider = widening(fit.equations)
    told = Judged(fit.design, wider * np.sqrt(np.diag(fit.covariance)), "")
    return Comparison(fitted_robot(design, model, fit, told, (sigmas, wider), known, twin), model)


def twin_runs(parameters: Parameters, campaign: Campaign, seed: int, count: int) -> Iterator[MeasuredRun | str]:
    """Runs of the twin as drawn, without an outsole, as the ingest reads them."""
    campaign = dataclasses.replace(campaign, runs=dataclasses.replace(campaign.runs, seed=seed))
    walker, point = find_gait(campaign.biped, campaign.slope, 1e-9, None)
    begin = first_state(walk_from_mid_stance(walker, point.z, 1, 1e-9, 1e3)[0])
    walked = (sensed_run(number, walk_twin(number, *begin, campaign, bare=True), campaign, bare=True)
              for number in range(count))
    design = drawn_design(parameters)
    model = first_model(design, looked_for(design), parameters)
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "twin.sqlite"
        source.write_bytes(database_bytes([device(place, campaign) for place in MOUNTING],
                                          ((experiment, sent) for experiment, _, sent in walked)))
        yield from read_runs(source, design, model, parameters)


def most_by_chance(comparison: Comparison, freedom: float = np.inf) -> float:
    """Standard errors, which have a `freedom`, from which on a part says that it is another robot."""
    return -float(stdtrit(freedom, 0.5 * LEVEL * PARTS / len(comparison.parts)))


def change_of(part: Part, comparison: Comparison) -> float:
    """By how much a part changes; one leg's length, of which robots bear .2 %, by what is found with that power."""
    robot, first = comparison.robot, comparison.robot.learned[0]
    there = comparison.model.robot(robot.design, robot.estimate, first.own)
    shifts = comparison.shifts(comparison.evidence(first.run, there, first.unknowns))
    sd = float(shifts[comparison.parts.index(part), 1])
    needed = sd * (most_by_chance(comparison) + float(ndtri(POWER)))
    return needed if part.name.startswith("leg_length of the") else float(np.fmax(needed, SHARE * part.value))


def changed_run(
    comparison: Comparison, campaign: Drawn, parameters: Parameters, part: Part | None, number: int
) -> tuple[MeasuredRun, float]:
    """A further run, with a part that has changed or none, and by how much. Raises StepFailed, NoGait."""
    drawing, model = model_of(parameters)
    rng, there = np.random.default_rng([SEED, number]), campaign.design
    if part is None:
        return _run(there, drawing, model, parameters, number, rng)[0], 0.0
    name, change = part.moves[0], change_of(part, comparison)
    change *= 1.0 if name == FRICTION else rng.choice([-1.0, 1.0])
    if "." in name:
        other = name.replace("biped.", "biped.other_")
        kept = {other: there.value(other)} if part.name.endswith("of the first leg") else {}
        there = there.with_values({**kept, **{one: there.value(one) + change for one in part.moves}})
    run, slope, unknowns = _run(there, drawing, model, parameters, number, rng)
    if name == SLOPE:  # other than it is read off
        reading, sd = run.own[SLOPE]
        run = dataclasses.replace(run, own={SLOPE: (reading - change, sd)})
    if "." not in name:
        unknowns[model.layout.place(name)] += change
        shown = predict(there.with_value(SLOPE, slope), (), unknowns, model.layout, run.sampling, 1e-9)
        run = dataclasses.replace(run, samples={
            side: shown.samples[side][:, :, 0] + np.asarray(model.noise) * rng.normal(size=run.samples[side].shape)
            for side in SIDES})  # fmt: skip
    return run, change


def further(
    comparison: Comparison, campaign: Drawn, parameters: Parameters, part: Part | None, number: int
) -> tuple[MeasuredRun, float]:
    """The same of the first push after which it walks. Raises StepFailed."""
    for again in range(PUSHES):
        with contextlib.suppress(StepFailed, NoGait):
            return changed_run(comparison, campaign, parameters, part, number + 100_000 * again)
    raise StepFailed("it does not walk")


def row_of(comparison: Comparison, part: Part | None, run: MeasuredRun, change: float) -> dict[str, Any]:
    """What is said of a run. Raises StepFailed."""
    begun = time.process_time()
    found = comparison.held(run)
    verdict = comparison.verdict(found)
    best, row = verdict.changes[0], dict[str, Any]()
    if part is not None:
        informed = float(comparison.shifts(found)[comparison.parts.index(part), 1])
        usual = next(one for one in verdict.changes if one.part == part)
        power, less = (float(ndtr(abs(change) / sd - most_by_chance(comparison, freedom)))
                       for sd, freedom in ((informed, np.inf), (usual.sd, usual.freedom)))  # fmt: skip
        row = {"change": change, "share": change / part.value if part.value > 0.0 else None, "power": power,
               "less": less, "off": (best.change - change) / best.sd}
    return row | {"same": verdict.same, "probability": verdict.probability,
                  "named": [one.part.name for one in verdict.named], "best": best.part.name,
                  "top": [[one.part.name, round(one.explains, 1)] for one in verdict.changes[:4]],
                  "residuals": verdict.residuals, "explained": verdict.explained,
                  "seconds": time.process_time() - begun}  # fmt: skip


def rows_of(
    asked: argparse.Namespace, number: int, parameters: Parameters, campaign: Campaign
) -> Iterator[dict[str, Any]]:
    """Of one robot, what is said of each further run."""
    if asked.twin:
        found = list(twin_runs(parameters, campaign, SEED + number, FITTED + asked.unchanged))
        runs = tuple(run for run in found if isinstance(run, MeasuredRun))
        mass = drawn_design(parameters).biped.total_mass
        comparison = robot_of(runs[:FITTED], (Known(TOTAL_MASS, mass, 1e-3 * mass),), parameters, True)
        yield from ({"why": one} for one in found if isinstance(one, str))
        yield from ({"part": None, **row_of(comparison, None, run, 0.0)} for run in runs[FITTED:])
        return
    drawn = draw(SEED + number, FITTED, parameters)
    comparison = robot_of(drawn.runs, drawn.known, parameters, False)
    plan = [*[None] * asked.unchanged, *comparison.parts * asked.changed]
    for place, part in enumerate(plan):
        row: dict[str, Any] = {"part": part and part.name}
        try:
            row |= row_of(comparison, part, *further(comparison, drawn, parameters, part, 1000 * number + place))
        except StepFailed as reason:
            row["why"] = str(reason)
        yield row


def told(rows: list[dict[str, Any]]) -> list[str]:
    """A table as Markdown: of each part how often it was found, and named."""
    held = [row for row in rows if "same" in row]
    usual = [row for row in held if row["part"] is None]
    lines = [f"{sum(not row['same'] for row in usual)} alarms in {len(usual)} unchanged runs; "
             f"{np.mean([row['seconds'] for row in held]):.2f} s of processor time a run held.", "",
             "| part | change | power | with what is usual | found | alone at the top | of these right | right or not "
             "told apart |", "|---|---|---|---|---|---|---|---|"]  # fmt: skip
    parts = defaultdict(list)
    for row in held:
        if row["part"] is not None:
            parts[row["part"]].append(row)
    for name, each in parts.items():
        found = [row for row in each if not row["same"]]
        alone = [row for row in found if len(row["named"]) == 1]
        change = (f"{100 * np.median([abs(row['share']) for row in each]):.2g} %" if each[0]["share"] is not None
                  else f"{np.median([abs(row['change']) for row in each]):.2g}")
        lines.append(f"| {name} | {change} | {np.median([row['power'] for row in each]):.2f} | "
                     f"{np.median([row['less'] for row in each]):.2f} | "
                     f"{len(found)}/{len(each)} | {len(alone)} | {sum(row['best'] == name for row in alone)} | "
                     f"{sum(name in row['named'] for row in found)} |")
    fell = [row for row in rows if "same" not in row]
    return lines + [f"{len(fell)} runs could not be walked or held." if fell else ""]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0, help="number of the first robot")
    parser.add_argument("--robots", type=int, default=6)
    parser.add_argument("--unchanged", type=int, default=25, help="runs of each robot")
    parser.add_argument("--changed", type=int, default=6, help="runs of each robot and part")
    parser.add_argument("--steps", type=int, default=7)
    parser.add_argument("--twin", action="store_true", help="runs of the Exudyn twin")
    parser.add_argument("--params", type=Path, default=ROOT / "params")
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--keep", type=Path, default=None)
    asked = parser.parse_args()
    parameters, rows = settings(asked.steps, asked.set, asked.params), list[dict[str, Any]]()
    every = Study(ROOT, asked.params, ROOT / "results", (*ONE_MACHINE, *asked.set))
    campaign: Campaign = every.parameters(["campaign"])["campaign"]
    for number in range(asked.first, asked.first + asked.robots):
        for row in rows_of(asked, number, parameters, campaign):
            rows.append({"robot": number, **row})
            if asked.keep:
                with asked.keep.open("a") as file:
                    file.write(json.dumps(rows[-1]) + "\n")
    print("\n".join(told(rows)))


if __name__ == "__main__":
    main()
