"""What the pipeline says when it cannot do what was asked: sentences, an exit code, never a traceback."""

import signal
from collections.abc import Iterable
from typing import Any

FAILED = 1
BAD_INPUT = 2
ANSWER = 3  # what was asked cannot be, for a reason the stage gives: no solution, for example


#: Signals by which somebody stops a command: Ctrl-C, `kill`, and a terminal that closes, which Windows does not tell.
STOPPING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


class StudyError(Exception):
    """Something the user can put right: wrong parameters, a damaged file, a results folder in use.

    `sentences` holds one clear sentence for each thing that is wrong.
    """

    exit_code = BAD_INPUT

    def __init__(self, sentences: str | Iterable[str]) -> None:
        self.sentences = (sentences,) if isinstance(sentences, str) else tuple(sentences)
        super().__init__("\n".join(self.sentences))


class Declined(StudyError):
    """What was asked cannot be, for a reason that a stage gave in another process."""

    exit_code = ANSWER


class StageFailed(StudyError):
    """A stage did not finish: it raised, crashed, or could not write. What was there before is unchanged.

    `outcomes` are those of the run's stages.
    """

    exit_code = FAILED

    def __init__(self, sentences: str | Iterable[str], outcomes: Iterable[Any] = ()) -> None:
        super().__init__(sentences)
        self.outcomes = list(outcomes)


class Lacking(StudyError):
    """A stage needs a result that is not there, as its own stage said no or failed; it says which, and why."""


class Stopped(StudyError):
    """Somebody stopped it; the sentence says what is kept. By another signal than Ctrl-C the code is another one."""

    exit_code = 130


def is_answer(error: BaseException, package: str) -> bool:
    """Whether a stage raised one of its own exceptions: a reasoned refusal such as "no solution", not a defect."""
    return isinstance(error, Declined) or type(error).__module__.split(".")[0] == package


def nearest(name: object, known: Iterable[str]) -> str:
    """The clause `; did you mean "x"?` for the known name closest to `name`, or nothing if none is close."""
    import difflib

    close = difflib.get_close_matches(str(name), list(known), n=1, cutoff=0.6)
    return f'; did you mean "{close[0]}"?' if close else ""
