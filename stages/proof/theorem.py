"""The theorem: a fixed point of the step, or of several, is in a ball, alone there, and so stable or unstable.

Z is a ball about a thin centre z, P the map over the steps, C close to (1 - P'(z))^-1. If Krawczyk's box
K = z + C (P(z) - z) + (1 - C (1 - P'(Z))) (Z - z) lies inside Z, there is one fixed point in Z, and it lies in K.
The multipliers are the eigenvalues of P'(Z). Similar matrices S^-1 P'(Z) S have them in Gershgorin's discs, as many in
each group of discs as it has members.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import acb, acb_mat, arb, arb_mat, ctx

from stages.biped.design import Biped
from stages.ground.slope import Slope
from stages.proof.equations import Leg, Machine
from stages.proof.flow import BITS, Ball, Matrix, NotProven, column
from stages.proof.sets import Carried, Scalar
from stages.proof.walk import Walk

#: Multipliers smaller than this part of the largest are enclosed together.
SMALL = 1e-4
#: The ball's radius is so many times less than where its own size would spoil the test; its centre's last digit is so
#: much smaller than the radius.
SURE, FINER = 1000.0, 100
#: Radius of the first ball, which only makes the centre better, and limits of the second.
FIRST, LEAST, MOST = 1e-15, 1e-19, 1e-15


@dataclass(frozen=True)
class Units:
    """Powers of two near the biped's length [m] and shortest time [s], by which nothing is rounded."""

    length: float
    time: float

    @classmethod
    def of(cls, biped: Biped, slope: Slope) -> Units:
        """Units in which the fastest rate is near one."""
        leg, rate = biped.leg(0), math.sqrt(slope.gravity / biped.leg_length)
        if biped.legs == "compliant":
            ease = 1 / (biped.hip_mass + leg.frame_mass) + 1 / leg.foot_mass
            rate = max(rate, math.sqrt(leg.stiffness * ease), leg.damping * ease)
        return cls(2.0 ** round(math.log2(biped.leg_length)), 2.0 ** math.ceil(math.log2(1 / rate)))

    def scales(self, rigid: bool) -> list[Ball]:
        """What one of each entry of a state is in SI units, thin."""
        lengths = [arb(1), arb(1)] if rigid else [arb(1), arb(self.length)] * 2
        return lengths + [each / arb(self.time) for each in lengths]


def machine_of(biped: Biped, slope: Slope, units: Units) -> Machine:
    """The design in these units; its numbers are the decimals that are written in the parameters, as balls."""
    time, length = arb(units.time), arb(units.length)

    def decimal(value: float) -> Ball:
        return arb(repr(float(value)))

    def leg(index: int) -> Leg:
        its = biped.leg(index)
        masses, lengths = (its.foot_mass, its.frame_mass), (its.leg_length, its.foot_radius, its.foot_com,
                                                            its.foot_offset, its.frame_com, its.frame_offset)
        mass, frame = map(decimal, masses)
        natural, radius, com, offset, frame_com, frame_offset = (decimal(each) / length for each in lengths)
        inertia, frame_inertia = (decimal(each) / length**2 for each in (its.leg_inertia, its.frame_inertia))
        return Leg(mass, natural, radius, com, decimal(its.stiffness) * time**2, decimal(its.damping) * time, inertia,
                   offset, frame, frame_com, frame_offset, frame_inertia)  # fmt: skip

    first, other, angle = biped.leg(0), biped.leg(1), decimal(slope.slope_deg) * arb.pi() / 180
    pull, torque = decimal(slope.gravity) * time**2 / length, (length / time) ** 2
    alike = (first.leg_length, first.foot_radius) == (other.leg_length, other.foot_radius)
    return Machine(
        decimal(biped.hip_mass), decimal(biped.weighed_hip), leg(0), leg(1), decimal(biped.hip_stiffness) / torque,
        decimal(biped.hip_damping) / (torque * time), -decimal(biped.hip_rest_angle),
        (pull * angle.sin(), -pull * angle.cos()), biped.legs == "rigid", alike)  # fmt: skip


@dataclass(frozen=True)
class Multipliers:
    """Discs (centre, radius) that hold one multiplier each, a bound of all others, and the largest one's size."""

    discs: list[tuple[Any, Ball]]
    others: Ball
    least: Ball
    most: Ball

    @property
    def stable(self) -> bool | None:
        """Whether all are inside the unit circle; None where that is not decided."""
        return True if self.most < 1 else False if self.least > 1 else None


@dataclass(frozen=True)
class Theorem:
    """What was proven, in SI units: period and step length of the mean step, and balls of the fixed point's entries."""

    phases: list[str]
    centre: list[str]
    radius: str
    fixed_point: list[Ball]
    period: Ball
    step_length: Ball
    least_forces: dict[str, Ball]
    multipliers: Multipliers


def walked(
    biped: Biped, slope: Slope, centre: list[str], radius: str, steps: int, progress: Callable[[int, str], None]
) -> tuple[Walk, list[Ball], Matrix]:
    """So many steps of the ball of `radius` about `centre` (decimals, SI units): the walk, and the ball's thin centre
    and extent in own units. Raises NotProven.
    """
    ctx.prec = BITS
    units = Units.of(biped, slope)
    scales = units.scales(biped.legs == "rigid")
    exact = [arb(text) / scale for text, scale in zip(centre, scales)]
    thin = [each.mid() for each in exact]
    reach = column([arb(0, (arb(radius) / scale + 2 * (each - each.mid())).abs_upper())
                    for each, scale in zip(exact, scales)])  # fmt: skip
    nothing = Scalar(arb(0), arb_mat(1, len(thin)))
    walk = Walk(machine_of(biped, slope, units), Carried.box(thin, reach), nothing, nothing, units.time)
    counted = iter(range(10**9))
    walk.advance = lambda phase: progress(next(counted), phase)
    try:
        for _ in range(steps):
            walk.step()
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        raise NotProven(f"numbers are too wide to go on, after {', '.join(walk.phases) or 'the start'}") from None
    return walk, thin, reach


def krawczyk(walk: Walk, thin: list[Ball], reach: Matrix) -> tuple[Matrix, Matrix]:
    """Krawczyk's box less the centre, and the part of it that comes from the ball's extent."""
    derivative, size = walk.carried.derivative, len(thin)
    one = arb_mat(size, size, [arb(int(i == j)) for i in range(size) for j in range(size)])
    inverse = (one - derivative.mid()).inv().mid()
    rest = (one - inverse * (one - derivative)) * reach
    return inverse * (column(walk.carried.centre) - column(thin)) + rest, rest


def refined(biped: Biped, slope: Slope, guess: list[float], steps: int, progress: Callable[[int, str], None]
            ) -> tuple[list[str], str]:  # fmt: skip
    """A better centre than the `guess` (SI units), and a radius that suits it, as decimals. Raises NotProven."""
    walk, thin, reach = walked(biped, slope, [repr(each) for each in guess], repr(FIRST), steps, progress)
    found, rest = krawczyk(walk, thin, reach)
    if not all(each.is_finite() for each in found.entries()):
        raise NotProven("the map's derivative is not known well enough to test a ball")
    share = max(float(a.rad()) / float(b.rad()) for a, b in zip(rest.entries(), reach.entries()))
    radius = min(max(FIRST / (share * SURE), LEAST), MOST)
    digits = -math.floor(math.log10(radius))
    scales = Units.of(biped, slope).scales(biped.legs == "rigid")
    better = [(a + b).mid() * scale for a, b, scale in zip(thin, found.entries(), scales)]
    return [decimals(each, digits + round(math.log10(FINER))) for each in better], f"1e-{digits}"


def decimals(value: Ball, digits: int) -> str:
    """A thin number rounded to so many digits behind the point."""
    scaled = (value * arb(10) ** digits + arb("0.5")).mid().floor().unique_fmpz()
    sign, text = "-" if scaled < 0 else "", str(abs(int(scaled))).rjust(digits + 1, "0")
    return f"{sign}{text[:-digits]}.{text[-digits:]}"


def prove(biped: Biped, slope: Slope, centre: list[str], radius: str, steps: int, progress: Callable[[int, str], None]
          ) -> Theorem:  # fmt: skip
    """The theorem for the ball of `radius` about `centre` (decimals, SI units). Raises NotProven."""
    walk, thin, reach = walked(biped, slope, centre, radius, steps, progress)
    found, _ = krawczyk(walk, thin, reach)
    units = Units.of(biped, slope)
    scales = units.scales(biped.legs == "rigid")
    for place, (each, scale) in enumerate(zip(found.entries(), scales)):
        inner = (arb(radius) / scale * (1 - arb(2) ** -60)).abs_lower()
        if not arb(0, inner).contains_interior(each):
            raise NotProven(f"the fixed point is not shown to be in the ball: Krawczyk's test fails in entry {place} "
                            "of the state")
    multipliers = enclosed(walk.carried.derivative)
    force = arb(units.length) / arb(units.time) ** 2
    return Theorem(
        walk.phases, centre, radius, [(a + b) * scale for a, b, scale in zip(thin, found.entries(), scales)],
        walk.time.over(found) * arb(units.time) / steps, walk.length.over(found) * arb(units.length) / steps,
        {phase: least * force for phase, least in walk.least.items()}, multipliers)  # fmt: skip


def enclosed(derivative: Matrix) -> Multipliers:
    """Enclosures of the eigenvalues of any matrix in a matrix of balls."""
    from scipy.linalg import schur

    size = derivative.nrows()
    middle = np.array([[float(derivative[i, j].mid()) for j in range(size)] for i in range(size)])
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
        centre = acb(similar[i, i].real.mid(), similar[i, i].imag.mid())
        radius = abs(similar[i, i] - centre) + sum((abs(similar[i, j]) for j in range(size) if j != i), arb(0))
        discs.append((centre, arb(radius.abs_upper())))
    groups = grouped(discs)
    least = [min_of([abs(discs[i][0]) - discs[i][1] for i in group]) for group in groups]
    most = [max_of([abs(discs[i][0]) + discs[i][1] for i in group]) for group in groups]
    alone = [discs[group[0]] for group in groups if len(group) == 1 and large_disc(discs[group[0]])]
    alone.sort(key=lambda disc: -float(abs(disc[0])))
    rest = [high for group, high in zip(groups, most) if len(group) > 1 or not large_disc(discs[group[0]])]
    return Multipliers(alone, max_of(rest) if rest else arb(0), max_of(least), max_of(most))


def large_disc(disc: tuple[Any, Ball]) -> bool:
    """Whether a disc is small beside the distance of its centre from zero."""
    return bool(disc[1] < abs(disc[0]) / 10)


def grouped(discs: list[tuple[Any, Ball]]) -> list[list[int]]:
    """Places of discs in groups that are not known to be apart."""
    groups: list[list[int]] = []
    for i, (centre, radius) in enumerate(discs):
        near = [group for group in groups
                if any(not abs(discs[j][0] - centre) > discs[j][1] + radius for j in group)]  # fmt: skip
        groups = [group for group in groups if group not in near] + [[i, *(j for group in near for j in group)]]
    return groups


def max_of(balls: list[Ball]) -> Ball:
    """The upper end of the largest number."""
    return max((arb(each.upper()) for each in balls), key=float)


def min_of(balls: list[Ball]) -> Ball:
    """The lower end of the least number."""
    return min((arb(each.lower()) for each in balls), key=float)
