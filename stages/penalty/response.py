"""How the penalty walker's gait answers to parameters of the design, the slope and the ground: exact derivatives.

A gait P(z, p) = z moves by dz = (1 - dP/dz)^-1 dP/dp; its period and step length move with z and with p. One step
carries them all as variations. Multipliers are had as those of the constraint model are, see
`stages.analytic.derivatives.multipliers`: the matrix is exact, and so is the tangent along which it is differenced.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from stages.analytic.derivatives.multipliers import along_the_gait, eigensystem
from stages.biped.design import Biped
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.penalty.model.changes import Changes, changes_of, owner
from stages.penalty.settings import Settings
from stages.penalty.step_map import PenaltyStepper
from stages.planar.run import LimitCycle, PlanarState
from stages.planar.section import NoLimitCycle, section_state

#: A design on its slope and ground.
Model = tuple[Biped, Slope, ContactLaw]
#: Tolerance of the steps, and of those whose derivatives are subtracted.
TOLERANCE, OF_MATRICES = 1e-12, 1e-13
#: Multipliers whose derivatives are asked for: the others die out within a step.
LEADING = 2


@dataclass(frozen=True)
class Response:
    """A gait's derivatives for whole shares of n parameters.

    `section` (10, n) of the section's numbers, `period` (n,) [s], `length` (n,) of the step [m], means of a cycle's;
    `matrix` (10, 10), the derivative of the cycle.
    """

    changes: Changes
    gait: LimitCycle
    matrix: np.ndarray
    section: np.ndarray
    period: np.ndarray
    length: np.ndarray

    def elasticities(self) -> np.ndarray:
        """Shares by which period and step length change for a share of each parameter, (n, 2)."""
        return np.column_stack([self.period / self.gait.period_s, self.length / self.gait.step_length_m])


def responses(
    biped: Biped, slope: Slope, contact: ContactLaw, start: PlanarState, gait: LimitCycle, names: Sequence[str],
    tolerance: float = TOLERANCE,
) -> Response:  # fmt: skip
    """Of a gait found from the mid-stance `start`, by parameters named as in their files: "biped.damping".

    Raises KeyError for a name that is no number of the three, NoLimitCycle if the walker does not take the step.
    """
    changes = changes_of(biped, slope, contact, names)
    stepper = PenaltyStepper(biped, slope, contact, section_state(gait.section_state, start), Settings(tolerance))
    step = stepper.step_tangents(gait.section_state, changes)
    matrix = step.numbers[:, :10]
    moved = np.linalg.solve(np.eye(10) - matrix, step.numbers[:, 10:])
    period, length = ((row[10:] + row[:10] @ moved) / stepper.steps_a_cycle for row in (step.duration, step.length))
    return Response(changes, gait, matrix, moved, period, length)


@dataclass(frozen=True)
class OfMultipliers:
    """Elasticities (n, 2) of the magnitudes of the two leading multipliers, and what extrapolation leaves of them (n,).

    They are NaN by a parameter of which a changed walker falls; `refused` says so.
    """

    elasticities: np.ndarray
    errors: np.ndarray
    refused: tuple[str, ...]


def of_multipliers(
    biped: Biped, slope: Slope, contact: ContactLaw, start: PlanarState, found: Response
) -> OfMultipliers:
    """How a gait's multipliers answer to the parameters of `found`."""
    values, left, right = eigensystem(found.matrix)
    values, left, right = values[:LEADING], left[:LEADING], right[:, :LEADING]
    standing = section_state(found.gait.section_state, start)
    names, refused = found.changes.names, []
    shares, errors = np.full((len(names), LEADING), np.nan), np.full(len(names), np.nan)
    for row, name in enumerate(names):
        of_row = partial(matrix_slope, (biped, slope, contact), standing, found, row)
        try:
            moved, errors[row] = along_the_gait(of_row, left, right)
            shares[row] = np.real(moved / values)
        except NoLimitCycle as reason:
            refused.append(f"by {name} the multipliers have no derivative: beside the design {reason}")
    return OfMultipliers(shares, errors, tuple(refused))


def matrix_slope(model: Model, start: PlanarState, found: Response, row: int, share: float) -> np.ndarray:
    """Central difference (10, 10) of the exact derivative of the step over a share of a parameter along the gaits."""
    sides = []
    for by in (share, -share):
        parts = changed(*model, found.changes.names[row], by * float(found.changes.scales[row]))
        stepper = PenaltyStepper(*parts, start, Settings(OF_MATRICES))
        numbers = found.gait.section_state + by * found.section[:, row]
        sides.append(stepper.derivative(numbers))
    slope: np.ndarray = (sides[0] - sides[1]) / (2 * share)
    return slope


def changed(biped: Biped, slope: Slope, contact: ContactLaw, name: str, by: float) -> Model:
    """The three with one of their numbers changed by so much. Raises KeyError."""
    section: Any = owner(name, (biped, slope, contact))
    key = name.partition(".")[2]
    new = dataclasses.replace(section, **{key: getattr(section, key) + by})
    if section is biped:
        return new, slope, contact
    return (biped, new, contact) if section is slope else (biped, slope, new)
