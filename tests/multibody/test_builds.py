"""Exudyn's fast build, which has no range checks, walks as the checked one does."""

import json
import subprocess
import sys

import numpy as np

from stages.multibody.assembly.system import VERSION
from stages.multibody.parameters import Settings
from stages.multibody.walking.walk import simulate

#: Two steps with the contact set and the solver of `conftest`; an attribute of sys refuses the fast build.
WALK = """
import json, sys
sys.exudynFast = False
from stages.biped.design import Biped
from stages.biped.walk import StanceState
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.parameters import Settings
from stages.multibody.assembly.system import VERSION
from stages.planar.run import (rolling_state)
from stages.multibody.walking.walk import simulate
biped = Biped("compliant", 0.316, 0.335, 0.333, 0.083, 0.1, 2800.0, 58.35, 0.0)
contact = ContactLaw(1e5, 2.2, 1e4, 1e-4, 1.1, 1.0, 0.1, 1.0)
start = rolling_state(biped, contact, StanceState(0.0, 0.331, 0.27, 0.334, 0.71, 0.0, 1.8, 0.0), normal_force=9.4)
run = simulate(biped, Slope(2.0, 9.81), contact, start, Settings.of_one_step(1e-9, 5e-4), duration=0.9)
end = run.trajectory.at(run.trajectory.time[-1:])
print(json.dumps([VERSION, run.outcome, run.solver_steps, *end[0][0], *end[1][0]]))
"""


def test_the_fast_build_walks_as_the_checked_one(biped, slope, contact, start):
    answer = subprocess.run([sys.executable, "-c", WALK], capture_output=True, text=True, check=True)
    version, outcome, steps, *end = json.loads(answer.stdout)  # nothing but that: the build prints nothing of its own
    assert version.endswith("(checked build)") and "checked" not in VERSION
    run = simulate(biped, slope, contact, start, Settings.of_one_step(1e-9, 5e-4), duration=0.9)
    assert outcome == run.outcome == "completed"
    assert abs(steps - run.solver_steps) <= 5
    position, velocity = run.trajectory.at(run.trajectory.time[-1:])
    assert np.abs(np.subtract(end, [*position[0], *velocity[0]])).max() < 1e-8
