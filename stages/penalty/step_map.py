"""The penalty walker's step from mid-stance to mid-stance, with its exact derivative, and its gait.

How the gait answers to parameters of the design, the slope and the ground has exact derivatives too. A gait
P(z, p) = z moves by dz = (1 - dP/dz)^-1 dP/dp; its period and step length move with z and with p. One step carries them
all as variations. Multipliers are had as those of the constraint model are, see
`stages.analytic.derivatives.multipliers`: the matrix is exact, and so is the tangent along which it is differenced.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from stages.analytic.derivatives.multipliers import along_the_gait, eigensystem
from stages.biped.accuracy.scales import scales_of
from stages.biped.design import Biped
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.penalty.model.changes import Changes, changes_of, owner
from stages.penalty.model.walker import ANGLE, SIZE, UNITS, Directions, X
from stages.penalty.walk import Ongoing, Settings, begin, numbers_of
from stages.planar.run import COMPLETED, LimitCycle, PlanarState
from stages.planar.section import (
    NoLimitCycle,
    SectionStep,
    require_turns,
    section_numbers,
    section_scales,
    section_state,
)

#: Places in the state of the section's numbers: with leg 0 standing, and with leg 1.
PLACES = np.array([[1, 3, 4, 5, 6, 7, 8, 9, 10, 11], [1, 2, 5, 4, 6, 7, 9, 8, 11, 10]])
#: The section's numbers that rigid legs do not have: lengths and their rates.
LENGTHS = [2, 3, 8, 9]
#: A walk that ends sooner, in pendulum times, is no step: legs that stand side by side map onto themselves at once.
SHORTEST = 0.5


def section_columns() -> np.ndarray:
    """Variations (10, 12) of the state by the section's numbers."""
    columns = np.zeros((10, SIZE))
    columns[np.arange(10), PLACES[0]] = 1.0
    return columns


class PenaltyStepper:
    """Takes steps from mid-stance to mid-stance, and counts them; `start` shows which feet are in play there.

    A cycle is one step, or two where the legs differ: leg 0 stands at its start and its end.
    """

    def __init__(
        self, biped: Biped, slope: Slope, contact: ContactLaw, start: PlanarState, settings: Settings
    ) -> None:
        self.start, self.settings = start, settings
        self.p, self.own = numbers_of(biped, slope, contact), scales_of(biped, slope.gravity)
        self.units, self.scales = np.array([self.own.size(unit) for unit in UNITS]), section_scales(biped, slope)
        self.rigid = biped.legs == "rigid"
        self.steps_walked, self.steps_a_cycle = 0, biped.steps_a_cycle

    @property
    def tolerance(self) -> float:
        """Tolerance of the integration."""
        return self.settings.tolerance

    def walk(self, start: PlanarState, steps: int) -> SectionStep:
        """Walk from a mid-stance to the one after `steps` steps. Raises NoLimitCycle."""
        return self._ended(self._walked(start, steps), start)

    def step(self, numbers: np.ndarray) -> SectionStep:
        """One cycle from section numbers (10,). Raises NoLimitCycle."""
        return self.walk(section_state(numbers, self.start), self.steps_a_cycle)

    def derivative(self, numbers: np.ndarray, after: SectionStep | None = None) -> np.ndarray:
        """Exact derivative (10, 10) of the cycle from section numbers (10,): by variations that walk along.

        Columns and rows of what rigid legs do not have are zero. Raises NoLimitCycle.
        """
        walk = self._walked(section_state(numbers, self.start), self.steps_a_cycle, section_columns())
        return self._on_section(walk, walk.y[SIZE:].reshape(-1, SIZE))

    def step_tangents(self, numbers: np.ndarray, changes: Changes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Derivatives of one cycle from section numbers (10,): of these numbers (10, c), its duration [s] and its
        length [m] (c,). The first ten of c are by the numbers at its start, the others by whole shares of `changes`.

        Raises NoLimitCycle.
        """
        start = section_state(numbers, self.start)
        columns = np.concatenate([section_columns(), changes.at_start])
        walk = self._walked(start, self.steps_a_cycle, columns, changes.directions(len(columns)))
        assert walk.directions is not None
        moved = walk.y[SIZE:].reshape(-1, SIZE)
        delays, ahead = walk.directions.delays * self.own.time, moved[:, X] * self.own.length
        for row in (delays, ahead):
            row[:10] /= self.units[PLACES[0]]
            if self.rigid:
                row[LENGTHS] = 0.0  # a length that a parameter changes is in its own column, from the start
        return self._on_section(walk, moved), delays, ahead

    def _walked(
        self, start: PlanarState, steps: int, columns: np.ndarray | None = None, directions: Directions | None = None
    ) -> Ongoing:
        self.steps_walked += steps
        walk = begin(self.p, self.own, start, self.settings, steps)
        if columns is not None:
            walk.y, walk.directions = np.concatenate([walk.y, columns.ravel()]), directions
        walk.go_on()
        if walk.outcome != COMPLETED:
            raise NoLimitCycle(walk.message or walk.outcome)
        return walk

    def _on_section(self, walk: Ongoing, columns: np.ndarray) -> np.ndarray:
        """Changes (10, n) of the section's numbers at the end of a walk, from variations (n, 12) of which the first ten
        are by these numbers; those that rigid legs do not have are zero.
        """
        found: np.ndarray = columns[:, PLACES[self._standing(walk)]].T * self.units[PLACES[0]][:, None]
        found[:, :10] /= self.units[PLACES[0]]
        if self.rigid:
            found[LENGTHS, :10], found[:, LENGTHS] = 0.0, 0.0
        return found

    def _ended(self, walk: Ongoing, start: PlanarState) -> SectionStep:
        if walk.time < SHORTEST * self.own.time:
            raise NoLimitCycle(f"a foot strikes again after {walk.time:.1g} s: no leg swings")
        y, stance = walk.y[:SIZE] * self.units, self._standing(walk)
        require_turns(start.leg_angle, walk.heel_strikes, stance)
        state = state_of(y, walk.in_play, stance)
        length = float(y[X]) - start.hip_position[0]
        return SectionStep(section_numbers(state), state, walk.time, length, walk.evaluations, walk.heel_strikes)

    def _standing(self, walk: Ongoing) -> int:
        return int(np.argmin(np.abs(walk.y[ANGLE : ANGLE + 2])))


def state_of(y: np.ndarray, in_play: tuple[bool, bool], first: int) -> PlanarState:
    """A state (12,) under its names, the legs named so that leg `first` comes first."""

    def legs(place: int) -> tuple[float, float]:
        return float(y[place + first]), float(y[place + 1 - first])

    return PlanarState(
        hip_position=(float(y[0]), float(y[1])),
        hip_velocity=(float(y[6]), float(y[7])),
        leg_angle=legs(2),
        leg_rate=legs(8),
        leg_length=legs(4),
        leg_length_rate=legs(10),
        in_play=(in_play[first], in_play[1 - first]),
    )


#: A design on its slope and ground.
Model = tuple[Biped, Slope, ContactLaw]
#: Tolerance of the steps, and of those whose derivatives are subtracted.
TOLERANCE, OF_MATRICES = 1e-12, 1e-13
#: Multipliers whose derivatives are requested: the others die out within a step.
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
    numbers, *measures = stepper.step_tangents(gait.section_state, changes)
    matrix = numbers[:, :10]
    moved = np.linalg.solve(np.eye(10) - matrix, numbers[:, 10:])
    period, length = ((row[10:] + row[:10] @ moved) / stepper.steps_a_cycle for row in measures)
    return Response(changes, gait, matrix, moved, period, length)


def of_multipliers(
    biped: Biped, slope: Slope, contact: ContactLaw, start: PlanarState, found: Response
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Elasticities (n, 2) of the magnitudes of a gait's two leading multipliers by the parameters of `found`, what
    extrapolation leaves of them (n,), and sentences on parameters beside which the walker falls: there both are NaN.
    """
    values, left, right = eigensystem(found.matrix)
    values, left, right = values[:LEADING], left[:LEADING], right[:, :LEADING]
    standing = section_state(found.gait.section_state, start)
    names, refused = found.changes.names, []
    shares, errors = np.full((len(names), LEADING), np.nan), np.full(len(names), np.nan)
    for row, name in enumerate(names):
        of_row = partial(matrix_slope, (biped, slope, contact), standing, found, row)
        try:
            moved, left_open = along_the_gait(of_row, left, right)
            shares[row], errors[row] = np.real(moved / values), left_open / np.abs(values).min()
        except NoLimitCycle as reason:
            refused.append(f"by {name} the multipliers have no derivative: beside the design {reason}")
    return shares, errors, refused


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
    new = replace(section, **{key: getattr(section, key) + by})
    if section is biped:
        return new, slope, contact
    return (biped, new, contact) if section is slope else (biped, slope, new)
