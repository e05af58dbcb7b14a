"""Strange files and graphs: refused with a sentence, or harmless; never a hang, a traceback or a wrong result."""

import os

import pytest

if os.name != "posix":
    pytest.skip("makes pipes, sockets and links", allow_module_level=True)

from tests.pipeline.strange import PLACES, Strange, everything

FEW = {
    ("parameter file", "deeply nested"), ("parameter file", "pipe"), ("file of a sweep", "alias bomb"),
    ("artefact", "HDF5 with lists of any length"),
    ("artefact", "HDF5 with links in a circle"), ("artefact", "HDF5 with a link to another file"),
    ("manifest", "folder"), ("record", "number of ten thousand digits"), ("log", "one line without an end"),
    ("graph", "stage called by a step up"), ("graph", "stage called by a very long"),
}  # fmt: skip


def suffered(toy, chosen):
    strange = Strange(toy)
    for place, kind in chosen:
        strange.suffer(place, kind)
    problems = [told for count in strange.counts.values() for told in (*count.lost, *count.wrong, *count.told)]
    assert not problems, "\n".join(problems)
    return sum(count.survived for count in strange.counts.values())


def test_a_few_strange_files(toy_with_commands):
    chosen = [(place, kind) for place, kind in everything() if (place.name, kind) in FEW]
    assert len(chosen) == len(FEW) == suffered(toy_with_commands, chosen)


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES, ids=lambda place: place.name)
def test_strange_files(toy_with_commands, place):
    assert suffered(toy_with_commands, [(place, kind) for kind in place.makers]) == len(place.makers)


def test_there_are_a_hundred_files_and_fifty_graphs():
    graphs = sum(place.name == "graph" for place, _ in everything())
    assert graphs >= 50 and len(list(everything())) - graphs >= 100
