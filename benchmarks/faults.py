"""Faults done to a small study, and how often it survived, lost a valid result, or called a wrong one current.

Run: python -m benchmarks.faults [fault ...]. All of them take most of an hour; `docs/faults.md` has the table. The
small study of tests/pipeline goes through the same executor, cache and lock as the real one, but computes in
milliseconds.
"""

import contextlib
import sys
import tempfile
from pathlib import Path

from tests.pipeline import faults


def main() -> None:
    """Print the table, a line as each fault is done."""
    chosen = [line for line in faults.FAULTS if line[0].__name__ in sys.argv[1:] or not sys.argv[1:]]
    print("| fault | runs | survived | lost | wrong |\n|---|---|---|---|---|")
    for fault, name, runs, needs_disk in chosen:
        with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
            study = Path(folder, "study")
            study.mkdir()
            if needs_disk:
                try:
                    stack.enter_context(faults.small_disk(study))
                except OSError as error:
                    print(f"| {name} | not done: {error} | | | |", flush=True)
                    continue
            count = faults.counted(faults.Scene(study), fault, runs)
        print(f"| {name} | {count.tried} | {count.survived} | {len(count.lost)} | {len(count.wrong)} |", flush=True)
        for sentence in count.problems:
            print(sentence, file=sys.stderr)


if __name__ == "__main__":
    main()
