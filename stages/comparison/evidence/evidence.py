"""All that claims are judged from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.comparison.agreement import ModelAgreement, TwinAgreement
from stages.comparison.inputs import Inputs
from stages.comparison.parameters import Parameters
from stages.comparison.runs.ingest_score import IngestScore
from stages.comparison.runs.measurement import MeasurementAgreement

NAN = float("nan")


@dataclass(frozen=True)
class Evidence:
    """Parameters, results of the stages, and how far they agree."""

    parameters: Parameters
    results: Inputs
    models: ModelAgreement
    twin: TwinAgreement
    measured: MeasurementAgreement
    ingest: IngestScore | None


def largest(multipliers: np.ndarray) -> float:
    """Magnitude of the first of multipliers (j, 2); NaN without any."""
    return float(np.hypot(*multipliers[0])) if len(multipliers) else NAN
