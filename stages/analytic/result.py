"""What the analytic stage hands on, and what is kept of explorations: families and basins."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from stages.biped.accuracy.estimate import ErrorEstimate
from stages.biped.quantity import LEFT, quantity
from stages.biped.walk import Gait, Limp, StanceState, Walk

#: A sliding foot uses all the friction there is, up to this share.
ROUND_OFF = 1e-9


@dataclass(frozen=True)
class EnergyAudit:
    """Energies of one step of a periodic gait [J]; `residual` is what does not close, relative to gravity's work."""

    gravity_work: float = quantity("J", "work of gravity over one step", symbol="W_g")
    damper_loss: float = quantity("J", "energy taken by dampers, and by friction at the hip, over one step")
    impact_loss: float = quantity("J", "kinetic energy lost in impacts")
    friction_loss: float = quantity("J", "energy taken by sliding of the trailing foot over one step")
    residual: float = quantity("1", "(work - losses) / work; zero if the audit closes")


@dataclass(frozen=True)
class Elasticities:
    """How the gait answers to one parameter: change in a share for a share of it, d ln measure / d ln parameter.

    For a parameter that is zero, a share is one of `scale`, a size it could have.
    """

    parameter: str = quantity("-", "parameter, as file.key")
    unit: str = quantity("-", "its unit")
    value: float = quantity("-", "its value, in that unit")
    half_width: float = quantity("-", "how far it may be off, in that unit; 0: exact")
    scale: float = quantity("-", "what a share is of, in that unit: the value, unless that is zero")
    period: float = quantity("1", "elasticity of the duration of a step")
    step_length: float = quantity("1", "elasticity of the step length")
    speed: float = quantity("1", "elasticity of the speed")


@dataclass(frozen=True)
class Uncertainty:
    """How far one number of the gait may be off, in its own unit; NaN where it has no derivative."""

    name: str = quantity("-", "which number: a field of Gait, of its fixed point, or the magnitude of a multiplier")
    unit: str = quantity("-", "its unit")
    value: float = quantity("-", "the number")
    worst: float = quantity("-", "all values off by their half-widths, at the worst; fitted ones as they go together")
    independent: float = quantity(
        "-", "the same as independent errors, or as fitted ones go together: root of the sum of squares")
    decisive: str = quantity("-", "the parameter of the design that may move it most")
    decisive_part: float = quantity("-", "by how much that one may move it")
    slope_least: float = quantity("-", "its least on slopes within the slope's half-width; NaN: no gait on some")
    slope_most: float = quantity("-", "its most there")

    def of_a_step(self, steps: int) -> Uncertainty:
        """What this, of a multiplier's magnitude over so many steps, is of one step's, to first order."""
        change = self.value ** (1.0 / steps - 1.0) / steps
        return replace(
            self, value=self.value ** (1.0 / steps), worst=change * self.worst, independent=change * self.independent,
            decisive_part=change * self.decisive_part, slope_least=self.slope_least ** (1.0 / steps),
            slope_most=self.slope_most ** (1.0 / steps))


@dataclass(frozen=True)
class OutsoleEffect:
    """The gait on an outsole; NaN where there is none."""

    thickness: float = quantity("m", "thickness of the outsole")
    mass: float = quantity("kg", "mass of a leg's rubber")
    frequency_without_mass: float = quantity("Hz", "step frequency on a layer without mass")
    frequency_with_mass: float = quantity("Hz", "step frequency on a layer with its mass")
    turning_mass: float = quantity("kg", "mass a leg of a layer that leaves the step frequency as it is; NaN: none")


@dataclass(frozen=True)
class Variation:
    """One design parameter changed alone, by the same share down and up."""

    name: str = quantity("-", "design parameter")
    change: float = quantity("1", "relative change")
    multiplier_below: float = quantity("1", "largest multiplier with the parameter lowered; NaN without a gait")
    multiplier_above: float = quantity("1", "largest multiplier with the parameter raised; NaN without a gait")
    frequency_below: float = quantity("Hz", "step frequency with the parameter lowered; NaN without a gait")
    frequency_above: float = quantity("Hz", "step frequency with the parameter raised; NaN without a gait")


@dataclass(frozen=True)
class NumericalError:
    """Estimated errors of the numbers computed, from the errors of the integrator's steps; NaN where none can be given.

    Period and step length are those of the gait, the hip's path and the steps' durations those of the walk.
    """

    period: float = quantity("s", "error of the gait's period, exact minus computed")
    step_length: float = quantity("m", "error of the gait's step length, exact minus computed")
    hip_position: float = quantity("m", "largest error of the hip over the walk")
    step_duration: float = quantity("s", "largest error of a step's duration over the walk")
    checked: str = quantity("-", "why the estimates are given, or why they are not")

    @property
    def given(self) -> bool:
        """Whether the estimates are given, but for a number whose leading terms cancel."""
        return bool(np.isfinite(self.hip_position))


@dataclass(frozen=True)
class OnBlocks:
    """Spread of a gait's steps on blocks of independent normal heights, to first order; it grows with their height."""

    sensitivity_norm: float = quantity(
        "s/m", "gait sensitivity norm: spread of a step's duration over the rms height of blocks")
    sensitivity_norm_deg: float = quantity("s/deg", "the same over the slope of that height on a step's length")
    step_length_spread: float = quantity("1", "spread of the step length over the rms height of blocks")
    section_spread: np.ndarray = quantity(
        "1", "spread of the section's coordinates over that height, in leg lengths and pendulum times",
        dimensions=("coordinate",))


@dataclass(frozen=True)
class Validity:
    """Forces the gait needs of the ground, and its scuffing. Friction is |tangential| / normal; infinite for a pull.

    Least and largest values are the solution's own, between its steps and at the ends of phases, not of its samples.
    In double stance friction has no largest value: towards toe-off the trailing foot's normal force vanishes before the
    tangential one. So it is stated how long the foot is outside of the friction cone, and what it needs while loaded.
    """

    least_normal_force_stance: float = quantity("N", "least normal force of the leading or only stance foot")
    least_normal_force_trailing: float = quantity("N", "least normal force of the trailing foot in double stance")
    friction_single_stance: float = quantity("1", "largest friction used in single stance")
    friction_double_stance_loaded: float = quantity(
        "1", "largest friction used in double stance by a foot that bears a tenth of its largest normal force there"
    )
    friction_there_is: float = quantity("1", "static friction of the ground, by which the next two are judged")
    time_outside_cone: float = quantity("1", "part of double stance in which the trailing foot needs more friction")
    impulse_outside_cone: float = quantity("1", "part of its tangential impulse in double stance that falls in then")
    impulse_friction_landing: float = quantity("1", "friction the impulse needs at the landing foot")
    impulse_friction_trailing: float = quantity("1", "friction the impulse needs at the trailing foot")
    impulse_normal_trailing: float = quantity("N s", "normal impulse on the trailing foot; negative is a pull")
    deepest_scuff: float = quantity("m", "depth of the swing foot below ground at mid-swing")
    deepest_scuff_angle: float = quantity("rad", "stance angle at the deepest scuff; not a number where no foot scuffs")
    feet_push_only: bool = quantity("1", "whether every normal force and impulse pushes")


def of_friction(needed: float, digits: str = ".3g") -> str:
    """A friction that a gait needs (1), in words where the ground would have to pull instead."""
    return f"{needed:{digits}}" if needed < math.inf else "a pull"


@dataclass(frozen=True)
class WithoutImpact:
    """The landing foot at acceleration level without an impact; zero for rigid legs."""

    duration: float = quantity("s", "time integrated, that of the gait's double stance")
    slip_at_landing: float = quantity("m/s", "slip of the landing foot just before heel strike, downhill positive")
    descent_at_landing: float = quantity("m/s", "descent of the landing foot just before heel strike")
    slip_at_end: float = quantity("m/s", "its slip after double stance, were there no impact")
    descent_at_end: float = quantity("m/s", "its descent after double stance, were there no impact")
    depth_at_end: float = quantity("m", "how far it has come into the ground by then")


@dataclass(frozen=True)
class Result:
    """The constraint model's gait and a walk on it that starts at mid-stance."""

    gait: Gait = quantity("-", "the most stable gait of the design")
    limp: Limp = quantity("-", "the two steps of that gait, which are the same where the legs are alike")
    mid_stance: StanceState = quantity("-", "state of that gait with the stance leg upright, single stance")
    residual: float = quantity(
        "1", "how far the fixed point moves in one step, in leg lengths and pendulum times", without_error=LEFT)
    monodromy_matrix: np.ndarray = quantity("1", "derivative of the step map at the fixed point, dimensionless, (j, j)")
    energy: EnergyAudit = quantity("-", "energy audit of one step")
    constraint_drift: np.ndarray = quantity(
        "1", "clearance, normal and slip velocity of the trailing foot at toe-off, dimensionless, shape (3,)",
        without_error=LEFT)
    variations: tuple[Variation, ...] = quantity("-", "largest multiplier with one design parameter changed")
    elasticities: tuple[Elasticities, ...] = quantity("-", "how the gait answers to each parameter; none on a fold")
    uncertainties: tuple[Uncertainty, ...] = quantity(
        "-", "how far the gait's numbers may be off for the last digits of the parameters; none if all are exact")
    without_impact: WithoutImpact = quantity("-", "the landing foot in double stance if no impact stopped it")
    outsole: OutsoleEffect = quantity("-", "the gait with rubber under the feet")
    validity: Validity = quantity("-", "what the gait needs of the ground")
    walk: Walk = quantity("-", "walk from mid-stance, leg 0 standing")
    numerical_error: NumericalError = quantity("-", "estimated errors of gait and walk")
    errors: tuple[ErrorEstimate, ...] = quantity("-", "errors of gait and walk, where an accuracy was requested")

    def summary(self) -> str:
        """What was found, in one line."""
        kind = "stable" if self.gait.stable else "unstable"
        return f"{kind} gait: {self.gait.step_frequency_hz:.3f} Hz, |multiplier| {self.gait.largest_multiplier:.3f}"


@dataclass(frozen=True)
class Inputs:
    """What a stage reads that begins at the constraint model's gait."""

    analytic: Result


#: Multipliers as near to the unit circle as this are on it.
ON_CIRCLE = 1e-7
#: How a walk ends, in words; a walk is known by its number here.
ENDINGS = (
    "reaches the gait", "walks on, elsewhere", "falls forward", "falls or rocks back", "stands still or rocks",
    "ends otherwise", "no such start",
)  # fmt: skip
REACHES, WALKS_ON, FORWARD, BACK, STILL, OTHERWISE, NO_START = range(len(ENDINGS))


@dataclass(frozen=True)
class Basin:
    """Map over angle and rate of the stance leg just after heel strike, the other section coordinates as the gait's."""

    stance_angle: np.ndarray = quantity(
        "rad", "stance angle at the start, foot ahead positive, (n,)", dimensions=("stance_angle",))
    stance_rate: np.ndarray = quantity("rad/s", "stance rate at the start, (m,)", dimensions=("stance_rate",))
    steps: np.ndarray = quantity(
        "1", "steps made until the walk reaches a gait or ends, at most `most_steps`, (n, m)",
        dimensions=("stance_angle", "stance_rate"))
    reached: np.ndarray = quantity(
        "1", "number of the gait that is reached, -1: none, (n, m)", dimensions=("stance_angle", "stance_rate"))
    ending: np.ndarray = quantity(
        "1", "how the walk ends, the place in `endings`, (n, m)", dimensions=("stance_angle", "stance_rate"))
    gait_angle: float = quantity("rad", "stance angle of the first gait, foot ahead positive")
    gait_rate: float = quantity("rad/s", "stance rate of the first gait")
    most_steps: int = quantity("1", "most steps of a walk")
    near: float = quantity("1", "a walk is at a gait within this, in all section coordinates")
    endings: tuple[str, ...] = quantity("-", "how a walk ends, in words", default=ENDINGS)

    @property
    def share(self) -> float:
        """Part of the starts that reach a gait."""
        return float((self.ending == REACHES).mean())


@dataclass(frozen=True)
class Turn:
    """A gait where its family turns back, doubles its period, or is left by a torus."""

    kind: str = quantity("-", "turning point, period doubling or torus")
    value: float = quantity("1", "value of the parameter, in its unit")
    multiplier: float = quantity("1", "real part of the multiplier that is nearest to the one of its kind: 1, -1")
    step_duration: np.ndarray = quantity("s", "duration of each step of the cycle, (cycle,)")
    stance_angle: np.ndarray = quantity("rad", "stance angle at heel strike, foot ahead positive, (cycle,)")


@dataclass(frozen=True)
class RecordedFamily:
    """Gaits of `cycle` steps over a parameter, n in order along the curve.

    Where the legs differ, steps are counted in pairs: a gait has `cycle` strides.
    """

    cycle: int = quantity("1", "steps after which the gait repeats")
    ended: str = quantity("-", "why the family ends, down and up the parameter, or away from the doubling")
    value: np.ndarray = quantity("1", "value of the parameter, in its unit, (n,)", dimensions=("gait",))
    step_duration: np.ndarray = quantity(
        "s", "duration of each step of the cycle, (n, cycle)", dimensions=("gait", "step"))
    stance_angle: np.ndarray = quantity(
        "rad", "stance angle at each heel strike, foot ahead positive, (n, cycle)", dimensions=("gait", "step"))
    double_stance: np.ndarray = quantity(
        "s", "time of each step with both feet on the ground, (n, cycle)", dimensions=("gait", "step"))
    floquet_multipliers: np.ndarray = quantity(
        "1", "multipliers of the whole cycle, largest first, rows of real and imaginary part, (n, j, 2)",
        dimensions=("gait", "multiplier", "part"))
    turns: tuple[Turn, ...] = quantity("-", "turning points, period doublings and tori")

    @property
    def steps(self) -> int:
        """Steps after which the gait repeats."""
        return int(self.step_duration.shape[1])

    def stable_at(self, value: float) -> bool:
        """Whether there is a stable gait at a value of the parameter: between two that are, one after the other."""
        side, both = self.value <= value, self.stable[1:] & self.stable[:-1]
        return bool((both & (side[1:] != side[:-1])).any())

    @property
    def stable(self) -> np.ndarray:
        """Whether every multiplier lies inside the unit circle, (n,); at a turn one is on it."""
        magnitude = np.hypot(self.floquet_multipliers[..., 0], self.floquet_multipliers[..., 1])
        return np.asarray(magnitude.max(axis=1) < 1.0 - ON_CIRCLE)
