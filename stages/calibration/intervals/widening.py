"""How much wider intervals are than noise would have them, by the size and the structure of the residuals."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stages.calibration.angles.prediction import correlation_length
from stages.calibration.estimation.equations import Equations
from stages.calibration.observation.unknowns import SIDES

#: Traces with fewer samples tell nothing of how neighbours hang together.
FEWEST = 10


def widening(fits: Sequence[Equations]) -> tuple[float, float]:
    """Root mean square residual of runs in sigmas, and the factor on intervals for it and for neighbours that hang
    together."""
    size = sum(one.chi2 for one in fits) / sum(one.count for one in fits)
    traces = [one.residuals[side][:, [column]] for one in fits for side in SIDES for column in range(3)]
    seen = [one[np.isfinite(one[:, 0])] for one in traces]
    length = correlation_length(dict(enumerate(one for one in seen if len(one) > FEWEST)))
    return math.sqrt(size), max(1.0, math.sqrt(size * max(1.0, length)))
