"""What the twin stage hands on."""

from __future__ import annotations

from dataclasses import dataclass

from stages.biped.error_estimate import ErrorEstimate
from stages.biped.quantity import quantity
from stages.biped.walk import Walk
from stages.multibody.assembly.inventory import Inventory
from stages.twin.walking.energy import EnergyBalance
from stages.twin.walking.settling import Settling
from stages.twin.walking.signals import Signals
from stages.twin.walking.snapshots import Snapshots

Table = tuple[str, list[str], list[list[str]]]


@dataclass(frozen=True)
class PartRow:
    """A row of the bill of parts with the inertia that follows from its shape."""

    name: str = quantity("-", "name")
    group: str = quantity("-", "rigid group")
    material: str = quantity("-", "material")
    shape: str = quantity("-", "shape and size in mm")
    pieces: int = quantity("1", "number of pieces")
    mass: float = quantity("kg", "mass of one piece")
    x: float = quantity("m", "mass centre, forward of the hip axis")
    y: float = quantity("m", "mass centre, above the hip axis")
    z: float = quantity("m", "mass centre, along the hip axis")
    inertia_x: float = quantity("kg m^2", "moment of inertia of one piece about its mass centre, axis x")
    inertia_y: float = quantity("kg m^2", "the same, axis y")
    inertia_z: float = quantity("kg m^2", "the same, axis z")


@dataclass(frozen=True)
class SumRow:
    """A sum of the bill beside Table 1."""

    what: str = quantity("-", "what is summed, with its unit")
    found: float = quantity("1", "sum of the bill")
    table_1: float = quantity("1", "value of Table 1")


@dataclass(frozen=True)
class Result:
    """A walk of the twin from the simple model's fixed point, and what is said of it."""

    outcome: str = quantity("-", "completed, or why the walk ended early")
    reason: str = quantity("-", "how it ended early, else empty")
    steps: int = quantity("1", "heel strikes")
    signals: Signals = quantity("-", "sampled signals in space and their planar projection")
    settling: Settling = quantity("-", "how the twin settles, and its settled gait")
    energy: EnergyBalance = quantity("-", "energy balance over the last whole step")
    snapshots: Snapshots = quantity("-", "poses in the settled gait")
    parts: tuple[PartRow, ...] = quantity("-", "bill of parts")
    sums: tuple[SumRow, ...] = quantity("-", "sums of the bill beside Table 1")
    errors: tuple[ErrorEstimate, ...] = quantity("-", "errors of the walk, where an accuracy was asked for")
    solver_steps: int = quantity("1", "number of solver steps")
    inventory: Inventory = quantity("-", "what the scene held, counted in the assembled system")

    @property
    def walk(self) -> Walk:
        """The planar projection of the walk."""
        return self.signals.walk

    def summary(self) -> str:
        """One line of what was found."""
        if self.outcome != "completed":
            return f"{self.outcome} after {self.steps} steps: {self.reason}"
        gait = self.settling
        when = f"settled after step {gait.steps_to_settle}" if gait.steps_to_settle >= 0 else "not settled"
        return (
            f"{self.steps} steps, {when}: {gait.step_frequency_hz:.3f} Hz, step {1e3 * gait.step_length_m:.1f} mm, "
            f"energy closed to {self.energy.relative_residual:.0e}"
        )

    def tables(self) -> list[Table]:
        """Bill of parts, its sums beside Table 1, and the steps, as (title, columns, rows of text)."""
        bill = [
            [
                part.name, part.group.replace("_", " "), part.material, part.shape, str(part.pieces),
                f"{1e3 * part.mass:.1f}",
                *(f"{1e3 * value:.1f}" for value in (part.x, part.y, part.z)),
                *(f"{1e6 * value:.2f}" for value in (part.inertia_x, part.inertia_y, part.inertia_z)),
            ]
            for part in self.parts
        ]  # fmt: skip
        sums = [
            [row.what, f"{row.found:.5f}", f"{row.table_1:.3f}", f"{row.found - row.table_1:+.1e}"] for row in self.sums
        ]
        steps = [
            [str(step), f"{period:.5f}", f"{1e3 * length:.3f}"]
            for step, (period, length) in enumerate(
                zip(self.settling.step_period, self.settling.step_length, strict=True), 1
            )
        ]
        columns = ["part", "group", "material", "shape [mm]", "pieces", "mass [g]", "x [mm]", "y [mm]", "z [mm]",
                   "Ix [kg mm2]", "Iy [kg mm2]", "Iz [kg mm2]"]  # fmt: skip
        return [
            ("Bill of parts (masses and sizes assumed; mass centre from the middle of the hip axis)", columns, bill),
            ("Sums of the bill beside Table 1", ["sum", "bill", "Table 1", "difference"], sums),
            ("Steps", ["step", "period [s]", "length [mm]"], steps),
        ]
