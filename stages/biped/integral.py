"""The integral of what is sampled, at every sample."""

from __future__ import annotations

import numpy as np


def running_integral(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Integral of values (n,) from the first of their times (n,) [s] to each, straight between them.

    As `scipy.integrate.cumulative_trapezoid`, which takes half a second to load.
    """
    return np.append(0.0, np.cumsum(np.diff(time) * (values[1:] + values[:-1]) / 2.0))
