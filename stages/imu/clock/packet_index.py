"""Sample index from the packet counter: the only clock of a sensor that no radio can warp.

A packet counter steps by one a packet, wraps at its modulus, and starts again when the sensor restarts. Rows may be
repeated, swapped, or missing. From (packet, position) every sample gets an index that counts sampling periods within
a segment, where a segment is one life of the sensor between two restarts. A packet that was sent again bears another
stamp and the same readings: its content shows no restart. Without a counter the sensor's own stamps number the
samples, and only without those does the rank of a row, which knows of no loss.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from stages.biped.quantity import quantity
from stages.imu.result import NOT_OBSERVABLE, RowCounts
from stages.imu.sources.schema import Recording

FEW_FALLS = 5  # stamps that fall in the order of storage: a clock that was set, not rows in any order
BY_COUNTER, BY_DEVICE_STAMP, BY_ROWS = "counter", "device stamp", "rows"
REORDER_WINDOW = 64  # packets; a counter that falls back further than this has restarted
LOOK_AHEAD = 5  # packets looked at to distinguish a late packet from a restart
RARE = 0.1  # of the rows that a position in a packet usually has
BACK_S = 0.5  # a sensor's own stamp that falls by more has restarted
AHEAD_S = 60.0  # one that rises by so much more than arrivals do was set
NEIGHBOURS = 5  # stamps before and after a step that tell a lost sample from a late stamp


@dataclass(frozen=True)
class IndexedRecording(RowCounts):
    """Rows in the order they were sampled, each with its place on the sensor's own clock.

    Without a counter `index` is the rank of the row and losses cannot be observed.
    """

    recording: Recording = quantity("-", "the rows")
    segment: np.ndarray = quantity("1", "restarts of the sensor before each, shape (n,)")
    index: np.ndarray = quantity("1", "sampling periods from the start of its segment, shape (n,)")


def arrival_stamp(recording: Recording) -> tuple[str, np.ndarray]:
    """The best stamp a recording has, with its name: phone, else server, else device, else ("none", NaN)."""
    for name in ("phone", "server", "device"):
        stamp = getattr(recording, f"{name}_stamp")
        if np.isfinite(stamp).sum() > max(1, recording.rows // 2):
            return name, stamp
    return "none", np.full(recording.rows, np.nan)


def unwrap_counter(counter: np.ndarray, modulus: int | None) -> tuple[np.ndarray, np.ndarray]:
    """Segment and continuous packet number of each row, rows in order of arrival.

    A fall of the counter is a wrap if it goes from the end of the modulus to its start, a restart if it goes further
    back than packets get swapped or if the next packets repeat numbers already seen, and a late packet otherwise.
    A single number that disagrees with both neighbours is left where it is; it does not start a segment.
    """
    if not len(counter):
        return counter, counter
    starts = np.flatnonzero(np.diff(counter, prepend=counter[0] - 1))
    packets = counter[starts]
    segments, numbers = np.zeros_like(packets), np.zeros_like(packets)
    segment, wraps = 0, 0
    seen: set[int] = set()
    newest = int(packets[0])
    for i, raw in enumerate(packets.tolist()):
        number = raw + wraps
        if modulus and newest - number > modulus // 2:
            number += modulus
            if number - newest < REORDER_WINDOW:
                wraps += modulus
            else:
                number -= modulus
        elif modulus and number - newest > modulus // 2 and wraps:
            number -= modulus  # late, from before the wrap
        if number < newest and _restarted(packets[i : i + LOOK_AHEAD], raw, newest - wraps, seen, wraps):
            segment, wraps, number = segment + 1, 0, raw
            seen, newest = set(), raw
        seen.add(number)
        newest = max(newest, number)
        segments[i], numbers[i] = segment, number
    lengths = np.diff(np.append(starts, len(counter)))
    return np.repeat(segments, lengths), np.repeat(numbers, lengths)


def misread(counter: np.ndarray) -> np.ndarray:
    """Which rows (n,), in order of arrival, bear a packet's number that is far from those before and after, which go on
    beside it: no number of a late packet, which is missing among those before, but of none."""
    starts = np.flatnonzero(np.diff(counter, prepend=np.nan) != 0)
    packets, (_, which, often) = counter[starts], np.unique(counter[starts], return_inverse=True, return_counts=True)
    before, number, after = packets[:-2], packets[1:-1], packets[2:]
    late = (often[which][1:-1] == 1) & (number > packets[:1]) & (number < before)
    alone = np.zeros(len(packets), dtype=bool)
    alone[1:-1] = (np.abs(after - before) <= LOOK_AHEAD) & (np.abs(number - before) > REORDER_WINDOW) & ~late
    return np.repeat(alone, np.diff(np.append(starts, len(counter))))


def _restarted(upcoming: np.ndarray, raw: int, newest: int, seen: set[int], wraps: int) -> bool:
    below = upcoming <= newest
    if below.sum() <= len(upcoming) // 2:
        return False
    repeated = sum(int(number) + wraps in seen for number in upcoming)
    return newest - raw > REORDER_WINDOW or repeated > len(upcoming) // 2


def index_samples(recording: Recording) -> IndexedRecording:
    """Remove duplicates, put the rows in order, split at restarts and count the losses."""
    stored = recording.rows
    recording = recording.take(np.sort(np.unique(as_bytes(recording.table()), return_index=True)[1]))
    exact = stored - recording.rows
    if np.isfinite(recording.packet).sum() < recording.rows / 2:
        return index_without_counter(recording, exact)
    signed = recording.packet < 0  # a counter of 16 bits goes from 32767 to -32768
    recording = replace(recording, packet=recording.packet + signed * (recording.device.counter_modulus or 1 << 16))
    stamp_name, stamp = arrival_stamp(recording)
    usable = np.isfinite(recording.packet) & (recording.packet >= 0) & (np.isfinite(stamp) | (stamp_name == "none"))
    usable &= ~_odd(recording.position)
    recording, stamp = recording.take(usable), stamp[usable]
    first = first_arrivals(recording, stamp)
    sent_again = recording.rows - len(first)
    recording, stamp = recording.take(first), stamp[first]
    batch, position = _positions(recording)
    order = arrival_order(recording.packet, stamp) if stamp_name != "none" else np.arange(recording.rows)
    order = order[~misread(recording.packet[order])]
    segment, packet = unwrap_counter(recording.packet[order].astype(np.int64), recording.device.counter_modulus)
    index = packet * batch + position[order]
    rank = np.argsort(order[np.lexsort((index, segment))])
    late = int((rank < np.maximum.accumulate(rank)).sum())
    unusable = int((~usable).sum()) + recording.rows - len(order)
    return numbered(recording.take(order), segment, index, batch, BY_COUNTER, exact, late, unusable, sent_again)


def numbered(
    recording: Recording, segment: np.ndarray, index: np.ndarray, batch: int, by: str,
    exact: int, out_of_order: int, unusable: int, sent_again: int = 0,
) -> IndexedRecording:
    """The rows by `segment` and `index` (n,), of one index the first; each segment begins with a packet of number 0."""
    order = np.lexsort((index, segment))
    segment, index = segment[order], index[order]
    new = np.append(True, (np.diff(segment) != 0) | (np.diff(index) != 0))[: len(index)]
    order, segment, index = order[new], segment[new], index[new]
    index = index - index[np.searchsorted(segment, segment)] // batch * batch
    same = np.diff(segment) == 0
    lost = int(np.maximum(np.diff(index // batch)[same] - 1, 0).sum()) if by == BY_COUNTER else NOT_OBSERVABLE
    return IndexedRecording(
        recording=recording.take(order),
        segment=segment,
        index=index,
        batch_size=batch,
        exact_duplicates=exact,
        key_duplicates=len(new) - len(order),
        out_of_order=out_of_order,
        unusable_rows=unusable,
        lost_packets=lost,
        gaps=int((np.diff(index)[same] > 1).sum()),
        resets=int(segment[-1]) if len(segment) else 0,
        numbered_by=by,
        sent_again=sent_again,
    )


def arrival_order(packet: np.ndarray, stamp: np.ndarray) -> np.ndarray:
    """Rows (n,) in order of arrival: as they are stored, unless they are stored in any order; then by their stamps.

    A clock that was set back makes stamps fall once or twice; to sort by it would mix what came before and after.
    Packets held back by a stall arrive together: in rows of any order the numbers show theirs.
    """
    return np.lexsort((packet, stamp)) if (np.diff(stamp) < 0).sum() > FEW_FALLS else np.arange(len(stamp))


def first_arrivals(recording: Recording, stamp: np.ndarray) -> np.ndarray:
    """Rows (k,), in order, without those of packets that were sent again: same number, same readings, later stamp.

    Readings that stand under several numbers (a dead or coarse sensor at rest) prove nothing, and stay.
    """
    values = (recording.acceleration, recording.angular_rate)
    order = np.argsort(stamp, kind="stable")
    reading = np.unique(as_bytes(*values), return_inverse=True)[1].ravel()[order]
    key = np.unique(as_bytes(recording.packet, recording.position, recording.device_stamp), return_inverse=True)[1]
    pairs = np.column_stack((reading, key.ravel()[order]))
    _, first, which = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    numbers_of_reading = np.bincount(pairs[first, 0], minlength=len(order))
    keep = np.ones(len(order), dtype=bool)
    keep[order] = (first[which.ravel()] == np.arange(len(order))) | (numbers_of_reading[reading] > 1)
    return np.flatnonzero(keep)


def as_bytes(*columns: np.ndarray) -> np.ndarray:
    """Rows of these columns, (n,) or (n, k) each, as one opaque value (n,) a row: equal ones compare equal, NaN too."""
    table = np.ascontiguousarray(np.column_stack(columns) + 0.0)
    return table.view(np.dtype((np.void, table.shape[1] * 8))).ravel()


def _odd(position: np.ndarray) -> np.ndarray:
    """Which rows (n,) bear a position in the packet that next to no others do."""
    _, which, often = np.unique(position, return_inverse=True, return_counts=True)
    return np.asarray(often[which] < RARE * np.median(often))


def _positions(recording: Recording) -> tuple[int, np.ndarray]:
    """Batch size and position of each row in its packet, from 0; where none is stored, or one for all rows, the rank
    within the packet."""
    position = recording.position - recording.position.min(initial=math.inf)
    if np.isfinite(position).all() and position.any():
        largest = int(position.max()) + 1
        return max(largest, recording.device.batch_size or 1), position.astype(np.int64)
    packet = recording.packet
    starts = np.flatnonzero(np.diff(packet, prepend=np.nan) != 0)
    lengths = np.diff(np.append(starts, len(packet)))
    rank = np.arange(len(packet)) - np.repeat(starts, lengths)
    batch = recording.device.batch_size or int(np.median(lengths)) if len(lengths) else 1
    return max(batch, 1), np.minimum(rank, max(batch, 1) - 1)


def index_without_counter(recording: Recording, exact: int) -> IndexedRecording:
    """Count sampling periods by the sensor's own stamps where there are some, else count rows in order of arrival."""
    stored, stamped = recording.rows, np.isfinite(recording.device_stamp)
    by_stamps = stamped.sum() > max(1, stored // 2) and bool(np.ptp(recording.device_stamp[stamped]))  # ROS has 0
    recording = recording.take(stamped | (not by_stamps))
    name, stamp = arrival_stamp(recording)
    known = np.isfinite(stamp) | (name == "none")
    recording, stamp = recording.take(known), stamp[known]
    if by_stamps:
        return _index_by_device_stamp(recording, exact, stored - recording.rows)
    order, falls = arrival_order(np.zeros(len(stamp)), stamp), int((np.diff(stamp) < 0).sum())
    segment, rank = np.zeros(len(order), dtype=np.int64), np.arange(len(order))
    return numbered(recording.take(order), segment, rank, 1, BY_ROWS, exact, falls, stored - recording.rows)


def _index_by_device_stamp(recording: Recording, exact: int, unusable: int) -> IndexedRecording:
    """Sampling periods from the sensor's own stamps, one a sample or one a packet."""
    stamp = recording.device_stamp
    step, arrived = np.diff(stamp), np.diff(arrival_stamp(recording)[1])
    falls, restarts = int((step < 0).sum()), np.append(False, (step < -BACK_S) | (step - arrived > AHEAD_S))
    life = np.cumsum(restarts) if restarts.sum() <= FEW_FALLS else np.zeros(len(stamp), dtype=np.int64)
    order = np.lexsort((stamp, life))
    life, stamp = life[order], stamp[order]
    fresh = np.append(True, (np.diff(stamp) > 0) | (np.diff(life) != 0))
    batch = max(1, round(len(stamp) / int(fresh.sum())))
    at, which = np.flatnonzero(fresh), np.cumsum(fresh) - 1
    rank, parts = np.arange(len(stamp)) - at[which], np.split(stamp[at], np.flatnonzero(np.diff(life[at])) + 1)
    periods = np.cumsum(np.concatenate([[1, *_advances(part)] for part in parts])) - 1
    index = (periods[which] * batch + np.minimum(rank, batch - 1)).astype(np.int64)
    return numbered(recording.take(order), life, index, batch, BY_DEVICE_STAMP, exact, falls, unusable)


def _advances(stamp: np.ndarray) -> np.ndarray:
    """Sampling periods from each of a life's stamps (k,) to the next, (k - 1,).

    A stamp that jitters is late alone; after a loss all that follow are.
    """
    step, count = np.diff(stamp), len(stamp)
    if count < 2:
        return np.empty(0)
    usual = float(np.quantile(step, 0.5, method="lower"))  # one of them
    usual = float(step[np.abs(step / usual - 1) < 0.5].mean())  # of stamps in ms the median is a whole number
    late = np.pad(stamp - usual * np.arange(count), NEIGHBOURS, "edge")
    level = np.median(np.lib.stride_tricks.sliding_window_view(late, NEIGHBOURS), axis=1)
    stay = level[NEIGHBOURS + 1 : NEIGHBOURS + count] - level[1:count]
    return np.asarray(1 + np.maximum(0, np.rint(np.minimum(step / usual - 1, stay / usual))))
