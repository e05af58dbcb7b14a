"""Independent calls of one function, spread over a process for each core, and how far a stage has come."""

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any, TypeVar

Argument = TypeVar("Argument")
Answer = TypeVar("Answer")
_kept: tuple[Callable[..., Any], tuple[Any, ...]]


def context() -> Any:
    """How processes begin: as the variable STAGE_PROCESSES says; without it anew, which is safe in any program."""
    return multiprocessing.get_context(os.environ.get("STAGE_PROCESSES", "spawn"))


def each_in_a_process(
    function: Callable[..., Answer], arguments: Sequence[Argument], *shared: Any
) -> Iterator[tuple[int, Answer]]:
    """Number of an argument and the function's answer, as they get ready: the order is arbitrary.

    A call is given what is `shared`, and then its argument; processes that are forked have the former already. All and
    the answers must be picklable. On one core, or for one argument, this process does the work. An error of a call is
    raised here, and calls that have not begun are dropped.
    """
    workers = min(len(arguments), os.cpu_count() or 1)
    if workers <= 1:
        for number, argument in enumerate(arguments):
            yield number, function(*shared, argument)
        return
    with ProcessPoolExecutor(workers, context(), _keep, (function, shared)) as pool:
        waiting = {pool.submit(_call, argument): number for number, argument in enumerate(arguments)}
        try:
            for done in as_completed(waiting):
                yield waiting[done], done.result()
        finally:
            pool.shutdown(cancel_futures=True)


def _keep(function: Callable[..., Any], shared: tuple[Any, ...]) -> None:
    """What a process is begun with."""
    global _kept
    _kept = function, shared


def _call(argument: Any) -> Any:
    function, shared = _kept
    return function(*shared, argument)


Progress = Callable[[float, str], None]
"""Called with the fraction done (0 to 1) and a few words on what is being computed."""


def ignore(fraction: float, what: str) -> None:
    """Report to no one: the default of every stage's `run`."""
