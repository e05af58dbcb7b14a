from dataclasses import dataclass
from pathlib import Path

from toystages.bounce.result import Result as Bounce
from toystages.picture.result import Result

CLAIM = """headlines: [it is a toy]
claims:
- {id: force, section: "1", words: one newton, implies: 1 N, measured: %.4g N, verdict: does not hold, condition: "",
   causes: [it is another toy], rests_on: [ground.gravity 9.81]}
tables:
- {title: Toys, columns: ["", toy], rows: [[weight, "2"]]}
"""


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
