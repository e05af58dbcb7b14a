"""Strange files and graphs: refused with a sentence, or harmless; never a hang, a traceback or a wrong result."""

import os

import pytest

if os.name != "posix":
    pytest.skip("makes pipes, sockets and links", allow_module_level=True)

from tests.pipeline.strange import PLACES, Strange, everything


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES, ids=lambda place: place.name)
def test_strange_files(toy_with_commands, place):
    strange = Strange(toy_with_commands)
    for kind in place.makers:
        strange.suffer(place, kind)
    count = strange.counts[place.name]
    assert count.problems == [] and count.survived == len(place.makers)


def test_there_are_a_hundred_files_and_fifty_graphs():
    graphs = sum(place.name == "graph" for place, _ in everything())
    assert graphs >= 50 and len(list(everything())) - graphs >= 100
