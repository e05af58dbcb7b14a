"""Keeps the map of extremes: docs/extremes.csv, .md and .png from the artefact of the full resolution.

Run first: bipedstudy run extremes --set extremes.resolution=full --set extremes.processes=2
Then: python -m benchmarks.extremes_table [results/extremes.h5]
"""

from __future__ import annotations

import csv
import datetime
import platform
import sys
from importlib.metadata import version
from pathlib import Path

from pipeline.artefact import load
from stages.comparison.figures import extremes, style
from stages.extremes.result import Result, Table
from stages.extremes.verdict import CRASHED, HUNG, WRONG

DOCS = Path(__file__).resolve().parent.parent / "docs"
PACKAGES = ("numpy", "scipy", "numba", "exudyn")
COLUMNS = ("engine", "axis", "value", "changes", "status", "error", "audit", "reference", "reason")

EXPLANATION = """# The extremes

{points} points over all models, {summary}.
Measured on {date} with Python {python}, {versions}. Made by `benchmarks/extremes_table.py`; all points are in
`extremes.csv`.

- *right*: within 1e-4 (leg lengths, pendulum times) of a reference of another make. Gaits and steps: SciPy's DOP853 or
  Radau on the readable equations; where legs ring fast and long, and with Coulomb feet, a rerun at tolerance 1e-12
  beside the energy audit. Assembly "joints": the tree. Tree and twin: a rerun at a hundredth of the tolerance beside
  the energy balance, which has its own column. Rigid limit: the constraint model with Coulomb feet.
- *inaccurate*: further off, but the tolerance asked for or the model's own energy audit tells.
- *refused*: the parameter check or the search for gaits says no, with a reason. That no gait exists is not proven.
- *failed*: the run ended early with a reason: a fall, a standstill, the limit on solver steps.
- *unconfirmed*: an answer whose reference run ended early.
- *wrong*, *crashed*, *hung*: a reference contradicts an answer and nothing in it tells; an exception; no end.

![Map of the extremes](extremes.png)
"""


def markdown(table: Table) -> str:
    """A table of a result as Markdown."""
    title, columns, rows = table
    lines = [f"\n## {title}\n", "| " + " | ".join(columns) + " |", "|" + " --- |" * len(columns)]
    return "\n".join(lines + ["| " + " | ".join(cell.replace("|", "/") for cell in row) + " |" for row in rows]) + "\n"


def main(path: Path) -> None:
    """Write the three files. A map that is not full is not kept."""
    result = load(path, Result)
    if result.resolution != "full":
        raise SystemExit(f"{path} holds the {result.resolution} map; the full one is kept")
    with open(DOCS / "extremes.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row, changes in zip(result.rows(), result.changes, strict=True):
            engine, axis, value, status, error, audit, reference, reason = row
            numbers = [f"{number:.3g}" if number == number else "" for number in (error, audit)]
            writer.writerow([engine, axis, f"{value:g}", changes, status, *numbers, reference, reason[:160]])
    words = EXPLANATION.format(
        points=len(result.status), summary=result.summary().partition(": ")[2], date=datetime.date.today(),
        python=platform.python_version(), versions=", ".join(f"{name} {version(name)}" for name in PACKAGES),
    )  # fmt: skip
    defects = [row for row in result.rows() if row[3] in (WRONG, CRASHED, HUNG)]
    listed = ("Defects", ["engine", "axis", "value", "status", "error", "reason"],
              [[r[0], r[1], f"{r[2]:g}", r[3], f"{r[4]:.1e}", r[7]] for r in defects])  # fmt: skip
    tables = [*result.tables(), *([listed] if defects else [])]
    (DOCS / "extremes.md").write_text(words + "".join(markdown(table) for table in tables), encoding="utf-8")
    with style.drawing():
        pictures = style.pictures("extremes", extremes.draw(result), 150)
    (DOCS / "extremes.png").write_bytes(pictures["figures/extremes.png"])


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "results/extremes.h5"))
