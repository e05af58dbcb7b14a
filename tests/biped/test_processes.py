"""Calls that are spread over processes."""

import math
import os

import pytest

from stages.biped.processes import each_in_a_process


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
