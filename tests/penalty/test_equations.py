"""The derived equations against physics written down apart from them: momentum, energy, other ways to differentiate."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from stages.penalty.model import equations
from stages.penalty.model.generate import module_source
from stages.penalty.model.walker import SIZE, build_penalty
from stages.penalty.motion.accelerations import accelerations
from stages.penalty.motion.feet import AWAITED, LANDED, OUT, phase_of
from stages.penalty.motion.flow import penalty_rates
from stages.planar.energy import kinetic_energy, mass_moment, spring_energy

#: Step of the differences in time [s].
STEP = 1e-5
FLYING, STANDING = phase_of(OUT, OUT, 0), phase_of(LANDED, AWAITED, 0)


def states(seed, count, biped):
    """States with feet 20 to 200 um deep (12,), motions as large as a walk's or larger."""
    generator = np.random.default_rng(seed)
    for _ in range(count):
        angle = generator.uniform(-0.4, 0.4, 2)
        length = biped.leg_length + generator.uniform(-4e-3, 4e-3, 2)
        rates = generator.uniform(-1.0, 1.0, 6) * [0.5, 0.05, 2.0, 2.0, 0.1, 0.1]
        lowest = (length - biped.foot_radius) * np.cos(angle) + biped.foot_radius
        yield np.array([generator.uniform(), lowest[0] - generator.uniform(2e-5, 2e-4), *angle, *length, *rates])


def test_the_generated_file_is_what_the_derivation_gives():
    assert Path(equations.__file__).read_text() == module_source()


@pytest.mark.parametrize("inertia", [0.0, 2e-4])
def test_in_the_air_momentum_changes_by_weight_and_energy_by_dampers(biped, slope, contact, inertia):
    """By central differences along the motion, of sums over the masses that `stages.planar.energy` writes down."""
    machine = dataclasses.replace(biped, leg_inertia=inertia)
    p, gravity = build_penalty(machine, slope.gravity_vector, contact, 0.5), np.array(slope.gravity_vector)
    for y in states(3, 20, machine):
        qdd = np.array(accelerations(FLYING, y, p)[0])
        places = np.array([y[:6] + sign * STEP * y[6:] + 0.5 * STEP**2 * qdd for sign in (-1.0, 1.0)])
        motions = np.array([y[6:] + sign * STEP * qdd for sign in (-1.0, 1.0)])

        def moment(place, motion):
            ahead, behind = (mass_moment(machine, place + sign * 1e-6 * motion) for sign in (1.0, -1.0))
            return (ahead - behind) / 2e-6

        before, after = moment(places, motions)
        assert (after - before) / (2 * STEP) == pytest.approx(machine.total_mass * gravity, abs=2e-5)
        energy = kinetic_energy(machine, places, motions) + spring_energy(machine, places)
        energy -= mass_moment(machine, places) @ gravity
        lost = machine.damping * float(np.sum(y[10:] ** 2))
        assert np.diff(energy)[0] / (2 * STEP) == pytest.approx(-lost, abs=2e-6)


@pytest.mark.parametrize("law", ["impact", "restitution"])
def test_variations_follow_the_rates(biped, slope, contact, law):
    """Carried variations against central differences of the rates, one and both feet in the ground."""
    ground = dataclasses.replace(contact, normal_force=law)
    p = build_penalty(biped, slope.gravity_vector, ground, 0.5)
    for y in states(5, 12, biped):
        whole = np.concatenate([y, np.eye(SIZE).ravel()])
        rates = np.empty_like(whole)
        penalty_rates(STANDING, whole, p, rates)
        for column, own in enumerate(rates[SIZE:].reshape(SIZE, SIZE)):
            ends = []
            for sign in (1.0, -1.0):
                moved, found = y.copy(), np.empty(SIZE)
                moved[column] += sign * 1e-8
                penalty_rates(STANDING, moved, p, found)
                ends.append(found)
            numeric = (ends[0] - ends[1]) / 2e-8
            assert own == pytest.approx(numeric, rel=2e-5, abs=2e-5 * np.abs(rates[SIZE:]).max())


@pytest.mark.parametrize("legs", ["compliant", "rigid"])
def test_elimination_solves_the_whole_system(biped, slope, contact, legs):
    """Against the assembled matrix; rigid legs are the same without the rows and columns of the lengths."""
    p = build_penalty(dataclasses.replace(biped, legs=legs, leg_inertia=2e-4), slope.gravity_vector, contact, 0.5)
    kept = [0, 1, 2, 3, 4, 5] if legs == "compliant" else [0, 1, 2, 3]
    pressed = 0
    for y in states(7, 10, biped):
        qdd, force, _, *terms = accelerations(STANDING, y, p)
        pressed += force[0] > 0.0
        mass, load = np.diag([p.M, p.M, 0.0, 0.0, 0.0, 0.0]), np.array([p.M * p.g_x, p.M * p.g_y, 0.0, 0.0, 0.0, 0.0])
        for leg, t in enumerate(terms):
            part = np.diag([p.m, p.m, t[4], p.m])
            part[:2, 2:] = np.reshape(t[:4], (2, 2))
            part[2:, :2] = part[:2, 2:].T
            normal, friction = force[2 * leg : 2 * leg + 2]
            push = friction * np.array([1.0, 0.0, *t[14:16]]) + normal * np.array([0.0, 1.0, *t[12:14]])
            rows = [0, 1, 2 + leg, 4 + leg]
            mass[np.ix_(rows, rows)] += part
            load[rows] += np.array(t[5:9]) + push
        found = np.zeros(6)
        found[kept] = np.linalg.solve(mass[np.ix_(kept, kept)], load[kept])
        assert qdd == pytest.approx(found, rel=1e-11, abs=1e-11 * np.abs(found).max())
    assert pressed > 3
