"""Comparison stage: how far all sources agree, determinants of gait, and the paper's claims with verdicts.

Inputs: the results of the models, of their studies and of the ingest. Settings: params/comparison.yaml. Outputs:
`Result`, claims.yaml.
"""

import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from stages.biped.processes import Progress, ignore
from stages.biped.quantity import written_out
from stages.biped.walk import require
from stages.comparison.claims.judge import another_biped, judge
from stages.comparison.claims.numerics import constraints_reduce_effort
from stages.comparison.claims.paper import FREQUENCY_HZ
from stages.comparison.determinants import Determinants, digits_of, of_walk
from stages.comparison.evidence import NAN, Evidence, Inputs, known
from stages.comparison.made_again import as_both_have_it
from stages.comparison.parameters import Parameters
from stages.comparison.result import DOES_NOT_APPLY, BipedSummary, Claim, Result, counted, tables_of
from stages.comparison.tables import Table
from stages.imu.result import stepping


def summarise(e: Evidence) -> BipedSummary:
    """The summary of the study's biped."""
    analytic, validity = e.results.analytic, e.results.analytic.validity
    models, twin, effort = known(lambda: e.models), known(lambda: e.twin), known(lambda: constraints_reduce_effort(e))
    error, constraint_work, penalty_work, *_ = effort if effort is not None else (NAN,) * 3
    limit, ladder = known(lambda: e.results.contact_study.limit), known(lambda: e.results.twin_ladder)
    return BipedSummary(
        analytic.gait.step_frequency_hz,
        analytic.gait.step_length_m,
        abs(analytic.numerical_error.period),
        analytic.numerical_error.hip_position,
        models.period_difference if models is not None else NAN,
        models.step_length_difference if models is not None else NAN,
        float(limit.hard.hip_position.max()) if limit is not None else NAN,
        float(models.same_start.position.max()) if models is not None else NAN,
        twin.step_frequency if twin is not None else NAN,
        analytic.gait.largest_multiplier,
        ladder.largest_multipliers[0] if ladder is not None else NAN,
        validity.friction_single_stance,
        max(validity.impulse_friction_landing, validity.impulse_friction_trailing),
        e.parameters.contact.coefficients.static_friction,
        math.sin(e.parameters.slope.angle),
        constraint_work,
        penalty_work,
        error,
    )


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Compare and judge; what a claim lacks it says in place of its numbers.

    Raises NotRecorded if a walk lacks a signal, NoEvidence without the constraint model.
    """
    for name in {"multibody", "twin"}.difference(inputs.missing):
        walk = getattr(inputs, name).walk
        require(name, {"ground_reaction": walk.ground_reaction, "imu": walk.hip_specific_force})
    if "multibody" not in inputs.missing:
        require("multibody", {"slip": inputs.multibody.slip_velocity})
    e = Evidence(parameters, inputs)
    models, twin = known(lambda: e.models), known(lambda: e.twin)
    measured, score = known(lambda: e.measured), known(lambda: e.ingest)
    progress(0.8, "judging the claims")
    determined, biped, level = determinants(e), summarise(e), parameters.level.level
    models_alone = {name: one for name, one in determined.items() if not name.startswith("runs")}
    digits = digits_of(e.results.analytic.uncertainties, models_alone)
    both = as_both_have_it(inputs)
    claims = judge(e, both and (Evidence(parameters, both[0]), Evidence(parameters, both[1])))
    tables = tables_of(biped, determined, digits)
    files = {"claims.yaml": as_yaml(claims, tables, headlines(biped, determined, claims), level, biped)}
    another = another_biped(parameters)
    return Result(models, twin, measured, score, determined, digits, biped, another, claims, level, files)


def again(parameters: Parameters, inputs: Inputs, result: Result) -> tuple[Result, Result]:
    """What is compared, and the same by closer solvers, of synthetic runs those alone that these made once more."""
    one, other = as_both_have_it(inputs) or (inputs, inputs)
    return run(parameters, replace(one, closer=None)), run(parameters, replace(other, closer=None))


def determinants(e: Evidence) -> dict[str, Determinants]:
    """Determinants of all models; of the runs, which have no walk but heel strikes, only what these show."""
    biped, gravity, layer = e.parameters.biped, e.parameters.slope.gravity, e.parameters.twin.outsole

    def of(name: str, layer: float = 0.0) -> Determinants | None:
        radii, lengths = np.array([biped.foot_radii, biped.leg_lengths]) + layer
        return known(lambda: of_walk(getattr(e.results, name).walk, radii, lengths, gravity))

    measured = known(lambda: e.measured)
    found = {
        "constraint model": of("analytic"),
        "multibody model": of("multibody"),
        "twin": of("twin", layer),
        f"runs ({measured.origin if measured else ''})":
            Determinants(step_frequency=measured.step_frequency)
            if measured and stepping(e.results.imu.runs) else None,
    }
    return {name: one for name, one in found.items() if one is not None}


def headlines(biped: BipedSummary, determined: Mapping[str, Determinants], claims: Sequence[Claim]) -> list[str]:
    """How fast, how stable, how far the models agree, how the claims come out: a sentence each, from the results."""
    judged = all(claim.verdict != DOES_NOT_APPLY for claim in claims)
    found = {name: one.step_frequency for name, one in determined.items() if math.isfinite(one.step_frequency)}
    spread = 100.0 * (max(found.values(), default=1.0) / min(found.values(), default=1.0) - 1.0)
    listed = ", ".join(f"{name} {frequency:.3f} Hz" for name, frequency in found.items())
    stable, twins = ("stable" if each < 1 else "unstable" for each in (biped.multiplier, biped.twin_multiplier))
    other = math.isfinite(biped.twin_multiplier) and stable != twins
    return [
        f"The robot takes {biped.step_frequency:.4f} steps a second"
        f"{f'; the paper has {FREQUENCY_HZ:g}' if judged else ''}.",
        f"Its gait is {stable}: a small disturbance {'shrinks' if biped.multiplier < 1 else 'grows'} to "
        f"{biped.multiplier:.2f} of its size with each step"
        f"{f'; the twin of it is {twins}, with {biped.twin_multiplier:.2f} in the plane' * other}.",
        *([f"Step frequencies differ by at most {written_out(spread, 2)} %: {listed}."] if len(found) > 1 else []),
        f"The paper's claims, judged by these results: {counted([claim.verdict for claim in claims])}.",
    ]


def as_yaml(
    claims: Sequence[Claim], tables: Iterable[Table], headlines: Sequence[str], level: str, biped: BipedSummary
) -> bytes:
    """All of it as YAML, a claim's part a line; the verdicts counted and the biped's numbers are what DVC compares."""
    lines = ["# Generated by the comparison stage: the paper's claims against this study.", f"level: {quoted(level)}",
             "headlines:"]  # fmt: skip
    lines += [f"- {quoted(sentence)}" for sentence in headlines]
    lines.append("claims:")
    for claim in claims:
        printed = {**asdict(claim), "numbers": [str(number) for number in claim.numbers]}
        parts = [f"{key}: {quoted(value)}" for key, value in printed.items()]
        lines += [f"- {parts[0]}", *(f"  {part}" for part in parts[1:])]
    lines.append("tables:")
    for title, columns, rows in tables:
        lines += [f"- title: {quoted(title)}", f"  columns: {quoted(columns)}", "  rows:"]
        lines += [f"  - {quoted(row)}" for row in rows]
    verdicts = sorted(Counter(claim.verdict for claim in claims).items())
    lines += ["verdicts:", *(f"  {quoted(verdict)}: {count}" for verdict, count in verdicts)]
    lines += ["numbers:", *(f"  {name}: {decimal(value)}" for name, value in asdict(biped).items()
                            if math.isfinite(value))]  # fmt: skip
    return ("\n".join(lines) + "\n").encode()


def decimal(value: float) -> str:
    """A number with a point, without which some readers of YAML take 3e-10 for a word."""
    text = repr(float(value))
    return text if "." in text else text.replace("e", ".0e")


def quoted(value: Any) -> str:
    """A text, or a list of texts."""
    return json.dumps(value, ensure_ascii=False)
