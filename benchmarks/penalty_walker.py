"""The compiled penalty walker against Exudyn: how far apart they are, and what each takes, on drawn contact sets.

    python benchmarks/penalty_walker.py [SETS [SEED]]

Twenty sets for each law of the normal force, drawn by a seed, hard ones among them. Of each: the distance over one step
(allowed: 1e-9 m) and between solved cycles (allowed: three times the larger own error), and of some the distance over
ten steps (the same). Then, in the same run, processor times at settings of about equal error: one step, the step with
its derivative, and a solved cycle with its multipliers; and what the gait's derivatives by all numbers of design, slope
and ground take, exact and by extrapolated differences of steps.
"""

import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from pipeline.study import locate
from stages.biped.walk import StanceState
from stages.contact_study.parameters import Parameters
from stages.ground.laws import NORMAL_FORCES
from stages.multibody.parameters import Settings as ExudynSettings
from stages.multibody.walking.cycle import SectionWalker
from stages.multibody.walking.walk import build, simulate as exudyn_walk
from stages.penalty.model.changes import changes_of, names_of
from stages.penalty.step_map import PenaltyStepper, changed, responses
from stages.penalty.walk import Settings, simulate
from stages.planar.limit_cycle import gait_near
from stages.planar.run import rolling_state
from stages.planar.section import NoLimitCycle, section_numbers
from stages.studies.result import Distance
from stages.studies.walks import Machine, between_cycles, hip_distance, over_a_walk
from tests.penalty.drawn import drawn_sets

#: Close to the gait's mid-stance; the numbers are no result of the study.
START, FORCE = StanceState(0.0, 0.331, 0.27, 0.334, 0.71, 0.0, 1.8, 0.0), 9.4
LONG_WALKS, LONG = 3, 10
#: Tolerances of about equal error of the hip over a step, which is printed beside the times.
OURS, EXUDYN, LARGEST_STEP = 1e-8, 1e-7, 1e-3


def distances(given: Parameters, law: str, sets: int, seed: int) -> list[Distance]:
    """All distances of one law of the normal force."""
    found = []
    for number, contact in enumerate(drawn_sets(given.contact, seed, sets, law)):
        machine = Machine(given.biped, given.slope, contact)
        start = rolling_state(given.biped, contact, START, FORCE)
        found.append(over_a_walk("one step", machine, start))
        if number < LONG_WALKS:
            found.append(over_a_walk("ten steps", machine, start, LONG))
        try:
            near = gait_near(PenaltyStepper(given.biped, given.slope, contact, start, Settings(1e-9)), start)
            found.append(between_cycles("cycle", machine, start, near.section_state))
        except NoLimitCycle as reason:
            print(f"  no cycle: {reason}")
    return found


def seconds(function: Callable[[], Any], rounds: int) -> float:
    """Processor time of one call, the best of several."""
    spent = []
    for _ in range(rounds):
        began = time.process_time()
        function()
        spent.append(time.process_time() - began)
    return min(spent)


def times(given: Parameters) -> None:
    """Both engines on the contact set of ground.yaml."""
    model = given.biped, given.slope, given.contact
    start = rolling_state(given.biped, given.contact, START, FORCE)
    machine, ours = Machine(*model), Settings(OURS)
    other = ExudynSettings.of_one_step(EXUDYN, LARGEST_STEP)
    built = build(*model, other, signals=())
    stepper, walker = PenaltyStepper(*model, start, ours), SectionWalker(*model, start, other, 5e-4)
    numbers = section_numbers(start)
    truth = machine.compiled(start, 1e-13, 1, None)
    walks = simulate(*model, start, ours, signals=()), exudyn_walk(*model, start, other, steps=1, assembly=built)
    errors = [hip_distance(run, truth) for run in walks]
    rows: list[tuple[str, Callable[[], Any], Callable[[], Any]]] = [
        ("one step, recorded", lambda: simulate(*model, start, ours, signals=()),
         lambda: exudyn_walk(*model, start, other, steps=1, assembly=built)),
        ("derivative of the step map", lambda: stepper.derivative(numbers), lambda: walker.derivative(numbers)),
        ("cycle and multipliers", lambda: gait_near(stepper, start),
         lambda: gait_near(SectionWalker(*model, start, other, 5e-4), start)),
    ]  # fmt: skip
    print(f"\nhip error over a step: compiled at {OURS:g} {errors[0]:.1e} m, Exudyn at {EXUDYN:g} {errors[1]:.1e} m")
    print(f"{'':30}{'compiled [ms]':>15}{'Exudyn [ms]':>15}{'ratio':>9}")
    for name, compiled, exudyn in rows:
        compiled()
        one, two = seconds(compiled, 10), seconds(exudyn, 2)
        print(f"{name:30}{1e3 * one:15.2f}{1e3 * two:15.1f}{two / one:9.0f}", flush=True)


def derivatives(given: Parameters) -> None:
    """Period and step length of the gait by every number: one step with variations, or eight steps for each number.

    Differences walk to the gait of each changed walker in first order: four steps tell how the section's numbers move,
    four from there how period and length do.
    """
    model = given.biped, given.slope, given.contact
    start = rolling_state(given.biped, given.contact, START, FORCE)
    gait = gait_near(PenaltyStepper(*model, start, Settings(1e-12)), start)
    names = names_of(*model)

    def by_differences() -> np.ndarray:
        left, found = np.linalg.inv(np.eye(10) - gait.monodromy_matrix), []
        scales = changes_of(*model, names).scales

        def slope(name: str, scale: float, moved: np.ndarray) -> np.ndarray:
            rates = []
            for share in (2e-4, 1e-4):
                ends = []
                for by in (share, -share):
                    stepper = PenaltyStepper(*changed(*model, name, by * scale), start, Settings(1e-13))
                    step = stepper.step(gait.section_state + by * moved)
                    ends.append(np.array([*step.numbers, np.log(step.duration), np.log(step.length)]))
                rates.append((ends[0] - ends[1]) / (2 * share))
            return np.asarray((4 * rates[1] - rates[0]) / 3)

        for name, scale in zip(names, scales, strict=True):
            moved = left @ slope(name, scale, np.zeros(10))[:10]
            found.append(slope(name, scale, moved)[10:])
        return np.array(found)

    def exact() -> np.ndarray:
        return responses(*model, start, gait, names).elasticities()

    apart = np.abs(exact() - by_differences()).max()
    one, two = seconds(exact, 5), seconds(by_differences, 2)
    print(f"\n{len(names)} numbers, elasticities of period and length: exact {1e3 * one:.0f} ms, by differences "
          f"{1e3 * two:.0f} ms, {two / one:.1f} times as long; {apart:.1e} apart")  # fmt: skip


def main() -> None:
    sets, seed = (int(text) for text in (*sys.argv[1:3], *(20, 20)[len(sys.argv) - 1 :]))
    given = locate().parameters(["contact_study"])["contact_study"]
    print(f"{'law, what':24}{'number':>7}{'median [m]':>12}{'largest [m]':>13}{'of allowed':>12}{'not fine':>10}")
    for law in NORMAL_FORCES:
        found = distances(given, law, sets, seed)
        for what in dict.fromkeys(one.what for one in found):
            own = [one for one in found if one.what == what]
            sizes, shares = [one.distance for one in own], [one.distance / one.allowed for one in own]
            print(f"{law + ', ' + what:24}{len(own):7}{np.median(sizes):12.1e}{max(sizes):13.1e}{max(shares):12.2f}"
                  f"{sum(not one.fine for one in own):10}", flush=True)  # fmt: skip
    times(given)
    derivatives(given)


if __name__ == "__main__":
    main()
