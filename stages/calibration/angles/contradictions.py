"""What a fit of angles says against the file that came with them: known values, zeros, signs, and turned columns."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stages.calibration.angles.fit import AngleFit
from stages.calibration.angles.recording import DrivenStep
from stages.calibration.angles.robot import ZEROS
from stages.calibration.angles.setup import FARTHEST_ZERO, AngleSetup
from stages.calibration.estimation.least_squares import covariance_of
from stages.calibration.information.identifiability import short

#: From how many of its standard errors on a value is said to be contradicted, and from how many it settles the matter.
SAID, SETTLED = 3.0, 10.0


@dataclass(frozen=True)
class Contradiction:
    """One of them in a sentence, and of how many standard errors."""

    words: str
    errors: float


def refuted(found: Sequence[Contradiction]) -> bool:
    """Whether robot and recording do not belong together: two contradict each other, or one beyond doubt."""
    return len(found) >= 2 or any(one.errors > SETTLED for one in found)


def contradictions(
    setup: AngleSetup, fit: AngleFit, sd: dict[str, float], steps: Sequence[DrivenStep]
) -> list[Contradiction]:
    """All of a fit whose information counts samples as what they are worth, `sd` by the scatter of its steps."""
    return [*_turned(steps), *_known(setup, fit), *_zeros(setup, fit), *_signs(setup, fit, sd)]


def _known(setup: AngleSetup, fit: AngleFit) -> Iterator[Contradiction]:
    """Known values against all else: what is found less what is known has the variance of the known one, less that of
    both together."""
    size = np.array([setup.sizes()[name] for name in fit.names])
    covariance = covariance_of(fit.information, size)
    for one in setup.known:
        row = one.row(fit.names)
        value = fit.robot.value(one.name)
        variance = one.sd**2 - float(row @ np.where(np.isfinite(covariance), covariance, 0.0) @ row)
        off = abs(value - one.value) / math.sqrt(max(variance, 1e-6 * one.sd**2))
        if row.any() and off > SAID:
            yield Contradiction(f"{short(one.name)} is known as {one.value:.4g} +- {one.sd:.2g} "
                                f"{setup.robot.unit(one.name)}; these steps contradict that by {off:.1f} standard "
                                f"errors (found {value:.4g})", off)  # fmt: skip


def _zeros(setup: AngleSetup, fit: AngleFit) -> Iterator[Contradiction]:
    known = {one.name for one in setup.known}
    for name in (name for name in ZEROS if name in fit.names and name not in known):
        off = fit.robot.value(name) - setup.robot.value(name)
        if abs(off) > FARTHEST_ZERO:
            yield Contradiction(f"{name} comes out {math.degrees(off):+.1f} degrees off: more than an encoder is "
                                "mounted wrong by; legs may be exchanged, or a sign turned", 0.0)  # fmt: skip


def _signs(setup: AngleSetup, fit: AngleFit, sd: dict[str, float]) -> Iterator[Contradiction]:
    for name in fit.names:
        drawn, found = setup.robot.value(name), fit.robot.value(name)
        if drawn * found < 0.0 and abs(found) > SAID * sd[name]:
            yield Contradiction(f"{short(name)} comes out with the other sign ({found:.4g} for {drawn:.4g} "
                                f"{setup.robot.unit(name)}): a column or a value has its sign turned",
                                abs(found - drawn) / sd[name])  # fmt: skip


def _turned(steps: Sequence[DrivenStep]) -> Iterator[Contradiction]:
    """Where both feet are on level ground, legs of one length enclose twice the stance angle."""
    ends = np.array([[2.0 * one.stance[at], one.between[at]] for one in steps for at in (0, -1)])
    slope = float(ends[:, 0] @ ends[:, 1] / (ends[:, 0] @ ends[:, 0]))
    if slope < 0.0:
        yield Contradiction(f"near heel strikes the angle between the legs is {slope:+.2f} times twice the stance "
                            "angle, where with both feet on the ground it is about +1: one of the columns stance "
                            "angle, hip angle and standing pair is turned", math.inf)  # fmt: skip
