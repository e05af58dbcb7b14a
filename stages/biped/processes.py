"""Independent calls of one function, spread over a process for each core."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any, TypeVar

Argument = TypeVar("Argument")
Answer = TypeVar("Answer")


def context() -> Any:
    """How processes begin: as the variable STAGE_PROCESSES says; without it anew, which is safe in any program."""
    return multiprocessing.get_context(os.environ.get("STAGE_PROCESSES", "spawn"))


def each_in_a_process(
    function: Callable[[Argument], Answer], arguments: Sequence[Argument]
) -> Iterator[tuple[int, Answer]]:
    """Number of an argument and the function's answer, as they get ready: the order is arbitrary.

    Function, arguments and answers must be picklable. On one core, or for one argument, this process does the work.
    An error of a call is raised here, and calls that have not begun are dropped.
    """
    workers = min(len(arguments), os.cpu_count() or 1)
    if workers <= 1:
        for number, argument in enumerate(arguments):
            yield number, function(argument)
        return
    with ProcessPoolExecutor(workers, mp_context=context()) as pool:
        waiting = {pool.submit(function, argument): number for number, argument in enumerate(arguments)}
        try:
            for done in as_completed(waiting):
                yield waiting[done], done.result()
        finally:
            pool.shutdown(cancel_futures=True)
