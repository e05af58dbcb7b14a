import importlib
import os
import signal
import sys
import time

import numpy as np

from toystages.body.motion import distance
from toystages.fall.errors import NoFall
from toystages.fall.result import Result, Sample


def run(parameters, inputs=None, progress=lambda fraction, what: None):
    assert inputs is None
    settings = parameters.settings
    print("stages print nothing, but libraries do", flush=True)
    behaviour = settings.behaviour
    if behaviour == "raise":
        raise ZeroDivisionError("a pendulum\nwithout length")
    if behaviour == "answer":
        raise NoFall("nothing falls upwards")
    if behaviour == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if behaviour == "exit":
        sys.exit("enough")
    if behaviour == "hidden":
        importlib.import_module("toystages.side" + ".result")
    if behaviour == "disk":
        raise OSError(28, "No space left on device")
    files = {"secret.txt": b"x"} if behaviour == "extra" else {}
    if behaviour == "sleep":
        for _ in range(600):
            progress(0.5, "sleeping")
            time.sleep(0.1)
    t = np.linspace(0, 1, settings.steps)
    sample = Sample(t, distance(parameters.gravity.gravity, t))
    return Result(sample, settings.height, {part.name: part.mass for part in settings.parts}, files)
