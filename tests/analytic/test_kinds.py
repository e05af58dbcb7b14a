"""What kind of walker it is stands in the type of its numbers, and decides what is compiled."""

import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from stages.analytic.compiled import ByKind, Compiled
from stages.analytic.integration.step import walk_step
from stages.analytic.model.kinds import PlainLimited, PlainRigid, PlainRolling, StiffLimited, StiffRolling
from stages.analytic.model.walker import build_walker
from stages.analytic.phases.flow import flow
from stages.analytic.phases.section import section_state
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
    if isinstance(function, Compiled) and function not in found:
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


#: What a heel strike is given, of a rolling walker and of one that carries changes of its numbers.
STRUCK = ("walker_of().p", "varied(walker_of().p, numpy.ones((1, 10)), 1)")


@pytest.fixture(scope="module")
def compiled_for(tmp_path_factory):
    """Names of the functions compiled for each of `STRUCK`, one after the other, in a process without machine code."""
    program = f"""
import numpy
from numba.core import event
from stages.analytic.derivatives import walking
from stages.analytic.model.varied import varied
from stages.analytic.phases.succession import succeed
from tests.analytic.designs import walker_of
y = numpy.array([0.28, 1.0, 0.27, 1.0, 0.5, 0.0, 0.4, 0.0])
for y, p in ((y, {STRUCK[0]}), (numpy.concatenate([y, 0 * y]), {STRUCK[1]})):
    with event.install_recorder("numba:compile") as recorder:
        succeed(1, y, p)
    functions = {{record.data["dispatcher"].py_func for _, record in recorder.buffer}}
    print(*sorted({{f"{{f.__module__}}.{{f.__name__}}" for f in functions if f.__module__.startswith("stages")}}))
"""
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=Path(__file__).parents[2], capture_output=True, text=True, check=True,
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path_factory.mktemp("code"))})  # fmt: skip
    return dict(zip(STRUCK, map(str.split, done.stdout.splitlines()), strict=True))


@pytest.mark.parametrize("numbers, reset", [
    (STRUCK[0], "phases.transitions.rolling_reset"),
    (STRUCK[1], "derivatives.impacts.rolling_varied_reset"),
])
def test_compiler_follows_the_kind(compiled_for, numbers, reset):
    """Heel strike of a rolling walker: nothing of Coulomb's is compiled.

    Nor is what carries changes of the walker's numbers, unless they are asked for.
    """
    names = compiled_for[numbers]
    assert f"stages.analytic.{reset}" in names
    assert any("derivatives" in name for name in names) == reset.startswith("derivatives")
    assert not [name for name in names if "coulomb" in name or "rigid" in name or "limited" in name]


def test_numbers_of_no_kind_are_refused():
    with pytest.raises(TypeError, match="tuple is no kind of walker"):
        section_state(np.zeros(5), (1.0,) * 10)
    with pytest.raises(TypeError, match="no kind of walker"):
        flow(1, np.zeros(8), None, np.zeros(8))
