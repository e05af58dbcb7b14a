"""Single stance with a motor and Coulomb friction at the hip: its equations, its derivatives."""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.walk.driven_stance import driven_stance
from stages.biped.design import Biped
from stages.ground.slope import Slope
from tests.analytic.differences import extrapolated

#: Two legs on points, level ground, a hip with a counterweight: of the size of a small robot.
ROBOT = Biped(
    "rigid", 2.0, 0.7, 0.28, 0.0, 0.235, 1000.0, 0.0, 0.003, hip_gravity_mass=-0.4, hip_damping=0.0016,
    other_foot_com=0.23, other_leg_inertia=0.0031)  # fmt: skip
INTERVAL, SAMPLES = 0.005, 100
SIGNAL = 0.16 * np.sin(0.35 * np.arange(SAMPLES))
START = np.array([-0.05, -0.05, 0.4, 0.2])
NAMES = ("biped.hip_mass", "biped.hip_gravity_mass", "biped.foot_com", "biped.other_foot_com", "biped.foot_mass",
         "biped.other_leg_inertia", "biped.hip_damping", "biped.hip_friction")  # fmt: skip


def design(friction=0.0, **values):
    return DesignPoint(dataclasses.replace(ROBOT, hip_friction=friction, **values), Slope(slope_deg=0.0, gravity=9.81))


def relative_rate(states):
    return states[:, 2] + states[:, 3]


@pytest.mark.parametrize("friction", [0.0, 0.02])
def test_the_equations_are_lagranges(friction):
    """Against SciPy on equations written down by hand for two rods on a point, with angles of their own."""
    b, g = ROBOT, 9.81
    length, below, other = 0.28, 0.28 - b.foot_com, 0.28 - b.leg(1).foot_com
    m, stance, swing = b.foot_mass, b.leg_inertia, b.leg(1).leg_inertia

    def rates(t, y):
        q, s, dq, ds = y  # of the stance leg, hip ahead; of the swing leg, foot ahead
        torque = np.interp(t, INTERVAL * np.arange(SAMPLES), SIGNAL) - b.hip_damping * (dq + ds)
        torque -= friction * np.sign(dq + ds)
        mixed = m * other * length * np.cos(q + s)
        mass = [[(b.hip_mass + m) * length**2 + m * (length - below) ** 2 + stance, mixed],
                [mixed, m * other**2 + swing]]  # fmt: skip
        centrifugal = m * other * length * np.sin(q + s)
        weight = (b.hip_gravity_mass + m) * length + m * (length - below)
        force = [weight * g * np.sin(q) + centrifugal * ds**2 + torque,
                 -m * g * other * np.sin(s) + centrifugal * dq**2 + torque]  # fmt: skip
        return [dq, ds, *np.linalg.solve(mass, force)]

    times = INTERVAL * np.arange(SAMPLES)
    wanted = solve_ivp(rates, (0, times[-1]), START, "DOP853", times, rtol=1e-11, atol=1e-12, max_step=INTERVAL).y.T
    found = driven_stance(design(friction), START, INTERVAL, SIGNAL)
    assert np.abs(found.states - wanted).max() < 1e-8


@pytest.mark.parametrize(("friction", "sticks"), [(0.03, False), (0.12, True), (0.5, True)])
def test_derivatives_through_slip_and_stick_are_those_of_differences(friction, sticks):
    here = design(friction)
    found = driven_stance(here, START, INTERVAL, SIGNAL, NAMES, SIGNAL[None])
    assert (np.abs(relative_rate(found.states)) < 1e-12).any() == sticks
    assert (np.abs(np.diff(np.sign(np.round(relative_rate(found.states), 9)))) > 0).sum() >= 1

    def end(where, scale=1.0, start=START):
        return driven_stance(where, start, INTERVAL, scale * SIGNAL).states[-1]

    for column, name in enumerate(NAMES):
        value = here.value(name)
        wanted = extrapolated(lambda h: end(here.with_value(name, value + h)), 1e-4 * max(abs(value), 0.01))  # noqa: B023
        exact = found.along[-1, :, column]
        assert np.abs(exact - wanted).max() < 2e-7 * np.abs(found.along[:, :, column]).max(), name
    assert np.abs(found.along[-1, :, -1] - extrapolated(lambda h: end(here, 1 + h), 1e-5)).max() < 1e-6
    for column, unit in enumerate(np.eye(4)):
        wanted = extrapolated(lambda h: end(here, 1.0, START + h * unit), 1e-5)  # noqa: B023
        assert np.abs(found.by_start[-1, :, column] - wanted).max() < 1e-6


def test_a_hip_that_sticks_is_one_rigid_body():
    states = driven_stance(design(10.0), np.array([-0.1, 0.2, 1.0, -1.0]), INTERVAL, SIGNAL).states
    assert np.ptp(states[:, 0] + states[:, 1]) < 1e-12
    assert np.ptp(states[:, 0]) > 0.1


def test_compliant_legs_are_refused():
    with pytest.raises(ValueError, match="rigid legs"):
        driven_stance(design(legs="compliant"), START, INTERVAL, SIGNAL)
