"""Compiled functions that compiled code calls: a part of their callers, from the cache too, and Python's as well."""

from __future__ import annotations

import json
import os
import shutil
from types import SimpleNamespace

import pytest

from stages.biped.machine_code.dispatchers import Compiled
from tests import warm

OPTIONS = {"nopython": True, "nogil": True, "error_model": "numpy"}
TOYS = """
import math
import numpy as np

@compiled
def root(x):
    if x < 0.0:
        raise ValueError("less than nothing has no root")
    return math.sqrt(x)

@compiled
def area(x):
    return 2.0 * root(x)

@compiled
def late(x):
    return area(x) - root(x)

@compiled
def whole(x):
    return root(int(x))

@compiled
def twice(x):
    return root(x) + root(int(x))

@compiled
def pair(x):
    both = np.empty(2)
    both[0], both[1] = x, root(x)
    return both

@compiled
def total(x):
    both = pair(x)
    return both[0] + both[1]
"""
#: Says what a process that calls one of them finds, and which functions it loaded as parts, or called.
CALLED = f"""
import json, sys
from pathlib import Path
from stages.biped.machine_code import MachineCode
from stages.biped.machine_code.dispatchers import Compiled
code, made = MachineCode("toy", Path(sys.argv[1])), []
def compiled(function):
    made.append(Compiled(function, {OPTIONS}))
    return code.keep(made[-1])
{TOYS}
answer = [float(np.sum(globals()[name](9.0))) for name in sys.argv[2:]]
parts = [function.__name__ for function in made for _ in function.inner.stats.cache_hits.elements()]
print(json.dumps([answer, parts, [function.__name__ for function in made if function.overloads]]))
"""


@pytest.fixture(scope="module")
def toys():
    """The functions of `TOYS` by name."""
    found = {"compiled": lambda function: Compiled(function, OPTIONS)}
    exec(TOYS, found)
    return SimpleNamespace(**found)


def test_what_compiled_code_calls_is_a_part_of_it(toys):
    assert toys.area(9.0) == 6.0
    assert not toys.root.overloads and len(toys.root.inner.overloads) == 1
    (part,), (whole,) = toys.root.inner.overloads.values(), toys.area.overloads.values()
    engine = whole.library.codegen._engine
    assert engine.is_symbol_defined(whole.fndesc.llvm_cpython_wrapper_name)
    assert not engine.is_symbol_defined(part.fndesc.llvm_cpython_wrapper_name)


def test_python_calls_it_too(toys):
    assert toys.area(4.0) == 4.0 and toys.root(4.0) == 2.0
    assert len(toys.root.overloads) == len(toys.root.inner.overloads) == 1


def test_an_error_comes_out_of_a_part(toys):
    with pytest.raises(ValueError, match="less than nothing"):
        toys.area(-1.0)


def test_a_constant_is_a_number_like_others():
    scaled = Compiled(lambda x, factor: factor * x, OPTIONS)
    calls = {"scaled": scaled}
    exec("def both(x):\n    return scaled(x, 2.0) + scaled(x, 3.0) + scaled(x, 2) + scaled(x, 3)", calls)
    assert Compiled(calls["both"], OPTIONS)(1.0) == 10.0
    assert len(scaled.inner.overloads) == 2  # for a float and for an integer


@pytest.fixture
def called(tmp_path, repository):
    """What a new process that calls some of `TOYS` finds: what they give, what it loaded as parts, what as a whole."""

    def process(*names, cache="cache"):
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / cache), "PYTHONPATH": str(repository)}
        done = warm.run(CALLED, str(tmp_path), *names, cwd=repository, env=environment)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return process


def test_kept_parts_serve_callers_that_are_compiled_later(called):
    assert called("area") == [[6.0], [], ["area"]]
    assert called("area") == [[6.0], [], ["area"]]  # the whole, without its parts
    assert called("late") == [[3.0], ["root", "area"], ["late"]]
    assert called("root") == [[3.0], ["root"], ["root"]]


@pytest.mark.parametrize("orders", [
    [("pair",), ("total",), ("total", "pair"), ("pair", "total")],
    [("total",), ("pair",), ("pair", "total")],  # the entry of `pair` is made from a part that another process kept
])  # fmt: skip
def test_an_entry_has_its_own_python_objects(called, orders):
    """Those of the part, which its callers bring along, are without what the entry needs to return an array."""
    for order in orders:
        answer, _, whole = called(*order)
        assert answer == [12.0] * len(order) and sorted(whole) == sorted(order)


def test_what_two_processes_keep_at_once_serves_both(called, tmp_path):
    """Each begins with nothing kept, and so did the other: they keep one function for different types."""
    for name, cache in (("area", "one"), ("whole", "other")):
        called(name, cache=cache)
        shutil.copytree(tmp_path / cache, tmp_path / "cache", dirs_exist_ok=True)
    assert called("twice") == [[6.0], ["root", "root"], ["twice"]]
