"""The ramp under a twin that walks on the plane: blocks for its steps, and as long as they need."""

from __future__ import annotations

from dataclasses import replace

from stages.twin.parameters import Settings
from stages.twin.ramp import Ramp, lay_blocks

#: A ramp under a walk on the plane is no more times as long as its blocks need: a small robot's would be lost on it.
SPARE = 1.25


def laid(settings: Settings, step_length: float) -> Ramp:
    """The ramp of the scene; of a walk on the plane one that fits steps of this length [m], whatever they are.

    Raises BlocksDoNotFit where the scene is the ramp.
    """
    if settings.scene != "plane":
        return lay_blocks(settings, step_length)
    step = settings.expected_step or step_length
    block = min(settings.block_length, 0.5 * step)
    least = (settings.block_sets - 1) * step + block
    length = min(max(settings.ramp_length, least), SPARE * least)
    return lay_blocks(replace(settings, block_length=block, ramp_length=length), step_length)
