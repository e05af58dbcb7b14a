"""Settings of the twin and its bill of parts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from stages.biped.accuracy.tolerances import CLOSER, Accuracy, accuracy, scaled
from stages.biped.design import Biped
from stages.biped.quantity import Bound, Broken, parameter
from stages.biped.rubber import Rubber
from stages.ground.blocks import Blocks, overlap
from stages.ground.contact_law import OnGround
from stages.planar.signals import GROUND_REACTION, IMU
from stages.twin.machine.bill import DRAWN, faults, fitted, rule
from stages.twin.machine.parts import Material, Part

#: Of the planar projection: forces on each pair of feet, specific force and angular velocity of both sensors. In space:
#: what the sensors measure in their sockets; roll, yaw and place across the slope; all coordinates; force on each foot.
IMU_IN_SPACE, ATTITUDE, COORDINATES, FOOT_FORCE = "imu_in_space", "attitude", "coordinates", "foot_force"
SIGNALS = (GROUND_REACTION, IMU, IMU_IN_SPACE, ATTITUDE, COORDINATES, FOOT_FORCE)
#: Loosest tolerance of the solver that is allowed, and by how much walks that others make of the twin may be looser.
LOOSEST, OF_OTHERS = 1e-4, 10.0
#: Those that later stages and figures read.
READ_LATER = (GROUND_REACTION, IMU)


def _drawn(key: str, unit: str, bound: Bound) -> float | None:
    """A number of the design that the parts are drawn for."""
    field: float | None = parameter(
        unit, f"{key} of the design that the parts belong to; null: biped.yaml's", bound=bound, default=None)
    return field


@dataclass(frozen=True)
class Settings(Rubber):
    """How the twin is built, sampled and integrated. Positions as in `stages.twin.machine.parts.Part`."""

    FILE: ClassVar[str] = "twin"

    steps: int = parameter("1", "steps to walk", bound=Bound(minimum=1, maximum=1000))
    sampling_rate_hz: float = parameter("Hz", "rate of the sampled signals", bound=Bound(above=0, maximum=1e5))
    tolerance: float = parameter(
        "1", "absolute tolerance of the solver, one number in m, rad, m/s and rad/s, whatever the robot's size",
        bound=Bound(minimum=1e-11, maximum=LOOSEST), closer=CLOSER)
    largest_step: float = parameter("s", "largest step of the solver", bound=Bound(above=0, maximum=1e-2))
    longest_step: float | None = parameter(
        "s", "time without a heel strike after which the walk counts as stalled; null: some three steps of its size",
        bound=Bound(above=0, maximum=100))
    inertia: str = parameter(
        "-", "parts: from the bill of parts; planar: Table 1's point masses", choices=("parts", "planar")
    )
    inner_lane: float = parameter("m", "distance of each inner foot's middle from the mid-plane", bound=Bound(above=0))
    outer_lane: float = parameter("m", "distance of each outer foot's middle from the mid-plane", bound=Bound(above=0))
    hip_socket: tuple[float, ...] = parameter("m", "place of the hip sensor on the inner frame, x, y, z")
    foot_socket: tuple[float, ...] | None = parameter(
        "m", "place of the foot sensor on an inner foot, x, y, z; null: the left one's mass centre")
    bearing_friction: float = parameter("N m s", "viscous friction of the outer legs' bearings", bound=Bound(minimum=0))
    slider_friction: float = parameter("N s/m", "viscous friction of each leg's slider", bound=Bound(minimum=0))
    outsole: float = parameter("m", "rubber on top of Table 1's foot radius and leg length", bound=Bound(minimum=0))
    scene: str = parameter("-", "plane: ground everywhere; ramp: stepping blocks only", choices=("plane", "ramp"))
    ramp_length: float = parameter("m", "length of the ramp", bound=Bound(above=0))
    expected_step: float = parameter(
        "m", "distance from set to set; 0: the step length of the simple model's gait", bound=Bound(minimum=0)
    )
    materials: tuple[Material, ...] = parameter("-", "densities")
    parts: tuple[Part, ...] = parameter("-", "bill of parts")
    most_solver_steps: int = parameter(
        "1",
        "solver steps without a heel strike after which the solver is stuck",
        bound=Bound(minimum=1000, maximum=10**7),
        default=500_000,
    )
    signals: tuple[str, ...] = parameter(
        "-", "signals recorded beside the motion, sampled at sampling_rate_hz", choices=SIGNALS, default=READ_LATER
    )
    accuracy: str | Accuracy = accuracy("tolerance and largest_step")
    parts_hip_mass: float | None = _drawn("hip_mass", "kg", Bound(above=0))
    parts_foot_mass: float | None = _drawn("foot_mass", "kg", Bound(above=0))
    parts_leg_length: float | None = _drawn("leg_length", "m", Bound(above=0))
    parts_foot_radius: float | None = _drawn("foot_radius", "m", Bound(minimum=0))
    parts_foot_com: float | None = _drawn("foot_com", "m", Bound(minimum=0))

    def foot_sensor(self, foot_com: float) -> tuple[float, ...]:
        """Place of the foot sensor [m], for feet whose mass is so far above the hip axis [m]."""
        return (0.0, foot_com, self.inner_lane) if self.foot_socket is None else self.foot_socket

    def drawn_for(self, biped: Biped) -> Biped:
        """The design that the parts are drawn for: `biped`, with the `parts_` numbers that are given."""
        numbers = (self.parts_hip_mass, self.parts_foot_mass, self.parts_leg_length, self.parts_foot_radius,
                   self.parts_foot_com)  # fmt: skip
        given: dict[str, Any] = {key: value for key, value in zip(DRAWN, numbers, strict=True) if value is not None}
        return replace(biped, **given)

    def bill(self, biped: Biped) -> tuple[Part, ...]:
        """The parts of a machine of this design, by the rule of `stages.twin.machine.bill`; a planar one has
        none.
        """
        return fitted(self.parts, self.drawn_for(biped), biped) if self.inertia == "parts" else ()

    def bill_rule(self, biped: Biped) -> str:
        """How `bill` made the parts fit the design, in words; "" if they are as written, or none."""
        return rule(self.parts, self.drawn_for(biped), biped) if self.inertia == "parts" else ""

    def with_tolerance(self, tolerance: float | None) -> Settings:
        """These settings at a tolerance; without one at ten times their own, for what is read less finely.

        At ten times the tolerance of 1e-6 a walk's hip moves by 6e-7 m.
        """
        return replace(self, tolerance=tolerance or min(scaled(self.tolerance, OF_OTHERS), LOOSEST))

    def broken_rules(self) -> Iterator[Broken]:
        """Places are points, lanes do not overlap, a signal is named once."""
        if len(set(self.signals)) < len(self.signals):
            yield Broken("signals", "each of " + ", ".join(SIGNALS) + " at most once")
        foot = self.foot_sensor(0.0)
        for key, place in (("hip_socket", self.hip_socket), ("foot_socket", foot)):
            if len(place) != 3:
                yield Broken(key, "three numbers: x, y, z")
        if len(foot) == 3 and foot[2] == 0.0:
            yield Broken("foot_socket", "z other than 0, which distinguishes left foot from right foot")
        if self.foot_width > 2.0 * self.inner_lane:
            yield Broken("foot_width", f"<= 2 inner_lane = {2.0 * self.inner_lane:g} m, or the inner feet overlap")
        if self.outer_lane - self.inner_lane < self.foot_width:
            yield Broken("outer_lane", f">= inner_lane + foot_width = {self.inner_lane + self.foot_width:g} m")

    def broken_ramp(self, blocks: Blocks) -> Iterator[Broken]:
        """Blocks are no narrower than feet, and all find room on the ramp."""
        if self.foot_width > blocks.block_width:
            yield Broken("ground.block_width", f">= foot_width = {self.foot_width:g} m")
        if blocks.block_width > self.outer_lane - self.inner_lane:
            apart = self.outer_lane - self.inner_lane
            yield Broken(
                "ground.block_width", f"<= outer_lane - inner_lane = {apart:g} m, or blocks side by side overlap")
        # without an expected step: the longest that the ramp has room for
        step = self.expected_step or max(0.0, self.ramp_length - blocks.block_length) / (blocks.block_sets - 1)
        fault = block_fault(blocks, self.ramp_length, step)
        if fault is not None:
            yield fault


def block_fault(blocks: Blocks, ramp_length: float, step: float) -> Broken | None:
    """What is wrong with blocks for steps of this length [m]: they overlap in their lane, or the ramp is too short."""
    fault = overlap(blocks.block_length, step)
    if fault is not None:
        return Broken(f"ground.{fault.key}", fault.allowed)
    needed = (blocks.block_sets - 1) * step + blocks.block_length
    if needed > ramp_length * (1.0 + 1e-12):
        return Broken("twin.ramp_length", f">= {needed:.4g} m, or {blocks.block_sets} sets of blocks find no room")
    return None


@dataclass(frozen=True)
class Parameters(OnGround):
    """All parameters the stage uses."""

    settings: Settings
    blocks: Blocks = Blocks()

    def broken_rules(self) -> Iterator[Broken]:
        """The bill of parts is possible and that of a design; point masses need no bill. Blocks fit their ramp."""
        if self.settings.scene == "ramp":
            yield from self.settings.broken_ramp(self.blocks)
        if self.settings.inertia == "parts":
            drawn = self.settings.drawn_for(self.biped)
            for fault in faults(self.settings.parts, self.settings.materials, drawn, self.biped):
                yield Broken("twin.parts", fault)
