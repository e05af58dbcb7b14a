"""What the analytic stage needs to know."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from typing import ClassVar

from stages.biped.accuracy.tolerances import Accuracy, ConstraintTolerance, accuracy
from stages.biped.design import Biped
from stages.biped.quantity import Bound, Broken, broken, half_widths, parameter
from stages.biped.rubber import Rubber
from stages.ground.slope import Friction, OnSlope, Slope


@dataclass(frozen=True)
class Settings(ConstraintTolerance):
    """Accuracy of the integration and what is recorded."""

    steps: int = parameter("1", "steps of the recorded walk", bound=Bound(minimum=1, maximum=10_000))
    sampling_rate_hz: float = parameter("Hz", "sampling rate of the recorded walk", bound=Bound(above=0, maximum=1e6))
    integrator: str = parameter(
        "-", "what computes the gait: compiled code with exact derivatives, or SciPy step by step",
        choices=("compiled", "scipy"), default="compiled")
    transition: str = parameter(
        "-", "trailing foot from heel strike to toe-off: rolls whatever it takes, or has Coulomb friction and no pull",
        choices=("rolling", "coulomb"), default="rolling")
    outsole: float = parameter(
        "m", "rubber under the feet, whose effect on the gait is reported", bound=Bound(above=0), default=0.002)
    accuracy: str | Accuracy = accuracy("tolerance")

    def limited(self, friction: Friction) -> Friction | None:
        """The ground's friction as far as it limits the trailing foot: None where that rolls whatever it takes."""
        return friction if self.transition == "coulomb" else None

    def broken_rules(self) -> Iterator[Broken]:
        """The readable path knows rolling feet only."""
        return broken((self.transition == "coulomb" and self.integrator == "scipy", "integrator",
                       "compiled with transition = coulomb (the SciPy path knows rolling feet only)"))  # fmt: skip


@dataclass(frozen=True)
class Correlation:
    """How the errors of two values, by their file.key, go together."""

    one: str = parameter("-", "a parameter, as biped.hip_mass")
    other: str = parameter("-", "another")
    correlation: float = parameter("1", "correlation of their errors", bound=Bound(minimum=-1, maximum=1))


@dataclass(frozen=True)
class DesignDigits:
    """How far the values of the design may be off, in their units: half of a last digit printed, or what is given."""

    FILE: ClassVar[str] = Biped.FILE

    half_widths: Mapping[str, float] = half_widths("half-widths of the design's values")
    correlations: tuple[Correlation, ...] = parameter(
        "-", "how errors of values go together", default=())

    def broken_rules(self) -> Iterator[Broken]:
        """Errors that go together are those of parameters that there are, each pair once."""
        known = {f"{cls.FILE}.{each.name}" for cls in (Biped, Slope) for each in fields(cls)}
        wrong = [name for each in self.correlations for name in (each.one, each.other)
                 if name not in known or each.one == each.other]  # fmt: skip
        pairs = [{each.one, each.other} for each in self.correlations]
        yield from broken((bool(wrong), "correlations",
                           f"of two parameters of the design, by file.key, not of {', '.join(wrong[:1])}"),
                          (any(pair in pairs[:row] for row, pair in enumerate(pairs)), "correlations",
                           "each pair of parameters once"))  # fmt: skip


@dataclass(frozen=True)
class SlopeDigits:
    """The same for the slope and what else the ground's file has."""

    FILE: ClassVar[str] = Slope.FILE

    half_widths: Mapping[str, float] = half_widths("half-widths of the slope's values")


@dataclass(frozen=True)
class Rounded:
    """What a stage knows of how far the values that it is handed may be off."""

    design_digits: DesignDigits = field(default=DesignDigits(), kw_only=True)
    slope_digits: SlopeDigits = field(default=SlopeDigits(), kw_only=True)

    @property
    def half_widths(self) -> dict[str, float]:
        """How far parameters may be off, in their units, by file.key; exact ones are not in it."""
        both = self.design_digits, self.slope_digits
        return {f"{each.FILE}.{key}": width for each in both for key, width in each.half_widths.items()}

    @property
    def correlations(self) -> dict[tuple[str, str], float]:
        """How errors of parameters go together, by file.key of both; others are independent."""
        return {(each.one, each.other): each.correlation for each in self.design_digits.correlations}


@dataclass(frozen=True)
class Parameters(Rounded, OnSlope):
    """Parameters of the analytic stage."""

    friction: Friction
    rubber: Rubber
    settings: Settings

    def broken_rules(self) -> Iterator[Broken]:
        """The readable path knows Table 1's biped only; a hip with Coulomb friction goes with feet that roll."""
        biped, scipy = self.biped, self.settings.integrator == "scipy"
        return broken(
            (biped.hip_friction > 0 and biped.legs == "compliant" and self.limited_friction is not None,
             "biped.hip_friction",
             "0 N m with analytic.transition = coulomb (Coulomb friction at the hip is known with a trailing foot that "
             "rolls)"),
            (scipy and biped.detailed, "analytic.integrator", f"compiled with biped.{''.join(biped.details[:1])} (the "
             "SciPy path knows Table 1's biped only)"))

    @property
    def limited_friction(self) -> Friction | None:
        """Friction of the trailing foot; None where it rolls whatever that takes."""
        return self.settings.limited(self.friction)
