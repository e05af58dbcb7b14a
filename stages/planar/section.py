"""The section of the step map: mid-stance, where the stance leg is normal to the ground.

There the state has ten free numbers: the hip's x does not matter, the stance angle is zero, and legs are named by role
so that one step maps the section onto itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from stages.biped.accuracy.scales import scales_of
from stages.biped.design import Biped
from stages.ground.slope import Slope
from stages.planar.run import PlanarState, Recorded, Run

#: Units of the section's numbers, and by unit the scale in which residuals and steps of finite differences are, in
#: scales of the design.
UNITS = ("m", "rad", "m", "m", "m/s", "m/s", "rad/s", "rad/s", "m/s", "m/s")
SHARES = {"m": 0.03, "rad": 0.1, "m/s": 0.05, "rad/s": 0.2}


class NoLimitCycle(Exception):
    """The model does not walk, or the iteration finds no fixed point; the message says which."""


def section_scales(biped: Biped, slope: Slope, units: Sequence[str] = UNITS) -> np.ndarray:
    """These scales for numbers in n units, (n,) in SI units."""
    own = scales_of(biped, slope.gravity)
    return np.array([SHARES[unit] * own.size(unit) for unit in units])


@dataclass(frozen=True)
class SectionStep:
    """A walk from section to section: where it ends, as `section_numbers` (10,) and as a state, how long [s] and wide
    [m] it was, the solver's steps, and over how many steps of the walker."""

    numbers: np.ndarray
    state: PlanarState
    duration: float
    length: float
    solver_steps: int
    steps: int

    @property
    def period(self) -> float:
        """Duration of a step [s], the mean of those walked."""
        return self.duration / self.steps

    @property
    def step_length(self) -> float:
        """Length of a step [m], the mean of those walked."""
        return self.length / self.steps


def section_numbers(state: PlanarState) -> np.ndarray:
    """Hip y; swing angle; lengths of stance and swing leg; hip velocity x, y; rates of angles and lengths: (10,).

    Leg 0 is the stance leg.
    """
    _, swing = state.leg_angle
    numbers = (state.hip_position[1], swing, *state.leg_length, *state.hip_velocity)
    return np.array([*numbers, *state.leg_rate, *state.leg_length_rate])


def section_state(numbers: np.ndarray, like: PlanarState) -> PlanarState:
    """The state at x = 0 with these numbers; which feet are in play is taken from `like`."""
    y, swing, stance_length, swing_length, across, upward, *rates = numbers.tolist()
    return PlanarState(
        hip_position=(0.0, y),
        hip_velocity=(across, upward),
        leg_angle=(0.0, swing),
        leg_rate=(rates[0], rates[1]),
        leg_length=(stance_length, swing_length),
        leg_length_rate=(rates[2], rates[3]),
        in_play=like.in_play,
    )


def require_turns(angles: Sequence[float] | np.ndarray, strikes: int, stance: int) -> None:
    """Legs strike in turn: after so many strikes from the mid-stance with these angles (2,) that leg stands.

    Of legs that differ, half of a stride would be a cycle otherwise. Raises NoLimitCycle.
    """
    if stance != (int(np.argmin(np.abs(angles))) + strikes) % 2:
        raise NoLimitCycle("a foot strikes twice before the other does")


def upright_at(run: Recorded, angles: Sequence[int]) -> tuple[int, float]:
    """The last row before a leg comes upright, and the moment [s] in which it does: the sum of its `angles` among the
    coordinates falls through zero. Raises NoLimitCycle if it does not."""
    behind = np.flatnonzero(run.position[:, angles].sum(axis=1) > 0.0)
    if not len(behind) or behind[-1] + 1 == len(run.time):
        raise NoLimitCycle("the step does not end in mid-stance")
    before = int(behind[-1])  # the solver may take a step beyond the end
    at, (early, late) = run.after(before), run.time[before : before + 2].tolist()

    def leaning(time: float) -> float:
        return float(at(time)[0][..., angles].sum())

    if leaning(late) < 0.0:  # else it is upright there, but for round-off
        late = float(brentq(leaning, early, late, xtol=1e-15, rtol=8.9e-16))
    return before, late


def mid_stance_after(run: Run) -> SectionStep:
    """The end of a run, brought to the moment in which the new stance leg is upright, with the legs named by role.

    Raises NoLimitCycle if the run failed or does not end there.
    """
    if not run.completed:
        raise NoLimitCycle(run.message or run.outcome)
    trajectory = run.trajectory
    stance = int(np.argmin(np.abs(trajectory.position[-1, 2:4])))
    require_turns(trajectory.position[0, 2:4], run.heel_strikes, stance)
    _, moment = upright_at(trajectory, [2 + stance])
    state = trajectory.state_at(moment)
    length = state.hip_position[0] - float(trajectory.position[0, 0])
    if stance == 1:
        pairs = ("leg_angle", "leg_rate", "leg_length", "leg_length_rate", "in_play")
        state = replace(state, **{name: getattr(state, name)[::-1] for name in pairs})
    return SectionStep(section_numbers(state), state, moment, length, run.solver_steps, run.heel_strikes)
