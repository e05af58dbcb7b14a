"""The contact laws as machine code are their own texts over floats: the whole register, and every operation."""

import dataclasses

import numba
import numpy as np
import pytest

from stages.ground.compiled import COMPILED, TANGENTS, compiled_coefficient, compiled_slope
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import friction_slope, signed_coefficient
from stages.ground.laws import FRICTIONS, NORMAL_FORCES, PointLaw
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


STEP = 1e-40


@pytest.mark.parametrize("name", NORMAL_FORCES)
def test_a_law_gives_its_own_derivatives_of_the_normal_force(name):
    """By a complex step, against central differences of its text over floats; in and out of contact."""
    law = dataclasses.replace(LAW, normal_force=name).numbers.normal
    for depth in (-1e-5, 1e-6, 3e-5, 0.99e-4, 5e-4):
        for rate in (-1.0, -0.01, 0.0, 0.3):
            tangents = (
                law.force(complex(depth, STEP), complex(rate, 0.0), TANGENTS),
                law.force(complex(depth, 0.0), complex(rate, STEP), TANGENTS),
            )
            sizes = 1e-5 * max(abs(depth), 1e-6), 1e-6
            by_depth = [law.force(depth + sign * sizes[0], rate, SCALARS) for sign in (1.0, -1.0)]
            by_rate = [law.force(depth, rate + sign * sizes[1], SCALARS) for sign in (1.0, -1.0)]
            for tangent, (ahead, behind), size in zip(tangents, (by_depth, by_rate), sizes):
                value = law.force(depth, rate, SCALARS)
                assert tangent.real == pytest.approx(value, rel=1e-12, abs=1e-12)
                expected, noise = (ahead - behind) / (2 * size), 1e-14 * abs(value) / size
                assert tangent.imag / STEP == pytest.approx(expected, rel=1e-6, abs=1e-9 + noise)


@pytest.mark.parametrize("name", FRICTIONS)
def test_a_law_gives_its_own_derivative_of_friction(name):
    law = dataclasses.replace(LAW, friction=name).numbers
    for slip in (-2.0, -0.4, -0.05, 0.0, 0.03, 0.2, 0.7, 1.5):
        tangent = signed_coefficient(law, complex(slip, STEP), TANGENTS)
        ends = [signed_coefficient(law, slip + sign * 1e-7, SCALARS) for sign in (1.0, -1.0)]
        assert complex(tangent).real == pytest.approx(signed_coefficient(law, slip, SCALARS), rel=1e-12, abs=1e-15)
        assert complex(tangent).imag / STEP == pytest.approx((ends[0] - ends[1]) / 2e-7, rel=1e-6, abs=1e-7)


def test_every_operation_has_its_derivative():
    pairs = {"sqrt": (), "power": (2.2,), "creep": (0.5, 1.1), "minimum": (0.4,), "maximum": (0.4,), "step": (0.5, 1.1),
             "rise": (0.5, 1.1), "length": (-0.3,), "absolute": (), "sign": (), "round": ()}  # fmt: skip
    assert set(pairs) == set(TANGENTS._fields)
    for name, arguments in pairs.items():
        for x in (0.2, 0.45, 0.7, 1.3):
            function, size = getattr(SCALARS, name), 1e-6
            expected = (function(x + size, *arguments) - function(x - size, *arguments)) / (2 * size)
            found = getattr(TANGENTS, name)(complex(x, 1e-20), *arguments)
            assert found.real == pytest.approx(function(x, *arguments), rel=1e-12)
            assert found.imag / 1e-20 == pytest.approx(expected, rel=1e-7, abs=1e-9), (name, x)


@numba.njit
def normal_of_numbers(law, numbers, depth, rate):
    return law.like(numbers, 0).force(complex(depth, 0.0), complex(rate, 0.0), TANGENTS)


@numba.njit
def friction_of_numbers(law, numbers, slip):
    friction = law.friction.like(numbers, 0)
    return compiled_coefficient(PointLaw(friction, friction, numbers[-1]), complex(slip, 0.0), TANGENTS)


NUMBERS = ("contact_stiffness", "contact_exponent", "contact_damping", "damping_depth", "static_friction",
           "dynamic_friction", "stiction_velocity", "friction_velocity", "restitution", "impact_speed")  # fmt: skip


@pytest.mark.parametrize("key", NUMBERS)
@pytest.mark.parametrize("law", [*NORMAL_FORCES, *FRICTIONS])
def test_a_law_gives_its_derivatives_by_every_parameter(law, key):
    """Complex steps through what makes its numbers and through its text, against central differences over floats."""
    chosen = {"normal_force": law} if law in NORMAL_FORCES else {"friction": law}
    contact = dataclasses.replace(LAW, **chosen)
    value = getattr(contact, key)

    def changed(by):
        return dataclasses.replace(contact, **{key: value + by}).numbers

    ends, step = [changed(sign * 1e-6 * value) for sign in (1.0, -1.0)], 2e-6 * value
    if law in NORMAL_FORCES:
        numbers = np.array(changed(1j * STEP).normal, dtype=complex)
        for depth in (-1e-5, 1e-6, 3e-5, 0.99e-4, 5e-4):
            for rate in (-1.0, -0.01, 0.0, 0.3):
                own = normal_of_numbers(contact.numbers.normal, numbers, depth, rate).imag / STEP
                ahead, behind = (end.normal.force(depth, rate, SCALARS) for end in ends)
                noise = 1e-15 * abs(ahead) / step
                assert own == pytest.approx((ahead - behind) / step, rel=1e-5, abs=1e-9 + 10 * noise)
        return
    varied = changed(1j * STEP)
    numbers = np.array([*varied.friction, varied.stiction_velocity], dtype=complex)
    for slip in (-2.0, -0.4, -0.05, 0.0, 0.03, 0.2, 0.7, 1.5):
        own = friction_of_numbers(contact.numbers, numbers, slip).imag / STEP
        ahead, behind = (signed_coefficient(end, slip, SCALARS) for end in ends)
        assert own == pytest.approx((ahead - behind) / step, rel=1e-6, abs=1e-8)
