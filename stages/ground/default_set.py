"""Adams' default contact set, from which the paper starts."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

from stages.biped.quantity import Bound, parameter
from stages.ground.contact_law import ContactLaw


@dataclass(frozen=True)
class DefaultSet:
    """The numbers of the default contact set; laws and friction coefficients are those of ground.yaml."""

    FILE: ClassVar[str] = "contact_study"

    default_stiffness: float = parameter("N/mm^e", "stiffness of the starting set", symbol="k_c", bound=Bound(above=0))
    default_exponent: float = parameter("1", "force exponent of the starting set", symbol="e", bound=Bound(minimum=1))
    default_damping: float = parameter(
        "N s/m", "largest damping of the starting set", symbol="c_max", bound=Bound(above=0)
    )
    default_depth: float = parameter(
        "m", "depth of complete damping of the starting set", symbol="d", bound=Bound(above=0)
    )
    default_stiction_velocity: float = parameter(
        "m/s", "stiction velocity of the starting set", symbol="v_s", bound=Bound(above=0)
    )
    default_friction_velocity: float = parameter(
        "m/s", "friction velocity of the starting set", symbol="v_d", bound=Bound(above=0)
    )

    def law(self, contact: ContactLaw) -> ContactLaw:
        """The default set with the laws and the friction coefficients of `contact`."""
        return dataclasses.replace(
            contact,
            contact_stiffness=self.default_stiffness,
            contact_exponent=self.default_exponent,
            contact_damping=self.default_damping,
            damping_depth=self.default_depth,
            stiction_velocity=self.default_stiction_velocity,
            friction_velocity=self.default_friction_velocity,
        )
