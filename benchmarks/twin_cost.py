"""What a simulated second of the twin costs beside the planar model, and where the time goes.

    python benchmarks/twin_cost.py

All walk two steps from the same mid-stance at the same tolerance. Time is processor time, the best of three walks, so
that other work on the machine disturbs it least. The rows below the line share out the twin's time: calls of the
compiled ground and of the watch are counted in the walk and timed on their own, the rest is Exudyn's.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.parameters.loading import load
from stages.biped.walk import StanceState
from stages.contact_study.parameters import Parameters as ContactStudy
from stages.multibody.parameters import Parameters as PlanarParameters
from stages.multibody.walking.walk import build as build_planar
from stages.multibody.walking.walk import simulate
from stages.planar.run import rolling_state
from stages.twin.machine.contact import clearances
from stages.twin.machine.machine import build
from stages.twin.machine.tree import ConnectorTree, SpatialTree
from stages.twin.parameters import Parameters
from stages.twin.walking.simulate import rolling_start, simulate_twin

START = StanceState(0.0, 0.331, 0.27, 0.334, 0.71, 0.0, 1.8, 0.0)
FORCE, STEPS, TOLERANCE, LARGEST = 9.4, 2, 1e-7, 2e-3
PARAMS = Path(__file__).parent.parent / "params"


class CountingTree(SpatialTree):
    """A tree that counts how often the solver asks for the ground's forces."""

    calls = 0

    def add_ground(self) -> None:
        super().add_ground()
        ground = self.ground

        def counted(*arguments: Any) -> np.ndarray:
            self.calls += 1
            return ground(*arguments)

        self.counted = counted
        self.mbs.SetObjectParameter(self.tree, "forceUserFunction", counted)


def best(call: Callable[[], Any], rounds: int = 3) -> tuple[float, Any]:
    """Processor time [s] of the best round, and what the call returned; a round before them warms up."""
    found, times = call(), []
    for _ in range(rounds):
        began = time.process_time()
        found = call()
        times.append(time.process_time() - began)
    return min(times), found


def main() -> None:
    """Print the table."""
    wanted = {"multibody": PlanarParameters, "twin": Parameters}
    loaded = load(PARAMS, [], wanted, [*wanted.values(), ContactStudy])
    planar, twin = loaded["multibody"], loaded["twin"]
    biped, slope, contact = twin.biped, twin.slope, twin.contact
    flat = dataclasses.replace(planar.settings, assembly="tree", tolerance=TOLERANCE, largest_step=LARGEST)
    assembly, state = build_planar(biped, slope, contact, flat), rolling_state(biped, contact, START, FORCE)
    spent, run = best(lambda: simulate(biped, slope, contact, state, flat, steps=STEPS, assembly=assembly))
    print(f"{'model':<34}{'s per simulated s':>18}{'solver steps per s':>20}")
    row("planar checker", spent, run.trajectory.time)

    settings = dataclasses.replace(twin.settings, tolerance=TOLERANCE, largest_step=LARGEST)
    machine = build(biped, settings)
    start = rolling_start(machine, contact, START, FORCE)
    for name, tree in (("twin, compiled ground", SpatialTree), ("twin, eight connectors", ConnectorTree)):
        system = tree(machine, slope, contact)
        spent, record = best(
            lambda: simulate_twin(machine, slope, contact, start, settings, steps=STEPS, tree=system)  # noqa: B023
        )
        row(name, spent, record.time)
        if tree is SpatialTree:
            whole, simulated, watched = spent, float(record.time[-1]), len(record.time)

    counting = CountingTree(machine, slope, contact)
    simulate_twin(machine, slope, contact, start, settings, steps=STEPS, tree=counting)
    q, v = start.position.tolist(), start.velocity.tolist()
    force, _ = best(lambda: [counting.ground(None, 0.0, 0, q, v) for _ in range(2000)])
    look, _ = best(lambda: [clearances(start.position, machine.feet) for _ in range(2000)])
    ground, watch = counting.calls * force / 2000, watched * look / 2000
    print("-" * 72)
    for name, part in (
        (f"ground, {counting.calls} calls", ground),
        (f"clearances for the watch, {watched} calls", watch),
        ("Exudyn's tree, solver, sensors", whole - ground - watch),
    ):
        print(f"{name:<34}{part / simulated:>18.3f}{part / whole:>19.0%}")


def row(name: str, spent: float, times: np.ndarray) -> None:
    """One line of the table."""
    simulated = float(times[-1])
    print(f"{name:<34}{spent / simulated:>18.3f}{(len(times) - 1) / simulated:>20.0f}")


if __name__ == "__main__":
    main()
