"""Numbers of the claims on the twin."""

from __future__ import annotations

from stages.comparison.claims import twin
from stages.comparison.claims.paper import BLOCK_SETS
from stages.comparison.evidence import walks
from stages.comparison.evidence.evidence import NAN, Evidence, largest


def twin_settles(e: Evidence) -> twin.TwinSettles:
    settling, rung = e.results.twin.settling, e.results.twin_ladder.twin
    first = float(settling.step_period[0]) if len(settling.step_period) else NAN
    period, multiplier = settling.period_s, NAN
    if rung is not None:
        period, multiplier = rung.period_s, largest(rung.plane_multipliers)
    return twin.TwinSettles(settling.steps_to_settle, first, period, multiplier, settling.frequency_text())


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
    reach, rolls = walks.block_reach(e.results.twin.walk, radius, step, BLOCK_SETS)
    needed = (BLOCK_SETS - 1) * step + settings.block_length
    return twin.RampLength(step, needed, reach, rolls, settings.block_length)
