"""Runs of the constraint model for the tests of the calibration."""

import dataclasses
import math
from functools import cache

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.calibration.blind_score import draw, model_of
from stages.calibration.observation.measured_run import SIDES, Sampling, layout_of
from tests.study import TABLE_1, parameters_of

BIPED = dataclasses.replace(TABLE_1, leg_inertia=8.576e-4)
#: The study's own settings, legs with the inertia of the twin's.
PARAMETERS = parameters_of("calibration", "biped.leg_inertia=8.576e-4")
SENSOR, SETTINGS = PARAMETERS.sensor, PARAMETERS.settings
#: Short runs, so that a fit takes half a second.
SHORT = dataclasses.replace(PARAMETERS, given=dataclasses.replace(SETTINGS, planned_steps=7))
DESIGN = DesignPoint(BIPED, PARAMETERS.slope)
LATE = dict.fromkeys(SIDES, math.sqrt(2) / (2 * math.pi * SENSOR.bandwidth_hz))
BANDWIDTH_HZ = dict.fromkeys(SIDES, SENSOR.bandwidth_hz)


def gait():
    """Walker and gait of the design."""
    return find_gait(DESIGN.biped, DESIGN.slope, 1e-9, None)


@cache
def fitted():
    """The drawing's design and the model that short runs are fitted by."""
    return model_of(SHORT)


@cache
def drawn(seed):
    """A campaign of one short run of a robot that was drawn."""
    return draw(seed, 1, SHORT)


def disturbed(seed, steps):
    """Layout, unknowns and sampling of a run off the gait, seen by sensors with errors."""
    walker, point = gait()
    rng = np.random.default_rng(seed)
    layout = layout_of(walker, point.z, 1e-9, PARAMETERS.priors)
    unknowns = layout.middle.copy()
    unknowns[:7] *= 1 + 0.002 * rng.normal(size=7)
    unknowns[7:] += 0.3 * layout.sizes[7:] * rng.normal(size=len(unknowns) - 7)
    end = (steps - 0.3) * point.steps[0].period * walker.time
    times = np.arange(layout.middle[layout.place("mid_stance")] + SETTINGS.settling_s, end, 0.01)
    return layout, unknowns, Sampling(times, times + 0.003, LATE, BANDWIDTH_HZ, 1)
