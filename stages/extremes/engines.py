"""Words of the map of extremes: which engines it asks, and what their answers are worth. Quick to import."""

from __future__ import annotations

#: Models: the constraint model's gait with rolling and with Coulomb feet, that of designs with frames, unequal legs and
#: more than a hinge at the hip, one step of it, many steps of it in a row, a gait's derivatives and the estimate of its
#: error, the compiled penalty walker, Exudyn's planar model in both assemblies, as its contact stiffens, and the twin.
GAIT, COULOMB, DETAILED, STEP, MARCH, DERIVATIVES, ESTIMATE, COMPILED, TREE, JOINTS, LIMIT, TWIN = ENGINES = (
    "gait", "gait, coulomb", "gait, detailed", "step", "steps in a row", "derivatives", "error estimate",
    "penalty, compiled", "tree", "joints", "rigid limit", "twin")  # fmt: skip
#: Those that know a design with details.
KNOWING_DETAILS = (GAIT, COULOMB, DETAILED, STEP, MARCH, DERIVATIVES, ESTIMATE, COMPILED, TREE)
#: What is asked of a gait besides itself, wherever the full map asks for one.
OF_A_GAIT = (DERIVATIVES, ESTIMATE)
#: What lies on no axis: draws of all parameters, and the study's own parameters.
TOGETHER, USUAL = "all together", "the study's own"

#: The answer agrees with the reference; it does not, but its own audit or the tolerance asked for tell so; input or
#: design refused with a reason; the run ended early with a reason; an answer whose reference gave none.
RIGHT, INACCURATE, REFUSED, FAILED, UNCONFIRMED = "right", "inaccurate", "refused", "failed", "unconfirmed"
#: An answer that the reference contradicts and nothing in it tells: a defect. A process that died or did not return.
WRONG, CRASHED, HUNG = "wrong", "crashed", "hung"
STATUSES = (RIGHT, INACCURATE, REFUSED, FAILED, UNCONFIRMED, WRONG, CRASHED, HUNG)
