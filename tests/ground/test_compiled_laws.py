"""The contact laws as machine code are their own texts over floats: the whole register, and every operation."""

import dataclasses

import numba
import numpy as np
import pytest

from stages.ground.compiled import COMPILED, compiled_slope
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import friction_slope
from stages.ground.laws import FRICTIONS, NORMAL_FORCES
from stages.ground.operations import ARRAYS, SCALARS

LAW = ContactLaw(1e5, 2.2, 1e4, 1e-4, 1.1, 1.0, 0.1, 1.0)
DEPTHS = (-1e-5, 0.0, 1e-6, 3e-5, 1e-4, 5e-4)
SPEEDS = (0.0, 1e-9, 0.01, 0.0999, 0.1, 0.3, 1.0, 2.0)
GRID = (-2.0, -1.0, -0.3, 0.0, 1e-9, 0.2, 0.5, 1.0, 3.0)


@numba.njit
def force(law, penetration, rate):
    return law.force(penetration, rate, COMPILED)


@numba.njit
def slope(law, slip_x, slip_z):
    return compiled_slope(law, slip_x, slip_z, COMPILED)


@pytest.mark.parametrize("name", NORMAL_FORCES)
def test_a_compiled_normal_force_is_its_text(name):
    law = dataclasses.replace(LAW, normal_force=name).numbers.normal
    for depth in DEPTHS:
        for rate in (-1.0, -0.01, 0.0, 0.3):
            assert force(law, depth, rate) == pytest.approx(law.force(depth, rate, SCALARS), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("name", FRICTIONS)
def test_compiled_friction_is_its_text(name):
    law = dataclasses.replace(LAW, friction=name).numbers
    for speed in SPEEDS:
        for x, z in ((speed, 0.0), (0.6 * speed, -0.8 * speed)):
            assert slope(law, x, z) == pytest.approx(friction_slope(law, x, z, SCALARS), rel=1e-12)


def test_what_is_no_law_does_not_compile():
    with pytest.raises(numba.core.errors.TypingError):
        force(LAW, 1e-5, 0.0)
    with pytest.raises(numba.core.errors.TypingError):
        force(LAW.numbers.friction, 1e-5, 0.0)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        *((name, ()) for name in ("sign", "absolute", "round")),
        *((name, (0.4,)) for name in ("minimum", "maximum")),
        *((name, (0.5, 1.1)) for name in ("step", "rise")),
    ],
)
def test_an_operation_means_the_same_in_every_table(name, arguments):
    at = [getattr(table, name) for table in (COMPILED, SCALARS)]
    expected = getattr(ARRAYS, name)(np.array(GRID), *arguments)
    for operation in at:
        assert [operation(x, *arguments) for x in GRID] == pytest.approx(expected.tolist(), rel=1e-15, abs=1e-15)


def test_operations_on_what_is_not_negative_mean_the_same_in_every_table():
    for x in (1e-9, 0.2, 0.5, 3.0):
        for table in (SCALARS, ARRAYS):
            assert COMPILED.sqrt(x) == table.sqrt(x)
            # roots are rounded rightly everywhere; powers are not, and NumPy 1.26 has its own with AVX-512
            assert COMPILED.power(x, 2.2) == pytest.approx(table.power(x, 2.2), rel=1e-15)
            assert COMPILED.creep(x, 0.5, 1.1) == pytest.approx(table.creep(x, 0.5, 1.1), rel=1e-14)
            assert COMPILED.length(x, -0.3) == pytest.approx(table.length(x, -0.3), rel=1e-15)
