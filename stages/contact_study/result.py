"""What the contact study hands on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.contact_study import friction_result
from stages.contact_study.friction_result import FrictionVariation
from stages.contact_study.limit_result import COMPLETED, Candidates, RigidLimit, limit_table, search_table, shown
from stages.engines.result import EngineAgreement
from stages.ground.contact_law import ContactLaw

#: Keys of the contact set that the study varies, in the paper's order (figures 5 and 6).
VARIED = (
    "contact_stiffness",
    "contact_exponent",
    "contact_damping",
    "damping_depth",
    "stiction_velocity",
    "friction_velocity",
)


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

    @property
    def completed(self) -> bool:
        """Whether there is something to compare."""
        return self.outcome == COMPLETED


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
        "-", "the same from Adams' default contact set instead of ground.yaml's"
    )
    engines: EngineAgreement = quantity("-", "distance of the compiled penalty walker, which walks all, from Exudyn")

    def summary(self) -> str:
        """What was chosen, in one line."""
        failed = sum(outcome != COMPLETED for outcome in self.variations.outcome)
        ended = f"{failed} variations ended early; " if failed else ""
        if self.limit is None or self.candidates is None:
            return f"{ended}no set chosen: {self.limit_outcome}"
        if self.limit.chosen.outcome != COMPLETED:
            return f"{ended}no set chosen, the starting set: {self.limit.chosen.outcome}"
        law, found, hard = self.chosen.law, self.limit.chosen, self.limit.hard
        return (
            f"{len(self.candidates.outcome)} sets tried, chosen k_c {law.contact_stiffness:g} N/mm^e, "
            f"c_max {law.contact_damping:g} N s/m, d {1e3 * law.damping_depth:g} mm, "
            f"v_s {1e3 * law.stiction_velocity:g} mm/s: hip {1e3 * found.hip_position.max():.2f} mm from the rigid "
            f"limit, which is {1e3 * hard.hip_position.max():.2f} mm from rolling feet; {ended}"
            + ("ground.yaml holds it" if self.ground_is_choice else "ground.yaml holds another")
            + f"; {self.engines.sentence()}"
        )

    def tables(self) -> tuple[tuple[str, tuple[str, ...], list[tuple[object, ...]]], ...]:
        """The variations, the sets against the rigid limit, and the best of the search."""
        v = self.variations
        varied: list[tuple[object, ...]] = [_row(("starting set", ""), self.default)]
        for row, key in enumerate(v.key):
            numbers = v.hip_position[row], v.hip_velocity[row], v.normal_force[row], v.penetration[row]
            varied.append((key, float(v.value[row]), *_shown(*numbers), int(v.evaluations[row]), v.outcome[row]))
        varied += [_row(("chosen set", ""), self.chosen), _row(("ground.yaml", ""), self.ground)]
        seen = ("hip mm", "hip mm/s", "force N", "depth um", "evaluations")
        tables: list[friction_result.Table] = [
            ("One parameter at a time, differences from the constraint model", ("", "value", *seen, ""), varied)
        ]
        if self.limit is not None and self.candidates is not None:
            tables += [limit_table(self.limit), search_table(self.candidates)]
        friction = (("ground.yaml's contact set", self.friction_variations),
                    ("Adams' default contact set", self.default_friction_variations))  # fmt: skip
        return (*tables, *(friction_result.table(*pair) for pair in friction), self.engines.table())


def _row(name: tuple[str, str], step: OneStep) -> tuple[object, ...]:
    numbers = step.hip_position, step.hip_velocity, step.normal_force, step.penetration
    return (*name, *_shown(*numbers), step.evaluations, step.outcome)


def _shown(position: np.ndarray, velocity: np.ndarray, force: float, depth: float) -> tuple[float, ...]:
    """Rounded for a table: mm, mm/s, N, micrometres."""
    values = 1e3 * np.max(position), 1e3 * np.max(velocity), force, 1e6 * depth
    return shown(*values)
