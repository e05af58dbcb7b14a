"""A packet counter that wraps and restarts, made to count on."""

from __future__ import annotations

import numpy as np

REORDER_WINDOW = 64  # packets; a counter that falls back further than this has restarted
LOOK_AHEAD = 5  # packets looked at to tell a late packet from a restart


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


def _restarted(upcoming: np.ndarray, raw: int, newest: int, seen: set[int], wraps: int) -> bool:
    below = upcoming <= newest
    if below.sum() <= len(upcoming) // 2:
        return False
    repeated = sum(int(number) + wraps in seen for number in upcoming)
    return newest - raw > REORDER_WINDOW or repeated > len(upcoming) // 2
