"""Settings of the twin and its bill of parts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from stages.biped.design import Biped
from stages.biped.quantity import Bound, Broken, parameter
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.twin.parts import Material, Part
from stages.twin.table_one import faults


@dataclass(frozen=True)
class Settings:
    """How the twin is built, sampled and integrated. Positions as in `stages.twin.parts.Part`."""

    FILE: ClassVar[str] = "twin"

    steps: int = parameter("1", "steps to walk", bound=Bound(minimum=1, maximum=1000))
    sampling_rate_hz: float = parameter("Hz", "rate of the sampled signals", bound=Bound(above=0, maximum=1e5))
    tolerance: float = parameter(
        "1", "absolute tolerance of the explicit solver in m, rad, m/s, rad/s", bound=Bound(minimum=1e-11, maximum=1e-4)
    )
    largest_step: float = parameter("s", "largest step of the solver", bound=Bound(above=0, maximum=1e-2))
    longest_step: float = parameter(
        "s", "time without a heel strike after which the walk counts as stalled", bound=Bound(above=0, maximum=100)
    )
    inertia: str = parameter(
        "-", "parts: from the bill of parts; planar: Table 1's point masses", choices=("parts", "planar")
    )
    inner_lane: float = parameter("m", "distance of each inner foot's middle from the mid-plane", bound=Bound(above=0))
    outer_lane: float = parameter("m", "distance of each outer foot's middle from the mid-plane", bound=Bound(above=0))
    foot_width: float = parameter("m", "width of each foot's cylinder", bound=Bound(above=0))
    hip_socket: tuple[float, ...] = parameter("m", "place of the hip sensor on the inner frame, x, y, z")
    foot_socket: tuple[float, ...] = parameter("m", "place of the foot sensor on an inner foot, x, y, z")
    bearing_friction: float = parameter("N m s", "viscous friction of the outer legs' bearings", bound=Bound(minimum=0))
    slider_friction: float = parameter("N s/m", "viscous friction of each leg's slider", bound=Bound(minimum=0))
    outsole: float = parameter("m", "rubber on top of Table 1's foot radius and leg length", bound=Bound(minimum=0))
    materials: tuple[Material, ...] = parameter("-", "densities")
    parts: tuple[Part, ...] = parameter("-", "bill of parts")

    def broken_rules(self) -> Iterator[Broken]:
        """Places are points and lanes do not overlap."""
        for key in ("hip_socket", "foot_socket"):
            if len(getattr(self, key)) != 3:
                yield Broken(key, "three numbers: x, y, z")
        if len(self.foot_socket) == 3 and self.foot_socket[2] == 0.0:
            yield Broken("foot_socket", "z other than 0, which tells left foot from right foot")
        if self.foot_width > 2.0 * self.inner_lane:
            yield Broken("foot_width", f"<= 2 inner_lane = {2.0 * self.inner_lane:g} m, or the inner feet overlap")
        if self.outer_lane - self.inner_lane < self.foot_width:
            yield Broken("outer_lane", f">= inner_lane + foot_width = {self.inner_lane + self.foot_width:g} m")


@dataclass(frozen=True)
class Parameters:
    """All parameters the stage uses."""

    biped: Biped
    slope: Slope
    contact: ContactLaw
    settings: Settings

    def broken_rules(self) -> Iterator[Broken]:
        """The bill of parts is possible and adds up to the design; point masses need no bill."""
        if self.settings.inertia == "parts":
            for fault in faults(self.settings.parts, self.settings.materials, self.biped):
                yield Broken("twin.parts", fault)
