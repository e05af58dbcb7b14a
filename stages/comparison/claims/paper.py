"""The numbers that the paper prints, which stand here once; how far two may differ stands in params/comparison.yaml.

Their source and that of every sentence is Vasileiou, Smyrli, Drogosis and Papadopoulos, Mechanism and Machine Theory
(2021).
"""

from dataclasses import dataclass
from typing import ClassVar

from stages.biped.quantity import Bound, parameter

STANDARD_GRAVITY = 9.80665  # m/s^2 in one g of a sensor's data sheet

FREQUENCY_HZ = 2.08  # section 7.2
LAST_DIGIT_HZ = 0.01  # of that frequency
ACCELEROMETER_G = 4.0  # section 7.2
GYROSCOPE_DEG_S = 2000.0  # section 7.2
RAMP_M = 2.0  # section 7.1
BLOCK_SETS = 11  # section 7.1


#: A parameter as the paper has it: its value, and where it stands.
Printed = tuple[float | str, str]

#: The biped and its slope: what a claim on the paper's biped is about.
BIPED: dict[str, Printed] = {
    "biped.legs": ("compliant", "section 2.1"),
    "biped.hip_mass": (0.316, "Table 1"),
    "biped.foot_mass": (0.335, "Table 1"),
    "biped.leg_length": (0.333, "Table 1"),
    "biped.foot_radius": (0.083, "Table 1"),
    "biped.foot_com": (0.100, "Table 1"),
    "biped.stiffness": (2800.0, "Table 1"),
    "biped.damping": (58.350, "Table 1"),
    "biped.leg_inertia": (0.0, "section 2.1: point masses"),
    "ground.slope_deg": (2.0, "section 3.5"),
    "ground.gravity": (9.81, "the standard value, which the paper does not print"),
}

#: Other parameters that the paper prints: claims stay with another value, and name it.
SETTINGS: dict[str, Printed] = {
    "analytic.tolerance": (1e-7, "section 2.3"),
    "multibody.tolerance": (1e-6, "section 3.5"),
    "twin.tolerance": (1e-6, "section 3.5"),
    "ground.friction": ("stribeck", "section 3.4: eq. (10)"),
    "ground.static_friction": (1.1, "section 3.4"),
    "ground.stiction_velocity": (0.1, "section 3.4: Adams' default"),
    "ground.friction_velocity": (1.0, "section 3.4: Adams' default"),
}


@dataclass(frozen=True)
class Limits:
    """What the figures show too: how far the paper's models differ, and how a stride is cut."""

    FILE: ClassVar[str] = "comparison"

    position_limit: float = parameter("m", "largest hip difference the paper states", bound=Bound(above=0))
    velocity_limit: float = parameter("m/s", "largest hip velocity difference the paper states", bound=Bound(above=0))
    phase_points: int = parameter("1", "points of a stride", bound=Bound(minimum=11, maximum=100_001))
