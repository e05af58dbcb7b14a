"""Settings of the multibody stage."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from stages.biped.accuracy.estimate import finer_explicit
from stages.biped.accuracy.tolerances import CLOSER, Accuracy, PenaltyTolerance, accuracy
from stages.biped.quantity import Bound, Broken, parameter
from stages.ground.blocks import Blocks
from stages.ground.contact_law import OnGround
from stages.planar.signals import READ_LATER, SIGNALS


@dataclass(frozen=True)
class Settings(PenaltyTolerance):
    """How the multibody model is assembled, integrated and sampled."""

    assembly: str = parameter(
        "-", "tree: minimal coordinates, explicit; joints: bodies and joints, implicit", choices=("tree", "joints")
    )
    steps: int = parameter("1", "steps to walk", bound=Bound(minimum=1, maximum=10000))
    sampling_rate_hz: float = parameter("Hz", "rate of the sampled signals", bound=Bound(above=0, maximum=1e5))
    largest_step: float = parameter("s", "largest step of the explicit solver", bound=Bound(above=0, maximum=1e-2))
    implicit_solver: str = parameter("-", "solver of the joints assembly", choices=("trapezoidal", "generalized_alpha"))
    rolling_step: float = parameter(
        "s", "step of the implicit solver away from heel strike", bound=Bound(above=0, maximum=1e-2), closer=0.5
    )
    impact_step: float = parameter(
        "s", "step of the implicit solver around heel strike", bound=Bound(above=0, maximum=1e-2), closer=0.5
    )
    impact_window: float = parameter("s", "time after heel strike with impact_step", bound=Bound(minimum=0, maximum=1))
    longest_step: float | None = parameter(
        "s", "time without a heel strike after which the walk counts as stalled; null: some three steps of its size",
        bound=Bound(above=0, maximum=100))

    scene: str = parameter(
        "-", "ideal: no scuffing; blocks: stepping blocks one step apart", choices=("ideal", "blocks"), default="ideal"
    )
    most_solver_steps: int = parameter(
        "1",
        "solver steps without a heel strike after which the solver is stuck",
        bound=Bound(minimum=1000, maximum=10**7),
        default=500_000,
    )
    signals: tuple[str, ...] = parameter(
        "-", "signals recorded beside the motion, sampled at sampling_rate_hz", choices=SIGNALS, default=READ_LATER
    )
    coarse: float = parameter(
        "1", "tolerance on the way to the gait and in its derivatives; the gait's own is no looser",
        bound=Bound(minimum=1e-10, maximum=1e-6), default=1e-7, closer=CLOSER)
    accuracy: str | Accuracy = accuracy("tolerance and largest_step, or rolling_step and impact_step of the joints")

    @classmethod
    def of_one_step(cls, tolerance: float, largest_step: float) -> Settings:
        """One step by the explicit solver of the tree assembly; what belongs to the other assembly is not used."""
        return cls(
            assembly="tree",
            steps=1,
            sampling_rate_hz=1000.0,
            tolerance=tolerance,
            largest_step=largest_step,
            implicit_solver="trapezoidal",
            rolling_step=1e-4,
            impact_step=1e-5,
            impact_window=0.02,
            longest_step=None,
            most_solver_steps=500_000,
        )

    def finer(self, by: float) -> Settings | None:
        """Settings of the solver with so many times the tolerance, or steps of an error so many times as large.

        None beyond the finest tolerance or steps of 100 ns; steps are not made coarser than they are.
        """
        if self.assembly == "tree":
            return finer_explicit(self, by)
        share = max(by**0.5, 1e-7 / self.impact_step)
        if share >= 1.0:
            return None
        return replace(self, rolling_step=self.rolling_step * share, impact_step=self.impact_step * share)

    def broken_rules(self) -> Iterator[Broken]:
        """The fine step is not coarser than the coarse one; a signal is named once."""
        if len(set(self.signals)) < len(self.signals):
            yield Broken("signals", "each of " + ", ".join(SIGNALS) + " at most once")
        if self.impact_step > self.rolling_step:
            yield Broken("impact_step", f"<= rolling_step = {self.rolling_step:g} s")


@dataclass(frozen=True)
class Parameters(OnGround):
    """All parameters the stage uses."""

    settings: Settings
    blocks: Blocks = Blocks()

    def at(self, tolerance: float) -> Parameters:
        """The same at another tolerance of the solver."""
        return replace(self, settings=replace(self.settings, tolerance=tolerance))

    def broken_rules(self) -> Iterator[Broken]:
        """Bodies and joints have no frames on rigid legs."""
        frames = [key for key in self.biped.details if "frame_" in key]
        if frames and self.biped.legs == "rigid" and self.settings.assembly == "joints":
            yield Broken("multibody.assembly", f"tree with rigid legs and biped.{frames[0]}")
