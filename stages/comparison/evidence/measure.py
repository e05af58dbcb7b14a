"""What is measured for each claim, in the paper's order: the one place where claims meet results."""

from __future__ import annotations

from collections.abc import Callable
from typing import get_type_hints

from stages.comparison.claims.measured import Measured, Unmeasured
from stages.comparison.evidence import of_calibration, of_contact, of_gait, of_measurement, of_numerics, of_twin
from stages.comparison.evidence.evidence import Evidence
from stages.comparison.stride import NoEvidence

#: What measures each claim, in the paper's order.
MEASURES: tuple[Callable[[Evidence], Measured], ...] = (
    of_numerics.constraints_reduce_effort,
    of_contact.twice_differentiated,
    of_gait.multipliers_minimised,
    of_gait.stable_gait,
    of_numerics.tight_tolerances,
    of_gait.chaos_amplifies,
    of_contact.contact_set,
    of_contact.contact_set_figure_8,
    of_contact.rolling_without_slip,
    of_contact.friction_velocities,
    of_numerics.stiff_solver,
    of_contact.hip_displacement,
    of_contact.hip_velocity,
    of_contact.integration_tolerance,
    of_twin.twin_settles,
    of_twin.ramp_length,
    of_twin.push_converges,
    of_gait.step_frequency,
    of_measurement.sensor_range,
    of_twin.twin_like_simple,
    of_measurement.hip_path_drifts,
    of_measurement.encloses,
    of_measurement.slower,
    of_calibration.outsole_slows,
    of_measurement.push_slows,
    of_calibration.prototype_is_model,
)


def measure(e: Evidence) -> tuple[Measured | Unmeasured, ...]:
    """Every claim's numbers, or why it has none."""
    return tuple(_measured(e, one) for one in MEASURES)


def _measured(e: Evidence, one: Callable[[Evidence], Measured]) -> Measured | Unmeasured:
    try:
        return one(e)
    except NoEvidence as error:
        return Unmeasured(get_type_hints(one)["return"], str(error))
