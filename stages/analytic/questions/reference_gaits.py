"""`reference-gaits`: ten gaits with proven digits, to score other simulators by (docs/reference_gaits.md)."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stages.biped.question import Answer, Asking, Question, option, refuse

if TYPE_CHECKING:
    from stages.analytic.parameters import Parameters
    from stages.biped.design import Biped
    from stages.biped.walk import StanceState
    from stages.ground.slope import Slope

KIND = "bipedstudy reference gaits 1"
EQUATIONS = "docs/equations.md, docs/model.md"
#: How the name of an enclosure ends that has a unit.
ENDINGS = {"s": "s", "m": "m", "N": "N"}
HIP = {"mass": "hip_mass", "weighed_mass": "weighed_hip", "stiffness": "hip_stiffness", "damping": "hip_damping",
       "rest_angle": "hip_rest_angle"}  # fmt: skip


@dataclass(frozen=True)
class Options:
    """Options of `reference-gaits`."""

    file: Path | None = option("-", "Write them into this new file, as JSON", default=None)
    only: tuple[str, ...] = option("-", "The gait of the design of this name alone; repeatable", default=())


@dataclass(frozen=True)
class Design:
    """A design on its slope, in words; with `cycle` its gait is the stable cycle of several steps."""

    name: str
    words: str
    biped: Biped
    slope: Slope
    cycle: bool = False


def designs(biped: Biped, slope: Slope) -> Iterator[Design]:
    """Ten designs around a biped: the biped as it is, and changes by shares of its own sizes."""
    mass, length = biped.foot_mass, biped.leg_length
    moment, torque = mass * length**2, biped.total_mass * slope.gravity * length
    rate = (slope.gravity / length) ** 0.5
    yield Design("plain", "the design itself", biped, slope)
    yield Design("rigid", "legs that keep their length", replace(biped, legs="rigid"), slope)
    yield Design("detailed", "inertias, frames above the springs, masses beside the legs' lines", replace(
        biped, leg_inertia=0.005 * moment, foot_offset=0.002 * length, frame_mass=0.1 * mass, frame_com=0.2 * length,
        frame_offset=0.005 * length, frame_inertia=0.001 * moment), slope)  # fmt: skip
    yield Design("unequal_legs", "the other leg is heavier, its mass lies higher", replace(
        biped, other_foot_mass=1.05 * mass, other_foot_com=1.02 * biped.foot_com), slope)  # fmt: skip
    yield Design("two_step_cycle", "rigid legs on a slope on which each second step is alike", replace(
        biped, legs="rigid"), replace(slope, slope_deg=1.75 * slope.slope_deg), cycle=True)  # fmt: skip
    yield Design("hip_spring", "a spring and a damper between the legs", replace(
        biped, hip_stiffness=0.02 * torque, hip_damping=0.001 * torque / rate), slope)  # fmt: skip
    yield Design("large", "lengths by 3, masses by 27, springs by 9", scaled(biped, 3.0), slope)
    yield Design("small", "lengths by 1/4, masses by 1/64, springs by 1/16", scaled(biped, 0.25), slope)
    yield Design("weak_gravity", "a sixth of gravity, as on the Moon", biped, replace(
        slope, gravity=slope.gravity / 6))  # fmt: skip
    yield Design("flat_feet", "larger feet on a steeper slope", replace(
        biped, foot_radius=1.2 * biped.foot_radius), replace(slope, slope_deg=1.25 * slope.slope_deg))  # fmt: skip


#: Powers of the length by which numbers of each unit grow: masses as volumes, springs and dampers as areas, torques of
#: the hip as weights times lengths.
GROWTH = {"m": 1, "kg": 3, "N/m": 2, "N s/m": 2, "kg m^2": 5, "N m": 4, "N m/rad": 4, "N m s/rad": 4.5, "rad": 0}


def scaled(biped: Biped, by: float) -> Biped:
    """A biped whose lengths are `by` times as long."""
    powers = {field.name: GROWTH.get(field.metadata["unit"]) for field in fields(biped)}
    return replace(biped, **{name: value * by**power for name, power in powers.items()
                             if power is not None and (value := getattr(biped, name)) is not None})


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Find, prove and describe the gaits; where some are not, the others. Raises WrongOption; NoGait and NotProven,
    naming the design, where none is."""
    from stages.analytic.errors import NoGait
    from stages.analytic.questions.prove import refuse_rough, require_flint
    from stages.proof.flow import NotProven

    require_flint()
    refuse_rough(parameters.biped, parameters.limited_friction is not None)
    chosen = {design.name: design for design in designs(parameters.biped, parameters.slope)}
    refuse(*((name not in chosen, f"only: there is no design {name}; there are {', '.join(chosen)}")
             for name in options.only))  # fmt: skip
    with asking.new_file(options.file) if options.file else nullcontext() as path:
        gaits, refused = list[dict[str, Any]](), list[NoGait | NotProven]()
        for name in options.only or chosen:
            try:
                gaits.append(described(chosen[name], asking))
            except (NoGait, NotProven) as reason:
                refused.append(reason)
        if not gaits:
            raise refused[0]
        plain = {"kind": KIND, "equations": EQUATIONS, "gaits": gaits}
        if path is not None:
            path.write_bytes((json.dumps(plain, indent=1) + "\n").encode())
    rows = [(gait["name"], gait["steps"], *gait["enclosures"]["period"]["between"], "yes" if gait["stable"] else "no")
            for gait in gaits]  # fmt: skip
    table = "Duration of a step, the mean of its steps [s]", ("gait", "steps", "at least", "at most", "stable"), rows
    return Answer([f"written: {options.file}"] if options.file else [], plain, tables=(table,),
                  remark="\n".join(map(str, refused)), no=bool(refused))  # fmt: skip


def described(design: Design, asking: Asking) -> dict[str, Any]:
    """A gait with its design, as JSON: every number with its unit, each enclosure between decimals."""
    from stages.analytic.errors import NoGait
    from stages.analytic.gait.gait_report import record_steps
    from stages.analytic.gait.gait_search import describe
    from stages.analytic.phases.section import section_state
    from stages.analytic.questions.prove import TOLERANCE, proven, study_gait
    from stages.proof.flow import NotProven

    try:
        asking.progress(0.0, design.name)
        walker, point = study_gait(design.biped, design.slope, design.cycle)
        found = proven(design.biped, design.slope, walker, point, asking)
    except (NoGait, NotProven) as refused:
        raise type(refused)(f"design {design.name} ({design.words}): {refused}") from None
    gait, start = describe(walker, point), walker.stance_state(section_state(point.z, walker.p))
    units = {field.name: field.metadata["unit"] for field in fields(start)}

    def state(of: StanceState) -> dict[str, Any]:
        """A state as JSON."""
        return {name: quantity_of(value, units[name]) for name, value in vars(of).items()}

    events = [{
        "event": "heel strike" if segment.last else "toe-off", "stance_leg": segment.stance_leg,
        "time": quantity_of((segment.start + segment.duration) * walker.time, "s"),
        "state": state(walker.on(segment.stance_leg).stance_state(segment.end)),
    } for segment in record_steps(walker, point, TOLERANCE)]  # fmt: skip
    start = replace(start, **{name: float(text) for name, text in found["centre"].items()})
    return {
        "name": design.name, "words": design.words, "steps": len(point.steps), "stable": found["stable"],
        "parameters": parameters_of(design), "start": state(start), "events": events,
        "period": quantity_of(gait.period_s, "s"), "step_length": quantity_of(gait.step_length_m, "m"),
        "multipliers": {"value": gait.floquet_multipliers.tolist(), "unit": "1"},
        "enclosures": {name.removesuffix(f"_{unit}"): {"between": ends, "unit": unit}
                       for name, ends in found["enclosures"].items()
                       for unit in [units.get(name) or ENDINGS.get(name.rpartition("_")[2], "1")]},
    }  # fmt: skip


def quantity_of(value: float, unit: str) -> dict[str, Any]:
    """A number with its unit."""
    return {"value": float(value), "unit": unit}


def parameters_of(design: Design) -> dict[str, Any]:
    """Hip, ground and both legs; leg 0 stands first. What a design does not give is 0."""
    from stages.biped.design import Biped, Leg
    from stages.ground.slope import Slope

    units = {field.name: field.metadata["unit"] for kind in (Biped, Slope) for field in fields(kind)}
    hip = {name: quantity_of(getattr(design.biped, key), units.get(key, "kg")) for name, key in HIP.items()}
    legs = {f"leg_{i}": {field.name: quantity_of(getattr(design.biped.leg(i), field.name), units[field.name])
                         for field in fields(Leg)} for i in (0, 1)}  # fmt: skip
    ground = {name: quantity_of(value, units[name]) for name, value in vars(design.slope).items()}
    return {"hip": {"legs": design.biped.legs, **hip}, "ground": ground, **legs}


QUESTION = Question(
    "reference-gaits",
    """Ten gaits of designs around the one in params/, to score other simulators by: see docs/reference_gaits.md.

    Of each: parameters, start, events, period, multipliers, and what prove encloses them in, with units. It needs
    python-flint (the extra [proof]) and takes some minutes.
    """,
    Options,
    ask,
    examples=("bipedstudy reference-gaits --file gaits.json",),
)
