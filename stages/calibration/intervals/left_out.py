"""What a model leaves out that would explain what a fit leaves: score tests (C. R. Rao, 1948), then likelihood ratios.

A parameter that a fit holds pulls on the residuals by its score, at the estimate and without another fit. Its square
over its information is chi-square with one degree of freedom where the parameter is what it is held at. Those that
show most are fitted too: what that takes off the sum of squares is chi-square in the same way (S. S. Wilks, 1938).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from operator import attrgetter

import numpy as np
from scipy.special import ndtri

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.processes import Progress, ignore
from stages.calibration.estimation.campaign import JOINT, CampaignFit, Joint, fit_campaign
from stages.calibration.estimation.least_squares import Known, known_equations
from stages.calibration.estimation.run_fit import GOOD, Equations, Model, lowest, run_equations
from stages.calibration.information.identifiability import short
from stages.calibration.intervals.model_error import structure_in_words, widening
from stages.calibration.observation.measured_run import SIDES

#: What is tried where a model does not have it: legs that differ, friction at the hip, frames above the springs.
OTHER = tuple(f"biped.other_{key}" for key in (
    "foot_radius", "foot_mass", "foot_com", "stiffness", "damping", "leg_length"))
FRICTION, FRAME = "biped.hip_friction", "biped.frame_mass"
#: In so many of the campaigns whose model is right a cause may be named, by all tests together (Bonferroni).
LEVEL = 0.02
#: At most so many are named: those whose likelihood is not less than the best one's by this factor.
NAMED, WORSE = 3, 20.0
#: Of a fit with one more parameter: what explains the residuals takes four to six.
WITH_ONE_MORE = replace(JOINT, most=10)


@dataclass(frozen=True)
class Cause:
    """A parameter that was left out: `sigmas` of its score, or of its likelihood ratio if it is fitted too; then its
    `value` and `sd`, the shared parameters' `shift` (d,) with it, the `drop` of the residuals' sum of squares in
    variances, and whether it `explains` them: what is left is noise."""

    name: str
    sigmas: float
    value: float = math.nan
    sd: float = math.nan
    shift: Vector = field(default_factory=lambda: np.zeros(0))
    drop: float = 0.0
    explains: bool = False


def candidates(design: DesignPoint, model: Model) -> tuple[str, ...]:
    """Parameters that a fit of compliant legs could have had and has not."""
    has = {*model.shared, *model.own}
    alike = [name for name in OTHER if name not in has and getattr(design.biped, name.partition(".")[2]) is None]
    absent = [name for name in (FRICTION, FRAME) if name not in has and design.value(name) == 0.0]
    return (*alike, *absent) if design.biped.legs == "compliant" else ()


def with_all(design: DesignPoint, names: Sequence[str]) -> DesignPoint:
    """The same robot as one that has the parameters `names`: legs that are alike, a hip with next to no friction,
    frames without mass, which would sit half way down to the leg's."""
    biped = design.biped
    values = {name: design.value(name) for name in names if name in OTHER}
    if FRAME in names:
        values["biped.frame_com"] = 0.5 * (biped.leg_length - biped.foot_com)
    there = design.with_values(values)
    return there.with_value(FRICTION, float(lowest(there, [FRICTION])[0])) if FRICTION in names else there


def scores(
    design: DesignPoint, fit: CampaignFit, model: Model, known: Sequence[Known], names: Sequence[str]
) -> list[Cause]:
    """The score of each of `names` at a fit, the most telling first; `value` is by how much it would change.

    Sigmas are those of the residuals that would be left with it: their size, and how far neighbours hang together.
    """
    d, wide = len(model.shared), replace(model, shared=(*model.shared, *names))
    there = with_all(model.robot(design, fit.design), names)
    at = [run_equations(there, own, unknowns, run, wide)
          for own, unknowns, run in zip(fit.own, fit.unknowns, fit.runs, strict=True)]  # fmt: skip
    matrix, right, _ = known_equations(known, [one.of(there) for one in known], wide.shared, there)
    for one in at:
        more, other = one.eliminated(len(wide.shared))
        matrix, right = matrix + more, right + other
    alike = np.eye(len(wide.shared))  # what the fit looks for moves the other leg as well
    for place, name in enumerate(names, d):
        if (first := name.replace("other_", "")) in model.shared:
            alike[place, model.shared.index(first)] = 1.0
    matrix, right = alike.T @ matrix @ alike, alike.T @ right
    unit = 1.0 / np.sqrt(np.diag(matrix))
    matrix, right = matrix * unit * unit[:, None], right * unit
    found = []
    for place, name in enumerate(names, d):
        kept = [*range(d), place]
        inverse = np.linalg.pinv(matrix[np.ix_(kept, kept)], rcond=1e-13, hermitian=True)
        step = inverse @ right[kept] * unit[kept]
        sigmas = step[-1] / (math.sqrt(inverse[-1, -1]) * unit[place])
        moved = np.zeros(len(wide.shared))
        moved[kept] = step
        _, wider = widening([_with(one, alike @ moved) for one in at])
        one_sided = name in (FRICTION, FRAME) and step[-1] < 0.0
        found.append(Cause(name, 0.0 if one_sided else abs(sigmas) / wider, float(step[-1]), shift=step[:-1]))
    return sorted(found, key=attrgetter("sigmas"), reverse=True)


def _with(one: Equations, step: Vector) -> Equations:
    """A run's equations with the residuals that a step (d,) of the shared parameters would leave."""
    moves, shown = np.concatenate([step, one.own_step(step)]), one.predicted.samples
    residuals = {side: one.residuals[side] - shown[side][:, :, 1:] @ moves / one.noise[side] for side in SIDES}
    changed = replace(one, residuals=residuals)
    return replace(changed, chi2=sum(float(np.nansum(changed.pulls(side) ** 2)) for side in SIDES))


def limit(count: int) -> float:
    """Sigmas beyond which one of so many scores is no chance."""
    return float(-ndtri(0.5 * LEVEL / count)) if count else math.inf


def causes(
    design: DesignPoint, fit: CampaignFit, model: Model, known: Sequence[Known], progress: Progress = ignore
) -> list[Cause]:
    """What explains the residuals of a fit: the best first, at most three that they cannot part; none where they are as
    noise would have them."""
    names = candidates(design, model)
    try:
        found = scores(design, fit, model, known, names) if names else []
    except StepFailed:
        return []
    least = limit(len(names))
    best = [one for one in found if one.sigmas > least][:NAMED]
    tried = [] if fit.chi2 > GOOD * fit.count else [_fitted(one, design, fit, model, known, False) for one in best]
    for number, each in enumerate(best):  # a fit that its cause has led far off does not find back from there
        if any(one.explains and one.sigmas > least for one in tried):
            break  # what explains all that was amiss leaves the others nothing
        progress(0.9 + 0.1 * number / len(best), f"all runs once more, with {short(each.name)} looked for too")
        tried.append(_fitted(each, design, fit, model, known, True))
    sure = [one for one in tried if one.sigmas > least]  # of these, those that explain the residuals if any do
    fits = sorted([one for one in sure if one.explains] or sure, key=attrgetter("sigmas"))
    there = [*{one.name: one for one in fits}.values()]  # of two fits of one parameter the better
    there.sort(key=attrgetter("sigmas"), reverse=True)
    return [one for one in there if one.drop > there[0].drop - 2.0 * math.log(WORSE)][:NAMED]


def _fitted(
    score: Cause, design: DesignPoint, fit: CampaignFit, model: Model, known: Sequence[Known], anew: bool
) -> Cause:
    """The fit with that parameter looked for too, from where the fit without it is; or `anew`, from the first guess and
    what the score says of the parameter, each run alone first. It explains nothing where there is no fit."""
    name, wide = score.name, replace(model, shared=(*model.shared, score.name))
    there = with_all(design, [name])
    low = float(lowest(there, [name])[0])
    try:
        if anew:
            there = there.with_value(name, max(low, there.value(name) + score.value))
            with_it = fit_campaign(there, fit.runs, wide, known)
        else:
            held = model.robot(design, fit.design).value(name)  # none, or a leg's
            with_it = Joint(there, fit.runs, wide, known).from_point(
                np.append(fit.design, max(low, held)), fit.own, fit.unknowns, {}, 0, WITH_ONE_MORE)
    except StepFailed:
        return Cause(name, 0.0)
    if with_it.left_out:  # residuals of fewer runs
        return Cause(name, 0.0)
    _, wider = widening(with_it.equations)
    before, after = (sum(one.cost for one in each.equations) for each in (fit, with_it))
    drop = 2.0 * (before - after) / wider**2
    return Cause(name, math.sqrt(max(drop, 0.0)), float(with_it.design[-1]),
                 float(wider * math.sqrt(with_it.covariance[-1, -1])), with_it.design[:-1] - fit.design, drop,
                 not structure_in_words(with_it.runs, with_it.equations))


def widened(sd: Vector, found: Sequence[Cause]) -> Vector:
    """Standard deviations (d,) that hold what each of the causes that explain the residuals would change too."""
    return np.asarray(np.max([sd, *(np.hypot(sd, one.shift) for one in found if one.explains)], axis=0))


def in_words(found: Sequence[Cause], design: DesignPoint) -> list[str]:
    """A sentence on the causes, and how to look for the first; nothing without any."""
    if not found:
        return []
    each = [f"{short(one.name)} ({one.value:.4g} {design.unit(one.name)} for {design.value(one.name):.4g}, "
            f"{one.sigmas:.1f} standard errors)" for one in found]
    what = "one of: " + "; ".join(each) + " (the runs cannot part them)" if len(each) > 1 else each[0]
    if not any(one.explains for one in found):
        return [f"no parameter that was tried explains the residuals, and no interval holds what the model lacks; "
                f"nearest comes {what}"]
    return [f"the residuals are explained by {what}; intervals are wider by what that would change. To look for "
            f"it, give {short(found[0].name)} in biped.yaml"]
