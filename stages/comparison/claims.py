"""What the paper claims, what was found, and why: one function a claim.

`holds` is None where the study cannot decide. Nothing here is typed in: `found` is made of computed numbers.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from stages.analytic.gait.sensitivity import OUTSOLE
from stages.analytic.result import Result as AnalyticResult
from stages.biped.walk import SENSOR_SIGNALS
from stages.comparison.agreement import STANDARD_GRAVITY, ModelAgreement, TwinAgreement
from stages.comparison.measurement import MeasurementAgreement
from stages.comparison.parameters import Settings
from stages.comparison.result import Claim
from stages.contact_study.result import Result as ContactStudy
from stages.error_budget.effects import CREEP, IMPACT, SLIP, UNEXPLAINED
from stages.error_budget.result import Result as ErrorBudget
from stages.error_budget.split import POSITION, VELOCITY
from stages.multibody.result import FrictionVariation


def step_frequency(analytic: AnalyticResult, settings: Settings) -> Claim:
    stated = 2.08
    found = analytic.gait.step_frequency_hz
    return Claim(
        "step_frequency",
        "the simulated walking frequency is 2.08 Hz on a slope of 2 degrees (sections 3.5 and 7.2)",
        f"{found:.4f} Hz, {100 * (found / stated - 1):+.2f} %",
        bool(abs(found / stated - 1) <= settings.frequency_tolerance),
        "nothing was fitted; the rest is within the digits of Table 1 and the unprinted gravity and event settings",
    )


def stable_gait(analytic: AnalyticResult) -> Claim:
    sizes = np.hypot(*analytic.gait.floquet_multipliers.T)
    return Claim(
        "stable_gait",
        "the design of Table 1 walks in a stable gait (sections 2.2 and 3.5)",
        "multipliers of magnitude " + ", ".join(f"{size:.3g}" for size in sizes[:4]),
        analytic.gait.stable,
        "exact multipliers by variational equations; the gait was found from no guess",
    )


MINIMISED = "Table 1 minimises the magnitude of the multipliers (section 2.2)"


def multipliers_minimised(analytic: AnalyticResult) -> Claim:
    now = float(np.hypot(*analytic.gait.floquet_multipliers[0]))
    options = [
        (value, f"{variation.name} {sign}{100 * variation.change:.0f} %")
        for variation in analytic.variations
        if variation.name != OUTSOLE
        for value, sign in ((variation.multiplier_below, "-"), (variation.multiplier_above, "+"))
        if np.isfinite(value)
    ]
    if not options:
        return Claim(
            "multipliers_minimised",
            MINIMISED,
            f"largest multiplier {now:.3f}",
            None,
            "no gait was found with any parameter changed: the design cannot be compared with its neighbours",
        )
    best, how = min(options)
    improves = best < 0.99 * now
    return Claim(
        "multipliers_minimised",
        MINIMISED,
        f"largest multiplier {now:.3f}; {best:.3f} with {how}",
        not improves,
        "one parameter changed alone lowers it further: Table 1 is not a minimum of the largest multiplier; the paper "
        "fine-tuned the optimum to measurements of the robot"
        if improves
        else "no parameter changed alone lowers it by 1 %",
    )


def hip_displacement(models: ModelAgreement, settings: Settings) -> Claim:
    x, y = 1e3 * models.same_start.position
    cx, cy = 1e3 * models.settled.position
    holds = bool(models.same_start.position.max() <= settings.position_limit)
    creep = f"{1e3 * models.creep_velocity:.1f} mm/s"
    return Claim(
        "hip_displacement",
        "hip displacements of the two models differ by at most 0.3 mm (figure 8)",
        f"over one step from the same mid-stance state {x:.2f} mm in x, {y:.2f} mm in y; "
        f"settled cycles at equal phase {cx:.2f} mm and {cy:.2f} mm",
        holds,
        f"over one step, with the contact set that the contact study chose; the stance foot still creeps at {creep} on "
        "average and the trailing foot slips at heel strike, which the rolling constraint forbids: one moves the hip "
        "back, the other on"
        if holds
        else f"friction creep: the stance foot creeps at {creep} on average below the stiction velocity, which the "
        "rolling constraint forbids; it adds up in x",
    )


def hip_velocity(models: ModelAgreement, settings: Settings) -> Claim:
    x, y = 1e3 * models.same_start.velocity
    mx, my = 1e3 * models.same_start_median_velocity
    holds = bool(models.same_start.velocity.max() <= settings.velocity_limit)
    return Claim(
        "hip_velocity",
        "hip velocities of the two models differ by at most 5 mm/s (figure 8)",
        f"over one step from the same mid-stance state at most {x:.1f} mm/s in x, {y:.1f} mm/s in y; "
        f"medians {mx:.1f} and {my:.1f} mm/s",
        holds,
        "but for the fraction of a millisecond between the heel strikes of the two models, where one has the velocity "
        "before the impact and the other that after it"
        if holds
        else "the largest values stand at heel strike, which the constraint model passes in no time and penalty "
        "contact in milliseconds; the median is the creep of the stance foot",
    )


def contact_set(study: ContactStudy, settings: Settings) -> Claim:
    rows = study.variations.rows("contact_stiffness")
    alone = np.append(study.variations.hip_position[rows].max(axis=1), study.default.hip_position.max())
    values = np.append(study.variations.value[rows], study.default.law.contact_stiffness)
    found, law = study.chosen, study.chosen.law
    held = "holds" if study.ground_is_choice else "does not hold"
    stated = (
        "a small change of k_c from Adams' defaults makes the contact resemble the constraints (section 3.3, figure 5)"
    )
    chosen = (
        f"the set with the least difference has k_c = {law.contact_stiffness:g} N/mm^e, c_max = "
        f"{1e-3 * law.contact_damping:g} N s/mm, d = {1e3 * law.damping_depth:g} mm, v_s = "
        f"{1e3 * law.stiction_velocity:g} mm/s and comes to {1e3 * found.hip_position.max():.2f} mm"
    )
    if not np.isfinite(alone).any():
        return Claim("contact_set", stated, chosen, None, "no step with k_c changed alone was finished")
    best = int(np.nanargmin(alone))
    holds = bool(alone[best] <= settings.position_limit)
    return Claim(
        "contact_set",
        stated,
        f"with k_c changed alone the hips differ by at least {1e3 * alone[best]:.2f} mm over a step "
        f"(k_c = {values[best]:g} N/mm^e); {chosen}",
        holds,
        f"judged by the {1e3 * settings.position_limit:g} mm of figure 8; ground.yaml {held} the chosen set"
        if holds
        else f"judged by the {1e3 * settings.position_limit:g} mm of figure 8: at Adams' stiction velocity the foot "
        f"creeps at {1e3 * study.default.creep_velocity:.1f} mm/s whatever k_c is; ground.yaml {held} the chosen set",
    )


def integration_tolerance(budget: ErrorBudget) -> Claim:
    stated = "the remaining differences are due to integration tolerances (figure 8)"
    if budget.step is None:
        return Claim("integration_tolerance", stated, budget.outcome, None, "the difference could not be split")
    split = budget.step.split
    whole, rest = split.total, split.part(UNEXPLAINED)
    integration = 1e3 * budget.step.paper_integration[:, :2].max()
    ends = {effect: 1e3 * split.part(effect)[-1, 0] for effect in (SLIP, CREEP, IMPACT)}
    either = 1e3 * abs(float(split.interaction[-1, 0]))
    found = (
        f"at the paper's tolerances integration moves the hip by {integration:.0e} mm of "
        f"{1e3 * split.peak(whole, POSITION):.2f} mm over one step; "
        f"{100 * split.explained(POSITION):.0f} % of the displacement (rms) and "
        f"{100 * split.explained(VELOCITY):.0f} % of the velocity are explained by other effects"
    )
    if budget.cycle is not None:
        found += (
            f", between cycles {100 * budget.cycle.split.explained(POSITION):.0f} % and "
            f"{100 * budget.cycle.split.explained(VELOCITY):.0f} %"
        )
    return Claim(
        "integration_tolerance",
        stated,
        found,
        bool(integration > 1e3 * split.peak(rest, POSITION)),
        f"after one step creep below v_s has moved the hip by {ends[CREEP]:+.2f} mm, slip of the trailing foot by "
        f"{ends[SLIP]:+.2f} mm, an impact of finite stiffness by {ends[IMPACT]:+.2f} mm; the order in which creep and "
        f"impact are switched on moves {either:.2f} mm either way between them",
    )


def rolling_without_slip(analytic: AnalyticResult, friction: float) -> Claim:
    validity = analytic.validity
    needed = max(validity.impulse_friction_trailing, validity.friction_double_stance)
    return Claim(
        "rolling_without_slip",
        f"with a static friction of {friction:g} the feet roll without slipping (section 3.4)",
        f"single stance uses {validity.friction_single_stance:.2f}; the trailing foot needs "
        f"{validity.friction_double_stance:.3g} in double stance and "
        f"{validity.impulse_friction_trailing:.3g} at heel strike",
        bool(needed <= friction),
        "the constraint that the trailing foot keeps rolling through the impact asks for tangential force with "
        "hardly any normal force; Coulomb friction lets that foot slip",
    )


def friction_velocities(
    variations: Sequence[FrictionVariation], period: float, length: float, limit: float, study: ContactStudy
) -> Claim:
    known = [v for v in variations if np.isfinite(v.period_s)]
    in_period = max((abs(v.period_s / period - 1) for v in known), default=float("nan"))
    in_length = max((abs(v.step_length_m / length - 1) for v in known), default=float("nan"))
    default, rows = study.default.law, study.variations
    near = [
        row
        for key in ("stiction_velocity", "friction_velocity")
        for row in rows.rows(key)
        if 0.5 <= rows.value[row] / getattr(default, key) <= 2.0 and rows.outcome[row] == study.default.outcome
    ]
    moved = [abs(rows.end_position[row, 0] - study.default.end_position[0]) / length for row in near]
    from_default = max(moved, default=float("nan"))
    return Claim(
        "friction_velocities",
        "small to moderate changes of the two transition velocities of friction from their defaults do not affect the "
        "gait (section 3.4)",
        f"from Adams' defaults, changes up to halving and doubling move the hip by up to {100 * from_default:.1f} % of "
        f"a step in one step; from ground.yaml's, they change the settled period by at most {100 * in_period:.2f} % "
        f"and the step length by at most {100 * in_length:.2f} %",
        bool(from_default <= limit) if near else None,
        f"called unaffected up to {100 * limit:g} %; what changes is the creep below the stiction velocity, "
        f"{1e3 * study.default.creep_velocity:.1f} mm/s at Adams' default",
    )


def twice_differentiated_constraints(analytic: AnalyticResult) -> Claim:
    drift = float(np.abs(analytic.constraint_drift).max())
    return Claim(
        "twice_differentiated_constraints",
        "constraints differentiated twice no longer describe rolling without slip (section 2.2)",
        f"integrated at acceleration level, clearance and slip of the trailing foot are {drift:.1e} at toe-off "
        "(leg lengths, pendulum times)",
        bool(drift > 1e-6),
        "from consistent initial conditions the twice differentiated constraints describe rolling; they only drift, "
        "by the integration error",
    )


def twin_settles(twin: TwinAgreement) -> Claim:
    settled = twin.steps_to_settle >= 0
    return Claim(
        "twin_settles",
        "from the simple model's fixed point the twin reaches a stable gait after a few steps (section 5.2)",
        f"period and length of a step within 1 % after step {twin.steps_to_settle}, then {twin.step_frequency:.4f} Hz"
        if settled
        else "period and length of a step do not settle in the steps walked",
        settled,
        "bodies with inertia and four feet have another fixed point than the simple model; the transient leads there",
    )


def twin_like_simple(twin: TwinAgreement, settings: Settings) -> Claim:
    hip_x, hip_y, rate = twin.normalised_rms[:3]
    return Claim(
        "twin_like_simple",
        "the twin's response is nearly identical to the simple model's (section 7.4, figure 16)",
        f"rms difference over range at equal phase: hip forward {hip_x:.3f}, hip up {hip_y:.3f}, "
        f"angular velocity {rate:.3f}",
        bool(max(hip_x, hip_y, rate) <= settings.similarity_limit),
        f"called nearly identical up to {settings.similarity_limit:g}; accelerations differ most at the heel-strike "
        "spike, of which each phase shows the mean around it. The paper gives no parts: their inertia is assumed, and "
        "was balanced between the legs after a first bill of parts made the twin limp, so this likeness is partly "
        "built in",
    )


def measurement_encloses(measured: MeasurementAgreement, settings: Settings) -> Claim:
    shares = [measured.twin[name].envelope_share for name in SENSOR_SIGNALS[:3]]
    return Claim(
        "measurement_encloses",
        "the whole set of 30 runs encloses the simulated curves (section 7.4, figure 16)",
        f"the envelope of {measured.runs} {measured.origin} runs holds the twin over "
        + ", ".join(f"{100 * share:.0f} %" for share in shares)
        + " of the stride (hip forward, hip up, angular velocity)",
        bool(np.min(shares) >= settings.enclosure_share) if measured.origin == "measured" else None,
        "the runs are synthetic, made from the twin: they test the method, they cannot confirm the model"
        if measured.origin != "measured"
        else "measured runs",
    )


def measurement_slower(measured: MeasurementAgreement) -> Claim:
    change = measured.step_frequency / measured.twin_step_frequency - 1
    return Claim(
        "measurement_slower",
        "the prototype walks slightly slower than the models (section 7.4)",
        f"{measured.origin} runs {measured.step_frequency:.4f} Hz, twin {measured.twin_step_frequency:.4f} Hz over the "
        f"same steps, {100 * change:+.2f} %",
        bool(change < 0) if measured.origin == "measured" else None,
        "measured runs"
        if measured.origin == "measured"
        else "the runs are synthetic: the twin with an assumed outsole, push and build tolerance",
    )


def outsole_slows(analytic: AnalyticResult) -> Claim:
    layer = next(v for v in analytic.variations if v.name == OUTSOLE)
    change = layer.frequency_above / analytic.gait.step_frequency_hz - 1
    return Claim(
        "outsole_slows",
        "the length that rubber outsoles add to the legs explains the slower walk (section 7.4)",
        f"an outsole of {100 * layer.change:g} % of the leg changes the simple model's step frequency by "
        f"{100 * change:+.2f} %",
        bool(change < 0) if np.isfinite(change) else None,
        "longer legs are slower pendulums"
        if change < 0
        else "it lengthens the leg, but also raises the leg's mass above the ground and widens the foot's radius, "
        "which quicken the gait; the effects cancel",
    )


def sensor_range(twin: TwinAgreement) -> Claim:
    return Claim(
        "sensor_range",
        "4 g, 2000 deg/s and 100 Hz capture the gait's dynamics (section 7.2)",
        f"the twin's largest specific force is {twin.peak_specific_force / STANDARD_GRAVITY:.1f} g at the hip and "
        f"{twin.peak_foot_specific_force / STANDARD_GRAVITY:.1f} g at the foot, "
        f"its largest rate {np.degrees(twin.peak_rate):.0f} deg/s; "
        f"{1e3 * twin.time_above_range:.1f} ms a step lie above 4 g",
        bool(twin.time_above_range == 0.0),
        "the heel-strike spike exceeds the range and is shorter than a sampling period: a 100 Hz record shows it "
        "clipped or smoothed"
        if twin.time_above_range > 0
        else "all signals stay inside the ranges",
    )


def ramp_length(analytic: AnalyticResult) -> Claim:
    steps = int(2.0 / analytic.gait.step_length_m)
    return Claim(
        "ramp_length",
        "a ramp of 2 m with 11 sets of stepping blocks fits the gait (section 7.1)",
        f"2 m hold {steps} steps of {1e3 * analytic.gait.step_length_m:.1f} mm",
        bool(11 <= steps + 1 <= 14),
        "about one set of blocks a step, less the standing place at each end",
    )


def as_yaml(claims: Sequence[Claim]) -> bytes:
    """The claims as YAML. JSON strings are YAML strings, so quoting is exact."""
    lines = ["# Generated by the comparison stage: the paper's claims against this study."]
    for claim in claims:
        holds = {True: "true", False: "false", None: "null"}[claim.holds]
        lines.append(f"- id: {claim.id}")
        lines += [f"  {key}: {json.dumps(getattr(claim, key), ensure_ascii=False)}" for key in ("stated", "found")]
        lines += [f"  holds: {holds}", f"  why: {json.dumps(claim.why, ensure_ascii=False)}"]
    return ("\n".join(lines) + "\n").encode()
