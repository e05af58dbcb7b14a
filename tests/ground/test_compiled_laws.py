"""The contact laws as machine code are their own texts over floats: the whole register, and every operation."""

import dataclasses
from itertools import product
from pathlib import Path

import numba
import numpy as np
import pytest

from stages.ground.compiled import COMPILED, TANGENTS, compiled_coefficient, compiled_slope, kept_with_ground
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import ARRAYS, SCALARS, friction_slope, signed_coefficient
from stages.ground.laws import FRICTIONS, NORMAL_FORCES, PointLaw

LAW = ContactLaw(1e5, 2.2, 1e4, 1e-4, 1.1, 1.0, 0.1, 1.0)
RATES = (-1.0, -0.01, 0.0, 0.3)
#: Depths with rates, in and out of contact; those of the second are not where a law has a corner.
CONTACTS = [*product((-1e-5, 0.0, 1e-6, 3e-5, 1e-4, 5e-4), RATES)]
SMOOTH = [*product((-1e-5, 1e-6, 3e-5, 0.99e-4, 5e-4), RATES)]
SLIPS = (-2.0, -0.4, -0.05, 0.0, 0.03, 0.2, 0.7, 1.5)
SPEEDS = (0.0, 1e-9, 0.01, 0.0999, 0.1, 0.3, 1.0, 2.0)
GRID = (-2.0, -1.0, -0.3, 0.0, 1e-9, 0.2, 0.5, 1.0, 3.0)
#: Machine code of what stands here is kept as that of the stages is: by the digest of all its sources.
compiled = kept_with_ground(Path(__file__).parent)


@compiled
def force(law, penetration, rate):
    return law.force(penetration, rate, COMPILED)


@compiled
def slope(law, slip_x, slip_z):
    return compiled_slope(law, slip_x, slip_z, COMPILED)


@pytest.mark.parametrize("name", NORMAL_FORCES)
def test_a_compiled_normal_force_is_its_text(name):
    law = dataclasses.replace(LAW, normal_force=name).numbers.normal
    for depth, rate in CONTACTS:
        assert force(law, depth, rate) == pytest.approx(law.force(depth, rate, SCALARS), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("name", FRICTIONS)
def test_compiled_friction_is_its_text(name):
    law = dataclasses.replace(LAW, friction=name).numbers
    for speed in SPEEDS:
        for x, z in ((speed, 0.0), (0.6 * speed, -0.8 * speed)):
            assert slope(law, x, z) == pytest.approx(friction_slope(law, x, z, SCALARS), rel=1e-12)


def test_what_is_no_law_does_not_compile():
    for other in (LAW, LAW.numbers.friction):
        with pytest.raises(numba.TypingError):
            force(other, 1e-5, 0.0)


#: What each operation is given besides x: of those that any x may be given, and of those that are for x >= 0.
ANY = {"sign": (), "absolute": (), "round": (), "minimum": (0.4,), "maximum": (0.4,), "step": (0.5, 1.1),
       "rise": (0.5, 1.1)}  # fmt: skip
POSITIVE = {"power": (2.2,), "creep": (0.5, 1.1), "length": (-0.3,)}


@compiled
def of_any(x):
    """Every operation of `ANY` on x, in its order."""
    return (COMPILED.sign(x), COMPILED.absolute(x), COMPILED.round(x), COMPILED.minimum(x, 0.4),
            COMPILED.maximum(x, 0.4), COMPILED.step(x, 0.5, 1.1), COMPILED.rise(x, 0.5, 1.1))  # fmt: skip


@compiled
def of_positive(x):
    """Every operation of `POSITIVE` on x, in its order."""
    return COMPILED.power(x, 2.2), COMPILED.creep(x, 0.5, 1.1), COMPILED.length(x, -0.3)


@compiled
def tangents(x):
    """Every operation of both on a number that carries a change."""
    return (TANGENTS.sign(x), TANGENTS.absolute(x), TANGENTS.round(x), TANGENTS.minimum(x, 0.4),
            TANGENTS.maximum(x, 0.4), TANGENTS.step(x, 0.5, 1.1), TANGENTS.rise(x, 0.5, 1.1),
            TANGENTS.power(x, 2.2), TANGENTS.creep(x, 0.5, 1.1), TANGENTS.length(x, -0.3))  # fmt: skip


@pytest.mark.parametrize(("name", "arguments"), ANY.items())
def test_an_operation_means_the_same_in_every_table(name, arguments):
    expected = getattr(ARRAYS, name)(np.array(GRID), *arguments).tolist()
    assert [of_any(x)[[*ANY].index(name)] for x in GRID] == pytest.approx(expected, rel=1e-15, abs=1e-15)
    assert [getattr(SCALARS, name)(x, *arguments) for x in GRID] == pytest.approx(expected, rel=1e-15, abs=1e-15)


def test_operations_on_what_is_not_negative_mean_the_same_in_every_table():
    for x in (1e-9, 0.2, 0.5, 3.0):
        power, creep, length = of_positive(x)
        for table in (SCALARS, ARRAYS):
            # roots are rounded rightly everywhere; powers are not, and NumPy 1.26 has its own with AVX-512
            assert power == pytest.approx(table.power(x, 2.2), rel=1e-15)
            assert creep == pytest.approx(table.creep(x, 0.5, 1.1), rel=1e-14)
            assert length == pytest.approx(table.length(x, -0.3), rel=1e-15)


STEP = 1e-40


@compiled
def force_tangent(law, penetration, rate):
    return law.force(penetration, rate, TANGENTS)


@compiled
def coefficient_tangent(law, slip):
    return compiled_coefficient(law, slip, TANGENTS)


@pytest.mark.parametrize("name", NORMAL_FORCES)
def test_a_law_gives_its_own_derivatives_of_the_normal_force(name):
    """By a complex step, against central differences of its text over floats; in and out of contact."""
    law = dataclasses.replace(LAW, normal_force=name).numbers.normal
    for depth, rate in SMOOTH:
        value = law.force(depth, rate, SCALARS)
        for which, size in (((1, 0), 1e-5 * max(abs(depth), 1e-6)), ((0, 1), 1e-6)):
            tangent = force_tangent(law, complex(depth, which[0] * STEP), complex(rate, which[1] * STEP))
            ahead, behind = (law.force(depth + by * which[0], rate + by * which[1], SCALARS) for by in (size, -size))
            assert tangent.real == pytest.approx(value, rel=1e-12, abs=1e-12)
            expected, noise = (ahead - behind) / (2 * size), 1e-14 * abs(value) / size
            assert tangent.imag / STEP == pytest.approx(expected, rel=1e-6, abs=1e-9 + noise)


@pytest.mark.parametrize("name", FRICTIONS)
def test_a_law_gives_its_own_derivative_of_friction(name):
    law = dataclasses.replace(LAW, friction=name).numbers
    for slip in SLIPS:
        tangent = coefficient_tangent(law, complex(slip, STEP))
        ends = [signed_coefficient(law, slip + sign * 1e-7, SCALARS) for sign in (1.0, -1.0)]
        assert complex(tangent).real == pytest.approx(signed_coefficient(law, slip, SCALARS), rel=1e-12, abs=1e-15)
        assert complex(tangent).imag / STEP == pytest.approx((ends[0] - ends[1]) / 2e-7, rel=1e-6, abs=1e-7)


def test_every_operation_has_its_derivative():
    assert {*ANY, *POSITIVE} == set(TANGENTS._fields)
    for x in (0.2, 0.45, 0.7, 1.3):
        for (name, arguments), found in zip({**ANY, **POSITIVE}.items(), tangents(complex(x, 1e-20)), strict=True):
            function, size = getattr(SCALARS, name), 1e-6
            expected = (function(x + size, *arguments) - function(x - size, *arguments)) / (2 * size)
            assert found.real == pytest.approx(function(x, *arguments), rel=1e-12)
            assert found.imag / 1e-20 == pytest.approx(expected, rel=1e-7, abs=1e-9), (name, x)


@compiled
def normal_of_numbers(law, numbers, depth, rate):
    return law.like(numbers, 0).force(complex(depth, 0.0), complex(rate, 0.0), TANGENTS)


@compiled
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
        for depth, rate in SMOOTH:
            own = normal_of_numbers(contact.numbers.normal, numbers, depth, rate).imag / STEP
            ahead, behind = (end.normal.force(depth, rate, SCALARS) for end in ends)
            noise = 1e-15 * abs(ahead) / step
            assert own == pytest.approx((ahead - behind) / step, rel=1e-5, abs=1e-9 + 10 * noise)
        return
    varied = changed(1j * STEP)
    numbers = np.array([*varied.friction, varied.stiction_velocity], dtype=complex)
    for slip in SLIPS:
        own = friction_of_numbers(contact.numbers, numbers, slip).imag / STEP
        ahead, behind = (signed_coefficient(end, slip, SCALARS) for end in ends)
        assert own == pytest.approx((ahead - behind) / step, rel=1e-6, abs=1e-8)
