"""The leg's angle from one integration: its rate less the bias of the still stand, from the angle it stood at."""

from __future__ import annotations

import numpy as np

from stages.imu.trial.events import filled


def leg_angle(time: np.ndarray, lateral_rate: np.ndarray, rest: np.ndarray, rest_angle: float) -> np.ndarray:
    """Angle of the leg from the slope normal (n,) [rad], foot ahead positive.

    lateral_rate (n,) [rad/s] is that of the leg, its bias removed; holes are drawn over. `rest` (n,) marks the still
    stand, in whose mean the angle is `rest_angle` [rad].
    """
    rate = filled(lateral_rate)
    turned = np.append(0.0, np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time)))
    return np.asarray(turned - (turned[rest].mean() if rest.any() else turned[0]) + rest_angle)
