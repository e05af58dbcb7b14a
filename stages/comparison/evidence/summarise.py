"""The summary of the study's biped."""

from __future__ import annotations

import math

from stages.comparison.evidence.evidence import NAN, Evidence, known, largest
from stages.comparison.evidence.of_numerics import constraints_reduce_effort
from stages.comparison.summary import BipedSummary


def summarise(e: Evidence) -> BipedSummary:
    """The summary of the study's biped."""
    analytic, validity = e.results.analytic, e.results.analytic.validity
    models, work, twin = known(lambda: e.models), known(lambda: constraints_reduce_effort(e)), known(lambda: e.twin)
    limit, rung = known(lambda: e.results.contact_study.limit), known(lambda: e.results.twin_ladder.twin)
    return BipedSummary(
        analytic.gait.step_frequency_hz,
        analytic.gait.step_length_m,
        abs(analytic.numerical_error.period),
        analytic.numerical_error.hip_position,
        models.period_difference if models is not None else NAN,
        models.step_length_difference if models is not None else NAN,
        float(limit.hard.hip_position.max()) if limit is not None else NAN,
        float(models.same_start.position.max()) if models is not None else NAN,
        twin.step_frequency if twin is not None else NAN,
        largest(analytic.gait.floquet_multipliers),
        largest(rung.plane_multipliers) if rung is not None else NAN,
        validity.friction_single_stance,
        max(validity.impulse_friction_landing, validity.impulse_friction_trailing),
        e.parameters.contact.static_friction,
        math.sin(e.parameters.slope.angle),
        work.constraint if work is not None else NAN,
        work.penalty if work is not None else NAN,
        work.error if work is not None else NAN,
    )
