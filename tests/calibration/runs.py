"""Runs of the constraint model for the tests of the calibration."""

import math

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.biped.design import Biped
from stages.calibration.observation.prediction import Sampling
from stages.calibration.observation.unknowns import layout_of, mid_stance
from stages.calibration.parameters import Parameters, Settings
from stages.campaign.parameters import SensorSettings
from stages.ground.slope import Slope

BIPED = Biped("compliant", 0.316, 0.335, 0.333, 0.083, 0.1, 2800.0, 58.35, 8.576e-4)
SENSOR = SensorSettings(100.0, 2000.0, 40.0, 4.0, 2000.0, 16, 2.0, 0.005, 0.005, 0.02, 0.5, 1.77e-3, 0.007)
SETTINGS = Settings(
    tolerance=1e-7, planned_steps=12, planned_runs=30, settling_s=0.05, before_strike_s=0.01, after_strike_s=0.03,
    robust_sigmas=4.0, clock_sd=2e-4, foot_lag_sd_s=0.002, mid_stance_sd_s=0.02, start_length_sd=0.001,
    start_length_rate_sd=0.02, tilt_sd_deg=2.0)
PARAMETERS = Parameters(BIPED, Slope(2.0, 9.81), SENSOR, SETTINGS)
DESIGN = DesignPoint(BIPED, PARAMETERS.slope)
LATE = math.sqrt(2) / (2 * math.pi * SENSOR.bandwidth_hz)


def gait():
    """Walker and gait of the design."""
    return find_gait(DESIGN.biped, DESIGN.slope, 1e-9, None)


def disturbed(seed, steps):
    """Layout, unknowns and sampling of a run off the gait, seen by sensors with errors."""
    walker, point = gait()
    rng = np.random.default_rng(seed)
    layout = layout_of(walker, mid_stance(walker, point.z, 1e-9), PARAMETERS.beliefs)
    unknowns = layout.middle.copy()
    unknowns[:7] *= 1 + 0.002 * rng.normal(size=7)
    unknowns[7:] += 0.3 * layout.sizes[7:] * rng.normal(size=len(unknowns) - 7)
    end = (steps - 0.3) * point.steps[0].period * walker.time
    times = np.arange(layout.middle[layout.place("mid_stance")] + SETTINGS.settling_s, end, 0.01)
    return layout, unknowns, Sampling(times, times + 0.003, LATE, SENSOR.bandwidth_hz, 1)
