"""The multibody model's own gait, its derivative by finite differences."""

from __future__ import annotations

import numpy as np

from stages.biped.design import Biped
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import static_penetration
from stages.ground.slope import Slope
from stages.multibody.parameters import Settings
from stages.multibody.walking.walk import build, simulate
from stages.planar.cycle import LimitCycle
from stages.planar.limit_cycle import by_differences, gait_near
from stages.planar.section import SectionStep, mid_stance_after, section_scales, section_state
from stages.planar.state import PlanarState

DIFFERENCE = 1e-4
#: Numbers that lift the standing foot, hip y and its leg's length, and the share of its depth that they may change by.
LIFTING, SHARE_OF_DEPTH = [0, 2], 0.4


def limit_cycle(
    biped: Biped,
    slope: Slope,
    contact: ContactLaw,
    state: PlanarState,
    settings: Settings,
    difference: float = DIFFERENCE,
    *,
    central: bool = True,
) -> LimitCycle:
    """The gait near `state`, see `gait_near`; `difference` is the step of the finite differences, in `section_scales`.

    Raises NoLimitCycle. For the defaults the integration's own tolerance should be 1e-10 or less.
    """
    walker = SectionWalker(biped, slope, contact, state, settings, difference)
    return gait_near(walker, state, central=central)


class SectionWalker:
    """A built model that takes steps from mid-stance to mid-stance, and counts them.

    `difference` is the step of its finite differences, in `section_scales`; none lifts the standing foot. A cycle is
    one step, or two where the legs differ: leg 0 stands at its start and its end.
    """

    def __init__(
        self, biped: Biped, slope: Slope, contact: ContactLaw, state: PlanarState, settings: Settings, difference: float
    ) -> None:
        self.model = biped, slope, contact
        self.start, self.settings = state, settings
        sunk = static_penetration(contact, biped.weighed_mass * slope.gravity)
        self.scales = section_scales(biped, slope)
        self.differences = difference * self.scales
        self.differences[LIFTING] = np.minimum(self.differences[LIFTING], SHARE_OF_DEPTH * sunk)
        self.machine = build(biped, slope, contact, settings, signals=())
        self.steps_a_cycle = 1 if biped.alike else 2
        self.steps_walked = 0

    @property
    def tolerance(self) -> float:
        """Tolerance of the solver."""
        return self.settings.tolerance

    def walk(self, start: PlanarState, steps: int) -> SectionStep:
        """Walk from a mid-stance to the one after `steps` steps. Raises NoLimitCycle."""
        self.steps_walked += steps
        return mid_stance_after(
            simulate(*self.model, start, self.settings, steps=steps, assembly=self.machine)
        )

    def step(self, numbers: np.ndarray) -> SectionStep:
        """One cycle from section numbers (10,). Raises NoLimitCycle."""
        return self.walk(section_state(numbers, self.start), self.steps_a_cycle)

    def derivative(self, numbers: np.ndarray, after: SectionStep | None = None) -> np.ndarray:
        """Derivative (10, 10) of the cycle, by central differences, or by forward ones if the step itself is known."""
        return by_differences(self.step, numbers, self.differences, after)
