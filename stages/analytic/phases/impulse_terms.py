"""What an impact leaves of the equations of motion: inertia, and how it varies with the configuration.

Over an impact M (qd+ - qd-) = Pi Lambda: springs, dampers and gravity give no impulse.
"""

from __future__ import annotations

from stages.analytic.compiled import Four, Jacobians, Numbers, inlined
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import solve
from stages.analytic.model.kinds import Compliant
from stages.analytic.model.walker import Vector
from stages.analytic.phases.flow import row4_times


@inlined
def impulse_jacobians(y: Vector, before: Four, after: Four, impulse: tuple[float, float], p: Compliant) -> Jacobians:
    """Derivatives by position of M (qd+ - qd-), of Pi Lambda and of Pi^T qd+."""
    by_mass = eq.compliant_inertia_jacobian(
        y[0], y[1], y[2], y[3],
        after[0] - before[0], after[1] - before[1], after[2] - before[2], after[3] - before[3], p)
    by_force = eq.contact_force_jacobian(y[0], y[1], y[2], y[3], impulse[0], impulse[1], p)
    by_contact = eq.contact_acceleration_jacobian(
        y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, after[0], after[1], after[2], after[3], p)
    return by_mass, by_force, by_contact


@inlined
def free_jump(jacobians: Jacobians, factors: Numbers, y: Vector, start: int) -> Four:
    """Variation of qd+ at unchanged Lambda for the variation of the state before, stored from `start`."""
    by_mass, by_force, _ = jacobians  # of the rows of eight, the first half: derivatives by position
    change = solve(
        factors,
        row4_times(by_force[0:4], y, start) - row4_times(by_mass[0:4], y, start),
        row4_times(by_force[4:8], y, start) - row4_times(by_mass[8:12], y, start),
        row4_times(by_force[8:12], y, start) - row4_times(by_mass[16:20], y, start),
        row4_times(by_force[12:16], y, start) - row4_times(by_mass[24:28], y, start),
    )
    return (y[start + 4] + change[0], y[start + 5] + change[1],
            y[start + 6] + change[2], y[start + 7] + change[3])
