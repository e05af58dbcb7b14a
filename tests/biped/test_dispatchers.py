"""Compiled functions that compiled code calls: kept for callers that are compiled later, and Python's as well."""

import json
import math
import os
import shutil
from functools import partial
from types import SimpleNamespace

import pytest

from stages.biped.machine_code import MachineCode
from stages.biped.processes import each_in_a_process
from tests import commands

OPTIONS = {"nogil": True, "error_model": "numpy"}
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
#: Says what a process that calls some of them finds: what they give, which it loaded, and which it compiled.
CALLED = f"""
import json, sys
from pathlib import Path
import numpy as np
from stages.biped.machine_code import MachineCode
code, made = MachineCode("toy", Path(sys.argv[1])), []
def compiled(function):
    made.append(code.compiled(function, **{OPTIONS}))
    return made[-1]
{TOYS}
answer = [float(np.sum(globals()[name](9.0))) for name in sys.argv[2:]]
loaded = [function.__name__ for function in made for _ in function.stats.cache_hits.elements()]
fresh = [function.__name__ for function in made for _ in function.stats.cache_misses.elements()]
print(json.dumps([answer, loaded, fresh]))
"""


@pytest.fixture(scope="module")
def toys(tmp_path_factory):
    """The functions of `TOYS` by name."""
    folder = tmp_path_factory.mktemp("toys")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NUMBA_CACHE_DIR", str(folder / "cache"))
        code = MachineCode("toy", folder)
    found = {"compiled": lambda function: code.compiled(function, **OPTIONS), "__name__": __name__}
    exec(TOYS, found)
    return SimpleNamespace(**found)


def test_python_calls_what_compiled_code_calls(toys):
    assert toys.area(9.0) == 6.0 and len(toys.root.signatures) == 1
    assert toys.area(4.0) == 4.0 and toys.root(4.0) == 2.0
    assert len(toys.root.signatures) == 1


def test_an_error_comes_out_of_what_is_called(toys):
    with pytest.raises(ValueError, match="less than nothing"):
        toys.area(-1.0)


@pytest.fixture
def called(tmp_path):
    """What a new process that calls some of `TOYS` finds: what they give, what it loaded as parts, what as a whole."""

    def process(*names, cache="cache"):
        done = commands.python(CALLED, str(tmp_path), *names, cwd=commands.HOME, NUMBA_CACHE_DIR=str(tmp_path / cache))
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return process


@pytest.mark.slow
def test_what_is_kept_serves_callers_that_are_compiled_later(called):
    assert called("area") == [[6.0], [], ["root", "area"]]
    assert called("area") == [[6.0], ["area"], []]  # without what it calls
    assert called("late") == [[3.0], ["root", "area"], ["late"]]
    assert called("root") == [[3.0], ["root"], []]


@pytest.mark.parametrize("orders", [
    [("pair",), ("total",), ("total", "pair"), ("pair", "total")],
    [("total",), ("pair",), ("pair", "total")],  # another process kept `pair` when it compiled its caller
])  # fmt: skip
@pytest.mark.slow
def test_an_array_comes_from_what_is_called_as_well(called, orders):
    """Python objects that a function needs to return one come with what calls it, in any order of calls."""
    for order in orders:
        answer, loaded, fresh = called(*order)
        assert answer == [12.0] * len(order) and set(order) <= {*loaded, *fresh}


@pytest.mark.slow
def test_what_two_processes_keep_at_once_serves_both(called, tmp_path):
    """Each begins with nothing kept, and so did the other: they keep one function for different types."""
    for name, cache in (("area", "one"), ("whole", "other")):
        called(name, cache=cache)
        shutil.copytree(tmp_path / cache, tmp_path / "cache", dirs_exist_ok=True)
    assert called("twice") == [[6.0], ["root", "root"], ["twice"]]


# --- Where numba's caches are made of other parts than today's, it keeps machine code by itself: every command
# works.


#: Python runs it when it starts, in every process of a command: parts of numba's caches that ours are made of are gone.
OTHER_NUMBA = "from numba.core import caching\ndel caching._CacheLocator, caching.CompileResultCacheImpl\n"
COLD = "compiling the equations of motion"


@pytest.fixture
def command(tmp_path, repository):
    """Runs a command of a copy of the study with such a numba, and gives what it says."""
    for name in ("dvc.yaml", "params"):
        source = repository / name
        (shutil.copytree if source.is_dir() else shutil.copy)(source, tmp_path / name)
    (tmp_path / "other").mkdir()
    (tmp_path / "other/sitecustomize.py").write_text(OTHER_NUMBA)
    path = os.pathsep.join([str(tmp_path / "other"), str(repository)])
    return partial(commands.afresh, cwd=tmp_path, timeout=3600.0, PYTHONPATH=path,
                   NUMBA_CACHE_DIR=str(tmp_path / "cache"))  # fmt: skip


@pytest.mark.slow
def test_a_command_answers_the_same_and_finds_its_machine_code_again(command, tmp_path, repository):
    first, again = command("gait", "--json"), command("gait", "--json")
    assert (first.returncode, again.returncode) == (0, 0), first.stderr
    assert COLD in first.stderr and COLD not in again.stderr
    ours = commands.afresh("gait", "--json", cwd=repository)
    assert json.loads(first.stdout) == json.loads(again.stdout) == json.loads(ours.stdout)
    (folder,) = (tmp_path / "cache/bipedstudy").glob("analytic-*")
    assert [*folder.rglob("*.nbi")] and not [*repository.rglob("stages/**/*.nbi")]


@pytest.mark.slow
def test_the_whole_study_and_what_needs_other_functions(command):
    first, again, other = (command(*words) for words in (("run-all", "--accuracy", "draft"),) * 2 + (("sensitivity",),))
    assert [done.returncode for done in (first, again, other)] == [0, 0, 0], first.stderr + again.stderr + other.stderr
    assert first.stdout.count("computed") > 10 and "computed" not in again.stdout


# --- Calls that are spread over processes.


@pytest.mark.parametrize("cores", [1, 2])
def test_each_answer_comes_with_its_number_and_an_error_is_raised_here(cores, monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: cores)
    assert dict(each_in_a_process(math.comb, [2, 3, 5], 7)) == {0: 21, 1: 35, 2: 21}
    with pytest.raises(ValueError, match="non-negative"):
        list(each_in_a_process(math.comb, [2, -3], 7))


def test_one_argument_is_worked_on_in_this_process_and_none_in_none():
    assert list(each_in_a_process(math.comb, [])) == []
    assert [answer for _, answer in each_in_a_process(lambda one: (one, os.getpid()), ["alone"])] == [
        ("alone", os.getpid())]  # fmt: skip
