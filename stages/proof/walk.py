"""One step of the walk, enclosed: double stance, toe-off, single stance, heel strike, with all that the model asks.

The theorem's conditions are tested on the tube of every step of time, cut into pieces until each holds:

- the ground pushes on the stance foot, and in double stance on the other foot, whose force falls to zero only at the
  end: where it cannot be told from zero there, it falls;
- no heel strike before the last: with the swing foot ahead, its height has no zero through which it falls. The height
  is zero as a phase begins, and may pass zero behind the stance foot, which the model's guard leaves out;
- no leg is pressed down to its foot, and the hip is between the feet after heel strike.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from flint import arb, arb_mat

from stages.proof.equations import Machine, foot, full, motion, strike
from stages.proof.flow import Ball, Matrix, NotProven, Polynomial, Step, column, expanded, quick_enough, step, upper
from stages.proof.jets import gradient, jacobian
from stages.proof.sets import Carried, Scalar

DOUBLE_STANCE, SINGLE_STANCE = "double stance", "single stance"
#: Most steps of time of a phase, and how often a piece of a step is cut in two.
MOST_STEPS, CUTS = 3000, 12
#: Pieces are cut until a force is known to this part of its size.
FORCE_WIDTH = 0.02
#: Bisections of an event's time.
BISECTIONS = 120


@dataclass
class Walk:
    """What is gathered on the way: time (its `unit` in seconds), way, phases, and the stance foot's least forces."""

    machine: Machine
    carried: Carried
    time: Scalar
    length: Scalar
    unit: float
    phases: list[str] = field(default_factory=list)
    least: dict[str, Ball] = field(default_factory=dict)
    advance: Callable[[str], None] = lambda _: None

    def step(self) -> None:
        """Walk to the next heel strike, legs renamed. Raises NotProven."""
        if not self.machine.rigid:
            Phase(self, True).run()
        Phase(self, False).run()
        machine, hull = self.machine, self.carried.hull
        self.length = self.length.more(self.carried.scalar(lambda y: foot(machine, y)[2]))
        slope = jacobian(lambda y: strike(machine, y), hull)
        end = strike(machine, list(self.carried.x.entries()))
        self.carried = self.carried.after(column(end), matrix(slope))
        self.machine = machine.exchanged
        angle = self.carried.hull[len(self.machine.free) // 2]
        if not angle < 0:
            raise NotProven("at heel strike the hip is not between the feet")


def matrix(rows: Sequence[Sequence[Any]]) -> Matrix:
    """Rows as a matrix."""
    return arb_mat(len(rows), len(rows[0]), [each for row in rows for each in row])


class Phase:
    """A phase of a walk, in double stance (`both`) or single stance, with its guard."""

    def __init__(self, walk: Walk, both: bool) -> None:
        self.walk, self.machine, self.both = walk, walk.machine, both
        self.name = DOUBLE_STANCE if both else SINGLE_STANCE
        self.elapsed = arb(0)
        #: Equal rigid legs have both feet at one place where they pass. Ahead, height has the sign of psi - theta.
        self.by_angles = self.machine.rigid and self.machine.alike

    def field(self, y: Sequence[Any]) -> list[Any]:
        """Rates at a state."""
        return [*y[len(y) // 2 :], *motion(self.machine, y, self.both, forces=False).accelerations]

    def guard(self, y: Sequence[Any]) -> Any:
        """What falls to zero at the phase's end: the trailing foot's normal force, or the swing foot's height."""
        if self.both:
            return motion(self.machine, y, True, forces=False).trailing_force
        return y[1] - y[0] if self.by_angles else foot(self.machine, y)[0]

    def refuse(self, what: str, time: Ball) -> NotProven:
        """What cannot be shown, with its place."""
        return NotProven(f"{what}, in {self.name} of step {self.steps}, "
                         f"{float(self.elapsed + time) * self.walk.unit:.6g} s into it")  # fmt: skip

    @property
    def steps(self) -> int:
        """Number of the step that is being walked."""
        return self.walk.phases.count(SINGLE_STANCE) + 1

    def run(self) -> None:
        """Carry the walk's set to the end of the phase. Raises NotProven."""
        walk, share = self.walk, 1.0
        for _ in range(MOST_STEPS):
            polynomial = expanded(self.field, list(walk.carried.x.entries()))
            spread = [upper(each) for each in walk.carried.spread.entries()]
            longest = quick_enough(polynomial)
            try:
                end = self.crossing(polynomial, arb(longest * share))
                found = step(self.field, polynomial, longest * share if end is None else end, spread)
            except NotProven as reason:
                raise self.refuse(str(reason), arb(0)) from None
            share = min(1.0, 1.2 * float(found.length) / longest)
            ends = end is not None and found.length == end
            self.check(found, arb(0), found.length, ends, CUTS)
            walk.carried = walk.carried.after(found.end, found.derivative)
            walk.time = walk.time.more(Scalar(found.length, arb_mat(1, found.end.nrows())))
            self.elapsed += found.length
            if ends:
                self.end()
                walk.phases.append(self.name)
                return
            walk.advance(self.name)
        raise self.refuse("no end of the phase was found", arb(0))

    def crossing(self, polynomial: Polynomial, length: Ball) -> Ball | None:
        """The time at which the guard falls through zero along a thin polynomial, about; None if it does not."""
        def value(time: Ball) -> Ball:
            return self.guard([each.mid() for each in polynomial.at(time)]).mid()

        low, high = arb(0), length
        if not (value(low) > 0 and value(high) < 0):
            return None
        if not self.both and not foot(self.machine, [each.mid() for each in polynomial.at(high)])[1] > 0:
            return None
        for _ in range(BISECTIONS):
            middle = ((low + high) / 2).mid()
            low, high = (middle, high) if value(middle) > 0 else (low, middle)
        return high

    def rate(self, y: Sequence[Ball]) -> Ball:
        """How fast the guard changes at a state."""
        return sum((a * b for a, b in zip(gradient(self.guard, y), self.field(y))), arb(0))

    def check(self, found: Step, low: Ball, high: Ball, last: bool, cuts: int) -> None:
        """Show the conditions from time `low` to `high` of a step, at whose end is the event if it is the `last`."""
        broken = self.broken(found.tube(low.union(high)), last)
        if broken is None:
            return
        if cuts == 0:
            raise self.refuse(broken, low)
        middle = ((low + high) / 2).mid()
        self.check(found, low, middle, last, cuts - 1)
        self.check(found, middle, high, last, cuts - 1)

    def broken(self, y: Sequence[Ball], last: bool) -> str | None:
        """The condition that cannot be shown at states in a box, in words."""
        moves = motion(self.machine, y, self.both)
        q = full(self.machine, y[: len(y) // 2], True)
        legs = ((q[1], self.machine.stance), (q[3], self.machine.swing))
        if not all(length > leg.r and length > leg.l for length, leg in legs):
            return "a leg may be pressed down to its foot"
        force = moves.stance_force
        if not force > 0:
            return "the ground may have to pull the stance foot"
        if force.rad() > FORCE_WIDTH * force:
            return "the stance foot's force is not known well"
        if self.both:
            if not moves.trailing_force > 0 and not (last and self.rate(y) < 0):
                return "the ground may have to pull the trailing foot"
        else:
            value, ahead = self.guard(y), foot(self.machine, y)[1]
            if self.by_angles and not (value > -3 and value < 3):
                return "the legs may be too far apart"
            if not (ahead < 0 or value > 0):
                rising = not last and (value < 0 or self.rate(y) > 0)
                if not rising and not (last and self.rate(y) < 0):
                    return "the swing foot may strike before"
        known = self.walk.least.get(self.name)
        self.walk.least[self.name] = force if known is None else known.min(force)
        return None

    def end(self) -> None:
        """Cross the event, whose time lies within a little of where the set is (interval Newton method)."""
        carried = self.walk.carried
        hull = carried.hull
        guess, middle = self.guard(hull), self.rate(hull)
        reach = upper(guess / middle) * 4 if middle < 0 else arb(1)
        around = arb(0, reach)
        box = [a + around * b for a, b in zip(hull, self.field(hull))]
        box = [a.union(a + 2 * (a - a.mid())) for a in box]
        rates = self.field(box)
        if not all(b.contains(a + around * c) for a, b, c in zip(hull, box, rates)):
            raise self.refuse("the event could not be enclosed", arb(0))
        slope = arb_mat(1, len(box), gradient(self.guard, box))
        rate = (slope * column(rates))[0, 0]
        if not rate < 0:
            raise self.refuse("the event may be a touch and no crossing", arb(0))
        at_centre = -self.guard(list(carried.x.entries())) / rate
        delay = at_centre - (slope * carried.spread)[0, 0] / rate
        if not reach > delay or not -reach < delay:
            raise self.refuse("the event's time could not be enclosed", arb(0))
        broken = self.broken(box, True)
        if not self.both and not foot(self.machine, box)[1] > 0:
            broken = "the swing foot is not ahead where it lands"
        if broken is not None:
            raise self.refuse(broken, arb(0))
        linear = matrix(jacobian(self.field, box))
        size = len(box)
        norm = max(sum((upper(linear[i, j]) for j in range(size)), arb(0)).upper() for i in range(size)) * reach
        flown = matrix([[arb(int(i == j), (2 * norm).abs_upper()) for j in range(size)] for i in range(size)])
        if not norm < 0.5:
            raise self.refuse("the event's time is not known well", arb(0))
        delays = slope * flown * (-1 / rate)
        end = carried.x + column(rates) * at_centre
        derivative = flown + column(rates) * delays
        walk = self.walk
        walk.time = walk.time.more(Scalar(
            at_centre + (delays * carried.frame * carried.s)[0, 0], delays * carried.frame * carried.by_start))
        walk.carried = carried.after(end, derivative)

