"""A run that was not fitted beside what the robot found foretells of it from its beginning alone."""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from stages.calibration.reports.sensor_picture import fit_picture
from stages.calibration.result import HeldOut
from stages.comparison.stride import NoEvidence
from stages.figures.entry import Entry, Given


def draw(given: Given) -> Figure:
    """The first run held out that is foretold, or else the first as it is fitted."""
    one, foretold = _shown(given)
    return fit_picture({"hip": one.hip, "foot": one.foot}, one.strikes, "foretold" if foretold else "fit")


def _shown(given: Given) -> tuple[HeldOut, bool]:
    for foretold in (True, False):
        for one in given.calibration.held_out:
            if math.isfinite(one.foretold_force) or not foretold:
                return one, foretold
    why = [f"{one.name}: {one.why}" for one in given.calibration.failed]
    raise NoEvidence("; ".join(["no run was held out that the robot found by the others walks", *why]))


def caption(given: Given) -> str:
    one, foretold = _shown(given)
    force, rate = (one.foretold_force, one.foretold_rate) if foretold else (one.fit_force, one.fit_rate)
    start = (f"those of its first {one.begun:.3g} s" if foretold else
             f"fitted to all of it, as from its first {one.begun:.3g} s that robot does not walk to its end")
    return (f"{one.name}, {one.kind}, was not fitted: its robot is that of the other runs, its ramp, start and sensors "
            f"are {start}. Over {'the rest' if foretold else 'it'} the specific force is off by "
            f"{force:.3f} m/s² and the rate by {1e3 * rate:.1f} mrad/s (rms), where sensors "
            f"have noise of {one.noise_force:.3f} and {1e3 * one.noise_rate:.2f}. Lines below: root mean square by "
            "part of the step. Where runs are of machines of their own, what builds differ by is in it.")


FIGURE = Entry("Calibration: a run held out, foretold from its beginning", 43, ("calibration",), draw, caption)
