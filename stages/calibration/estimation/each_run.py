"""One run's fit as a part of an answer: its argument and its answer are plain, so that it is kept and goes anywhere."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.biped.design import Biped
from stages.calibration.estimation.equations import Model, run_equations
from stages.calibration.estimation.fit import RunFit, fit_run
from stages.calibration.estimation.known import Known
from stages.calibration.information.plan import first_model
from stages.calibration.observation.measured_run import MeasuredRun
from stages.calibration.observation.prediction import Sampling
from stages.calibration.observation.unknowns import SIDES
from stages.calibration.parameters import Parameters


def guess(parameters: Parameters) -> DesignPoint:
    """The design a fit begins from: the drawing, with legs that may differ in length.

    A tenth of a millimetre makes the steps of either leg differ by hundredths of a second.
    """
    biped = parameters.biped
    if biped.legs == "compliant" and biped.other_leg_length is None:
        biped = dataclasses.replace(biped, other_leg_length=biped.leg_length)
    return DesignPoint(biped, parameters.slope)


def as_plain(run: MeasuredRun) -> dict[str, Any]:
    """A run as JSON knows it."""
    return {
        "name": run.name,
        "sampling": {"hip": run.sampling.hip.tolist(), "foot": run.sampling.foot.tolist(), "late": run.sampling.late,
                     "bandwidth_hz": run.sampling.bandwidth_hz, "first_leg": run.sampling.first_leg,
                     "place": run.sampling.place, "below_hip": run.sampling.below_hip,
                     "declared": run.sampling.declared},
        "samples": {side: run.samples[side].tolist() for side in SIDES},
        "used": {side: run.used[side].tolist() for side in SIDES},
        "strikes": run.strikes.tolist(),
        "own": {name: list(value) for name, value in run.own.items()},
    }


def from_plain(plain: Mapping[str, Any]) -> MeasuredRun:
    """The run of `as_plain`."""
    sampling = dict(plain["sampling"])
    sampling |= {side: np.array(sampling[side]) for side in SIDES}
    return MeasuredRun(
        plain["name"], Sampling(**sampling), {side: np.array(plain["samples"][side]) for side in SIDES},
        {side: np.array(plain["used"][side], dtype=bool) for side in SIDES}, np.array(plain["strikes"]),
        {name: (value[0], value[1]) for name, value in plain["own"].items()})


def fitted(
    parameters: Parameters, drawn: dict[str, Any], names: list[str], known: list[list[Any]], place: float,
    plain: Mapping[str, Any],
) -> dict[str, Any]:
    """The fit of one run from the design `drawn` (its biped's fields), in plain values; or why there is none.

    `place` [m] is the standard error of the foot sensor's.
    """
    parameters = dataclasses.replace(parameters, settings=dataclasses.replace(parameters.settings, lever_arm_sd=place))
    design = DesignPoint(Biped(**drawn), parameters.slope)
    model = first_model(design, names, parameters)
    try:
        fit = fit_run(design, from_plain(plain), model, [Known(*one) for one in known])
    except StepFailed as reason:
        return {"why_none": str(reason)}
    return {"design": fit.design.tolist(), "own": fit.own.tolist(), "unknowns": fit.unknowns.tolist(),
            "evaluations": fit.evaluations, "converged": fit.converged, "why": fit.why}


def fit_of(answer: Mapping[str, Any], run: MeasuredRun, design: DesignPoint, model: Model) -> RunFit | str:
    """The fit of an answer, with its equations."""
    if "why_none" in answer:
        return str(answer["why_none"])
    values, own, unknowns = (np.array(answer[key]) for key in ("design", "own", "unknowns"))
    there = design.with_values(dict(zip(model.shared, values, strict=True)))
    return RunFit(values, own, unknowns, run_equations(there, own, unknowns, run, model), answer["evaluations"],
                  answer["converged"], answer["why"])
