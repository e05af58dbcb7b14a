"""The exports in the programs they are for: each gives the accelerations of the twin's coordinates without ground.

A function takes what is exported and returns a function of coordinates and rates (11,). ImportError if the program is
not installed.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from stages.twin.exports import mjcf, sdf, urdf
from stages.twin.exports.exported import Exported
from stages.twin.machine.contact import COUNT

Accelerations = Callable[[np.ndarray, np.ndarray], np.ndarray]


def in_mujoco(exported: Exported) -> Accelerations:
    import mujoco

    model = mujoco.MjModel.from_xml_string(mjcf.write(exported).decode())
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data = mujoco.MjData(model)

    def accelerations(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_forward(model, data)
        return np.array(data.qacc)

    return accelerations


def in_pinocchio(exported: Exported) -> Accelerations:
    """Springs are added as forces: URDF has none."""
    import pinocchio

    model = pinocchio.buildModelFromXML(urdf.write(exported).decode())
    data = model.createData()
    joints = [(joint, model.joints[model.getJointId(joint.name.replace(" ", "_"))])
              for joint, *_ in exported.coordinates()]  # fmt: skip
    assert model.nv == COUNT

    def accelerations(position: np.ndarray, rate: np.ndarray) -> np.ndarray:
        q, v, force, found = pinocchio.neutral(model), np.zeros(COUNT), np.zeros(COUNT), np.zeros(COUNT)
        for joint, at in joints:
            value = position[joint.row]
            q[at.idx_q : at.idx_q + at.nq] = value if at.nq == 1 else (np.cos(value), np.sin(value))
            v[at.idx_v] = rate[joint.row]
            force[at.idx_v] = -joint.stiffness * (value - joint.rest) - joint.damping * rate[joint.row]
        answer = pinocchio.aba(model, data, q, v, force)
        for joint, at in joints:
            found[joint.row] = answer[at.idx_v]
        return found

    return accelerations


def in_drake(exported: Exported, form: str) -> Accelerations:
    """From `sdf` or `urdf`; with the latter springs are added as forces."""
    from pydrake import all as drake

    plant: Any = drake.MultibodyPlant(0.0)
    text = {"sdf": sdf, "urdf": urdf}[form].write(exported).decode()
    drake.Parser(plant).AddModelsFromString(text, form)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    joints = [(joint, plant.GetJointByName(joint.name if form == "sdf" else joint.name.replace(" ", "_")))
              for joint, *_ in exported.coordinates()]  # fmt: skip

    def accelerations(position: np.ndarray, rate: np.ndarray) -> np.ndarray:
        found, force = np.zeros(COUNT), np.zeros(COUNT)
        for joint, there in joints:
            (there.set_angle if joint.turns else there.set_translation)(context, position[joint.row])
            (there.set_angular_rate if joint.turns else there.set_translation_rate)(context, rate[joint.row])
            if form == "urdf":
                force[there.velocity_start()] = -joint.stiffness * (position[joint.row] - joint.rest)
        plant.get_applied_generalized_force_input_port().FixValue(context, force)
        rates = plant.EvalTimeDerivatives(context).CopyToVector()[COUNT:]
        for joint, there in joints:
            found[joint.row] = rates[there.velocity_start()]
        return found

    return accelerations


#: Program and format -> the package it needs, and its accelerations.
PEERS: dict[str, tuple[str, Callable[[Exported], Accelerations]]] = {
    "MuJoCo, mjcf": ("mujoco", in_mujoco),
    "Pinocchio, urdf": ("pinocchio", in_pinocchio),
    "Drake, urdf": ("pydrake", lambda exported: in_drake(exported, "urdf")),
    "Drake, sdf": ("pydrake", lambda exported: in_drake(exported, "sdf")),
}
