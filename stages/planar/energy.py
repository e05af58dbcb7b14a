"""Where the energy of the walk goes: gravity's work against leg dampers, contact damping and friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.between_steps import quadrature
from stages.biped.design import Biped
from stages.biped.quantity import quantity
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import friction_coefficient
from stages.ground.normal_force import normal_force
from stages.ground.slope import Slope
from stages.planar.trajectory import Trajectory, foot_kinematics


@dataclass(frozen=True)
class EnergyBalance:
    """Work and losses over a span of the walk; the residual is what does not add up."""

    gravity_work: float = quantity("J", "work of gravity")
    leg_damper_loss: float = quantity("J", "energy lost in the dampers of both legs")
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
    """Energy balance between two times [s], the powers integrated by quadrature over the solver's own steps."""
    time, weight = quadrature(trajectory.time, start, end)
    position, velocity = trajectory.at(time)
    held = trajectory.in_play(time)
    damper = biped.damping * np.sum(velocity[:, 4:] ** 2, axis=1) if biped.legs == "compliant" else 0.0 * time
    normal_power, friction_power = np.zeros_like(time), np.zeros_like(time)
    for leg in (0, 1):
        depth, rate, slip = foot_kinematics(position, velocity, leg, biped.foot_radius)
        normal = np.where(held[:, leg], normal_force(contact, depth, rate), 0.0)
        normal_power += normal * rate
        friction_power += normal * friction_coefficient(contact, slip) * slip
    ends = np.array([start, end])
    place, motion = trajectory.at(ends)
    at_ends = trajectory.in_play(ends)
    machine = np.diff(kinetic_energy(biped, place, motion) + spring_energy(biped, place))[0]
    ground = np.diff(contact_energy(contact, biped.foot_radius, place, motion, at_ends))[0]
    gravity = np.diff(mass_moment(biped, place) @ np.array(slope.gravity_vector))[0]
    losses = weight @ damper, weight @ normal_power - ground, weight @ friction_power
    stored = machine + ground
    return EnergyBalance(*map(float, (gravity, *losses, stored, gravity - sum(losses) - stored)))


def mass_moment(biped: Biped, position: np.ndarray) -> np.ndarray:
    """Sum of mass times position [kg m] of hip and feet, (n, 2), from columns as in `Trajectory`."""
    moment = biped.hip_mass * position[:, :2]
    for leg in (0, 1):
        angle, arm = position[:, 2 + leg], position[:, 4 + leg] - biped.foot_com
        foot = position[:, :2] + np.column_stack([arm * np.sin(angle), -arm * np.cos(angle)])
        moment = moment + biped.foot_mass * foot
    return moment


def kinetic_energy(biped: Biped, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Kinetic energy [J], shape (n,)."""
    energy = 0.5 * biped.hip_mass * np.sum(velocity[:, :2] ** 2, axis=1)
    for leg in (0, 1):
        angle, rate = position[:, 2 + leg], velocity[:, 2 + leg]
        arm, arm_rate = position[:, 4 + leg] - biped.foot_com, velocity[:, 4 + leg]
        sine, cosine = np.sin(angle), np.cos(angle)
        across = velocity[:, 0] + arm_rate * sine + arm * rate * cosine
        upward = velocity[:, 1] - arm_rate * cosine + arm * rate * sine
        energy = energy + 0.5 * biped.foot_mass * (across**2 + upward**2) + 0.5 * biped.leg_inertia * rate**2
    return np.asarray(energy)


def spring_energy(biped: Biped, position: np.ndarray) -> np.ndarray:
    """Energy in the leg springs [J], shape (n,)."""
    if biped.legs == "rigid":
        return np.zeros(len(position))
    return np.asarray(0.5 * biped.stiffness * np.sum((position[:, 4:] - biped.leg_length) ** 2, axis=1))


def contact_energy(
    contact: ContactLaw, radius: float, position: np.ndarray, velocity: np.ndarray, held: np.ndarray
) -> np.ndarray:
    """Energy in the springs of the contacts that are in play [J]: k_c p^(e+1) / (e+1), shape (n,)."""
    exponent = contact.contact_exponent + 1.0
    energy = np.zeros(len(position))
    for leg in (0, 1):
        depth = np.maximum(foot_kinematics(position, velocity, leg, radius)[0], 0.0)
        energy += np.where(held[:, leg], contact.stiffness_si * depth**exponent / exponent, 0.0)
    return energy
