"""The same walker with the same contact law in Exudyn, MuJoCo and Drake: time at equal error.

    python benchmarks/other_engines.py

MuJoCo and Drake have no contact law of this kind. The law is therefore applied as a force, in each engine's own
equations of motion and with its own integrator that converges: MuJoCo's RK4 at fixed steps, Drake's continuous mode
with error-controlled Runge-Kutta. Their forces come from Python at every evaluation, so a second time is given with
the time spent in Python taken off; Exudyn's is compiled. The walk is 0.3 s from mid-stance, through heel strike and
toe-off; foot 1 acts once it is ahead, which is the ideal rule of the study over this span. Errors are the largest
difference of the hip's position from Exudyn at tolerance 1e-11. Neither engine is a dependency of the study.
"""

import dataclasses
import importlib.util
import math
import time
from typing import Any

import numpy as np
from penalty_step import STANDING_FORCE, START, parameters

from stages.ground.contact_law import ContactLaw
from stages.ground.friction import SCALARS
from stages.multibody.assembly.contact import disc_force
from stages.multibody.parameters import Parameters
from stages.multibody.walking.walk import build, simulate
from stages.planar.run import PlanarState, rolling_state

DURATION = 0.3
GRID = np.linspace(0.0, DURATION, 601)


class Ground:
    """Generalised force of the ground on (x, y, phi_0, s_0, phi_1, s_1), s a leg's shortening; counts its calls."""

    def __init__(self, law: ContactLaw, radius: float, leg_length: float) -> None:
        self.law, self.radius, self.reach = law, radius, leg_length - radius
        self.calls, self.seconds = 0, 0.0

    def __call__(self, q: Any, v: Any) -> np.ndarray:
        began = time.process_time()
        force = np.zeros(6)
        reach = [self.reach - q[3], self.reach - q[5]]
        ahead = q[0] + reach[1] * math.sin(q[4]) > q[0] + reach[0] * math.sin(q[2])
        for leg in (0, 1) if ahead else (0,):
            angle, rate, out = q[2 + 2 * leg], v[2 + 2 * leg], -v[3 + 2 * leg]
            sine, cosine, arm = math.sin(angle), math.cos(angle), reach[leg]
            height = q[1] - arm * cosine
            if height >= self.radius:
                continue
            along = v[0] + out * sine + arm * rate * cosine
            upward = v[1] - out * cosine + arm * rate * sine
            fx, fy = disc_force(self.law, self.radius, height, along, upward, rate, SCALARS)
            force[0] += fx
            force[1] += fy
            force[2 + 2 * leg] += fx * (arm * cosine + self.radius) + fy * arm * sine
            force[3 + 2 * leg] += -fx * sine + fy * cosine
        self.calls += 1
        self.seconds += time.process_time() - began
        return force


def coordinates(given: Parameters, state: PlanarState) -> tuple[np.ndarray, np.ndarray]:
    """(x, y, phi_0, s_0, phi_1, s_1) and rates of a state."""
    natural = given.biped.leg_length
    (a, b), (la, lb) = state.leg_angle, state.leg_length
    (ra, rb), (da, db) = state.leg_rate, state.leg_length_rate
    return np.array([*state.hip_position, a, natural - la, b, natural - lb]), np.array(
        [*state.hip_velocity, ra, -da, rb, -db]
    )


def mujoco_walk(given: Parameters, state: PlanarState, step: float) -> tuple[np.ndarray, float, Ground]:
    """Hip position on the grid, processor time, and the ground with its counts, by MuJoCo's RK4."""
    import mujoco

    biped, (gx, gy) = given.biped, given.slope.gravity_vector
    spring = f'stiffness="{biped.stiffness}" damping="{biped.damping}"'
    place = f'pos="0 {biped.foot_com - biped.leg_length} 0" mass="{biped.foot_mass}"'
    leg = (
        f'<body><joint type="hinge" axis="0 0 1"/><joint type="slide" axis="0 1 0" {spring}/>'
        f'<inertial {place} diaginertia="1e-12 1e-12 1e-12"/></body>'
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option integrator="RK4" timestep="{step}" gravity="{gx} {gy} 0"><flag contact="disable"/></option>'
        '<worldbody><body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'
        f'<inertial pos="0 0 0" mass="{biped.hip_mass}" diaginertia="1e-12 1e-12 1e-12"/>{leg}{leg}</body>'
        "</worldbody></mujoco>"
    )
    data, ground = mujoco.MjData(model), Ground(given.contact, biped.foot_radius, biped.leg_length)
    data.qpos[:], data.qvel[:] = coordinates(given, state)

    def passive(_: Any, now: Any) -> None:
        now.qfrc_passive[:] += ground(now.qpos.tolist(), now.qvel.tolist())

    mujoco.set_mjcb_passive(passive)
    record = [(0.0, *data.qpos[:2], *data.qvel[:2])]
    began = time.process_time()
    try:
        for _ in range(round(DURATION / step)):
            mujoco.mj_step(model, data)
            record.append((data.time, *data.qpos[:2], *data.qvel[:2]))
    finally:
        mujoco.set_mjcb_passive(None)
    spent = time.process_time() - began
    return _between(np.array(record)), spent, ground


def drake_walk(given: Parameters, state: PlanarState, accuracy: float) -> tuple[np.ndarray, float, Ground]:
    """The same by Drake's continuous mode: error-controlled Runge-Kutta of third order."""
    from pydrake.all import (
        DiagramBuilder,
        LeafSystem,
        MultibodyPlant,
        PrismaticJoint,
        ResetIntegratorFromFlags,
        RevoluteJoint,
        RotationalInertia,
        Simulator,
        SpatialInertia,
    )

    biped, ground = given.biped, Ground(given.contact, given.biped.foot_radius, given.biped.leg_length)
    plant = MultibodyPlant(time_step=0.0)
    massless, slim = SpatialInertia.Zero(), RotationalInertia(1e-12, 1e-12, 1e-12)

    def point(mass: float, y: float = 0.0) -> Any:
        return SpatialInertia.MakeFromCentralInertia(mass, [0.0, y, 0.0], slim)

    carriage = plant.AddRigidBody("carriage", massless)
    hip = plant.AddRigidBody("hip", point(biped.hip_mass))
    world = plant.world_frame()
    plant.AddJoint(PrismaticJoint("x", world, carriage.body_frame(), [1, 0, 0]))
    plant.AddJoint(PrismaticJoint("y", carriage.body_frame(), hip.body_frame(), [0, 1, 0]))
    for leg in (0, 1):
        shaft = plant.AddRigidBody(f"shaft {leg}", massless)
        foot = plant.AddRigidBody(f"foot {leg}", point(biped.foot_mass, biped.foot_com - biped.leg_length))
        plant.AddJoint(RevoluteJoint(f"phi {leg}", hip.body_frame(), shaft.body_frame(), [0, 0, 1]))
        slide = PrismaticJoint(f"s {leg}", shaft.body_frame(), foot.body_frame(), [0, 1, 0], damping=biped.damping)
        plant.AddJoint(slide)
    plant.mutable_gravity_field().set_gravity_vector([*given.slope.gravity_vector, 0.0])
    plant.Finalize()
    order = [plant.GetJointByName(name).position_start() for name in ("x", "y", "phi 0", "s 0", "phi 1", "s 1")]

    class Law(LeafSystem):
        def __init__(self) -> None:
            super().__init__()
            self.DeclareVectorInputPort("state", 12)
            self.DeclareVectorOutputPort("force", 6, self.force)

        def force(self, context: Any, output: Any) -> None:
            values = self.get_input_port().Eval(context)
            q, v = values[:6][order].tolist(), values[6:][order].tolist()
            total = ground(q, v)
            total[3] -= biped.stiffness * q[3]
            total[5] -= biped.stiffness * q[5]
            placed = np.zeros(6)
            placed[order] = total
            output.SetFromVector(placed)

    builder = DiagramBuilder()
    builder.AddSystem(plant)
    law = builder.AddSystem(Law())
    builder.Connect(plant.get_state_output_port(), law.get_input_port())
    builder.Connect(law.get_output_port(), plant.get_applied_generalized_force_input_port())
    diagram = builder.Build()
    simulator = Simulator(diagram)
    integrator = ResetIntegratorFromFlags(simulator, "runge_kutta3", 2e-3)
    integrator.set_target_accuracy(accuracy)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    q, v = coordinates(given, state)
    values = np.zeros(12)
    values[:6][order], values[6:][order] = q, v
    plant.SetPositionsAndVelocities(context, values)
    record = [(0.0, *q[:2], *v[:2])]

    def watched(root: Any) -> None:
        now = plant.GetMyContextFromRoot(root)
        place, motion = plant.GetPositions(now)[order[:2]], plant.GetVelocities(now)[order[:2]]
        record.append((root.get_time(), *place, *motion))

    simulator.set_monitor(watched)
    began = time.process_time()
    simulator.AdvanceTo(DURATION)
    return _between(np.array(record)), time.process_time() - began, ground


def _between(record: np.ndarray) -> np.ndarray:
    """Hip position on the grid from rows of time, position and velocity at the integrator's steps."""
    from scipy.interpolate import CubicHermiteSpline

    rows = record[np.concatenate([[True], np.diff(record[:, 0]) > 0.0])]
    return np.asarray(CubicHermiteSpline(rows[:, 0], rows[:, 1:3], rows[:, 3:])(np.minimum(GRID, rows[-1, 0])))


def main() -> None:
    given = parameters()
    state = rolling_state(given.biped, given.contact, START, STANDING_FORCE)
    base = dataclasses.replace(given.settings, assembly="tree", largest_step=2e-3)

    def exudyn_walk(tolerance: float, largest: float = 2e-3) -> tuple[np.ndarray, float, int]:
        settings = dataclasses.replace(base, tolerance=tolerance, largest_step=largest)
        machine = build(given.biped, given.slope, given.contact, settings)
        began = time.process_time()
        run = simulate(given.biped, given.slope, given.contact, state, settings, duration=DURATION, assembly=machine)
        return run.trajectory.at(GRID)[0][:, :2], time.process_time() - began, run.solver_steps

    truth = exudyn_walk(1e-11, 2e-4)[0]
    print(f"{'':44}{'hip error':>10}{'s per s':>10}{'less Python':>12}{'law calls':>10}")

    def row(name: str, place: np.ndarray, spent: float, python: float, calls: object) -> None:
        error, own = np.abs(place - truth).max(), (spent - python) / DURATION
        print(f"{name:44}{error:10.1e}{spent / DURATION:10.3f}{own:12.3f}{calls!s:>10}", flush=True)

    for tolerance in (1e-4, 1e-5, 1e-6, 1e-8):
        place, spent, _ = min((exudyn_walk(tolerance) for _ in range(5)), key=lambda one: one[1])
        row(f"Exudyn, DOPRI5, tolerance {tolerance:.0e}", place, spent, 0.0, "compiled")
    for name, walk, accuracies in (
        ("mujoco", mujoco_walk, (2e-4, 1e-4, 5e-5, 2e-5)), ("pydrake", drake_walk, (1e-2, 1e-3, 1e-4, 1e-6))
    ):  # fmt: skip
        if importlib.util.find_spec(name) is None:
            print(f"{name} is not installed: its rows are left out")
            continue
        for accuracy in accuracies:
            place, spent, ground = min((walk(given, state, accuracy) for _ in range(2)), key=lambda one: one[1])
            what = "MuJoCo, RK4, step" if name == "mujoco" else "Drake, RK3, accuracy"
            row(f"{what} {accuracy:.0e}", place, spent, ground.seconds, ground.calls)


if __name__ == "__main__":
    main()
