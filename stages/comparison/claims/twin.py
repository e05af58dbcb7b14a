"""Claims on the twin: settling, likeness to the simple model, pushes, the ramp."""

import math
from collections.abc import Sequence

import numpy as np

from stages.biped.walk import Walk
from stages.comparison.claims.paper import BLOCK_SETS, RAMP_M
from stages.comparison.claims.statement import OF_ITS_ROW, Statement
from stages.comparison.evidence import NAN, Evidence
from stages.comparison.parameters import Settings
from stages.comparison.result import DOES_NOT_APPLY, FAILS, HOLDS, HOLDS_IF, OPEN, Judgement, percent, yes_or_no
from stages.rough_ground.result import CONSTRAINT, PENALTY

RESTS_ON = ("twin.inertia", "twin.parts", "twin.tolerance", "ground.contact_stiffness", "ground.stiction_velocity")
PUSHES = ("sideways_speeds", "roll_rates", "yaw_rates", "yaw_angles")


def twin_settles(e: Evidence) -> tuple[int, float, float, float, str]:
    settling, rung = e.results.twin.settling, e.results.twin_ladder.twin
    first = float(settling.step_period[0]) if len(settling.step_period) else NAN
    period, multiplier = settling.period_s, NAN
    if rung is not None:
        period, multiplier = rung.period_s, e.results.twin_ladder.largest_multipliers[0]
    return settling.steps_to_settle, first, period, multiplier, settling.frequency_text()


def judge_twin_settles(
    limits: Settings, steps: int, first: float, period: float, multiplier: float, frequency: str
) -> Judgement:
    """Steps until the twin has settled (-1: never), the first step's period [s] and its gait's, or the last four's
    where no gait is known, its largest multiplier (NaN if unknown), and the frequency of these four, in words."""
    settled = steps >= 0
    return Judgement(
        f"period and length within 1 % of its leg's last two after step {steps}; last four: {frequency}"
        if settled
        else "period and length of a step do not settle in the steps walked",
        yes_or_no(settled),
        (
            (
                settled and abs(first / period - 1) > 5e-4,
                f"the twin's fixed point is another: the first step is {percent(first / period - 1, 1)} "
                "longer in time than the gait's",
            ),
            (settled and multiplier < 1, f"a step leaves {multiplier:.2f} of a difference"),
            (settled, f"{steps} of the first steps are off the last ones by more than 1 %"),
            (not settled, "period or length still change by more than 1 % in the last steps"),
            (not settled and multiplier >= 1, f"a step multiplies a difference by {multiplier:.2f}"),
        ),
    )


def twin_like_simple(e: Evidence) -> tuple[float, float, float, tuple[tuple[str, float], ...], float, bool]:
    ladder = e.results.twin_ladder
    upto = next((number for number, rung in enumerate(ladder.rungs) if rung.is_twin), len(ladder.rungs) - 1)
    names = [rung.name for rung in ladder.rungs[1 : upto + 1]]
    details = tuple((name, period) for name, period, _ in ladder.changes() if name in names)
    forward, up, rate = (float(value) for value in e.twin.normalised_rms[:3])
    assumed = e.parameters.twin.inertia == "parts"
    return forward, up, rate, details, ladder.simple_period_s, assumed


def judge_twin_like_simple(
    limits: Settings,
    forward: float,
    up: float,
    rate: float,
    details: tuple[tuple[str, float], ...],
    period: float,
    assumed: bool,
) -> Judgement:
    """Rms difference over range (1) of hip forward, hip up and angular velocity at equal phase.

    `details` are the changes of the step period [s] that the twin's details make, from the ladder; `period` [s] is the
    step's; `assumed` whether a bill of parts, which the paper does not give, spreads the mass.
    """
    worst = max(forward, up, rate)
    alike = worst <= limits.similarity_limit
    counts = limits.frequency_tolerance * period
    large = [(name, change) for name, change in details if abs(change) > counts]
    sizes = ", ".join(f"{name} {1e3 * change:+.1f} ms" for name, change in large)
    total = sum(change for _, change in details)
    cancels = len(large) > 1 and abs(total) < max(abs(change) for _, change in large)
    return Judgement(
        f"rms difference over range: hip forward {forward:.3f}, hip up {up:.3f}, angular velocity {rate:.3f}",
        FAILS if not alike else HOLDS_IF if assumed else HOLDS,
        (
            (alike, f"none is above {limits.similarity_limit:g}, which is called almost identical here"),
            (not alike, f"{worst:.2f} is above {limits.similarity_limit:g}"),
            (
                assumed,
                "the paper gives no parts; those of twin.yaml were balanced after a first twin limped, so "
                "likeness is partly built in",
            ),
            (
                cancels,
                f"details act against each other in the step's {1e3 * period:.0f} ms: {sizes}, together "
                f"{1e3 * total:+.1f} ms",
            ),
        ),
        "mass is spread as in the bill of parts that twin.yaml assumes" if alike and assumed else "",
    )


def push_converges(e: Evidence) -> tuple[int, int, tuple[tuple[str, str, float, float], ...], float, float]:
    runs = e.results.campaign.runs
    return (
        sum(run.failed_attempts for run in runs),
        len(runs),
        tuple(e.results.twin_pushes.limits()),
        *e.results.twin_ladder.largest_multipliers,
    )


def judge_push_converges(
    limits: Settings,
    failed: int,
    pushes: int,
    limits_of: tuple[tuple[str, str, float, float], ...],
    multiplier: float,
    sideways: float,
) -> Judgement:
    """How many walks with another push along the path ended before their last step, of how many (the campaign's).

    `limits_of` are, for each kind of push out of the plane, its unit, the largest size walked off and the smallest that
    is not (infinite if none); `multiplier` is the twin's largest in the plane, `sideways` out of it.
    """
    falls = [row for row in limits_of if math.isfinite(row[3])]
    lost = [row[0] for row in limits_of if row[2] == 0]
    along = failed == 0 and pushes > 0
    untried = pushes + failed == 0
    verdict = DOES_NOT_APPLY if untried else FAILS if not along or lost else HOLDS_IF if falls else HOLDS
    bounds = ", ".join(f"{kind} below {fatal:.3g} {unit}" for kind, unit, _, fatal in falls)
    most = ", ".join(f"{kind} {survived:.3g} {unit}" if survived else f"no {kind}"
                     for kind, unit, survived, _ in limits_of)
    return Judgement(
        f"{pushes} pushes along the path (synthetic): {failed} end in a fall; to the side the twin "
        f"walks on after {most}",
        verdict,
        (
            (along and multiplier < 1, f"in the plane a step leaves {multiplier:.2f} of it"),
            (bool(falls) and verdict == HOLDS_IF, "larger pushes to the side topple it"),
            (
                sideways > 0.9,
                f"its heading hardly comes back: a step leaves {sideways:.4f} of a turn to the side",
            ),
            (verdict == HOLDS, "no push that was tried ends in a fall"),
            (untried, "no synthetic campaign was walked: a lab's own measurements take its place"),
            (not along and not untried,
                  f"{failed} of {pushes + failed} pushes along the path end in a fall"),
            (bool(lost), f"even the smallest tried ends in a fall: {', '.join(lost)}"),
        ),
        f"a push to the side is small: {bounds}" if verdict == HOLDS_IF else "",
    )  # fmt: skip


def ramp_length(e: Evidence) -> tuple[float, float, float, float, float]:
    settings, block = e.parameters.twin, e.parameters.blocks.block_length
    step = settings.expected_step or e.results.analytic.gait.step_length_m
    radii = [radius + settings.outsole for radius in e.parameters.biped.foot_radii]
    reach, rolls = block_reach(e.results.twin.walk, radii, step, BLOCK_SETS)
    needed = (BLOCK_SETS - 1) * step + block
    return step, needed, reach, rolls, block


def judge_ramp_length(
    limits: Settings, step: float, needed: float, reach: float, rolls: float, block: float
) -> Judgement:
    """What 11 sets one step [m] apart need [m], and how far the twin's feet come from the middle of their blocks.

    `reach` [m] is the farthest that a standing foot of the twin comes from its block's middle, from landing to leaving,
    NaN if it walks over fewer sets; `rolls` [m] how far it rolls; `block` [m] the block's length.
    """
    room, on_blocks, known = needed <= RAMP_M, reach <= block / 2, math.isfinite(reach)
    verdict = FAILS if not room else OPEN if not known else yes_or_no(on_blocks)
    farthest, half = f"{1e3 * reach:.0f} mm", f"{500 * block:.0f} mm"
    return Judgement(
        f"{BLOCK_SETS} sets {1e3 * step:.1f} mm apart need {needed:.2f} m; "
        + (f"on them the twin's feet roll over {1e3 * rolls:.0f} mm and come no farther than {farthest} from a block's "
           "middle" if known else "the twin walks over fewer"),
        verdict,
        (
            (verdict == HOLDS, f"there are {RAMP_M - needed:.2f} m to spare"),
            (verdict == HOLDS, f"a block carries a foot up to {half} from its middle, the feet need {farthest}"),
            (not room, f"{needed - RAMP_M:.2f} m are missing"),
            (room and known and not on_blocks, f"a foot leaves its block, which ends {half} from its middle"),
            (verdict == OPEN, "the twin walks fewer steps than there are sets"),
        ),
    )


def contact_place(walk: Walk, leg: int, radius: float) -> np.ndarray:
    """Place [m] down the slope of the point of a leg's foot that is nearest to the ground, (n,)."""
    centre = walk.leg_length[:, leg] - radius
    return np.asarray(walk.hip_position[:, 0] + centre * np.sin(walk.leg_angle[:, leg]))


def block_reach(walk: Walk, radii: Sequence[float], step: float, sets: int) -> tuple[float, float]:
    """How far [m] standing feet come from the middles of blocks `step` [m] apart, and how far they roll on average.

    The first block's middle is where the first foot stands at the start. NaN with fewer steps than there are sets.
    """
    places = [contact_place(walk, leg, radius) for leg, radius in enumerate(radii)]
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


def ramp_passed(e: Evidence) -> tuple[int, float, float, float, float, float, float, float, float]:
    found, least = e.results.rough_ground, e.parameters.settings.passing_chance
    rows = found.of(CONSTRAINT)
    good = max((row for row in rows if row.ramp_chance >= least), key=lambda row: row.block_height_rms, default=rows[0])
    other = next(row for row in found.of(PENALTY) if row.block_height_rms == good.block_height_rms)
    lost = min((row.block_height_rms for row in rows if row.ramp_chance < 0.5), default=NAN)
    return (good.ramp_steps + 1, good.block_height_rms, good.ramp_chance, good.ramp_low, good.ramp_high,
            other.ramp_low, other.ramp_high, lost, rows[-1].block_height_rms)


def judge_ramp_passed(
    limits: Settings, sets: int, height: float, chance: float, low: float, high: float, other_low: float,
    other_high: float, lost: float, highest: float,
) -> Judgement:  # fmt: skip
    """Chance to walk over all sets of blocks good to a height [m], with its interval, that of the penalty model, and
    the least height on which half of the walks fall, NaN if none; the highest that was tried."""
    passes, agree = chance >= limits.passing_chance, other_low <= high and low <= other_high
    verdict = FAILS if not passes else HOLDS if height >= highest else HOLDS_IF
    good = f"{1e3 * height:.2g} mm (rms)"
    return Judgement(
        f"{sets} sets are passed with a chance of {chance:.3f} ({low:.3f} to {high:.3f}) on blocks good to {good}; "
        f"with penalty contact {other_low:.3f} to {other_high:.3f}",
        verdict,
        (
            (verdict == HOLDS, "it is so on the highest blocks that were tried"),
            (verdict == HOLDS_IF, "the paper does not print how even its blocks are"),
            (not passes, "on the least height that was tried walks fall more often"),
            (math.isfinite(lost), f"on blocks good to {1e3 * lost:.2g} mm half of the walks fall"),
            (agree, "both models agree within their intervals"),
            (not agree, "the models' intervals do not meet"),
        ),
        f"blocks are good to {good}" if verdict == HOLDS_IF else "",
    )


STATEMENTS = (
    Statement(
        "twin_settles",
        "5.2",
        "[...] these initial conditions are not part of the digital twin's fixed-point trajectory: due to this, a "
        "transient phase during the first few steps appears, which eventually converges to its stable walking pattern.",
        "started on the simple model's fixed point, period and length of the twin's steps settle",
        twin_settles,
        judge_twin_settles,
        RESTS_ON,
        units={"s": "first period"},
        plain="The detailed model, started like the simple one, takes a few uneven steps and then walks evenly.",
    ),
    Statement(
        "ramp_length",
        "7.1",
        "The ramp has a length of 2 meters, and a total of 11 stepping block sets.",
        "11 sets one step apart find room on 2 m, and each foot of the twin comes down within its block",
        ramp_length,
        judge_ramp_length,
        ("ground.block_length", "twin.expected_step", "twin.inertia"),
        units={"m": "step needed reach rolls block"},
        plain="A ramp of 2 m with 11 sets of blocks has room for the walk.",
    ),
    Statement(
        "ramp_passed",
        "7.1",
        "The ramp has a length of 2 meters, and a total of 11 stepping block sets.",
        "on blocks of independent normal heights the walker comes to the last set without a fall",
        ramp_passed,
        judge_ramp_passed,
        ("ground.block_length", "rough_ground.height_from", "rough_ground.heights"),
        units={"m": "height lost highest"},
        plain="On uneven blocks the robot still reaches the end of the ramp.",
    ),
    Statement(
        "push_converges",
        "7.1",
        "[...] the biped easily converged to its stable gait after a well-rehearsed push.",
        "walks that start with another push than the gait's end in the gait",
        push_converges,
        judge_push_converges,
        (*RESTS_ON, "campaign.push_sd", *(f"twin_pushes.{key}" for key in PUSHES)),
        units={OF_ITS_ROW: "limits_of"},
        plain="Pushed off by hand, the robot soon finds its walk.",
    ),
    Statement(
        "twin_like_simple",
        "7.4, figure 16",
        "The simulation results of the simplified model [...] are almost identical with the simulation results of the "
        "detailed model [...]",
        "at equal phase the hip's accelerations and angular velocity of both differ by a small part of their range",
        twin_like_simple,
        judge_twin_like_simple,
        RESTS_ON,
        units={"s": "details period"},
        plain="The detailed and the simple model walk almost alike.",
    ),
)
