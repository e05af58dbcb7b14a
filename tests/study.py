"""The study's own parameters, as its files have them, and the robot of the paper."""

from pathlib import Path
from typing import Any

from pipeline.study import locate
from stages.biped.design import Biped
from stages.ground.slope import Slope

ROOT = Path(__file__).resolve().parents[1]
#: Table 1 of the paper, and its slope.
TABLE_1 = Biped(
    legs="compliant", hip_mass=0.316, foot_mass=0.335, leg_length=0.333, foot_radius=0.083, foot_com=0.100,
    stiffness=2800.0, damping=58.35, leg_inertia=0.0)
SLOPE = Slope(slope_deg=2.0, gravity=9.81)


def parameters_of(stage: str, *settings: str) -> Any:
    """The parameters of a stage with some set, as `--set` takes them. Raises StudyError."""
    return locate(settings=settings, start=ROOT).parameters((stage,))[stage]
