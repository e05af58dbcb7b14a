"""What every file of this study says of itself, as netCDF readers name it. `CITATION.cff` and `LICENSE` say more."""

from __future__ import annotations

import json
from pathlib import Path

#: Differences of the stages' numbers from the level reference, measured by benchmarks/levels.py: stage -> digest of all
#: parameters -> path -> difference. A number has an error if its own parameters were the measured ones.
MEASURED = Path(__file__).with_name("numerical_errors.json")
#: Error given for a measured difference.
TIMES = 2.0
ATTRIBUTES = {
    "title": "bipedstudy: a reproducible study of a passive biped walker",
    "license": "BSD-3-Clause",
    "references": (
        "Vasileiou, Smyrli, Drogosis, Papadopoulos: Development of a passive biped robot digital twin using analysis, "
        "experiments, and a multibody simulation environment. Mechanism and Machine Theory, 2021"
    ),
}


def numerical_errors(stage: str, settings: str) -> dict[str, float]:
    """Errors of a stage's numbers, by their paths in its artefact, in their units; none where nobody measured. Of an
    array and of a table's column, the largest over all rows.

    `settings` is the digest of all parameters that the numbers follow from; with others none is known. What was
    measured is the difference from a finer computation, which the error may exceed.
    """
    kept = json.loads(MEASURED.read_text(encoding="utf-8")).get(stage, {})
    return {path: TIMES * error for path, error in kept.get(settings, {}).items()}
