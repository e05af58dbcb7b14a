"""What the model error stage hands on: measures of the gaits of drawn designs by every rung."""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from stages.biped.quantity import quantity
from stages.model_error.measures import MEASURES, NAMES
from stages.studies.result import Table, shown

#: Whether an error of each measure is stated as a share of it.
SHARED = np.array([share for _, _, share in MEASURES])
#: Names of the rungs, the cheapest first.
MODELS = ("constraint model", "constraint model in detail", "penalty walker", "twin")
PENALTY, TWIN = 2, 3
#: Processor time [s] of a gait by each at its first tolerance, the median of drawn designs on one machine. They order
#: the rungs, and are printed.
PRICES = 0.05, 0.06, 0.2, 1.5
#: Numbers of a design by which misses are fitted, in words: what a reader calls them.
FITTED = (
    "mass of a leg over all mass", "foot radius by leg length", "mass centre by leg length", "k l / (m g)",
    "damping ratio", "inertia of a leg by m l^2", "slope", "contact stiffness", "contact damping", "stiction velocity",
)  # fmt: skip
#: Numbers of which the other leg has a share of both legs' mean, and those, of either sign, by which it differs.
SHARES = {
    "foot_mass": "mass", "leg_length": "length", "stiffness": "stiffness", "damping": "damping",
    "foot_radius": "foot radius", "foot_com": "mass centre", "leg_inertia": "inertia", "frame_mass": "frame's mass",
    "frame_inertia": "frame's inertia",
}  # fmt: skip
DIFFERENCES = {"foot_offset": "mass off the leg's line", "frame_com": "frame's mass centre",
               "frame_offset": "frame's mass off the leg's line"}  # fmt: skip
#: These, and the numbers that drawn designs hardly differ in: who leaves them is outside of what was drawn.
NUMBERS = (
    *FITTED, "static friction", "dynamic friction", "friction velocity", "force exponent", "damping depth",
    "frame's mass", "frame's inertia", *DIFFERENCES.values(), "hip's stiffness", "hip's damping", "hip's friction",
    "hip's rest angle", "hip's mass for gravity", "outsole", "bearing friction", "slider friction",
    *(f"{name} of the other leg" for name in (*SHARES.values(), *DIFFERENCES.values())),
)  # fmt: skip
#: Probability that a stated error holds, if misses are normal, and how many standard deviations such an error is.
COVERED = 0.95
WIDTH = NormalDist().inv_cdf(0.5 + 0.5 * COVERED)
#: Fewest draws from which a spread is estimated.
FEWEST = 4
#: The digits of a parameter leave it anywhere between its edges: standard deviation over half width.
EVEN = 1.0 / 3.0**0.5


@dataclass(frozen=True)
class Stability:
    """The probability that the largest multiplier's magnitude is below one, and what it follows from."""

    probability: float = quantity("1", "that the magnitude is below one")
    multiplier: float = quantity("1", "the magnitude, of one step")
    solver: float = quantity("1", "what the model's solver leaves of it")
    model: float = quantity("1", "what the model may miss of the twin")
    inputs: float = quantity("1", "what errors of the parameters leave open; NaN if not known")
    rung: str = quantity("-", "the model")


@dataclass(frozen=True)
class Result:
    """Measures of the gaits of drawn designs by every rung; NaN where a rung was not walked, or has no gait."""

    seed: int = quantity("1", "seed of the draw")
    kind: str = quantity("-", "what no number shows of the designs, all of one kind")
    numbers: np.ndarray = quantity(
        "1", "dimensionless numbers of the drawn designs, in the order of NUMBERS",
        dimensions=("design", "number"))
    values: np.ndarray = quantity(
        "-", "period [s], step frequency [Hz], step length [m], speed [m/s], peak force [N] and magnitude of the "
        "largest multiplier, by constraint model, constraint model in detail, penalty walker, twin",
        dimensions=("ladder", "design", "measure"))
    solver_errors: np.ndarray = quantity(
        "-", "what the solver's error leaves of them, from a second search at ten times the tolerance",
        dimensions=("ladder", "design", "measure"))
    at_the_design: np.ndarray = quantity(
        "-", "errors of the measures at the study's own design: what the solver leaves, the median of the draws; the "
        "model's bias, by which an answer is corrected; what the model may miss beside it; shares, but of multipliers",
        dimensions=("ladder", "measure", "part"))
    without_gait: tuple[str, ...] = quantity("-", "designs of which a rung has no gait, and why")
    stability: Stability | None = quantity(
        "-", "whether the gait of the study's own design is stable; none where no model has an error that is known",
        default=None)

    def __post_init__(self) -> None:
        """Raises ValueError for one of an earlier version."""
        if self.values.shape[-1] != len(MEASURES):
            raise ValueError("of other measures")

    def misses(self, rung: int) -> np.ndarray:
        """What a rung misses of the penalty walker, and that of the twin, (n, k), of gaits that both find stable: as a
        share, multipliers by themselves."""
        better = TWIN if rung == PENALTY else PENALTY
        both = (self.values[rung, :, -1] < 1.0) & (self.values[better, :, -1] < 1.0)
        one, other = self.values[rung, both], self.values[better, both]
        return np.asarray(np.where(SHARED, other / one - 1.0, other - one))

    def summary(self) -> str:
        """One line of what was found."""
        frequency = NAMES.index("step_frequency")
        parts = [f"the {name} {100 * found.mean():+.2f} % "
                + (f"with a spread of {100 * found.std():.2f} %" if len(found) >= FEWEST else f"in {len(found)} alone")
                for rung, name in enumerate(MODELS[:PENALTY])
                if len(found := self.misses(rung)[:, frequency])]  # fmt: skip
        misses = "the penalty walker's step frequency from " + ", ".join(parts)
        return f"{len(self.numbers)} designs; {misses if parts else 'none has a stable gait by two models'}"

    def tables(self) -> list[Table]:
        """Mean and spread of each rung's misses, as (title, columns, rows)."""
        rows: list[list[object]] = []
        for rung, name in enumerate(MODELS[:TWIN]):
            found = self.misses(rung)
            for measure, (word, _, share) in enumerate(MEASURES if len(found) else ()):
                if np.isnan(found[:, measure]).any():
                    continue  # what the model does not have
                mean, spread = found[:, measure].mean(), found[:, measure].std()
                unit = "of it" if share else "1"
                rows.append([name, MODELS[TWIN if rung == PENALTY else PENALTY], word, unit, *shown(mean, spread),
                             len(found)])  # fmt: skip
                if len(found) == 1:
                    rows[-1][5] = "none"
        return [
            ("What each model misses of the next better one", ("model", "of", "measure", "unit", "mean", "spread",
                                                               "designs"), rows),
            ("What solver and model leave of a measure at the study's own design",
             ("model", *(f"{name} [{'of it' if share else '1'}]" for name, _, share in MEASURES)),
             [[name, *("none" if np.isnan(whole) else float(shown(float(whole))[0])
                       for whole in self.at_the_design[rung][:, (0, 2)].sum(axis=1))]
              for rung, name in enumerate(MODELS)]),
            ("Designs without a gait", ("why",), [[why] for why in self.without_gait]),
        ]  # fmt: skip
