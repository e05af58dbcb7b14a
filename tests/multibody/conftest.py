"""The planar model in Exudyn as the tests change it, and a walk of it that others look at."""

import dataclasses

import pytest

from stages.multibody.parameters import Parameters, Settings
from stages.multibody.walking.cycle import CENTRAL, SectionWalker
from stages.multibody.walking.walk import build, simulate
from tests.changed import changed
from tests.planar_start import biped, contact, rough, slope, start

__all__ = ["biped", "contact", "rough", "slope", "start"]  # fixtures


@dataclasses.dataclass(frozen=True)
class Scene(Parameters):
    """A model that can be changed, built and walked."""

    def but(self, **changes):
        """The same with other values, each of the part that has a field of this name."""
        return changed(self, **changes)

    def build(self, lanes=None, **how):
        """Its assembly."""
        return build(self.biped, self.slope, self.contact, self.settings, lanes, **how)

    def walker(self, state, difference=CENTRAL):
        """Its step map on the section, around a mid-stance."""
        return SectionWalker(self.biped, self.slope, self.contact, state, self.settings, difference)

    def walk(self, state, **how):
        """Its walk from a state."""
        return simulate(self.biped, self.slope, self.contact, state, self.settings, **how)


@pytest.fixture(scope="session")
def scene(biped, slope, contact):
    settings = Settings(1e-9, "tree", 2, 2000.0, 5e-4, "trapezoidal", 2e-4, 1e-5, 0.02, 3.0)
    return Scene(biped, slope, contact, settings)


@pytest.fixture(scope="session")
def two_steps(scene, start):
    return scene.walk(start)
