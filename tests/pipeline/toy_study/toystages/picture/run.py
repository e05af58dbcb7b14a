from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from toystages.bounce.result import Result as Bounce
from toystages.picture.result import Result

CLAIM = "- {id: force, stated: 1 N, found: %.4g N, holds: false, why: it is another toy}\n"


@dataclass(frozen=True)
class Inputs:
    bounce: Bounce
    side: Path


def run(parameters, inputs, progress=lambda fraction, what: None):
    title = parameters.settings.title.encode()
    files = {"figures/one.svg": title, "claims.yaml": (CLAIM % inputs.bounce.force).encode()}
    if parameters.settings.extra:
        files["figures/two.svg"] = title + inputs.side.read_bytes()
    return Result(tuple(sorted(files)), files)
