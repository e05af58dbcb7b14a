"""The table of prices: every level, the one at hand marked, and errors that fall as the price rises."""

from __future__ import annotations

import pytest

from stages.biped.accuracy.tolerances import LEVELS
from stages.comparison.tables import ERRORS, prices


@pytest.mark.parametrize("level", LEVELS)
def test_the_level_at_hand_is_marked_and_errors_fall_with_the_price(level):
    _, columns, rows = prices(level)
    assert [name.split(" (")[0] for name in columns[1:]] == list(LEVELS)
    assert [name for name in columns if "(this one)" in name] == [f"{level} (this one)"]
    numbers = {name: [float(value) for value in values] for name, *values in rows}
    assert all(len(values) == len(LEVELS) for values in numbers.values())
    for name, _, unit in ERRORS.values():
        of = numbers[f"{name} [{unit}]" if unit != "1" else name]
        assert of == sorted(of, reverse=True)
    assert numbers["processor time [s]"] == sorted(numbers["processor time [s]"])
    assert numbers["other verdicts than at reference"][-1] == numbers["verdicts not decided at this accuracy"][-1] == 0
