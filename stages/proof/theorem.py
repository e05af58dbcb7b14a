"""The theorem: a fixed point of the step, or of several, is in a ball, alone there, and so stable or unstable.

Z is a ball about a thin centre z, P the map over the steps, C close to (1 - P'(z))^-1. If Krawczyk's box
K = z + C (P(z) - z) + (1 - C (1 - P'(Z))) (Z - z) lies inside Z, there is one fixed point in Z, and it lies in K.
"""

import dataclasses
import json
import math
import re
from collections.abc import Callable, Mapping
from decimal import Decimal
from functools import partial
from typing import Any

import numpy as np
from flint import acb, acb_mat, arb, arb_mat, ctx

from stages.biped.accuracy.scales import Scales
from stages.biped.design import Biped
from stages.biped.quantity import faults
from stages.biped.question import refuse
from stages.biped.walk import StanceState
from stages.ground.slope import Slope
from stages.proof.equations import Machine
from stages.proof.flow import BITS, Ball, Carried, Matrix, NotProven, around, column, identity
from stages.proof.walk import Walk

KIND = "bipedstudy proof 1"
KEYS = ("kind", "biped", "ground", "steps", "phases", "centre", "radius", "stable", "enclosures", "says")
#: What a proof says of the claims that it decides, for one step.
SAYS = {True: {"stable_gait": "proven for the constraint model"},
        False: {"stable_gait": "proven unstable for the constraint model"}, None: {}}  # fmt: skip
#: Entries of the state with their units; rigid legs have every other.
STATE = {field.name: field.metadata["unit"] for field in dataclasses.fields(StanceState)}
DECIMAL = re.compile(r"-?\d{1,40}(\.\d{1,80})?(e-?\d{1,3})?")
#: Radius of a ball, in which the last of its centre's digits is this small; and how often a better centre is taken.
RADIUS, DIGITS, CENTRES = "1e-16", 18, 3
#: By so many of its radii an enclosure is written wider, as other roundings choose other steps when it is checked.
SPARE = 4
#: Multipliers smaller than this part of the largest are enclosed together.
SMALL = 1e-4


def prove(biped: Biped, slope: Slope, centre: list[str], radius: str, steps: int, centres: int,
          progress: Callable[[float, str], None]) -> dict[str, Any]:  # fmt: skip
    """The content of a proof file, for the ball of `radius` about `centre` (decimals, SI units), or about a better one,
    for so many `centres` in all. Raises NotProven.
    """
    ctx.prec, size, names = BITS, len(centre), list(STATE)[:: len(STATE) // len(centre)]
    fast = slope.gravity / biped.leg_length + (biped.stiffness / biped.foot_mass if biped.legs == "compliant" else 0)
    # the leg and the fastest rate are near one, and nothing is rounded
    own = Scales(1.0, 2.0 ** round(math.log2(biped.leg_length)), 2.0 ** -round(0.5 * math.log2(fast)))
    scales, one = [arb(own.size(STATE[name])) for name in names], identity(size)
    for attempt in range(centres):
        exact = [arb(text) / scale for text, scale in zip(centre, scales)]
        thin = column(exact).mid()
        reach = around(column(exact) - thin + column([arb(radius) / scale for scale in scales]))
        box = Carried(thin, one, arb_mat(size, 1), one, reach)
        walk = Walk(Machine.of(biped, slope, own), box, own, partial(progress, attempt / centres))
        try:
            for _ in range(steps):
                walk.step()
            end, derivative = walk.carried, walk.carried.frame * walk.carried.by_start
            inverse = (one - derivative.mid()).inv().mid()
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            raise NotProven(f"numbers are too wide to go on, in {walk.phases[-1]}") from None
        box = thin + inverse * (end.x + end.frame * end.s - thin) + (one - inverse * (one - derivative)) * reach
        point = {name: each * scale for name, each, scale in zip(names, box.entries(), scales)}
        missed = [name for name, text in zip(names, centre) if not abs(point[name] - arb(text)) < arb(radius)]
        if not missed:
            stable, multipliers = judged(derivative)
            balls, spare = {**walk.measured(steps), **point, **multipliers}, SPARE if centres > 1 else 0
            balls = {name: ball + arb(0, ball.rad() * spare) for name, ball in balls.items()}
            return record(biped, slope, steps, walk.phases, dict(zip(names, centre)), radius, stable, balls)
        centre = [outward(each.mid(), DIGITS)[0] for each in point.values()]
    raise NotProven(f"the fixed point is not shown to be in the ball: Krawczyk's test fails for {missed[0]}")


def judged(derivative: Matrix) -> tuple[bool | None, dict[str, Ball]]:
    """Whether all eigenvalues of any matrix in a matrix of balls are inside the unit circle, or one is outside, and
    enclosures of those that are known apart, largest first.
    """
    discs = enclosed(derivative)
    alone = [one for one in discs if not any(one.overlaps(each) for each in discs if each is not one)]
    most = max((arb(abs(each).upper()) for each in discs), key=float)
    largest = max((arb(abs(each).lower()) for each in alone), key=float, default=arb(0)).union(most)
    balls = {f"multiplier_{place}_{part}": getattr(one, part)
             for place, one in enumerate((each for each in alone if not each.contains(0)), 1)
             for part in ("real", "imag")}  # fmt: skip
    stable = True if largest < 1 else False if largest > 1 else None
    return stable, {**balls, "largest_multiplier_size": largest}


def enclosed(derivative: Matrix) -> list[Any]:
    """Balls that hold the eigenvalues of any matrix in a matrix of balls, largest first: Gershgorin's discs of a
    similar matrix. One apart from all others holds one.
    """
    from scipy.linalg import schur

    size = derivative.nrows()
    middle = np.array(derivative.mid().tolist(), dtype=float)
    weights = np.linalg.norm(middle, axis=1) + 1e-12 * np.linalg.norm(middle)
    middle = middle / weights[:, None] * weights
    values, vectors = np.linalg.eig(middle)
    large = np.abs(values) > SMALL * np.abs(values).max()
    limit = float(np.abs(values[large]).min()) * 0.999
    _, basis, small = schur(middle, output="complex", sort=lambda value: abs(value) < limit)
    change = weights[:, None] * np.hstack([vectors[:, large], basis[:, :small]])
    columns = acb_mat(size, size, [acb(float(each.real), float(each.imag)) for each in change.ravel()])
    similar = columns.inv() * acb_mat(derivative) * columns
    discs = []
    for i in range(size):
        radius = arb(0, sum((abs(similar[i, j]) for j in range(size) if j != i), arb(0)).abs_upper())
        discs.append(similar[i, i] + acb(radius, radius))
    return sorted(discs, key=lambda disc: -float(abs(disc)))


def outward(ball: Any, digits: int | None = None) -> list[str]:
    """Decimals below and above a ball, with so many digits behind the point."""
    if digits is None:
        width = 2 * float(ball.rad())
        digits = max(1, 2 - math.floor(math.log10(width))) if width > 0 else 40
    scaled = ball * 10**digits
    ends = scaled.lower().floor(), scaled.upper().ceil()
    return [f"{Decimal(f'{end.unique_fmpz()}e-{digits}'):f}" for end in ends]


def record(biped: Biped, slope: Slope, steps: int, phases: list[str], centre: dict[str, str], radius: str,
           stable: bool | None, balls: Mapping[str, Any]) -> dict[str, Any]:  # fmt: skip
    """A proof file's content; `balls` are its enclosures in SI units."""
    says = SAYS[stable] if steps == 1 or not biped.alike else {}
    found = {name: outward(ball) for name, ball in balls.items()}
    about = dataclasses.asdict(biped), dataclasses.asdict(slope)
    parts = (KIND, *about, steps, phases, centre, radius, stable, found, says)
    return dict(zip(KEYS, parts, strict=True))


def read(content: bytes, name: str) -> tuple[Biped, Slope, dict[str, Any]]:
    """The design and the content of a proof file. Raises WrongOption."""
    try:
        given: Any = json.loads(content)
        if set(given) != set(KEYS) or given["kind"] != KIND:
            raise ValueError(f"it has kind: {KIND!r} and the keys {', '.join(KEYS[1:])}")
        biped, slope = Biped(**given["biped"]), Slope(**given["ground"])
        if broken := [*faults(biped), *faults(slope)]:
            raise ValueError(f"biped or ground has a value that no design may have: {broken[0]}")
        if tuple(given["centre"]) != (names := tuple(STATE)[:: 2 if biped.legs == "rigid" else 1]):
            raise ValueError(f"centre has the entries {', '.join(names)}")
        if given["steps"] not in (1, 2, 4, 8):
            raise ValueError(f"steps = {given['steps']!r}; allowed: 1, 2, 4 or 8")
        pairs = [(low, high) for low, high in given["enclosures"].values()]
        numbers = [given["radius"], *given["centre"].values(), *(each for pair in pairs for each in pair)]
        if not all(isinstance(each, str) and DECIMAL.fullmatch(each) for each in numbers):
            raise ValueError("radius, centre and enclosures are decimals, as text")
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        refuse((True, f"{name} is no proof file: {error}"))
    return biped, slope, given


def confirm(given: Mapping[str, Any], anew: Mapping[str, Any], name: str) -> None:
    """Raise NotProven where the file `name` says what a proof made anew does not."""
    for key in ("phases", "stable", "says"):
        if given[key] != anew[key]:
            raise NotProven(f"{name} is not confirmed: its {key} is {given[key]}, and a new proof has {anew[key]}")
    if set(given["enclosures"]) != set(anew["enclosures"]):
        raise NotProven(f"{name} is not confirmed: its enclosures are not those of a proof made anew")
    for key, found in anew["enclosures"].items():
        (low, high), (at_least, at_most) = map(Decimal, given["enclosures"][key]), map(Decimal, found)
        if not low <= at_least <= at_most <= high:
            raise NotProven(f"{name} is not confirmed: a proof made anew shows {key} in {' .. '.join(found)} alone")
