"""The penalty walker's contact, motion and sensors as lines of C, made of what its compiled functions are made of.

One leg's part is that of `stages.penalty.model.derivation`, contact laws are the texts of `stages.ground.laws` on
symbols, and `build_penalty` makes the walker's numbers of the parameters, which are symbols here as well.
"""

import dataclasses
import math
import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import sympy as sp

from stages.analytic.model.derivation import g_x, g_y, time_derivative
from stages.biped.design import Biped
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import signed_coefficient, with_single_terms
from stages.ground.slope import Slope
from stages.penalty.model import derivation as d
from stages.penalty.model.changes import names_of
from stages.penalty.model.derivation import KINDS, Kind
from stages.penalty.model.walker import Penalty, build_penalty
from stages.penalty.motion.feet import AIR
from stages.planar.run import FALLEN, HIP_CREEP

#: The contact laws' operations on symbols.
SYMBOLIC = with_single_terms(
    sp.sin, sp.asin, sp.sqrt, sign=sp.sign, absolute=sp.Abs, round=sp.floor, power=sp.Pow, minimum=sp.Min,
    maximum=sp.Max)  # fmt: skip
#: Parameters of the law restitution, of which its damping follows by iteration: C has the number that follows.
ITERATED = ("ground.restitution", "ground.impact_speed")
Leg = Callable[[Any], Any]
real = partial(sp.Symbol, real=True)


def equations(biped: Biped, slope: Slope, contact: ContactLaw) -> tuple[list[str], dict[str, str]]:
    """Names of the parameters, and lines of C for any values of them: `ground`, how the feet stand and what pushes
    them; `motion`, mass matrix a and forces b of a qdd = b; with qdd known, `sensed`, what the sensors measure.
    """
    names = [name for name in names_of(biped, slope, contact) if name not in ITERATED]
    keys, rigid = [name.partition(".")[2] for name in names], biped.legs == "rigid"
    machine, law = (dataclasses.replace(section, **{key: real(key) for key in keys if hasattr(section, key)})
                    for section in list[Any]((biped, contact)))  # fmt: skip
    angle, gravity = math.radians(1.0) * real("slope_deg"), real("gravity")
    p = build_penalty(machine, (gravity * sp.sin(angle), -gravity * sp.cos(angle)), law, FALLEN)
    kind, time = KINDS["detailed" if biped.detailed else "plain"], sp.sqrt(machine.leg_length / gravity)
    legs = [leg_in_c(kind, index, numbers, rigid) for index, numbers in enumerate((p.first, p.other))]
    return names, {"ground": on_ground(p, kind, legs, machine.leg_length, time), "felt": sensed(kind, legs[0]),
                   "motion": system(p, d.derive(kind.leg), legs, time, 4 if rigid else 6)}  # fmt: skip


def leg_in_c(kind: Kind, index: int, numbers: Any, rigid: bool) -> Leg:
    """What puts terms of the derivation in the names of leg 0 or 1 in C; a rigid one has its natural length."""
    known = kind.design.parameters
    own = {known[name]: getattr(numbers, name) for name in numbers._fields if name in known}
    own |= {old: real(f"{old}_{index}") for old in (d.phi, d.L, d.dphi, d.dL, d.N, d.F)}
    own |= dict(zip(d.ACCELERATIONS, map(real, ("b[0]", "b[1]", f"b[{2 + index}]", f"b[{4 + index}]"))))
    own |= {d.L: numbers.L_nat, d.dL: 0, d.ddL: 0} if rigid else {}
    return lambda term: sp.sympify(term).xreplace(own)


def on_ground(p: Penalty, kind: Kind, legs: list[Leg], length: sp.Expr, time: sp.Expr) -> str:
    """Lines of contact, force, and of what events follow from, in scales of the walker."""
    touch, force, outputs = (dict[str, sp.Expr]() for _ in range(3))
    for i, leg in enumerate(legs):
        depth, rate, slip = met = [real(f"{name}_{i}") for name in ("depth", "rate", "slip")]
        touch |= {f"const double {symbol}": leg(term) for symbol, term in zip(met, d.derive(kind.leg).contact)}
        force[f"const double N_{i}"] = real(f"acts_{i}") * p.law.normal.force(depth, rate, SYMBOLIC)
        force[f"const double F_{i}"] = -signed_coefficient(p.law, slip, SYMBOLIC) * real(f"N_{i}")
        outputs |= {f"w->above[{i}]": -depth / length, f"w->air[{i}]": AIR * leg(kind.leg.L_nat) / length,
                 f"w->swing[{i}]": leg(d.dphi) * time}  # fmt: skip
    ahead, behind = (leg((d.L - kind.leg.r) * sp.sin(d.phi)) for leg in legs)
    leaning = (math.pi / 2 - sp.Abs(leg(d.phi)) for leg in legs)
    outputs |= {"w->ahead": (ahead - behind) / length, "w->upright": sp.Min((d.y - p.fallen) / length, *leaning)}
    return "\n".join(assigned(*each) for each in (("t", touch), ("s", force), ("g", outputs)))


def system(p: Penalty, part: d.LegPart, legs: list[Leg], time: sp.Expr, size: int) -> str:
    """Lines of the lower half of the mass matrix, and of the forces of hip, pushes, both legs and the ground."""
    mass, force = sp.zeros(6, 6), sp.zeros(6, 1)
    angle, rate = (legs[0](symbol) - legs[1](symbol) for symbol in (d.phi, d.dphi))
    rubbed = sp.Max(sp.Min(rate * time / HIP_CREEP, 1), -1)
    force[2] = -p.k_h * (angle - p.phi_h) - p.b_h * rate - p.tau_h * rubbed
    force[3] = -force[2]
    for row, (pull, push) in enumerate(((g_x, "push_x"), (g_y, "push_y"))):
        mass[row, row], force[row] = p.M, p.M_g * legs[0](pull) + real(push)
    for index, leg in enumerate(legs):
        rows = (0, 1, 2 + index, 4 + index)
        for row, place in enumerate(rows):
            force[place] += leg(part.force[row] + part.push[row])
            for column, beside in enumerate(rows):
                mass[place, beside] += leg(part.mass[row, column])
    half = {f"a[{row}][{column}]": mass[row, column] for row in range(size) for column in range(row + 1)}
    return assigned("u", half | {f"b[{row}]": force[row] for row in range(size)})


def sensed(kind: Kind, leg: Leg) -> str:
    """Lines of what sensors at hip and foot's mass centre measure on the leg's axes, and of the ground's forces."""
    forward, upward = sp.Matrix([sp.cos(d.phi), sp.sin(d.phi)]), sp.Matrix([-sp.sin(d.phi), sp.cos(d.phi)])
    hip, outputs = sp.Matrix([d.x, d.y]), []
    for place in (hip, hip - (d.L - kind.leg.l) * upward + kind.leg.e * forward):
        jacobian = place.jacobian(d.COORDINATES)
        turning = time_derivative(jacobian, d.COORDINATES, d.RATES) * d.RATES
        force = jacobian * d.ACCELERATIONS + turning - sp.Matrix([g_x, g_y])
        outputs += [leg(force.dot(forward)), leg(force.dot(upward)), leg(d.dphi)]
    outputs += map(real, ("N_0", "F_0", "N_1", "F_1"))
    return assigned("f", {f"v[OUTPUT + {place}]": signal for place, signal in enumerate(outputs)})


def assigned(prefix: str, values: Mapping[str, sp.Expr]) -> str:
    """Lines of C that assign the values, what they share first, without factors of one."""
    shared, reduced = sp.cse(list(values.values()), symbols=sp.numbered_symbols(prefix), order="none")
    pairs = [*((f"const double {symbol}", value) for symbol, value in shared), *zip(values, reduced, strict=True)]
    return re.sub(r"(?<![\d.])1\.0\*", "", "\n".join(f"    {name} = {sp.ccode(value)};" for name, value in pairs))
