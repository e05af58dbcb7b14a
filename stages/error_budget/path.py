"""The path from the constraint model to the penalty model, one effect at a time, over one step and between cycles."""

import dataclasses
from collections.abc import Callable, Collection

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.walk.recording import crossing_state, walk_on
from stages.analytic.walk.sampling import signals_at
from stages.biped.design import Biped
from stages.error_budget.parameters import Parameters
from stages.error_budget.result import (
    CONTACT,
    CREEP,
    IMPACT,
    Convergence,
    CycleBudget,
    Shares,
    StepBudget,
    split_of,
    telescoped,
)
from stages.ground.contact_law import ContactLaw, with_impact
from stages.ground.friction import static_penetration
from stages.ground.slope import Friction, Slope
from stages.penalty.walk import Settings, simulate
from stages.planar.limit_cycle import fixed_point
from stages.planar.run import Trajectory
from stages.planar.sampling import find_events
from stages.planar.section import NoLimitCycle, section_numbers, section_state
from stages.studies.walks import Machine, Upright


def switched(law: ContactLaw, on: Collection[str], share: float) -> ContactLaw:
    """The law with the effects in `on` as they are, and the others reduced to the part `share`.

    An effect that is off keeps about that part of its size, and so does what it does to the hip:

    - creep: a foot at rest slips below v_s; off, s v_s. The fall from static to dynamic friction over the slip speed up
      to v_d goes with it; off, v_d = 2 s v_s. Alone it moves the hip by less than 1e-5 mm.
    - an impact of finite stiffness: the landing foot sinks in and comes back, and a standing foot sinks in as the force
      on it grows. Stiffness and damping are one effect, not two, see `stages.ground.contact_law`.
    """
    if CREEP not in on:
        stiction = share * law.stiction_velocity
        law = dataclasses.replace(law, stiction_velocity=stiction, friction_velocity=2.0 * stiction)
    if IMPACT not in on:
        law = with_impact(law, share)
    return law


class ConstraintWalk:
    """A walk of the constraint model over two heel strikes from a mid-stance state, by default over three from that of
    the gait, whose period is given."""

    def __init__(self, walker: Walker, point: FixedPoint, tolerance: float, start: Vector | None = None) -> None:
        self.walker, self.point = walker, point
        self.start = crossing_state(walker, point.z, tolerance) if start is None else start
        self.segments = walk_on(walker, self.start, 2 if start is None else 1, tolerance)

    @property
    def period(self) -> float:
        """Step period of the gait [s], of legs that differ their mean."""
        return float(self.point.period * self.walker.time)

    @property
    def heel_strikes(self) -> np.ndarray:
        """Times of the heel strikes [s], (2,) or (3,)."""
        ends = [segment.start + segment.duration for segment in self.segments if segment.last]
        return np.array(ends) * self.walker.time

    def upright(self, biped: Biped, slope: Slope) -> Upright:
        """Where the penalty model of this biped begins: this start, and the force on the standing foot there."""
        force = float(signals_at(self.walker, self.segments[:1], np.zeros(1))["ground_reaction"][0, 0, 1])
        return Upright(biped, slope, self.walker.stance_state(self.start), force)

    def hip(self, time: np.ndarray) -> np.ndarray:
        """Hip at times [s] from the start, (n, 4); at heel strike the velocity after it."""
        order, last = np.argsort(time, kind="stable"), self.segments[-1]
        at = np.minimum(time[order] / self.walker.time, last.start + last.duration)
        found = signals_at(self.walker, self.segments, at)
        rows = np.column_stack([found["hip_position"], found["hip_velocity"]])
        return np.asarray(rows[np.argsort(order)])


def constraint_gait(
    biped: Biped, slope: Slope, tolerance: float, friction: Friction | None = None
) -> ConstraintWalk:
    """The gait. Raises NoGait or StepFailed."""
    return ConstraintWalk(*find_gait(biped, slope, tolerance, friction), tolerance)


def penalty_hip(trajectory: Trajectory, time: np.ndarray) -> np.ndarray:
    """Hip of a run of the penalty model at times [s], (n, 4)."""
    position, velocity = trajectory.at(time)
    return np.column_stack([position[:, :2], velocity[:, :2]])


#: What a model gives, as an array of one shape: the hip's curves, or a cycle's scalars beside them.
Outcome = np.ndarray
#: Effects that are on where others are in their limit.
LIMITS: tuple[frozenset[str], ...] = (frozenset(), *(frozenset({effect}) for effect in CONTACT))


class Limits:
    """The penalty model with some effects on and the others in their limit.

    `outcome` walks with a contact law at a tolerance; `share` is the part left of an effect that is off.
    """

    def __init__(
        self,
        law: ContactLaw,
        share: float,
        outcome: Callable[[ContactLaw, float], Outcome],
        tolerance: float,
        limit_tolerance: float,
    ) -> None:
        self.share = share
        self.shares = {
            on: Shares(*(outcome(switched(law, on, part * share), limit_tolerance) for part in (4, 2, 1)))
            for on in LIMITS  # the nodes first, so that each search of a cycle starts close to it
        }
        self.whole = outcome(law, tolerance)

    def at(self, on: frozenset[str]) -> Outcome:
        """Outcome with the effects `on`, the others in their limit."""
        return self.whole if on == frozenset(CONTACT) else self.shares[on].limit

    def convergence(self, curves: Callable[[Outcome], Outcome], compared: np.ndarray) -> Convergence:
        """How the limits were approached; `curves` takes the hip (n, 4) out of an outcome."""
        shares = [Shares(*(curves(outcome) for outcome in self.shares[on])) for on in LIMITS]
        return Convergence.of(self.share, shares, compared)


def contributions(
    constraint: Outcome, fine: Outcome, coulomb: Outcome, limits: Limits, fine_penalty: Outcome
) -> tuple[np.ndarray, np.ndarray]:
    """Contributions in the order of `EFFECTS` (6, ...), and how they depend on which effect of contact is first (...).

    The path: constraint model; integrated finely; with Coulomb friction at the trailing foot; penalty model with both
    effects of contact in their limits; each switched on; integrated as it is. `fine_penalty` has both on. The effects
    of contact have the mean over both orders; what comes second is half the difference, see `Split`.
    """
    neither, creep, impact = (limits.at(on) for on in LIMITS)
    whole = limits.at(frozenset(CONTACT))
    first, last = (telescoped([neither, node, fine_penalty]) for node in (creep, impact))
    steps = telescoped([constraint, fine, coulomb, neither])
    mean = 0.5 * (first + last[::-1])
    return np.concatenate([steps, mean, [whole - fine_penalty]]), 0.5 * (first[0] - last[1])


class OneStep:
    """The scene of all walks: the constraint model's mid-stance state and the times of its step."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters, settings = parameters, parameters.settings
        self.constraint = constraint_gait(parameters.biped, parameters.slope, parameters.constraint_tolerance)
        self.time = np.linspace(0.0, self.constraint.period, settings.points)
        self.strikes = [float(self.constraint.heel_strikes[0])]

    def coarse_or_fine(self, tolerance: float, coulomb: bool = False) -> np.ndarray:
        """The constraint model's hip from the common state at a tolerance, (n, 4); `coulomb`: the foot may slip."""
        p, gait = self.parameters, self.constraint
        design = DesignPoint(p.biped, p.slope, p.contact.coefficients if coulomb else None)
        walk = ConstraintWalk(design.walker(), gait.point, tolerance, gait.start)
        self.strikes.append(float(walk.heel_strikes[0]))
        return walk.hip(self.time)

    @property
    def upright(self) -> Upright:
        """Where all walks begin."""
        return self.constraint.upright(self.parameters.biped, self.parameters.slope)

    def penalty(self, law: ContactLaw, tolerance: float) -> np.ndarray:
        """The penalty model's hip from the common state, (n, 4). Raises NoLimitCycle."""
        run = self.upright.walk(law, Settings(tolerance), duration=float(self.time[-1]), signals=())
        strikes = find_events(run.trajectory, self.parameters.biped.foot_radii).heel_strike_time
        if not run.completed or not len(strikes):
            raise NoLimitCycle(f"over one step: {run.message or run.outcome}")
        self.strikes.append(float(strikes[0]))
        return penalty_hip(run.trajectory, self.time)

    def exudyn(self, law: ContactLaw, tolerance: float) -> np.ndarray:
        """The same of Exudyn's model. Raises NoLimitCycle."""
        machine = Machine(self.parameters.biped, self.parameters.slope, law, self.parameters.checked_tolerance)
        run = machine.exudyn(self.upright.start(law), tolerance, 1, float(self.time[-1]))
        if not run.completed:
            raise NoLimitCycle(f"over one step, in Exudyn: {run.message or run.outcome}")
        return penalty_hip(run.trajectory, self.time)

    def compared(self) -> np.ndarray:
        """Times outside the span in which only some of the models have had their impact, (n,)."""
        end = max(self.strikes) + self.parameters.settings.impact_window
        return (self.time < min(self.strikes)) | (self.time > end)


def step_budget(scene: OneStep) -> StepBudget:
    """The budget over one step. Raises NoLimitCycle, NoGait, StepFailed."""
    parameters, settings, law = scene.parameters, scene.parameters.settings, scene.parameters.contact
    coarse = scene.coarse_or_fine(parameters.constraint_tolerance)
    fine = scene.coarse_or_fine(settings.constraint_fine_tolerance)
    coulomb = scene.coarse_or_fine(settings.constraint_fine_tolerance, coulomb=True)
    fine_penalty = scene.penalty(law, settings.penalty_fine_tolerance)
    paper = (
        scene.coarse_or_fine(settings.paper_constraint_tolerance) - fine,
        scene.exudyn(law, settings.paper_penalty_tolerance) - fine_penalty,
    )
    limits = Limits(law, settings.step_share, scene.penalty, parameters.penalty_tolerance, settings.limit_tolerance)
    parts, interaction = contributions(coarse, fine, coulomb, limits, fine_penalty)
    compared = scene.compared()
    largest = np.array(
        [[*np.abs(curve[:, :2]).max(axis=0), *np.abs(curve[compared, 2:]).max(axis=0)] for curve in paper]
    )
    convergence = limits.convergence(np.asarray, compared)
    return StepBudget(scene.time, split_of(parts, interaction, compared), convergence, largest)


#: Scalars of a cycle, in s and m.
SCALARS = ("step period", "step length")


class Cycles:
    """Cycles of all models as one array each: the hip over a stride (4 n values), then the `SCALARS`; `middle` has the
    phases of their heel strikes amid a stride."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters, settings = parameters, parameters.settings
        self.phase = np.linspace(0.0, 1.0, settings.points)
        self.middle: list[float] = []
        self.rolling = constraint_gait(parameters.biped, parameters.slope, settings.constraint_fine_tolerance)
        friction = parameters.contact.coefficients
        self.coulomb = constraint_gait(parameters.biped, parameters.slope, settings.constraint_fine_tolerance, friction)
        self.found: list[tuple[ContactLaw, np.ndarray]] = []
        self.derivative: np.ndarray | None = None

    def outcome(self, hip: np.ndarray, period: float, length: float, strikes: np.ndarray) -> np.ndarray:
        """A cycle of the hip (n, 4) at phases of a stride from heel strike, of step period [s] and length [m], with the
        `strikes` [s] of one cycle."""
        self.middle.append(0.5 if len(strikes) == 1 else float(strikes[1] - strikes[0]) / (2.0 * period))
        hip[:, 0] -= hip[0, 0]
        return np.concatenate([hip.ravel(), [period, length]])

    def constraint(self, walk: ConstraintWalk) -> np.ndarray:
        """The constraint model's cycle."""
        strikes = walk.heel_strikes
        hip = walk.hip(strikes[0] + 2.0 * walk.period * self.phase)
        return self.outcome(hip, walk.period, 0.5 * float(hip[-1, 0] - hip[0, 0]), strikes[: len(walk.point.steps)])

    def penalty(self, law: ContactLaw, tolerance: float) -> np.ndarray:
        """The penalty model's cycle, searched from that of the law most like it. Raises NoLimitCycle."""
        p, solver = self.parameters, Settings(tolerance)
        upright = self.coulomb.upright(p.biped, p.slope)
        stepper = upright.stepper(law, solver)
        start, force = stepper.start, upright.standing_force
        guess = section_numbers(start)
        if self.found:
            near, known = min(self.found, key=lambda other: _distance(other[0], law))
            guess = known.copy()
            guess[0] += static_penetration(near, force) - static_penetration(law, force)
        try:
            cycle = fixed_point(stepper, guess, self.derivative)
        except NoLimitCycle as reason:
            raise NoLimitCycle(f"on a cycle: {reason}") from None
        self.derivative = cycle.derivative
        self.found.append((law, cycle.numbers))
        steps, whole = stepper.steps_a_cycle, cycle.step
        run = simulate(p.biped, p.slope, law, section_state(cycle.numbers, start), solver, steps=steps, signals=())
        strikes = find_events(run.trajectory, p.biped.foot_radii).heel_strike_time[:steps]
        time = strikes[0] + 2.0 * whole.period * self.phase
        cycles = np.floor(time / whole.duration)  # from mid-stance to mid-stance, of which one was walked
        hip = penalty_hip(run.trajectory, time - cycles * whole.duration)
        hip[:, 0] += cycles * whole.length
        return self.outcome(hip, whole.period, whole.step_length, strikes)

    def compared(self) -> np.ndarray:
        """Phases more than the impact's window after a heel strike, and not in the instant of one, (n,)."""
        window = self.parameters.settings.impact_window / (2.0 * self.rolling.period)
        inside = (self.phase >= min(self.middle)) & (self.phase <= max(self.middle) + window)
        return ~inside & (self.phase > window) & (self.phase < 1.0)


def _distance(one: ContactLaw, other: ContactLaw) -> float:
    """How unlike two laws are in stiffness and stiction velocity."""
    ratios = one.contact_stiffness / other.contact_stiffness, one.stiction_velocity / other.stiction_velocity
    return float(np.abs(np.log(ratios)).sum())


def cycle_budget(parameters: Parameters, coarse: ConstraintWalk) -> CycleBudget:
    """The budget between cycles; `coarse` is the constraint model's gait at its usual tolerance.

    Raises NoLimitCycle, NoGait, StepFailed.
    """
    cycles, settings, law = Cycles(parameters), parameters.settings, parameters.contact
    limits = Limits(law, settings.cycle_share, cycles.penalty, parameters.penalty_tolerance, settings.limit_tolerance)
    fine_penalty = cycles.penalty(law, settings.penalty_fine_tolerance)
    start = cycles.constraint(coarse)
    rolling, coulomb = cycles.constraint(cycles.rolling), cycles.constraint(cycles.coulomb)
    parts, interaction = contributions(start, rolling, coulomb, limits, fine_penalty)
    count, compared = len(SCALARS), cycles.compared()

    def hip(outcome: np.ndarray) -> np.ndarray:
        return outcome[..., :-count].reshape(*outcome.shape[:-1], -1, 4)

    return CycleBudget(
        phase=cycles.phase,
        split=split_of(hip(parts), hip(interaction), compared),
        scalars=parts[:, -count:],
        scalar_interaction=interaction[-count:],
        convergence=limits.convergence(hip, compared),
        constraint_scalars=start[-count:],
    )
