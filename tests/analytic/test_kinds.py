"""What kind of walker it is stands in the type of its numbers, and decides what is compiled."""

from types import ModuleType

import numpy as np
import pytest
from numba.extending import is_jitted

from stages.analytic.compiled import ByKind, uncounted
from stages.analytic.integration.phase import walk_step
from stages.analytic.model.kinds import (
    Detailed,
    DetailedCompliant,
    DetailedRigid,
    PlainCompliant,
    PlainRigid,
    StiffDetailed,
    StiffPlain,
    exchange,
    present,
    with_legs_exchanged,
)
from stages.analytic.model.terms import exchanged
from stages.analytic.model.walker import build_walker
from stages.analytic.phases.motion import flow
from stages.analytic.phases.section import section_state
from tests import commands
from tests.analytic.designs import FRICTION, SLOPE, TABLE_1, TABLE_1_RIGID, changed

STIFF = changed(TABLE_1, damping=1e5)


@pytest.mark.parametrize("design, friction, kind, more", [
    (TABLE_1_RIGID, None, PlainRigid, ()), (TABLE_1_RIGID, FRICTION, PlainRigid, ()),
    (changed(STIFF, legs="rigid"), None, PlainRigid, ()),
    (TABLE_1, None, PlainCompliant, ()), (TABLE_1, FRICTION, PlainCompliant, ("mu_s", "mu_d")),
    (STIFF, None, StiffPlain, ()), (STIFF, FRICTION, StiffPlain, ("mu_s", "mu_d")),
    (changed(STIFF, frame_mass=0.01, frame_com=0.02), None, StiffDetailed, ()),
    (changed(STIFF, hip_friction=1e-3), None, DetailedCompliant, ("tau_h",)),
    (changed(TABLE_1_RIGID, hip_friction=1e-3), None, DetailedRigid, ("tau_h",)),
    (changed(TABLE_1_RIGID, feet_retract=True, strike_time=0.5), None, DetailedRigid, ("T",)),
])
def test_a_walker_has_the_type_and_the_numbers_that_its_design_needs(design, friction, kind, more):
    walker = build_walker(design, SLOPE, friction)
    assert type(walker.p) is kind
    assert walker.rigid == (kind in (PlainRigid, DetailedRigid)) and walker.rolls == ("mu_s" not in more)
    assert walker.stiff == (kind in (StiffPlain, StiffDetailed)) and walker.timed == ("T" in more)
    tail = 5 if walker.rigid else 6
    assert present(walker.p) == [*kind._fields[:-tail], *more]


@pytest.mark.parametrize("kind", [PlainRigid, PlainCompliant, DetailedRigid, DetailedCompliant, StiffDetailed])
def test_legs_are_exchanged_alike_by_both(kind):
    p = kind(*np.linspace(1.0, 2.0, len(kind._fields)).tolist())
    assert exchanged(p) == with_legs_exchanged(p) and type(exchanged(p)) is kind
    assert issubclass(kind, Detailed) == (with_legs_exchanged(p) != p)
    assert not issubclass(kind, Detailed) or len(set(exchange(kind._fields)[0])) == len(p)


def reached(function, kind, found):
    """All compiled functions that `function` calls for a kind of walker, directly or not, by module and name."""
    if isinstance(function, ByKind):
        function = function.of(kind)
    if is_jitted(function) and function not in found:
        found.add(function)
        names, known = function.py_func.__code__.co_names, function.py_func.__globals__
        modules = [known, *(vars(known[name]) for name in names if isinstance(known.get(name), ModuleType))]
        for module in modules:
            for name in names:
                reached(module.get(name), kind, found)
    return found


def of_module(functions, part):
    return {f.py_func.__name__ for f in functions if part in f.py_func.__module__}


def test_a_step_calls_only_what_its_kind_of_walker_needs():
    step = {kind: reached(walk_step, kind, set()) for kind in (PlainRigid, PlainCompliant, StiffPlain)}
    names = {kind: {f.py_func.__name__ for f in functions} for kind, functions in step.items()}
    assert {"compliant_rates", "strike"} <= names[PlainCompliant] & names[StiffPlain]
    assert not {name for name in names[PlainCompliant] if "rigid" in name}
    assert not {name for name in names[PlainRigid] if "compliant" in name or name == "strike"}
    assert of_module(step[StiffPlain], "radau") and not of_module(step[PlainCompliant], "radau")
    for functions in step.values():
        assert not of_module(functions, "detailed")


#: Directions of the numbers that the variations go along: none, and one.
DIRECTIONS = ("None", "directions(numpy.ones((1, 16)), 1)")
FLOWS = "lambda y, p, d: flow(1, y, p, y.copy(), d)"
STRIKES = "lambda y, p, d: succeed(1, y, p, d)"


def compiled_for(called, code):
    """Names of the functions compiled for each of `DIRECTIONS`, one after the other, in a process without machine code.
    """
    program = f"""
import sys
import numpy
from numba.extending import is_jitted
from stages.analytic.model.kinds import directions
from stages.analytic.phases.motion import flow
from stages.analytic.phases.succession import succeed
from tests.analytic.designs import walker_of
called = {called}
for d in ({", ".join(DIRECTIONS)}):
    called(numpy.array([0.28, 1.0, 0.27, 1.0, 0.5, 0.0, 0.4, 0.0] + 8 * [0.0]), walker_of().p, d)
    modules = [vars(module).values() for name, module in sys.modules.items() if name.startswith("stages")]
    functions = {{id(f): f for values in modules for f in values if is_jitted(f)}}.values()
    print(*sorted(f"{{f.__module__}}.{{f.__name__}}" for f in functions if f.stats.cache_misses))
"""
    done = commands.python(program, cwd=commands.HOME, NUMBA_CACHE_DIR=str(code))
    assert done.returncode == 0, done.stderr
    return map(str.split, done.stdout.splitlines())


@pytest.mark.slow
@pytest.mark.parametrize(("called", "needed"), [
    (FLOWS, "phases.motion.compliant_rates"), (STRIKES, "phases.impact.compliant_reset")])  # fmt: skip
def test_what_is_not_asked_for_is_not_compiled(called, needed, tmp_path):
    """Derivatives by the walker's numbers, unless variations go along them; what other legs need."""
    for names, asked in zip(compiled_for(called, tmp_path), (False, True), strict=True):
        assert f"stages.analytic.{needed}" in names
        assert any("_derivatives." in name for name in names) == asked
        assert not [name for name in names if "detailed" in name or "rigid" in name]


def test_numbers_of_no_kind_are_refused():
    with pytest.raises(TypeError, match="tuple is no kind of walker"):
        section_state(np.zeros(5), (1.0,) * 10)
    with pytest.raises(TypeError, match="no kind of walker"):
        flow(1, np.zeros(8), None, np.zeros(8))


@pytest.mark.parametrize("array", [np.arange(6.0).reshape(2, 3), np.arange(3), np.arange(4) * 1j])
def test_an_array_without_a_count_is_the_same_memory(array: np.ndarray) -> None:
    view = uncounted(array)
    assert (view.shape, view.dtype) == (array.shape, array.dtype)
    np.testing.assert_array_equal(view, array)
    view[-1] = 7
    np.testing.assert_array_equal(view, array)


def test_only_a_contiguous_array_can_be_without_a_count() -> None:
    with pytest.raises(AssertionError):
        uncounted(np.zeros((3, 4))[:, 1:3])
