"""Shared by two stages."""

import numpy as np


def distance(gravity, time):
    """Free fall."""
    return 0.5 * gravity * np.asarray(time) ** 2  # Galileo
