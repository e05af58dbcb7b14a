"""The machines of the ladder: one thing more each, the same masses, the twin among them."""

import dataclasses
import itertools

import numpy as np
import pytest

from stages.twin.machine.machine import build, join
from stages.twin_ladder.run import rungs, same


def test_each_rung_differs_from_the_one_before(machines):
    for one, other in itertools.pairwise(machines):
        assert not same(one.machine, other.machine)


def test_no_rung_changes_the_masses_of_table_1(machines, parameters):
    """But the outsole, which comes on top of them."""
    for rung in machines[:-1]:
        assert rung.machine.mass == pytest.approx(parameters.biped.total_mass, abs=1e-4)
        for pair in (rung.machine.bodies[1:3], rung.machine.bodies[4:6]):
            assert join(pair).mass == pytest.approx(parameters.biped.foot_mass, abs=5e-5)


def test_the_outsoles_weigh_what_their_rubber_does(machines, parameters):
    rubber = parameters.twin.mass(parameters.biped.foot_radius, parameters.settings.outsole)
    assert machines[-1].machine.mass - machines[-2].machine.mass == pytest.approx(4.0 * rubber) and rubber > 0.004


def test_the_twin_is_one_of_them(machines, parameters):
    (twin,) = [rung for rung in machines if rung.is_twin]
    assert same(twin.machine, build(parameters.biped, parameters.twin))
    assert machines[-1].name == "rubber outsoles" and not machines[-1].is_twin


def test_an_outsole_or_friction_of_the_twin_moves_it_up(parameters):
    soled = dataclasses.replace(parameters.twin, outsole=0.001, slider_friction=2.0)
    found = rungs(parameters.biped, soled, 0.002)
    assert [rung.is_twin for rung in found] == [False] * 5 + [True]
    assert found[-1].machine.length == pytest.approx(parameters.biped.leg_length + 0.001)
    assert found[-2].name == "joint friction"


def test_planar_inertia_leaves_out_the_rungs_of_the_parts(parameters):
    planar = dataclasses.replace(parameters.twin, inertia="planar")
    assert [rung.name for rung in rungs(parameters.biped, planar, 0.002)] == [
        "paired legs", "foot width", "rubber outsoles",
    ]  # fmt: skip


def test_distributed_inertia_keeps_the_mass_centres(machines):
    points, spread = (rung.machine for rung in machines[1:3])
    for one, other in zip(points.bodies, spread.bodies, strict=True):
        assert other.centre == pytest.approx(one.centre, abs=2e-6)
    assert np.trace(spread.bodies[1].inertia) > 0.0 and not points.bodies[1].inertia.any()
