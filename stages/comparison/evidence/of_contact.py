"""Numbers of the claims on contact and on figure 8."""

from __future__ import annotations

import math

import numpy as np

from stages.comparison.claims import contact, figure_8
from stages.comparison.evidence import studies
from stages.comparison.evidence.evidence import NAN, Evidence
from stages.comparison.hip_motion import farthest
from stages.contact_study.friction_result import changes, crossing
from stages.contact_study.limit_result import COMPLETED
from stages.error_budget.effects import SLIP, UNEXPLAINED
from stages.error_budget.split import POSITION, VELOCITY


def twice_differentiated(e: Evidence) -> contact.TwiceDifferentiated:
    analytic = e.results.analytic
    drift, kept = float(np.abs(analytic.constraint_drift).max()), analytic.without_impact
    return contact.TwiceDifferentiated(drift, abs(kept.slip_at_end), kept.descent_at_end)


def rolling_without_slip(e: Evidence) -> contact.RollingWithoutSlip:
    validity = e.results.analytic.validity
    return contact.RollingWithoutSlip(
        validity.friction_there_is,
        validity.friction_single_stance,
        max(validity.impulse_friction_trailing, validity.impulse_friction_landing),
        validity.time_outside_cone,
        validity.impulse_outside_cone,
    )


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
    variations, limit = e.results.contact_study.default_friction_variations, e.parameters.settings.unaffected_limit
    found = []
    for key in ("stiction_velocity", "friction_velocity"):
        sides = [factor for factor in crossing(variations, key, limit) if math.isfinite(factor)]
        turning = min((max(factor, 1 / factor) for factor in sides), default=math.inf)
        moved = {one.factor: max(pair, key=abs) for one, *pair in changes(variations) if one.name == key}
        halved, doubled = (studies.at(list(moved), list(moved.values()), factor) for factor in (0.5, 2.0))
        creep = e.results.contact_study.default.creep_velocity
        found.append(contact.FrictionVelocities(key, turning, halved, doubled, creep))
    return min(found, key=lambda one: (one.turning, -max(abs(one.halved), abs(one.doubled))))


def hip_displacement(e: Evidence) -> figure_8.HipDisplacement:
    analytic, multibody = e.results.analytic, e.results.multibody
    two = farthest(analytic.walk, multibody.walk, 2 * analytic.gait.period_s)
    limit, cycle = e.results.contact_study.limit, slip_between_cycles(e)
    budget, hardest = e.results.error_budget.step, None
    if limit is not None:
        known = [(share, one) for share, one in zip(limit.family_share, limit.family) if one.outcome == COMPLETED]
        hardest = min(known, key=lambda pair: float(pair[0]), default=None)
    return figure_8.HipDisplacement(
        float(limit.hard.hip_position.max()) if limit is not None else NAN,
        cycle[0],
        float(e.models.same_start.position.max()),
        float(two.max()),
        float(e.models.settled.position.max()),
        studies.ends(budget.split) if budget is not None else (),
        float(limit.ground.hip_position.max()) if limit is not None else NAN,
        float(hardest[1].hip_position.max()) if hardest is not None else NAN,
        float(hardest[0]) if hardest is not None else NAN,
    )


def hip_velocity(e: Evidence) -> figure_8.HipVelocity:
    study = e.results.contact_study
    step = float(study.limit.hard.hip_velocity.max()) if study.limit is not None else NAN
    inside = float(study.ground.impact_velocity.max())
    return figure_8.HipVelocity(step, slip_between_cycles(e)[1], float(e.models.same_start.velocity.max()), inside)


def slip_between_cycles(e: Evidence) -> tuple[float, float]:
    """Largest differences of hip position [m] and velocity [m/s] between the cycles of the two constraint models, at
    equal phase over a stride, velocities outside of impacts: at one, round-off says on which side a phase is."""
    budget = e.results.error_budget.cycle
    if budget is None:
        return NAN, NAN
    slip = budget.split.part(SLIP)
    return budget.split.peak(slip, POSITION), budget.split.peak(slip, VELOCITY)


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
        studies.ends(split),
        split.explained(POSITION),
        budget.cycle.split.explained(POSITION) if budget.cycle is not None else NAN,
    )
