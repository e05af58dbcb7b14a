"""The command `bipedstudy`."""

import atexit
import os
import sys
import threading
from typing import NoReturn

import bipedstudy  # first: it says where the engine is


def main() -> NoReturn:
    """Run the command line, and end the process."""
    if bipedstudy.broken:
        print(f"error: {bipedstudy.broken}", file=sys.stderr)
        sys.exit(2)
    from pipeline.cli import main as run

    try:
        run()
    except SystemExit as end:
        if isinstance(end.code, int) and threading.active_count() == 1:
            _leave(end.code)
        raise


def _leave(code: int) -> NoReturn:
    """End the process without taking its modules apart object by object, which is a tenth of a short command."""
    atexit._run_exitfuncs()
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except OSError:  # nobody reads on
        pass
    os._exit(code)


if __name__ == "__main__":
    main()
