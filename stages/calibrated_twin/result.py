"""What the calibrated twin hands on."""

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import count_of, quantity
from stages.biped.walk import Walk
from stages.calibration.result import LAB

CORRECTED = "corrected by the twin"
#: Title, columns and rows of text.
Table = tuple[str, tuple[str, ...], list[tuple[str, ...]]]


@dataclass(frozen=True)
class Number:
    """One parameter of a robot, as Table 1 counts it."""

    name: str = quantity("-", "parameter, by its file and key")
    unit: str = quantity("-", "its unit")
    drawn: float = quantity("SI", "value as drawn")
    found: float = quantity("SI", "by the constraint model, mean of the runs")
    by_twin: float = quantity("SI", "after one correction step with the twin; as found where there was none")
    corrected: float = quantity("SI", "less what fits of other machines' runs miss; by the twin where none show it")
    sd: float = quantity("SI", "standard error of the corrected value, what the model puts wrong in it")
    truth: float = quantity("SI", "the robot's, mean of the runs; NaN where nobody knows it")

    def interval(self, half_width: float) -> tuple[float, float]:
        """Where the value lies."""
        return self.corrected - half_width * self.sd, self.corrected + half_width * self.sd

    def holds_truth(self, half_width: float) -> bool:
        """Whether the truth lies there; not where nobody knows it."""
        lower, upper = self.interval(half_width)
        return lower <= self.truth <= upper


@dataclass(frozen=True)
class Robot:
    """A kind of robot as its runs show it."""

    kind: str = quantity("-", "with outsole, without outsole, lab")
    runs: int = quantity("1", "runs that were fitted")
    corrected_runs: int = quantity("1", "runs that the twin corrected")
    other_runs: int = quantity("1", "runs of other machines that show what the model puts wrong; 0: none")
    numbers: tuple[Number, ...] = quantity("-", "a row for each parameter")
    correlations: np.ndarray = quantity(
        "1", "of the parameters, by the first run's fit, (n, n)", dimensions=("parameter", "parameter_too"))
    biases: np.ndarray = quantity(
        "SI", "what a correction took off each parameter that was looked for, by corrected run, (c, d)",
        dimensions=("corrected_run", "looked_for"))
    frequency: float = quantity("Hz", "step frequency of the corrected robot's gait on the nominal ramp")
    frequency_sd: float = quantity("Hz", "its standard error")
    true_frequency: float = quantity("Hz", "that of the true robot's gait; NaN where nobody knows it")

    @property
    def by_what(self) -> str:
        """What its intervals rest on."""
        if self.other_runs:
            return f"the errors of fits of {self.other_runs} other robots' runs"
        return "the fit's noise and the whole of what the correction took off" if self.corrected_runs else (
            "the fit's noise and residuals alone")


@dataclass(frozen=True)
class Pair:
    """What the outsole does, by one pair of runs, with and without: same machine, push and ramp."""

    name: str = quantity("-", "the run with the outsole")
    longer: float = quantity("m", "by how much the leg is longer")
    longer_sd: float = quantity("m", "standard error of that")
    true_longer: float = quantity("m", "by how much it is")
    heavier: float = quantity("kg", "by how much a leg is heavier below its spring")
    slower: float = quantity("1", "relative change of the step frequency on the nominal ramp")
    slower_sd: float = quantity("1", "standard error of that")
    true_slower: float = quantity("1", "that of the true robots")


@dataclass(frozen=True)
class Check:
    """A run that was not fitted, walked by the twin with the robot's numbers."""

    name: str = quantity("-", "the run")
    kind: str = quantity("-", "of which robot")
    numbers: str = quantity("-", "as found, or corrected by the twin")
    late: float = quantity("s", "largest time by which a heel strike of the twin is off")
    force: float = quantity("m/s^2", "rms error of the specific force")
    rate: float = quantity("rad/s", "rms error of the rate")


@dataclass(frozen=True)
class Result:
    """Robots as the runs show them, corrected by the Exudyn twin, and the twin's walk with the first one's numbers."""

    robots: tuple[Robot, ...] = quantity("-", "robot by robot")
    pairs: tuple[Pair, ...] = quantity("-", "what the outsole does")
    checks: tuple[Check, ...] = quantity("-", "runs that were not fitted, walked by the twin")
    reasons: tuple[str, ...] = quantity("-", "what could not be done, and why")
    walk: Walk | None = quantity("-", "the twin's walk with the first robot's corrected numbers; none if it falls")

    @property
    def strikes_off(self) -> float | None:
        """By how much the twin's heel strikes are off in a lab's runs held out [s], with corrected numbers where there
        are; None without such runs: synthetic ones are of no robot."""
        checks = (check for check in self.checks if check.kind == LAB and np.isfinite(check.late))
        late = {check.name: float(check.late) for check in checks}  # of a run as found, and then corrected
        return max(late.values(), default=None)

    def summary(self) -> str:
        """What was found, in one line."""
        if not self.robots:
            return "no run could be fitted"
        first = self.robots[0]
        moved = [abs(one.corrected - one.found) / one.sd for one in first.numbers if one.sd > 0]
        runs = sum(one.runs for one in self.robots)
        return (f"{count_of(len(self.robots), 'robot')} from {count_of(runs, 'run')}, {first.corrected_runs} of "
                f"the first corrected, by up to {max(moved):.1f} standard errors")

    def tables(self) -> list[Table]:
        """Parameters, pairs and checks, as (title, columns, rows of text)."""
        tables: list[Table] = []
        for robot in self.robots:
            rows: list[tuple[str, ...]] = [
                (one.name, f"{one.drawn:.6g} {one.unit}", f"{one.found:.6g}", f"{one.by_twin:.6g}",
                 f"{one.corrected:.6g}", f"{one.sd:.2g}", f"{one.truth:.6g}" if np.isfinite(one.truth) else "not known")
                for one in robot.numbers
            ]
            tables.append((f"Robot {robot.kind}, {robot.runs} runs; sd by {robot.by_what}",
                           ("parameter", "nominal", "fitted", "by the twin", "corrected", "sd", "truth"), rows))
        pairs: list[tuple[str, ...]] = [
            (one.name, f"{1e3 * one.longer:.2f}", f"{1e3 * one.longer_sd:.2f}", f"{1e3 * one.true_longer:.2f}",
             f"{1e3 * one.heavier:.1f}", f"{100 * one.slower:+.2f}", f"{100 * one.slower_sd:.2f}",
             f"{100 * one.true_slower:+.2f}")
            for one in self.pairs
        ]
        checks: list[tuple[str, ...]] = [
            (one.name, one.numbers, f"{1e3 * one.late:.1f}", f"{one.force:.3f}", f"{one.rate:.4f}")
            for one in self.checks
        ]
        more: list[Table] = [
            ("What the outsole does",
             ("run", "longer mm", "sd", "truth", "heavier g a leg", "frequency %", "sd", "truth"), pairs),
            ("Runs held out, walked by the twin",
             ("run", "numbers", "strikes off by ms", "force m/s^2", "rate rad/s"), checks)]
        return tables + [table for table in more if table[2]]
