"""`prove`: a gait exists, is alone in a ball, and is stable or not, as a theorem."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stages.biped.question import Answer, Asking, Question, WrongOption, option, refuse

if TYPE_CHECKING:
    from stages.analytic.parameters import Parameters
    from stages.biped.design import Biped
    from stages.ground.slope import Slope

#: The study's gait is integrated to this tolerance; and the proof is of that gait if periods differ by less than this
#: part.
TOLERANCE, SAME_GAIT = 1e-12, 1e-8
#: About so many steps of time are made for a step of the walk.
ABOUT = 70


@dataclass(frozen=True)
class Options:
    """Options of `prove`."""

    check: Path | None = option("-", "Confirm this proof file, from its design and centre alone", default=None)
    file: Path | None = option("-", "Write the proof file", default=None)
    cycle: bool = option("-", "The stable cycle of 2, 4 or 8 steps beside an unstable gait", default=False)


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Prove the study's gait, or confirm a proof file. Raises NotProven and NoGait."""
    try:
        import flint  # noqa: F401
    except ImportError:
        raise WrongOption("to prove, python-flint is needed: pip install 'bipedstudy[proof]'") from None
    from stages.proof.flow import NotProven

    if options.check is not None:
        return confirmed(options.check, asking)
    biped, slope = parameters.biped, parameters.slope
    refuse_rough(biped, parameters.limited_friction is not None)
    guess, steps, period = study_gait(biped, slope, options.cycle)
    found = proven(biped, slope, guess, steps, asking)
    low, high = map(float, found["enclosures"]["period_s"])
    if not math.isclose(period, low, rel_tol=SAME_GAIT) or not math.isclose(period, high, rel_tol=SAME_GAIT):
        raise NotProven(f"what was proven is another gait: period {low:.9g} s, and the study's is {period:.9g} s")
    if options.file is not None:
        with asking.new_file(options.file) as path:
            path.write_text(json.dumps(found, indent=1) + "\n")
    return Answer(list(lines(found)), found)


def refuse_rough(biped: Biped, limited: bool) -> None:
    """Refuse kinds of walkers whose motion is not smooth between events. Raises WrongOption."""
    rest = "; prove knows feet that roll, without friction at the hip, which land by themselves"
    refuse((limited, f"analytic.transition = coulomb is not proven{rest}"),
           (biped.hip_friction > 0, f"biped.hip_friction = {biped.hip_friction:g} N m is not proven{rest}"),
           (biped.strike_time is not None, f"biped.strike_time = {biped.strike_time} s is not proven{rest}"))


def study_gait(biped: Biped, slope: Slope, cycle: bool) -> tuple[list[float], int, float]:
    """State after heel strike of the study's gait (SI units), its steps, and the mean step's period [s]."""
    from stages.analytic.errors import NoGait
    from stages.analytic.gait.gait_search import find_gait
    from stages.analytic.gait.poincare import find_cycle
    from stages.analytic.phases.section import section_state

    walker, point = find_gait(biped, slope, TOLERANCE, None)
    if cycle:
        other = find_cycle(walker, point.z, TOLERANCE)
        if other is None:
            raise NoGait("there is no stable cycle of 2, 4 or 8 steps beside the gait")
        point = other
    state = section_state(point.z, walker.p)[: walker.size] * walker.scales()
    return state.tolist(), len(point.steps), point.period * walker.time


def proven(biped: Biped, slope: Slope, guess: list[float], steps: int, asking: Asking) -> dict[str, Any]:
    """The content of the proof file of the gait near a guess. Raises NotProven."""
    from stages.proof.file import record
    from stages.proof.theorem import prove, refined

    centre, radius = refined(biped, slope, guess, steps, shown(asking, 2 * steps, 0.0))
    return record(biped, slope, steps, prove(biped, slope, centre, radius, steps, shown(asking, 2 * steps, 0.5)))


def shown(asking: Asking, steps: int, first: float) -> Callable[[int, str], None]:
    """What shows how far it has come, from the fraction `first`, by steps of time and phase."""
    return lambda done, phase: asking.progress(min(first + done / (ABOUT * steps), 0.99), phase)


def confirmed(path: Path, asking: Asking) -> Answer:
    """A proof file, confirmed by a proof made anew. Raises NotProven where it is not."""
    from stages.proof.file import read, record, unconfirmed, unlikely
    from stages.proof.flow import NotProven
    from stages.proof.theorem import prove
    from stages.proof.walk import DOUBLE_STANCE, SINGLE_STANCE

    try:
        content = path.read_bytes()
    except OSError as error:
        raise WrongOption(f"--check {path}: {error.strerror}") from None
    biped, slope, told = read(content, str(path))
    refuse_rough(biped, False)
    steps = told["steps"]
    expected = ([SINGLE_STANCE] if biped.legs == "rigid" else [DOUBLE_STANCE, SINGLE_STANCE]) * steps
    reason = unlikely(told, expected)
    if reason is None:
        try:
            theorem = prove(
                biped, slope, list(told["centre"].values()), told["radius"], steps, shown(asking, steps, 0.0))
            reason = unconfirmed(told, record(biped, slope, steps, theorem))
        except NotProven as failed:
            reason = str(failed)
    if reason is not None:
        raise NotProven(f"{path} is not confirmed: {reason}")
    return Answer([f"{path} is confirmed", *lines(told)], told)


def lines(found: dict[str, Any]) -> list[str]:
    """A proof file in words."""
    enclosed, steps = found["enclosures"], found["steps"]
    stable = {True: "stable: all multipliers lie inside the unit circle", None: "not decided",
              False: "unstable: a multiplier lies outside the unit circle"}[found["stable"]]  # fmt: skip
    said = [f"proven: a gait of {steps} step{'s' if steps > 1 else ''} exists, the only one within {found['radius']} "
            f"(m, rad, and per second) of the centre; {stable}",
            f"phases: {', '.join(found['phases'])}"]  # fmt: skip
    for name, (low, high) in enclosed.items():
        said.append(f"{name}: {low} .. {high}")
    return said


QUESTION = Question(
    "prove",
    """Prove that the gait of the design in params/ exists, is the only one in a ball, and is stable or unstable.

    It needs python-flint (the extra [proof]). See docs/proof.md.
    """,
    Options,
    ask,
    key="proof",
    examples=("bipedstudy prove --file proof.json", "bipedstudy prove --check proof.json",),
)
