"""What the comparison reads, and all that claims are judged from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar, cast

from stages.biped.accuracy.scales import quickness
from stages.campaign.result import Result as Campaign
from stages.comparison.agreement import ModelAgreement, TwinAgreement, compare_models, compare_twin
from stages.comparison.ingest_score import IngestScore, score_ingest
from stages.comparison.measurement import MeasurementAgreement, compare_measurement
from stages.comparison.parameters import Parameters
from stages.comparison.sources import Results
from stages.comparison.stride import NoEvidence, Stride, last_stride


@dataclass(frozen=True)
class Inputs(Results):
    """Those that are compared and judged. `closer` are those of closer solvers: what numbers then differ by are their
    errors.
    """

    campaign: Campaign
    closer: Inputs | None = None


NAN = float("nan")
T = TypeVar("T")


class _There:
    """Results by the names of their stages; one that is not there says why as soon as it is read."""

    def __init__(self, inputs: Inputs) -> None:
        self._inputs = inputs

    def __getattr__(self, name: str) -> Any:
        if name in self._inputs.missing:
            raise NoEvidence(self._inputs.missing[name])
        return getattr(self._inputs, name)


@dataclass(frozen=True)
class Evidence:
    """Parameters, results of the stages, and how far they agree. Whatever rests on a result that is not there, or on a
    walk without a whole stride, raises NoEvidence.
    """

    parameters: Parameters
    inputs: Inputs

    @cached_property
    def results(self) -> Inputs:
        """The results."""
        return cast(Inputs, _There(self.inputs))

    def strides(self, *names: str) -> dict[str, Stride]:
        """The last stride of each model's walk."""
        points = self.parameters.settings.phase_points
        return {name: last_stride(getattr(self.results, name).walk, points) for name in names}

    @cached_property
    def models(self) -> ModelAgreement:
        """Constraint model against penalty model."""
        strides = self.strides("analytic", "multibody")
        return compare_models(self.results.analytic, self.results.multibody, strides)

    @cached_property
    def twin(self) -> TwinAgreement:
        """Twin against penalty model."""
        return compare_twin(self.results.twin, self.strides("twin", "multibody"))

    @cached_property
    def measured(self) -> MeasurementAgreement:
        """Measurements against twin and penalty model."""
        skipped, strides = self.parameters.settings.skipped_steps, self.strides("twin", "multibody")
        return compare_measurement(self.results.imu, self.results.twin.walk, strides["twin"], strides["multibody"],
                                   self.results.multibody.walk, skipped)  # fmt: skip

    @cached_property
    def ingest(self) -> IngestScore | None:
        """The ingest against the synthetic truth; None for other measurements."""
        skipped, gravity = self.parameters.settings.skipped_steps, self.parameters.slope.gravity
        quick = quickness(self.parameters.biped, gravity)
        return score_ingest(self.results.campaign, self.results.imu, skipped, gravity, quick)


def known(read: Callable[[], T]) -> T | None:
    """What is read, or None where there is no evidence."""
    try:
        return read()
    except NoEvidence:
        return None
