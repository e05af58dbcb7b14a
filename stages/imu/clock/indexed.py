"""A recording whose samples are numbered, and the stamps that date them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.imu.sources.schema import Recording

FEW_FALLS = 5  # stamps that fall in the order of storage: a clock that was set, not rows in any order
BY_COUNTER, BY_DEVICE_STAMP, BY_ROWS = "counter", "device stamp", "rows"


@dataclass(frozen=True)
class IndexedRecording:
    """Rows in the order they were sampled, each with its place on the sensor's own clock.

    `index` (n,) counts sampling periods from the start of its `segment` (n,). `lost_packets` is None where there is
    no counter: then `index` is the rank of the row and losses cannot be observed.
    """

    recording: Recording
    segment: np.ndarray
    index: np.ndarray
    batch_size: int
    exact_duplicates: int
    key_duplicates: int
    out_of_order: int
    unusable_rows: int
    lost_packets: int | None
    gaps: int
    resets: int
    numbered_by: str = BY_COUNTER
    sent_again: int = 0


def arrival_stamp(recording: Recording) -> tuple[str, np.ndarray]:
    """The best stamp a recording has, with its name: phone, else server, else device, else ("none", NaN)."""
    for name in ("phone", "server", "device"):
        stamp = getattr(recording, f"{name}_stamp")
        if np.isfinite(stamp).sum() > max(1, recording.rows // 2):
            return name, stamp
    return "none", np.full(recording.rows, np.nan)
