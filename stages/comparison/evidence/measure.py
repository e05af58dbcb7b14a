"""What is measured for each claim, in the paper's order: the one place where claims meet results."""

from __future__ import annotations

from stages.comparison.claims.measured import Measured
from stages.comparison.evidence import of_calibration, of_contact, of_gait, of_measurement, of_numerics, of_twin
from stages.comparison.evidence.evidence import Evidence


def measure(e: Evidence) -> tuple[Measured, ...]:
    """Every claim's numbers."""
    return (
        of_numerics.constraints_reduce_effort(e),
        of_contact.twice_differentiated(e),
        of_gait.multipliers_minimised(e.results.analytic),
        of_gait.stable_gait(e),
        of_numerics.tight_tolerances(e),
        of_gait.chaos_amplifies(e.results.analytic),
        of_contact.contact_set(e),
        of_contact.contact_set_figure_8(e),
        of_contact.rolling_without_slip(e),
        of_contact.friction_velocities(e),
        of_numerics.stiff_solver(e),
        of_contact.hip_displacement(e),
        of_contact.hip_velocity(e),
        of_contact.integration_tolerance(e),
        of_twin.twin_settles(e),
        of_twin.ramp_length(e),
        of_twin.push_converges(e),
        of_gait.step_frequency(e.results.analytic),
        of_measurement.sensor_range(e),
        of_twin.twin_like_simple(e),
        of_measurement.hip_path_drifts(e),
        of_measurement.encloses(e.measured),
        of_measurement.slower(e.measured),
        of_calibration.outsole_slows(e),
        of_measurement.push_slows(e),
        of_calibration.prototype_is_model(e),
    )
