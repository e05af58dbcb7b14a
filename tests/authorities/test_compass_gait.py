"""The compass gait: hip 10 kg, legs of 5 kg at half their length, point feet (mu = 2, beta = 1).

The model and its cascade of period doublings over the slope: Goswami, Thuilot, Espiau, INRIA report 2996 (1996), and
Thuilot, Goswami, Espiau, Bifurcation and chaos in a simple passive bipedal gait (1997). Both were found, with their
beginnings only: neither says there at which slope the gait doubles, so the number below is this walker's own, held to
its digits. It does not depend on mass, leg length and gravity, and is where a walk forward begins to alternate.
"""

from __future__ import annotations

import numpy as np
import pytest

from stages.analytic.gait.continuation import PERIOD_DOUBLING, continue_gait
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import poincare_map
from stages.biped.design import Biped
from stages.ground.slope import Slope

DOUBLES_AT = 4.39090


def compass(scale: float = 1.0, slope_deg: float = 3.0) -> DesignPoint:
    """The compass gait with masses and lengths times `scale`."""
    biped = Biped("rigid", 10.0 * scale, 5.0 * scale, scale, 0.0, 0.5 * scale, 1.0, 0.0, 0.0)
    return DesignPoint(biped, Slope(slope_deg=slope_deg, gravity=9.81 / scale))


@pytest.mark.parametrize("scale", [1.0, 0.3])
def test_the_first_doubling(scale):
    design = compass(scale)
    _, point = find_gait(design.biped, design.slope, 1e-12)
    branch = continue_gait(design, "ground.slope_deg", (2.9, 4.6), point.z, 1e-12)
    doublings = [point.value for kind, point in branch.special if kind == PERIOD_DOUBLING]
    assert doublings == pytest.approx([DOUBLES_AT], abs=1e-5)


@pytest.mark.parametrize(("slope_deg", "alternates"), [(DOUBLES_AT - 0.05, False), (DOUBLES_AT + 0.05, True)])
def test_a_walk_alternates_beyond_it(slope_deg, alternates):
    design = compass(slope_deg=slope_deg)
    walker, point = find_gait(design.biped, design.slope, 1e-10)
    z = point.z * 1.001
    for _ in range(600):
        before, z = z, poincare_map(walker, z, 1e-10).z
    assert (np.abs(z - before).max() > 1e-3) == alternates
