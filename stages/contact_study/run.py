"""Contact study: what each parameter of the contact does to a step, and which set comes closest to the rigid limit.

Inputs: the analytic gait's walk and mid-stance. Settings: params/contact_study.yaml; of ground.yaml the laws and the
friction coefficients, and the set it holds, to say whether that is the choice. Output: `Result`, figures 4 to 6 and
that of the contact sets.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.result import Inputs
from stages.biped.accuracy.scales import scales_of, size
from stages.biped.design import BeyondModel, require_own_strikes
from stages.biped.processes import Progress, ignore
from stages.contact_study.one_step import Scene, landing_force, measure, take_step
from stages.contact_study.parameters import Parameters, Settings
from stages.contact_study.result import VARIED, FrictionVariation, OneStep, Result, Variations
from stages.contact_study.rigid_limit import from_rigid_limit, same_set
from stages.ground.contact_law import ContactLaw
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings as SolverSettings
from stages.planar.limit_cycle import FixedPoint, fixed_point
from stages.planar.section import NoLimitCycle, section_numbers
from stages.studies.result import COMPLETED, EngineAgreement, as_columns, drawn

#: Changes of each transition velocity on both sides, outwards: what the paper may mean by small to moderate.
FACTORS = (tuple(2.0 ** (-0.5 * step) for step in (1, 2, 4)), tuple(2.0 ** (0.5 * step) for step in (1, 2, 4)))
VELOCITIES = ("stiction_velocity", "friction_velocity")
#: Steps after which a walker is near its gait, if the mid-stance it starts from does not lead to it at once.
SETTLING_STEPS = 8


def vary_friction(
    contact: ContactLaw, stepper: Callable[[ContactLaw], PenaltyStepper]
) -> tuple[FrictionVariation, ...]:
    """Gaits on ground with this contact law, and with each transition velocity changed alone by `FACTORS`.

    `stepper` walks on ground with a law from a mid-stance near its gait. Changes that break the order of the velocities
    are left out.
    """
    base = first_gait(stepper(contact))
    found = []
    for name in VELOCITIES:
        found.append(row(name, 1.0, base))
        for side in FACTORS:
            known = [] if base is None else [(0.0, base)]
            for factor in side:
                law = dataclasses.replace(contact, **{name: factor * getattr(contact, name)})
                if any(True for _ in law.broken_rules()):
                    continue
                point = next_gait(stepper(law), known, math.log(factor))
                if point is not None:
                    known.append((math.log(factor), point))
                found.append(row(name, factor, point))
    return tuple(sorted(found, key=lambda one: (VELOCITIES.index(one.name), one.factor)))


def laws_of(contact: ContactLaw, variations: Sequence[FrictionVariation]) -> list[ContactLaw]:
    """The contact laws of variations of this one that have a gait."""
    known = [one for one in variations if math.isfinite(one.period_s)]
    return [dataclasses.replace(contact, **{one.name: one.factor * getattr(contact, one.name)}) for one in known]


def first_gait(walker: PenaltyStepper) -> FixedPoint | None:
    """The gait near the walker's start, or where some steps lead to; None if there is none."""
    with suppress(NoLimitCycle):
        return fixed_point(walker, section_numbers(walker.start))
    with suppress(NoLimitCycle):
        return fixed_point(walker, walker.walk(walker.start, SETTLING_STEPS).numbers)
    return None


def next_gait(walker: PenaltyStepper, known: list[tuple[float, FixedPoint]], at: float) -> FixedPoint | None:
    """The gait on the line through the last two known ones, each with the logarithm of its factor, `at` another."""
    if not known:
        return first_gait(walker)
    (there, last), numbers = known[-1], known[-1][1].numbers
    if len(known) > 1:
        before, earlier = known[-2]
        numbers = numbers + (numbers - earlier.numbers) * (at - there) / (there - before)
    with suppress(NoLimitCycle):
        return fixed_point(walker, numbers, last.derivative)
    return None


def row(name: str, factor: float, point: FixedPoint | None) -> FrictionVariation:
    """What is kept of a gait."""
    known = (math.nan, math.nan) if point is None else (point.step.period, point.step.step_length)
    return FrictionVariation(name, factor, *known)


#: Seed of the draws.
SEED = 17


def checked(
    scene: Scene, laws: Sequence[tuple[ContactLaw, int]], cycles: Sequence[ContactLaw], count: int, tolerance: float
) -> EngineAgreement:
    """So many steps with sets, each given with its cost, and one cycle if there is more than one step.

    The dearest set is the first, the others and the cycle are drawn. `tolerance` is Exudyn's. Raises EnginesDisagree.
    """
    hardest = max(range(len(laws)), key=lambda number: laws[number][1])

    def named(law: ContactLaw) -> str:
        return ", ".join(f"{key} {getattr(law, key):.3g}" for key in VARIED)

    distances = [
        scene.upright.step_apart(f"a step with {named(law)}", law, tolerance, scene.period)
        for law, _ in (laws[number] for number in drawn(count, len(laws), SEED, (hardest,)))
    ]
    for law in (cycles[number] for number in drawn(int(count > 1), len(cycles), SEED)):
        with suppress(NoLimitCycle):  # a set without a gait has none to compare
            distances.append(scene.upright.cycle_apart(f"the cycle with {named(law)}", law, tolerance))
    return EngineAgreement(SEED, tuple(distances))


#: Spans of the force curves from heel strike, in pendulum times: start, end, spacing. Impact, bounces, rest of stance.
CURVE = ((-0.01, 0.03, 2.5e-4), (0.03, 0.2, 5e-4), (0.2, 1.8, 5e-3))
#: Shares of the time in which one parameter is varied, and until the search ends.
SHARES = 0.1, 0.6


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Vary one parameter at a time, then search. A step that fails is a row with its reason, and a rigid limit that the
    constraint model does not know leaves the choice out with its own. Raises BeyondModel."""
    require_own_strikes(parameters.biped, "the study of contact sets")
    analytic, settings = inputs.analytic, parameters.settings
    scene = Scene(
        parameters.biped,
        parameters.slope,
        SolverSettings(parameters.penalty_tolerance, settings.between, most_solver_steps=settings.most_solver_steps),
        settings.cost_tolerance,
        analytic.walk,
        analytic.mid_stance,
        analytic.gait.period_s,
        settings.impact_window,
    )
    time = curve_times(scales_of(parameters.biped, parameters.slope.gravity).time)
    default = parameters.default_set.law(parameters.contact)

    def walked(law: ContactLaw) -> tuple[OneStep, np.ndarray]:
        done = take_step(scene, law)
        return measure(scene, law, done), landing_force(scene, done, time)

    first, first_force = walked(default)
    varied: list[dict[str, Any]] = []
    changes = list(one_at_a_time(default, settings, size(parameters.biped)))
    for index, (key, law) in enumerate(changes):
        progress(SHARES[0] * index / len(changes), f"varying {key}")
        step, force = walked(law)
        varied.append({**vars(step), "key": key, "value": float(getattr(law, key)), "force": force})
    limit, candidates, outcome = None, None, COMPLETED
    try:
        limit, candidates = from_rigid_limit(
            parameters, scene, lambda done: progress(SHARES[0] + (SHARES[1] - SHARES[0]) * done, "choosing")
        )
    except (NoGait, StepFailed, BeyondModel) as reason:
        outcome = str(reason)
    chosen = limit.chosen.law if limit else default
    chosen_step, chosen_force = walked(chosen)
    progress(SHARES[1], "varying friction")
    stepper = partial(scene.upright.stepper, solver=scene.solver)
    friction = [vary_friction(law, stepper) for law in (parameters.contact, default)]
    progress(0.7, "comparing with Exudyn")
    walked_laws = [(row["law"], row["evaluations"]) for row in varied if row["outcome"] == COMPLETED]
    if limit is not None:
        walked_laws += [(one.law, one.evaluations) for one in limit.family if one.outcome == COMPLETED]
    walked_laws = walked_laws or [(default, first.evaluations)]
    return Result(
        time=time,
        default=first,
        default_force=first_force,
        variations=as_columns(Variations, varied),
        candidates=candidates,
        limit_outcome=outcome,
        limit=limit,
        chosen=chosen_step,
        chosen_force=chosen_force,
        ground=walked(parameters.contact)[0],
        ground_is_choice=limit is not None and same_set(parameters.contact, chosen),
        friction_variations=friction[0],
        default_friction_variations=friction[1],
        engines=checked(scene, walked_laws, laws_of(parameters.contact, friction[0]), settings.checked,
                        parameters.checked_tolerance),
    )


def curve_times(pendulum_time: float) -> np.ndarray:
    """Times of the force curves from heel strike [s], denser in the impact and while a foot may bounce, (n,)."""
    spans = [start + spacing * np.arange(round((end - start) / spacing)) for start, end, spacing in CURVE]
    return np.concatenate(spans) * pendulum_time


def one_at_a_time(default: ContactLaw, settings: Settings, longer: float) -> Iterator[tuple[str, ContactLaw]]:
    """The starting set with one parameter changed: (parameter, law), in the paper's order.

    Another exponent leaves the force at 1 mm of Table 1's robot as it is, and of a leg `longer` times at as many mm.
    """
    values = (
        settings.stiffness_values,
        settings.exponent_values,
        settings.damping_values,
        settings.depth_values,
        settings.stiction_velocity_values,
        settings.friction_velocity_values,
    )
    for key, options in zip(VARIED, values):
        for value in options:
            change: dict[str, Any] = {key: value}
            if key == "contact_exponent":
                change["contact_stiffness"] = default.contact_stiffness * longer ** (default.contact_exponent - value)
            yield key, dataclasses.replace(default, **change)
