"""What the ladder stage hands on."""

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import COUNTED, LEFT, quantity
from stages.biped.walk import largest_of_a_step
from stages.studies.result import COMPLETED, Table

#: From where on the two steps of a stride are said to differ, as a share of their mean.
LIMPS = 0.01
#: From where on the twin's own walk is said to be another than its gait, as a share of period or length.
AWAY = 0.01


@dataclass(frozen=True)
class MachineGait:
    """The gait of one machine by one model; numbers are NaN and arrays empty if none was found."""

    name: str = quantity("-", "name of the rung")
    outcome: str = quantity("-", "completed, or why no gait was found")
    period_s: float = quantity("s", "duration of a step, mean of both pairs'", symbol="T")
    step_length_m: float = quantity("m", "advance of the hip in a step", symbol="s")
    inner_outer_difference: float = quantity("1", "limp: from inner to outer mid-stance less back, over the mean step")

    @property
    def found(self) -> bool:
        """Whether the machine has a gait."""
        return self.outcome == COMPLETED

    @property
    def limps(self) -> bool:
        """Whether its two steps differ by what is seen, as beyond a period doubling: a cycle of two steps."""
        return abs(self.inner_outer_difference) >= LIMPS


@dataclass(frozen=True)
class RungGait(MachineGait):
    """A rung's gait, in space but for the first rung."""

    added: str = quantity("-", "what it has that the rung before has not")
    is_twin: bool = quantity("1", "whether this machine is the twin of the study's parameters")
    plane_multipliers: np.ndarray = quantity(
        "1", "the two largest multipliers of a cycle in the plane, real and imaginary part, shape (2, 2)",
        dimensions=("multiplier", "part")
    )
    side_multipliers: np.ndarray = quantity(
        "1", "the largest multiplier of a cycle in roll, yaw and sideways motion, shape (1, 2) or empty"
    )
    residual: float = quantity(
        "1", "how far the fixed point moves in a stride, in the section's scales", without_error=LEFT)
    solver_steps: float = quantity(
        "1", "solver steps a step of walking takes", without_error=COUNTED)
    strides_walked: int = quantity("1", "strides walked to find the gait and its multipliers")


@dataclass(frozen=True)
class SameMachine(MachineGait):
    """The constraint model of one rung's own machine, as its bill projects into the plane, beside that machine.

    Arrays of the hip hold NaN where one of them has no gait.
    """

    outcome: str = quantity("-", "completed, or why the constraint model has no gait")
    multipliers: np.ndarray = quantity(
        "1", "the two largest multipliers of a cycle, real and imaginary part, shape (2, 2)",
        dimensions=("multiplier", "part")
    )
    hip_apart_m: np.ndarray = quantity(
        "m", "largest difference of both hips over a stride at equal phase, x and y, shape (2,)",
        dimensions=("direction",)
    )
    hip_from_simple_m: np.ndarray = quantity(
        "m", "the same from the constraint model of the simple machine, shape (2,)", dimensions=("direction",)
    )


@dataclass(frozen=True)
class Result:
    """Gaits from the simple model to the twin and beyond it, each machine with one thing more than the one before."""

    simple_period_s: float = quantity("s", "step of the constraint model", symbol="T")
    simple_step_length_m: float = quantity("m", "step length of the constraint model", symbol="s")
    rungs: tuple[RungGait, ...] = quantity("-", "planar multibody model first")
    walked_period_s: float = quantity("s", "last four steps of the twin's own walk, their mean", symbol="T")
    walked_step_length_m: float = quantity("m", "the same of their length", symbol="s")
    same_machine: tuple[SameMachine, ...] = quantity(
        "-", "the constraint model of each rung's own machine, in the rungs' order", default=())
    steps: int = quantity("1", "steps that multipliers are of: two where the legs differ", default=1)

    @property
    def twin(self) -> RungGait | None:
        """The rung that is the twin, if it has a gait."""
        return next((rung for rung in self.rungs if rung.is_twin and rung.found), None)

    @property
    def largest_multipliers(self) -> tuple[float, float]:
        """Magnitudes of the twin's largest multipliers in the plane and out of it, of a step; NaN if unknown."""
        found = (self.twin.plane_multipliers, self.twin.side_multipliers) if self.twin else np.zeros((2, 0, 2))
        plane, side = (largest_of_a_step(each, self.steps) for each in found)
        return plane, side

    def changes(self) -> list[tuple[str, float, float]]:
        """What each rung adds to period [s] and step length [m]; a rung without gait adds nothing and is left out."""
        period, length = self.simple_period_s, self.simple_step_length_m
        rows = []
        for rung in self.rungs:
            if rung.found:
                rows.append((rung.name, rung.period_s - period, rung.step_length_m - length))
                period, length = rung.period_s, rung.step_length_m
        return rows

    def summary(self) -> str:
        """One line of what was found."""
        missing = [rung.name for rung in self.rungs if not rung.found]
        without = f", no gait for {', '.join(missing)}" if missing else ""
        if self.twin is None:
            return f"{len(self.rungs)} variants{without}"
        difference = 1e3 * (self.twin.period_s - self.simple_period_s)
        left = self.left_of_twin()
        own = f"; from the constraint model of the same robot {1e3 * left[0]:+.3g} ms" if left else ""
        largest = " of two steps" * (self.steps > 1) + f" {pair_text(self.twin.plane_multipliers[0])}"
        longest = 1e3 * (self.twin.step_length_m - self.simple_step_length_m)
        limp = 100 * abs(self.twin.inner_outer_difference)
        limps = f"; it limps, its two steps last {limp:.2g} % of their mean apart" * self.twin.limps
        gait = np.array([self.twin.step_length_m, self.twin.period_s])
        walk = np.array([self.walked_step_length_m, self.walked_period_s])
        words = "{:.1f} mm in {:.0f} ms".format
        walked = (f"; its own walk is not there: its last four steps are {words(*1e3 * walk)}, those of this gait "
                  f"{words(*1e3 * gait)}") * bool(np.any(np.abs(walk / gait - 1.0) >= AWAY))
        return (
            f"{len(self.rungs)} variants{without}: the twin's step is {difference:+.3g} ms and {longest:+.3g} mm from "
            f"the simple model's{own}, largest multiplier{largest}{limps}{walked}"
        )

    def left(self) -> list[tuple[RungGait, SameMachine]]:
        """Rungs and the constraint model of their own machine, where both have a gait."""
        pairs = zip(self.rungs, self.same_machine)  # an artefact without the constraint model's side has none
        return [(rung, own) for rung, own in pairs if rung.found and own.found]

    def left_of_twin(self) -> tuple[float, float] | None:
        """Step [s] and step length [m] of the twin less those of the constraint model of the same machine."""
        left = ((rung.period_s - own.period_s, rung.step_length_m - own.step_length_m)
                for rung, own in self.left() if rung.is_twin)  # fmt: skip
        return next(left, None)

    def tables(self) -> list[Table]:
        """The ladder, and the sum of its parts, as (title, columns, rows of text)."""
        columns = ["variant", "period [s]", "change [ms]", "length [mm]", "change [mm]", "multipliers in the plane",
                   "sideways", "limp", "solver steps a step", "strides walked"]  # fmt: skip
        rows = [["constraint model", f"{self.simple_period_s:.5f}", "", f"{1e3 * self.simple_step_length_m:.2f}"]]
        changes = {name: change for name, *change in self.changes()}
        for rung in self.rungs:
            if not rung.found:
                rows.append([rung.name, rung.outcome])
                continue
            period, length = changes[rung.name]
            rows.append([
                rung.name + (" = the twin" if rung.is_twin else ""),
                f"{rung.period_s:.5f}", f"{1e3 * period:+.2f}",
                f"{1e3 * rung.step_length_m:.2f}", f"{1e3 * length:+.2f}",
                ", ".join(pair_text(value) for value in rung.plane_multipliers[:2]),
                ", ".join(pair_text(value, 5) for value in rung.side_multipliers[:1]),
                f"{rung.inner_outer_difference:.1e}", f"{rung.solver_steps:.0f}", str(rung.strides_walked),
            ])  # fmt: skip
        ladder = [row + [""] * (len(columns) - len(row)) for row in rows]
        walks = [
            ("fixed point of the twin", self.twin.period_s, self.twin.step_length_m),
            ("last steps of the twin's own walk", self.walked_period_s, self.walked_step_length_m),
        ] if self.twin is not None else []  # fmt: skip
        twin = [[name, f"{period:.5f}", f"{1e3 * length:.2f}"] for name, period, length in walks]
        return [
            ("From the simple model to the twin, one change at a time", columns, ladder),
            ("Each variant and the constraint model of the same robot",
             ["variant", "constraint model [s]", "left [ms]", "length [mm]", "left [mm]", "multipliers", "machine's",
              "limp", "machine's", "hip apart x, y [mm]", "from simple x, y [mm]"], self._same_rows()),
            ("What each variant has more", ["variant", "added"], [[rung.name, rung.added] for rung in self.rungs]),
            ("The twin", ["", "period [s]", "length [mm]"], twin),
        ]

    def _same_rows(self) -> list[list[str]]:
        return [
            [
                rung.name + (" = the twin" if rung.is_twin else ""),
                f"{own.period_s:.5f}", f"{1e3 * (rung.period_s - own.period_s):+.2f}",
                f"{1e3 * own.step_length_m:.2f}", f"{1e3 * (rung.step_length_m - own.step_length_m):+.2f}",
                ", ".join(pair_text(value) for value in own.multipliers),
                ", ".join(pair_text(value) for value in rung.plane_multipliers[:2]),
                f"{own.inner_outer_difference:.1e}", f"{rung.inner_outer_difference:.1e}",
                ", ".join(f"{1e3 * value:.2f}" for value in own.hip_apart_m),
                ", ".join(f"{1e3 * value:.2f}" for value in own.hip_from_simple_m),
            ]
            for rung, own in self.left()
        ]  # fmt: skip


def pair_text(value: np.ndarray, digits: int = 3) -> str:
    """A multiplier given as real and imaginary part, short enough for a table."""
    (real, imaginary), least = value.tolist(), 0.5 * 10.0**-digits
    turns = "" if abs(imaginary) < least else f"{imaginary:+.{digits}f}i"
    return turns if turns and abs(real) < least else f"{real:+.{digits}f}{turns}"
