"""Settings of the extremes.

Here stand the words of the map too: which engines it tries, and what their answers are worth. Quick to import.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar

from stages.analytic.parameters import Settings as AnalyticSettings
from stages.biped.quantity import Bound, faults, parameter
from stages.ground.contact_law import OnGround
from stages.ground.slope import Friction
from stages.multibody.parameters import Settings as MultibodySettings
from stages.twin.parameters import Parameters as TwinParameters, Settings as TwinSettings

#: Models: the constraint model's gait with rolling and with Coulomb feet, that of designs with frames, unequal legs and
#: more than a hinge at the hip, one step of it, many steps of it in a row, a gait's derivatives and the estimate of its
#: error, the compiled penalty walker, Exudyn's planar model in both assemblies, as its contact stiffens, and the twin.
GAIT, COULOMB, DETAILED, STEP, MARCH, DERIVATIVES, ESTIMATE, COMPILED, TREE, JOINTS, LIMIT, TWIN = ENGINES = (
    "gait", "gait, coulomb", "gait, detailed", "step", "steps in a row", "derivatives", "error estimate",
    "penalty, compiled", "tree", "joints", "rigid limit", "twin")  # fmt: skip
#: Those that know a design with details.
KNOWING_DETAILS = (GAIT, COULOMB, DETAILED, STEP, MARCH, DERIVATIVES, ESTIMATE, COMPILED, TREE)
#: What is computed of a gait besides itself, wherever the full map requests one.
OF_A_GAIT = (DERIVATIVES, ESTIMATE)
#: What lies on no axis: draws of all parameters, and the study's own parameters.
TOGETHER, USUAL = "all together", "the study's own"

#: The answer agrees with the reference; it does not, but its own audit or the tolerance requested show so; input or
#: design refused with a reason; the run ended early with a reason; an answer whose reference gave none.
RIGHT, INACCURATE, REFUSED, FAILED, UNCONFIRMED = "right", "inaccurate", "refused", "failed", "unconfirmed"
#: An answer that the reference contradicts and nothing in it shows: a defect. A process that died or did not return.
WRONG, CRASHED, HUNG = "wrong", "crashed", "hung"
STATUSES = (RIGHT, INACCURATE, REFUSED, FAILED, UNCONFIRMED, WRONG, CRASHED, HUNG)

@dataclass(frozen=True)
class Settings:
    """How many points there are, when an answer is right, and when a run is given up."""

    FILE: ClassVar[str] = "extremes"

    resolution: str = parameter("-", "points: few, some, or the whole map", choices=("few", "coarse", "full"))
    processes: int = parameter("1", "processes that compute side by side", bound=Bound(minimum=1, maximum=256))
    right_within: float = parameter(
        "1", "largest error of a right answer, in leg lengths and pendulum times", bound=Bound(above=0, maximum=0.1)
    )
    penalty_tolerance: float = parameter(
        "1", "tolerance of multibody and twin where it is not varied", bound=Bound(minimum=1e-9, maximum=1e-4)
    )
    most_solver_steps: int = parameter(
        "1", "solver steps of multibody and twin without a heel strike after which a run is given up",
        bound=Bound(minimum=1000, maximum=10**7),
    )  # fmt: skip
    longest_s: float = parameter(
        "s", "time on the clock after which a point counts as hung", bound=Bound(minimum=10, maximum=1e5)
    )


@dataclass(frozen=True)
class Parameters(OnGround):
    """All parameters the stage uses: those of every engine, which the points depart from."""

    friction: Friction
    analytic: AnalyticSettings
    multibody: MultibodySettings
    twin: TwinSettings
    settings: Settings

    def changed(self, changes: Iterator[tuple[str, Any]] | tuple[tuple[str, Any], ...]) -> Parameters:
        """With values changed by their names in the parameter files, as "ground.gravity"; nothing is checked.

        Raises KeyError for a name no section has.
        """
        sections = {field.name: getattr(self, field.name) for field in fields(self)}
        for name, value in changes:
            file, _, key = name.partition(".")
            owners = [field for field, section in sections.items() if file == section.FILE and hasattr(section, key)]
            if not owners:
                raise KeyError(name)
            for owner in owners:
                sections[owner] = replace(sections[owner], **{key: value})
        return Parameters(**sections)

    def refusal(self, names: tuple[str, ...]) -> str:
        """Why these sections would be refused, as the files' check says it; empty if they would not."""
        for name in names:
            section = getattr(self, name)
            for broken in faults(section):
                value = getattr(section, broken.key)
                shown = f"{value:g}" if isinstance(value, (int, float)) else value
                return f"{section.FILE}.{broken.key} = {shown} is not allowed; allowed: {broken.allowed}"
        if "twin" in names:
            for broken in TwinParameters(self.biped, self.slope, self.contact, self.twin).broken_rules():
                return f"{broken.key} is not allowed; allowed: {broken.allowed}"
        return ""
