"""Sample index without a packet counter: from the sensor's own stamps, else from the order of the rows."""

from __future__ import annotations

import numpy as np

from stages.imu.clock.indexed import BY_DEVICE_STAMP, BY_ROWS, FEW_FALLS, IndexedRecording, arrival_stamp
from stages.imu.sources.schema import Recording

BACK_S = 0.5  # a sensor's own stamp that falls by more has restarted


def index_without_counter(recording: Recording, exact: int) -> IndexedRecording:
    """Count sampling periods by the sensor's own stamps where there are some, else count rows in order of arrival."""
    stored = recording.rows
    if np.isfinite(recording.device_stamp).sum() > max(1, stored // 2):
        return _index_by_device_stamp(recording, exact)
    name, stamp = arrival_stamp(recording)
    if name == "none":
        rank = np.arange(stored)
        return IndexedRecording(recording, np.zeros(stored, int), rank, 1, exact, 0, 0, 0, None, 0, 0, BY_ROWS)
    known = np.isfinite(stamp)
    recording, stamp = recording.take(known), stamp[known]
    falls = int((np.diff(stamp) < 0).sum())
    order = np.argsort(stamp, kind="stable") if falls > FEW_FALLS else np.arange(len(stamp))
    segment, rank = np.zeros(len(order), dtype=np.int64), np.arange(len(order))
    return IndexedRecording(
        recording.take(order), segment, rank, 1, exact, 0, falls, stored - len(order), None, 0, 0, BY_ROWS
    )


def _index_by_device_stamp(recording: Recording, exact: int) -> IndexedRecording:
    """Sampling periods from the sensor's own stamps, one a sample or one a packet."""
    stored = recording.rows
    recording = recording.take(np.isfinite(recording.device_stamp))
    unusable = stored - recording.rows
    name, arrived = arrival_stamp(recording)
    if name not in ("none", "device"):
        known = np.isfinite(arrived)
        recording, unusable = recording.take(known), unusable + int((~known).sum())
    stamp = recording.device_stamp
    falls = np.diff(stamp) < 0
    restarts = np.append(False, np.diff(stamp) < -BACK_S)
    life = np.cumsum(restarts) if restarts.sum() <= FEW_FALLS else np.zeros(len(stamp), dtype=np.int64)
    order = np.lexsort((stamp, life))
    life, stamp = life[order], stamp[order]
    fresh = np.append(True, (np.diff(stamp) > 0) | (np.diff(life) != 0))
    batch = round(len(stamp) / max(1, int(fresh.sum())))
    if batch < 2:
        order, life, stamp, fresh, batch = order[fresh], life[fresh], stamp[fresh], fresh[fresh], 1
    at = np.flatnonzero(fresh)
    rank = np.arange(len(stamp)) - np.repeat(at, np.diff(np.append(at, len(stamp))))
    step = np.diff(stamp[at])
    usual = float(np.median(step)) if len(step) else 1.0
    periods = np.append(0, np.cumsum(np.where(np.diff(life[at]) == 0, np.maximum(1, np.rint(step / usual)), 1)))
    first = np.append(True, np.diff(life[at]) != 0)
    periods -= periods[first][np.cumsum(first) - 1]
    index = np.repeat(periods, np.diff(np.append(at, len(stamp)))) * batch + np.minimum(rank, batch - 1)
    index = index.astype(np.int64)
    new = np.append(True, (np.diff(index) != 0) | (np.diff(life) != 0))
    return IndexedRecording(
        recording=recording.take(order[new]),
        segment=life[new],
        index=index[new],
        batch_size=batch,
        exact_duplicates=exact,
        key_duplicates=recording.rows - int(new.sum()),
        out_of_order=int(falls.sum()),
        unusable_rows=unusable,
        lost_packets=None,
        gaps=int(((np.diff(index[new]) > 1) & (np.diff(life[new]) == 0)).sum()),
        resets=int(life[-1]) if len(life) else 0,
        numbered_by=BY_DEVICE_STAMP,
    )
