"""What the sensors of a calibrated run showed beside what the fit says they should have, and residuals by phase."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from stages.calibration.reports.sensor_picture import by_phase, fit_picture, rms_by_part
from stages.calibration.result import FittedRun
from stages.calibration.result import Result as Calibration
from stages.comparison.stride import NoEvidence
from stages.figures.entry import Entry, Given


def draw(given: Given) -> Figure:
    """The first run that was fitted."""
    calibration: Calibration = given.calibration
    if not calibration.fits:
        why = [f"{one.name}: {one.why}" for one in calibration.failed]
        raise NoEvidence("; ".join(["no run could be fitted", *why]))
    fit = calibration.fits[0]
    return fit_picture({"hip": fit.hip, "foot": fit.foot}, fit.strikes)


def caption(given: Given) -> str:
    calibration: Calibration = given.calibration
    fit = calibration.fits[0]
    words = (f"{fit.name}, {fit.kind}, {len(fit.strikes) - 1} steps fitted alone by the constraint model: residuals "
             f"of {fit.sigmas:.2f} times the sensors' noise. Lines below: root mean square by part of the step; what "
             f"is sampled at impacts does not count, and is cut off above. {_largest(fit)}")  # fmt: skip
    return " ".join([words, *_told(calibration)])


def _largest(fit: FittedRun) -> str:
    middle, size = rms_by_part(*by_phase(fit.foot, fit.strikes, (0, 1)))
    worst = int(np.argmax(size))
    return f"The foot's are largest {100 * middle[worst]:.0f} % into a step ({size[worst]:.3f} m/s²)."


def _told(calibration: Calibration) -> Iterator[str]:
    for one in calibration.held_out:
        words = (f"{one.name} was held out: with its start and sensors fitted errors are {one.fit_force:.3f} m/s² and "
                 f"{1e3 * one.fit_rate:.1f} mrad/s")  # fmt: skip
        if math.isfinite(one.foretold_force):
            words += (f"; foretold from its first {one.begun:g} s, {one.foretold_force:.2f} m/s² and "
                      f"{1e3 * one.foretold_rate:.0f} mrad/s over the rest")  # fmt: skip
        yield words + "."
    for words in calibration.not_seen:
        yield f"{words[0].upper()}{words[1:]}."


FIGURE = Entry(
    "Calibration: a run as its sensors showed it and as the fit has it", 41, ("calibration",), draw, caption,
    claims=("prototype_is_model",),
)  # fmt: skip
