"""What the run asks of a worker process."""

from __future__ import annotations

import base64
import json
import pickle
from dataclasses import asdict, dataclass
from typing import Any


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
