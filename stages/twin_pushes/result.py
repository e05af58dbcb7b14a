"""What the pushes stage hands on."""

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.studies.result import COMPLETED, Table


@dataclass(frozen=True)
class PushedWalk:
    """A walk after one push; the histories run from the push to the end of the walk or to the fall."""

    kind: str = quantity("-", "what the push changes")
    unit: str = quantity("-", "unit of its size")
    size: float = quantity("-", "size of the push in that unit")
    outcome: str = quantity("-", "completed, or why the walk ended early")
    reason: str = quantity("-", "how it ended early, else empty")
    steps: int = quantity("1", "heel strikes")
    time: np.ndarray = quantity("s", "time since the push, shape (n,)", symbol="t")
    roll: np.ndarray = quantity("rad", "roll about the forward axis, shape (n,)", dimensions=("time",))
    yaw: np.ndarray = quantity("rad", "yaw about the slope's normal, shape (n,)", dimensions=("time",))
    lateral: np.ndarray = quantity(
        "m", "place of the hip across the slope, shape (n,)", symbol="z_hip", dimensions=("time",)
    )
    roll_left: float = quantity("rad", "largest roll over the last two steps, NaN after a fall")
    yaw_left: float = quantity("rad", "yaw at the end, NaN after a fall")

    @property
    def survived(self) -> bool:
        """Whether the twin walked on to the end."""
        return self.outcome == COMPLETED


@dataclass(frozen=True)
class Result:
    """Which pushes to the side the twin walks off, and what is left of them."""

    walks: tuple[PushedWalk, ...] = quantity("-", "walks by kind of push, sizes rising")
    falls_alone: bool = quantity(
        "1", "whether the twin falls without a push too; found where it falls after every push", default=False)

    def limits(self) -> list[tuple[str, str, float, float]]:
        """For each kind (kind, unit, largest size below which all are survived, smallest that is not); 0 or inf if
        there is none."""
        rows: list[tuple[str, str, float, float]] = []
        for kind, unit in dict.fromkeys((walk.kind, walk.unit) for walk in self.walks):
            own = [walk for walk in self.walks if walk.kind == kind]
            fatal = min((walk.size for walk in own if not walk.survived), default=np.inf)
            rows.append((kind, unit, max((walk.size for walk in own if walk.size < fatal), default=0.0), fatal))
        return rows

    def summary(self) -> str:
        """One line of what was found."""
        words = [
            (f"{kind} {survived:.3g} {unit} survived" + (f", {fatal:.3g} not" if np.isfinite(fatal) else "")
             if survived else f"{kind} {fatal:.3g} {unit} not survived")
            for kind, unit, survived, fatal in self.limits()
        ]
        most = max((walk.steps for walk in self.walks if walk.survived), default=0)  # an unpushed twin may fall later
        alone = ", but the twin falls without a push too" * self.falls_alone
        return f"{len(self.walks)} pushes{f', walked off for {most} steps' * (most > 0)}: {'; '.join(words)}{alone}"

    def tables(self) -> list[Table]:
        """Every push and how it ended, as (title, columns, rows of text)."""
        columns = ["push", "size", "steps", "end", "largest roll [deg]", "roll left [deg]", "yaw left [deg]",
                   "drift [mm]"]  # fmt: skip
        rows = [
            [
                walk.kind, f"{walk.size:.3g} {walk.unit}", str(walk.steps), walk.reason or walk.outcome,
                f"{np.degrees(np.abs(walk.roll).max()):.2f}",
                *((f"{np.degrees(walk.roll_left):.1e}", f"{np.degrees(walk.yaw_left):+.3f}") if walk.survived
                  else ("", "")),
                f"{1e3 * (walk.lateral[-1] - walk.lateral[0]):+.1f}",
            ]
            for walk in self.walks
        ]  # fmt: skip
        return [("Pushes to the side", columns, rows)]
