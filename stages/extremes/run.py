"""The extremes stage: over which parameters every model is right, and how it says so where it is not.

Inputs: none. Settings: params/extremes.yaml. Output: `Result`, a row a point.
"""

from collections.abc import Callable, Collection, Sequence

from stages.analytic.errors import NoGait
from stages.biped.design import BeyondModel
from stages.biped.processes import Progress, ignore
from stages.extremes import constraint_points, penalty_points
from stages.extremes.parameters import (
    COMPILED,
    COULOMB,
    CRASHED,
    DERIVATIVES,
    DETAILED,
    ESTIMATE,
    GAIT,
    JOINTS,
    LIMIT,
    MARCH,
    OF_A_GAIT,
    REFUSED,
    STEP,
    TREE,
    TWIN,
    UNCONFIRMED,
    Parameters,
)
from stages.extremes.points import BLOCK, KINDS, Point, detailed_draw, points
from stages.extremes.result import Finding, Result
from stages.extremes.watchdog import compute
from stages.studies.result import as_columns

#: Why the stage is not run once more at closer settings of solvers.
ONCE = "it is a map of what the solvers bear, at tolerances of its own"
#: Gives the verdict on a point, from the usual parameters and those at the point.
Evaluate = Callable[[Parameters, Parameters, Point], Finding]
CONSTRAINT, PLANAR, SPATIAL = ("friction", "analytic"), ("contact", "multibody"), ("contact", "twin")
#: Of every engine: the sections of the parameters that it reads besides the biped and the slope, and its verdicts.
MEASURES: dict[str, tuple[tuple[str, ...], Evaluate]] = {
    GAIT: (CONSTRAINT, constraint_points.gait),
    COULOMB: (CONSTRAINT, constraint_points.gait),
    DETAILED: (CONSTRAINT, constraint_points.gait),
    STEP: (CONSTRAINT, constraint_points.one_step),
    MARCH: (CONSTRAINT, constraint_points.march),
    DERIVATIVES: (CONSTRAINT, constraint_points.derivatives),
    ESTIMATE: (CONSTRAINT, constraint_points.estimate),
    COMPILED: (PLANAR, penalty_points.one_step),
    TREE: (PLANAR, penalty_points.one_step),
    JOINTS: (PLANAR, penalty_points.one_step),
    LIMIT: (PLANAR, penalty_points.rigid_limit),
    TWIN: (SPATIAL, penalty_points.one_step),
}


def run(parameters: Parameters, inputs: None = None, progress: Progress = ignore) -> Result:
    """Try every point; none of them can fail the stage."""
    tried = points(parameters)
    settings = parameters.settings

    def done(count: int) -> None:
        progress(count / len(tried), f"{count} of {len(tried)} points")

    progress(0.0, "compiling")
    usual = compile_once(parameters, {point.engine for point in tried})
    known = {i: usual[point.engine] for i, point in enumerate(tried) if point.engine in usual and not point.changes}
    others = [point for i, point in enumerate(tried) if i not in known]
    rest = iter(compute(
        evaluate, parameters, others, processes=settings.processes, longest_s=settings.longest_s, done=done))
    return as_result(settings.resolution, tried, [known[i] if i in known else next(rest) for i in range(len(tried))])


def compile_once(parameters: Parameters, engines: Collection[str]) -> dict[str, Finding]:
    """Leave compiled code on the disk before the clock of a point runs: compiling takes longer than any point.

    What was found meanwhile: the verdicts on the usual parameters, by engine.
    """
    full = parameters.settings.resolution == "full"
    first = (GAIT, COULOMB, STEP, *(OF_A_GAIT if full else ()), COMPILED, TWIN)
    found = {one: evaluate(parameters, Point(one, "none", 0.0, ())) for one in first if one in engines}
    for kind in range(len(KINDS)) if full else ():
        evaluate(parameters, Point(DETAILED, "none", 0.0, detailed_draw(parameters.biped, kind * BLOCK)))
    if full and COMPILED in engines:
        evaluate(parameters, Point(COMPILED, "none", 0.0, (("ground.normal_force", "restitution"),)))
    return found


def evaluate(parameters: Parameters, point: Point) -> Finding:
    """The verdict on one point. An exception that the engine did not mean to raise counts as a crash."""
    try:
        sections, verdict = MEASURES[point.engine]
        here = located(parameters, point)
        if reason := here.refusal(("biped", "slope", *sections)):
            return Finding(REFUSED, reason=reason)
        return verdict(parameters, here, point)
    except (NoGait, BeyondModel) as reason:
        return Finding(REFUSED, reason=str(reason))
    except constraint_points.NoReference as reason:
        return Finding(UNCONFIRMED, reason=str(reason))
    except Exception as error:
        return Finding(CRASHED, reason=f"{type(error).__name__}: {' '.join(str(error).split())[:200]}")


def located(parameters: Parameters, point: Point) -> Parameters:
    """The parameters at a point: the solvers of the penalty models as the settings say, then what the point changes."""
    settings, assembly = parameters.settings, "joints" if point.engine == JOINTS else "tree"
    solvers: dict[str, object] = {"multibody.assembly": assembly}
    for file in ("multibody", "twin"):
        solvers[f"{file}.tolerance"] = settings.penalty_tolerance
        solvers[f"{file}.most_solver_steps"] = settings.most_solver_steps
    here = parameters.changed(tuple(solvers.items())).changed(point.changes)
    if point.engine == TWIN and {"biped.hip_mass", "biped.foot_mass"} & dict(point.changes).keys():
        here = here.changed((("twin.inertia", "planar"),))  # the bill of parts has Table 1's masses
    return here


def as_result(resolution: str, requested: Sequence[Point], found: Sequence[Finding]) -> Result:
    """Points and findings as columns."""
    rows = [{**vars(point), **vars(finding), "changes": in_words(point)} for point, finding in zip(requested, found)]
    return as_columns(Result, rows, resolution=resolution)


def in_words(point: Point) -> str:
    """The parameters changed, as name=value; ..."""
    return "; ".join(f"{name}={value if isinstance(value, str) else f'{value:g}'}" for name, value in point.changes)
