"""Claims on contact: constraints, friction, and the contact set."""

import math
from collections.abc import Sequence

import numpy as np

from stages.analytic.result import of_friction
from stages.biped.quantity import mm
from stages.comparison.claims.statement import Statement
from stages.comparison.evidence import NAN, Evidence
from stages.comparison.parameters import Settings
from stages.comparison.result import FAILS, HOLDS, HOLDS_IF, OPEN, Judgement, percent, yes_or_no
from stages.contact_study.result import changes, crossing

STUDIED = (
    "contact_study.default_stiffness",
    "contact_study.default_stiction_velocity",
    "contact_study.tolerance",
    "multibody.tolerance",
)


def twice_differentiated(e: Evidence) -> tuple[float, float, float]:
    analytic = e.results.analytic
    drift, kept = float(np.abs(analytic.constraint_drift).max()), analytic.without_impact
    return drift, abs(kept.slip_at_end), kept.descent_at_end


def judge_twice_differentiated(limits: Settings, drift: float, slip: float, descent: float) -> Judgement:
    """Constraints at acceleration level: `drift` after an impact map (1), slip and descent (m/s) kept without one."""
    drifts = drift > limits.drift_limit
    kept = max(slip, descent) > 0
    return Judgement(
        f"with an impact map clearance and slip drift by {drift:.1e} up to toe-off (leg lengths, pendulum "
        f"times); without one the landing foot keeps {slip:.3f} m/s of slip and {descent:.3f} m/s of "
        "descent through double stance",
        HOLDS if drifts else HOLDS_IF if kept else FAILS,
        (
            (drifts, f"even from consistent rates they drift by more than {limits.drift_limit:g}"),
            (
                not drifts and kept,
                "s'' = 0 keeps whatever s' the foot lands with; an impact that first makes s' = 0, as here, leaves "
                f"a drift of {drift:.1e}. The paper names no impact map",
            ),
            (not drifts and not kept, "the foot lands without slip and descent, and s'' = 0 keeps it so"),
        ),
        "no impact map first stops the landing foot" if kept and not drifts else "",
    )


def rolling_without_slip(e: Evidence) -> tuple[float, float, float, float, float, float, float]:
    validity = e.results.analytic.validity
    return (
        validity.friction_there_is,
        validity.friction_single_stance,
        validity.impulse_friction_trailing,
        validity.impulse_friction_landing,
        validity.time_outside_cone,
        validity.impulse_outside_cone,
        e.results.analytic.energy.friction_loss,
    )


def judge_rolling_without_slip(
    limits: Settings, friction: float, single: float, trailing: float, landing: float, time_outside: float,
    impulse_outside: float, slid: float,
) -> Judgement:  # fmt: skip
    """Friction over normal force (1): there is, needed in single stance, by the impulses of heel strike on both feet.

    It is infinite where the ground would have to pull. `time_outside` and `impulse_outside` are the shares (1) of
    double stance in which the trailing foot needs more. A foot with Coulomb's transition needs no more than there is:
    it slides, and friction takes `slid` [J] of a step.
    """
    within = max(single, trailing, landing) <= friction and time_outside == 0 and slid == 0
    of_there_is = 1 / friction if friction > 0 else math.inf
    shares = f"{100 * time_outside:.0f} % of its time and {100 * impulse_outside:.0f} % of its impulse"
    return Judgement(
        f"single stance needs {of_friction(single, '.2f')} of a static coefficient of {friction:g}, the trailing foot "
        f"{of_friction(trailing, '.4g')} and the landing foot {of_friction(landing, '.4g')} at heel strike; in double "
        f"stance the trailing foot is outside the friction cone for {shares}",
        yes_or_no(within),
        (
            (within, f"every phase stays inside the cone, at most at {max(single, trailing, landing):.2f}"),
            (
                0 < friction < trailing < math.inf,
                f"rolling on through the impact needs at the trailing foot {trailing * of_there_is:.3g} times "
                "the friction there is: hardly any normal impulse comes with the tangential one",
            ),
            (slid > 0, f"in double stance the trailing foot slides: friction takes {slid:.2g} J of a step"),
            (friction == 0, "the ground has no friction"),
            (trailing == math.inf, "rolling on through the impact needs the ground to pull the trailing foot"),
            (landing > friction, "the impulse on the landing foot needs more than the friction there is"),
            (
                time_outside > 0,
                "towards toe-off the normal force vanishes before the tangential one: the ratio has no bound there",
            ),
            (single > friction, f"single stance needs {of_friction(single, '.2f')}"),
            (
                not within and single <= friction,
                f"in single stance the foot does roll, with {100 * single * of_there_is:.0f} % of the cone",
            ),
        ),
    )


def contact_set(e: Evidence) -> tuple[float, float, float, float, float]:
    study = e.results.contact_study
    rows = study.variations.rows("contact_stiffness")
    force, value = study.variations.normal_force[rows], study.variations.value[rows]
    default, now = study.default.law.contact_stiffness, study.default.normal_force
    better = np.flatnonzero(force < now)
    near = np.abs(np.log(value / default))
    least = int(better[np.argmin(near[better])]) if len(better) else int(np.argmin(np.nan_to_num(force, nan=np.inf)))
    stiffest = int(np.argmax(np.where(np.isfinite(force), value, -np.inf)))
    return (
        now, float(force[least]), float(value[least] / default), float(force[stiffest]),
        float(value[stiffest] / default),
    )  # fmt: skip


def judge_contact_set(
    limits: Settings, default: float, best: float, factor: float, beyond: float, beyond_factor: float
) -> Judgement:
    """Rms difference of normal forces [N] at Adams' defaults, and with the smallest change of k_c alone that lowers it,
    or else with the best one, and the factor of that change.

    `beyond` is the difference at the largest k_c tried, which is `beyond_factor` times the default.
    """
    size = max(factor, 1 / factor) if factor > 0 else math.nan
    better, known = best < default, math.isfinite(default)
    small = size <= limits.moderate_change
    verdict = OPEN if not known else FAILS if not better else HOLDS if small else HOLDS_IF
    return Judgement(
        f"the normal forces differ by {default:.3f} N rms at the defaults and by {best:.3f} N with "
        f"{factor:.3g} times their k_c",
        verdict,
        (
            (verdict in (HOLDS, HOLDS_IF), f"k_c alone lowers it to {100 * best / default:.0f} %"),
            (
                verdict == HOLDS_IF,
                f"no smaller change that was tried does so; moderate is up to a factor of {limits.moderate_change:g}",
            ),
            (
                known and beyond > default,
                f"a foot on stiffer ground bounces: at {beyond_factor:g} times k_c it is {beyond:.2f} N",
            ),
            (verdict == FAILS, "no k_c that was tried lowers it"),
            (verdict == OPEN, "no step was finished at the defaults"),
        ),
        f"a change by a factor of {size:.1f} is small" if verdict == HOLDS_IF else "",
    )


def contact_set_figure_8(e: Evidence) -> tuple[float, float, float, float, float, float]:
    study, v = e.results.contact_study, e.results.contact_study.variations
    rows = v.rows("contact_stiffness")
    alone = np.append(v.hip_position[rows].max(axis=1), study.default.hip_position.max())
    values = np.append(v.value[rows], study.default.law.contact_stiffness)
    best = int(np.nanargmin(alone)) if np.isfinite(alone).any() else 0
    slips = [(float(v.hip_position[row].max()), float(v.value[row])) for row in v.rows("stiction_velocity")]
    other = min((pair for pair in slips if math.isfinite(pair[0])), default=(NAN, NAN))
    creep = study.default.creep_velocity
    moves = creep * e.results.analytic.gait.period_s
    return float(alone[best]), float(values[best]), creep, moves, *other


def judge_contact_set_figure_8(
    limits: Settings,
    least: float,
    stiffness: float,
    creep: float,
    creep_moves: float,
    other: float,
    other_velocity: float,
) -> Judgement:
    """Least hip difference [m] over a step with k_c alone changed from Adams' defaults; creep [m/s] at the defaults.

    `creep_moves` [m] is how far that creep moves the hip in a step; `other` the difference [m] with `other_velocity`
    [m/s] as stiction velocity.
    """
    if not math.isfinite(least):
        return Judgement("no step", OPEN, ((True, "no step with k_c changed alone was finished"),))
    holds = least <= limits.position_limit
    return Judgement(
        f"at least {mm(least)} over a step (k_c = {stiffness:g} N/mm^e)",
        yes_or_no(holds),
        (
            (holds, f"{mm(least)} is inside figure 8's {1e3 * limits.position_limit:g} mm"),
            (
                not holds and creep_moves > limits.position_limit,
                f"at Adams' stiction velocity the standing foot creeps at {1e3 * creep:.1f} mm/s whatever "
                f"k_c is, {mm(creep_moves)} a step",
            ),
            (
                not holds and other < least,
                f"v_s = {1e3 * other_velocity:g} mm/s alone would bring it to {mm(other)}",
            ),
            (not holds, f"it is {least / limits.position_limit:.1f} times figure 8's limit"),
        ),
    )


def friction_velocities(e: Evidence) -> tuple[str, float, float, float, float]:
    variations, limit = e.results.contact_study.default_friction_variations, e.parameters.settings.unaffected_limit
    found = []
    for key in ("stiction_velocity", "friction_velocity"):
        sides = [factor for factor in crossing(variations, key, limit) if math.isfinite(factor)]
        turning = min((max(factor, 1 / factor) for factor in sides), default=math.inf)
        moved = {one.factor: max(pair, key=abs) for one, *pair in changes(variations) if one.name == key}
        halved, doubled = (at(list(moved), list(moved.values()), factor) for factor in (0.5, 2.0))
        creep = e.results.contact_study.default.creep_velocity
        found.append((key, turning, halved, doubled, creep))
    return min(found, key=lambda one: (one[1], -max(abs(one[2]), abs(one[3]))))


def judge_friction_velocities(
    limits: Settings, velocity: str, turning: float, halved: float, doubled: float, creep: float
) -> Judgement:
    """What a change of a transition velocity from Adams' default does to the gait.

    `turning` is the smallest factor, up or down, at which period or step length changes by the limit (infinite if none
    tried does), `velocity` the parameter; `halved` and `doubled` are the larger of their relative changes at these
    factors. `creep` [m/s] is the standing foot's at the default.
    """
    known = math.isfinite(halved) or math.isfinite(doubled)
    holds, fails = turning >= limits.moderate_change, turning <= limits.small_change
    verdict = OPEN if not known else HOLDS if holds else FAILS if fails else HOLDS_IF
    limit = f"{100 * limits.unaffected_limit:g} %"
    turns = f"a factor of {turning:.2f} on the {velocity.replace('_', ' ')}"
    return Judgement(
        f"from the starting set, period and length of the gait's step change by up to {percent(halved, 1)} at "
        f"half and {percent(doubled, 1)} at twice the {velocity.replace('_', ' ')}"
        + (f"; the change reaches {limit} at {turns}" if math.isfinite(turning) else ""),
        verdict,
        (
            (verdict == HOLDS, f"no change up to a factor of {limits.moderate_change:g} reaches {limit}"),
            (
                verdict == HOLDS_IF,
                f"called unaffected up to {limit}; what changes is creep below the stiction velocity, "
                f"{1e3 * creep:.1f} mm/s at the default",
            ),
            (verdict == FAILS, f"{turns} is a small change, and moves it by {limit} already"),
            (verdict == OPEN, "no walk with a changed transition velocity was finished"),
        ),
        f"the change stays below a factor of {turning:.1f}" if verdict == HOLDS_IF else "",
    )


def at(factors: Sequence[float], changes: Sequence[float], factor: float) -> float:
    """The change at one factor."""
    return next((change for f, change in zip(factors, changes) if math.isclose(f, factor)), NAN)


STATEMENTS = (
    Statement(
        "twice_differentiated_constraints",
        "2.2",
        "A double differentiation of these constraints [...] was found to eliminate the first order terms of s in (6), "
        "resulting in a set of constraints that do not describe rolling without slipping.",
        "integrated at acceleration level, the landing foot slips or sinks by more than an integration error",
        twice_differentiated,
        judge_twice_differentiated,
        ("analytic.tolerance", "analytic.transition"),
        units={"m/s": "slip descent"},
        method=True,
        plain="If only accelerations are held, and nothing stops the landing foot, it slips or sinks into the ground.",
    ),
    Statement(
        "contact_set",
        "3.3, figure 5",
        "[...] a small change in the value of k_c results in an improvement of the contact force model's resemblance "
        "to the ground force that was calculated by the mathematical model [...]",
        "from Adams' defaults, a small change of k_c alone lowers the difference of the normal forces",
        contact_set,
        judge_contact_set,
        STUDIED,
        units={"N": "default best beyond"},
        plain="A springy ground that is a little stiffer or softer than usual pushes more like hard ground.",
    ),
    Statement(
        "contact_set_figure_8",
        "3.3, figure 8",
        "Therefore, this parameter set is used for the comparison of the multibody dynamics model in MSC Adams to the "
        "mathematical model in MATLAB.",
        "with k_c alone changed from Adams' defaults the hips of the two models stay within figure 8's limit",
        contact_set_figure_8,
        judge_contact_set_figure_8,
        STUDIED,
        units={"m": "least creep_moves other", "m/s": "creep other_velocity", "N/mm^e": "stiffness"},
        plain="With the ground stiffness that was chosen, both models move the hip alike.",
    ),
    Statement(
        "rolling_without_slip",
        "3.4",
        "The developed mathematical model in MATLAB assumes pure rolling of the foot on the ground. For this to hold "
        "[...] the friction on the foot must remain static. [...] a value of 1.1 was set for µ_s [...]",
        "friction needed over normal force stays below µ_s in both stances and in the impulses of heel strike",
        rolling_without_slip,
        judge_rolling_without_slip,
        ("ground.friction", "ground.static_friction", "analytic.transition"),
        units={"J": "slid"},
        plain="The feet roll and never slip, because the ground has enough friction.",
    ),
    Statement(
        "friction_velocities",
        "3.4",
        "[...] for small to moderate changes of the stiction and friction transition velocities with respect to the "
        "default, the behaviour of the walker was not affected.",
        "such changes from Adams' defaults leave the gait the same",
        friction_velocities,
        judge_friction_velocities,
        STUDIED,
        units={"m/s": "creep"},
        plain="At which speeds friction passes from sticking to sliding does not matter for the walk.",
    ),
)
