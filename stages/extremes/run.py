"""The extremes stage: over which parameters every model is right, and how it says so where it is not.

Inputs: none. Settings: params/extremes.yaml. Output: `Result`, a row a point.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from stages.biped.progress import Progress, ignore
from stages.extremes import constraint_points, gait_accounts, penalty_points
from stages.extremes.detailed_points import BLOCK, KINDS, detailed_draw
from stages.extremes.engines import COMPILED, COULOMB, DETAILED, GAIT, MARCH, OF_A_GAIT, STEP, TWIN
from stages.extremes.parameters import Parameters
from stages.extremes.points import Point, points
from stages.extremes.result import Result
from stages.extremes.verdict import CRASHED, Finding
from stages.extremes.watchdog import compute

#: What gives the verdicts on an engine's points.
EVALUATED = dict.fromkeys((GAIT, COULOMB, DETAILED, STEP, MARCH), constraint_points.evaluate) | dict.fromkeys(
    OF_A_GAIT, gait_accounts.evaluate)


def run(parameters: Parameters, inputs: None = None, progress: Progress = ignore) -> Result:
    """Try every point; none of them can fail the stage."""
    asked = points(parameters)
    settings = parameters.settings

    def done(count: int) -> None:
        progress(count / len(asked), f"{count} of {len(asked)} points")

    progress(0.0, "compiling")
    usual = compile_once(parameters, {point.engine for point in asked})
    known = {i: usual[point.engine] for i, point in enumerate(asked) if point.engine in usual and not point.changes}
    others = [point for i, point in enumerate(asked) if i not in known]
    rest = iter(compute(
        evaluate, parameters, others, processes=settings.processes, longest_s=settings.longest_s, done=done))
    return as_result(settings.resolution, asked, [known[i] if i in known else next(rest) for i in range(len(asked))])


def compile_once(parameters: Parameters, engines: Collection[str]) -> dict[str, Finding]:
    """Leave compiled code on the disk before the clock of a point runs: compiling takes longer than any point.

    What was found meanwhile: the verdicts on the usual parameters, by engine.
    """
    full = parameters.settings.resolution == "full"
    found = {}
    for engine in (GAIT, COULOMB, STEP, *(OF_A_GAIT if full else ()), COMPILED, TWIN):
        if engine not in engines:
            continue
        found[engine] = evaluate(parameters, Point(engine, "none", 0.0, ()))
    for kind in range(len(KINDS)) if full else ():
        evaluate(parameters, Point(DETAILED, "none", 0.0, detailed_draw(parameters.biped, kind * BLOCK)))
    if full and COMPILED in engines:
        evaluate(parameters, Point(COMPILED, "none", 0.0, (("ground.normal_force", "restitution"),)))
    return found


def evaluate(parameters: Parameters, point: Point) -> Finding:
    """The verdict on one point. An exception that the engine did not mean to raise counts as a crash."""
    try:
        finding: Finding = EVALUATED.get(point.engine, penalty_points.evaluate)(parameters, point)
        return finding
    except Exception as error:
        return Finding(CRASHED, reason=f"{type(error).__name__}: {' '.join(str(error).split())[:200]}")


def as_result(resolution: str, asked: tuple[Point, ...], found: list[Finding]) -> Result:
    """Points and findings as columns."""
    return Result(
        resolution=resolution,
        engine=tuple(point.engine for point in asked),
        axis=tuple(point.axis for point in asked),
        value=np.array([point.value for point in asked]),
        changes=tuple(in_words(point) for point in asked),
        status=tuple(finding.status for finding in found),
        error=np.array([finding.error for finding in found]),
        audit=np.array([finding.audit for finding in found]),
        reference=tuple(finding.reference for finding in found),
        reason=tuple(finding.reason for finding in found),
    )


def in_words(point: Point) -> str:
    """The parameters changed, as name=value; ..."""
    return "; ".join(f"{name}={value if isinstance(value, str) else f'{value:g}'}" for name, value in point.changes)
