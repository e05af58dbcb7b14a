"""`ground-sensitivity`: how the gait on ground that gives way answers to each parameter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stages.biped.question import Answer, Asking, Question, WrongOption, elasticity, option
from stages.contact_study.parameters import Parameters

if TYPE_CHECKING:
    import numpy as np

#: Elasticities in the order of their columns; those of a parameter that is zero are for a size that it could have.
HEADS = "period", "length", "|mu1|", "|mu2|"
#: Tolerance and sampling rate [Hz] of the constraint model's gait, from which this one is sought.
CONSTRAINT, RATE = 1e-10, 2000.0


@dataclass(frozen=True)
class Options:
    """Options of `ground-sensitivity`."""

    parameters: tuple[str, ...] = option(
        "-", "Parameter to differentiate by, instead of all that the gait depends on; repeatable", default=(),
        metavar="FILE.KEY")


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Derivatives of the gait near the constraint model's.

    Raises NoGait, StepFailed, NoLimitCycle, EnginesDisagree, WrongOption.
    """
    import numpy as np

    from stages.analytic.gait.gait_search import find_gait
    from stages.analytic.walk.sampling import walk_from_mid_stance
    from stages.penalty.model.changes import names_of, owner
    from stages.penalty.step_map import TOLERANCE, PenaltyStepper, of_multipliers, responses
    from stages.penalty.walk import Settings
    from stages.planar.limit_cycle import gait_near
    from stages.planar.run import rolling_state
    from stages.planar.section import section_state
    from stages.studies.result import EngineAgreement
    from stages.studies.walks import Machine, over_a_walk

    biped, slope, contact = model = parameters.biped, parameters.slope, parameters.contact
    every = names_of(*model)
    names = tuple(dict.fromkeys(options.parameters)) or every
    for name in names:
        if name not in every:
            raise WrongOption(f"--parameters {name}: this gait depends on {', '.join(every)}")
    walker, point = find_gait(biped, slope, CONSTRAINT)
    walk, upright = walk_from_mid_stance(walker, point.z, 1, CONSTRAINT, RATE)
    start = rolling_state(biped, contact, upright, walk.standing_force)
    gait = gait_near(PenaltyStepper(*model, start, Settings(TOLERANCE)), start)
    asking.progress(0.3, "derivatives")
    response = responses(*model, start, gait, names)
    asking.progress(0.5, "multipliers")
    of_both, errors, refused = of_multipliers(*model, start, response)
    asking.progress(0.9, "a step in Exudyn")
    distance = over_a_walk("a step of the gait", Machine(*model), section_state(gait.section_state, start))
    EngineAgreement(0, (distance,))
    elasticities = np.column_stack([response.elasticities(), of_both])
    found: dict[str, dict[str, Any]] = {}
    for row, (name, scale) in enumerate(zip(response.changes.names, response.changes.scales, strict=True)):
        value = float(getattr(owner(name, model), name.partition(".")[2]))
        known = [float(share) if share == share else None for share in elasticities[row]]
        found[name] = {
            "value": value, "elasticities": dict(zip(HEADS, known, strict=True)) if value else None,
            "period_s": float(response.period[row] / scale), "step_length_m": float(response.length[row] / scale),
        }  # fmt: skip
    plain = {
        "gait": {"period_s": gait.period_s, "step_length_m": gait.step_length_m},
        "multipliers": gait.floquet_multipliers[:2].tolist(),
        "parameters": found,
        "left_by_extrapolation": max((float(error) for error in errors if error == error), default=None),
        "refused": refused,
        "distance_to_exudyn_m": distance.distance,
    }
    text = list(lines(plain, distance.allowed, elasticities, response.changes.scales))
    return Answer(text, plain, rows=[{"parameter": name, **own} for name, own in found.items()])


def lines(
    plain: dict[str, Any], allowed: float, elasticities: np.ndarray, scales: np.ndarray
) -> Iterator[str]:  # fmt: skip
    """The answer in words: `plain` is its JSON, which has no elasticities (n, 4) of a parameter that is zero.

    For such a one they are those for a size that it could have, in `scales`.
    """
    yield (f"gait on the ground of ground.yaml: period {plain['gait']['period_s']:.6g} s, steps of "
           f"{plain['gait']['step_length_m']:.6g} m")
    (first, turned), (second, other) = plain["multipliers"]
    yield f"leading multipliers: {complex(first, turned):.6g}, {complex(second, other):.6g}"
    if abs(complex(first, turned)) >= 1.0:
        yield "the gait is unstable: a walk does not stay with it, and there may be a stable one beside it"
    yield (f"a step of it in Exudyn: {plain['distance_to_exudyn_m']:.1g} m from the compiled walker's "
           f"({allowed:g} allowed)")
    yield ""
    yield "Elasticities: by how many percent a measure changes for 1 % of a parameter."
    yield f"{'':25}" + "".join(f"{head:>9}" for head in HEADS)
    for name, row in zip(plain["parameters"], elasticities, strict=True):
        yield f"{name:25}" + "".join(elasticity(value, 9) for value in row)
    for (name, own), scale in zip(plain["parameters"].items(), scales, strict=True):
        if not own["value"]:
            yield f"{name} is 0: above stands what 1 % of {scale:.3g} does"
    if plain["left_by_extrapolation"] is not None:
        yield f"multipliers' are sure to {plain['left_by_extrapolation']:.0e}, the others exact"
    yield from plain["refused"]


QUESTION = Question(
    "ground-sensitivity",
    """Print by how many percent the gait on compliant ground changes for 1 % of each parameter.

    Period, step length and the two leading multipliers of the planar penalty model's gait, by every number of the
    design, the slope and the contact law. Derivatives are carried through flow and events; those of multipliers are
    differences of exact ones. Exudyn walks a step of the gait as a check.
    """,
    Options,
    ask,
    examples=("bipedstudy ground-sensitivity --parameters ground.stiction_velocity",),
    rows=True,
)
