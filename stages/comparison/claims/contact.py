"""Claims on contact: constraints, friction, and the contact set."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.comparison import studies
from stages.comparison.claims.measured import Measured
from stages.comparison.claims.verdict import (
    FAILS,
    HOLDS,
    HOLDS_IF,
    OPEN,
    Cause,
    Judgement,
    mm,
    percent,
    yes_or_no,
)
from stages.comparison.evidence import NAN, Evidence
from stages.comparison.parameters import Settings
from stages.contact_study.result import changes, crossing

STUDIED = ("contact_study.default_stiffness", "contact_study.default_stiction_velocity", "contact_study.tolerance",
           "multibody.tolerance")


@dataclass(frozen=True)
class TwiceDifferentiated(Measured):
    """Constraints at acceleration level: `drift` after an impact map (1), slip and descent (m/s) kept without one."""

    ID = "twice_differentiated_constraints"
    UNITS = (("m/s", "slip descent"),)
    RESTS_ON = ("analytic.tolerance", "analytic.transition")
    METHOD = True

    drift: float
    slip: float
    descent: float

    def judge(self, limits: Settings) -> Judgement:
        drifts = self.drift > limits.drift_limit
        kept = max(self.slip, self.descent) > 0
        return Judgement(
            f"with an impact map clearance and slip drift by {self.drift:.1e} up to toe-off (leg lengths, pendulum "
            f"times); without one the landing foot keeps {self.slip:.3f} m/s of slip and {self.descent:.3f} m/s of "
            "descent through double stance",
            HOLDS if drifts else HOLDS_IF if kept else FAILS,
            (
                Cause(drifts, f"even from consistent rates they drift by more than {limits.drift_limit:g}"),
                Cause(
                    not drifts and kept,
                    "s'' = 0 keeps whatever s' the foot lands with; an impact that first makes s' = 0, as here, leaves "
                    f"a drift of {self.drift:.1e}. The paper names no impact map",
                ),
                Cause(not drifts and not kept, "the foot lands without slip and descent, and s'' = 0 keeps it so"),
            ),
            "no impact map first stops the landing foot" if kept and not drifts else "",
        )


@dataclass(frozen=True)
class RollingWithoutSlip(Measured):
    """Friction over normal force (1): there is, needed in single stance, by the impulses of heel strike.

    `time_outside` and `impulse_outside` are the shares (1) of double stance in which the trailing foot needs more.
    """

    ID = "rolling_without_slip"
    RESTS_ON = ("ground.static_friction", "analytic.transition")

    friction: float
    single: float
    strike: float
    time_outside: float
    impulse_outside: float

    def judge(self, limits: Settings) -> Judgement:
        within = max(self.single, self.strike) <= self.friction and self.time_outside == 0
        shares = f"{100 * self.time_outside:.0f} % of its time and {100 * self.impulse_outside:.0f} % of its impulse"
        return Judgement(
            f"of {self.friction:g} there is, single stance uses {self.single:.2f}, the trailing foot needs "
            f"{self.strike:.4g} at heel strike; in double stance it is outside the friction cone for {shares}",
            yes_or_no(within),
            (
                Cause(within, f"every phase stays inside the cone, at most at {max(self.single, self.strike):.2f}"),
                Cause(
                    self.strike > self.friction,
                    f"rolling on through the impact asks the trailing foot for {self.strike / self.friction:.3g} times "
                    "the friction there is: hardly any normal impulse comes with the tangential one",
                ),
                Cause(
                    self.time_outside > 0,
                    "towards toe-off the normal force vanishes before the tangential one: the ratio has no bound there",
                ),
                Cause(self.single > self.friction, f"single stance needs {self.single:.2f}"),
                Cause(
                    not within and self.single <= self.friction,
                    f"in single stance the foot does roll, with {100 * self.single / self.friction:.0f} % of the cone",
                ),
            ),
        )


@dataclass(frozen=True)
class ContactSet(Measured):
    """Rms difference of normal forces [N] at Adams' defaults, and with the smallest change of k_c alone that lowers it,
    or else with the best one, and the factor of that change.

    `beyond` is the difference at the largest k_c tried, which is `beyond_factor` times the default.
    """

    ID = "contact_set"
    UNITS = (("N", "default best beyond"),)
    RESTS_ON = STUDIED

    default: float
    best: float
    factor: float
    beyond: float
    beyond_factor: float

    def judge(self, limits: Settings) -> Judgement:
        size = max(self.factor, 1 / self.factor) if self.factor > 0 else math.nan
        better, known = self.best < self.default, math.isfinite(self.default)
        small = size <= limits.moderate_change
        verdict = OPEN if not known else FAILS if not better else HOLDS if small else HOLDS_IF
        return Judgement(
            f"the normal forces differ by {self.default:.3f} N rms at the defaults and by {self.best:.3f} N with "
            f"{self.factor:.3g} times their k_c",
            verdict,
            (
                Cause(verdict in (HOLDS, HOLDS_IF), f"k_c alone lowers it to {100 * self.best / self.default:.0f} %"),
                Cause(
                    verdict == HOLDS_IF,
                    f"no smaller change that was tried does so, and a moderate one is up to {limits.moderate_change:g}",
                ),
                Cause(
                    known and self.beyond > self.default,
                    f"a foot on stiffer ground bounces: at {self.beyond_factor:g} times k_c it is {self.beyond:.2f} N",
                ),
                Cause(verdict == FAILS, "no k_c that was tried lowers it"),
                Cause(verdict == OPEN, "no step was finished at the defaults"),
            ),
            f"a change by a factor of {size:.1f} is small" if verdict == HOLDS_IF else "",
        )


@dataclass(frozen=True)
class ContactSetFigure8(Measured):
    """Least hip difference [m] over a step with k_c alone changed from Adams' defaults; creep [m/s] at the defaults.

    `creep_moves` [m] is how far that creep moves the hip in a step; `other` the difference [m] with `other_velocity`
    [m/s] as stiction velocity.
    """

    ID = "contact_set_figure_8"
    UNITS = (("m", "least creep_moves other"), ("m/s", "creep other_velocity"), ("N/mm^e", "stiffness"))
    RESTS_ON = STUDIED

    least: float
    stiffness: float
    creep: float
    creep_moves: float
    other: float
    other_velocity: float

    def judge(self, limits: Settings) -> Judgement:
        if not math.isfinite(self.least):
            return Judgement("no step", OPEN, (Cause(True, "no step with k_c changed alone was finished"),))
        holds = self.least <= limits.position_limit
        return Judgement(
            f"at least {mm(self.least)} over a step (k_c = {self.stiffness:g} N/mm^e)",
            yes_or_no(holds),
            (
                Cause(holds, f"{mm(self.least)} is inside figure 8's {1e3 * limits.position_limit:g} mm"),
                Cause(
                    not holds and self.creep_moves > limits.position_limit,
                    f"at Adams' stiction velocity the standing foot creeps at {1e3 * self.creep:.1f} mm/s whatever "
                    f"k_c is, {mm(self.creep_moves)} a step",
                ),
                Cause(
                    not holds and self.other < self.least,
                    f"v_s = {1e3 * self.other_velocity:g} mm/s alone would bring it to {mm(self.other)}",
                ),
                Cause(not holds, f"it is {self.least / limits.position_limit:.1f} times figure 8's limit"),
            ),
        )


@dataclass(frozen=True)
class FrictionVelocities(Measured):
    """What a change of a transition velocity from Adams' default does to the gait.

    `turning` is the smallest factor, up or down, at which period or step length changes by the limit (infinite if none
    tried does), `velocity` the parameter; `halved` and `doubled` are the larger of their relative changes at these
    factors. `creep` [m/s] is the standing foot's at the default.
    """

    ID = "friction_velocities"
    UNITS = (("m/s", "creep"),)
    RESTS_ON = STUDIED

    velocity: str
    turning: float
    halved: float
    doubled: float
    creep: float

    def judge(self, limits: Settings) -> Judgement:
        known = math.isfinite(self.halved) or math.isfinite(self.doubled)
        holds, fails = self.turning >= limits.moderate_change, self.turning <= limits.small_change
        verdict = OPEN if not known else HOLDS if holds else FAILS if fails else HOLDS_IF
        limit = f"{100 * limits.unaffected_limit:g} %"
        turns = f"a factor of {self.turning:.2f} on the {self.velocity.replace('_', ' ')}"
        return Judgement(
            f"from Adams' defaults, period and length of the gait's step change by up to {percent(self.halved, 1)} at "
            f"half and {percent(self.doubled, 1)} at twice the {self.velocity.replace('_', ' ')}"
            + (f"; it reaches {limit} at {turns}" if math.isfinite(self.turning) else ""),
            verdict,
            (
                Cause(verdict == HOLDS, f"no change up to a factor of {limits.moderate_change:g} reaches {limit}"),
                Cause(
                    verdict == HOLDS_IF,
                    f"called unaffected up to {limit}; what changes is creep below the stiction velocity, "
                    f"{1e3 * self.creep:.1f} mm/s at the default",
                ),
                Cause(verdict == FAILS, f"{turns} is a small change, and moves it by {limit} already"),
                Cause(verdict == OPEN, "no walk with a changed transition velocity was finished"),
            ),
            f"the change stays below a factor of {self.turning:.1f}" if verdict == HOLDS_IF else "",
        )


def twice_differentiated(e: Evidence) -> TwiceDifferentiated:
    analytic = e.results.analytic
    drift, kept = float(np.abs(analytic.constraint_drift).max()), analytic.without_impact
    return TwiceDifferentiated(drift, abs(kept.slip_at_end), kept.descent_at_end)


def rolling_without_slip(e: Evidence) -> RollingWithoutSlip:
    validity = e.results.analytic.validity
    return RollingWithoutSlip(
        validity.friction_there_is,
        validity.friction_single_stance,
        max(validity.impulse_friction_trailing, validity.impulse_friction_landing),
        validity.time_outside_cone,
        validity.impulse_outside_cone,
    )


def contact_set(e: Evidence) -> ContactSet:
    study = e.results.contact_study
    rows = study.variations.rows("contact_stiffness")
    force, value = study.variations.normal_force[rows], study.variations.value[rows]
    default, now = study.default.law.contact_stiffness, study.default.normal_force
    better = np.flatnonzero(force < now)
    near = np.abs(np.log(value / default))
    least = int(better[np.argmin(near[better])]) if len(better) else int(np.argmin(np.nan_to_num(force, nan=np.inf)))
    stiffest = int(np.argmax(np.where(np.isfinite(force), value, -np.inf)))
    return ContactSet(
        now, float(force[least]), float(value[least] / default), float(force[stiffest]),
        float(value[stiffest] / default),
    )  # fmt: skip


def contact_set_figure_8(e: Evidence) -> ContactSetFigure8:
    study, v = e.results.contact_study, e.results.contact_study.variations
    rows = v.rows("contact_stiffness")
    alone = np.append(v.hip_position[rows].max(axis=1), study.default.hip_position.max())
    values = np.append(v.value[rows], study.default.law.contact_stiffness)
    best = int(np.nanargmin(alone)) if np.isfinite(alone).any() else 0
    slips = [(float(v.hip_position[row].max()), float(v.value[row])) for row in v.rows("stiction_velocity")]
    other = min((pair for pair in slips if math.isfinite(pair[0])), default=(NAN, NAN))
    creep = study.default.creep_velocity
    moves = creep * e.results.analytic.gait.period_s
    return ContactSetFigure8(float(alone[best]), float(values[best]), creep, moves, *other)


def friction_velocities(e: Evidence) -> FrictionVelocities:
    variations, limit = e.results.contact_study.default_friction_variations, e.parameters.settings.unaffected_limit
    found = []
    for key in ("stiction_velocity", "friction_velocity"):
        sides = [factor for factor in crossing(variations, key, limit) if math.isfinite(factor)]
        turning = min((max(factor, 1 / factor) for factor in sides), default=math.inf)
        moved = {one.factor: max(pair, key=abs) for one, *pair in changes(variations) if one.name == key}
        halved, doubled = (studies.at(list(moved), list(moved.values()), factor) for factor in (0.5, 2.0))
        creep = e.results.contact_study.default.creep_velocity
        found.append(FrictionVelocities(key, turning, halved, doubled, creep))
    return min(found, key=lambda one: (one.turning, -max(abs(one.halved), abs(one.doubled))))
