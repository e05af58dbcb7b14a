"""How the penalty walker's gait answers to a parameter of the design, the slope or the ground.

A gait P(z, p) = z moves by dz = (1 - dP/dz)^-1 dP/dp, with the exact dP/dz that the variations give. dP/dp, and along
the gaits' tangent (dz, dp) period, step length and multipliers, are central differences of steps, extrapolated to none
(Richardson): the constraint model's derivatives by parameters are exact, these are not, and carry what the
extrapolation leaves.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.biped.design import Biped
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.penalty.settings import Settings
from stages.penalty.step_map import PenaltyStepper
from stages.planar.cycle import LimitCycle
from stages.planar.limit_cycle import floquet_multipliers
from stages.planar.section import section_state
from stages.planar.state import PlanarState

#: Share of a parameter by which it is changed, then half of that; tolerance of the steps.
SHARE, TOLERANCE = 2e-4, 1e-13


@dataclass(frozen=True)
class Response:
    """Elasticities: shares by which period, step length and the magnitudes of the two leading multipliers change for a
    share of a parameter, (4,), and what the extrapolation leaves of them, (4,).
    """

    name: str
    elasticities: np.ndarray
    errors: np.ndarray


def responses(
    biped: Biped, slope: Slope, contact: ContactLaw, start: PlanarState, gait: LimitCycle, names: Sequence[str]
) -> list[Response]:
    """Of a gait found from the mid-stance `start`, by parameters named as in their files: "biped.damping".

    Raises NoLimitCycle if a changed walker does not take the step, KeyError for a name that none of the three has.
    """
    sections = biped, slope, contact
    left = np.linalg.inv(np.eye(10) - gait.monodromy_matrix)

    def changed(name: str, share: float) -> PenaltyStepper:
        file, _, key = name.partition(".")
        owners = [section for section in sections if file == section.FILE and hasattr(section, key)]
        if not owners:
            raise KeyError(name)
        value = (1.0 + share) * getattr(owners[0], key)
        new: list[Any] = [dataclasses.replace(one, **{key: value}) if one is owners[0] else one for one in sections]
        return PenaltyStepper(new[0], new[1], new[2], section_state(gait.section_state, start), Settings(TOLERANCE))

    def answer(name: str) -> Response:
        moved = left @ extrapolated(lambda share: changed(name, share).step(gait.section_state).numbers)[0]

        def measures(share: float) -> np.ndarray:
            stepper, numbers = changed(name, share), gait.section_state + share * moved
            step, derivative = stepper.step(numbers), stepper.derivative(numbers)
            leading = np.hypot(*floquet_multipliers(derivative)[:2].T)
            return np.log([step.duration, step.length, *leading])

        return Response(name, *extrapolated(measures))

    return [answer(name) for name in names]


def extrapolated(function: Callable[[float], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Derivative of a function of a share at none of it, and what extrapolating it changes."""
    far, near = (0.5 * (function(share) - function(-share)) / share for share in (SHARE, 0.5 * SHARE))
    return (4.0 * near - far) / 3.0, np.abs(near - far) / 3.0
