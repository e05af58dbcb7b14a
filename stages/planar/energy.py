"""Where the energy of the walk goes: gravity's work against leg dampers, contact damping and friction."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from stages.biped.between_steps import quadrature
from stages.biped.design import Biped
from stages.biped.quantity import quantity
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import friction_coefficient, normal_force
from stages.ground.slope import Slope
from stages.planar.run import Trajectory, foot_kinematics


@dataclass(frozen=True)
class EnergyBalance:
    """Work and losses over a span of the walk; the residual is what does not add up."""

    gravity_work: float = quantity("J", "work of gravity")
    leg_damper_loss: float = quantity("J", "energy lost in dampers, and in friction at the hip")
    contact_damping_loss: float = quantity("J", "energy lost in the damping of the contact")
    friction_loss: float = quantity("J", "energy lost to friction, creep included")
    stored: float = quantity("J", "increase of kinetic energy and of the energy in leg and contact springs")
    residual: float = quantity("J", "work of gravity less losses and stored energy")

    @property
    def relative_residual(self) -> float:
        """Residual as a part of the work of gravity."""
        return abs(self.residual / self.gravity_work)


def energy_balance(
    trajectory: Trajectory, biped: Biped, slope: Slope, contact: ContactLaw, start: float, end: float
) -> EnergyBalance:
    """Energy balance between two times [s], the powers integrated by quadrature over the solver's own steps.

    The hip's damper and friction count among the legs' dampers, its spring among the legs' springs.
    """
    time, weight = quadrature(trajectory.time, start, end)
    position, velocity = trajectory.at(time)
    held, blocks = trajectory.in_play(time), trajectory.under(time)
    damper = damper_power(biped, velocity)
    normal_power, friction_power = np.zeros_like(time), np.zeros_like(time)
    for leg in (0, 1):
        depth, rate, slip = foot_kinematics(position, velocity, leg, biped.foot_radii[leg], blocks[:, leg])
        normal = np.where(held[:, leg], normal_force(contact, depth, rate), 0.0)
        normal_power += normal * rate
        friction_power += normal * friction_coefficient(contact, slip) * slip
    ends = np.array([start, end])
    place, motion = trajectory.at(ends)
    at_ends = trajectory.in_play(ends)
    machine = np.diff(kinetic_energy(biped, place, motion) + spring_energy(biped, place))[0]
    ground = np.diff(contact_energy(
        contact, biped.foot_radii, place, motion, at_ends, trajectory.under(ends)))[0]  # fmt: skip
    weighed = replace(biped, hip_mass=biped.weighed_hip)
    gravity = np.diff(mass_moment(weighed, place) @ np.array(slope.gravity_vector))[0]
    losses = weight @ damper, weight @ normal_power - ground, weight @ friction_power
    stored = machine + ground
    return EnergyBalance(*map(float, (gravity, *losses, stored, gravity - sum(losses) - stored)))


def damper_power(biped: Biped, velocity: np.ndarray) -> np.ndarray:
    """Power lost in the dampers of the legs and in the hip [W], shape (n,)."""
    power = np.zeros(len(velocity))
    if biped.legs == "compliant":
        power = _of_legs(biped.leg(0).damping, biped.leg(1).damping, velocity[:, 4:] ** 2)
    if biped.hip_damping or biped.hip_friction:
        rate = velocity[:, 2] - velocity[:, 3]
        power = power + biped.hip_damping * rate**2 + biped.hip_friction * np.abs(rate)
    return power


def _of_legs(first: float, other: float, columns: np.ndarray) -> np.ndarray:
    """Columns (n, 2) times a factor each, summed (n,); equal factors last, so that they cost no round-off."""
    if first == other:
        return np.asarray(first * np.sum(columns, axis=1))
    return np.asarray(first * columns[:, 0] + other * columns[:, 1])


#: A body: mass [kg], inertia [kg m^2], place [m] and velocity [m/s], each (n, 2), and rate [rad/s] (n,).
Piece = tuple[float, float, np.ndarray, np.ndarray, np.ndarray]


def _pieces(biped: Biped, position: np.ndarray, velocity: np.ndarray) -> Iterator[Piece]:
    """Feet, and frames where there are any."""
    for number in (0, 1):
        leg = biped.leg(number)
        angle, rate = position[:, 2 + number], velocity[:, 2 + number]
        sine, cosine, none = np.sin(angle), np.cos(angle), np.zeros(len(angle))
        length, speed = position[:, 4 + number], velocity[:, 4 + number]
        bodies = [(leg.foot_mass, leg.leg_inertia, length - leg.foot_com, speed, leg.foot_offset)]
        if leg.frame_mass or leg.frame_inertia:
            bodies.append((leg.frame_mass, leg.frame_inertia, none + leg.frame_com, none, leg.frame_offset))
        for mass, inertia, arm, moving, aside in bodies:
            place = np.column_stack([arm * sine + aside * cosine, -arm * cosine + aside * sine])
            across = velocity[:, 0] + moving * sine + arm * rate * cosine - aside * rate * sine
            upward = velocity[:, 1] - moving * cosine + arm * rate * sine + aside * rate * cosine
            yield mass, inertia, position[:, :2] + place, np.column_stack([across, upward]), rate


def mass_moment(biped: Biped, position: np.ndarray) -> np.ndarray:
    """Sum of mass times position [kg m] of all bodies, (n, 2), from columns as in `Trajectory`."""
    moment = biped.hip_mass * position[:, :2]
    for mass, _, place, _, _ in _pieces(biped, position, np.zeros_like(position)):
        moment = moment + mass * place
    return moment


def kinetic_energy(biped: Biped, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Kinetic energy [J], shape (n,)."""
    energy = 0.5 * biped.hip_mass * np.sum(velocity[:, :2] ** 2, axis=1)
    for mass, inertia, _, motion, rate in _pieces(biped, position, velocity):
        energy = energy + 0.5 * mass * np.sum(motion**2, axis=1) + 0.5 * inertia * rate**2
    return np.asarray(energy)


def spring_energy(biped: Biped, position: np.ndarray) -> np.ndarray:
    """Energy in the springs of legs and hip [J], shape (n,)."""
    energy = np.zeros(len(position))
    if biped.legs == "compliant":
        first, other = biped.leg(0), biped.leg(1)
        strains = position[:, 4:] - np.array([first.leg_length, other.leg_length])
        energy = _of_legs(0.5 * first.stiffness, 0.5 * other.stiffness, strains**2)
    if biped.hip_stiffness:
        turned = position[:, 2] - position[:, 3] - biped.hip_rest_angle
        energy = energy + 0.5 * biped.hip_stiffness * turned**2
    return energy


def contact_energy(
    contact: ContactLaw, radii: tuple[float, float], position: np.ndarray, velocity: np.ndarray, held: np.ndarray,
    ground: np.ndarray,
) -> np.ndarray:
    """Energy in the springs of the contacts that are in play [J]: k_c p^(e+1) / (e+1), shape (n,).

    `ground` (n, 2) [m]: heights of what the feet are over.
    """
    exponent = contact.contact_exponent + 1.0
    energy = np.zeros(len(position))
    for leg in (0, 1):
        depth = np.maximum(foot_kinematics(position, velocity, leg, radii[leg], ground[:, leg])[0], 0.0)
        energy += np.where(held[:, leg], contact.stiffness_si * depth**exponent / exponent, 0.0)
    return energy
