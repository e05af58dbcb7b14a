"""An Exudyn system with what all of ours share: signals kept at every step, a start, a kinematic tree.

Exudyn, loaded so that it is fast, opens no window, prints nothing and reads no settings from the user's home folder.

Everything of Exudyn is imported through this module, because how it loads is decided at its first import. Its fast
build, without range checks, takes the same steps in 0.7 times the time; where the processor has no AVX2 Exudyn loads
the other one by itself. A test walks with both.
"""

import contextlib
import io
import os
import sys
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np

from stages.ground.slope import Slope
from stages.multibody.walking.watch import Look

os.environ.setdefault("EXUDYN_NO_USER_SETTINGS", "1")  # such settings would make runs differ between machines
if not hasattr(sys, "exudynFast"):
    sys.exudynFast = True  # type: ignore[attr-defined]

with contextlib.redirect_stdout(io.StringIO()):  # the fast build says its name, settings or not
    import exudyn
    from exudyn import itemInterface as items
    from exudyn.utilities import CreateSymbolicUserFunction

exudyn.config.printToConsole = False
exudyn.special.userInterface.SuppressAll(True)  # its renderer aborts a process that has no display

symbolic: Any = exudyn.symbolic
#: What a solver raises; the checked build wraps a watch's RuntimeError, the fast one hands it on.
SOLVER_ERRORS = (exudyn.ExudynError, RuntimeError)
#: Version and build, as artefacts show them.
VERSION = f"{exudyn.__version__} ({'fast' if 'exudyn.exudynCPPfast' in sys.modules else 'checked'} build)"

__all__ = ["SOLVER_ERRORS", "VERSION", "CreateSymbolicUserFunction", "exudyn", "items", "symbolic"]


OUTPUT = exudyn.OutputVariableType
#: Signals of a node by which the motion is known.
COORDINATES = (
    ("position", OUTPUT.Coordinates),
    ("velocity", OUTPUT.Coordinates_t),
    ("acceleration", OUTPUT.Coordinates_tt),
)


class System(ABC):
    """A system to be filled, that walks; `drift` is the largest violation of a joint in the last solver call [m]."""

    exact_acceleration = True
    drift = 0.0

    def __init__(self) -> None:
        self.container = exudyn.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.sensors: dict[str, Any] = {}

    @abstractmethod
    def look(self) -> Look:
        """Where it is at the current step."""

    @abstractmethod
    def leg_rate(self, leg: int) -> float:
        """Rate of a leg's angle at the current step [rad/s]."""

    @abstractmethod
    def set_in_play(self, leg: int, acts: bool) -> None:
        """Let the ground act on a leg's foot, or not."""

    @abstractmethod
    def set_height(self, leg: int, height: float) -> None:
        """Put a block of this height [m] under a leg's foot."""

    @abstractmethod
    def recording(self) -> dict[str, np.ndarray]:
        """Signals of the last solver call by name: `time` and what the motion is known by."""

    def keep(self, name: str, sensor: Any, **of: Any) -> None:
        """Keep a signal at every step under a name."""
        self.sensors[name] = self.mbs.AddSensor(sensor(**of, storeInternal=True, writeToFile=False))

    def add_tree(
        self, slope: Slope, joints: Sequence[Any], parents: Sequence[int], bodies: dict[int, tuple[float, Any, Any]],
        offsets: np.ndarray, spring: np.ndarray, damper: np.ndarray, relaxed: np.ndarray | None = None
    ) -> None:
        """Add a kinematic tree, whose motion is kept. Each joint is a coordinate and a link.

        `bodies`: mass [kg], mass centre (3,) [m] and tensor of inertia about it (3, 3) [kg m^2] of links.
        `offsets` (n, 3) [m] of links from their parents; `spring` [N/m] and `damper` [N s/m] of joints, (n,),
        and the coordinates at which the springs are `relaxed`, zero if not given.
        """
        count = len(joints)
        nothing = np.zeros(count)
        mass, centre, inertia = np.zeros(count), np.zeros((count, 3)), np.zeros((count, 3, 3))
        for link, body in bodies.items():
            mass[link], centre[link], inertia[link] = body
        start = dict.fromkeys(("referenceCoordinates", "initialCoordinates", "initialCoordinates_t"), nothing)
        self.node = self.mbs.AddNode(items.NodeGenericODE2(**start, numberOfODE2Coordinates=count))
        self.tree = self.mbs.AddObject(items.ObjectKinematicTree(
            nodeNumber=self.node,
            jointTypes=list(joints),
            linkParents=list(parents),
            jointTransformations=exudyn.Matrix3DList([np.eye(3)] * count),
            jointOffsets=exudyn.Vector3DList(list(offsets)),
            linkInertiasCOM=exudyn.Matrix3DList(list(inertia)),
            linkCOMs=exudyn.Vector3DList(list(centre)),
            linkMasses=mass,
            gravity=[*slope.gravity_vector, 0.0],
            jointPControlVector=spring,
            jointDControlVector=damper,
            # must be given in full length with the control vectors
            jointPositionOffsetVector=nothing if relaxed is None else relaxed,
            jointVelocityOffsetVector=nothing,
        ))  # fmt: skip
        for name, kind in COORDINATES:
            self.keep(name, items.SensorNode, nodeNumber=self.node, outputVariableType=kind)

    def add_weight(self, marker: Any, mass: float, slope: Slope) -> None:
        """What gravity pulls at beside the masses, as if a mass [kg] hung at a marker; none for no mass."""
        if mass:
            load = [mass * component for component in slope.gravity_vector]
            self.mbs.AddLoad(items.LoadForceVector(markerNumber=self.mbs.AddMarker(marker), loadVector=[*load, 0.0]))

    def assemble(self) -> None:
        """Nothing more is added."""
        self.mbs.Assemble()
        system = self.mbs.systemData  # requested once: to look it up takes longer than to answer
        self.coordinates, self.rates = system.GetODE2Coordinates, system.GetODE2Coordinates_t

    def begin(self, place: Sequence[float] | np.ndarray, motion: Sequence[float] | np.ndarray) -> None:
        """Make coordinates and rates the initial ones."""
        initial = exudyn.ConfigurationType.Initial
        self.mbs.systemData.SetODE2Coordinates(place, configuration=initial)
        self.mbs.systemData.SetODE2Coordinates_t(motion, configuration=initial)

    def kept(self) -> dict[str, np.ndarray]:
        """Rows of the last solver call by signal, the first column time [s]."""
        return {name: np.asarray(self.mbs.GetSensorStoredData(number), dtype=float)
                for name, number in self.sensors.items()}  # fmt: skip
