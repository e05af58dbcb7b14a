"""The state and its variations at given times inside one phase, each as accurate as the integration itself."""

from __future__ import annotations

from typing import Any

import numpy as np

from stages.analytic.derivatives import walking
from stages.analytic.integration.integrator import STAGES, error_norm, step_factor, take_step
from stages.analytic.integration.phase import shift_to_event
from stages.analytic.model.walker import Vector
from stages.analytic.phases.flow import flow
from stages.analytic.phases.guards import guard
from stages.calibration.compiled import compiled

assert walking  # what a varied walker does is registered there

#: Two times closer than this are one.
SAME = 1e-13


@compiled
def march(
    phase: int, y: Vector, p: Any, tolerance: float, times: Vector, states: np.ndarray, rates: np.ndarray
) -> bool:
    """Carry `y`, state and variations, through the rising `times` (n,) since now; False where no step is short enough.

    What it is there and its rates are left in `states` and `rates` (n, y.size).
    """
    size = y.size
    stages, new = np.empty((STAGES, size)), np.empty(size)
    time, h = 0.0, 0.02
    flow(phase, y, p, stages[0])
    for i in range(times.size):
        while times[i] - time > SAME:
            left = times[i] - time
            step = min(h, left)
            take_step(phase, y, step, p, stages, new)
            error = error_norm(y, new, step, p, stages, tolerance)
            if not error <= 1.0:  # written so that NaN is refused
                h = step * (step_factor(error) if error == error else 0.1)
                if h < SAME:
                    return False
                continue
            time = times[i] if step == left else time + step
            for j in range(size):
                y[j] = new[j]
            flow(phase, y, p, stages[0])
            h = max(h, step * step_factor(error)) if step < h else step * step_factor(error)
        for j in range(size):
            states[i, j] = y[j]
            rates[i, j] = stages[0, j]
    return True


@compiled
def arrive(phase: int, y: Vector, p: Any) -> None:
    """Variations at a fixed time of a state `y` at its phase's event become variations at the event, in place."""
    event, rates = y.copy(), np.empty(y.size)
    flow(phase, event, p, rates)
    shift_to_event(phase, y, p, event, rates, guard(phase, event, p, rates, 0)[1])
