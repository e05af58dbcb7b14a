"""The toy study of `toy.py` as fixtures: fresh, with the command line, or run once already."""

import itertools
import os
import shutil
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.execution import process
from pipeline.room import confine
from tests.pipeline.toy import Toy, copied, with_commands, written

_serial = itertools.count()


@pytest.hookimpl(tryfirst=True)
def pytest_fixture_setup() -> None:
    """Workers' server serves those who share an environment: pytest tells in it which test runs, and nobody asks."""
    os.environ.pop("PYTEST_CURRENT_TEST", None)


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call() -> None:
    """As before: pytest tells it anew for each phase of a test."""
    pytest_fixture_setup()


@pytest.fixture
def toy(tmp_path: Path) -> Toy:
    """A fresh toy study for runs from this process; its package has a name of its own, as imports are remembered."""
    before = list(sys.path)
    yield written(tmp_path, f"toy{os.getpid()}_{next(_serial)}")
    sys.path[:] = before


@pytest.fixture
def toy_with_commands(tmp_path: Path) -> Toy:
    """A fresh toy study whose package is called `stages`, as the command line expects."""
    return with_commands(tmp_path)


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Toy:
    """A toy study that has been run once; tests take a copy, `done`."""
    pytest_fixture_setup()  # what belongs to the session is set up without this folder's hooks
    toy = written(tmp_path_factory.mktemp("finished"), f"toy{os.getpid()}_{next(_serial)}")
    before = list(sys.path)
    toy.run()
    sys.path[:] = before
    return toy


@pytest.fixture
def done(finished: Toy, tmp_path: Path) -> Toy:
    """A toy study that has been run once, free to be spoilt."""
    root = tmp_path / "study"
    shutil.copytree(finished.root, root, copy_function=shutil.copy)
    for name in [name for name in sys.modules if name.partition(".")[0] == finished.package]:
        del sys.modules[name]  # of the copy before: a process takes the stages from one place
    before = list(sys.path)
    yield replace(finished, root=root)
    sys.path[:] = before


@pytest.fixture
def told() -> Path:
    """A folder outside of the study in which stages can leave a file, although they are confined."""
    with tempfile.TemporaryDirectory(dir=confine.SHARED if Path(confine.SHARED).is_dir() else None) as folder:
        yield Path(folder)


@pytest.fixture
def own_server() -> None:
    """A server of workers for this test alone, which gives it another environment; that of the others stays."""
    kept, process._server = process._server, None
    yield
    if process._server is not None:
        process._server.close()
    process._server = kept


@pytest.fixture(scope="session")
def finished_with_commands(tmp_path_factory: pytest.TempPathFactory) -> Toy:
    """A toy study for the command line that has been run once; tests take a copy, `ran`."""
    toy = with_commands(tmp_path_factory.mktemp("finished"))
    toy.says("run-all")
    return toy


@pytest.fixture
def ran(finished_with_commands: Toy, tmp_path: Path) -> Toy:
    """A toy study for the command line that has been run once, free to be spoilt."""
    return copied(finished_with_commands, tmp_path)
