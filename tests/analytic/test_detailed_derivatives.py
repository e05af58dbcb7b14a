"""Derivatives of gaits of detailed designs by all their numbers, against extrapolated differences and dimensions."""

from __future__ import annotations

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.derivatives.multipliers import multiplier_derivatives
from stages.analytic.derivatives.numbers import left_by_dimensions, sensitive_names
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import step_length
from stages.analytic.gait.poincare import fixed_point
from tests.analytic.designs import FRICTION, SLOPE, TABLE_1, changed, found_gait, gait_beside
from tests.analytic.differences import together
from tests.analytic.test_detailed import LAME

UNITS = {"period_s": "s", "step_length_m": "m", "speed_m_s": "m/s", "step_frequency_hz": "Hz"}
DESIGNS = pytest.mark.parametrize(("legs", "friction"), [
    ("rigid", None), ("compliant", None), ("compliant", FRICTION)])


def varied(biped, friction, names=None):
    design = DesignPoint(biped, SLOPE, friction)
    _, point = gait_beside(biped, found_gait(biped, friction)[1].z, friction, 1e-13)
    names = sensitive_names(design) if names is None else names
    return design, point, gait_derivatives(design, point, names, 1e-13)


@DESIGNS
def test_derivatives_by_all_numbers_are_those_of_differences(legs, friction):
    """Of a gait that limps: period and step length, means over the stride."""
    design, point, gait = varied(changed(LAME, legs=legs), friction)
    assert "biped.other_frame_com" in gait.changes.names and "biped.hip_rest_angle" in gait.changes.names
    walker = gait.walker

    def measures(values):
        there = design.with_values(values).walker()
        moved = fixed_point(there, point.z, 1e-13)
        return np.array([moved.period * there.time, step_length(there, moved) * there.length])

    names = [name for name in gait.changes.names if not name.endswith("_friction") or name == "biped.hip_friction"]
    rows = [gait.changes.names.index(name) for name in names]
    shares = np.array([2e-6 if "length" in name else 2e-5 if "radius" in name or "com" in name else 1e-4
                       for name in names])  # fmt: skip
    values, steps = np.array([design.value(name) for name in names]), shares * gait.changes.scales[rows]
    exact = np.array([gait.period[rows] * walker.time, gait.step_length[rows] * walker.length]) * shares
    for group, weights in together(np.abs(exact).max(axis=0), 18):

        def at(by):
            changed = values[group] + by * weights * steps[group]  # noqa: B023
            return measures({names[row]: value for row, value in zip(group, changed, strict=True)})  # noqa: B023

        slopes = [(at(by) - at(-by)) / (2 * by) for by in (1.0, 0.5)]
        wanted = (4 * slopes[1] - slopes[0]) / 3
        # what each of them may be off by at most, if it is alone
        allowed = np.abs(weights) * (2e-6 * np.abs(exact[:, group]) + 1e-8 * shares[group])
        off = np.abs(exact[:, group] @ weights - wanted)
        assert (off <= allowed.min(axis=1)).all(), [names[row] for row in group]


@DESIGNS
def test_dimensions_set_the_sums_of_elasticities(legs, friction):
    _, _, gait = varied(changed(LAME, legs=legs), friction)
    there = [row for row, value in enumerate(gait.changes.values) if value != 0.0]
    elasticities = gait.elasticities()
    for measure, unit in UNITS.items():
        left = left_by_dimensions(elasticities[measure][there], [gait.changes.units[row] for row in there], unit)
        assert np.abs(left).max() < 1e-9, measure


def test_a_number_of_both_legs_moves_as_the_two_legs_numbers_together():
    """Where the other leg's number is given, though equal, each leg's has a derivative of its own; they add up."""
    alike = changed(TABLE_1, frame_mass=0.01, frame_com=0.02)
    _, _, one = varied(alike, None, ("biped.foot_mass", "biped.frame_com", "biped.frame_mass"))
    both = ("biped.foot_mass", "biped.other_foot_mass", "biped.frame_com", "biped.other_frame_com")
    given = changed(alike, other_foot_mass=0.335, other_frame_com=0.02)
    _, _, two = varied(given, None, both)
    assert two.period[0] + two.period[1] == pytest.approx(one.period[0], rel=1e-9)
    assert two.period[2] + two.period[3] == pytest.approx(one.period[1], rel=1e-9)


def test_multipliers_of_a_stride_have_derivatives():
    design, point, gait = varied(LAME, None, ("biped.foot_mass", "biped.other_frame_mass", "biped.hip_stiffness"))
    found = multiplier_derivatives(gait)
    assert not found.refused
    signs = np.array([1.0, -1.0, 1.0])

    def largest(share):
        values = {name: design.value(name) * (1 + sign * share)
                  for name, sign in zip(gait.changes.names, signs, strict=True)}  # fmt: skip
        return fixed_point(design.with_values(values).walker(), point.z, 1e-13).floquet_multipliers[0]

    slopes = [(largest(h) - largest(-h)) / (2 * h) for h in (2e-4, 1e-4)]
    assert (np.abs(found.derivatives[0]) > 1e-3).all(), "none may be wrong unseen"
    assert found.derivatives[0] @ signs == pytest.approx((4 * slopes[1] - slopes[0]) / 3, abs=1e-5)
