"""Inertia of shapes against textbook formulas."""

import math

import numpy as np
import pytest

from stages.twin.machine.machine import Body, join
from stages.twin.machine.parts import size_fault, solid


def test_box():
    a, b, c, m = 0.02, 0.10, 0.03, 0.7
    shape, square = solid("box", (a, b, c)), np.array([a * a, b * b, c * c])
    assert shape.volume == pytest.approx(a * b * c)
    assert shape.inertia(m) == pytest.approx(m / 12 * (square.sum() - square))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_solid_cylinder_about_its_axis_and_across(axis):
    r, length, m = 0.02, 0.3, 1.3
    wanted = [m / 2 * r * r if each == axis else m / 12 * (3 * r * r + length * length) for each in "xyz"]
    assert solid("cylinder", (r, length), axis).inertia(m) == pytest.approx(wanted)


def test_tube_is_a_cylinder_less_a_cylinder():
    outer, inner, length, density = 0.02, 0.015, 0.1, 2700.0
    hollow, full, hole = (
        solid(*each) for each in (
            ("tube", (outer, inner, length)), ("cylinder", (outer, length)), ("cylinder", (inner, length))))
    assert hollow.volume == pytest.approx(full.volume - hole.volume)
    of_hollow, of_full, of_hole = (np.array(each.inertia(density * each.volume)) for each in (hollow, full, hole))
    assert of_hollow == pytest.approx(of_full - of_hole)


def test_arc_with_the_diameter_as_chord_is_a_half_disc():
    r, m = 0.08, 0.5
    shape = solid("arc", (r, r, 0.02, 2 * r))
    assert shape.centroid[1] == pytest.approx(-4 * r / (3 * math.pi))
    about_axis = shape.inertia(m)[2] + m * shape.centroid[1] ** 2
    assert about_axis == pytest.approx(0.5 * m * r * r)


def test_arc_against_integration_over_its_area():
    outer, thickness, width, chord = 0.083, 0.012, 0.02, 0.11
    half = math.asin(chord / 2 / outer)
    radius, angle = np.meshgrid(
        np.linspace(outer - thickness, outer, 801), np.linspace(-half, half, 801), indexing="ij"
    )
    x, y, weight = radius * np.sin(angle), -radius * np.cos(angle), radius
    shape = solid("arc", (outer, thickness, width, chord))
    mean = lambda f: np.trapezoid(np.trapezoid(f * weight)) / np.trapezoid(np.trapezoid(weight))  # noqa: E731
    assert shape.centroid[1] == pytest.approx(mean(y), rel=1e-5)
    across = mean(x**2), mean((y - mean(y)) ** 2)
    assert shape.mean_square[:2] == pytest.approx(across, rel=1e-4)


def test_parallel_axis_theorem_on_a_rod_about_its_end():
    length, m = 0.4, 0.2
    rod = Body(m, np.array([0.0, length / 2, 0.0]), np.diag(solid("cylinder", (1e-6, length), "y").inertia(m)))
    assert rod.inertia_about(np.zeros(3))[2, 2] == pytest.approx(m * length**2 / 3, rel=1e-9)


def test_two_halves_of_a_box_make_the_box():
    half, whole = (np.diag(solid("box", (length, 0.05, 0.02)).inertia(m)) for length, m in ((0.1, 0.3), (0.2, 0.6)))
    found = join([Body(0.3, np.array([x, 0.3, 0.1]), half) for x in (-0.05, 0.05)])
    assert found.centre == pytest.approx([0.0, 0.3, 0.1]) and found.inertia == pytest.approx(whole, abs=1e-12)


@pytest.mark.parametrize(
    ("shape", "size"),
    [
        ("box", (1.0, 1.0)),
        ("cylinder", (0.0, 1.0)),
        ("tube", (1.0, 1.0, 1.0)),
        ("arc", (1.0, 2.0, 1.0, 1.0)),
        ("arc", (1.0, 0.1, 1.0, 2.1)),
        ("box", (1.0, float("nan"), 1.0)),
    ],
)
def test_impossible_sizes_are_named(shape, size):
    assert size_fault(shape, size)
