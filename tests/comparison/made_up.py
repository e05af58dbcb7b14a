"""Made-up results. A walk: smooth, periodic, with known strides. Nothing in it comes from a model."""

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.interpolate import interp1d

from stages.biped.walk import SENSOR_SIGNALS, Walk
from stages.comparison.measurement import LegAgreement, LegCurves, MeasurementAgreement, of_walk
from stages.contact_study.result import VARIED, OneStep, Result, Variations
from stages.error_budget.result import (
    CREEP,
    EFFECTS,
    IMPACT,
    SLIP,
    UNEXPLAINED,
    Convergence,
    CycleBudget,
    Result as Budget,
    StepBudget,
    split_of,
)
from stages.ground.contact_law import ContactLaw
from stages.imu.trial.agreement import Agreement, FrequencyDifference
from stages.studies.result import COMPLETED, Distance, EngineAgreement
from tests.contact_study.made_up import make_candidates, make_limit

DEFAULTS = ContactLaw(1e5, 2.2, 1e4, 1e-4, 1.1, 1.0, 0.1, 1.0)


def make_walk(period: float = 0.5, steps: int = 8, speed: float = 0.3, first_periods: tuple[float, ...] = ()) -> Walk:
    """Heel strikes every `period` (after `first_periods`), legs in turn; signals are sines of the stride phase."""
    strikes = 0.2 + np.cumsum([0.0, *first_periods, *([period] * (steps - 1 - len(first_periods)))])
    time = np.linspace(0.0, strikes[-1] + 0.1, 4001)
    phase = 2 * np.pi * np.interp(time, strikes, 0.5 * np.arange(steps))
    legs = np.arange(steps) % 2
    two = np.column_stack([np.sin(phase), np.cos(phase)])
    # the ground carries leg 0 in the first half of its stride and leg 1 in the second
    share = np.column_stack([np.sin(phase) >= 0, np.sin(phase) < 0]).astype(float)
    return Walk(
        time=time,
        hip_position=np.column_stack([speed * time, 0.33 + 0.003 * np.sin(phase)]),
        hip_velocity=np.column_stack([speed + 0.1 * np.sin(phase), 0.02 * np.cos(phase)]),
        leg_angle=0.3 * two,
        leg_rate=2.0 * two,
        leg_length=0.333 + 0.002 * two,
        leg_length_rate=0.01 * two,
        ground_reaction=np.stack([share * np.array([0.5, -0.5]), 9.0 * share], axis=-1),
        hip_specific_force=np.column_stack([np.sin(phase), 9.8 + np.cos(phase)]),
        hip_angular_velocity=2 * np.sin(phase),
        foot_specific_force=np.column_stack([2 * np.sin(phase), 9.8 + 2 * np.cos(phase)]),
        foot_angular_velocity=2 * np.sin(phase),
        heel_strike_time=strikes,
        heel_strike_leg=legs,
        toe_off_time=strikes + 0.02,
        toe_off_leg=1 - legs,
    )


def resampled(walk: Walk, time: np.ndarray) -> Walk:
    """The walk with its signals at other times, straight between its own."""
    signals = {
        field.name: interp1d(walk.time, getattr(walk, field.name), axis=0)(time)
        for field in dataclasses.fields(walk)
        if len(getattr(walk, field.name)) == len(walk.time)
    }
    return dataclasses.replace(walk, **{**signals, "time": time})


def scaled(value: Any, factor: float) -> Any:
    """A result with every number times a factor."""
    if isinstance(value, float) or (isinstance(value, np.ndarray) and value.dtype.kind == "f"):
        return factor * value
    if isinstance(value, dict):
        return {key: scaled(part, factor) for key, part in value.items()}
    if isinstance(value, SimpleNamespace):
        return type(value)(**scaled(vars(value), factor))
    if dataclasses.is_dataclass(value):
        parts = {field.name: scaled(getattr(value, field.name), factor) for field in dataclasses.fields(value)}
        return dataclasses.replace(value, **parts)
    return tuple(scaled(part, factor) for part in value) if isinstance(value, tuple) else value


def make_step(law: ContactLaw = DEFAULTS, hip: float = 2e-3, creep: float = 4e-3) -> OneStep:
    """A step with a stated hip difference [m] and creep [m/s]."""
    pair = np.array([hip, 0.1 * hip])
    return OneStep("completed", "", law, pair, 5 * pair, pair, pair, 0.1, 0.1, 500.0, 4e-5, creep, 1e-4, 600)


def make_study(hip: float = 2e-3, chosen: float = 2e-4, ground_is_choice: bool = True) -> Result:
    """A contact study with every parameter halved and doubled; the hip differs by `hip` [m] times the factor."""
    factors, time = (0.5, 2.0), np.linspace(-2e-3, 0.33, 500)
    values = [factor * getattr(DEFAULTS, key) for key in VARIED for factor in factors]
    size = np.array([hip * factor for _ in VARIED for factor in factors])
    bump = np.column_stack([-np.exp(-time / 0.05), 10 + 500 * np.exp(-(((time + 3e-4) / 2e-4) ** 2))])
    rows = len(values)
    variations = Variations(
        key=tuple(key for key in VARIED for _ in factors),
        value=np.array(values),
        outcome=("completed",) * rows,
        message=("",) * rows,
        hip_position=np.column_stack([size, 0.1 * size]),
        hip_velocity=np.column_stack([5 * size, size]),
        end_position=np.column_stack([size, 0.1 * size]),
        normal_force=np.full(rows, 0.1),
        friction_force=np.full(rows, 0.1),
        peak_force=np.full(rows, 500.0),
        penetration=np.full(rows, 4e-5),
        creep_velocity=2 * size,
        evaluations=np.full(rows, 600),
        force=bump * (1 + 0.1 * np.arange(rows))[:, None, None],
    )
    best = make_step(hip=chosen)
    return Result(
        time, make_step(hip=hip), bump, variations, make_candidates(DEFAULTS, hip), COMPLETED,
        make_limit(DEFAULTS, hip, chosen), best, bump, best, ground_is_choice, (), (), make_engines(),
    )  # fmt: skip


def make_engines() -> EngineAgreement:
    """A check of the two engines."""
    return EngineAgreement(1, (Distance("a step", "completed", 1e-11, float("nan"), 1e-9),))


def make_budget(integration: float = 1e-8) -> Budget:
    """Contributions of round sizes [m] with their rates, the rest 2 % of the total; `integration` in metres."""
    time = np.linspace(0.0, 0.48, 101)
    sizes = {SLIP: 3e-4, CREEP: -5e-4, IMPACT: 1e-4, UNEXPLAINED: -2e-6}
    shape = np.column_stack([time, 0.1 * time, 1.0 + time, 0.1 - time])
    contributions = np.array([sizes.get(effect, 0.0) * shape for effect in EFFECTS])
    split = split_of(contributions, 5e-5 * shape, np.abs(time - 0.24) > 0.01)
    convergence = Convergence(0.1, np.ones((3, 4)), np.full((3, 4), 1e-6))
    step = StepBudget(time, split, convergence, np.full((2, 4), integration))
    scalars, interaction = contributions[:, -1, :2].copy(), split.interaction[-1, :2].copy()
    cycle = CycleBudget(time / 0.48, split, scalars, interaction, convergence, np.array([0.48, 0.16]))
    return Budget("completed", step, cycle, make_engines())


def make_agreement(origin: str = "measured", share: float = 1.0, frequency: float = 1.9) -> MeasurementAgreement:
    """Runs that agree with both models in every signal, but for the share inside the envelope."""
    found = Agreement(0.1, 0.01, 0.99, True, 0.98, 0.0, -0.2, 0.2, share)
    difference = FrequencyDifference(frequency - 2.0, frequency - 2.1, frequency - 1.9, 0.95)
    signals = dict.fromkeys(SENSOR_SIGNALS, found)
    return MeasurementAgreement(
        origin, 30, frequency, 0.01, 2.0, difference, difference, 40.0, signals, signals, make_leg()
    )


def make_leg() -> LegAgreement:
    """A leg of the runs that swings a tenth further than both models', over steps a tenth as long again."""
    model = of_walk(make_walk(), 101, 51)
    runs = LegCurves(1.1 * model.angle, 1.1 * model.rate, 1.1 * model.hip_path, 1.1 * model.step_length)
    every = [np.stack([one, 1.02 * one]) for one in (runs.angle, runs.rate, runs.hip_path)]
    apart = np.array([5e-3, 1e-3])
    return LegAgreement(runs, *every, 1e-3, 8e-4, model, model, 0.02, 0.02, apart, apart)
