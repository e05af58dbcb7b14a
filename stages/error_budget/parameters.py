"""Settings of the error budget."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from stages.biped.accuracy.scales import Following, scales_of, similar
from stages.biped.accuracy.tolerances import CLOSER, ConstraintTolerance, PenaltyTolerance, checked
from stages.biped.quantity import Bound, Broken, parameter
from stages.ground.contact_law import OnGround

#: So many times as fine, at least, is the tolerance that measures another's error.
TIGHTER = 10.0
#: What null is for Table 1's robot, as in the contact study.
OF_TABLE_1 = {"impact_window": 1e-3}


@dataclass(frozen=True)
class Settings:
    """How far effects are driven to their limits, and how accurately all is integrated."""

    FILE: ClassVar[str] = "error_budget"

    step_share: float = parameter(
        "1",
        "least of three shares (4, 2, 1 times it) that an effect is lowered to, in a step",
        bound=Bound(above=0, maximum=0.2),
    )
    cycle_share: float = parameter("1", "the same between cycles", bound=Bound(above=0, maximum=0.2))
    constraint_tolerance: float | None = parameter(
        "1", "tolerance of the constraint model, dimensionless; null: analytic.tolerance",
        bound=Bound(minimum=1e-13, maximum=1e-3), closer=CLOSER)
    constraint_fine_tolerance: float = parameter(
        "1", "the tighter one that measures its integration error",
        bound=Bound(minimum=1e-14, maximum=1e-3), closer=CLOSER)
    penalty_tolerance: float | None = parameter(
        "1", "tolerance of the penalty model, in leg lengths and pendulum times; null: multibody.tolerance",
        bound=Bound(minimum=1e-12, maximum=1e-3), closer=CLOSER)
    limit_tolerance: float = parameter(
        "1",
        "tolerance of the penalty model in limits, where only contact is fast",
        bound=Bound(minimum=1e-11, maximum=1e-3), closer=CLOSER)
    penalty_fine_tolerance: float = parameter(
        "1", "the tighter one that measures its integration error",
        bound=Bound(minimum=1e-11, maximum=1e-3), closer=CLOSER)
    paper_constraint_tolerance: float = parameter(
        "1", "tolerance of the paper's constraint model", bound=Bound(minimum=1e-13, maximum=1e-3)
    )
    paper_penalty_tolerance: float = parameter(
        "1", "tolerance of the paper's multibody model", bound=Bound(minimum=1e-11, maximum=1e-3)
    )
    impact_window: Following = parameter(
        "s", "time after heel strike in which velocities are not compared", bound=Bound(minimum=0, maximum=1))
    points: int = parameter("1", "points of the curves over a step", bound=Bound(minimum=51, maximum=100_001))
    checked: int = parameter(
        "1", "steps with random laws of the budget that Exudyn walks too",
        bound=Bound(minimum=0, maximum=10), closer=0)
    checked_tolerance: float | None = parameter(
        "1", "tolerance of Exudyn's solver in what it walks too; null: a hundredth of penalty_tolerance",
        bound=Bound(minimum=1e-11, maximum=1e-6), closer=CLOSER)

    def broken_rules(self) -> Iterator[Broken]:
        """The fine tolerances are tighter."""
        for model in ("constraint", "penalty"):
            own, fine = f"{model}_tolerance", f"{model}_fine_tolerance"
            if getattr(self, own) is not None and getattr(self, fine) >= getattr(self, own):
                yield Broken(fine, f"< {own} = {getattr(self, own):g}")


@dataclass(frozen=True)
class Parameters(OnGround):
    """All parameters the stage uses."""

    settings: Settings
    constraint: ConstraintTolerance
    penalty: PenaltyTolerance

    def __post_init__(self) -> None:
        """The window follows the robot where it is null."""
        own = scales_of(self.biped, self.slope.gravity)
        object.__setattr__(self, "settings", similar(self.settings, OF_TABLE_1, own))

    @property
    def constraint_tolerance(self) -> float:
        """Tolerance of the constraint model."""
        given = self.settings.constraint_tolerance
        return given or max(self.constraint.tolerance, TIGHTER * self.settings.constraint_fine_tolerance)

    @property
    def penalty_tolerance(self) -> float:
        """Tolerance of the penalty model."""
        given = self.settings.penalty_tolerance
        return given or max(self.penalty.tolerance, TIGHTER * self.settings.penalty_fine_tolerance)

    @property
    def checked_tolerance(self) -> float:
        """Tolerance of Exudyn's solver in what it walks too."""
        return self.settings.checked_tolerance or checked(self.penalty_tolerance)
