"""Arrays of a result carry names, units and dimensions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import bipedstudy as bs
from pipeline.errors import StudyError
from stages.biped.quantity import quantity


@dataclass(frozen=True)
class Fall:
    time: np.ndarray = quantity("s", "time", symbol="t")
    place: np.ndarray = quantity("m", "place x, y", symbol="x")
    mass: float = quantity("kg", "mass", symbol="m")
    stable: bool = quantity("1", "whether it stands")


FALL = Fall(np.arange(3.0), np.ones((3, 2)), 2.0, True)


def test_an_array_knows_what_it_is():
    place = bs.array(FALL, "place")
    assert (place.unit, place.symbol, place.dimensions) == ("m", "x", ("time", "place_1"))
    assert repr(place) == "place [m] (time 3 x place_1 2): place x, y"
    assert np.array_equal(np.asarray(place), FALL.place)
    assert list(bs.arrays(FALL)) == ["time", "place", "mass"]


def test_an_unknown_array_is_told_with_the_nearest():
    with pytest.raises(StudyError, match=r'no array "plaice".*did you mean "place"'):
        bs.array(FALL, "plaice")


def test_a_dataset_has_units_and_a_time_axis():
    pytest.importorskip("xarray")
    found = bs.dataset(FALL)
    assert found.place.attrs["units"] == "m" and float(found.place.sel(time=1.0)[0]) == 1.0
