"""`ground-sensitivity`: how the gait on ground that gives way answers to each parameter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stages.biped.question import Answer, Asking, Question, WrongOption, option
from stages.contact_study.parameters import Parameters

if TYPE_CHECKING:
    import numpy as np

    from stages.penalty.response import OfMultipliers, Response
    from stages.studies.result import Distance

#: Elasticities in the order of their columns.
HEADS = "period", "length", "|mu1|", "|mu2|"
#: Tolerance and sampling rate [Hz] of the constraint model's gait, from which this one is sought.
CONSTRAINT, RATE = 1e-10, 2000.0


@dataclass(frozen=True)
class Options:
    """Options of `ground-sensitivity`."""

    parameters: tuple[str, ...] = option(
        "-", "Parameter to ask for, instead of all that the gait depends on; repeatable", default=(),
        metavar="FILE.KEY")


@dataclass(frozen=True)
class Sensitivity:
    """The gait with its derivatives; elasticities (n, 4) as in `HEADS`, of a parameter that is zero for a size it could
    have; those of the multipliers once more; how far Exudyn's step is from the walker's.
    """

    response: Response
    elasticities: np.ndarray
    multipliers: OfMultipliers
    distance: Distance

    @property
    def left(self) -> float | None:
        """What extrapolation leaves of the multipliers' elasticities at most; None where there are none."""
        known = [float(error) for error in self.multipliers.errors if error == error]
        return max(known, default=None)


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Derivatives of the gait near the constraint model's.

    Raises NoGait, StepFailed, NoLimitCycle, EnginesDisagree, WrongOption.
    """
    import numpy as np

    from stages.analytic.gait.gait_search import find_gait
    from stages.analytic.walk.sampling import walk_from_mid_stance
    from stages.penalty.model.changes import names_of
    from stages.penalty.response import TOLERANCE, of_multipliers, responses
    from stages.penalty.settings import Settings
    from stages.penalty.step_map import PenaltyStepper
    from stages.planar.limit_cycle import gait_near
    from stages.planar.section import section_state
    from stages.planar.state import rolling_state
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
    multipliers = of_multipliers(*model, start, response)
    asking.progress(0.9, "a step in Exudyn")
    distance = over_a_walk("a step of the gait", Machine(*model), section_state(gait.section_state, start))
    EngineAgreement(0, (distance,))
    shares = np.column_stack([response.elasticities(), multipliers.elasticities])
    found = Sensitivity(response, shares, multipliers, distance)
    plain = as_plain(found, parameters)
    rows = [{"parameter": name, **told} for name, told in plain["parameters"].items()]
    return Answer(list(lines(found, parameters)), plain, rows=rows)


def value_of(name: str, parameters: Parameters) -> float:
    """The value of a parameter."""
    from stages.penalty.model.changes import owner

    section = owner(name, (parameters.biped, parameters.slope, parameters.contact))
    return float(getattr(section, name.partition(".")[2]))


def lines(found: Sensitivity, parameters: Parameters) -> Iterator[str]:
    """The answer in words."""
    gait = found.response.gait
    yield f"gait on the ground of ground.yaml: period {gait.period_s:.6g} s, steps of {gait.step_length_m:.6g} m"
    (first, turned), (second, other) = gait.floquet_multipliers[:2]
    yield f"leading multipliers: {complex(first, turned):.6g}, {complex(second, other):.6g}"
    yield (f"a step of it in Exudyn: {found.distance.distance:.1g} m from the compiled walker's "
           f"({found.distance.allowed:g} allowed)")
    yield ""
    yield "Elasticities: by how many percent a measure changes for 1 % of a parameter."
    yield f"{'':25}" + "".join(f"{head:>9}" for head in HEADS)
    changes = found.response.changes
    for name, row in zip(changes.names, found.elasticities, strict=True):
        yield f"{name:25}" + "".join(f"{value:>+9.4f}" if value == value else f"{'-':>9}" for value in row)
    for name, scale in zip(changes.names, changes.scales, strict=True):
        if not value_of(name, parameters):
            yield f"{name} is 0: above stands what 1 % of {scale:.3g} does"
    if found.left is not None:
        yield f"multipliers' are sure to {found.left:.0e}, the others exact"
    yield from found.multipliers.refused


def as_plain(found: Sensitivity, parameters: Parameters) -> dict[str, Any]:
    """The answer as JSON: for each parameter elasticities (none for one that is zero) and derivatives per unit."""
    response = found.response
    told = {}
    for row, (name, scale) in enumerate(zip(response.changes.names, response.changes.scales, strict=True)):
        value = value_of(name, parameters)
        known = [float(share) if share == share else None for share in found.elasticities[row]]
        shares = dict(zip(HEADS, known, strict=True))
        told[name] = {
            "value": value, "elasticities": shares if value else None,
            "period_s": float(response.period[row] / scale), "step_length_m": float(response.length[row] / scale),
        }  # fmt: skip
    gait = response.gait
    return {
        "gait": {"period_s": gait.period_s, "step_length_m": gait.step_length_m},
        "multipliers": gait.floquet_multipliers[:2].tolist(),
        "parameters": told,
        "left_by_extrapolation": found.left,
        "refused": list(found.multipliers.refused),
        "distance_to_exudyn_m": found.distance.distance,
    }


QUESTION = Question(
    "ground-sensitivity",
    """Tell how the gait on ground that gives way answers to each parameter: exact elasticities.

    Period, step length and the two leading multipliers of the planar penalty model's gait, by every number of the
    design, the slope and the contact law. Derivatives are carried through touch-down, lift-off and the corners of the
    contact law; the multipliers' are differences of exact ones. A step of the gait is walked by Exudyn too.
    """,
    Options,
    ask,
    examples=("bipedstudy ground-sensitivity --parameters ground.stiction_velocity",),
    rows=True,
)
