"""What a parameter folder keeps of a calibrated robot, for every command that takes one with --params."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.calibration.estimation.campaign import CampaignFit
from stages.calibration.estimation.least_squares import TOTAL_MASS
from stages.calibration.following.robot_file import FittedRobot
from stages.calibration.information.identifiability import SLOPE
from stages.calibration.result import HALF_WIDTH

if TYPE_CHECKING:
    from stages.calibration.reports.sensor_report import Calibrated

#: What a parameter folder of another robot says of the twin: the bill of parts is that of this one.
PLANAR = {"twin.inertia": "planar"}
#: And of soles: that on which the robot walked is part of the legs that were found.
SOLED = {"campaign.outsole": {"value": 0.0, "unit": "m"}}
FRAME, HIP, OTHER_LENGTH = "biped.frame_mass", "biped.hip_mass", "biped.other_leg_length"


def parameters_left(result: Calibrated, robot: FittedRobot) -> dict[str, Any]:
    """Parameters as a folder keeps them: with the half widths of their intervals and how errors go together, the ramp
    as runs had it, and the mass that was weighed, without which a study's own fit does not know its scale.

    The foot sensor stays where runs were read with it, wherever the leg's mass is found to be. A robot from the bill of
    parts is left as Table 1 counts it, which all stages take: frames are the hip's.
    """
    design, names, values, covariance = result.design, robot.names, [*result.estimate.values], robot.covariance
    twin, below = result.parameters.twin, result.parameters.ingest.limits.lever_arm
    socket = twin.foot_sensor(twin.hip_socket[1] - below)
    left: dict[str, Any] = {"imu.lever_arm": {"value": below, "unit": "m"},
                            "twin.foot_socket": {"value": [*socket], "unit": "m"}, **SOLED}  # fmt: skip
    if SLOPE in robot.own:
        sd = robot.own_sd[robot.own.index(SLOPE)]
        left[SLOPE] = {"value": robot.design.value(SLOPE), "uncertainty": float(HALF_WIDTH * sd), "unit": "deg"}
    if not result.of_parts and OTHER_LENGTH in robot.own:
        if _legs_differ(design, robot):
            names, values = (*names, OTHER_LENGTH), [*values, robot.design.value(OTHER_LENGTH)]
            covariance = with_other_length(result.fit, robot)
        else:
            left[OTHER_LENGTH] = {"value": None, "unit": "m"}
    hip = [HIP if result.of_parts and name == FRAME else name for name in names]
    left |= with_errors(design, hip, values, covariance)
    for one in (one for one in result.known if one.name == TOTAL_MASS):
        left |= {"calibration.weighed_mass": one.value, "calibration.weighed_sd": one.sd / one.value}
    if result.of_parts:
        frame = left.pop(HIP, {"value": design.biped.frame_mass, "uncertainty": 0.0, "unit": "kg"})
        both = {"value": design.biped.hip_mass + 2.0 * frame["value"], "uncertainty": 2.0 * frame["uncertainty"]}
        left = {"biped.leg_inertia": design.biped.leg_inertia, HIP: {**frame, **both}, **left}
    return left if design.biped.frame_mass and not result.of_parts else left | PLANAR


def with_errors(
    design: DesignPoint, names: Sequence[str], values: Sequence[float], covariance: np.ndarray
) -> dict[str, Any]:
    """Parameters `names` of a design, with half widths from their `covariance` (n, n) and how their errors go together.
    """
    sd = np.sqrt(np.diag(covariance))
    shares = np.clip(covariance / np.outer(sd, sd), -1.0, 1.0)
    return {name: {"value": float(value), "uncertainty": float(HALF_WIDTH * own), "unit": design.unit(name)}
            for name, value, own in zip(names, values, sd, strict=True)} | {"biped.correlations": {"rows": [
                {"one": names[one], "other": names[other], "correlation": float(shares[one, other])}
                for one, other in combinations(range(len(names)), 2)]}}  # fmt: skip


def _legs_differ(drawn: DesignPoint, robot: FittedRobot) -> bool:
    """Whether legs differ in length by more than they usually do from run to run, or were drawn so."""
    (first, other), sd = robot.design.biped.leg_lengths, float(robot.own_sd[robot.own.index(OTHER_LENGTH)])
    return len({*drawn.biped.leg_lengths}) > 1 or abs(other - first) > HALF_WIDTH * sd


def with_other_length(fit: CampaignFit, robot: FittedRobot) -> np.ndarray:
    """Covariance (d + 1, d + 1) of the robot's parameters and the other leg's length, which each run's own fit makes go
    along with them and which runs have apart."""
    d, place = len(robot.names), robot.own.index(OTHER_LENGTH)
    along = np.mean([one.others(-one.matrix[d:, :d])[place] for one in fit.equations], axis=0)
    both = np.vstack([np.eye(d), along])
    covariance = both @ robot.covariance @ both.T
    covariance[d, d] += robot.own_sd[place] ** 2
    return np.asarray(covariance)
