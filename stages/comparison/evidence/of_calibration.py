"""Numbers of the claims that a calibration decides."""

from __future__ import annotations

import math

import numpy as np

from stages.biped.design import Biped
from stages.calibrated_twin.result import Number
from stages.calibration.result import HALF_WIDTH
from stages.comparison.claims.of_runs import calibration
from stages.comparison.evidence.evidence import NAN, Evidence


def outsole_slows(e: Evidence) -> calibration.OutsoleSlows:
    """What the constraint model says of an outsole, and what pairs of runs do."""
    layer, usual = e.results.analytic.outsole, e.results.analytic.gait.step_frequency_hz
    pairs = [one for one in e.results.calibrated_twin.pairs if math.isfinite(one.slower + one.slower_sd)]

    def mean(field: str) -> float:
        return float(np.mean([getattr(one, field) for one in pairs])) if pairs else NAN

    return calibration.OutsoleSlows(
        layer.thickness,
        layer.frequency_without_mass / usual - 1,
        layer.frequency_with_mass / usual - 1,
        layer.mass,
        layer.turning_mass,
        e.measured.origin,
        len(pairs),
        mean("longer"),
        HALF_WIDTH * mean("longer_sd"),
        mean("slower"),
        HALF_WIDTH * mean("slower_sd"),
        mean("true_slower"),
    )


def prototype_is_model(e: Evidence) -> calibration.PrototypeIsModel:
    """The first robot's parameters beside Table 1's; those that Table 1 does not print are left out."""
    robots = e.results.calibrated_twin.robots
    if not robots:
        return calibration.PrototypeIsModel(e.measured.origin, 0, (), -1)
    robot = robots[0]
    found = [(one, printed) for one in robot.numbers if (printed := _printed(e.parameters.biped, one)) > 0]
    intervals = tuple((one.name.partition(".")[2], *one.interval(HALF_WIDTH), printed) for one, printed in found)
    true = [one for one, _ in found if math.isfinite(one.truth)]
    held = sum(one.holds_truth(HALF_WIDTH) for one in true)
    return calibration.PrototypeIsModel(e.measured.origin, robot.runs, intervals, held if true else -1)


def _printed(biped: Biped, number: Number) -> float:
    """Table 1's value of a number; zero for one that is none of the biped's."""
    owner, _, key = number.name.partition(".")
    return biped.number(key) if owner == Biped.FILE else 0.0
