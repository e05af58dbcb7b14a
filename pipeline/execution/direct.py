"""A stage's artefact as it lies in the results folder: its result, and the key that it was made by."""

from __future__ import annotations

from pipeline.cache import artefact, regular
from pipeline.stage_modules import result_class
from pipeline.study import Study, shown


class Direct:
    """The `result` and the `key` of one stage's artefact. Raises `StudyError` if there is none that can be read."""

    def __init__(self, study: Study, stage: str) -> None:
        path = study.graph.stages[stage].artefact
        place = study.store.place(path)
        content = regular.content(place, shown(place))
        self.key = artefact.provenance(content, path)["key"]
        self.result = artefact.decode(content, result_class(study.package, stage), path)
