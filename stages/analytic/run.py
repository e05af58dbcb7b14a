"""Analytic stage: the gait of the constraint model and a walk on it.

Inputs: none. Settings: params/analytic.yaml, the rubber of twin.yaml. Output: `Result`, eqs. (1)-(8) of the paper.
"""

from __future__ import annotations

from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.outsole_effect import outsole_effect
from stages.analytic.gait.sensitivity import Neighbours, vary_design
from stages.analytic.parameters import Parameters
from stages.analytic.result import Result
from stages.analytic.walk.recording import constraint_drift, crossing_state, walk_on
from stages.analytic.walk.sampling import sample_walk
from stages.biped.progress import Progress, ignore


def run(parameters: Parameters, inputs: None = None, progress: Progress = ignore) -> Result:
    """Find the gait, audit it and record a walk.

    Raises NoGait if the design has no gait, StepFailed if the recorded walk does not get to its end.
    """
    tolerance = parameters.settings.tolerance
    progress(0.0, "looking for gaits")
    friction = parameters.limited_friction
    walker, point = find_gait(parameters.biped, parameters.slope, tolerance, friction)
    if parameters.settings.integrator == "scipy":
        from stages.analytic.integration.readable import (
            refine,  # its SymPy takes longer to load than the whole compiled search
        )

        point = refine(walker, point.z, tolerance)
    progress(0.6, "recording the walk")
    report = report_gait(walker, point, tolerance)
    upright = crossing_state(walker, point.z, tolerance)
    segments = walk_on(walker, upright, parameters.settings.steps, tolerance)
    near = Neighbours(parameters.biped, parameters.slope, point.z, tolerance, friction)
    return Result(
        gait=report.gait,
        mid_stance=walker.stance_state(upright),
        residual=point.residual,
        monodromy_matrix=point.monodromy_matrix,
        energy=report.energy,
        constraint_drift=constraint_drift(walker, report.segments),
        variations=vary_design(near),
        outsole=outsole_effect(near, parameters.rubber, parameters.settings.outsole),
        validity=report.validity,
        walk=sample_walk(walker, segments, parameters.settings.sampling_rate_hz),
    )
