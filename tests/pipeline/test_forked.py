"""Workers are forked from a process that loaded what they import from other packages, once; it is never in the way."""

import errno
import os
import queue
import re
import time

import pytest

from pipeline.cache.fingerprint import entry_modules
from pipeline.cache.sources import beside
from pipeline.execution import process
from pipeline.execution.display import Display
from pipeline.execution.fork_server import foreign
from pipeline.execution.job import Job
from pipeline.execution.process import FORKED, Worker

pytestmark = pytest.mark.skipif(not FORKED, reason="workers are started afresh on this system")
FALL, SIDE = "PACKAGE/fall/run.py", "PACKAGE/side/run.py"


@pytest.fixture
def package(done, own_server, tmp_path, monkeypatch):
    """A foreign package `loud`, with the code that is given; stages fall and side import it."""

    def write(code):
        folder = tmp_path / "foreign"
        folder.mkdir()
        told = folder / "told"
        told.touch()
        (folder / "loud.py").write_text(f"import os\ntry:\n    open({str(told)!r}, 'a').write(f'{{os.getpid()}}\\n')\n"
                                        f"except PermissionError:\n    pass\n{code}")  # fmt: skip
        monkeypatch.setenv("PYTHONPATH", str(folder))
        for path in (FALL, SIDE):
            done.edit(path, "import time\n", "import time\n\nimport loud\n")
        return lambda: told.read_text().split()

    return write


def in_side(done, code):
    done.edit(SIDE, "    return Result(", "".join(f"    {line}\n" for line in code.splitlines()) + "    return Result(")


def test_what_stages_import_is_loaded_once(done, package):
    told = package("")
    assert done.run()["side"] == "computed" and done.run(force=True)["side"] == "computed"
    assert len(told()) == 1


def test_a_worker_runs_the_code_that_is_there_when_it_starts(done, package):
    """An edit of the same length and time fools the interpreter's own check of what it compiled before."""
    package("")
    done.run()
    path = done.path("PACKAGE/body/motion.py")
    before = path.stat()
    done.edit("PACKAGE/body/motion.py", "0.5 * gravity", "0.7 * gravity")
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    outcome = next(outcome for outcome in done.outcomes() if outcome.stage == "fall")
    assert outcome.summary == f"fell {0.7 * 9.81:.2f} m"


def test_a_package_that_starts_threads_is_loaded_by_each_worker(done, package):
    told = package("import threading, time\nthreading.Thread(target=time.sleep, args=(600,), daemon=True).start()\n")
    in_side(done, "import threading\nassert threading.active_count() == 3")  # main, the listener, and the package's
    assert done.run(names=("fall", "side")) == {"fall": "computed", "side": "computed"}
    assert len(told()) == 1


@pytest.mark.parametrize(("code", "said"), [
    ("raise ZeroDivisionError('no luck')", "ZeroDivisionError: no luck; the full account is in "),
    ("import signal\nos.kill(os.getpid(), signal.SIGSEGV)", "its process was ended by the system (SIGSEGV); the full"),
], ids=["cannot be loaded", "crashes when it is loaded"])  # fmt: skip
def test_a_package_that_fails_as_it_is_loaded_fails_its_stage_alone(done, package, code, said):
    package(code)
    done.edit(SIDE, "import loud\n", "")
    done.fails("side.seed=5", jobs=1, said="^stage fall: " + re.escape(said))
    assert done.run("side.seed=5", names=("side",)) == {"side": "current"}


def test_a_server_that_is_killed_costs_nothing(done, monkeypatch):
    """A worker that runs goes on, and the next has another server."""
    in_side(done, "progress(0.5, 'kill'), time.sleep(1.0)")
    done.edit("PACKAGE/picture/run.py", "CLAIM", "CLAIMED")
    servers = []

    def kill(*told):
        if told[-1] == "kill":
            servers.append(process._server)
            servers[-1].process.kill()

    monkeypatch.setattr(Display, "progress", kill)
    hows = done.run("fall.height=3", jobs=1)
    assert len(servers) == 1 and process._server is not servers[0]
    assert hows == {"fall": "computed", "bounce": "computed", "side": "computed", "picture": "computed"}


def test_no_room_for_another_process_fails_its_stage_with_a_sentence(done, own_server, tmp_path, monkeypatch):
    (tmp_path / "sitecustomize.py").write_text(
        "import errno, os, sys\n"
        "def full():\n"
        "    raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))\n"
        "if any(name.endswith('fork_server') for name in sys.orig_argv):\n"
        "    os.fork = full\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    done.fails("side.seed=5", names=("side",), said="^stage side: its process ended by itself with code 1; the full")
    assert os.strerror(errno.EAGAIN) in (done.root / "results/log/side.log").read_text()
    monkeypatch.undo()
    assert done.run("side.seed=5", names=("side",)) == {"side": "computed"}


def test_the_environment_is_that_of_the_moment(done, own_server, monkeypatch):
    in_side(done, "import os\nassert os.environ['MOMENT'] == str(parameters.settings.seed)")
    for moment in ("7", "8"):
        monkeypatch.setenv("MOMENT", moment)
        assert done.run(f"side.seed={moment}", names=("side",)) == {"side": "computed"}


def test_numbers_drawn_without_a_seed_differ_between_workers(done):
    in_side(done, "import sys, numpy as np\nprint('drawn', np.random.random(), file=sys.stderr)\nraise ValueError")
    drawn = set()
    for _ in range(2):
        done.fails(names=("side",))
        drawn |= {*re.findall(r"drawn (\S+)", (done.root / "results/log/side.log").read_text())}
    assert len(drawn) == 2


def test_a_stage_that_dies_takes_what_it_started_with_it(done):
    """Its own processes are forked as well, and must not keep its line open."""
    in_side(done, "import multiprocessing, os, sys\n"
                  "child = multiprocessing.get_context('fork').Process(target=time.sleep, args=(300,))\n"
                  "child.start()\n"
                  "print('child', child.pid, file=sys.stderr, flush=True)\n"
                  "os.kill(os.getpid(), 9)")  # fmt: skip
    began = time.monotonic()
    done.fails(names=("side",), said=r"stage side: its process was ended by the system \(SIGKILL\)")
    child = int(re.findall(r"child (\d+)", (done.root / "results/log/side.log").read_text())[0])
    assert time.monotonic() - began < 60
    with pytest.raises(ProcessLookupError):
        for _ in range(100):
            os.kill(child, 0)
            time.sleep(0.05)


def test_processes_of_a_stage_have_what_it_loaded(done):
    in_side(done, "import multiprocessing, os\n"
                  "from concurrent.futures import ProcessPoolExecutor\n"
                  "context = multiprocessing.get_context(os.environ['STAGE_PROCESSES'])\n"
                  "assert context.get_start_method() == 'fork'\n"
                  "with ProcessPoolExecutor(2, mp_context=context) as pool:\n"
                  "    assert [*pool.map(abs, [-1, -2])] == [1, 2]")  # fmt: skip
    assert done.run(names=("side",)) == {"side": "computed"}


def test_what_is_imported_late_is_not_loaded_before(repository):
    """The derivation of the equations, with SymPy, is imported where their text is made alone."""
    files = [path.relative_to(repository).as_posix() for path in (repository / "stages").rglob("*.py")]
    memo = beside(repository / "stages")  # parsing takes two seconds, once
    heads = {file: memo.meaning((repository / file).read_bytes()).heads for file in files}
    memo.save()
    found = {stage: {module.split(".")[0] for module, _ in foreign("stages", [f"stages.{stage}.run"], heads)}
             for stage in ("analytic", "extremes", "figures")}  # fmt: skip
    assert {"numpy", "numba"} <= found["analytic"] and not found["analytic"] & {"sympy", "matplotlib", "exudyn"}
    assert "sympy" in found["extremes"] and "matplotlib" in found["figures"]


def test_what_was_parsed_for_the_key_is_not_parsed_again(done, monkeypatch):
    path = done.path("PACKAGE/fall/run.py")
    monkeypatch.setattr("ast.parse", None)
    assert beside(path.parent.parent).meaning(path.read_bytes()).heads


def test_a_worker_is_ended_while_it_waits_and_while_its_packages_load(done, package):
    """The second one hangs in the server, which ends with it; the next has another."""
    told = package("if os.path.exists(__file__ + '.hang'):\n    import time\n    time.sleep(600)")
    study, messages = done.study(), queue.SimpleQueue()
    side = study.graph.stages["side"]
    hangs = done.root.parent / "foreign/loud.py.hang"
    hangs.touch()
    for stages, code in (((), {}), ((side,), study.sources.closure(entry_modules(side, done.package)).files)):
        worker = Worker(Job(done.package, str(done.root), str(done.root), stages, code), done.root, messages.put)
        while not (told() if stages else worker._pid):
            time.sleep(0.02)
        began = time.monotonic()
        worker.end()
        assert messages.get(timeout=10)["failed"]["text"] == "its process was ended by the system (SIGKILL)"
        assert time.monotonic() - began < 5
    hangs.unlink()
    assert done.run("side.seed=5", names=("side",)) == {"side": "computed"}
