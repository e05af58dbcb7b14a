"""Analytic stage: the gait of the constraint model and a walk on it.

Inputs: none. Settings: params/analytic.yaml. Output: `Result`, eqs. (1)-(8) of the paper.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stages.analytic.energy import audit
from stages.analytic.flow import DOUBLE_STANCE, RIGID, SINGLE_STANCE
from stages.analytic.gait_search import describe, find_gait, step_length
from stages.analytic.parameters import Parameters
from stages.analytic.readable import refine
from stages.analytic.recording import constraint_drift, crossing_state, record
from stages.analytic.result import Result
from stages.analytic.sampling import sample_walk
from stages.analytic.sensitivity import vary_design
from stages.analytic.step import section_state
from stages.analytic.validity import assess
from stages.biped.progress import Progress, ignore


def run(parameters: Parameters, inputs: Mapping[str, Any], progress: Progress = ignore) -> Result:
    """Find the gait, audit it and record a walk.

    Raises NoGait if the design has no gait, StepFailed if the recorded walk does not get to its end.
    """
    tolerance = parameters.settings.tolerance
    progress(0.0, "looking for gaits")
    walker, point = find_gait(parameters.biped, parameters.slope, tolerance)
    if parameters.settings.integrator == "scipy":
        point = refine(walker, point.z, tolerance)
    gait = describe(walker, point)
    progress(0.6, "recording the walk")
    first_phase = RIGID if walker.rigid else DOUBLE_STANCE
    one_step = record(walker, section_state(walker.rigid, point.z, walker.p), 1, tolerance, first_phase)
    upright = crossing_state(walker, point.z, tolerance)
    segments = record(
        walker, upright, parameters.settings.steps + 1, tolerance, RIGID if walker.rigid else SINGLE_STANCE)
    return Result(
        gait=gait,
        mid_stance=walker.stance_state(upright),
        residual=point.residual,
        monodromy_matrix=point.monodromy_matrix,
        energy=audit(walker, one_step, step_length(walker, point)),
        constraint_drift=constraint_drift(walker, one_step),
        variations=vary_design(parameters.biped, parameters.slope, point.z, tolerance),
        validity=assess(walker, one_step),
        walk=sample_walk(walker, segments, parameters.settings.sampling_rate_hz),
    )
