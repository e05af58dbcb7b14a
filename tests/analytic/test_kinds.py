"""What kind of walker it is stands in the type of its numbers, and decides what is compiled."""

import os
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from numba.extending import is_jitted

from stages.analytic.compiled import ByKind
from stages.analytic.integration.step import walk_step
from stages.analytic.model.kinds import PlainLimited, PlainRigid, PlainRolling, StiffLimited, StiffRolling
from stages.analytic.model.walker import build_walker
from stages.analytic.phases.flow import flow
from stages.analytic.phases.section import section_state
from tests import warm
from tests.analytic.designs import FRICTION, SLOPE, TABLE_1, TABLE_1_RIGID, changed

STIFF = changed(TABLE_1, damping=1e5)


@pytest.mark.parametrize("design, friction, kind", [
    (TABLE_1_RIGID, None, PlainRigid), (TABLE_1_RIGID, FRICTION, PlainRigid),
    (changed(STIFF, legs="rigid"), None, PlainRigid),
    (TABLE_1, None, PlainRolling), (TABLE_1, FRICTION, PlainLimited),
    (STIFF, None, StiffRolling), (STIFF, FRICTION, StiffLimited),
])
def test_kind_of_walker_is_its_type(design, friction, kind):
    walker = build_walker(design, SLOPE, friction)
    assert type(walker.p) is kind
    assert walker.rigid == (kind is PlainRigid) and walker.rolls == (kind not in (PlainLimited, StiffLimited))


def test_no_kind_holds_numbers_it_does_not_need():
    assert set(PlainRolling._fields) - set(PlainRigid._fields) == {"k", "b"}
    assert set(PlainLimited._fields) - set(PlainRolling._fields) == {"mu_s", "mu_d"}


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
    step = {kind: reached(walk_step, kind, set()) for kind in (PlainRigid, PlainRolling, PlainLimited, StiffRolling)}
    names = {kind: {f.py_func.__name__ for f in functions} for kind, functions in step.items()}
    assert of_module(step[PlainLimited], "coulomb") and {"single_rates", "strike"} <= names[PlainLimited]
    for kind in (PlainRigid, PlainRolling, StiffRolling):
        assert not of_module(step[kind], "coulomb")
    assert not {name for name in names[PlainRolling] if "sliding" in name or "rigid" in name}
    assert not {name for name in names[PlainRigid] if "compliant" in name or "double" in name}
    assert of_module(step[StiffRolling], "radau") and not of_module(step[PlainRolling], "radau")
    assert not any(of_module(functions, "derivatives") for functions in step.values())


#: Numbers of a rolling walker, and of one that carries changes of its numbers.
NUMBERS = ("walker_of().p", "varied(walker_of().p, numpy.ones((1, 10)), 1)")
#: What begins a step, which is quickly compiled, and all that a heel strike calls.
BEGINS = "compiled(lambda phase, y, p: first_phase(y, exchanged(p)))"
STRIKES = "succeed"


def compiled_for(called, code):
    """Names of the functions compiled for each of `NUMBERS`, one after the other, in a process without machine code."""
    program = f"""
import sys
import numpy
from numba.extending import is_jitted
from stages.analytic.compiled import compiled
from stages.analytic.derivatives import walking
from stages.analytic.model.terms import exchanged
from stages.analytic.model.varied import varied
from stages.analytic.phases.succession import first_phase, succeed
from tests.analytic.designs import walker_of
called = {called}
y = numpy.array([0.28, 1.0, 0.27, 1.0, 0.5, 0.0, 0.4, 0.0])
for y, p in ((y, {NUMBERS[0]}), (numpy.concatenate([y, 0 * y]), {NUMBERS[1]})):
    called(1, y, p)
    modules = [vars(module).values() for name, module in sys.modules.items() if name.startswith("stages")]
    functions = {{id(f): f for values in modules for f in values if is_jitted(f)}}.values()
    print(*sorted(f"{{f.__module__}}.{{f.__name__}}" for f in functions if f.stats.cache_misses))
"""
    done = warm.run(program, cwd=Path(__file__).parents[2], env={**os.environ, "NUMBA_CACHE_DIR": str(code)})
    assert done.returncode == 0, done.stderr
    return map(str.split, done.stdout.splitlines())


@pytest.mark.parametrize(("called", "own"), [
    (BEGINS, ("phases.succession.rolling_phase", "derivatives.walking.plain_exchanged")),
    pytest.param(STRIKES, ("phases.transitions.rolling_reset", "derivatives.walking.rolling_varied_reset"),
                 marks=pytest.mark.slow)])  # fmt: skip
def test_compiler_follows_the_kind(called, own, tmp_path):
    """Of a rolling walker nothing of Coulomb's is compiled.

    Nor is what carries changes of the walker's numbers, unless they are asked for.
    """
    for names, needed in zip(compiled_for(called, tmp_path), own, strict=True):
        assert f"stages.analytic.{needed}" in names
        assert any("derivatives" in name for name in names) == needed.startswith("derivatives")
        assert not [name for name in names if "coulomb" in name or "rigid" in name or "limited" in name]


def test_numbers_of_no_kind_are_refused():
    with pytest.raises(TypeError, match="tuple is no kind of walker"):
        section_state(np.zeros(5), (1.0,) * 10)
    with pytest.raises(TypeError, match="no kind of walker"):
        flow(1, np.zeros(8), None, np.zeros(8))
