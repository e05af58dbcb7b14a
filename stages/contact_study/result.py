"""What the contact study hands on: steps against the constraint model, distances from the rigid limit, friction."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stages.biped.quantity import COUNTED, GIVEN, mm, quantity
from stages.ground.contact_law import ContactLaw
from stages.studies.result import COMPLETED, EngineAgreement, Table, shown

#: Keys of the contact set that the study varies, in the paper's order (figures 5 and 6).
VARIED = (
    "contact_stiffness",
    "contact_exponent",
    "contact_damping",
    "damping_depth",
    "stiction_velocity",
    "friction_velocity",
)
#: Keys that the search varies together.
SEARCHED = ("contact_stiffness", "contact_damping", "damping_depth", "stiction_velocity")
#: Parts of a difference from the rigid limit, see `stages.contact_study.rigid_limit`.
PARTS = ("creep", "impact", "rest")
#: Outcome of a set that takes more solver steps than a choice may take.
TOO_DEAR = "too dear"
#: Sets of the search that a table shows.
BEST = 12
LAWS = ("k_c N/mm^e", "c_max N s/m", "d m", "v_s m/s")
#: What a table shows of a step.
SEEN = ("hip_position", "hip_velocity", "normal_force", "penetration", "evaluations", "outcome")


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
    most_evaluations: float = quantity("1", "evaluations that a chosen set may take over one step",
                                       without_error=COUNTED)
    finalists: tuple[Distance, ...] = quantity("-", "the sets of the search compared between cycles, best first")
    family_share: np.ndarray = quantity("1", "what is left of impact and creep of the chosen set, shape (f,)")
    family: tuple[Distance, ...] = quantity("-", "the chosen set's family at these shares, towards the limit")


@dataclass(frozen=True)
class Candidates:
    """The contact sets that the search tried, one a row, over one step from the rigid limit; NaN as in `Distance`."""

    contact_stiffness: np.ndarray = quantity(
        "N/mm^e", "stiffness of the normal force, shape (c,)", symbol="k_c", without_error=GIVEN)
    contact_damping: np.ndarray = quantity(
        "N s/m", "largest contact damping, shape (c,)", symbol="c_max", without_error=GIVEN)
    damping_depth: np.ndarray = quantity(
        "m", "penetration at which the damping is complete, shape (c,)", symbol="d", without_error=GIVEN)
    stiction_velocity: np.ndarray = quantity(
        "m/s", "slip speed of greatest friction, shape (c,)", symbol="v_s", without_error=GIVEN)
    outcome: tuple[str, ...] = quantity("-", "completed, too dear, or why the step ended early")
    hip_position: np.ndarray = quantity("m", "largest hip position difference in x and y, shape (c, 2)")
    hip_velocity: np.ndarray = quantity("m/s", "largest hip velocity difference in x and y, shape (c, 2)")
    position_parts: np.ndarray = quantity("m", "largest hip position difference of each part, shape (c, 3)")
    velocity_parts: np.ndarray = quantity("m/s", "largest hip velocity difference of each part, shape (c, 3)")
    evaluations: np.ndarray = quantity("1", "evaluations of the rates over one step at cost_tolerance, shape (c,)")
    score: np.ndarray = quantity("1", "distance over one step; infinite if it is not known, shape (c,)")


@dataclass(frozen=True)
class FrictionVariation:
    """The gait, a fixed point, with one transition velocity changed; NaN where none is found."""

    name: str = quantity("-", "parameter changed")
    factor: float = quantity("1", "factor on its value; 1 is the contact set itself")
    period_s: float = quantity("s", "step period", symbol="T")
    step_length_m: float = quantity("m", "step length", symbol="s")


def friction_table(contact_set: str, variations: Sequence[FrictionVariation]) -> Table:
    """What the transition velocities of friction change, from this contact set."""
    heads = ("velocity", "factor", "period [s]", "change [%]", "step [mm]", "change [%]")
    return f"The gait with one transition velocity of friction changed, {contact_set}", heads, [
        (
            variation.name.replace("_", " "), f"{variation.factor:.3g}",
            f"{variation.period_s:.5f}", f"{100 * in_period:+.2f}",
            f"{1e3 * variation.step_length_m:.2f}", f"{100 * in_length:+.2f}",
        )
        for variation, in_period, in_length in changes(variations)
    ]  # fmt: skip


def changes(variations: Sequence[FrictionVariation]) -> Iterator[tuple[FrictionVariation, float, float]]:
    """Each variation with its relative change of period and of step length against factor 1."""
    unchanged = {variation.name: variation for variation in variations if variation.factor == 1.0}
    for variation in variations:
        base = unchanged[variation.name]
        yield variation, variation.period_s / base.period_s - 1.0, variation.step_length_m / base.step_length_m - 1.0


def crossing(variations: Sequence[FrictionVariation], name: str, limit: float) -> tuple[float, float]:
    """Factors on the velocity `name`, below and above 1, at which period or step length has changed by `limit`.

    Interpolated in the logarithm of the factor between the variations computed; NaN where the change stays smaller.
    """
    rows = sorted(
        (math.log(variation.factor), max(abs(in_period), abs(in_length)))
        for variation, in_period, in_length in changes(variations)
        if variation.name == name and math.isfinite(in_period)
    )
    sides = []
    for side in ([row for row in rows[::-1] if row[0] <= 0.0], [row for row in rows if row[0] >= 0.0]):
        sides.append(float("nan"))
        for (near, less), (far, more) in pairwise(side):
            if less < limit <= more:
                sides[-1] = math.exp(near + (far - near) * (limit - less) / (more - less))
                break
    return sides[0], sides[1]


@dataclass(frozen=True)
class OneStep:
    """One step from the constraint model's mid-stance with one contact set, against the constraint model.

    All numbers but the outcome are NaN if the step was not finished. Velocities and forces are compared outside the
    impact: before the first heel strike of the two models, and from `impact_window` after the second.
    """

    outcome: str = quantity("-", "completed, or why the step ended early")
    message: str = quantity("-", "what the solver said if it failed")
    law: ContactLaw = quantity("-", "the contact law")
    hip_position: np.ndarray = quantity("m", "largest hip position difference in x and y, with the step's end, (2,)")
    hip_velocity: np.ndarray = quantity("m/s", "largest hip velocity difference at samples, x and y, shape (2,)")
    impact_velocity: np.ndarray = quantity("m/s", "the same inside the impact, shape (2,)")
    end_position: np.ndarray = quantity("m", "hip position difference, with its sign, at the step's end, shape (2,)")
    normal_force: float = quantity("N", "rms difference of the normal forces of both feet")
    friction_force: float = quantity("N", "rms difference of the friction forces of both feet")
    peak_force: float = quantity("N", "largest normal force on the landing foot")
    penetration: float = quantity("m", "deepest penetration", symbol="p")
    creep_velocity: float = quantity("m/s", "mean slip speed of the standing foot before heel strike")
    heel_strike_lead: float = quantity("s", "how much earlier than in the constraint model the foot lands")
    evaluations: int = quantity("1", "evaluations of the rates at cost_tolerance: the cost")


@dataclass(frozen=True)
class Variations:
    """Steps with one parameter of the starting set changed alone, one a row; NaN where a step was not finished."""

    key: tuple[str, ...] = quantity("-", "parameter changed")
    value: np.ndarray = quantity("-", "its value in the parameter's unit, shape (k,)")
    outcome: tuple[str, ...] = quantity("-", "completed, or why the step ended early")
    message: tuple[str, ...] = quantity("-", "what the solver said if it failed")
    hip_position: np.ndarray = quantity("m", "largest hip position difference in x and y, shape (k, 2)")
    hip_velocity: np.ndarray = quantity("m/s", "largest hip velocity difference in x and y, shape (k, 2)")
    end_position: np.ndarray = quantity("m", "hip position difference at the step's end, with its sign, shape (k, 2)")
    normal_force: np.ndarray = quantity("N", "rms difference of the normal forces, shape (k,)")
    friction_force: np.ndarray = quantity("N", "rms difference of the friction forces, shape (k,)")
    peak_force: np.ndarray = quantity("N", "largest normal force on the landing foot, shape (k,)")
    penetration: np.ndarray = quantity("m", "deepest penetration, shape (k,)", symbol="p")
    creep_velocity: np.ndarray = quantity("m/s", "mean slip speed of the standing foot, shape (k,)")
    evaluations: np.ndarray = quantity("1", "evaluations of the rates at cost_tolerance, shape (k,)")
    force: np.ndarray = quantity("N", "tangential and normal force on the landing foot, shape (k, n, 2)")

    def rows(self, key: str) -> list[int]:
        """The rows in which `key` is changed."""
        return [row for row, name in enumerate(self.key) if name == key]


@dataclass(frozen=True)
class Result:
    """The study of the contact set and the choice it makes.

    The `OneStep`s are against the constraint model of the study, as the paper compares them; what is in `limit` is
    against the rigid limit, by which the choice is made.
    """

    time: np.ndarray = quantity("s", "times of the force curves, from the constraint model's heel strike, shape (n,)")
    default: OneStep = quantity("-", "the starting set")
    default_force: np.ndarray = quantity("N", "tangential and normal force with the starting set, shape (n, 2)")
    variations: Variations = quantity("-", "each parameter changed alone")
    candidates: Candidates | None = quantity("-", "sets the search tried; empty without a rigid limit")
    limit_outcome: str = quantity("-", "completed, or why the constraint model has no gait with Coulomb's transition")
    limit: RigidLimit | None = quantity("-", "distances from the rigid limit; empty without one")
    chosen: OneStep = quantity("-", "the set that the criterion chooses; the starting set without a rigid limit")
    chosen_force: np.ndarray = quantity("N", "tangential and normal force with the chosen set, shape (n, 2)")
    ground: OneStep = quantity("-", "the set of ground.yaml, which the other stages use")
    ground_is_choice: bool = quantity("1", "whether ground.yaml holds the chosen set")
    friction_variations: tuple[FrictionVariation, ...] = quantity("-", "gait at other transition velocities")
    default_friction_variations: tuple[FrictionVariation, ...] = quantity(
        "-", "the same from the starting set instead of ground.yaml's"
    )
    engines: EngineAgreement = quantity("-", "distance of the compiled penalty walker, which walks all, from Exudyn")

    @property
    def undecided(self) -> str:
        """Why no set was chosen, so that the starting one stands in its place; empty where one was."""
        if self.limit is None:
            return self.limit_outcome
        return "" if self.limit.chosen.outcome == COMPLETED else self.limit.chosen.outcome

    def summary(self) -> str:
        """What was chosen, in one line."""
        failed = sum(outcome != COMPLETED for outcome in self.variations.outcome)
        ended = f"{failed} variations ended early; " if failed else ""
        if self.limit is None or self.candidates is None or self.undecided:
            return f"{ended}no set chosen: {self.undecided}"
        law, found, hard = self.chosen.law, self.limit.chosen, self.limit.hard
        damping = f"c_max {law.contact_damping:g} N s/m, d {1e3 * law.damping_depth:g} mm, "
        damping *= law.normal_force == "impact"  # no other law uses them
        return (
            f"{len(self.candidates.outcome)} sets tried, chosen k_c {law.contact_stiffness:g} N/mm^e, "
            f"{damping}v_s {1e3 * law.stiction_velocity:g} mm/s: "
            f"hip {mm(found.hip_position.max())} from the rigid limit, "
            f"which is {mm(hard.hip_position.max())} from rolling feet; {ended}"
            + ("ground.yaml holds it" if self.ground_is_choice else "ground.yaml holds another")
            + f"; {self.engines.sentence()}"
        )

    def tables(self) -> tuple[Table, ...]:
        """The variations, the sets against the rigid limit, and the best of the search."""
        v, steps = self.variations, (("chosen set", self.chosen), ("ground.yaml", self.ground))
        varied = [step_row("starting set", "", *(getattr(self.default, name) for name in SEEN))]
        varied += map(step_row, v.key, v.value.tolist(), *(getattr(v, name) for name in SEEN))
        varied += [step_row(which, "", *(getattr(step, name) for name in SEEN)) for which, step in steps]
        heads = ("", "value", "hip mm", "hip mm/s", "force N", "depth um", "evaluations", "")
        limits = () if self.limit is None or self.candidates is None else (
            limit_table(self.limit), search_table(self.candidates))  # fmt: skip
        return (
            ("One parameter at a time, differences from the constraint model", heads, varied),
            *limits,
            friction_table("ground.yaml's contact set", self.friction_variations),
            friction_table("the starting set", self.default_friction_variations),
            self.engines.table(),
        )


def step_row(
    name: str, value: object, position: np.ndarray, velocity: np.ndarray, force: float, depth: float, cost: int,
    outcome: str,
) -> tuple[object, ...]:
    """A step in a table: largest differences in mm and mm/s, N, micrometres."""
    sizes = shown(1e3 * np.max(position), 1e3 * np.max(velocity), force, 1e6 * depth)
    return (name, value, *sizes, int(cost), outcome)


def limit_table(limit: RigidLimit) -> Table:
    """The limit, then all sets measured from it over one step and between cycles."""
    named = [("starting set", limit.default), ("chosen set", limit.chosen), ("ground.yaml", limit.ground)]
    named += [("finalist", one) for one in limit.finalists]
    named += [(f"family, {share:g}", one) for share, one in zip(limit.family_share, limit.family)]
    heads = ("", *LAWS, "hip x mm", "y mm", "x mm/s", "y mm/s", "T ms", "s mm", "evaluations", "step score")
    return "Distance from the rigid limit over one step and between cycles", heads, [
        ("limit - rolling feet", *("",) * len(SEARCHED), *_differences(limit.hard), "", ""),
        *((name, *shown(*(getattr(one.law, key) for key in SEARCHED)), *_differences(one), one.evaluations,
           *shown(one.step_score)) for name, one in named),
    ]  # fmt: skip


def _differences(one: Distance | HardLimit) -> tuple[float, ...]:
    """Rounded for a table: mm, mm/s, ms, mm."""
    return shown(*(1e3 * np.array([*one.hip_position, *one.hip_velocity, one.period, one.step_length])))


def search_table(c: Candidates) -> Table:
    """The best sets of the search, of those that have a score."""
    best = np.argsort(c.score, kind="stable")[: min(BEST, np.isfinite(c.score).sum())]
    split = tuple(f"{part} {unit}" for unit in ("mm", "mm/s") for part in PARTS)
    heads = (*LAWS, "hip mm", "hip mm/s", *split, "evaluations", "score")
    return f"The {len(best)} best of {len(c.outcome)} sets searched", heads, [
        (
            *shown(*(getattr(c, key)[row] for key in SEARCHED)),
            *shown(1e3 * c.hip_position[row].max(), 1e3 * c.hip_velocity[row].max()),
            *shown(*(1e3 * c.position_parts[row]), *(1e3 * c.velocity_parts[row])),
            int(c.evaluations[row]),
            *shown(c.score[row]),
        )
        for row in best
    ]  # fmt: skip
