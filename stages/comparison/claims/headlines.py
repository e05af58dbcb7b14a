"""Three sentences of numbers for who reads no more: the gait, the two models, the verdicts."""

from __future__ import annotations

import math
from collections.abc import Sequence

from stages.comparison.claims.paper import FREQUENCY_HZ
from stages.comparison.claims.verdict import DOES_NOT_APPLY, mm
from stages.comparison.result import Claim, counted
from stages.comparison.summary import BipedSummary


def headlines(biped: BipedSummary, claims: Sequence[Claim]) -> list[str]:
    """The sentences, each from the results."""
    differing = (biped.limit_difference, biped.period_difference, biped.length_difference)
    judged = all(claim.verdict != DOES_NOT_APPLY for claim in claims)
    apart = (
        f"As penalty contact hardens, its hip comes to differ from the rolling constraint model's by "
        f"{mm(biped.limit_difference)} over a step from a common state; with this study's contact set settled steps "
        f"differ by {1e3 * biped.period_difference:+.2f} ms and {1e3 * biped.length_difference:+.2f} mm."
    )
    return [
        f"The constraint model takes {biped.step_frequency:.4f} steps a second"
        f"{f', the paper has {FREQUENCY_HZ:g},' if judged else ''} and is "
        f"{'stable' if biped.multiplier < 1 else 'unstable'}: largest multiplier {biped.multiplier:.3f}.",
        *([apart] if all(map(math.isfinite, differing)) else []),
        f"Sentences of the paper, judged by what is computed here: {counted([claim.verdict for claim in claims])}.",
    ]
