"""What the contact study hands on of the rigid limit: distances of contact sets from it, and the search."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.ground.contact_law import ContactLaw

#: Keys that the search varies together.
SEARCHED = ("contact_stiffness", "contact_damping", "damping_depth", "stiction_velocity")
#: Parts of a difference from the rigid limit, see `stages.contact_study.distance`.
PARTS = ("creep", "impact", "rest")
COMPLETED = "completed"
#: Outcome of a set that takes more solver steps than a choice may take.
TOO_DEAR = "too dear"
#: Sets of the search that a table shows.
BEST = 12
LAWS = ("k_c N/mm^e", "c_max N s/m", "d m", "v_s m/s")


@dataclass(frozen=True)
class Distance:
    """How far a contact set is from the rigid limit: the constraint model with Coulomb's transition.

    Differences are penalty model minus limit, over one step from the common mid-stance state and between solved cycles.
    `*_parts` split them into `PARTS`, each measured by itself; a score adds the sizes of the parts, each in its limit,
    and is infinite where a part is not known. NaN where a step or a cycle is not known.
    """

    law: ContactLaw = quantity("-", "the contact law")
    outcome: str = quantity("-", "completed, too dear, or why the step ended early")
    evaluations: int = quantity("1", "evaluations of the rates over one step at cost_tolerance: the cost")
    hip_position: np.ndarray = quantity("m", "largest hip position difference in x and y, with the step's end, (2,)")
    hip_velocity: np.ndarray = quantity("m/s", "largest hip velocity difference outside the impact, shape (2,)")
    end_position: np.ndarray = quantity("m", "hip position difference, with its sign, at the step's end, shape (2,)")
    position_parts: np.ndarray = quantity("m", "largest hip position difference of each part, in x or y, shape (3,)")
    velocity_parts: np.ndarray = quantity("m/s", "largest hip velocity difference of each part, shape (3,)")
    step_score: float = quantity("1", "distance over one step")
    cycle_outcome: str = quantity("-", "completed, not sought, or why no cycle was found")
    period: float = quantity("s", "difference of the cycles' step periods, with its sign", symbol="T")
    step_length: float = quantity("m", "difference of the cycles' step lengths, with its sign", symbol="s")
    period_parts: np.ndarray = quantity("s", "that of the periods in parts, shape (3,)")
    length_parts: np.ndarray = quantity("m", "that of the lengths in parts, shape (3,)")
    cycle_score: float = quantity("1", "distance between cycles")

    @property
    def score(self) -> float:
        """Distance over one step and between cycles."""
        return self.step_score + self.cycle_score


@dataclass(frozen=True)
class HardLimit:
    """What no contact parameter removes: the constraint model with Coulomb's transition minus that of rolling feet."""

    hip_position: np.ndarray = quantity("m", "largest hip position difference in x and y, with the step's end, (2,)")
    hip_velocity: np.ndarray = quantity("m/s", "largest hip velocity difference outside the impact, shape (2,)")
    end_position: np.ndarray = quantity("m", "hip position difference, with its sign, at the step's end, shape (2,)")
    period: float = quantity("s", "difference of the gaits' step periods, with its sign", symbol="T")
    step_length: float = quantity("m", "difference of the gaits' step lengths, with its sign", symbol="s")
    limit_period: float = quantity("s", "step period with Coulomb's transition")
    limit_step_length: float = quantity("m", "step length with Coulomb's transition")


@dataclass(frozen=True)
class RigidLimit:
    """Distances of contact sets from the rigid limit, and of the limit from rolling feet."""

    hard: HardLimit = quantity("-", "the limit itself against rolling feet")
    default: Distance = quantity("-", "the starting set")
    chosen: Distance = quantity("-", "the set that the criterion chooses")
    ground: Distance = quantity("-", "the set of ground.yaml, which the other stages use")
    most_evaluations: float = quantity("1", "evaluations that a chosen set may take over one step")
    finalists: tuple[Distance, ...] = quantity("-", "the sets of the search compared between cycles, best first")
    family_share: np.ndarray = quantity("1", "what is left of impact and creep of the chosen set, shape (f,)")
    family: tuple[Distance, ...] = quantity("-", "the chosen set's family at these shares, towards the limit")


@dataclass(frozen=True)
class Candidates:
    """The contact sets that the search tried, one a row, over one step from the rigid limit; NaN as in `Distance`."""

    contact_stiffness: np.ndarray = quantity("N/mm^e", "stiffness of the normal force, shape (c,)", symbol="k_c")
    contact_damping: np.ndarray = quantity("N s/m", "largest contact damping, shape (c,)", symbol="c_max")
    damping_depth: np.ndarray = quantity("m", "penetration at which the damping is complete, shape (c,)", symbol="d")
    stiction_velocity: np.ndarray = quantity("m/s", "slip speed of greatest friction, shape (c,)", symbol="v_s")
    outcome: tuple[str, ...] = quantity("-", "completed, too dear, or why the step ended early")
    hip_position: np.ndarray = quantity("m", "largest hip position difference in x and y, shape (c, 2)")
    hip_velocity: np.ndarray = quantity("m/s", "largest hip velocity difference in x and y, shape (c, 2)")
    position_parts: np.ndarray = quantity("m", "largest hip position difference of each part, shape (c, 3)")
    velocity_parts: np.ndarray = quantity("m/s", "largest hip velocity difference of each part, shape (c, 3)")
    evaluations: np.ndarray = quantity("1", "evaluations of the rates over one step at cost_tolerance, shape (c,)")
    score: np.ndarray = quantity("1", "distance over one step; infinite if it is not known, shape (c,)")


Table = tuple[str, tuple[str, ...], list[tuple[object, ...]]]


def shown(*values: float) -> tuple[float, ...]:
    """Rounded for a table."""
    return tuple(float(f"{value:.3g}") for value in values)


def limit_table(limit: RigidLimit) -> Table:
    """The limit, then all sets measured from it over one step and between cycles."""
    heads = ("", *LAWS, "hip x mm", "y mm", "x mm/s", "y mm/s", "T ms", "s mm", "evaluations", "step score")
    return "Distance from the rigid limit over one step and between cycles", heads, list(_limit_rows(limit))


def search_table(c: Candidates) -> Table:
    """The best sets of the search."""
    best = np.argsort(c.score, kind="stable")[:BEST]
    rows: list[tuple[object, ...]] = [
        (
            *shown(*(getattr(c, key)[row] for key in SEARCHED)),
            *shown(1e3 * c.hip_position[row].max(), 1e3 * c.hip_velocity[row].max()),
            *shown(*(1e3 * c.position_parts[row]), *(1e3 * c.velocity_parts[row])),
            int(c.evaluations[row]),
            *shown(c.score[row]),
        )
        for row in best
    ]
    split = tuple(f"{part} {unit}" for unit in ("mm", "mm/s") for part in PARTS)
    heads = (*LAWS, "hip mm", "hip mm/s", *split, "evaluations", "score")
    return f"The {len(rows)} best of {len(c.outcome)} sets searched", heads, rows


def _limit_rows(limit: RigidLimit) -> Iterator[tuple[object, ...]]:
    hard = limit.hard
    yield ("limit - rolling feet", *("",) * len(SEARCHED), *_differences(hard), "", "")
    named = [("starting set", limit.default), ("chosen set", limit.chosen), ("ground.yaml", limit.ground)]
    named += [("finalist", one) for one in limit.finalists]
    named += [(f"family, {share:g}", one) for share, one in zip(limit.family_share, limit.family)]
    for name, one in named:
        laws = shown(*(getattr(one.law, key) for key in SEARCHED))
        yield (name, *laws, *_differences(one), one.evaluations, *shown(one.step_score))


def _differences(one: Distance | HardLimit) -> tuple[float, ...]:
    """Rounded for a table: mm, mm/s, ms, mm."""
    return shown(*(1e3 * np.array([*one.hip_position, *one.hip_velocity, one.period, one.step_length])))
