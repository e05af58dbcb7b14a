"""What the calibration hands on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import count_of, quantity

#: Half of a 95 % interval, in standard deviations.
HALF_WIDTH = 1.959964
#: The kind of a robot whose runs are a lab's own; others are the campaign's, which are synthetic.
LAB = "lab"


@dataclass(frozen=True)
class Determined:
    """How well runs determine one parameter of the design, the robot being weighed."""

    name: str = quantity("-", "parameter, by its file and key")
    unit: str = quantity("-", "its unit")
    value: float = quantity("SI", "value of the design")
    sd_one_run: float = quantity("SI", "smallest standard deviation of an unbiased estimate from one run")
    sd: float = quantity("SI", "the same from all runs of the campaign")
    goes_with: str = quantity("-", "unknown that its error is tied to most")
    correlation: float = quantity("1", "correlation with that")


@dataclass(frozen=True)
class Trace:
    """One sensor of a run that was fitted: forward and up [m/s^2], lateral rate [rad/s]."""

    time: np.ndarray = quantity("s", "times of its samples by its clock since the first heel strike used, shape (n,)")
    measured: np.ndarray = quantity("SI", "samples, shape (n, 3)", dimensions=("time", "channel"))
    fitted: np.ndarray = quantity("SI", "what the fit says they should be, (n, 3)", dimensions=("time", "channel"))
    residual: np.ndarray = quantity(
        "SI", "measured less fitted, NaN for samples that do not count, (n, 3)", dimensions=("time", "channel"))


@dataclass(frozen=True)
class FittedRun:
    """The fit of one run, blind; what is called truth was put beside it afterwards."""

    name: str = quantity("-", "the run")
    kind: str = quantity("-", "of which robot: with outsole, without outsole, lab")
    design: np.ndarray = quantity("SI", "parameters found, shape (d,)", dimensions=("parameter",))
    own: np.ndarray = quantity("SI", "parameters of this run alone, shape (o,)", dimensions=("own",))
    unknowns: np.ndarray = quantity("SI", "start, times and sensors' errors, shape (k,)", dimensions=("unknown",))
    covariance: np.ndarray = quantity(
        "SI", "of the parameters found, widened, shape (d, d)", dimensions=("parameter", "parameter_too"))
    truth: np.ndarray = quantity("SI", "the robot's, NaN where nobody knows it, (d,)", dimensions=("parameter",))
    sigmas: float = quantity("1", "root mean square residual in noises of the sensors")
    wider: float = quantity("1", "factor on intervals, for the residuals' size and structure")
    walks: int = quantity("1", "walks that the fit took")
    converged: bool = quantity("1", "whether it came to rest")
    why: str = quantity("-", "why it did not")
    hip: Trace = quantity("-", "hip sensor")
    foot: Trace = quantity("-", "foot sensor")
    strikes: np.ndarray = quantity("s", "measured heel strikes since the first one used, shape (s,)")


@dataclass(frozen=True)
class HeldOut:
    """How well the robot that other runs gave explains a run, and predicts it."""

    name: str = quantity("-", "the run")
    kind: str = quantity("-", "of which robot")
    begun: float = quantity("s", "length of the beginning from which it is predicted")
    sigmas: float = quantity("1", "root mean square residual in noises, start and sensors fitted")
    fit_force: float = quantity("m/s^2", "rms error of the specific force, start and sensors fitted")
    fit_rate: float = quantity("rad/s", "rms error of the rate, start and sensors fitted")
    foretold_force: float = quantity("m/s^2", "rms error of the specific force after the beginning; NaN: it falls")
    foretold_rate: float = quantity("rad/s", "rms error of the rate after the beginning; NaN: it falls")
    noise_force: float = quantity("m/s^2", "noise of the specific force")
    noise_rate: float = quantity("rad/s", "noise of the rate")
    own: np.ndarray = quantity("deg", "the run's ramp, shape (1,)")
    unknowns: np.ndarray = quantity("SI", "start, times and sensors' errors, shape (k,)", dimensions=("unknown",))
    hip: Trace = quantity("-", "hip sensor, predicted; as fitted where it falls")
    foot: Trace = quantity("-", "foot sensor, predicted; as fitted where it falls")
    strikes: np.ndarray = quantity("s", "measured heel strikes since the first one used, shape (s,)")


@dataclass(frozen=True)
class Followed:
    """A run that was fitted, followed with the robot it showed: what was known after each sample of its hip's sensor
    from the samples until then. Times count from the first heel strike used."""

    name: str = quantity("-", "the run")
    time: np.ndarray = quantity("s", "times of the samples, shape (n,)")
    angle: np.ndarray = quantity("rad", "inner leg's angle from the slope normal, foot ahead positive, shape (n,)")
    angle_sd: np.ndarray = quantity("rad", "its standard error, shape (n,)")
    next_strike: np.ndarray = quantity("s", "when the next heel strike comes, NaN where not known, shape (n,)")
    next_strike_sd: np.ndarray = quantity("s", "its standard error, shape (n,)")
    step_length: np.ndarray = quantity(
        "m", "length of the step that it ends, and its standard error, (n, 2)", dimensions=("time", "value_and_sd"))
    strikes: np.ndarray = quantity("s", "measured heel strikes, shape (s,)")
    true_time: np.ndarray = quantity("s", "times at which the truth is known, shape (m,); none of a lab's runs")
    true_angle: np.ndarray = quantity("rad", "the inner leg's angle then, shape (m,)", dimensions=("true_time",))


@dataclass(frozen=True)
class Misses:
    """What fits of other machines' runs miss, whose truth is known as the study made them: the model's discrepancy."""

    runs: tuple[str, ...] = quantity("-", "their names; none where the study has none to spare")
    shares: np.ndarray = quantity(
        "1", "found less truth, in shares of the values as drawn, (m, d)", dimensions=("other_run", "parameter"))
    own: np.ndarray = quantity(
        "SI", "parameters of each of them alone, shape (m, o)", dimensions=("other_run", "own"))
    unknowns: np.ndarray = quantity(
        "SI", "their starts, times and sensors' errors, shape (m, k)", dimensions=("other_run", "unknown"))
    pulls: np.ndarray = quantity(
        "1", "rate by which a fit moved the sensors' clocks, mean of both, shape (m,)", dimensions=("other_run",))


@dataclass(frozen=True)
class Failed:
    """A run that could not be fitted, or walked."""

    name: str = quantity("-", "the run")
    kind: str = quantity("-", "of which robot")
    why: str = quantity("-", "why not")


@dataclass(frozen=True)
class Result:
    """What the campaign's sensors can determine of the design, and what a blind fit of some of its runs found."""

    runs: int = quantity("1", "runs of the campaign")
    told: tuple[Determined, ...] = quantity("-", "a row for each parameter")
    not_seen: tuple[str, ...] = quantity("-", "combinations that no sensor sees, in words")
    names: tuple[str, ...] = quantity("-", "parameters that the fit looks for, by file and key")
    units: tuple[str, ...] = quantity("-", "their units")
    drawn: np.ndarray = quantity("SI", "their values as drawn, from which the fit begins", dimensions=("parameter",))
    own_names: tuple[str, ...] = quantity("-", "parameters that each run has for itself")
    unknown_names: tuple[str, ...] = quantity("-", "a run's other unknowns")
    fits: tuple[FittedRun, ...] = quantity("-", "runs that were fitted, each alone")
    held_out: tuple[HeldOut, ...] = quantity("-", "runs that were not, explained and predicted")
    misses: Misses = quantity("-", "what fits of runs of further machines miss")
    failed: tuple[Failed, ...] = quantity("-", "runs that could not be fitted or walked")
    followed: tuple[Followed, ...] = quantity(
        "-", "the first run that was fitted, followed; none if it is lost", default=())
    lever_arm_sd: float = quantity("m", "what was known of the foot sensor's place, standard error", default=np.nan)

    def of_kind(self, kind: str) -> list[FittedRun]:
        """Fits of one kind of robot."""
        return [fit for fit in self.fits if fit.kind == kind]

    def summary(self) -> str:
        """What was found, in one line."""
        shares = [100 * row.sd / abs(row.value) for row in self.told if row.value and np.isfinite(row.sd)]
        seen = f"parameters to {min(shares):.2g} to {max(shares):.2g} %, given the mass" if shares else "no parameter"
        are = "are" if len(self.not_seen) > 1 else "is"
        unseen = f"; {count_of(len(self.not_seen), 'combination')} {are} not determined" if self.not_seen else ""
        moving = sum(not fit.converged for fit in self.fits)
        blind = f"; {len(self.fits)} fitted" if self.fits else ""
        blind += f", {moving} of them not to rest" if moving else ""
        return f"{self.runs} runs determine {seen}{unseen}{blind}"

    def tables(self) -> list[tuple[str, Sequence[str], Sequence[Sequence[str]]]]:
        """Standard deviations, fits and predictions, as (title, columns, rows of text)."""
        off = 100 * self.misses.shares
        tables: list[tuple[str, Sequence[str], Sequence[Sequence[str]]]] = [
            ("What the campaign's sensors can determine",
             ("parameter", "value", "sd, one run", f"sd, {self.runs} runs", "goes with", "correlation"),
             [(row.name, f"{row.value:.6g} {row.unit}", f"{row.sd_one_run:.2g}", f"{row.sd:.2g}", row.goes_with,
               f"{row.correlation:+.3f}") for row in self.told]),
            ("Fitted by the constraint model without the truth, each run alone; the model's error is not in the sd",
             ("run", "parameter", "nominal", "fitted", "sd", "truth"),
             [(fit.name, name, f"{drawn:.6g} {unit}", f"{value:.6g}",
               f"{np.sqrt(variance):.2g}" if fit.converged else "not at rest",
               f"{true:.6g}" if np.isfinite(true) else "not known")
              for fit in self.fits for name, unit, drawn, value, variance, true in zip(
                  self.names, self.units, self.drawn, fit.design, np.diag(fit.covariance), fit.truth, strict=True)])]
        if len(off) > 1:
            tables.append((
                f"Errors of such fits, from {len(off)} runs of other robots", ("parameter", "mean %", "sd %"),
                [(name, f"{mean:+.2f}", f"{sd:.2f}")
                 for name, mean, sd in zip(self.names, off.mean(axis=0), off.std(axis=0, ddof=1), strict=True)]))
        if self.held_out:
            tables.append((
                f"Runs held out, forecast from {self.held_out[0].begun:g} s",
                ("run", "fit in noises", "fit m/s^2", "fit rad/s", "forecast m/s^2", "forecast rad/s"),
                [(one.name, f"{one.sigmas:.2f}", f"{one.fit_force:.3f}", f"{one.fit_rate:.4f}",
                  f"{one.foretold_force:.3f}", f"{one.foretold_rate:.4f}") for one in self.held_out]))
        return tables  # fmt: skip
