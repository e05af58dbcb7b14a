"""What is asked at the points of the map, and which of it a stage of the study asks."""

from __future__ import annotations

from typing import Any

#: Models: the constraint model's gait with rolling and with Coulomb feet, that of designs with frames, unequal legs and
#: more than a hinge at the hip, one step of it, many steps of it in a row, a gait's derivatives and the estimate of its
#: error, the compiled penalty walker, Exudyn's planar model in both assemblies, as its contact stiffens, and the twin.
GAIT, COULOMB, DETAILED, STEP, MARCH, DERIVATIVES, ESTIMATE, COMPILED, TREE, JOINTS, LIMIT, TWIN = ENGINES = (
    "gait", "gait, coulomb", "gait, detailed", "step", "steps in a row", "derivatives", "error estimate",
    "penalty, compiled", "tree", "joints", "rigid limit", "twin")  # fmt: skip
#: Those that know a design with details.
KNOWING_DETAILS = (GAIT, COULOMB, DETAILED, STEP, MARCH, DERIVATIVES, ESTIMATE, TREE)
#: What is asked of a gait besides itself, wherever the full map asks for one.
OF_A_GAIT = (DERIVATIVES, ESTIMATE)
#: What lies on no axis: draws of all parameters, and the study's own parameters.
TOGETHER, USUAL = "all together", "the study's own"


def engine_of(stage: str, parameters: Any) -> str | None:
    """The engine that a stage with these parameters uses; None for a stage that stands on others."""
    if stage == "analytic":
        return COULOMB if parameters.limited_friction and parameters.biped.legs == "compliant" else GAIT
    if stage == "multibody":
        return JOINTS if parameters.settings.assembly == "joints" else TREE
    return TWIN if stage == "twin" else None
