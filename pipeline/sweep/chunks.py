"""How many points a worker gets at once: enough that handing them over costs little, few enough to share the end."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

from pipeline.execution.job import Task

_TARGET_S = 2.0


class Chunks:
    """Hands out the points of a sweep, from several threads; the sizes follow the time points have taken so far."""

    def __init__(self, indices: Sequence[int], task: Callable[[int], Task], workers: int) -> None:
        self._indices, self._task, self._workers = indices, task, workers
        self._next, self._done, self._seconds = 0, 0, 0.0
        self._lock = threading.Lock()

    def take(self) -> list[Task]:
        """The next points; none when all are handed out."""
        with self._lock:
            left = len(self._indices) - self._next
            mean = self._seconds / self._done if self._done else _TARGET_S
            fair = -(-left // (2 * self._workers))
            size = max(1, min(int(_TARGET_S / max(mean, 1e-6)), fair, 10_000))
            chosen = self._indices[self._next : self._next + size]
            self._next += len(chosen)
        return [self._task(index) for index in chosen]

    def took(self, points: int, seconds: float) -> None:
        """Points have taken this long."""
        with self._lock:
            self._done += points
            self._seconds += seconds
