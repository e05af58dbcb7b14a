"""The look of the study's figures, for tests that draw by themselves."""

import matplotlib.pyplot as plt
import pytest

from stages.drawing import style


@pytest.fixture(scope="module")
def drawing():
    """Fonts and rules are read once for all figures of a file."""
    with style.drawing():
        yield


@pytest.fixture(autouse=True)
def closed_figures():
    """Pyplot keeps every figure that a test draws until it is closed."""
    yield
    plt.close("all")
