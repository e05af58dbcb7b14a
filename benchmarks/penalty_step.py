"""The penalty model over two steps: time against error of the solvers, and what a contact law in Python costs.

    python benchmarks/penalty_step.py

All walk from the same mid-stance with the contact set of params/ground.yaml for one second. Errors are the largest
difference of the hip's position from the tree assembly at tolerance 1e-11. Time is processor time per simulated
second, the best of several runs; 1 is real time.
"""

import dataclasses
import time

import numpy as np

from pipeline.parameters.loading import load
from pipeline.study import locate
from stages.biped.walk import StanceState
from stages.contact_study.parameters import Parameters as ContactStudy
from stages.multibody.parameters import Parameters, Settings
from stages.multibody.walking.walk import build, simulate
from stages.planar.run import Run, rolling_state

DURATION = 1.0
#: Close to the gait's mid-stance, so that two steps are walked; the numbers are no result of the study.
START = StanceState(0.0, 0.331, 0.27, 0.334, 0.71, 0.0, 1.8, 0.0)
STANDING_FORCE = 9.4


def parameters() -> Parameters:
    """The study's own parameters of the multibody stage."""
    return load(locate().params, [], {"multibody": Parameters}, [Parameters, ContactStudy])["multibody"]


def walk(given: Parameters, settings: Settings, *, compiled: bool = True) -> tuple[Run, float]:
    """A walk and its processor time [s], without building the assembly."""
    state = rolling_state(given.biped, given.contact, START, STANDING_FORCE)
    machine = build(given.biped, given.slope, given.contact, settings, compiled=compiled)
    began = time.process_time()
    run = simulate(given.biped, given.slope, given.contact, state, settings, duration=DURATION, assembly=machine)
    return run, time.process_time() - began


def main() -> None:
    given = parameters()
    base = dataclasses.replace(given.settings, assembly="tree", largest_step=2e-3)
    exact = walk(given, dataclasses.replace(base, tolerance=1e-11, largest_step=2e-4))[0].trajectory
    grid = np.linspace(0.0, DURATION, 5000)
    truth = exact.at(grid)[0][:, :2]

    def row(name: str, settings: Settings, rounds: int, compiled: bool = True) -> float:
        runs = [walk(given, settings, compiled=compiled) for _ in range(rounds)]
        run, seconds = runs[0][0], min(spent for _, spent in runs) / DURATION
        error = np.abs(run.trajectory.at(np.minimum(grid, run.trajectory.time[-1]))[0][:, :2] - truth).max()
        drift = f"{run.joint_drift:10.0e}" if settings.assembly == "joints" else f"{'-':>10}"
        cost = f"{run.solver_steps:9d}{error:10.1e}{seconds:10.3f}{1 / seconds:12.1f}{drift}"
        print(f"{name:52}{cost}  {run.outcome}", flush=True)
        return seconds

    print(f"{'':52}{'steps':>9}{'hip error':>10}{'s per s':>10}{'x real time':>12}{'drift':>10}")
    for tolerance in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9):
        settings = dataclasses.replace(base, tolerance=tolerance)
        row(f"tree, adaptive, tolerance {tolerance:.0e}", settings, 5)
    settings = dataclasses.replace(base, tolerance=1e-6)
    compiled = row("tree, adaptive, 1e-06, compiled contact law", settings, 5)
    called = row("tree, adaptive, 1e-06, contact law called in Python", settings, 3, compiled=False)
    print(f"{'':4}Python law / compiled law: {called / compiled:.2f}")
    joints = dataclasses.replace(base, assembly="joints")
    for rolling, impact in ((4e-4, 1e-5), (2e-4, 2e-5), (2e-4, 1e-5), (1e-4, 5e-6)):
        settings = dataclasses.replace(joints, rolling_step=rolling, impact_step=impact)
        row(f"joints, {rolling:.0e} s, {impact:.0e} s around heel strike", settings, 1)
    for step in (1e-4, 2e-5, 1e-5):
        row(f"joints, {step:.0e} s throughout", dataclasses.replace(joints, rolling_step=step, impact_step=step), 1)


if __name__ == "__main__":
    main()
