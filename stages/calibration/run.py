"""The calibration stage: what the campaign's sensors can tell, and some of its runs fitted blind.

Inputs: the databases of the campaign, or a lab's own; the campaign itself is read for what its scale showed, and
for the truth once all is fitted. Robots are fitted from what the databases hold, the drawing and the scale, and from
nothing else. Settings: params/calibration.yaml, the sensors of params/campaign.yaml. Output: `Result`.
"""

import contextlib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from types import MappingProxyType

import numpy as np
from scipy.linalg import block_diag

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.design import Biped
from stages.biped.processes import Progress, each_in_a_process, ignore
from stages.calibration.estimation.held_out import explained, trace
from stages.calibration.estimation.least_squares import covariance_of, information_of
from stages.calibration.estimation.run_fit import Model, design_sizes, fit_run, one_step
from stages.calibration.following.fitted import unexplained
from stages.calibration.following.follower import Follower
from stages.calibration.following.present import Instant
from stages.calibration.following.robot_file import OF_MOUNTING, mounted
from stages.calibration.following.track import follow, forecasts, lateness
from stages.calibration.information.identifiability import (
    SLOPE,
    described,
    identifiability,
    planned_equations,
    weighed,
)
from stages.calibration.intervals.model_error import widening
from stages.calibration.observation.measured_run import SIDES, MeasuredRun
from stages.calibration.parameters import Parameters, Settings
from stages.calibration.recordings import (
    FROM,
    Recorded,
    as_mounted,
    drawn_design,
    drawn_model,
    recorded,
    sources,
    table_value,
)
from stages.calibration.result import Determined, Failed, FittedRun, Followed, HeldOut, Misses, Result
from stages.campaign.result import Result as Campaign, RunTruth


@dataclass(frozen=True)
class Inputs:
    """What the stage reads: the synthetic runs, those without an outsole, their truth; and a lab's own database."""

    measurements: Path
    without_outsole: Path
    campaign: Campaign
    database: Path | None = None


#: What each run has of its own may be so far from what was fitted, in shares of it; and the sensors' mounting, with the
#: bandwidth's logarithm.
OWN, MOUNTED = 1e-3, (1e-4, 0.01)
#: What fits of runs found, by their names: shared parameters (d,), own (o,) and unknowns (k,).
Near = Mapping[str, tuple[Vector, Vector, Vector]]


def again(parameters: Parameters, inputs: Inputs, result: Result) -> Result:
    """The result at closer settings: each fit is where one more step leads from where it came to rest."""
    missed, truths = result.misses, {one.name: one for one in inputs.campaign.runs}
    near = {fit.name: (fit.design, fit.own, fit.unknowns) for fit in result.fits}
    near |= {one.name: (np.zeros(0), one.own, one.unknowns) for one in result.held_out}
    near |= {name: (_true(truths[name].robot, result.names) + share * result.drawn, own, unknowns)
             for name, share, own, unknowns in zip(
                 missed.runs, missed.shares, missed.own, missed.unknowns, strict=True)}  # fmt: skip
    return run(parameters, inputs, near=near)


def run(
    parameters: Parameters, inputs: Inputs, progress: Progress = ignore, near: Near = MappingProxyType({})
) -> Result:
    """Say what runs can tell, fit some of them blind, and put the truth beside; fits `near` ones take one step from
    there. Raises NoGait, NotIdentified, SourceRefused.
    """
    progress(0.1, "what the sensors can show")
    parameters = as_mounted(parameters, inputs.database)
    settings = parameters.settings
    rows, not_seen = _rows(parameters)
    design, model = drawn_model(parameters, inputs.database)
    truths = {one.name: one for one in (*inputs.campaign.runs, *inputs.campaign.bare)}
    found: list[FittedRun | HeldOut | Failed] = []
    missed, shown = tuple[FittedRun, ...](), None
    robots = [(kind, recorded(source, design, model, parameters, weights, anew))
              for kind, source, weights, anew in sources(
                  inputs.measurements, inputs.without_outsole, inputs.campaign, inputs.database)]  # fmt: skip
    for number, (kind, runs) in enumerate(robots):
        progress(0.2 + 0.8 * number / len(robots), f"fitting blind, robot {number + 1} of {len(robots)}")
        drawn = drawn_design(parameters, kind)
        given = list(islice(runs, settings.fitted_runs))
        mine = [fitted_run(drawn, kind, one, model, near) for one in given]
        fits = [fit for fit in mine if isinstance(fit, FittedRun)]
        if number == 0 and isinstance(mine[0], FittedRun):
            shown = followed(drawn, given[0][0], mine[0], model, settings, truths.get(mine[0].name))
        found += mine
        found += [held_out(drawn, kind, fits, one, model, settings.begun_s, near)
                  for one, _ in islice(runs, settings.held_out_runs if fits else 0)]  # fmt: skip
        if number == 0:  # the runs of the other robots are of the same machines
            more = [one for one in islice(runs, settings.discrepancy_runs) if one[0].name in truths]
            others = sorted(each_in_a_process(partial(fitted_run, drawn, kind, model=model, near=near), more))
            missed = _judged([fit for _, fit in others], truths, model.shared)
    return Result(
        settings.planned_runs, rows, not_seen, model.shared, tuple(design.unit(name) for name in model.shared),
        np.array([design.value(name) for name in model.shared]), model.own, model.layout.names,
        _judged(found, truths, model.shared), tuple(one for one in found if isinstance(one, HeldOut)),
        _misses_of(missed, design, model),
        tuple(one for one in found if isinstance(one, Failed)), () if shown is None else (shown,),
        settings.lever_arm_sd)


def _rows(parameters: Parameters) -> tuple[tuple[Determined, ...], tuple[str, ...]]:
    """What a run on the design's own gait can tell, and which combinations no sensor sees."""
    planned = design, _, model = planned_equations(parameters)
    units = [design.unit(name) for name in model.of_design]
    plain = identifiability(*planned, ())
    known, runs = (weighed(parameters.biped),), parameters.settings.planned_runs
    one, all_runs = (identifiability(*planned, known, count) for count in (1, runs))
    rows = tuple(
        Determined(name, units[row], float(one.values[row]), float(one.sd[row]), float(all_runs.sd[row]),
                   all_runs.partners[row], float(all_runs.correlations[row]))
        for row, name in enumerate(model.of_design)
    )
    return rows, tuple(described(each, model.of_design, units, plain.values) for each in plain.unseen)


def fitted_run(
    design: DesignPoint, kind: str, given: Recorded, model: Model, near: Near = MappingProxyType({})
) -> FittedRun | Failed:
    """The own fit of a run of a kind of robot, without a look at any truth, or one step from what is `near`."""
    run, known = given
    try:
        fit = (one_step(design, near[run.name], run, model, known) if run.name in near
               else fit_run(design, run, model, known))
    except StepFailed as reason:
        return Failed(run.name, kind, str(reason))
    sigmas, wider = widening([fit.equations])
    seen = fit.equations.eliminated(len(model.shared))[0] + information_of(known, model.shared)
    hip, foot = (trace(run, fit.equations, side) for side in SIDES)
    return FittedRun(
        name=run.name, kind=kind, design=fit.design, own=fit.own, unknowns=fit.unknowns,
        covariance=wider**2 * covariance_of(seen, design_sizes(design, model.shared)),
        truth=np.full(len(fit.design), math.nan), sigmas=sigmas, wider=wider, walks=fit.evaluations,
        converged=fit.converged, why=fit.why, hip=hip, foot=foot, strikes=run.strikes)  # fmt: skip


def held_out(
    design: DesignPoint, kind: str, fits: Sequence[FittedRun], run: MeasuredRun, model: Model, begun: float, near: Near
) -> HeldOut | Failed:
    """How well the robot of other runs' fits explains a run, and predicts it from its beginning."""
    shared, own = (np.mean(rows, axis=0) for rows in ([fit.design for fit in fits], [fit.own for fit in fits]))
    robot = model.robot(design, shared, own).with_value(SLOPE, design.value(SLOPE))
    try:
        return explained(robot, run, model, begun, kind, near.get(run.name))
    except StepFailed as reason:
        return Failed(run.name, kind, str(reason))


def followed(
    design: DesignPoint, run: MeasuredRun, fit: FittedRun, model: Model, settings: Settings, truth: RunTruth | None
) -> Followed | None:
    """What was known after each sample of the hip; None where the robot cannot be followed to a forecast."""
    mounting = np.array([(fit.unknowns[model.layout.place(name)], sd)
                         for name, sd in zip(OF_MOUNTING, MOUNTED, strict=True)])  # fmt: skip
    there, robot = mounted(model, mounting, fit.wider), model.robot(design, fit.design, fit.own)
    of_any = np.diag(np.square(design_sizes(robot, model.shared)))  # what the run does not show is as it may be drawn
    covariance = np.where(np.isfinite(fit.covariance), fit.covariance, of_any)
    follower = Follower(
        robot, there, block_diag(covariance, np.diag(np.square(OWN * fit.own))), settings, fit.wider,
        unexplained((one.time, one.residual / there.noise_at(run.sampling, side))
                    for side, one in zip(SIDES, (fit.hip, fit.foot), strict=True)))
    instants = list[Instant]()
    with contextlib.suppress(StepFailed):  # as far as it goes
        instants.extend(follow(follower, run))
    if not any(math.isfinite(one.strike) for one in instants):
        return None
    entry = [0 if one.leg == 0 else len(one.state) // 4 for one in instants]  # theta, or psi of the leg that swings
    sign = np.where(np.array(entry) == 0, -1.0, 1.0)
    angle = sign * [one.state[place] for one, place in zip(instants, entry, strict=True)]
    error = [math.sqrt(one.covariance[place, place]) for one, place in zip(instants, entry, strict=True)]
    late, late_sd = lateness([*forecasts(instants, run.strikes)[:, None]])  # of one more strike of this run
    true_time, true_angle = np.zeros(0), np.zeros(0)
    if truth is not None:
        strikes = truth.heel_strike_time[FROM : FROM + len(run.strikes)]
        began = float(np.mean(strikes - run.strikes[: len(strikes)]))
        seen = (truth.leg.time > began + instants[0].time) & (truth.leg.time < began + instants[-1].time)
        true_time, true_angle = truth.leg.time[seen] - began, truth.leg.angle[seen]
    return Followed(
        fit.name, np.array([one.time for one in instants]), np.asarray(angle), np.array(error),
        np.array([one.strike for one in instants]) + late,
        np.hypot([one.strike_sd for one in instants], late_sd),
        np.array([one.step for one in instants]), run.strikes, true_time, true_angle)  # fmt: skip


def _misses_of(found: Sequence[FittedRun], design: DesignPoint, model: Model) -> Misses:
    """By how much fits that rest miss the truth that stands beside them, in shares of a design's values."""
    fits = [fit for fit in found if fit.converged]
    drawn = np.array([design.value(name) for name in model.shared])
    shares = [(fit.design - fit.truth) / drawn for fit in fits]
    pulls = [model.layout.pull(fit.unknowns) for fit in fits]
    own, unknowns = ([getattr(fit, key) for fit in fits] for key in ("own", "unknowns"))
    return Misses(
        tuple(fit.name for fit in fits), np.array(shares).reshape(-1, len(drawn)),
        np.array(own).reshape(-1, len(model.own)), np.array(unknowns).reshape(-1, len(model.layout.names)),
        np.array(pulls))


def _judged(
    found: Iterable[object], truths: Mapping[str, RunTruth], names: Sequence[str]
) -> tuple[FittedRun, ...]:
    """The fits among what was `found`, with the robots' true numbers beside them, where they are known."""
    fits = [fit for fit in found if isinstance(fit, FittedRun)]
    for place, fit in enumerate(fits):
        if fit.name in truths:
            fits[place] = replace(fit, truth=_true(truths[fit.name].robot, names))
    return tuple(fits)


def _true(robot: Biped, names: Sequence[str]) -> Vector:
    """The true numbers of a robot, (d,): those of both legs on average, the length of the first."""
    own = {"biped.leg_length": robot.leg(0).leg_length, "biped.hip_mass": robot.hip_mass}
    return np.array([own[name] if name in own else table_value(robot, name) for name in names])
