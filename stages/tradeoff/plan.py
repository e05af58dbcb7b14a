"""Which ways are measured: for each model a reference, a second one nearly as tight, an independent one, and the rest.

The paper's own settings are RK23 and BDF (MATLAB's ode23 and ode15s) at 1e-7 for the constraint model, and for the
multibody model a variable-order implicit solver at 1e-6 with finer steps around heel strike (section 3.5). Exudyn has
no such solver; implicit steps by phase on bodies and joints stand in for it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass

from stages.analytic.phases.flow import DOUBLE_STANCE, SINGLE_STANCE
from stages.analytic.result import Result as Analytic
from stages.biped.design import BeyondModel, Biped, require_own_strikes
from stages.tradeoff import constraint_ways, penalty_ways, twin_ways
from stages.tradeoff.parameters import Parameters
from stages.tradeoff.scipy_walk import readable_rates
from stages.tradeoff.way import Way
from stages.twin.machine.connectors import ConnectorTree
from stages.twin.machine.machine import build
from stages.twin.machine.projection import project

PAPER, DEFAULT = "paper", "default"
TRAPEZOIDAL, ALPHA = "trapezoidal", "generalized_alpha"
#: Tolerance of the compiled penalty walker where it confirms a reference.
TIGHT = 1e-12


@dataclass(frozen=True)
class Plan:
    """One model's ways. The reference is shown converged by `second` (same way) and `independent` (another way)."""

    reference: Way
    second: Way
    independent: Way | None
    ways: tuple[Way, ...]


def plans(parameters: Parameters, analytic: Analytic) -> Iterator[Plan]:
    """All plans; `analytic` gives the mid-stance and the force of its first sample. Few are those that claims rest on.

    Of a design with details the constraint model's alone. Raises WayFailed, BeyondModel for a hip that rubs.
    """
    if parameters.biped.hip_friction > 0:
        raise BeyondModel("SciPy's ways, beside which the constraint model's are measured, do not know hip_friction")
    require_own_strikes(parameters.biped, "the study of speed against accuracy")
    if parameters.biped.detailed:
        yield detailed_plan(parameters, parameters.biped)
        return
    yield from constraint_plans(parameters, analytic)
    if parameters.settings.resolution == "full":
        yield projected_plan(parameters)
    yield from penalty_plans(parameters, analytic)
    if parameters.settings.resolution != "few":
        yield twin_plan(parameters, analytic)


def constraint_plans(parameters: Parameters, analytic: Analytic) -> Iterator[Plan]:
    """Rolling trailing foot, then limited friction, which rigid legs do not ask for."""
    resolution, steps = parameters.settings.resolution, parameters.settings.walked_steps
    full, usual = resolution == "full", parameters.constraint.tolerance
    tolerances = sorted({usual, *(10.0**-n for n in range(3, 14))}, reverse=True)
    one = parameters.biped.legs == "rigid" or resolution == "few"
    kinds = (None,) if one else (None, parameters.contact.coefficients)
    for friction in kinds:
        at = constraint_ways.scene(parameters.biped, parameters.slope, friction, analytic.mid_stance, steps)
        compiled = [constraint_ways.compiled_way(at, value, DEFAULT if value == usual else "") for value in tolerances]
        dop = constraint_ways.everywhere("DOP853")
        if friction is None and resolution != "few":
            independent = constraint_ways.scipy_way(at, "readable, SciPy DOP853", dop, 1e-12 if full else 1e-10,
                                                    readable_rates, multiplier=True)
        else:
            independent = constraint_ways.scipy_way(at, "SciPy DOP853", dop, 1e-12)
        if friction is None:
            compiled += scipy_ways(at, resolution)
        tight = [constraint_ways.compiled_way(at, value) for value in (1e-14, 1e-13)]
        yield Plan(tight[0], tight[1], independent, tuple(compiled))


def projected_plan(parameters: Parameters) -> Plan:
    """A design with frames and legs that differ, whose steps alternate: the twin as it projects into the plane."""
    return detailed_plan(parameters, project(build(parameters.biped, parameters.twin)))


def detailed_plan(parameters: Parameters, biped: Biped) -> Plan:
    """The constraint model of a design with details, by its own ways."""
    usual, dop = parameters.constraint.tolerance, constraint_ways.everywhere("DOP853")
    at = constraint_ways.detailed_scene(biped, parameters.slope, parameters.settings.walked_steps)
    tolerances = sorted({usual, *(10.0**-n for n in range(3, 14))}, reverse=True)
    ways = [constraint_ways.compiled_way(at, value, DEFAULT if value == usual else "") for value in tolerances]
    ways += [constraint_ways.scipy_way(at, "SciPy DOP853", dop, value) for value in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)]
    tight = [constraint_ways.compiled_way(at, value) for value in (1e-14, 1e-13)]
    independent = constraint_ways.scipy_way(at, "readable, SciPy DOP853", dop, 1e-12, readable_rates)
    return Plan(tight[0], tight[1], independent, tuple(ways))


def scipy_ways(at: constraint_ways.Scene, resolution: str) -> list[Way]:
    """SciPy's methods on the compiled terms, the paper's pair of methods, and the readable path."""
    full, few = resolution == "full", resolution == "few"
    wanted = {
        "DOP853": (1e-4, 1e-6, 1e-8, 1e-10, 1e-12) if full else (1e-8,) if few else (1e-6, 1e-8),
        "RK45": (1e-4, 1e-6, 1e-8, 1e-10) if full else () if few else (1e-6,),
        "Radau": (1e-4, 1e-6, 1e-8) if full else (),
        "LSODA": (1e-6, 1e-8, 1e-10) if full else (),
    }
    ways = [constraint_ways.scipy_way(at, f"SciPy {method}", constraint_ways.everywhere(method), value)
            for method, values in wanted.items() for value in values]
    for value in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8) if full else (1e-7,):
        methods = {SINGLE_STANCE: "RK23", DOUBLE_STANCE: "BDF"}
        mark = PAPER if value == 1e-7 else ""
        ways.append(constraint_ways.scipy_way(at, "SciPy RK23 and BDF", methods, value, mark=mark))
    for value in (1e-6, 1e-8, 1e-10) if full else ():
        dop = constraint_ways.everywhere("DOP853")
        ways.append(constraint_ways.scipy_way(at, "readable, SciPy DOP853", dop, value, readable_rates))
    return ways


def penalty_plans(parameters: Parameters, analytic: Analytic) -> Iterator[Plan]:
    """The study's ground with all ways; in full other grounds as well, with the tree."""
    resolution, steps = parameters.settings.resolution, parameters.settings.walked_steps
    full, few, force = resolution == "full", resolution == "few", analytic.walk.standing_force
    settings, ground = parameters.planar, parameters.contact
    start = parameters.biped, parameters.slope
    at = penalty_ways.scene(penalty_ways.PENALTY, *start, ground, settings, analytic.mid_stance, force, steps)
    tree, joints, compiled = penalty_ways.tree_way, penalty_ways.joints_way, penalty_ways.compiled_way
    loose, rolling, impact = parameters.twin.largest_step, settings.rolling_step, settings.impact_step
    by_phase = joints(at, TRAPEZOIDAL, rolling, impact, multiplier=full, mark=PAPER)
    powers = range(3, 10) if full else (4, 6) if few else (3, 4, 6, 8)
    ways = [tree(at, 10.0**-n, loose, multiplier=full) for n in powers]
    ways += [tree(at, settings.tolerance, settings.largest_step, multiplier=full, mark=DEFAULT), by_phase]
    ways += [compiled(at, 10.0**-n, multiplier=full) for n in (range(3, 13) if full else (3, 4, 6, 8, 10))]
    if full:
        ways += [tree(at, 1e-3, 2.5 * loose, multiplier=True), tree(at, 1e-4, 0.25 * loose, multiplier=True)]
        ways += [joints(at, TRAPEZOIDAL, 2 * rolling, impact, multiplier=True),
                 joints(at, TRAPEZOIDAL, rolling / 2, impact / 2, multiplier=True),
                 joints(at, ALPHA, rolling, impact), joints(at, ALPHA, rolling / 2, impact / 2)]
    tight = [tree(at, value, loose / 2, multiplier=full)
             for value in ((1e-11, 1e-10) if full else (1e-9, 1e-8) if few else (1e-10, 1e-9))]
    yield Plan(tight[0], tight[1], compiled(at, TIGHT, multiplier=full), tuple(ways))
    if not full:
        return
    for name, change in (
        ("k_c / 10", {"contact_stiffness": ground.contact_stiffness / 10}),
        ("k_c x 10", {"contact_stiffness": ground.contact_stiffness * 10}),
        ("restitution", {"normal_force": "restitution"}),
    ):
        other = dataclasses.replace(ground, **change)
        model = f"{penalty_ways.PENALTY}, {name}"
        at = penalty_ways.scene(model, *start, other, settings, analytic.mid_stance, force, steps)
        yield Plan(tree(at, 1e-10, loose), tree(at, 1e-9, loose), compiled(at, TIGHT),
                   (*(tree(at, value, loose) for value in (1e-4, 1e-6, 1e-8)),
                    *(compiled(at, value) for value in (1e-4, 1e-6, 1e-8))))


def twin_plan(parameters: Parameters, analytic: Analytic) -> Plan:
    """The twin; independent is a ground of Exudyn's own connectors, on the same solver: there is no other for it."""
    full, settings = parameters.settings.resolution == "full", parameters.twin
    force = analytic.walk.standing_force
    at = twin_ways.scene(parameters.biped, parameters.slope, parameters.contact, settings, analytic.mid_stance, force,
                         parameters.settings.walked_steps)
    way = twin_ways.twin_way
    usual, loose = (settings.tolerance, settings.largest_step), settings.largest_step
    powers = range(4, 10) if full else range(3, 8)
    chosen = {(10.0**-n, loose) for n in powers} | {usual}
    ways = [way(at, *pair, mark=f"{PAPER}, {DEFAULT}" if pair == usual and usual[0] == 1e-6 else
                DEFAULT if pair == usual else "") for pair in sorted(chosen, reverse=True)]
    if full:
        ways.append(way(at, 1e-4, 2.5 * loose))
    tight = [way(at, value, loose) for value in ((1e-10, 1e-9) if full else (1e-8, 1e-7))]
    independent = way(at, 1e-8 if full else 1e-7, loose, ConnectorTree)
    return Plan(tight[0], tight[1], independent, tuple(ways))
