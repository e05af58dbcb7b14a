"""How far the models agree: constraint model with Exudyn's, simple model with the twin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stages.analytic.result import Result as Analytic
from stages.biped.largest import largest_magnitudes
from stages.biped.quantity import quantity
from stages.biped.walk import Walk
from stages.comparison.claims.paper import ACCELEROMETER_G, STANDARD_GRAVITY
from stages.comparison.hip_motion import HipDifference, between_cycles, from_same_start, overlay
from stages.comparison.stride import Stride, normalised_rms
from stages.multibody.result import Result as Multibody
from stages.twin.result import Result as Twin

#: Full scale of the paper's accelerometer [m/s^2].
FULL_SCALE = ACCELEROMETER_G * STANDARD_GRAVITY


@dataclass(frozen=True)
class ModelAgreement:
    """Constraint model against the penalty model."""

    same_start: HipDifference = quantity("-", "largest difference over one step from the same mid-stance state")
    same_start_median_velocity: np.ndarray = quantity("m/s", "median velocity difference over that step, shape (2,)")
    settled: HipDifference = quantity("-", "largest difference of the settled cycles at equal phase")
    period_difference: float = quantity("s", "step period of the penalty model minus the constraint model's")
    step_length_difference: float = quantity("m", "step length of the penalty model minus the constraint model's")
    creep_velocity: float = quantity(
        "m/s", "mean slip velocity of the loaded foot in the penalty model's single stance"
    )
    energy_residual: float = quantity("1", "what the penalty model's energy balance does not close")


def compare_models(analytic: Analytic, multibody: Multibody, strides: Mapping[str, Stride]) -> ModelAgreement:
    """Agreement of the results of the analytic and the multibody stage, given the last stride of each by name."""
    period = analytic.gait.period_s
    laid = overlay(analytic.walk, multibody.walk, period)
    return ModelAgreement(
        same_start=from_same_start(analytic.walk, multibody.walk, period),
        same_start_median_velocity=np.median(np.abs(laid.velocity), axis=0),
        settled=between_cycles(strides["analytic"], strides["multibody"]),
        period_difference=multibody.cycle.period_s - period,
        step_length_difference=multibody.cycle.step_length_m - analytic.gait.step_length_m,
        creep_velocity=creep_velocity(multibody.walk, multibody.slip_velocity),
        energy_residual=multibody.energy.relative_residual,
    )


def creep_velocity(walk: Walk, slip: np.ndarray) -> float:
    """Mean slip speed [m/s] of the one foot on the ground, from the slip velocities (n, 2) of both."""
    loaded = walk.ground_reaction[:, :, 1] > 0
    alone = loaded.sum(axis=1) == 1
    return float(np.abs(np.where(loaded, slip, 0.0).sum(axis=1))[alone].mean()) if alone.any() else 0.0


@dataclass(frozen=True)
class TwinAgreement:
    """The twin against the simple (planar multibody) model."""

    steps_to_settle: int = quantity("1", "steps until period and length stay within 1 %; -1 if never")
    step_frequency: float = quantity("Hz", "step frequency of the twin's last four steps")
    normalised_rms: np.ndarray = quantity("1", "rms difference over range of six sensor signals at equal phase, (6,)")
    peak_specific_force: float = quantity("m/s^2", "largest specific force at the twin's hip sensor, last stride")
    peak_foot_specific_force: float = quantity("m/s^2", "largest specific force at the twin's foot sensor, last stride")
    peak_rate: float = quantity("rad/s", "largest angular velocity of the twin's sensors, last stride")
    time_above_range: float = quantity("s", "time a step that a component of the twin's specific force is above 4 g")


def compare_twin(twin: Twin, strides: Mapping[str, Stride]) -> TwinAgreement:
    """Agreement of the twin's result and the multibody model, given the last stride of each by name."""
    walk, start = twin.walk, twin.walk.heel_strike_time[-3]
    last = walk.time >= start
    hip, foot = (np.abs(force[last]).max(axis=1) for force in (walk.hip_specific_force, walk.foot_specific_force))
    above = np.maximum(hip, foot) > FULL_SCALE
    felt = np.column_stack([walk.hip_specific_force, walk.foot_specific_force, walk.hip_angular_velocity])
    peaks = largest_magnitudes(walk.time[last], felt[last])
    steps = int((walk.heel_strike_time >= start).sum()) - 1
    return TwinAgreement(
        steps_to_settle=twin.settling.steps_to_settle,
        step_frequency=twin.settling.step_frequency_hz,
        normalised_rms=normalised_rms(strides["twin"].signals, strides["multibody"].signals),
        peak_specific_force=float(peaks[:2].max()),
        peak_foot_specific_force=float(peaks[2:4].max()),
        peak_rate=float(peaks[4]),
        time_above_range=float(np.trapezoid(above.astype(float), walk.time[last]) / steps),
    )
