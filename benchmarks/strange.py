"""Puts strange files, and strange graphs, into a small study, and counts what it makes of them.

Run: python -m benchmarks.strange [place ...]. All of them take some minutes; `docs/faults.md` has the table. Ends with
1 and what went wrong if a file is not survived.
"""

import sys
import tempfile
from pathlib import Path

from tests.pipeline.strange import PLACES, Strange
from tests.pipeline.toy import with_commands


def main() -> None:
    """Print the table, a line as each place is done."""
    problems: list[str] = []
    print("| strange file in the place of a | files | survived | lost | wrong | without a sentence |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        study = Path(folder, "study")
        study.mkdir()
        strange = Strange(with_commands(study))
        for place in (place for place in PLACES if place.name in sys.argv[1:] or not sys.argv[1:]):
            for kind in place.makers:
                strange.suffer(place, kind)
            count = strange.counts[place.name]
            print(f"| {place.name} | {count.tried} | {count.survived} | {len(count.lost)} | {len(count.wrong)} | "
                  f"{len(count.told)} |", flush=True)  # fmt: skip
            problems += count.problems
    if problems:
        sys.exit("\n".join(problems))


if __name__ == "__main__":
    main()
