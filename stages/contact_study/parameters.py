"""Settings of the contact study."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from stages.biped.accuracy.scales import Following, Followings, scales_of, similar
from stages.biped.accuracy.tolerances import CLOSER, ConstraintTolerance, PenaltyTolerance, checked
from stages.biped.quantity import Bound, Broken, parameter
from stages.ground.contact_law import DefaultSet, OnGround

#: What null is for Table 1's robot.
OF_TABLE_1: Mapping[str, float | tuple[float, ...]] = {
    "stiffness_values": (1e4, 3e4, 1e6, 1e7), "damping_values": (1e2, 1e3, 3e4, 1e5),
    "depth_values": (1e-5, 3e-5, 3e-4, 1e-3), "stiction_velocity_values": (0.01, 0.02, 0.05, 0.2),
    "friction_velocity_values": (0.2, 0.5, 2.0, 5.0), "searched_stiffness": (1e5, 3e5, 1e6),
    "searched_damping": (1e4, 3e4), "searched_depth": (1e-5, 3e-5, 1e-4),
    "searched_stiction_velocity": (0.01, 0.02, 0.03, 0.05, 0.1), "position_limit": 3e-4, "velocity_limit": 5e-3,
    "sampling_rate_hz": 2000.0, "impact_window": 1e-3,
}  # fmt: skip


@dataclass(frozen=True)
class Settings:
    """The values to which the default set is varied, the criterion of the choice, and how a step is integrated."""

    FILE: ClassVar[str] = "contact_study"

    stiffness_values: Followings = parameter("N/mm^e", "stiffnesses tried one at a time", bound=Bound(above=0))
    exponent_values: tuple[float, ...] = parameter("1", "force exponents tried one at a time", bound=Bound(minimum=1))
    damping_values: Followings = parameter("N s/m", "dampings tried one at a time", bound=Bound(minimum=0))
    depth_values: Followings = parameter("m", "depths tried one at a time", bound=Bound(above=0))
    stiction_velocity_values: Followings = parameter(
        "m/s", "stiction velocities tried one at a time", bound=Bound(above=0)
    )
    friction_velocity_values: Followings = parameter(
        "m/s", "friction velocities tried one at a time", bound=Bound(above=0)
    )

    position_limit: Following = parameter("m", "hip difference that counts one in the score", bound=Bound(above=0))
    velocity_limit: Following = parameter("m/s", "hip velocity difference that counts one", bound=Bound(above=0))
    cost_limit: float = parameter(
        "1", "evaluations a step of a chosen set may take, in those of the starting set", bound=Bound(above=0)
    )
    searched_stiffness: Followings = parameter("N/mm^e", "stiffnesses of the search", bound=Bound(above=0))
    searched_damping: Followings = parameter("N s/m", "dampings of the search", bound=Bound(minimum=0))
    searched_depth: Followings = parameter("m", "depths of the search", bound=Bound(above=0))
    searched_stiction_velocity: Followings = parameter(
        "m/s", "stiction velocities of the search", bound=Bound(above=0)
    )
    finalists: int = parameter(
        "1", "best sets over one step that are compared between cycles", bound=Bound(minimum=1, maximum=1000)
    )
    family_shares: tuple[float, ...] = parameter(
        "1", "shares of the chosen set's impact and creep in sets nearer to the limit", bound=Bound(above=0)
    )

    constraint_tolerance: float | None = parameter(
        "1", "tolerance of the constraint models; null: analytic.tolerance",
        bound=Bound(minimum=1e-14, maximum=1e-3), closer=CLOSER)
    sampling_rate_hz: Following = parameter(
        "Hz", "rate at which the rigid limit is compared", bound=Bound(minimum=100, maximum=1e5)
    )
    impact_window: Following = parameter(
        "s", "time after heel strike in which velocities and forces are not compared", bound=Bound(minimum=0, maximum=1)
    )
    tolerance: float | None = parameter(
        "1", "tolerance of the penalty model, in leg lengths and pendulum times; null: multibody.tolerance",
        bound=Bound(minimum=1e-12, maximum=1e-3), closer=CLOSER)
    cost_tolerance: float = parameter(
        "1", "tolerance at which the evaluations of a step are counted", bound=Bound(minimum=1e-12, maximum=1e-3)
    )
    between: int = parameter(
        "1", "moments between two steps of the solver at which forces are kept", bound=Bound(minimum=0, maximum=100)
    )
    checked: int = parameter(
        "1", "steps with random sets that Exudyn walks too; with more than one, a cycle as well",
        bound=Bound(minimum=1, maximum=1000), closer=0)
    checked_tolerance: float | None = parameter(
        "1", "tolerance of Exudyn's solver in what it walks too; null: a hundredth of tolerance",
        bound=Bound(minimum=1e-11, maximum=1e-6), closer=CLOSER)
    most_solver_steps: int = parameter(
        "1",
        "solver steps without a heel strike after which a run is given up",
        bound=Bound(minimum=1000, maximum=10**7),
    )

    def broken_rules(self) -> Iterator[Broken]:
        """There is something to search."""
        for key in ("searched_stiffness", "searched_damping", "searched_depth", "searched_stiction_velocity"):
            if getattr(self, key) == ():
                yield Broken(key, "at least one value")


@dataclass(frozen=True)
class Parameters(OnGround):
    """All parameters the stage uses. Of `contact` the choice of laws and the coefficients of friction are kept."""

    default_set: DefaultSet
    settings: Settings
    constraint: ConstraintTolerance
    penalty: PenaltyTolerance

    def __post_init__(self) -> None:
        """Sizes that are null follow the robot."""
        own, exponent = scales_of(self.biped, self.slope.gravity), self.default_set.default_exponent
        object.__setattr__(self, "default_set", self.default_set.of(own))
        object.__setattr__(self, "settings", similar(self.settings, OF_TABLE_1, own, exponent))

    @property
    def constraint_tolerance(self) -> float:
        """Tolerance of the constraint models."""
        return self.settings.constraint_tolerance or self.constraint.tolerance

    @property
    def penalty_tolerance(self) -> float:
        """Tolerance of the penalty model."""
        return self.settings.tolerance or self.penalty.tolerance

    @property
    def checked_tolerance(self) -> float:
        """Tolerance of Exudyn's solver in what it walks too."""
        return self.settings.checked_tolerance or checked(self.penalty_tolerance)

    def broken_rules(self) -> Iterator[Broken]:
        """The transition velocities are in order, in the default set and in all that it is varied to."""
        default, settings = self.default_set, self.settings
        highest = max(
            (default.default_stiction_velocity, *settings.stiction_velocity_values,
             *settings.searched_stiction_velocity)
        )  # fmt: skip
        if highest >= default.default_friction_velocity:
            allowed = f"> {highest:g} m/s, the greatest stiction velocity"
            yield Broken("contact_study.default_friction_velocity", allowed)
        lowest = min((default.default_friction_velocity, *settings.friction_velocity_values))
        if lowest <= default.default_stiction_velocity:
            allowed = f"< {lowest:g} m/s, the least friction velocity"
            yield Broken("contact_study.default_stiction_velocity", allowed)
