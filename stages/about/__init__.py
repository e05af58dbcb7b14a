"""What every file of this study says of itself, as netCDF readers name it. `CITATION.cff` and `LICENSE` say more."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

#: Errors of the stages' numbers at each level, measured by benchmarks/levels.py, and how the stages computed then.
MEASURED = Path(__file__).with_name("numerical_errors.json")
#: Files of parameters that say what is computed; the others say how.
OF_THE_MACHINE = ("biped.", "ground.")
ATTRIBUTES = {
    "title": "bipedstudy: a reproducible study of a passive biped walker",
    "license": "BSD-3-Clause",
    "references": (
        "Vasileiou, Smyrli, Drogosis, Papadopoulos: Development of a passive biped robot digital twin using analysis, "
        "experiments, and a multibody simulation environment. Mechanism and Machine Theory, 2021"
    ),
}


def computed_how(parameters: str) -> str:
    """A digest of the lines `file.key = value` that say how a stage computed, and not what."""
    lines = [line for line in parameters.splitlines() if not line.startswith(OF_THE_MACHINE)]
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]


def numerical_errors(stage: str, parameters: str) -> dict[str, float]:
    """Errors of a stage's numbers, by their paths in its artefact, in their units; none where nobody measured. Of an
    array and of a table's column, the largest over all rows.

    They are differences from the level reference on the study's own biped and ground; of another, estimates.
    """
    if not MEASURED.exists():
        return {}
    kept = json.loads(MEASURED.read_text(encoding="utf-8")).get(stage, {})
    return dict(kept.get(computed_how(parameters), {}))
