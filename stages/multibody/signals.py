"""Which signals of a walk are recorded, beside the motion by which the walk is found.

The motion is recorded at every solver step: events, energy and what is sampled are computed from it. A signal that is
not named has no sensor in Exudyn and no rows in the result.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

#: Force of the ground on each foot; specific force and angular velocity of both sensors; of each foot in contact its
#: slip velocity and its penetration.
GROUND_REACTION, IMU, SLIP, PENETRATION = SIGNALS = ("ground_reaction", "imu", "slip", "penetration")
#: Those that later stages and figures read.
READ_LATER = (GROUND_REACTION, IMU, SLIP)

Rows = Mapping[str, np.ndarray]


def reactions(rows: Rows, count: int) -> np.ndarray:
    """Force of the ground on each foot from Exudyn's sensors `ground 0` and `ground 1`, (n, 2, 2) [N].

    (n, 0, 2) without these sensors.
    """
    names = [name for name in ("ground 0", "ground 1") if name in rows]
    return np.stack([-rows[name][:, 1:3] for name in names], axis=1) if names else np.zeros((count, 0, 2))


def sampled_bytes(*parts: Any) -> int:
    """Size of arrays and of the arrays that results hold [B]."""
    total = 0
    for part in parts:
        if isinstance(part, np.ndarray):
            total += part.nbytes
        else:
            total += sampled_bytes(*(getattr(part, field.name) for field in dataclasses.fields(part)))
    return total
