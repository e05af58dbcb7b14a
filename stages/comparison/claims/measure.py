"""What is measured for each claim, made in one place from the results, in the paper's order."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.analytic.gait.sensitivity import OUTSOLE
from stages.analytic.result import Result as Analytic
from stages.biped.walk import SENSOR_SIGNALS
from stages.comparison.agreement import ModelAgreement, TwinAgreement
from stages.comparison.claims import contact, figure_8, from_studies, from_walks, gait, measurement, numerics, twin
from stages.comparison.claims.paper import BLOCK_SETS, SETTINGS, STANDARD_GRAVITY
from stages.comparison.claims.verdict import Measured
from stages.comparison.hip_motion import overlay
from stages.comparison.inputs import Inputs
from stages.comparison.measurement import MeasurementAgreement
from stages.comparison.parameters import Parameters
from stages.comparison.summary import BipedSummary
from stages.error_budget.effects import SLIP, UNEXPLAINED
from stages.error_budget.split import POSITION
from stages.tradeoff.result import Row

#: Models of the study of speed against accuracy.
ROLLING, PENALTY = "constraint model, rolling", "penalty model"
NAN = float("nan")


@dataclass(frozen=True)
class Evidence:
    """All that claims are judged from: parameters, results of the stages, and how far they agree."""

    parameters: Parameters
    results: Inputs
    models: ModelAgreement
    twin: TwinAgreement
    measured: MeasurementAgreement


def measure(e: Evidence) -> tuple[Measured, ...]:
    """Every claim's numbers."""
    return (
        constraints_reduce_effort(e),
        twice_differentiated(e),
        multipliers_minimised(e.results.analytic),
        stable_gait(e),
        tight_tolerances(e),
        chaos_amplifies(e.results.analytic),
        contact_set(e),
        contact_set_figure_8(e),
        rolling_without_slip(e),
        friction_velocities(e),
        stiff_solver(e),
        hip_displacement(e),
        hip_velocity(e),
        integration_tolerance(e),
        twin_settles(e),
        ramp_length(e),
        push_converges(e),
        step_frequency(e.results.analytic),
        sensor_range(e),
        twin_like_simple(e),
        encloses(e.measured),
        slower(e.measured),
        outsole_slows(e),
        push_slows(e),
        measurement.PrototypeIsModel(e.measured.origin, ()),
    )


def step_frequency(analytic: Analytic) -> gait.StepFrequency:
    return gait.StepFrequency(analytic.gait.step_frequency_hz, from_studies.rounding(analytic.variations))


def stable_gait(e: Evidence) -> gait.StableGait:
    rung = next((rung for rung in e.results.twin_ladder.rungs if rung.found), None)
    known = rung is not None and rung is e.results.twin_ladder.rungs[0]
    planar = largest(rung.plane_multipliers) if rung is not None and known else NAN
    return gait.StableGait(largest(e.results.analytic.gait.floquet_multipliers), planar)


def largest(multipliers: np.ndarray) -> float:
    """Magnitude of the first of multipliers (j, 2); NaN without any."""
    return float(np.hypot(*multipliers[0])) if len(multipliers) else NAN


def multipliers_minimised(analytic: Analytic) -> gait.MultipliersMinimised:
    options = [
        (value, f"{variation.name} {sign}{100 * variation.change:.0f} %")
        for variation in analytic.variations
        if variation.name != OUTSOLE
        for value, sign in ((variation.multiplier_below, "-"), (variation.multiplier_above, "+"))
        if math.isfinite(value)
    ]
    return gait.MultipliersMinimised(largest(analytic.gait.floquet_multipliers), *min(options, default=(NAN, "")))


def chaos_amplifies(analytic: Analytic) -> gait.ChaosAmplifies:
    steps, matrix = len(analytic.walk.heel_strike_time), analytic.monodromy_matrix
    sizes = [float(np.linalg.norm(np.linalg.matrix_power(matrix, n), 2)) for n in range(1, max(steps, 1) + 1)]
    return gait.ChaosAmplifies(largest(analytic.gait.floquet_multipliers), max(sizes), sizes[-1], len(sizes))


def twice_differentiated(e: Evidence) -> contact.TwiceDifferentiated:
    slip, descent = from_walks.landing_velocity(e.results.analytic.walk, e.parameters.biped.foot_radius)
    return contact.TwiceDifferentiated(float(np.abs(e.results.analytic.constraint_drift).max()), slip, descent)


def rolling_without_slip(e: Evidence) -> contact.RollingWithoutSlip:
    analytic, friction = e.results.analytic, e.parameters.contact.static_friction
    strike = max(analytic.validity.impulse_friction_trailing, analytic.validity.impulse_friction_landing)
    outside = from_walks.outside_the_cone(analytic.walk, friction)
    return contact.RollingWithoutSlip(friction, analytic.validity.friction_single_stance, strike, *outside)


def contact_set(e: Evidence) -> contact.ContactSet:
    study = e.results.contact_study
    rows = study.variations.rows("contact_stiffness")
    force, value = study.variations.normal_force[rows], study.variations.value[rows]
    default, now = study.default.law.contact_stiffness, study.default.normal_force
    better = np.flatnonzero(force < now)
    near = np.abs(np.log(value / default))
    least = int(better[np.argmin(near[better])]) if len(better) else int(np.argmin(np.nan_to_num(force, nan=np.inf)))
    stiffest = int(np.argmax(np.where(np.isfinite(force), value, -np.inf)))
    return contact.ContactSet(
        now, float(force[least]), float(value[least] / default), float(force[stiffest]),
        float(value[stiffest] / default),
    )  # fmt: skip


def contact_set_figure_8(e: Evidence) -> contact.ContactSetFigure8:
    study, v = e.results.contact_study, e.results.contact_study.variations
    rows = v.rows("contact_stiffness")
    alone = np.append(v.hip_position[rows].max(axis=1), study.default.hip_position.max())
    values = np.append(v.value[rows], study.default.law.contact_stiffness)
    best = int(np.nanargmin(alone)) if np.isfinite(alone).any() else 0
    slips = [(float(v.hip_position[row].max()), float(v.value[row])) for row in v.rows("stiction_velocity")]
    other = min((pair for pair in slips if math.isfinite(pair[0])), default=(NAN, NAN))
    creep = study.default.creep_velocity
    moves = creep * e.results.analytic.gait.period_s
    return contact.ContactSetFigure8(float(alone[best]), float(values[best]), creep, moves, *other)


def friction_velocities(e: Evidence) -> contact.FrictionVelocities:
    limits, length, study = e.parameters.settings, e.results.analytic.gait.step_length_m, e.results.contact_study
    found = []
    for key in ("stiction_velocity", "friction_velocity"):
        factors, changes = from_studies.hip_changes(study, key, length)
        turning = from_studies.turning_factor(factors, changes, limits.unaffected_limit)
        halved, doubled = (from_studies.at(factors, changes, factor) for factor in (0.5, 2.0))
        found.append(contact.FrictionVelocities(
            "the hip's place after one step, in step lengths,", key, turning, halved, doubled,
            study.default.creep_velocity,
        ))  # fmt: skip
    return min(found, key=lambda one: one.turning)


def constraints_reduce_effort(e: Evidence) -> numerics.ConstraintsReduceEffort:
    rows, study = e.results.tradeoff.rows, e.results.contact_study
    paper = from_studies.of_the_paper(rows, PENALTY)
    error = paper.errors.hip_position if paper is not None else NAN
    work, more = (from_studies.least_work(of_model(rows, model), error) for model in (ROLLING, PENALTY))
    v, default = study.variations, study.default
    stiffer = [(float(v.value[row]), float(v.solver_steps[row])) for row in v.rows("contact_stiffness")
               if v.outcome[row] == default.outcome]  # fmt: skip
    value, steps = max(stiffer, default=(NAN, NAN))
    return numerics.ConstraintsReduceEffort(
        error, work, more, steps / max(default.solver_steps, 1), value / default.law.contact_stiffness
    )


def of_model(rows: tuple[Row, ...], model: str) -> list[Row]:
    return [row for row in rows if row.model == model]


def tight_tolerances(e: Evidence) -> numerics.TightTolerancesAddRounding:
    rows, paper = of_model(e.results.tradeoff.rows, ROLLING), float(SETTINGS["analytic.tolerance"].value)
    ways = {row.way for row in rows if "default" in row.mark}
    own = sorted((row for row in rows if row.way in ways and row.completed), key=lambda row: row.tolerance)
    if len(own) < 2:
        return numerics.TightTolerancesAddRounding("no way", NAN, NAN, NAN, paper, NAN)
    tightest, before = own[:2]
    usual = min(own, key=lambda row: abs(math.log(row.tolerance / paper)))
    return numerics.TightTolerancesAddRounding(
        tightest.way, tightest.tolerance, tightest.errors.hip_position, before.errors.hip_position, usual.tolerance,
        tightest.evaluations / usual.evaluations,
    )  # fmt: skip


def stiff_solver(e: Evidence) -> numerics.StiffSolver:
    rows, found = e.results.tradeoff.rows, []
    for model in (ROLLING, PENALTY):
        paper = from_studies.of_the_paper(rows, model)
        stiff = paper is not None and not from_studies.explicit(paper)
        error = paper.errors.hip_position if paper is not None and stiff else NAN
        found.append(paper.evaluations if paper is not None and stiff else NAN)
        found.append(from_studies.least_work(filter(from_studies.explicit, of_model(rows, model)), error))
    return numerics.StiffSolver(*found)


def hip_displacement(e: Evidence) -> figure_8.HipDisplacement:
    analytic, multibody = e.results.analytic, e.results.multibody
    two = overlay(analytic.walk, multibody.walk, 2 * analytic.gait.period_s).position
    step, cycle = slip_of_the_trailing_foot(e)
    budget = e.results.error_budget.step
    return figure_8.HipDisplacement(
        step[0],
        cycle[0],
        float(e.models.same_start.position.max()),
        float(np.abs(two).max()),
        float(e.models.settled.position.max()),
        from_studies.ends(budget.split) if budget is not None else (),
    )


def hip_velocity(e: Evidence) -> figure_8.HipVelocity:
    step, cycle = slip_of_the_trailing_foot(e)
    inside = float(e.results.contact_study.ground.impact_velocity.max())
    return figure_8.HipVelocity(step[1], cycle[1], float(e.models.same_start.velocity.max()), inside)


def slip_of_the_trailing_foot(e: Evidence) -> tuple[tuple[float, float], tuple[float, float]]:
    """Largest differences of hip position [m] and velocity [m/s] between the two constraint models: step, cycle."""
    found = []
    for budget in (e.results.error_budget.step, e.results.error_budget.cycle):
        sizes = np.abs(budget.split.part(SLIP)).max(axis=0) if budget is not None else np.full(4, NAN)
        found.append((float(sizes[:2].max()), float(sizes[2:].max())))
    return found[0], found[1]


def integration_tolerance(e: Evidence) -> figure_8.IntegrationTolerance:
    budget = e.results.error_budget
    if budget.step is None:
        return figure_8.IntegrationTolerance(budget.outcome, NAN, NAN, NAN, (), NAN, NAN)
    split = budget.step.split
    return figure_8.IntegrationTolerance(
        budget.outcome,
        float(budget.step.paper_integration[:, :2].max()),
        split.peak(split.total, POSITION),
        split.peak(split.part(UNEXPLAINED), POSITION),
        from_studies.ends(split),
        split.explained(POSITION),
        budget.cycle.split.explained(POSITION) if budget.cycle is not None else NAN,
    )


def twin_settles(e: Evidence) -> twin.TwinSettles:
    settling, rung = e.results.twin.settling, e.results.twin_ladder.twin
    first = float(settling.step_period[0]) if len(settling.step_period) else NAN
    multiplier = largest(rung.plane_multipliers) if rung is not None else NAN
    return twin.TwinSettles(settling.steps_to_settle, first, settling.period_s, multiplier)


def twin_like_simple(e: Evidence) -> twin.TwinLikeSimple:
    ladder = e.results.twin_ladder
    upto = next((number for number, rung in enumerate(ladder.rungs) if rung.is_twin), len(ladder.rungs) - 1)
    names = [rung.name for rung in ladder.rungs[1 : upto + 1]]
    details = tuple((name, period) for name, period, _ in ladder.changes() if name in names)
    forward, up, rate = (float(value) for value in e.twin.normalised_rms[:3])
    assumed = e.parameters.twin.inertia == "parts"
    return twin.TwinLikeSimple(forward, up, rate, details, ladder.simple_period_s, assumed)


def push_converges(e: Evidence) -> twin.PushConverges:
    runs, rung = e.results.campaign.runs, e.results.twin_ladder.twin
    known = rung is not None
    return twin.PushConverges(
        sum(run.failed_attempts for run in runs),
        len(runs),
        tuple(e.results.twin_pushes.limits()),
        largest(rung.plane_multipliers) if rung is not None and known else NAN,
        largest(rung.side_multipliers) if rung is not None and known else NAN,
    )


def ramp_length(e: Evidence) -> twin.RampLength:
    settings = e.parameters.twin
    step = settings.expected_step or e.results.analytic.gait.step_length_m
    radius = e.parameters.biped.foot_radius + settings.outsole
    reach, rolls = from_walks.block_reach(e.results.twin.walk, radius, step, BLOCK_SETS)
    needed = (BLOCK_SETS - 1) * step + settings.block_length
    return twin.RampLength(step, needed, reach, rolls, settings.block_length)


def sensor_range(e: Evidence) -> measurement.SensorRange:
    force = e.results.contact_study.variations.peak_force
    known = force[np.isfinite(force)]
    spread = (float(known.min()), float(known.max())) if len(known) else (NAN, NAN)
    behind = [run.hip.peak_filtered for run in e.results.campaign.runs]
    return measurement.SensorRange(
        e.twin.peak_specific_force / STANDARD_GRAVITY,
        e.twin.peak_foot_specific_force / STANDARD_GRAVITY,
        math.degrees(e.twin.peak_rate),
        e.twin.time_above_range,
        1 / e.twin.step_frequency,
        spread,
        float(np.median(behind)) / STANDARD_GRAVITY if behind else NAN,
    )


def encloses(measured: MeasurementAgreement) -> measurement.MeasurementEncloses:
    shares = tuple(measured.twin[name].envelope_share for name in SENSOR_SIGNALS[:3])
    return measurement.MeasurementEncloses(measured.origin, measured.runs, shares)


def slower(measured: MeasurementAgreement) -> measurement.MeasurementSlower:
    interval = measured.twin_frequency
    return measurement.MeasurementSlower(
        measured.origin, measured.step_frequency, measured.twin_step_frequency, interval.lower, interval.upper
    )


def outsole_slows(e: Evidence) -> measurement.OutsoleSlows:
    analytic = e.results.analytic
    layer = next(v for v in analytic.variations if v.name == OUTSOLE)
    change = layer.frequency_above / analytic.gait.step_frequency_hz - 1
    return measurement.OutsoleSlows(layer.change * e.parameters.biped.leg_length, change, NAN, NAN, NAN)


def push_slows(e: Evidence) -> measurement.PushSlows:
    frequencies = {run.report.name: run.report.step_frequency for run in e.results.imu.runs}
    found = from_studies.pushes_and_frequency(e.results.campaign.runs, frequencies)
    return measurement.PushSlows(e.measured.origin, len(frequencies), *found)


def summarise(e: Evidence) -> BipedSummary:
    """The summary of the study's biped."""
    analytic, validity, rung = e.results.analytic, e.results.analytic.validity, e.results.twin_ladder.twin
    models, work = e.models, constraints_reduce_effort(e)
    return BipedSummary(
        analytic.gait.step_frequency_hz,
        analytic.gait.step_length_m,
        models.period_difference,
        models.step_length_difference,
        float(models.same_start.position.max()),
        e.twin.step_frequency,
        largest(analytic.gait.floquet_multipliers),
        largest(rung.plane_multipliers) if rung is not None else float("nan"),
        validity.friction_single_stance,
        max(validity.impulse_friction_landing, validity.impulse_friction_trailing),
        e.parameters.contact.static_friction,
        math.sin(e.parameters.slope.angle),
        work.constraint,
        work.penalty,
        work.error,
    )
