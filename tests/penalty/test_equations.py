"""The derived equations against physics written down apart from them: momentum and energy in the air; guards."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.model.made import derived
from stages.penalty.model import walker
from stages.penalty.model.derivation import KINDS, module_source
from stages.penalty.model.walker import build_penalty
from stages.penalty.motion import feet
from stages.penalty.motion.accelerations import accelerations
from stages.planar.energy import damper_power, kinetic_energy, mass_moment, spring_energy
from tests.penalty.drawn import drawn_designs

#: Imaginary step in time [s], whose square is lost beside anything but zero: derivatives without truncation.
STEP = 1e-40
FLYING = feet.phase_of(feet.OUT, feet.OUT, 0)


def states(seed, count, biped):
    """States with feet 20 to 200 um deep (12,), motions as large as a walk's or larger."""
    generator = np.random.default_rng(seed)
    for _ in range(count):
        angle = generator.uniform(-0.4, 0.4, 2)
        length = biped.leg_length + generator.uniform(-4e-3, 4e-3, 2)
        rates = generator.uniform(-1.0, 1.0, 6) * [0.5, 0.05, 2.0, 2.0, 0.1, 0.1]
        lowest = (length - biped.foot_radius) * np.cos(angle) + biped.foot_radius
        yield np.array([generator.uniform(), lowest[0] - generator.uniform(2e-5, 2e-4), *angle, *length, *rates])


@pytest.fixture(params=["plain", "with inertia", "detailed"])
def machine(request, biped):
    """Table 1's biped, with inertia of its legs, and a design with every detail."""
    if request.param == "detailed":
        return next(drawn_designs(biped, 12, 1))
    return dataclasses.replace(biped, leg_inertia=0.0 if request.param == "plain" else 2e-4)


@pytest.mark.parametrize("called", KINDS)
def test_what_is_kept_is_what_the_derivation_gives(called):
    assert derived(walker.LEGS, called, walker.by_sympy).rpartition("# ")[0] == module_source(KINDS[called])


def test_in_the_air_momentum_changes_by_weight_and_energy_by_dampers(machine, slope, contact):
    """Along the motion, by a complex step through sums over the masses that `stages.planar.energy` writes down."""
    p, gravity = build_penalty(machine, slope.gravity_vector, contact, 0.5), np.array(slope.gravity_vector)
    for y in states(3, 20, machine):
        qdd = np.array(accelerations(FLYING, y, p)[0])
        place, motion = (y[:6] + 1j * STEP * y[6:])[None], (y[6:] + 1j * STEP * qdd)[None]
        ahead, behind = (mass_moment(machine, place + by * motion)[0].imag for by in (1e-6, -1e-6))
        assert (ahead - behind) / 2e-6 / STEP == pytest.approx(machine.weighed_mass * gravity, abs=1e-9)
        energy = kinetic_energy(machine, place, motion) + spring_energy(machine, place)
        energy -= mass_moment(dataclasses.replace(machine, hip_mass=machine.weighed_hip), place) @ gravity
        lost = float(damper_power(machine, y[None, 6:])[0])
        assert energy[0].imag / STEP == pytest.approx(-lost, abs=1e-13)


@pytest.mark.parametrize("status", [feet.OUT, feet.AWAITED, feet.LANDED])
def test_a_guards_change_is_its_derivative_and_a_leg_that_swings_up_leaves(biped, slope, contact, status):
    """Along any direction, by central differences; a foot in play that is above ground, behind and swings on is out."""
    p, generator = build_penalty(biped, slope.gravity_vector, contact, 0.5), np.random.default_rng(11)
    phase, left = feet.phase_of(feet.LANDED, status, 0), 0
    for y in states(6, 40, biped):
        dy = generator.normal(size=12)
        (before, _), (_, change), (after, _) = (
            feet.leg_guard(phase, y + step * dy, p, 1, dy, 0) for step in (-1e-7, 0.0, 1e-7))
        assert (after - before) / 2e-7 == pytest.approx(change, rel=1e-6, abs=1e-7)
        ahead = feet.place(y, p, 1, dy, 0)[0] - feet.place(y, p, 0, dy, 0)[0]
        if status != feet.OUT and feet.height(y, p, 1, dy, 0)[0] > 1e-6 and ahead < 0.0 < y[9]:
            assert feet.status_after(phase, y, p, 1) == feet.OUT
            left += 1
    assert left > 0 or status == feet.OUT
