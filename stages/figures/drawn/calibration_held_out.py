"""A run that was not fitted beside what the robot found foretells of it from its beginning alone."""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from stages.calibration.reports.sensor_picture import fit_picture
from stages.calibration.result import HeldOut
from stages.comparison.stride import NoEvidence
from stages.figures.inputs import Given

TITLE = "Calibration: a run held out, foretold from its beginning"
PLACE = 43
INPUTS = ("calibration",)


def draw(given: Given) -> Figure:
    """The first run held out that the robot walks."""
    one = _shown(given)
    return fit_picture({"hip": one.hip, "foot": one.foot}, one.strikes, "foretold")


def _shown(given: Given) -> HeldOut:
    for one in given.calibration.held_out:
        if math.isfinite(one.foretold_force):
            return one
    why = [f"{one.name}: {one.why}" for one in given.calibration.failed]
    raise NoEvidence("; ".join(["no run was held out that the robot found by the others walks", *why]))


def caption(given: Given) -> str:
    one = _shown(given)
    return (f"{one.name}, {one.kind}, was not fitted: its ramp, start and sensors are those of its first "
            f"{one.begun:g} s, its robot is that of the other runs. Over the rest the specific force is off by "
            f"{one.foretold_force:.3f} m/s² and the rate by {1e3 * one.foretold_rate:.1f} mrad/s (rms), where sensors "
            f"have noise of {one.noise_force:.3f} and {1e3 * one.noise_rate:.2f}. Lines below: root mean square by "
            "part of the step. Where runs are of machines of their own, what builds differ by is in it.")
