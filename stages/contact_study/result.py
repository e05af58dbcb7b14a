"""What the contact study hands on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
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

#: Keys that the search varies together.
SEARCHED = ("contact_stiffness", "contact_damping", "damping_depth", "stiction_velocity")
#: Sets of the search that a table shows.
BEST = 12


@dataclass(frozen=True)
class OneStep:
    """One step from the constraint model's mid-stance with one contact set, against the constraint model.

    All numbers but the outcome are NaN if the step was not finished. Velocities and forces are compared outside the
    impact: before the first heel strike of the two models, and from `impact_window` after the second.
    """

    outcome: str = quantity("-", "completed, or why the step ended early")
    message: str = quantity("-", "what the solver said if it failed")
    law: ContactLaw = quantity("-", "the contact law")
    hip_position: np.ndarray = quantity("m", "largest hip position difference in x and y, shape (2,)")
    hip_velocity: np.ndarray = quantity("m/s", "largest hip velocity difference in x and y, shape (2,)")
    impact_velocity: np.ndarray = quantity("m/s", "the same inside the impact, shape (2,)")
    end_position: np.ndarray = quantity("m", "hip position difference, with its sign, at the step's end, shape (2,)")
    normal_force: float = quantity("N", "rms difference of the normal forces of both feet")
    friction_force: float = quantity("N", "rms difference of the friction forces of both feet")
    peak_force: float = quantity("N", "largest normal force on the landing foot")
    penetration: float = quantity("m", "deepest penetration", symbol="p")
    creep_velocity: float = quantity("m/s", "mean slip speed of the standing foot before heel strike")
    heel_strike_lead: float = quantity("s", "how much earlier than in the constraint model the foot lands")
    solver_steps: int = quantity("1", "accepted steps of the explicit solver: the cost")

    @property
    def completed(self) -> bool:
        """Whether there is something to compare."""
        return self.outcome == "completed"


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
    solver_steps: np.ndarray = quantity("1", "accepted solver steps, shape (k,)")
    force: np.ndarray = quantity("N", "tangential and normal force on the landing foot, shape (k, n, 2)")

    def rows(self, key: str) -> list[int]:
        """The rows in which `key` is changed."""
        return [row for row, name in enumerate(self.key) if name == key]


@dataclass(frozen=True)
class Candidates:
    """The contact sets that the search tried, one a row; NaN where a step was not finished."""

    contact_stiffness: np.ndarray = quantity("N/mm^e", "stiffness of the normal force, shape (c,)", symbol="k_c")
    contact_damping: np.ndarray = quantity("N s/m", "largest contact damping, shape (c,)", symbol="c_max")
    damping_depth: np.ndarray = quantity("m", "penetration at which the damping is complete, shape (c,)", symbol="d")
    stiction_velocity: np.ndarray = quantity("m/s", "slip speed of greatest friction, shape (c,)", symbol="v_s")
    outcome: tuple[str, ...] = quantity("-", "completed, too dear, or why the step ended early")
    hip_position: np.ndarray = quantity("m", "largest hip position difference, shape (c,)")
    hip_velocity: np.ndarray = quantity("m/s", "largest hip velocity difference, shape (c,)")
    normal_force: np.ndarray = quantity("N", "rms difference of the normal forces, shape (c,)")
    penetration: np.ndarray = quantity("m", "deepest penetration, shape (c,)", symbol="p")
    solver_steps: np.ndarray = quantity("1", "accepted solver steps, shape (c,)")
    excess: np.ndarray = quantity("1", "part by which a limit is broken; infinite if the step ended early, shape (c,)")
    score: np.ndarray = quantity("1", "differences, each in its limit, added; infinite if it ended early, shape (c,)")


@dataclass(frozen=True)
class Result:
    """The study of the contact set and the choice it makes."""

    time: np.ndarray = quantity("s", "times of the force curves, from the constraint model's heel strike, shape (n,)")
    default: OneStep = quantity("-", "the starting set")
    default_force: np.ndarray = quantity("N", "tangential and normal force with the starting set, shape (n, 2)")
    variations: Variations = quantity("-", "each parameter changed alone")
    candidates: Candidates = quantity("-", "sets the search tried")
    chosen: OneStep = quantity("-", "the set that the criterion chooses")
    chosen_force: np.ndarray = quantity("N", "tangential and normal force with the chosen set, shape (n, 2)")
    ground: OneStep = quantity("-", "the set of ground.yaml, which the other stages use")
    ground_is_choice: bool = quantity("1", "whether ground.yaml holds the chosen set")

    def summary(self) -> str:
        """What was chosen, in one line."""
        law, step = self.chosen.law, self.chosen
        failed = sum(outcome != "completed" for outcome in self.variations.outcome)
        return (
            f"{len(self.candidates.outcome)} sets tried, chosen k_c {law.contact_stiffness:g} N/mm^e, "
            f"c_max {law.contact_damping:g} N s/m, d {1e3 * law.damping_depth:g} mm, "
            f"v_s {1e3 * law.stiction_velocity:g} mm/s: hip {1e3 * step.hip_position.max():.2f} mm, "
            f"{1e3 * step.hip_velocity.max():.1f} mm/s; "
            + (f"{failed} variations ended early; " if failed else "")
            + ("ground.yaml holds it" if self.ground_is_choice else "ground.yaml holds another")
        )

    def tables(self) -> tuple[tuple[str, tuple[str, ...], list[tuple[object, ...]]], ...]:
        """The variations and the best sets of the search."""
        v, c = self.variations, self.candidates
        varied: list[tuple[object, ...]] = [_row(("starting set", ""), self.default)]
        for row, key in enumerate(v.key):
            numbers = v.hip_position[row], v.hip_velocity[row], v.normal_force[row], v.penetration[row]
            varied.append((key, float(v.value[row]), *_shown(*numbers), int(v.solver_steps[row]), v.outcome[row]))
        varied += [_row(("chosen set", ""), self.chosen), _row(("ground.yaml", ""), self.ground)]
        best = np.lexsort((c.score, c.excess))[:BEST]
        tried: list[tuple[object, ...]] = [
            (
                *(float(getattr(c, key)[row]) for key in SEARCHED),
                *_shown(c.hip_position[row], c.hip_velocity[row], c.normal_force[row], c.penetration[row]),
                int(c.solver_steps[row]),
                float(c.excess[row]),
                float(c.score[row]),
            )
            for row in best
        ]
        seen = ("hip mm", "hip mm/s", "force N", "depth um", "steps")
        return (
            ("One parameter at a time, differences from the constraint model", ("", "value", *seen, ""), varied),
            (
                f"The {len(tried)} best of {len(c.outcome)} sets searched",
                ("k_c N/mm^e", "c_max N s/m", "d m", "v_s m/s", *seen, "excess", "score"),
                tried,
            ),
        )


def _row(name: tuple[str, str], step: OneStep) -> tuple[object, ...]:
    numbers = step.hip_position, step.hip_velocity, step.normal_force, step.penetration
    return (*name, *_shown(*numbers), step.solver_steps, step.outcome)


def _shown(position: np.ndarray, velocity: np.ndarray, force: float, depth: float) -> tuple[float, ...]:
    """Rounded for a table: mm, mm/s, N, micrometres."""
    values = 1e3 * np.max(position), 1e3 * np.max(velocity), force, 1e6 * depth
    return tuple(float(f"{value:.3g}") for value in values)
