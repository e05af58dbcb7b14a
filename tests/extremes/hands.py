"""What the watchdog's test lets its processes do; a module of its own, for they import it."""

import os
import time

from stages.extremes.parameters import RIGHT
from stages.extremes.result import Finding


def behave(common: float, point: str) -> Finding:
    """Answer, die, or never answer."""
    if point == "die":
        os._exit(3)
    if point == "hang":
        time.sleep(1e6)
    return Finding(RIGHT, common, reason=point)
