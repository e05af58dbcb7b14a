import random
import time

from toystages.side.result import Result


def run(parameters, inputs, progress=lambda fraction, what: None):
    time.sleep(parameters.settings.wait)
    number = random.Random(parameters.settings.seed).randrange(1000)
    if "table" in inputs:
        number = int(inputs["table"].read_text())
    return Result(number, {"side.bin": bytes([number % 256])})
