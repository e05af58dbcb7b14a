"""A stage run once more in this process, beside the artefact it made: nothing of it is stored."""

from __future__ import annotations

from typing import Any

from pipeline.cache import artefact
from pipeline.errors import ArtefactError
from pipeline.stage_modules import result_class, stage_module
from pipeline.study import Study, shown


class Direct:
    """One stage of a study: its result as it lies there, the key it was made by, and other runs of it."""

    def __init__(self, study: Study, stage: str) -> None:
        self.study, self.stage = study, study.graph.stages[stage]
        content = self._content(self.stage.artefact)
        self.key = artefact.provenance(content, self.stage.artefact)["key"]
        self.result = self._decoded(self.stage.artefact)

    def run(self, parameters: Any) -> Any:
        """The stage's result with these parameters, from the inputs as they lie there. Raises what the stage raises."""
        inputs = {path.rsplit("/", 1)[-1].removesuffix(".h5"): self._decoded(path) for path in self.stage.inputs}
        return stage_module(self.study.package, self.stage.name, "run").run(parameters, inputs)

    def _decoded(self, path: str) -> Any:
        name = path.rsplit("/", 1)[-1].removesuffix(".h5")
        return artefact.decode(self._content(path), result_class(self.study.package, name), path)

    def _content(self, path: str) -> bytes:
        place = self.study.store.place(path)
        try:
            return place.read_bytes()
        except OSError as error:
            raise ArtefactError(f"{shown(place)}: cannot be read: {error.strerror}") from None
