"""The look of the study's figures, for tests that draw by themselves."""

import pytest

from stages.drawing import style


@pytest.fixture(scope="module")
def drawing():
    """Fonts and rules are read once for all figures of a file."""
    with style.drawing():
        yield
