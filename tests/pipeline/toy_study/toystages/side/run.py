import random
import time
from dataclasses import dataclass
from pathlib import Path

from toystages.side.result import Result


@dataclass(frozen=True)
class Inputs:
    table: Path | None = None


def run(parameters, inputs, progress=lambda fraction, what: None):
    time.sleep(parameters.settings.wait)
    number = random.Random(parameters.settings.seed).randrange(1000)
    if inputs.table is not None:
        number = int(inputs.table.read_text())
    return Result(number, {"side.bin": bytes([number % 256])})
