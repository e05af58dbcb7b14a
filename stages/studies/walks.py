"""How far the compiled penalty walker is from Exudyn's model of the same machine, over walks and between cycles.

The two share the contact laws' text and the rule of the swinging foot, and nothing of the mechanics: equations derived
by Lagrange on one side, Exudyn's bodies, joints and integrator on the other. Both are walked at settings of the check's
own, whatever a study walks with, and each once more with others, which shows its own error.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.biped.accuracy.scales import scales_of
from stages.biped.design import Biped
from stages.biped.walk import StanceState
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.parameters import Settings as ExudynSettings
from stages.multibody.walking.cycle import SectionWalker
from stages.multibody.walking.walk import simulate as exudyn_walk
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings, simulate as compiled_walk
from stages.planar.limit_cycle import corrected, fixed_point
from stages.planar.run import PlanarState, Run, rolling_state
from stages.planar.section import SectionStep, section_numbers
from stages.studies.result import BUT, Distance

#: Tolerances of both models in a check, and so many times looser ones that show their own errors. Over one step both
#: walk so many times tighter where the first do not come near enough: either may step over a moment's touch.
COMPILED, EXUDYN = 1e-12, 1e-10
LOOSER = 10.0
#: Largest step of Exudyn's solver, in pendulum times.
LARGEST_STEP = 2.5e-3
#: Over one step the models are this close, in leg lengths; over more, and between cycles, so many times the larger own
#: error, which a difference of two runs may meet by chance: below this, a tenth of what one step may differ, it shows
#: nothing.
ONE_STEP, TIMES, NOISE = 3e-9, 3.0, 3e-10
#: Times at which paths are compared.
COMPARED = 2000


@dataclass(frozen=True)
class Machine:
    """A biped on its ground, walked by both engines; `tolerance` is Exudyn's in a check."""

    biped: Biped
    slope: Slope
    contact: ContactLaw
    tolerance: float = EXUDYN

    def exudyn_settings(self, tolerance: float) -> ExudynSettings:
        """How Exudyn integrates: to one tolerance in SI units for all coordinates, whatever the design's scales."""
        time = scales_of(self.biped, self.slope.gravity).time
        return ExudynSettings.of_one_step(tolerance, LARGEST_STEP * time)

    def compiled(self, state: PlanarState, tolerance: float, steps: int, duration: float | None) -> Run:
        """A walk of the compiled walker."""
        return compiled_walk(
            self.biped, self.slope, self.contact, state, Settings(tolerance), steps=steps,
            duration=duration, signals=(),
        )  # fmt: skip

    def exudyn(self, state: PlanarState, tolerance: float, steps: int, duration: float | None) -> Run:
        """A walk of Exudyn's model."""
        settings = self.exudyn_settings(tolerance)
        return exudyn_walk(self.biped, self.slope, self.contact, state, settings, steps=steps, duration=duration)


@dataclass(frozen=True)
class Upright:
    """Where walks on any ground begin: a biped at a mid-stance of the constraint model, pressed by a force [N]."""

    biped: Biped
    slope: Slope
    mid_stance: StanceState
    standing_force: float

    def start(self, law: ContactLaw) -> PlanarState:
        """The mid-stance on ground with this law: the standing foot at its static penetration."""
        return rolling_state(self.biped, law, self.mid_stance, self.standing_force)

    def walk(self, law: ContactLaw, solver: Settings, **until: Any) -> Run:
        """A walk of the compiled walker, see `stages.penalty.walk.simulate`."""
        return compiled_walk(self.biped, self.slope, law, self.start(law), solver, **until)

    def stepper(self, law: ContactLaw, solver: Settings) -> PenaltyStepper:
        """The compiled walker's step from mid-stance to mid-stance."""
        return PenaltyStepper(self.biped, self.slope, law, self.start(law), solver)

    def step_apart(self, what: str, law: ContactLaw, tolerance: float, duration: float) -> Distance:
        """Distance of the engines over one step of so long [s]; `tolerance` is Exudyn's."""
        machine = Machine(self.biped, self.slope, law, tolerance)
        return over_a_walk(what, machine, self.start(law), duration=duration)

    def cycle_apart(self, what: str, law: ContactLaw, tolerance: float) -> Distance:
        """Distance of the engines' cycles. Raises NoLimitCycle."""
        machine, start = Machine(self.biped, self.slope, law, tolerance), self.start(law)
        return between_cycles(what, machine, start, section_numbers(start))


def over_a_walk(
    what: str, machine: Machine, state: PlanarState, steps: int = 1, duration: float | None = None
) -> Distance:
    """Distance over a walk of so many steps, or of so long [s], from a state.

    Own errors are not needed over one step, and not measured.
    """
    ours = machine.compiled(state, COMPILED, steps, duration)
    other = machine.exudyn(state, machine.tolerance, steps, duration)
    distance, length = hip_distance(ours, other), machine.biped.leg_length
    if steps == 1:
        if distance > ONE_STEP * length:
            ours = machine.compiled(state, COMPILED / LOOSER, steps, duration)
            other = machine.exudyn(state, EXUDYN / LOOSER, steps, duration)
            distance = hip_distance(ours, other)
        return Distance(what, outcome_of(ours, other), distance, float("nan"), ONE_STEP * length)
    own = max(
        hip_distance(ours, machine.compiled(state, LOOSER * COMPILED, steps, duration)),
        hip_distance(other, machine.exudyn(state, LOOSER * machine.tolerance, steps, duration)),
    )
    return Distance(what, outcome_of(ours, other), distance, own, max(NOISE * length, TIMES * own))


def outcome_of(ours: Run, other: Run) -> str:
    """How both walks ended, or how each did."""
    if ours.outcome == other.outcome:
        return ours.outcome
    return f"{ours.outcome} compiled,{BUT}{other.outcome} in Exudyn"


def hip_distance(one: Run, other: Run) -> float:
    """Largest distance of two walks' hips [m] as long as both last."""
    time = np.linspace(0.0, min(float(one.trajectory.time[-1]), float(other.trajectory.time[-1])), COMPARED)
    first, second = (run.trajectory.at(time)[0][:, :2] for run in (one, other))
    return float(np.linalg.norm(first - second, axis=1).max())


def between_cycles(what: str, machine: Machine, state: PlanarState, numbers: np.ndarray) -> Distance:
    """Distance of the cycles of both models near section numbers (10,). Raises NoLimitCycle.

    In lengths: step length, period times speed, height of the hip and lengths of the legs at mid-stance. Two errors of
    Exudyn's may be alike by chance, and its own seem small: tighter ones decide.
    """
    parts = machine.biped, machine.slope, machine.contact, state
    stepper = PenaltyStepper(*parts, Settings(COMPILED))
    near = fixed_point(stepper, numbers).numbers
    derivative = stepper.derivative(near)
    ours = corrected(stepper, near, derivative).step
    looser = corrected(PenaltyStepper(*parts, Settings(LOOSER * COMPILED)), ours.numbers, derivative).step
    true = lengths_of(ours, ours)
    own = np.abs(lengths_of(looser, ours) - true).max()

    def exudyn(tolerance: float) -> np.ndarray:
        settings = machine.exudyn_settings(tolerance)
        return lengths_of(corrected(SectionWalker(*parts, settings, 1e-4), ours.numbers, derivative).step, ours)

    tolerance, before = machine.tolerance, exudyn(LOOSER * machine.tolerance)
    while True:
        other = exudyn(tolerance)
        error = float(max(own, np.abs(before - other).max()))
        found = Distance(what, "completed", float(np.abs(other - true).max()), error,
                         max(NOISE * machine.biped.leg_length, TIMES * error))  # fmt: skip
        if found.fine or tolerance < EXUDYN:
            return found
        tolerance, before = tolerance / LOOSER, other


def lengths_of(step: SectionStep, like: SectionStep) -> np.ndarray:
    """What is compared of a cycle [m], (5,), by its step; its period as the way at the speed of another."""
    way = step.duration * like.length / like.duration
    return np.array([step.length, way, step.numbers[0], *step.numbers[2:4]])
