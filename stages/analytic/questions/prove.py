"""`prove`: a gait exists, is alone in a ball, and is stable or not, as a theorem."""

from __future__ import annotations

import json
import math
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stages.biped.quantity import count_of
from stages.biped.question import Answer, Asking, Question, WrongOption, option, refuse

if TYPE_CHECKING:
    from stages.analytic.gait.poincare import FixedPoint
    from stages.analytic.model.walker import Walker
    from stages.analytic.parameters import Parameters
    from stages.biped.design import Biped
    from stages.ground.slope import Slope

#: Tolerance of the study's gait, and the part by which its period differs from the proven one's at most.
TOLERANCE, SAME_GAIT = 1e-12, 1e-8
STABLE = {True: "stable: all multipliers lie inside the unit circle", None: "not decided",
          False: "unstable: a multiplier lies outside the unit circle"}  # fmt: skip


@dataclass(frozen=True)
class Options:
    """Options of `prove`."""

    check: Path | None = option("-", "Confirm this proof file, from its design and centre alone", default=None)
    file: Path | None = option("-", "Write the proof file", default=None)
    cycle: bool = option("-", "The stable cycle of 2, 4 or 8 steps beside an unstable gait", default=False)


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Prove the study's gait, or confirm a proof file. Raises NotProven and NoGait."""
    require_flint()
    biped, slope = of = parameters.biped, parameters.slope
    with asking.new_file(options.file) if options.file else nullcontext() as path:
        if options.check is not None:
            of, content, found = confirmed(options.check, asking)
        else:
            refuse_rough(biped, parameters.limited_friction is not None)
            found = proven(biped, slope, *study_gait(biped, slope, options.cycle), asking)
            content = (json.dumps(found, indent=1) + "\n").encode()
        if path is not None:
            path.write_bytes(content)
    if of == (biped, slope) and found["says"]:
        asking.keep(content)
    many = count_of(found["steps"], "step")
    return Answer([
        "proven" if options.check is None else f"{options.check} is confirmed",
        f"a gait of {many} exists, the only one within {found['radius']} (m, rad, and per second) of the centre; "
        f"{STABLE[found['stable']]}", f"phases: {', '.join(found['phases'])}",
        *(f"{name}: {low} .. {high}" for name, (low, high) in found["enclosures"].items()),
    ], found)  # fmt: skip


def require_flint() -> None:
    """Refuse to prove without ball arithmetic. Raises WrongOption."""
    try:
        import flint  # noqa: F401
    except ImportError:
        raise WrongOption("to prove, python-flint is needed: pip install 'bipedstudy[proof]'") from None


def refuse_rough(biped: Biped, limited: bool) -> None:
    """Refuse kinds of walkers whose motion is not smooth between events. Raises WrongOption."""
    rest = "; prove knows feet that roll, without friction at the hip, which land by themselves"
    refuse((limited, f"analytic.transition = coulomb is not proven{rest}"),
           (biped.hip_friction > 0, f"biped.hip_friction = {biped.hip_friction:g} N m is not proven{rest}"),
           (biped.strike_time is not None, f"biped.strike_time = {biped.strike_time} s is not proven{rest}"))


def study_gait(biped: Biped, slope: Slope, cycle: bool) -> tuple[Walker, FixedPoint]:
    """The study's gait. Raises NoGait."""
    from stages.analytic.errors import NoGait
    from stages.analytic.gait.gait_search import find_gait
    from stages.analytic.gait.poincare import find_cycle

    walker, point = find_gait(biped, slope, TOLERANCE, None)
    if cycle:
        other = find_cycle(walker, point.z, TOLERANCE)
        if other is None:
            raise NoGait("there is no stable cycle of 2, 4 or 8 steps beside the gait")
        point = other
    return walker, point


def proven(biped: Biped, slope: Slope, walker: Walker, point: FixedPoint, asking: Asking) -> dict[str, Any]:
    """The content of the proof file of a gait. Raises NotProven."""
    from stages.analytic.phases.section import section_state
    from stages.proof.flow import NotProven
    from stages.proof.theorem import CENTRES, RADIUS, prove

    state, period = section_state(point.z, walker.p)[: walker.size] * walker.scales(), point.period * walker.time
    guess, steps = [repr(each) for each in state.tolist()], len(point.steps)
    found = prove(biped, slope, guess, RADIUS, steps, CENTRES, asking.progress)
    for end in map(float, found["enclosures"]["period_s"]):
        if not math.isclose(period, end, rel_tol=SAME_GAIT):
            raise NotProven(f"what was proven is another gait: period {end:.9g} s, and the study's is {period:.9g} s")
    return found


def confirmed(path: Path, asking: Asking) -> tuple[tuple[Biped, Slope], bytes, dict[str, Any]]:
    """Design and content of a proof file that a proof made anew confirms. Raises NotProven where it does not."""
    from stages.proof.theorem import confirm, prove, read

    try:
        content = path.read_bytes()
    except OSError as error:
        raise WrongOption(f"--check {path}: {error.strerror}") from None
    biped, slope, given = read(content, str(path))
    refuse_rough(biped, False)
    centre = list(given["centre"].values())
    confirm(given, prove(biped, slope, centre, given["radius"], given["steps"], 1, asking.progress), str(path))
    return (biped, slope), content, given


QUESTION = Question(
    "prove",
    """Prove that the gait of the design in params/ exists, is the only one in a ball, and is stable or unstable.

    It needs python-flint (the extra [proof]). See docs/proof.md.
    """,
    Options,
    ask,
    key="proof",
    examples=("bipedstudy prove --file proof.json", "bipedstudy prove --check proof.json"),
)
