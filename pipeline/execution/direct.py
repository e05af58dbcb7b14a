"""A stage run once more in this process, beside the artefact it made: nothing of it is stored."""

from __future__ import annotations

from typing import Any

from pipeline.cache import artefact, durable, regular
from pipeline.execution.inputs import given
from pipeline.stage_modules import result_class, stage_module
from pipeline.study import Study, shown


class Direct:
    """One stage of a study: its result as it lies there, the key it was made by, and other runs of it."""

    def __init__(self, study: Study, stage: str) -> None:
        self.study, self.stage = study, study.graph.stages[stage]
        content = self._content(self.stage.artefact)
        self.key = artefact.provenance(content, self.stage.artefact)["key"]
        self.result = artefact.decode(content, result_class(study.package, stage), self.stage.artefact)

    def run(self, parameters: Any) -> Any:
        """The stage's result with these parameters, from the inputs as they lie there. Raises what the stage raises."""
        package = self.study.package
        files = {path: (str(self.study.store.place(path)), durable.digest(self._content(path)))
                 for path in self.stage.inputs}  # fmt: skip
        inputs, _ = given(package, self.stage, parameters, self.study.named_files(parameters), files)
        return stage_module(package, self.stage.name, "run").run(parameters, inputs)

    def _content(self, path: str) -> bytes:
        place = self.study.store.place(path)
        return regular.content(place, shown(place))
