"""The ladder stage: from the simple model to the twin, one change at a time.

Inputs: the simple model, the planar gait to start from, the twin's own walk. Settings: params/twin_ladder.yaml, and of
analytic.yaml what the constraint model is.
Output: `Result`, the gait of every rung, and of the constraint model of the same machine, as its bill projects into the
plane. What a rung changes depends on what stands before it: the order is the issue.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.gait_search import find_gait, step_lengths
from stages.analytic.gait.poincare import FixedPoint, poincare_derivative
from stages.analytic.model.walker import Walker
from stages.analytic.result import Result as Analytic
from stages.analytic.walk.recording import crossing, up_to_mid_stance, vaulting, walk_on
from stages.analytic.walk.sampling import signals_at
from stages.biped.design import Biped
from stages.biped.processes import Progress, ignore
from stages.biped.walk import StanceState
from stages.ground.slope import Friction, Slope
from stages.multibody.result import Result as Multibody
from stages.multibody.walking.walk import simulate
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings as PenaltySettings
from stages.planar.limit_cycle import gait_near
from stages.planar.run import LimitCycle, PlanarState
from stages.planar.section import UNITS, NoLimitCycle, mid_stance_after, section_scales, section_state
from stages.studies.result import COMPLETED
from stages.twin.machine.machine import FRAME_BODY, Machine
from stages.twin.machine.projection import machine_of, project
from stages.twin.parameters import Settings
from stages.twin.result import Result as Twin
from stages.twin_ladder.cycle import IN_PLANE, SIDE_UNITS, SIDEWAYS, Gait, Search, columns, multipliers_of, step_map
from stages.twin_ladder.parameters import Parameters
from stages.twin_ladder.result import Result, RungGait, SameMachine

#: Shares of a stride at which hips are compared.
PHASES = np.linspace(0.0, 1.0, 801)
PLANAR = "planar model"
#: Which feet the ground acts on at a mid-stance; the rest of it comes from a section's numbers.
STANDING = PlanarState((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (True, False))
PLANAR_ADDED = "compliant ground lets standing feet slide slowly: penalty contact and friction instead of constraints"
#: The row of a rung, and where its hip is at `PHASES` of a stride (801, 2) [m]; NaN without a gait.
Climbed = tuple[RungGait, np.ndarray]
NO_HIP, UNKNOWN = np.full((len(PHASES), 2), np.nan), np.full(2, np.nan)


@dataclass(frozen=True)
class Rung:
    """A machine, its name, what it has that the one before has not, whether it is the twin as it walks, and whether it
    is that before but for the width of its feet, of which motion in the plane knows nothing."""

    name: str
    added: str
    machine: Machine
    is_twin: bool
    widened: bool


def rungs(biped: Biped, settings: Settings, outsole: float) -> list[Rung]:
    """All machines in order; `outsole` [m] is the rubber of the last one if the twin itself has none.

    The first two differ from the planar model only out of the plane. With the planar inertia of twin.yaml there are
    no parts to add. Raises as `machine_of` does.
    """
    bare = replace(settings, outsole=0.0, bearing_friction=0.0, slider_friction=0.0)
    points = machine_of(biped, replace(bare, inertia="planar"))
    above, halved = ("upper leg mass", "mass") if points.rigid else ("leg mass above the spring", "spring and mass")
    found = [
        ("paired legs", f"two legs a pair, each with half the {halved}, on feet without width",
         replace(points, half_width=0.0)),
        ("foot width", "feet are cylinders that touch with two edges", points),
    ]  # fmt: skip
    if settings.inertia == "parts":
        parts = machine_of(biped, bare)
        feet = tuple(points.bodies[i] if i in FRAME_BODY else body for i, body in enumerate(parts.bodies))
        found += [
            ("distributed inertia", "the lower legs' mass is spread as in the bill of parts",
             replace(points, bodies=feet)),
            (above, "the upper legs' mass swings with them instead of sitting at the hip's axis", parts),
        ]  # fmt: skip
    rubbed = machine_of(biped, replace(settings, outsole=0.0))
    if settings.bearing_friction > 0.0 or settings.slider_friction > 0.0:
        found.append(("joint friction", "friction in bearings and sliders", rubbed))
    rubber = settings.outsole or outsole
    soled = machine_of(biped, replace(settings, outsole=rubber))
    found.append(("rubber outsoles", f"{1e3 * rubber:g} mm of rubber: longer legs, wider feet, and its mass", soled))
    twin = len(found) - (1 if settings.outsole > 0.0 else 2)
    return [Rung(name, added, machine, number == twin, machine is points)
            for number, (name, added, machine) in enumerate(found)]  # fmt: skip


@dataclass(frozen=True)
class ConstraintGait:
    """A gait of the constraint model: its row, yet without a name and the hip's differences; `hip` (801, 2) [m] at
    `PHASES` of a stride, which begins at `mid_stance`, the first leg upright at x = 0."""

    row: SameMachine
    hip: np.ndarray
    mid_stance: StanceState


def constraint_gait(
    biped: Biped, slope: Slope, tolerance: float, friction: Friction | None = None, steps: int = 1
) -> ConstraintGait:
    """The gait of the constraint model of a biped; with `friction` its trailing foot may slip and rise. Multipliers are
    those of so many `steps`."""
    try:
        walker, point = find_gait(biped, slope, tolerance, friction)
        return _described(walker, point, tolerance, steps)
    except (NoGait, StepFailed) as error:
        nothing = float("nan")
        row = SameMachine("", str(error), nothing, nothing, nothing, np.zeros((0, 2)), UNKNOWN, UNKNOWN)
        return ConstraintGait(row, NO_HIP, StanceState(*[nothing] * 8))


def constraint_gaits(parameters: Parameters, bipeds: Iterable[Biped]) -> list[ConstraintGait]:
    """Gaits of the constraint model of bipeds at the study's settings, with multipliers of a cycle of the design's own:
    a twin's pairs may differ by their parts alone."""
    settings = parameters.analytic
    friction = settings.limited(parameters.friction)
    steps = parameters.biped.steps_a_cycle
    return [constraint_gait(biped, parameters.slope, settings.tolerance, friction, steps) for biped in bipeds]


def section_numbers(state: StanceState) -> np.ndarray:
    """A mid-stance of the constraint model as `stages.planar.section` has it, (10,): it rolls without slip."""
    length, forward = state.stance_length, state.stance_length * state.stance_rate
    rates = -state.stance_rate, state.swing_rate, state.stance_length_rate, state.swing_length_rate
    return np.array([length, state.swing_angle, length, state.swing_length, forward, state.stance_length_rate, *rates])


def _described(walker: Walker, point: FixedPoint, tolerance: float, steps: int) -> ConstraintGait:
    upright, elapsed = crossing(walker, point.z, tolerance)
    segments = walk_on(walker, upright, 2, tolerance, elapsed)
    hip = signals_at(walker, segments, 2 * point.period * PHASES)["hip_position"]
    strikes = np.cumsum([segment.last for segment in segments])
    second = [segment for segment, before in zip(segments[1:], strikes, strict=False) if before == 1]
    other = up_to_mid_stance(walker.exchanged, second[vaulting(second)])
    period = point.period * walker.time
    first = poincare_derivative(walker, point.z, tolerance)[1]
    stride = point.monodromy_matrix if len(point.steps) == 2 else point.monodromy_matrix @ point.monodromy_matrix
    row = SameMachine(
        name="",
        outcome=COMPLETED,
        period_s=period,
        step_length_m=float(np.mean(step_lengths(walker, point))) * walker.length,
        inner_outer_difference=2 * (other.start + other.duration) / point.period - 2,
        multipliers=columns(multipliers_of(np.eye(len(first)), first, stride, steps)[:IN_PLANE]),
        hip_apart_m=UNKNOWN,
        hip_from_simple_m=UNKNOWN,
    )
    return ConstraintGait(row, hip - hip[0] * [1.0, 0.0], walker.stance_state(upright))


def beside(name: str, own: ConstraintGait, simple: ConstraintGait, hip: np.ndarray) -> SameMachine:
    """The row of a rung: its own constraint model, and how far its `hip` (801, 2) is from that and the simple one's."""
    return replace(
        own.row,
        name=name,
        hip_apart_m=np.abs(hip - own.hip).max(axis=0),
        hip_from_simple_m=np.abs(hip - simple.hip).max(axis=0),
    )


@dataclass(frozen=True)
class Inputs:
    """What the stage reads."""

    analytic: Analytic
    multibody: Multibody
    twin: Twin


def again(parameters: Parameters, inputs: Inputs, result: Result) -> Result:
    """The result at closer settings: of the rungs the first two and the twin, which others read; of the others their
    constraint models."""
    first, *more = rungs(parameters.biped, parameters.twin, parameters.settings.outsole)
    twin, others = ([rung for rung in more if rung.is_twin is which] for which in (True, False))
    fewer = ladder(parameters, inputs, [first, *twin])
    gaits, pairs = {row.name: row for row in fewer.rungs}, {row.name: row for row in fewer.same_machine}
    own = constraint_gaits(parameters, (project(rung.machine) for rung in others))
    alone = {rung.name: one.row for rung, one in zip(others, own, strict=True)}
    return replace(
        fewer, rungs=tuple(gaits.get(row.name, row) for row in result.rungs),
        same_machine=tuple(pairs[row.name] if row.name in pairs else replace(
            alone[row.name], name=row.name, hip_apart_m=row.hip_apart_m, hip_from_simple_m=row.hip_from_simple_m)
            for row in result.same_machine))  # fmt: skip


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Find the gait of every rung. Raises ValueError if parts do not add up to the design."""
    return ladder(parameters, inputs, rungs(parameters.biped, parameters.twin, parameters.settings.outsole), progress)


def ladder(parameters: Parameters, inputs: Inputs, machines: list[Rung], progress: Progress = ignore) -> Result:
    """Gaits of machines, from that of the planar model, or of the constraint model where that has none; `inputs.twin`
    holds the twin's own walk.

    A machine without a gait is a row that says so.
    """
    analytic, settled = inputs.analytic, inputs.twin.settling
    bipeds = [parameters.biped, *(project(rung.machine) for rung in machines)]  # the planar model's is the simple one
    constrained = constraint_gaits(parameters, bipeds)
    cycle = inputs.multibody.mid_stance
    if cycle is None:
        start = section_numbers(analytic.mid_stance)
        first = without_gait(PLANAR, PLANAR_ADDED, inputs.multibody.unsettled, False), NO_HIP
    else:
        start, first = cycle.section_state, planar_rung(parameters, cycle)
    found = [first, *climb(parameters, machines, start, constrained, progress)]
    return Result(
        simple_period_s=analytic.gait.period_s,
        simple_step_length_m=analytic.gait.step_length_m,
        rungs=tuple(row for row, _ in found),
        walked_period_s=settled.period_s,
        walked_step_length_m=settled.step_length_m,
        same_machine=tuple(
            beside(row.name, own, constrained[0], hip) for (row, hip), own in zip(found, constrained, strict=True)
        ),
        steps=parameters.biped.steps_a_cycle,
    )


def planar_rung(parameters: Parameters, cycle: LimitCycle) -> Climbed:
    """The planar model as the first rung; it has no sideways motion."""
    start = section_state(cycle.section_state, STANDING)
    where = parameters.biped, parameters.slope, parameters.contact
    settings = replace(
        parameters.planar, assembly="tree", tolerance=parameters.settings.tolerance,
        largest_step=parameters.twin.largest_step,
    )  # fmt: skip
    run, limp = simulate(*where, start, settings, steps=2), 0.0
    if not parameters.biped.alike:
        limp = 2.0 * mid_stance_after(simulate(*where, start, settings, steps=1)).duration / cycle.period_s - 2.0
    row = RungGait(
        name=PLANAR,
        added=PLANAR_ADDED,
        outcome=COMPLETED,
        is_twin=False,
        period_s=cycle.period_s,
        step_length_m=cycle.step_length_m,
        inner_outer_difference=limp,
        plane_multipliers=cycle.floquet_multipliers[:IN_PLANE],
        side_multipliers=np.zeros((0, 2)),
        residual=cycle.residual,
        solver_steps=float(cycle.solver_steps),
        strides_walked=cycle.steps_walked // 2,
    )
    return row, run.trajectory.at(2 * cycle.period_s * PHASES)[0][:, :2]


def climb(
    parameters: Parameters, machines: list[Rung], plane: np.ndarray, constrained: Sequence[ConstraintGait],
    progress: Progress,
) -> list[Climbed]:
    """Gaits of the spatial machines, each searched from the penalty walker's of the same machine, and that from the
    last one found, or at first from the section numbers `plane` (10,), by as much as their constraint models'
    mid-stances differ; `constrained` has the planar model's first.
    """
    settings = parameters.settings
    solver = replace(parameters.twin, tolerance=settings.tolerance)
    in_plane, sideways = (section_scales(parameters.biped, parameters.slope, each) for each in (UNITS, SIDE_UNITS))
    side = np.ones((len(SIDE_UNITS), SIDEWAYS))
    length, before = parameters.biped.leg_length, constrained[0]
    rows: list[Climbed] = []
    found: tuple[Gait, np.ndarray] | None = None
    for number, (rung, own) in enumerate(zip(machines, constrained[1:], strict=True), 1):
        progress(number / (len(machines) + 1), f"gait with {rung.name}")
        named: dict[str, Any] = {"name": rung.name, "added": rung.added, "is_twin": rung.is_twin}
        if not settings.sideways and found is not None and rung.widened:
            rows.append((replace(found[0].row, **named), found[1]))
            continue
        longer = float(rung.machine.length.mean()) - length
        length += longer
        if own.row.found and before.row.found:
            ahead = section_numbers(own.mid_stance) - section_numbers(before.mid_stance)
        else:  # a longer machine stands higher on its feet
            ahead = longer * np.array([1.0, 0.0, 1.0, 1.0, *[0.0] * 6])
        plane, before = plane + ahead, own
        take = step_map(rung.machine, parameters.slope, parameters.contact, solver)
        search = Search(take, (in_plane, sideways), settings.tolerance, settings.difference, settings.sideways,
                        parameters.biped.steps_a_cycle)
        try:
            gait = search.find(*in_the_plane(parameters, rung.machine, section_state(plane, STANDING)), side, **named)
        except NoLimitCycle as error:
            rows.append((without_gait(reason=str(error), **named), NO_HIP))
            continue
        plane, side = gait.plane, gait.sideways
        found = gait, gait.hip(PHASES)
        rows.append((gait.row, found[1]))
    return rows


def in_the_plane(parameters: Parameters, machine: Machine, start: PlanarState) -> tuple[np.ndarray, np.ndarray]:
    """The mid-stance (10,) of the penalty walker's gait of a machine near `start`, and the exact derivative of its
    stride (10, 10). Raises NoLimitCycle.
    """
    settings = PenaltySettings(parameters.settings.tolerance)
    stepper = PenaltyStepper(project(machine), parameters.slope, parameters.contact, start, settings)
    cycle = gait_near(stepper, start)
    return cycle.section_state, np.linalg.matrix_power(cycle.monodromy_matrix, 2 // stepper.steps_a_cycle)


def without_gait(name: str, added: str, reason: str, is_twin: bool) -> RungGait:
    """A row that says why there is no gait."""
    nothing, unknown = np.zeros((0, 2)), float("nan")
    return RungGait(name, reason, unknown, unknown, unknown, added, is_twin, nothing, nothing, unknown, unknown, 0)
