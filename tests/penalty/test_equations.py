"""The derived equations against physics written down apart from them: momentum, energy, other ways to differentiate."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.model.made import derived
from stages.biped.accuracy.scales import SI
from stages.penalty.model import walker
from stages.penalty.model.changes import changes_of, names_of
from stages.penalty.model.derivation import KINDS, module_source
from stages.penalty.model.walker import SIZE, build_penalty
from stages.penalty.motion.accelerations import accelerations, hip_load
from stages.penalty.motion.engine import penalty_rates
from stages.penalty.motion.feet import AWAITED, LANDED, OUT, phase_of
from stages.penalty.step_map import changed
from stages.planar.energy import damper_power, kinetic_energy, mass_moment, spring_energy
from tests.analytic.differences import extrapolated
from tests.penalty.drawn import drawn_designs

#: Imaginary step in time [s], whose square is lost beside anything but zero: derivatives without truncation.
STEP = 1e-40
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


@pytest.fixture(params=["impact", "restitution"])
def model(request, machine, slope, contact):
    """Each machine on ground of either law."""
    return machine, slope, dataclasses.replace(contact, normal_force=request.param)


def built(biped, slope, contact):
    return build_penalty(biped, slope.gravity_vector, contact, 0.5)


def rates_of(y, p, *directions):
    """Rates of a state, or of a state with variations."""
    found = np.empty_like(y)
    penalty_rates(STANDING, y, p, found, *directions)
    return found


def test_variations_follow_the_rates(model):
    """Carried variations against central differences of the rates, one and both feet in the ground."""
    p = built(*model)
    for y in states(5, 12, model[0]):
        carried = rates_of(np.concatenate([y, np.eye(SIZE).ravel()]), p)[SIZE:].reshape(SIZE, SIZE)
        for own, change in zip(carried, 1e-8 * np.eye(SIZE), strict=True):
            numeric = (rates_of(y + change, p) - rates_of(y - change, p)) / 2e-8
            assert own == pytest.approx(numeric, rel=2e-5, abs=2e-5 * np.abs(carried).max())


def test_changes_of_the_numbers_follow_the_rates(model):
    """The rates of variations by every parameter against extrapolated differences of the rates of changed walkers."""
    names = names_of(*model)
    changes, p = changes_of(*model, names, SI), built(*model)
    for y in states(9, 4, model[0]):
        whole = np.concatenate([y, np.zeros(SIZE * len(names))])
        rates = rates_of(whole, p, changes.directions(len(names)))
        for name, scale, own in zip(names, changes.scales, rates[SIZE:].reshape(-1, SIZE), strict=True):

            def there(share):
                return rates_of(y, built(*changed(*model, name, share * scale)))  # noqa: B023

            numeric, noise = extrapolated(there, 1e-4), 2e-15 * np.abs(rates[:SIZE]).max() / 1e-4
            assert own == pytest.approx(numeric, rel=0, abs=1e-7 * np.abs(numeric).max() + noise), name


@pytest.mark.parametrize("legs", ["compliant", "rigid"])
def test_elimination_solves_the_whole_system(machine, slope, contact, legs):
    """Against the assembled matrix; rigid legs are the same without the rows and columns of the lengths."""
    design = dataclasses.replace(machine, legs=legs)
    gravity = np.array(slope.gravity_vector)
    p, hip = build_penalty(design, slope.gravity_vector, contact, 0.5), design.weighed_hip * gravity
    kept = [0, 1, 2, 3, 4, 5] if legs == "compliant" else [0, 1, 2, 3]
    pressed = 0
    for y in states(7, 10, machine):
        qdd, force, _, *terms = accelerations(STANDING, y, p)
        pressed += force[0] > 0.0
        mass, load = np.diag([p.M, p.M, 0.0, 0.0, 0.0, 0.0]), np.array([*hip, 0.0, 0.0, 0.0, 0.0])
        load[2] += hip_load(y, p)[2]
        load[3] -= hip_load(y, p)[2]
        for number, t in enumerate(terms):
            leg = design.leg(number)
            along = leg.foot_mass + leg.frame_mass
            part = np.diag([along, along, t[4], leg.foot_mass])
            part[2, 3] = part[3, 2] = t[16]
            part[:2, 2:] = np.reshape(t[:4], (2, 2))
            part[2:, :2] = part[:2, 2:].T
            normal, friction = force[2 * number : 2 * number + 2]
            push = friction * np.array([1.0, 0.0, *t[14:16]]) + normal * np.array([0.0, 1.0, *t[12:14]])
            rows = [0, 1, 2 + number, 4 + number]
            mass[np.ix_(rows, rows)] += part
            load[rows] += np.array(t[5:9]) + push
        found = np.zeros(6)
        found[kept] = np.linalg.solve(mass[np.ix_(kept, kept)], load[kept])
        assert qdd == pytest.approx(found, rel=1e-11, abs=1e-11 * np.abs(found).max())
    assert pressed > 3
