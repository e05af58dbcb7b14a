"""What all tests share: the repository's root, and an environment in which nothing opens a window."""

import atexit
import os
import shutil
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from pipeline.cache import processor

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ["XDG_CONFIG_HOME"] = tempfile.mkdtemp(prefix="bipedstudy-tests-")  # what tests agree to, users do not
atexit.register(shutil.rmtree, os.environ["XDG_CONFIG_HOME"], ignore_errors=True)
processor.take()  # as in the study's own processes

# The same examples on every machine, however slow it is: a test that fails must say something about the code.
settings.register_profile("study", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("study")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--write-golden", action="store_true", help="Write tests/baseline anew from what is drawn now.")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """A process tests whole folders, whose tests share machine code, gaits and servers; the largest begin."""
    from xdist.scheduler import LoadFileScheduling

    class ByFolder(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return nodeid.split("::")[0].rpartition("/")[0]

    return ByFolder(config, log)


@pytest.fixture(scope="session")
def repository() -> Path:
    """Root of the checkout."""
    return Path(__file__).resolve().parent.parent
