"""How often `same` calls a robot another one that is not, finds a part that has changed by 1 %, and names it.

python -m benchmarks.same_robot --robots 5 --unchanged 40 --changed 2 --keep same.jsonl

Robots are drawn and fitted on nine runs of the model's own kind; their further runs are held to them one by one.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import ndtr, ndtri

from pipeline.study import Study
from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.calibration.blind_score import Drawn, _run, draw, model_of
from stages.calibration.estimation.campaign import fit_campaign
from stages.calibration.following.change import LEVEL, PARTS, Comparison, Part
from stages.calibration.following.fitted import fitted_robot
from stages.calibration.information.identifiability import first_model, free_names
from stages.calibration.intervals.left_out import FRICTION
from stages.calibration.intervals.model_error import Judged, widening
from stages.calibration.observation.measured_run import SIDES
from stages.calibration.observation.prediction import predict
from stages.calibration.parameters import Parameters
from stages.calibration.recordings import as_mounted, guess

ROOT = Path(__file__).resolve().parent.parent
SHARE, FITTED, SEED, PUSHES = 0.01, 9, 4000, 5
#: One leg's length, of which Table 1's robot bears .2 %.
OF_ONE_LEG = 5e-4
#: Where a part has no value: friction in weights times leg lengths, a sensor moved in leg lengths or turned [rad].
OF_FRICTION, OF_PLACE, OF_TILT = 1e-3, 0.01, 0.01


def settings(steps: int, given: list[str]) -> Parameters:
    """The study's, with legs that have an inertia and sensors that stay where they are."""
    every = Study(ROOT, ROOT / "params", ROOT / "results", ("biped.leg_inertia=8.576e-4", *given))
    found: Parameters = every.parameters(["calibration"])["calibration"]
    return as_mounted(dataclasses.replace(found, settings=dataclasses.replace(found.settings, planned_steps=steps)))


def robot_of(campaign: Drawn, parameters: Parameters) -> Comparison:
    """The robot that its first runs are fitted by."""
    design = guess(parameters)
    model = first_model(design, free_names(design), parameters)
    fit = fit_campaign(design, campaign.runs, model, campaign.known)
    sigmas, wider = widening(fit.equations)
    told = Judged(fit.design, wider * np.sqrt(np.diag(fit.covariance)), "")
    robot = fitted_robot(design, model, fit, told, (sigmas, wider), tuple(campaign.known), False)
    return Comparison(robot, model)


def change_of(part: Part, design: DesignPoint) -> float:
    """By how much a part changes."""
    biped, name = design.biped, part.moves[0]
    if name == FRICTION:
        return OF_FRICTION * biped.total_mass * design.slope.gravity * biped.leg_length
    if "." in name:
        one_leg = name.endswith("leg_length") and len(part.moves) == 1
        return (OF_ONE_LEG if one_leg else SHARE) * design.value(name)
    return OF_PLACE * biped.leg_length if name == "foot_place" else OF_TILT


def held(comparison: Comparison, campaign: Drawn, parameters: Parameters, part: Part | None, number: int
         ) -> dict[str, Any]:  # fmt: skip
    """A further run, with a part that has changed or none, held to the robot."""
    drawing, model = model_of(parameters)
    rng, there = np.random.default_rng([SEED, number]), campaign.design
    change = 0.0 if part is None else change_of(part, there)
    if part is not None and "." in part.moves[0]:
        other = part.moves[0].replace("biped.", "biped.other_")
        kept = {other: there.value(other)} if part.name.endswith("of the first leg") else {}
        there = there.with_values({**kept, **{name: there.value(name) + change for name in part.moves}})
    for left in reversed(range(PUSHES)):
        try:
            run, slope, unknowns = _run(there, drawing, model, parameters, number, rng)
            break
        except (StepFailed, NoGait) as reason:  # pushed too hard, or too odd to walk
            if not left:
                return {"part": part and part.name, "why": str(reason)}
    if part is not None and "." not in part.moves[0]:
        unknowns[model.layout.place(part.moves[0])] += change
        shown = predict(there.with_value("ground.slope_deg", slope), (), unknowns, model.layout, run.sampling, 1e-9)
        run = dataclasses.replace(run, samples={
            side: shown.samples[side][:, :, 0] + np.asarray(model.noise) * rng.normal(size=run.samples[side].shape)
            for side in SIDES})  # fmt: skip
    try:
        found = comparison.held(run)
    except StepFailed as reason:
        return {"part": part and part.name, "why": str(reason)}
    verdict, plain = comparison.verdict_of(found), comparison.verdict(found.evidence)
    sds = {one.part.name: one.sd for one in plain.changes}
    most = -float(ndtri(0.5 * LEVEL * PARTS / len(comparison.parts)))
    best = verdict.changes[0]
    return {"part": part and part.name, "same": verdict.same, "probability": verdict.probability,
            "power": None if part is None else float(ndtr(change / sds[part.name] - most)),
            "strength": None if part is None else change / sds[part.name],
            "named": [one.part.name for one in verdict.named], "best": best.part.name,
            "top": [[one.part.name, round(one.explains, 1)] for one in verdict.changes[:4]],
            "off": (best.change - change) / best.sd, "residuals": verdict.residuals}  # fmt: skip


def told(rows: list[dict[str, Any]]) -> list[str]:
    """A table as Markdown: of each part how often it was found, and named."""
    usual = [row for row in rows if row["part"] is None and "same" in row]
    lines = [f"{sum(not row['same'] for row in usual)} alarms in {len(usual)} unchanged runs.", "",
             "| part | strength | power | found | alone at the top | of these right | right or not to be parted |",
             "|---|---|---|---|---|---|---|"]  # fmt: skip
    parts = defaultdict(list)
    for row in rows:
        if row["part"] is not None and "same" in row:
            parts[row["part"]].append(row)
    for name, each in parts.items():
        found = [row for row in each if not row["same"]]
        alone = [row for row in found if len(row["named"]) == 1]
        lines.append(
            f"| {name} | {np.median([row['strength'] for row in each]):.1f} | "
            f"{np.median([row['power'] for row in each]):.2f} | {len(found)}/{len(each)} | {len(alone)} | "
            f"{sum(row['best'] == name for row in alone)} | {sum(name in row['named'] for row in found)} |")
    fell = [row for row in rows if "same" not in row]
    return lines + [f"{len(fell)} runs could not be walked or held." if fell else ""]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0, help="number of the first robot")
    parser.add_argument("--robots", type=int, default=5)
    parser.add_argument("--unchanged", type=int, default=40, help="runs of each robot")
    parser.add_argument("--changed", type=int, default=2, help="runs of each robot and part")
    parser.add_argument("--steps", type=int, default=7)
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--keep", type=Path, default=None)
    asked = parser.parse_args()
    parameters, rows = settings(asked.steps, asked.set), []
    for robot in range(asked.first, asked.first + asked.robots):
        campaign = draw(SEED + robot, FITTED, parameters)
        comparison = robot_of(campaign, parameters)
        plan: list[Part | None] = [part for part in comparison.parts for _ in range(asked.changed)]
        for number, part in enumerate([*plan, *[None] * asked.unchanged]):
            rows.append({"robot": robot, **held(comparison, campaign, parameters, part, 1000 * robot + number)})
            if asked.keep:
                with asked.keep.open("a") as file:
                    file.write(json.dumps(rows[-1]) + "\n")
    print("\n".join(told(rows)))


if __name__ == "__main__":
    main()
