"""Where the energy of the twin's walk goes."""

from __future__ import annotations

import numpy as np

from stages.biped.between_steps import NODES, quadrature
from stages.twin.machine.contact import HINGE, SLIDE, along, point_law
from stages.twin.machine.kinematics import pair_axes, point_motion
from stages.twin.machine.machine import FOOT_BODY, Machine
from stages.twin.result import EnergyBalance
from stages.twin.walking.record import Record


def energy_balance(record: Record, start: float, end: float) -> EnergyBalance:
    """Energy balance between two times [s], the powers integrated by quadrature over the solver's own steps."""
    machine = record.machine
    time, weight = quadrature(record.time, start, end)
    q, v = record.at(time)
    # a switch happens at a solver step, so the middle of each span tells for the whole of it
    in_play = np.repeat(record.in_play(time[len(NODES) // 2 :: len(NODES)]), len(NODES), axis=0)
    ground = -along(q, v, in_play, machine.feet, point_law(record.contact))[1]
    legs = (machine.damping * v[:, list(SLIDE)] ** 2).sum(axis=1)
    bearing = machine.bearing_friction * v[:, HINGE] ** 2
    lost = float(weight @ legs), float(weight @ bearing), float(weight @ ground)
    (before, after), moment = mechanical_energy(machine, *record.at(np.array([start, end])))
    gravity = float((moment[1] - moment[0]) @ np.array([*record.slope.gravity_vector, 0.0]))
    stored = float(after - before)
    return EnergyBalance(gravity, *lost, stored, gravity - sum(lost) - stored)


def mechanical_energy(machine: Machine, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Kinetic energy plus that of the legs' springs [J] (n,), and sum of mass times position [kg m] (n, 3)."""
    energy = 0.5 * (machine.stiffness * q[:, list(SLIDE)] ** 2).sum(axis=1)
    moment = np.zeros((len(q), 3))
    none = np.zeros_like(q)
    axes = [pair_axes(q, v, none, pair) for pair in (0, 1)]
    slides: list[int | None] = [None] * 6
    for slide, foot in zip(SLIDE, FOOT_BODY, strict=True):
        slides[foot] = slide
    for index, body in enumerate(machine.bodies):
        pair = axes[index // 3]
        motion = point_motion(q, v, none, pair, body.centre, slides[index])
        spin = pair.components(pair.spin)
        energy += 0.5 * body.mass * (motion.velocity**2).sum(axis=1)
        energy += 0.5 * np.einsum("ij,jk,ik->i", spin, body.inertia, spin)
        moment += body.mass * motion.position
    return energy, moment
