"""Claims on the twin: settling, likeness to the simple model, pushes, the ramp."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.biped.walk import Walk
from stages.comparison.claims.measured import Measured
from stages.comparison.claims.paper import BLOCK_SETS, RAMP_M
from stages.comparison.claims.verdict import (
    DOES_NOT_APPLY,
    FAILS,
    HOLDS,
    HOLDS_IF,
    OPEN,
    Cause,
    Judgement,
    percent,
    yes_or_no,
)
from stages.comparison.evidence import NAN, Evidence, largest
from stages.comparison.parameters import Settings

RESTS_ON = ("twin.inertia", "twin.parts", "twin.tolerance", "ground.contact_stiffness", "ground.stiction_velocity")
PUSHES = ("sideways_speeds", "roll_rates", "yaw_rates", "yaw_angles")


@dataclass(frozen=True)
class TwinSettles(Measured):
    """Steps until the twin has settled (-1: never), the first step's period [s] and its gait's, or the last four's
    where no gait is known, its largest multiplier (NaN if unknown), and the frequency of these four, in words."""

    ID = "twin_settles"
    UNITS = (("s", "first period"),)
    RESTS_ON = RESTS_ON

    steps: int
    first: float
    period: float
    multiplier: float
    frequency: str

    def judge(self, limits: Settings) -> Judgement:
        settled = self.steps >= 0
        return Judgement(
            f"period and length within 1 % of the last four steps' after step {self.steps}; these: {self.frequency}"
            if settled
            else "period and length of a step do not settle in the steps walked",
            yes_or_no(settled),
            (
                Cause(
                    settled and self.first != self.period,
                    f"the twin's fixed point is another: the first step is {percent(self.first / self.period - 1, 1)} "
                    "longer in time than the gait's",
                ),
                Cause(settled and self.multiplier < 1, f"a step leaves {self.multiplier:.2f} of a difference"),
                Cause(settled, f"{self.steps} of the first steps are off the last ones by more than 1 %"),
                Cause(not settled, "period or length still change by more than 1 % in the last steps"),
                Cause(not settled and self.multiplier >= 1, f"a step multiplies a difference by {self.multiplier:.2f}"),
            ),
        )


@dataclass(frozen=True)
class TwinLikeSimple(Measured):
    """Rms difference over range (1) of hip forward, hip up and angular velocity at equal phase.

    `details` are the changes of the step period [s] that the twin's details make, from the ladder; `period` [s] is the
    step's; `assumed` whether a bill of parts, which the paper does not give, spreads the mass.
    """

    ID = "twin_like_simple"
    UNITS = (("s", "details period"),)
    RESTS_ON = RESTS_ON

    forward: float
    up: float
    rate: float
    details: tuple[tuple[str, float], ...]
    period: float
    assumed: bool

    def judge(self, limits: Settings) -> Judgement:
        worst = max(self.forward, self.up, self.rate)
        alike = worst <= limits.similarity_limit
        counts = limits.frequency_tolerance * self.period
        large = [(name, change) for name, change in self.details if abs(change) > counts]
        sizes = ", ".join(f"{name} {1e3 * change:+.1f} ms" for name, change in large)
        total = sum(change for _, change in self.details)
        cancels = len(large) > 1 and abs(total) < max(abs(change) for _, change in large)
        return Judgement(
            f"rms difference over range: hip forward {self.forward:.3f}, hip up {self.up:.3f}, angular velocity "
            f"{self.rate:.3f}",
            FAILS if not alike else HOLDS_IF if self.assumed else HOLDS,
            (
                Cause(alike, f"none is above {limits.similarity_limit:g}, which is called almost identical here"),
                Cause(not alike, f"{worst:.2f} is above {limits.similarity_limit:g}"),
                Cause(
                    self.assumed,
                    "the paper gives no parts; those of twin.yaml were balanced after the twin was seen to limp, so "
                    "likeness is partly built in",
                ),
                Cause(
                    cancels,
                    f"details act against each other in the step's {1e3 * self.period:.0f} ms: {sizes}, together "
                    f"{1e3 * total:+.1f} ms",
                ),
            ),
            "mass is spread as in the bill of parts that twin.yaml assumes" if alike and self.assumed else "",
        )


@dataclass(frozen=True)
class PushConverges(Measured):
    """How many walks with another push along the path ended before their last step, of how many (the campaign's).

    `limits_of` are, for each kind of push out of the plane, its unit, the largest size walked off and the smallest that
    is not (infinite if none); `multiplier` is the twin's largest in the plane, `sideways` out of it.
    """

    ID = "push_converges"
    RESTS_ON = (*RESTS_ON, "campaign.push_sd", *(f"twin_pushes.{key}" for key in PUSHES))

    failed: int
    pushes: int
    limits_of: tuple[tuple[str, str, float, float], ...]
    multiplier: float
    sideways: float

    def unit(self, name: str) -> str:
        """That of the push for a limit."""
        field, _, place = name.partition(".")
        return self.limits_of[int(place[0])][1] if field == "limits_of" else super().unit(name)

    def judge(self, limits: Settings) -> Judgement:
        falls = [row for row in self.limits_of if math.isfinite(row[3])]
        lost = [row[0] for row in self.limits_of if row[2] == 0]
        along = self.failed == 0 and self.pushes > 0
        untried = self.pushes + self.failed == 0
        verdict = DOES_NOT_APPLY if untried else FAILS if not along or lost else HOLDS_IF if falls else HOLDS
        bounds = ", ".join(f"{kind} below {fatal:g} {unit}" for kind, unit, _, fatal in falls)
        most = ", ".join(f"{kind} {survived:g} {unit}" for kind, unit, survived, _ in self.limits_of)
        return Judgement(
            f"{self.pushes} pushes along the path (synthetic): {self.failed} end in a fall; to the side the twin walks "
            f"off {most}",
            verdict,
            (
                Cause(along and self.multiplier < 1, f"in the plane a step leaves {self.multiplier:.2f} of it"),
                Cause(bool(falls) and verdict == HOLDS_IF, "larger pushes to the side topple it within three steps"),
                Cause(
                    self.sideways > 0.9,
                    f"its heading it keeps: to the side a step leaves {self.sideways:.4f} of a difference",
                ),
                Cause(verdict == HOLDS, "no push that was tried ends in a fall"),
                Cause(untried, "no synthetic campaign was walked: a lab's own measurements take its place"),
                Cause(not along and not untried,
                      f"{self.failed} of {self.pushes + self.failed} pushes along the path end in a fall"),
                Cause(bool(lost), f"even the smallest tried ends in a fall: {', '.join(lost)}"),
            ),
            f"a push to the side is small: {bounds}" if verdict == HOLDS_IF else "",
        )  # fmt: skip


@dataclass(frozen=True)
class RampLength(Measured):
    """What 11 sets one step [m] apart need [m], and how far the twin's feet come from the middle of their blocks.

    `reach` [m] is the farthest that a standing foot of the twin comes from its block's middle, from landing to leaving,
    NaN if it walks over fewer sets; `rolls` [m] how far it rolls; `block` [m] the block's length.
    """

    ID = "ramp_length"
    UNITS = (("m", "step needed reach rolls block"),)
    RESTS_ON = ("twin.block_length", "twin.expected_step", "twin.inertia")

    step: float
    needed: float
    reach: float
    rolls: float
    block: float

    def judge(self, limits: Settings) -> Judgement:
        room, on_blocks, known = self.needed <= RAMP_M, self.reach <= self.block / 2, math.isfinite(self.reach)
        verdict = FAILS if not room else OPEN if not known else yes_or_no(on_blocks)
        reach, half = f"{1e3 * self.reach:.0f} mm", f"{500 * self.block:.0f} mm"
        return Judgement(
            f"{BLOCK_SETS} sets {1e3 * self.step:.1f} mm apart need {self.needed:.2f} m; on them the twin's feet roll "
            f"over {1e3 * self.rolls:.0f} mm and come no farther than {reach} from a block's middle",
            verdict,
            (
                Cause(verdict == HOLDS, f"there are {RAMP_M - self.needed:.2f} m to spare"),
                Cause(verdict == HOLDS, f"a block carries a foot up to {half} from its middle, the feet need {reach}"),
                Cause(not room, f"{self.needed - RAMP_M:.2f} m are missing"),
                Cause(room and known and not on_blocks, f"a foot leaves its block, which ends {half} from its middle"),
                Cause(verdict == OPEN, "the twin walks fewer steps than there are sets"),
            ),
        )


def contact_place(walk: Walk, leg: int, radius: float) -> np.ndarray:
    """Place [m] down the slope of the point of a leg's foot that is nearest to the ground, (n,)."""
    centre = walk.leg_length[:, leg] - radius
    return np.asarray(walk.hip_position[:, 0] + centre * np.sin(walk.leg_angle[:, leg]))


def block_reach(walk: Walk, radius: float, step: float, sets: int) -> tuple[float, float]:
    """How far [m] standing feet come from the middles of blocks `step` [m] apart, and how far they roll on average.

    The first block's middle is where the first foot stands at the start. NaN with fewer steps than there are sets.
    """
    places = [contact_place(walk, leg, radius) for leg in (0, 1)]
    origin, reaches, spans = places[0][0], [], []
    for number, (strike, leg) in enumerate(zip(walk.heel_strike_time, walk.heel_strike_leg), 1):
        after = walk.toe_off_time[(walk.toe_off_time > strike) & (walk.toe_off_leg == leg)]
        if number == sets or not len(after):
            break
        edges = np.interp([strike, after[0]], walk.time, places[int(leg)]) - origin - number * step
        reaches.append(np.abs(edges).max())
        spans.append(np.ptp(edges))
    enough = len(reaches) == sets - 1
    return (float(max(reaches)), float(np.mean(spans))) if enough else (float("nan"), float("nan"))


def twin_settles(e: Evidence) -> TwinSettles:
    settling, rung = e.results.twin.settling, e.results.twin_ladder.twin
    first = float(settling.step_period[0]) if len(settling.step_period) else NAN
    period, multiplier = settling.period_s, NAN
    if rung is not None:
        period, multiplier = rung.period_s, largest(rung.plane_multipliers)
    return TwinSettles(settling.steps_to_settle, first, period, multiplier, settling.frequency_text())


def twin_like_simple(e: Evidence) -> TwinLikeSimple:
    ladder = e.results.twin_ladder
    upto = next((number for number, rung in enumerate(ladder.rungs) if rung.is_twin), len(ladder.rungs) - 1)
    names = [rung.name for rung in ladder.rungs[1 : upto + 1]]
    details = tuple((name, period) for name, period, _ in ladder.changes() if name in names)
    forward, up, rate = (float(value) for value in e.twin.normalised_rms[:3])
    assumed = e.parameters.twin.inertia == "parts"
    return TwinLikeSimple(forward, up, rate, details, ladder.simple_period_s, assumed)


def push_converges(e: Evidence) -> PushConverges:
    runs, rung = e.results.campaign.runs, e.results.twin_ladder.twin
    known = rung is not None
    return PushConverges(
        sum(run.failed_attempts for run in runs),
        len(runs),
        tuple(e.results.twin_pushes.limits()),
        largest(rung.plane_multipliers) if rung is not None and known else NAN,
        largest(rung.side_multipliers) if rung is not None and known else NAN,
    )


def ramp_length(e: Evidence) -> RampLength:
    settings = e.parameters.twin
    step = settings.expected_step or e.results.analytic.gait.step_length_m
    radius = e.parameters.biped.foot_radius + settings.outsole
    reach, rolls = block_reach(e.results.twin.walk, radius, step, BLOCK_SETS)
    needed = (BLOCK_SETS - 1) * step + settings.block_length
    return RampLength(step, needed, reach, rolls, settings.block_length)
