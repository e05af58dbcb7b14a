"""The penalty models at a point: one step from the constraint model's mid-stance, beside a reference run of it."""

import dataclasses
from collections.abc import Callable
from functools import lru_cache, partial

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.biped.accuracy.scales import TABLE_1, from_to, quickness, scales_of
from stages.biped.design import Biped, require_own_strikes
from stages.biped.walk import StanceState, Walk
from stages.extremes.constraint_points import usual_gait
from stages.extremes.parameters import COMPILED, FAILED, INACCURATE, JOINTS, TREE, TWIN, UNCONFIRMED, WRONG, Parameters
from stages.extremes.points import Point
from stages.extremes.result import Finding, judged
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Friction, Slope
from stages.multibody.walking.walk import simulate
from stages.penalty.walk import Settings as CompiledSettings, simulate as compiled_walk
from stages.planar.energy import energy_balance
from stages.planar.run import Run, Trajectory, rolling_state
from stages.twin.machine.projection import machine_of
from stages.twin.walking.measures import energy_balance as spatial_energy_balance
from stages.twin.walking.record import Record
from stages.twin.walking.simulate import rolling_start, simulate_twin

#: The reference's tolerance is tighter by this; what is the tightest tolerance Exudyn's explicit solver goes with.
TIGHTER, TIGHTEST = 1e-2, 1e-11
#: Points in time at which two runs are compared.
GRID = 400
#: For Table 1's robot, others have their own scales: time left out around heel strike for the rigid limit [s], rate of
#: the gait's samples [Hz], and the contact that is stiffened, in the parameters' units.
IMPACT, RATE_HZ = 5e-3, 2000.0
STIFFNESS, DAMPING, DEPTH, VELOCITIES = 1e5, 1e4, 1e-4, (1e-3, 2e-3)


@dataclasses.dataclass(frozen=True)
class Answer:
    """A step of a penalty model: how it ended, hip x and y on a grid of time, and its energy balance's residual."""

    completed: bool
    outcome: str
    time: np.ndarray
    hip: np.ndarray
    audit: float


def one_step(usual: Parameters, here: Parameters, point: Point) -> Finding:
    """The verdict on one step of a penalty model. Raises NoGait, BeyondModel."""
    require_own_strikes(here.biped, "the model")
    engine, limit, start = point.engine, usual.settings.right_within, mid_stance(here.biped, here.slope)
    answer = answer_of(here, engine, *start)
    if "gets nowhere" in answer.outcome:
        return Finding(FAILED, reason=answer.outcome)
    file, tolerance = ("twin", here.twin.tolerance) if engine == TWIN else ("multibody", here.multibody.tolerance)
    # in leg lengths: Exudyn's is in metres
    requested = np.nan if engine == JOINTS else tolerance / (1.0 if engine == COMPILED else here.biped.leg_length)
    if engine in (COMPILED, JOINTS):
        tree = here.changed((("multibody.assembly", "tree"), ("multibody.tolerance", 1e-9)))
        checked = answer_of(tree, TREE, *start)
        if engine == JOINTS or "gets nowhere" not in checked.outcome:
            return compared(answer, checked, here.biped, requested, limit, "tree, tolerance 1e-9")
    tighter = max(TIGHTEST, tolerance * TIGHTER)
    checked = answer_of(
        here.changed(((f"{file}.tolerance", tighter), (f"{file}.largest_step", 5e-4))), engine, *start)
    return compared(answer, checked, here.biped, requested, limit, f"tolerance {tighter:.0e}, energy")


def compared(
    answer: Answer, other: Answer, biped: Biped, requested: float, limit: float, reference: str
) -> Finding:
    """Verdict on an answer beside its reference; `requested` is the tolerance in leg lengths, or NaN without one."""
    if not answer.completed:
        if other.completed and not (requested > limit or np.isnan(requested)):
            return Finding(WRONG, reference=reference, reason=f"{answer.outcome}, but not in the reference")
        said = "; the reference walks" if other.completed else ""
        return Finding(FAILED, reference=reference, reason=answer.outcome + said)
    if not other.completed:
        return Finding(UNCONFIRMED, audit=answer.audit, reference=reference, reason=f"the reference: {other.outcome}")
    end = min(answer.time[-1], other.time[-1])
    times = np.linspace(0.0, end, GRID)
    gap = [np.interp(times, one.time, one.hip[:, i]) for one in (answer, other) for i in (0, 1)]
    error = max(np.abs(gap[0] - gap[2]).max(), np.abs(gap[1] - gap[3]).max()) / biped.leg_length
    return judged(float(error), answer.audit, requested, limit, reference)


def answer_of(here: Parameters, engine: str, stance: StanceState, force: float) -> Answer:
    """One step of an engine."""
    if engine == TWIN:
        machine = machine_of(here.biped, here.twin)
        start = rolling_start(machine, here.contact, stance, force)
        record = simulate_twin(machine, here.slope, here.contact, start, here.twin, steps=1)
        return answered(record, record, record.reason, partial(spatial_energy_balance, record, 0.0))
    ground = here.biped, here.slope, here.contact
    state = rolling_state(here.biped, here.contact, stance, force)
    if engine == COMPILED:
        solver = CompiledSettings(here.multibody.tolerance, most_solver_steps=here.multibody.most_solver_steps)
        run = compiled_walk(*ground, state, solver, signals=())
    else:
        run = simulate(*ground, state, here.multibody, steps=1)
    return answered(run, run.trajectory, run.message, partial(energy_balance, run.trajectory, *ground, 0.0))


def answered(
    run: Run | Record, path: Trajectory | Record, message: str, balance: Callable[[float], object]
) -> Answer:
    """What is kept of a run and its path; `balance` is that of its energy from the start to a time."""
    times, audit = np.linspace(0.0, float(path.time[-1]), 5 * GRID), np.nan
    if run.completed:
        audit = turnover(balance(float(times[-1])))
    hip = path.at(times)[0][:, :2] if len(path.time) > 1 else np.zeros((len(times), 2))
    return Answer(run.completed, ending(run.outcome, message), times, hip, audit)


def ending(outcome: str, message: str) -> str:
    """How a run ended, without the time at which it did."""
    words = f"{outcome}: {message}" if message and message != outcome else outcome
    return "the solver gets nowhere within its steps" if outcome == "step floor" else words.split(" at t =")[0]


def turnover(balance: object) -> float:
    """Residual of an energy balance as a part of all the energy that changed hands, which is never zero."""
    parts = dataclasses.asdict(balance)  # type: ignore[call-overload]
    residual = abs(parts.pop("residual"))
    return float(residual / max(sum(abs(part) for part in parts.values()), 1e-300))


@lru_cache(maxsize=64)
def mid_stance(biped: Biped, slope: Slope) -> tuple[StanceState, float]:
    """The constraint model's mid-stance and the force on the standing foot there [N]. Raises NoGait, BeyondModel."""
    walk, _, stance = step_of(biped, slope, None)
    return stance, walk.standing_force


def step_of(biped: Biped, slope: Slope, friction: Friction | None) -> tuple[Walk, float, StanceState]:
    """The gait from one mid-stance to the one after the next, its period [s], and its state at the start.

    Raises NoGait, BeyondModel.
    """
    try:
        walker, point = usual_gait(biped, slope, friction)
        rate = RATE_HZ * quickness(biped, slope.gravity)
        walk, upright = walk_from_mid_stance(walker, point.z, 1, 1e-10, rate)
    except (NoGait, StepFailed) as reason:
        raise NoGait(f"no gait to start from: {reason}") from None
    return walk, point.steps[0].period * walker.time, upright


def rigid_limit(usual: Parameters, here: Parameters, point: Point) -> Finding:
    """The planar model with contact so many times as stiff, an impact as plastic as before and hardly any creep,
    beside the constraint model with Coulomb friction, which is its limit. Raises NoGait, BeyondModel."""
    limit, factor = usual.settings.right_within, point.value
    mu, law = here.contact.static_friction, here.contact
    walk, period, stance = step_of(here.biped, here.slope, Friction(mu, mu))
    scale = factor ** (1.0 / (law.contact_exponent + 1.0))
    own = scales_of(here.biped, here.slope.gravity)
    stiff = from_to(TABLE_1, own).measure(ContactLaw(
        factor * STIFFNESS, law.contact_exponent, DAMPING * scale, DEPTH / scale, mu, mu, *VELOCITIES))
    patient = dataclasses.replace(here.multibody, most_solver_steps=500_000)
    state = rolling_state(here.biped, stiff, stance, walk.standing_force)
    run = simulate(here.biped, here.slope, stiff, state, patient, steps=1)
    if not run.completed:
        return Finding(FAILED, reason=ending(run.outcome, run.message))
    near = IMPACT / quickness(here.biped, here.slope.gravity)
    end = min(period, float(run.trajectory.time[-1]))
    away = (walk.time <= end) & (np.abs(walk.time - walk.heel_strike_time[0]) > near)
    hip = run.trajectory.at(walk.time[away])[0][:, :2]
    error = float(np.abs(hip - walk.hip_position[away]).max() / here.biped.leg_length)
    finding = judged(error, np.nan, limit, limit, "gait, coulomb: its rigid limit")
    if error > limit:
        return dataclasses.replace(finding, status=INACCURATE, reason="softer than the limit, by its own stiffness")
    return finding
