"""What the run asks of a worker process."""

from __future__ import annotations

import base64
import json
import pickle
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.cache.provenance import attributes

if TYPE_CHECKING:
    from pipeline.cache.fingerprint import Ingredients
    from pipeline.study import Study


@dataclass(frozen=True)
class Order:
    """What the parent asks for: `inputs` are (path in the study, file, its SHA-256); `code` is file -> meaning."""

    stage: str
    package: str
    code_root: str
    folder: str
    artefact: str
    outs: list[str]
    inputs: list[tuple[str, str, str]]
    code: dict[str, str]
    parameters: str
    provenance: dict[str, str]

    def line(self) -> bytes:
        """The order as it is sent."""
        return json.dumps(asdict(self)).encode() + b"\n"


def pickled(parameters: Any) -> str:
    """Parameters as text for an order."""
    return base64.b64encode(pickle.dumps(parameters)).decode()


def order_of(study: Study, values: Any, parts: Ingredients, folder: Path, inputs: list[tuple[str, str, str]]) -> Order:
    """The order to compute the stage of `parts` with the parameters `values` into `folder`.

    `inputs` are the results it reads; the files that parameters name are added.
    """
    about = attributes(parts, study.requests)
    stage = study.graph.stages[parts["stage"]]
    named = [(key, str(path), sha256) for key, (path, sha256) in study.named_files(values).items()]
    return Order(
        stage=stage.name,
        package=study.package,
        code_root=str(study.code_root),
        folder=str(folder),
        artefact=stage.artefact,
        outs=list(stage.outs),
        inputs=inputs + named,
        code=parts["code"],
        parameters=pickled(values),
        provenance=about,
    )
