"""What each element of a scene adds: solver steps, time, recorded bytes, and what it changes in the answer.

Two steps of the study's biped with the study's contact set from the same mid-stance. Every row changes one thing of the
row it is measured against, whose time is taken anew beside it. Time: processor time, the least of three.
Run: python -m benchmarks.scene_cost [--into docs/scenes.md]
"""

from __future__ import annotations

import dataclasses
import datetime
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.everything_on import MARK
from pipeline.parameters.loading import load
from stages.biped.gait import StanceState
from stages.extremes.parameters import Parameters
from stages.extremes.penalty_points import mid_stance
from stages.ground.friction import lanes
from stages.multibody.assembly.inventory import Inventory, take_inventory
from stages.multibody.walking.walk import build, simulate
from stages.planar.run import rolling_state
from stages.planar.sampling import sample
from stages.planar.signals import GROUND_REACTION, IMU, SIGNALS
from stages.twin.machine.machine import build as build_machine
from stages.twin.machine.tree import SpatialTree
from stages.twin.walking.record import find_events as find_spatial_events
from stages.twin.walking.simulate import rolling_start, simulate_twin

STEPS, REPEATS, BLOCK_SPACING = 2, 3, 0.1612
#: Changes of time [s] and place [m] below this do not show in the table.
SEEN = 5e-7
ROOT = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Cost:
    """One scene: how it ended, solver steps, seconds, inventory, and when and where its last heel strike was."""

    outcome: str
    steps: int
    seconds: float
    inventory: Inventory
    strike: float
    place: float


def least(run: Callable[[], Any]) -> tuple[Any, float]:
    """A run's result and the least of its processor times [s]."""
    times = []
    for _ in range(REPEATS):
        began = time.process_time()
        result = run()
        times.append(time.process_time() - began)
    return result, min(times)


def planar(here: Parameters, stance: StanceState, force: float, blocks: bool = False, compiled: bool = True,
           signals: tuple[str, ...] = SIGNALS) -> Cost:
    """A planar scene."""
    lane = lanes(BLOCK_SPACING, here.multibody.block_length) if blocks else None
    machine = build(here.biped, here.slope, here.contact, here.multibody, lane, compiled=compiled,
                    signals=signals)
    start = rolling_state(here.biped, here.contact, stance, force)

    def run() -> Any:
        return simulate(here.biped, here.slope, here.contact, start, here.multibody, steps=STEPS, lanes=lane,
                        assembly=machine)  # fmt: skip

    walked, seconds = least(run)
    trajectory = walked.trajectory
    strikes = sample(trajectory, here.biped, here.slope, 100.0).heel_strike_time
    strike = float(strikes[STEPS - 1]) if len(strikes) >= STEPS else np.nan
    place = float(trajectory.at(np.array([strike]))[0][0, 0]) if strike == strike else np.nan
    return Cost(walked.outcome, walked.solver_steps, seconds, take_inventory(machine.mbs), strike, place)


def spatial(here: Parameters, stance: StanceState, force: float) -> Cost:
    """The twin's scene."""
    machine = build_machine(here.biped, here.twin)
    tree = SpatialTree(machine, here.slope, here.contact)
    start = rolling_start(machine, here.contact, stance, force)
    record, seconds = least(
        lambda: simulate_twin(machine, here.slope, here.contact, start, here.twin, steps=STEPS, tree=tree)
    )
    strikes = find_spatial_events(record, machine.feet).heel_strike_time
    strike = float(strikes[STEPS - 1]) if len(strikes) >= STEPS else np.nan
    place = float(record.at(np.array([strike]))[0][0, 0]) if strike == strike else np.nan
    return Cost(record.outcome, len(record.time) - 1, seconds, take_inventory(tree.mbs, len(tree.feet)), strike, place)


def sampling(here: Parameters, stance: StanceState, force: float) -> list[tuple[str, float, int]]:
    """Time [s] and bytes of sampling the walk at several rates."""
    start = rolling_state(here.biped, here.contact, stance, force)
    run = simulate(here.biped, here.slope, here.contact, start, here.multibody, steps=STEPS)
    rows = []
    for rate in (100.0, 2000.0, 20000.0):
        walk, seconds = least(lambda rate=rate: sample(run.trajectory, here.biped, here.slope, rate))
        size = sum(np.asarray(getattr(walk, field.name)).nbytes for field in dataclasses.fields(walk))
        rows.append((f"sampling at {rate:g} Hz", seconds, size))
    return rows


def scenes(base: Parameters) -> list[tuple[str, Cost, Cost]]:
    """(what is added or changed, cost with it, cost of what it is measured against)."""
    stance, force = mid_stance(base.biped, base.slope)

    def at(*changes: tuple[str, Any]) -> Parameters:
        return base.changed(changes)

    plain = planar(base, stance, force)
    stiff = at(("ground.contact_stiffness", 10 * base.contact.contact_stiffness))
    coulomb, creeping = at(("ground.friction", "coulomb")), at(("ground.stiction_velocity", 0.003))
    rigid = at(("biped.legs", "rigid"))
    rigid_stance = dataclasses.replace(
        stance, stance_length=base.biped.leg_length, swing_length=base.biped.leg_length,
        stance_length_rate=0.0, swing_length_rate=0.0,
    )  # fmt: skip
    point_masses = spatial(at(("twin.inertia", "planar")), stance, force)
    bare = planar(base, stance, force, signals=())
    return [
        ("ground reaction recorded (against the motion alone)", planar(base, stance, force, signals=(GROUND_REACTION,)),
         bare),
        ("foot's sensor recorded (against the motion alone)", planar(base, stance, force, signals=(IMU,)), bare),
        ("springs in the legs (against rigid legs)", plain, planar(rigid, rigid_stance, force)),
        ("stepping blocks (against the ideal ground)", planar(base, stance, force, blocks=True), plain),
        ("Stribeck friction (against Coulomb's, regularised)", plain, planar(coulomb, stance, force)),
        ("restitution law (against IMPACT)", planar(at(("ground.normal_force", "restitution")), stance, force), plain),
        ("creep: stiction velocity 30 to 3 mm/s", planar(creeping, stance, force), plain),
        ("contact 10 times as stiff", planar(stiff, stance, force), plain),
        ("contact law in Python (against compiled)", planar(base, stance, force, compiled=False), plain),
        ("bodies and joints (against the tree)", planar(at(("multibody.assembly", "joints")), stance, force), plain),
        ("space and a second pair of feet (against the plane)", point_masses, plain),
        ("parts' inertia (against point masses)", spatial(base, stance, force), point_masses),
    ]  # fmt: skip


def report() -> str:
    """The tables as Markdown."""
    base = load(ROOT / "params", [], {"extremes": Parameters}, [Parameters])["extremes"]
    base = base.changed((("multibody.tolerance", 1e-7), ("twin.tolerance", 1e-7)))
    lines = [
        "# What a scene's elements cost\n",
        "Made by `benchmarks/scene_cost.py`: two steps from the same mid-stance at tolerance 1e-7. A row is measured",
        "against the scene in brackets. Changes are of the second heel strike: its time and the hip's place.\n",
        f"Exudyn {version('exudyn')}, {datetime.date.today()}, on a machine busy with other work: times are ratios to",
        "read within a third; solver steps and bytes are exact. The joints pause to change their step:",
        "what they recorded is the last stretch.\n",
        "| element | bodies | coordinates | contact pairs | solver steps | time | recorded | heel strike | hip there |",
        "|" + " --- |" * 9,
    ]
    moved = []
    for words, cost, against in scenes(base):
        held = cost.inventory
        moved.append((words, max(abs(cost.strike - against.strike), abs(cost.place - against.place)) >= SEEN))
        size = held.recorded_bytes
        early = "" if cost.outcome == against.outcome == "completed" else f" ({cost.outcome}, {against.outcome})"
        lines.append(
            f"| {words}{early} | {held.bodies} | {held.coordinates} | {held.contact_pairs} "
            f"| {cost.steps} ({cost.steps / against.steps:.2f} times) | {cost.seconds / against.seconds:.2f} times "
            f"| {size / 1e3:.0f} kB ({size / against.inventory.recorded_bytes:.2f} times) "
            f"| {1e3 * (cost.strike - against.strike):+.3f} ms | {1e3 * (cost.place - against.place):+.3f} mm |"
        )
    lines += ["\n| sampling, after the run | time | size |", "| --- | --- | --- |"]
    stance, force = mid_stance(base.biped, base.slope)
    for words, seconds, size in sampling(base, stance, force):
        lines.append(f"| {words} | {1e3 * seconds:.1f} ms | {size / 1e3:.0f} kB |")
    alike, other = ([words for words, changes in moved if changes is which] for which in (False, True))
    lines += [
        f"\nBelow {SEEN:g} s and {SEEN:g} m, so that a default scene leaves it out or takes the cheaper of both:",
        f"{'; '.join(alike)}.",
        f"\nWhat changes the answer, and is in the scene where the design has it: {'; '.join(other)}.",
    ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    text = report()
    if "--into" in sys.argv:
        page = Path(sys.argv[sys.argv.index("--into") + 1])
        _, mark, rest = page.read_text(encoding="utf-8").partition(MARK)  # those are of benchmarks/everything_on.py
        page.write_text(text + ("\n" + mark + rest if mark else ""), encoding="utf-8")
    else:
        print(text)
