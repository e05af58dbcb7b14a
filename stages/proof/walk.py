"""One step of the walk, enclosed, with the theorem's conditions (docs/proof.md) on the tube of every step of time."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from flint import arb, arb_mat
from scipy.optimize import brentq

from stages.biped.accuracy.scales import Scales
from stages.proof import flow
from stages.proof.equations import LENGTH, SWING_LENGTH, Machine, foot, motion, strike
from stages.proof.flow import Ball, Carried, Matrix, NotProven, Step, column, jacobian

DOUBLE_STANCE, SINGLE_STANCE = "double stance", "single stance"
#: Lengths of the first and of the shortest step of time, by what one is made shorter if it is not enclosed, or longer,
#: and how long no gait is.
FIRST, SHORTEST, SHORTER, LONGER, LONGEST = 1.0, 1e-4, 0.7, 1.05, 1e5
#: How often a step is cut in two, until a force is known to this part of its size.
CUTS, FORCE_WIDTH = 12, 0.02


@dataclass
class Walk:
    """What is gathered on the way: the set, time and way (in the machine's `scales`), phases, and the stance
    foot's least forces.
    """

    machine: Machine
    carried: Carried
    scales: Scales
    advance: Callable[[str], None]
    time: Ball = field(default_factory=arb)
    length: Ball = field(default_factory=arb)
    phases: list[str] = field(default_factory=list)
    least: dict[str, Ball] = field(default_factory=dict)
    both: bool = False

    def step(self) -> None:
        """Walk to the next heel strike, legs renamed. Raises NotProven."""
        for phase in (DOUBLE_STANCE, SINGLE_STANCE)[LENGTH not in self.machine.free :]:
            self.phases.append(phase)
            self.both = phase == DOUBLE_STANCE
            self.phase()
        hull = self.carried.hull
        self.length += foot(self.machine, hull)[2]
        _, slope = jacobian(lambda y: strike(self.machine, y), hull)
        end = strike(self.machine, list(self.carried.x.entries()))
        self.carried, self.machine = self.carried.after(column(end), arb_mat(slope)), self.machine.exchanged
        if not self.carried.hull[len(self.machine.free) // 2] < 0:
            raise NotProven("at heel strike the hip is not between the feet")

    def measured(self, steps: int) -> dict[str, Ball]:
        """Period and length of the mean of all steps, and least forces, in SI units."""
        forces = {f"least_force_{phase.replace(' ', '_')}_N": force * arb(self.scales.size("N"))
                  for phase, force in self.least.items()}  # fmt: skip
        return {"period_s": self.time * arb(self.scales.time) / steps,
                "step_length_m": self.length * arb(self.scales.length) / steps, **forces}  # fmt: skip

    def phase(self) -> None:
        """Carry the set to the end of the phase. Raises NotProven."""
        length = FIRST
        while True:
            polynomial = flow.expanded(self.rates, list(self.carried.x.entries()))
            end = found = None
            while found is None:
                end = self.crossing(polynomial[0], length)
                tried = arb(length if end is None else end)
                with suppress(ValueError):  # a divisor may be zero
                    found = flow.step(self.rates, polynomial, tried, flow.sizes(self.carried.spread))
                length *= SHORTER if found is None else LONGER
                self.require(length > SHORTEST, "the flow could not be enclosed")
            self.require(self.time < LONGEST, "no end of the phase was found")
            self.check(found, arb(0), found.length, end is not None, CUTS)
            self.carried = self.carried.after(found.end, found.derivative)
            self.time += found.length
            if end is not None:
                self.end()
                return
            self.advance(f"{self.phases[-1]}, {float(self.time) * self.scales.time:.3f} s")

    def rates(self, y: Sequence[Any]) -> list[Any]:
        """Rates at a state."""
        return [*y[len(y) // 2 :], *motion(self.machine, y, self.both)[0]]

    def guard(self, y: Sequence[Any]) -> Any:
        """What falls to zero at the phase's end: the trailing foot's normal force, or the swing foot's height."""
        return motion(self.machine, y, True)[2] if self.both else foot(self.machine, y)[0]

    def slope(self, y: Sequence[Ball]) -> tuple[Matrix, Matrix, Ball]:
        """The guard's derivative by the state (1, n), the state's rates (n, 1), and how fast the guard changes."""
        slope, rates = arb_mat(jacobian(lambda z: [self.guard(z)], y)[1]), column(self.rates(y))
        return slope, rates, (slope * rates)[0, 0]

    def require(self, shown: bool, what: str, time: Ball = 0) -> None:
        """Raise NotProven with the place, unless a condition is shown; `what` says how it fails."""
        if not shown:
            seconds = float(self.time + time) * self.scales.time
            raise NotProven(f"{what}, in {self.phases[-1]}, {seconds:.6g} s after the start")

    def crossing(self, table: Matrix, length: float) -> float | None:
        """The time at which the guard falls through zero along a thin polynomial, about; None if it does not."""
        first, last = flow.at(table, arb(0)), flow.at(table, arb(length))
        if not self.guard(first) > 0 or not self.guard(last) < 0 or not (self.both or foot(self.machine, last)[1] > 0):
            return None
        return float(brentq(lambda time: float(self.guard(flow.at(table, arb(time)))), 0.0, length))

    def check(self, found: Step, low: Ball, high: Ball, last: bool, cuts: int) -> None:
        """Show the conditions from time `low` to `high` of a step, at whose end is the event if it is the `last`."""
        broken = self.broken(found.tube(low.union(high)), last)
        if broken is not None:
            self.require(cuts > 0, broken, low)
            middle = ((low + high) / 2).mid()
            self.check(found, low, middle, last, cuts - 1)
            self.check(found, middle, high, last, cuts - 1)

    def broken(self, y: Sequence[Ball], last: bool) -> str | None:
        """The condition that cannot be shown at states in a box, in words. At the `last` the guard may fall to zero."""
        machine = self.machine
        (_, force, guard), (height, ahead, _), (q, _) = motion(machine, y, self.both), foot(machine, y), machine.full(y)
        legs = (LENGTH, machine.stance), (SWING_LENGTH, machine.swing)
        if not all(q[place] > leg.foot_radius.max(leg.foot_com) for place, leg in legs):
            return "a leg may be pressed down to its foot"
        if not force > 0 or force.rad() > FORCE_WIDTH * force:
            return "the ground may have to pull the stance foot"
        if self.both and not (guard > 0 or (last and self.slope(y)[2] < 0)):
            return "the ground may have to pull the trailing foot"
        if not (self.both or ahead < 0 or height > 0):
            rate = self.slope(y)[2]
            if not (rate < 0 if last else height < 0 or rate > 0):
                return "the swing foot may strike before"
        self.least[self.phases[-1]] = force.min(self.least.get(self.phases[-1], force))
        return None

    def end(self) -> None:
        """Bring the set, which is near the event, to it along the flow (interval Newton method in time)."""
        hull = self.carried.hull
        reach = arb(0, (self.guard(hull) / self.slope(hull)[2]).abs_upper()) * 2
        box = [a + 2 * reach * b for a, b in zip(hull, self.rates(hull))]
        slope, rates, rate = self.slope(box)
        self.require(rate < 0, "the event may be a touch and no crossing")
        time = -self.guard(hull) / rate
        stays = all(b.contains(a + reach * c) for a, b, c in zip(hull, box, rates.entries()))
        self.require(stays and reach.contains(time), "the event's time could not be enclosed")
        broken = self.broken(box, True)
        self.require(broken is None, str(broken))
        self.require(self.both or foot(self.machine, box)[1] > 0, "the swing foot is not ahead where it lands")
        one, linear = flow.identity(len(box)), flow.sizes(arb_mat(jacobian(self.rates, box)[1]))
        flown = one + flow.around((linear * arb(reach.abs_upper())).exp() - one)  # the flow's derivative in this time
        delays = slope * flown * (-1 / rate)
        at_x = -self.guard(list(self.carried.x.entries())) / rate
        self.time += time
        self.carried = self.carried.after(self.carried.x + rates * at_x, flown + rates * delays)
