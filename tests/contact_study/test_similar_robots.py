"""A study knows no metre: similar robots have the same choices, and numbers that differ by their units alone."""


import numpy as np
import pytest

from stages.contact_study.one_step import Scene, constraint_model
from stages.contact_study.rigid_limit import Ruler, choose
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings
from stages.planar.run import rolling_state
from stages.planar.section import section_numbers
from tests.changed import changed
from tests.planar_start import rough
from tests.similar import EXPONENT, differences, factor, similar

__all__ = ["rough"]  # a fixture

#: Masses, lengths, times: gravity stays, or is a quarter.
ALIKE = pytest.mark.parametrize("scale", [(8.0, 4.0, 2.0), (1.0, 1.0, 2.0)], ids=["four times", "gravity a quarter"])
#: Units of the section's numbers.
SECTION = ("m", "rad", "m", "m", "m/s", "m/s", "rad/s", "rad/s", "m/s", "m/s")
#: What rounding of powers leaves, over what the ground makes of it.
ROUND_OFF = 1e-9


@pytest.fixture
def exact(small):
    """Ground of which a similar robot's is exact."""
    return changed(small, contact_exponent=EXPONENT, default_exponent=EXPONENT)


def searched(parameters, rough):
    """The search over a step among two sets, from a mid-stance: what it chooses and what it tries."""
    biped, slope, settings = parameters.biped, parameters.slope, parameters.settings
    coulomb = constraint_model(
        biped, slope, parameters.contact.coefficients, rough, 1e-10, settings.sampling_rate_hz)
    scene = Scene(biped, slope, Settings(1e-6), 1e-6, coulomb.walk, rough, coulomb.period, settings.impact_window)
    ruler, law = Ruler(scene, coulomb, settings), parameters.default_set.law(parameters.contact)
    return choose(ruler.over_a_step(law), settings, ruler.over_a_step, lambda found: found)


@ALIKE
def test_the_search_tries_and_chooses_the_same(exact, rough, scale):
    chosen, _, tried = searched(exact, rough)
    other, _, others = searched(similar(exact, scale), similar(rough, scale))
    assert np.isfinite(chosen.step_score) and chosen.law.damping_depth in exact.settings.searched_depth
    assert other.evaluations == chosen.evaluations and (others.evaluations == tried.evaluations).all()
    assert others.outcome == tried.outcome
    assert max(differences(chosen, other, scale).values()) < ROUND_OFF


@ALIKE
def test_steps_and_their_derivatives_are_alike(exact, rough, scale):
    """As many evaluations, and every entry by its unit."""
    ends = []
    for parameters, stance in ((exact, rough), (similar(exact, scale), similar(rough, scale))):
        start = rolling_state(parameters.biped, parameters.contact, stance, 9.4 * parameters.biped.total_mass
                              * parameters.slope.gravity / (exact.biped.total_mass * exact.slope.gravity))
        stepper = PenaltyStepper(parameters.biped, parameters.slope, parameters.contact, start, Settings(1e-8))
        numbers = section_numbers(start)
        ends.append((stepper.step(numbers), stepper.derivative(numbers)))
    (step, matrix), (other, grown) = ends
    units = np.array([factor(unit, scale) for unit in SECTION])
    assert other.solver_steps == step.solver_steps
    assert other.numbers == pytest.approx(step.numbers * units, rel=ROUND_OFF)
    assert other.duration == pytest.approx(step.duration * scale[2], rel=ROUND_OFF)
    assert grown / units[:, None] * units == pytest.approx(matrix, rel=1e-7, abs=1e-7 * np.abs(matrix).max())
