"""The prover: its equations against the derivation's, its enclosures against known answers, and what it must refuse."""

import json
import sys
import time
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import StudyError
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.model.walker import build_walker
from stages.analytic.parameters import Parameters, Settings
from stages.analytic.phases.impact import heel_strike_reset
from stages.analytic.phases.motion import DOUBLE_STANCE, RIGID, SINGLE_STANCE, accelerations
from stages.analytic.questions import prove as question
from stages.biped.accuracy.scales import SI
from stages.biped.question import WrongOption
from stages.ground.slope import Slope
from tests.analytic.designs import FRICTION, RUBBER, SLOPE, TABLE_1, TABLE_1_RIGID, changed, clearance
from tests.asking import Asking

flint = pytest.importorskip("flint", reason="python-flint is not installed: pip install 'bipedstudy[proof]'")

from stages.proof import equations, flow, theorem, walk  # noqa: E402 - they need python-flint
from stages.proof.flow import NotProven  # noqa: E402

STORED = Path(__file__).with_name("table_1.json")
STUDY = Parameters(TABLE_1, SLOPE, FRICTION, RUBBER, Settings(tolerance=1e-10, steps=2, sampling_rate_hz=100.0))
DETAILS = {
    "leg_inertia": 1e-3, "foot_offset": 0.01, "frame_mass": 0.1, "frame_com": 0.05, "frame_offset": 0.02,
    "frame_inertia": 2e-4, "hip_stiffness": 0.7, "hip_damping": 0.02, "hip_rest_angle": 0.1, "hip_gravity_mass":
    0.3, "other_foot_mass": 0.3, "other_foot_radius": 0.09, "other_frame_com": 0.02,
    "other_leg_length": 0.32}  # fmt: skip
#: Slope at which the largest multiplier of Table 1's rigid biped is -1.0001, and one at which it is -1.038.
BARELY_UNSTABLE, UNSTABLE = 3.3631770623988606, 3.5


def test_a_file_that_is_there_is_refused_before_anything_is_proven(tmp_path):
    asking, place = Asking(), tmp_path / "proof.json"
    place.touch()
    with pytest.raises(StudyError, match="is there already, and is not replaced"):
        question.ask(STUDY, question.Options(file=place), asking)
    assert not asking.fractions


def proven(biped, slope, cycle=False):
    """The content of a proof file of the study's gait."""
    return question.proven(biped, slope, *question.study_gait(biped, slope, cycle), Asking())


@pytest.mark.parametrize("legs", ["compliant", "rigid"])
@pytest.mark.parametrize("details", [{}, DETAILS])
def test_equations_of_points_are_those_of_the_derivation(legs, details):
    biped = changed(TABLE_1, legs=legs, **details)
    walker = build_walker(biped, SLOPE)
    machine, scales, size = equations.Machine.of(biped, SLOPE, SI), walker.scales(), walker.size
    rng = np.random.default_rng(1)
    for _ in range(3):
        state = np.array([0.2, 0.33, 0.25, 0.328, 1.7, 0.1, -2.0, 0.2]) * (1 + 0.1 * rng.standard_normal(8))
        state = state[::2] if legs == "rigid" else state
        own = [flint.arb(float(each)) for each in state]
        for both, phase in ((False, RIGID),) if legs == "rigid" else ((False, SINGLE_STANCE), (True, DOUBLE_STANCE)):
            found, _, trailing = equations.motion(machine, own, both)
            rates, loads = accelerations(phase, state / scales, walker.p)
            expected = np.array(rates)[[0, 2] if legs == "rigid" else slice(4)] * scales[size // 2 :] / walker.time
            assert [float(each) for each in found] == pytest.approx(expected, rel=1e-10)
            if both:
                assert float(trailing) == pytest.approx(loads[0] * walker.force, rel=1e-10)
        after = state / scales
        heel_strike_reset(after, walker.p, None)
        assert [float(each) for each in equations.strike(machine, own)] == pytest.approx(after * scales, rel=1e-10)


@pytest.mark.slow
def test_a_step_of_the_flow_holds_the_pendulum_and_its_derivative():
    """y'' = -sin y from rest at 1, by its energy and by mpmath, and its derivative by the start as a difference."""
    mpmath = pytest.importorskip("mpmath")
    mpmath.mp.dps = 40
    flint.ctx.prec = flow.BITS

    def field(y):
        return [y[1], -y[0].sin_cos()[0]]

    def end(start, time):
        return mpmath.odefun(lambda t, y: [y[1], -mpmath.sin(y[0])], 0, [mpmath.mpf(start), mpmath.mpf(0)])(time)

    polynomial = flow.expanded(field, [flint.arb(1), flint.arb(0)])
    found = flow.step(field, polynomial, flint.arb(0.0625), flow.column([flint.arb("1e-15")] * 2))
    time = mpmath.mpf(float(found.length))
    for ball, exact in zip(found.end.entries(), end(1, time), strict=True):
        assert ball.overlaps(flint.arb(mpmath.nstr(exact, 36))) and ball.rad() < flow.ERROR
    slope = (end(mpmath.mpf(1) + mpmath.mpf("1e-12"), time)[0] - end(1, time)[0]) / mpmath.mpf("1e-12")
    assert float(found.derivative[0, 0]) == pytest.approx(float(slope), abs=1e-10)
    assert float(found.derivative[0, 0].rad()) <= flow.BY_START


def matrix(rows, width=0.0):
    return flint.arb_mat(len(rows), len(rows), [flint.arb(each, width) for row in rows for each in row])


def test_multipliers_are_decided_only_where_the_discs_decide_it():
    flint.ctx.prec = flow.BITS
    turn = [[0.3, -0.9, 0.0], [0.9, 0.3, 0.0], [5.0, 1.0, 0.0]]
    stable, found = theorem.judged(matrix(turn))
    assert stable is True and found["largest_multiplier_size"].contains(flint.arb("0.9").sqrt())
    assert found["multiplier_1_real"].contains(flint.arb("0.3")) and len(found) == 5
    assert theorem.judged(matrix(turn, 0.2))[0] is None
    assert theorem.judged(matrix([[1.0001, 7.0], [0.0, 0.2]]))[0] is False
    assert theorem.judged(matrix([[1.0001, 7.0], [0.0, 0.2]], 1e-3))[0] is None


@pytest.mark.slow
def test_a_gait_on_legs_of_20_mm_is_proven():
    """Its rates are large in SI units, and derivatives were known to as much as lengths and times of that size are."""
    mass, length = 1e-3, 0.06
    powers = {"hip_mass": mass, "foot_mass": mass, "leg_length": length, "foot_radius": length, "foot_com": length,
              "stiffness": mass / length, "damping": mass / length**0.5}  # fmt: skip
    tiny = proven(changed(TABLE_1, **{name: by * getattr(TABLE_1, name) for name, by in powers.items()}), SLOPE)
    assert tiny["stable"] and float(tiny["enclosures"]["multiplier_1_real"][0]) == pytest.approx(0.64034, abs=1e-4)


@pytest.mark.parametrize("share, shown", [(0.1, True), (3.0, False)])
def test_all_that_the_centres_image_may_be_off_counts(share, shown, monkeypatch):
    """A made-up step that halves what a start is off, and whose end is known to a share of the ball's radius."""
    def step(made):
        carried = made.carried
        made.carried = carried._replace(s=carried.delta * flint.arb(share), by_start=carried.by_start / 2)

    monkeypatch.setattr(walk.Walk, "step", step)
    given = TABLE_1_RIGID, SLOPE, ["0.2", "0.3", "1.5", "-2"], theorem.RADIUS, 1, 1, lambda *_: None
    if shown:
        assert theorem.prove(*given)["stable"] is True
    else:
        with pytest.raises(NotProven, match="Krawczyk"):
            theorem.prove(*given)


@pytest.mark.parametrize("swing", [False, True])
@pytest.mark.parametrize("own", [True, False])
def test_a_leg_may_be_no_shorter_than_its_own_foot(own, swing):
    """Feet of 0.10 m under one leg, of 0.09 m under the other, and 0.095 m between foot and hip of one of them."""
    biped = changed(TABLE_1, other_foot_com=0.09)
    machine = equations.Machine.of(biped, SLOPE, SI)
    walked = walk.Walk(machine if own != swing else machine.exchanged, None, SI, lambda _: None, phases=["single"])
    lengths = (0.33, 0.095) if swing else (0.095, 0.33)
    state = [flint.arb(each) for each in (0.1, lengths[0], 0.1, lengths[1], 0.0, 0.0, 0.0, 0.0)]
    assert (walked.broken(state, last=False) == "a leg may be pressed down to its foot") == own


def test_decimals_are_rounded_outwards():
    for ball in (flint.arb("0.1", 1e-9), -flint.arb(2).sqrt(), flint.arb(3), flint.arb("-1e-7", 1e-12)):
        ends = [Fraction(int(m)) * Fraction(2) ** int(e) for m, e in (ball.lower().man_exp(), ball.upper().man_exp())]
        low, high = map(Fraction, theorem.outward(ball))
        assert low <= ends[0] <= ends[1] <= high
        assert high - low <= 3 * Fraction(float(ball.rad()) * 2) + Fraction(1, 10**39)


def stored():
    return json.loads(STORED.read_text())


def test_the_stored_proof_holds_the_studys_gait():
    """Table 1 at tolerance 1e-13: period, state after heel strike and multipliers."""
    from stages.analytic.gait.poincare import fixed_point
    from stages.analytic.phases.section import section_state

    walker, point = find_gait(TABLE_1, SLOPE, 1e-10)
    point = fixed_point(walker, point.z, 1e-13)
    state = section_state(point.z, walker.p) * walker.scales()
    found = stored()["enclosures"]
    named = dict(zip(theorem_names(), state, strict=True))
    for name, value in {"period_s": point.period * walker.time, **named}.items():
        low, high = map(float, found[name])
        assert low - 5e-13 < value < high + 5e-13
    for place in (1, 2):
        low, high = map(float, found[f"multiplier_{place}_real"])
        assert low < point.floquet_multipliers[place - 1].real < high


def theorem_names():
    return list(stored()["centre"])


def test_an_independent_integrator_comes_back_to_the_stored_gait():
    """SciPy's DOP853 from the file's centre, over both phases and the strike."""
    from scipy.integrate import solve_ivp

    walker, told = build_walker(TABLE_1, SLOPE), stored()
    start = np.array([float(each) for each in told["centre"].values()]) / walker.scales()
    state, period = start, 0.0
    for phase in (DOUBLE_STANCE, SINGLE_STANCE):

        def rates(_, y, phase=phase):
            return [*y[4:], *accelerations(phase, y, walker.p)[0]]

        def guard(_, y, phase=phase):
            if phase == DOUBLE_STANCE:
                return accelerations(phase, y, walker.p)[1][0]
            return clearance(y, walker.p)[0]

        guard.direction = -1
        found = solve_ivp(rates, (0.0, 4.0), state, "DOP853", events=guard, rtol=1e-13, atol=1e-15)
        place = next(i for i, y in enumerate(found.y_events[0])
                     if phase == DOUBLE_STANCE or clearance(y, walker.p)[2] > 0)  # fmt: skip
        state, period = found.y_events[0][place], period + found.t_events[0][place]
    after = state.copy()
    heel_strike_reset(after, walker.p, None)
    assert after == pytest.approx(start, abs=1e-11)
    low, high = map(float, told["enclosures"]["period_s"])
    assert low - 1e-12 < period * walker.time < high + 1e-12


def test_what_a_file_says_is_confirmed_by_a_proof_made_anew_alone():
    told = stored()
    theorem.confirm(told, stored(), "proof.json")
    for name, (low, high) in told["enclosures"].items():
        narrow, middle = stored(), (Fraction(low) + Fraction(high)) / 2
        half = (Fraction(high) - Fraction(low)) / 2000
        narrow["enclosures"][name] = [f"{float(middle - half):.40f}", f"{float(middle + half):.40f}"]
        with pytest.raises(NotProven, match=f"not confirmed.* {name} "):
            theorem.confirm(narrow, stored(), "proof.json")
    for change in ({"phases": told["phases"][::-1]}, {"stable": False}, {"says": {}}, {"enclosures": {}}):
        with pytest.raises(NotProven, match=f"not confirmed: its {next(iter(change))}"):
            theorem.confirm({**told, **change}, stored(), "proof.json")


@pytest.mark.parametrize("change, part", [
    (lambda told: told.pop("radius"), "and the keys"),
    (lambda told: told.update(kind="another"), "is no proof file"),
    (lambda told: told.update(radius="1e-16 +/- 1"), "are decimals, as text"),
    (lambda told: told["biped"].update(hip_mass=-1.0), "no design may have"),
    (lambda told: told["biped"].update(knees=2), "unexpected keyword"),
    (lambda told: told.update(steps=3), "allowed: 1, 2, 4 or 8"),
])  # fmt: skip
def test_a_file_that_is_no_proof_is_refused_in_a_sentence(change, part):
    told = stored()
    change(told)
    with pytest.raises(WrongOption, match=part):
        theorem.read(json.dumps(told).encode(), "proof.json")
    assert set(theorem.KEYS) == set(stored())


@pytest.mark.parametrize("key, change, limited", [
    ("transition", {}, True), ("hip_friction", {"hip_friction": 0.01}, False),
    ("strike_time", {"legs": "rigid", "feet_retract": True, "strike_time": 0.5}, False),
])  # fmt: skip
def test_kinds_that_are_not_smooth_are_refused_by_name(key, change, limited):
    with pytest.raises(WrongOption, match=key):
        question.refuse_rough(changed(TABLE_1, **change), limited)


def test_without_python_flint_one_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "flint", None)
    with pytest.raises(WrongOption, match=r"pip install 'bipedstudy\[proof\]'"):
        question.ask(STUDY, question.Options(), Asking())


@pytest.mark.slow
def test_table_1_is_proven_and_the_stored_file_confirmed():
    asking, started = Asking(), time.process_time()
    found = proven(TABLE_1, SLOPE)
    assert time.process_time() - started < 90
    assert found["stable"] is True and found["phases"] == ["double stance", "single stance"]
    answer = question.ask(STUDY, question.Options(check=STORED), asking)
    assert "is confirmed" in answer.lines[0] and asking.kept == STORED.read_bytes()


def moved(told):
    told["centre"]["stance_angle"] = str(float(told["centre"]["stance_angle"]) + 1e-8)


def smaller(told):
    told["radius"] = "1e-19"


def swapped(told):
    told["phases"] = ["double stance", "single stance"]


@pytest.mark.slow
def test_a_changed_file_is_not_confirmed(tmp_path):
    """A file of rigid legs, whose proof takes a few seconds."""
    rightly = proven(TABLE_1_RIGID, SLOPE)
    for change, reason in ((lambda told: None, ""), (moved, "Krawczyk"), (smaller, "Krawczyk"),
                           (swapped, "phases")):  # fmt: skip
        told = json.loads(json.dumps(rightly))
        change(told)
        path = tmp_path / "proof.json"
        path.write_text(json.dumps(told))
        if not reason:
            assert question.confirmed(path, Asking())[2] == rightly
            continue
        with pytest.raises(NotProven, match=reason):
            question.confirmed(path, Asking())


@pytest.mark.parametrize("slope, steps, stable", [
    (BARELY_UNSTABLE, 1, False), pytest.param(2.0, 1, True, marks=pytest.mark.slow),
    pytest.param(UNSTABLE, 1, False, marks=pytest.mark.slow), pytest.param(UNSTABLE, 2, True, marks=pytest.mark.slow)])
def test_gaits_of_rigid_legs_and_a_cycle_past_the_doubling_are_proven_stable_or_unstable(slope, steps, stable):
    found = proven(TABLE_1_RIGID, Slope(slope, 9.81), cycle=steps == 2)
    assert found["stable"] is stable and found["steps"] == steps


def turned(point, machine):
    """The swing foot's Coriolis acceleration, here what its leg's turning adds along it, with its sign turned."""
    return point._replace(bias=(-point.bias[0], -point.bias[1]))


def left_out(point, machine):
    """The swing foot without its weight."""
    return point._replace(weight=0 * point.weight)


@pytest.mark.slow
@pytest.mark.parametrize("mutant", [turned, left_out])
def test_with_wrong_equations_the_studys_gait_is_not_proven(mutant, monkeypatch):
    rightly = equations.kinematics

    def wrongly(machine, q, v):
        points, centre = rightly(machine, q, v)
        return [*points[:2], mutant(points[2], machine), *points[3:]], centre

    monkeypatch.setattr(equations, "kinematics", wrongly)
    parameters = Parameters(TABLE_1_RIGID, SLOPE, FRICTION, RUBBER,
                            Settings(tolerance=1e-10, steps=2, sampling_rate_hz=100.0))  # fmt: skip
    with pytest.raises(NotProven):
        question.ask(parameters, question.Options(), Asking())


@pytest.mark.slow
def test_a_strike_ahead_of_the_last_is_seen(monkeypatch):
    """A foot that is counted as ahead from the start has its strike where it scuffs."""
    rightly = walk.foot

    def ahead(machine, state):
        height, advance, length = rightly(machine, state)
        return height, advance * advance + 1, length

    monkeypatch.setattr(walk, "foot", ahead)
    with pytest.raises(NotProven, match="the hip is not between the feet"):
        proven(TABLE_1_RIGID, SLOPE)
    crossing = walk.Walk.crossing

    def last_alone(self, table, length):
        return crossing(self, table, length) if float(self.time) * self.scales.time > 0.4 else None

    monkeypatch.setattr(walk.Walk, "crossing", last_alone)
    with pytest.raises(NotProven, match="the swing foot may strike before"):
        proven(TABLE_1_RIGID, SLOPE)
