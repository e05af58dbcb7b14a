"""Whether an accuracy asked for is met on any design.

`python -m benchmarks.accuracy_requests [seed] [designs]` draws designs (every number of Table 1 within 30 %, 1 to 4
degrees) and asks each for an error of the hip and for one of the step's duration, both drawn too. The true error is
that against a run with the finest settings, from its own finest gait. A line each; then the counts. Some minutes.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.study import Study
from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.run import run as run_analytic
from stages.biped.accuracy.estimate import NotMet, walk_differences
from stages.biped.walk import Walk
from stages.multibody.run import walk_to_accuracy
from stages.planar.run import rolling_state

ROOT = Path(__file__).resolve().parents[1]
STAGES = ("analytic", "multibody")
VARIED = {"hip_mass": 0.316, "foot_mass": 0.335, "leg_length": 0.333, "foot_radius": 0.083, "foot_com": 0.1,
          "stiffness": 2800.0, "damping": 58.35}  # fmt: skip
FINEST = {"analytic": {"tolerance": 1e-14}, "multibody": {"tolerance": 1e-11, "largest_step": 2e-4}}


def drawn(seed: int, index: int) -> tuple[tuple[str, ...], dict[str, float]]:
    """Settings of design `index` as `--set` takes them, and what is asked of it."""
    rng = np.random.default_rng([seed, index])
    values = {f"biped.{key}": value * rng.uniform(0.7, 1.3) for key, value in VARIED.items()}
    values["ground.slope_deg"] = rng.uniform(1.0, 4.0)
    asked = {"hip_position_m": 10 ** rng.uniform(-7, -3), "period_s": 10 ** rng.uniform(-8, -4)}
    return tuple(f"{key}={value!r}" for key, value in values.items()), asked


def parameters(settings: tuple[str, ...], asked: str) -> dict[str, Any]:
    """The parameters of both stages as the command line makes them."""
    request = (("accuracy", asked),) if asked else ()
    return dict(Study(ROOT, ROOT / "params", ROOT / "results", settings, requested=request).parameters(STAGES))


def walks(own: dict[str, Any], stages: tuple[str, ...] = STAGES) -> dict[str, Walk | str]:
    """The walk of each stage, or why it is refused."""
    try:
        analytic = run_analytic(own["analytic"])
    except NotMet as refusal:
        return dict.fromkeys(stages, str(refusal))
    found: dict[str, Walk | str] = {"analytic": analytic.walk}
    values = own["multibody"]
    state = rolling_state(values.biped, values.contact, analytic.mid_stance, analytic.walk.standing_force)
    try:
        found["multibody"] = walk_to_accuracy(values, state, analytic.gait.step_length_m)[1][2]
    except NotMet as refusal:
        found["multibody"] = str(refusal)
    return found


def finest(own: dict[str, Any]) -> dict[str, Any]:
    """The parameters with the finest settings of the solvers."""
    return {stage: replace(values, settings=replace(values.settings, **FINEST[stage])) for stage, values in own.items()}


def main() -> None:
    """Print each request and what came of it, and the counts."""
    seed, designs = (int(text) for text in (sys.argv[1:] + ["1", "20"][len(sys.argv) - 1 :]))
    counts: Counter[tuple[str, str]] = Counter()
    index = walking = 0
    while walking < designs:
        settings, requests = drawn(seed, index)
        index += 1
        try:
            exact = walks(finest(parameters(settings, "")))
        except (NoGait, StepFailed) as refusal:
            counts["design", "without a gait"] += 1
            print(f"{index - 1}: {str(refusal)[:90]}", flush=True)
            continue
        walking += 1
        for key, error in requests.items():
            began = time.process_time()
            for stage, walk in walks(parameters(settings, f"{key}={error!r}")).items():
                reference = exact[stage]
                if isinstance(walk, str) or isinstance(reference, str):
                    verdict, said = "refused", str(walk)
                else:
                    true = walk_differences(walk, reference)[key]
                    verdict, said = ("met" if true <= error else "MISSED"), f"true {true:.1e}"
                counts[stage, verdict] += 1
                print(f"{index - 1} {stage}: {key} {error:.1e} {verdict}: {said}", flush=True)
            print(f"   {time.process_time() - began:.1f} s", flush=True)
    for (stage, verdict), number in sorted(counts.items()):
        print(f"{stage} {verdict}: {number}")


if __name__ == "__main__":
    main()
