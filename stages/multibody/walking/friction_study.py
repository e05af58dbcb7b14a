"""How the settled gait answers to the transition velocities of the friction law (section 3.4 of the paper)."""

from __future__ import annotations

import dataclasses

from stages.biped.design import Biped
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.assembly.state import PlanarState
from stages.multibody.parameters import Settings
from stages.multibody.result import FrictionVariation
from stages.multibody.walking.cycle import settled_cycle
from stages.multibody.walking.walk import build, sample, simulate

#: Changes of each transition velocity: what the paper may mean by small to moderate.
FACTORS = (0.5, 2.0)
VELOCITIES = ("stiction_velocity", "friction_velocity")
#: A period to 1e-5 is enough here, and this tolerance gives it.
TOLERANCE = 1e-7


def vary_friction(
    biped: Biped, slope: Slope, contact: ContactLaw, state: PlanarState, settings: Settings
) -> tuple[FrictionVariation, ...]:
    """Walks with each transition velocity changed alone by `FACTORS`; changes that break their order are left out."""
    settings = dataclasses.replace(settings, tolerance=max(settings.tolerance, TOLERANCE))
    found = []
    for name in VELOCITIES:
        for factor in FACTORS:
            changed = dataclasses.replace(contact, **{name: factor * getattr(contact, name)})
            if any(True for _ in changed.broken_rules()):
                continue
            machine = build(biped, slope, changed, settings, signals=())  # the motion tells period and length
            walked = simulate(biped, slope, changed, state, settings, assembly=machine)
            walk = sample(walked.trajectory, slope, biped.foot_radius, settings.sampling_rate_hz)
            cycle = settled_cycle(walked, walk, biped.foot_radius)
            found.append(FrictionVariation(name, factor, cycle.period_s, cycle.step_length_m))
    return tuple(found)
