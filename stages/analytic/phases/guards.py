"""The guard of each phase: its fall through zero ends the phase.

Heel strike: clearance falls through zero with the swing foot ahead of the stance foot. The legs are equally long, so
the swing foot also falls below ground behind the stance foot and rises again; that is no heel strike. Rigid legs do so
where they are parallel, with one foot at the very place of the other: only round-off says which is ahead. Double stance
ends where the trailing foot's normal force, or with limited friction the friction it has left, falls to zero.
"""

from __future__ import annotations

from collections.abc import Callable

from stages.analytic.compiled import ByKind, compiled
from stages.analytic.model.kinds import Compliant, Kind, Limited, Rigid, SmoothRolling
from stages.analytic.model.walker import Vector
from stages.analytic.phases.coulomb_guard import hovering_guard, sliding_guard, sticking_guard
from stages.analytic.phases.flow import DOUBLE_STANCE, HOVERING, SINGLE_STANCE
from stages.analytic.phases.transitions import foot_clearance, trailing_force

Guard = tuple[float, float, bool]
#: Rigid legs that pass each other bring the feet together up to round-off; farther ahead [leg lengths] a foot lands.
PASSING = 1e-9


@compiled
def swing_guard(phase: int, y: Vector, p: Kind, dy: Vector, start: int) -> Guard:
    """`guard` of single stance."""
    height, change, advance = foot_clearance(y, p, dy, start)
    return height, change, advance > 0.0


@compiled
def rigid_guard(phase: int, y: Vector, p: Rigid, dy: Vector, start: int) -> Guard:
    """`guard` of rigid legs."""
    height, change, advance = foot_clearance(y, p, dy, start)
    return height, change, advance > PASSING


@compiled
def rolling_guard(phase: int, y: Vector, p: Compliant, dy: Vector, start: int) -> Guard:
    """`guard` of a walker whose feet roll."""
    if phase == DOUBLE_STANCE:
        force, change = trailing_force(y, p, dy, start)
        return force[0], change[0], True
    return swing_guard(phase, y, p, dy, start)


@compiled
def limited_guard(phase: int, y: Vector, p: Limited, dy: Vector, start: int) -> Guard:
    """`guard` of a walker with limited friction."""
    if phase == SINGLE_STANCE:
        return swing_guard(phase, y, p, dy, start)
    if phase == DOUBLE_STANCE:
        value, change = sticking_guard(y, p, dy, start)
    elif phase == HOVERING:
        value, change = hovering_guard(y, p, dy, start)
    else:
        value, change = sliding_guard(phase, y, p, dy, start)
    return value, change, True


#: Guard of the phase, its change for the variation of the state stored in `dy` from `start`, and whether its fall
#: through zero is the event: guard(phase, y, p, dy, start). Along the flow, `dy` is dy/dt and `start` zero.
guard: Callable[..., Guard] = ByKind({
    Rigid: rigid_guard, SmoothRolling: rolling_guard, Limited: limited_guard})
