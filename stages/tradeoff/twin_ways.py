"""Ways to walk the spatial twin: one solver at several tolerances, its ground compiled or made of connectors."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from stages.biped.design import Biped
from stages.biped.gait import StanceState
from stages.biped.largest import largest
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.tradeoff.way import Walked, Way, WayFailed, grid
from stages.twin.machine.contact import X, Y, along, point_law
from stages.twin.machine.machine import Machine, build
from stages.twin.machine.tree import SpatialTree
from stages.twin.parameters import Settings
from stages.twin.walking.events import find_events
from stages.twin.walking.record import Record
from stages.twin.walking.signals import PAIRS
from stages.twin.walking.simulate import Start, rolling_start, simulate_twin

TWIN = "twin"
COMPILED, CONNECTORS = "Exudyn tree in space, DOPRI5", "Exudyn tree in space, DOPRI5, eight connectors"


@dataclass(frozen=True)
class Scene:
    """The machine on its ground, its mid-stance, and how far it walks."""

    machine: Machine
    slope: Slope
    contact: ContactLaw
    settings: Settings
    start: Start
    steps: int


def scene(biped: Biped, slope: Slope, contact: ContactLaw, settings: Settings, stance: StanceState, force: float,
          steps: int) -> Scene:
    """The twin's scene. Raises ValueError if its parts do not add up to the design."""
    machine = build(biped, settings)
    start = rolling_start(machine, contact, stance, force)
    return Scene(machine, slope, contact, settings, start, steps)


def twin_way(at: Scene, tolerance: float, largest_step: float, kind: type[SpatialTree] = SpatialTree,
             mark: str = "") -> Way:
    """The twin at one tolerance and largest step [s]."""
    settings = dataclasses.replace(at.settings, tolerance=tolerance, largest_step=largest_step)
    built: list[Any] = []

    def integrate() -> Record:
        if not built:
            built.append(kind(at.machine, at.slope, at.contact))
        return simulate_twin(at.machine, at.slope, at.contact, at.start, settings, steps=at.steps, tree=built[0])

    def walk() -> Walked:
        record = integrate()
        if not record.completed:
            raise WayFailed(record.reason or record.outcome)
        strikes = find_events(record).heel_strike_time
        hip = record.at(grid(float(record.time[-1])))[0][:, [X, Y]]
        peak, cost = peak_force(record), record.evaluations / at.steps
        return Walked(hip, float(strikes[-1]), float(strikes[-1] - strikes[-2]), peak, cost)

    name = COMPILED if kind is SpatialTree else CONNECTORS
    return Way(TWIN, name, {"tolerance": tolerance, "largest_step": largest_step}, integrate, walk, None, mark)


def peak_force(record: Record) -> float:
    """Largest normal force on a pair of feet [N], between the solver's steps by the contact law."""
    law = point_law(record.contact)

    def normal(time: np.ndarray, pair: slice) -> np.ndarray:
        forces = along(*record.at(time), record.in_play(time), record.machine.feet, law)[0]
        return np.asarray(forces[:, pair, Y].sum(axis=1))

    return max(largest(record.time, normal(record.time, pair), partial(normal, pair=pair))[1] for pair in PAIRS)
