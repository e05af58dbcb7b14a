"""How the exported twin starts: on the constraint model's gait, on blocks laid for its steps."""

from __future__ import annotations

from stages.analytic.gait.gait_search import describe, find_gait
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.twin.exports.blocks import laid
from stages.twin.exports.exported import Exported
from stages.twin.exports.seen import shown_parts
from stages.twin.machine.machine import build
from stages.twin.parameters import Parameters
from stages.twin.walking.simulate import rolling_start

#: Of the gait; its step from mid-stance on is all that is taken.
TOLERANCE = 1e-9
SAMPLES_A_SECOND = 1000.0


def exported(parameters: Parameters) -> Exported:
    """The twin of these parameters as it starts in its stage. Raises NoGait, BlocksDoNotFit."""
    biped, slope, settings = parameters.biped, parameters.slope, parameters.settings
    walker, point = find_gait(biped, slope, TOLERANCE, None)
    walk, upright = walk_from_mid_stance(walker, point.z, 1, TOLERANCE, SAMPLES_A_SECOND)
    machine = build(biped, settings)
    start = rolling_start(machine, parameters.contact, upright, walk.standing_force)
    ramp = laid(settings, describe(walker, point).step_length_m)
    return Exported(machine, settings, slope, parameters.contact, start, ramp, shown_parts(settings, biped))
