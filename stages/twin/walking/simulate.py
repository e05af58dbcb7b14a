"""Let the twin walk: the one entry for everything that needs such a walk.

The watch over a run on the ramp: feet swing down through the gaps between blocks, and must come down on a block.

The ground acts on a pair while both its feet are over their blocks. A foot that crosses a block's edge does so in the
air, so the force never jumps; if it touches then, or comes down where no block is, the run ends with that reason.
"""

import math
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from stages.biped.walk import StanceState
from stages.ground.blocks import Laid
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import static_penetration
from stages.ground.slope import Slope
from stages.multibody.assembly.solver import explicit_plan, solve
from stages.multibody.walking.watch import Look, Watch, Words
from stages.planar.run import DIVERGED, FALLEN, patience
from stages.twin.machine.contact import COUNT, HINGE, PITCH, ROLL, SLIDE, YAW, X, Y, Z, feet_places
from stages.twin.machine.machine import LEGS, Machine
from stages.twin.machine.tree import SpatialTree
from stages.twin.parameters import Settings
from stages.twin.ramp import Ramp
from stages.twin.walking.record import Record

MISSED = "missed a block"


WORDS = Words(
    stuck="the solver's step became too small",
    endless="the solver took {calls} steps without a heel strike",
    diverged="the state is not finite",
    fell="fell in step {step}",
    stalled="no heel strike for {longest:g} s after step {done}",
    late="{wanted} steps not done in {limit:g} s",
)


@dataclass
class RampWatch(Watch):
    """`Watch` of a `tree` with the ground of a `ramp`; `risen` shows which pairs are in the air ahead of the other."""

    tree: SpatialTree = field(kw_only=True)
    ramp: Ramp = field(kw_only=True)
    risen: list[bool] = field(default_factory=lambda: [False, False])

    def switch(self, time: float, look: Look) -> None:
        """Let the ground act on pairs that are over their blocks; end the run where a foot misses one."""
        places = feet_places(self.tree.position(), self.tree.feet)
        places[:, 1] -= np.repeat(self.tree.ground[2:], 2)
        middle = places[::2, 0] + places[1::2, 0]
        for pair in (0, 1):
            feet = (2 * pair, 2 * pair + 1)
            carried = {foot: self._carried(foot, places[foot]) for foot in feet}
            low = [foot for foot in feet if places[foot, 1] <= 0.0]
            ahead = bool(middle[pair] > middle[1 - pair])
            missed = self._cross_edge(time, pair, carried, low, places)
            if not missed and low and not self.in_play[pair] and self.risen[pair] and ahead:
                missed = self._landing(low[0], places[low[0]])
            if missed:
                self.end(MISSED, missed)
                return
            self.risen[pair] = ahead and not low
            if low:
                self.touch(time, pair)

    def _cross_edge(
        self, time: float, pair: int, carried: dict[int, bool], low: list[int], places: np.ndarray
    ) -> str:
        """A pair passes the edge of its blocks: fine in the air, else what went wrong."""
        lost, struck = ([foot for foot in low if carried[foot] == there] for there in (False, True))
        if self.in_play[pair] and not all(carried.values()):
            if lost:
                return self._departure(lost[0], places[lost[0]])
            self.set(time, pair, False)
        elif not self.in_play[pair] and any(carried.values()):
            if struck:
                number = self.ramp.number(pair, float(places[struck[0], 0]))
                return f"{self._foot(struck[0])} struck the side of block set {number}"
            if all(carried.values()):
                self.set(time, pair, True)
        return ""

    def _carried(self, foot: int, place: np.ndarray) -> bool:
        half_width = self.tree.machine.half_width
        return self.ramp.carries(foot // 2, float(place[0]), float(place[2]), half_width)

    def _foot(self, foot: int) -> str:
        return f"in step {self.heel_strikes + 1} the {LEGS[foot]} foot"

    def _departure(self, foot: int, place: np.ndarray) -> str:
        aside = self.ramp.beside(foot // 2, float(place[2]), self.tree.machine.half_width)
        way = f"over the side of its block by {1e3 * aside:.1f} mm" if aside > 0.0 else "off the end of its block"
        return f"{self._foot(foot)} went {way}"

    def _landing(self, foot: int, place: np.ndarray) -> str:
        pair, x = foot // 2, float(place[0])
        number, miss = self.ramp.number(pair, x), self.ramp.miss(pair, x)
        if number > self.ramp.sets:
            return f"{self._foot(foot)} left the ramp beyond its last set of blocks"
        aside = self.ramp.beside(pair, float(place[2]), self.tree.machine.half_width)
        if miss == 0.0:
            return f"{self._foot(foot)} came down {1e3 * aside:.1f} mm beside block set {number}"
        side = "beyond" if miss > 0.0 else "short of"
        return f"{self._foot(foot)} came down {1e3 * abs(miss):.1f} mm {side} block set {number}"


@dataclass(frozen=True)
class Start:
    """Initial coordinates and rates of the tree (11,), and whether the ground acts on each pair."""

    position: np.ndarray
    velocity: np.ndarray
    in_play: tuple[bool, bool] = (True, False)


def rolling_start(
    machine: Machine,
    contact: ContactLaw,
    stance: StanceState,
    normal_force: float,
    *,
    yaw: float = 0.0,
    yaw_rate: float = 0.0,
    roll_rate: float = 0.0,
    sideways: float = 0.0,
) -> Start:
    """The simple model's state given to the twin: inner pair standing and rolling, outer pair swinging, out of play.

    Both feet of the inner pair are pressed into the ground by `normal_force` [N] in all. Leg lengths of `stance` are
    those of the simple model; a longer machine keeps its springs as loaded. Yaw [rad], its rate and that of roll
    [rad/s] and a speed to the side [m/s] are pushes that the simple model does not know.
    """
    r = float(np.mean(machine.radius[:2]))
    longer = float(np.mean(machine.length[:2])) - machine.drawn_lengths[0]
    theta, length = stance.stance_angle, stance.stance_length + longer
    rate, length_rate = stance.stance_rate, stance.stance_length_rate
    sine, cosine = math.sin(theta), math.cos(theta)
    q, v = np.zeros(COUNT), np.zeros(COUNT)
    q[X] = r * theta + (length - r) * sine
    q[Y] = r + (length - r) * cosine - static_penetration(contact, max(normal_force, 0.0))
    forward = r * rate + length_rate * sine + rate * (length - r) * cosine
    v[X], v[Z] = forward * math.cos(yaw), sideways - forward * math.sin(yaw)
    v[Y] = length_rate * cosine - rate * (length - r) * sine
    q[YAW], v[YAW], v[ROLL] = yaw, yaw_rate, roll_rate
    q[PITCH], v[PITCH] = -theta, -rate
    q[HINGE], v[HINGE] = stance.swing_angle + theta, stance.swing_rate + rate
    for leg, slide in enumerate(SLIDE):
        standing = leg < 2
        q[slide] = machine.drawn_lengths[leg // 2] - (stance.stance_length if standing else stance.swing_length)
        v[slide] = -(stance.stance_length_rate if standing else stance.swing_length_rate)
    return Start(q, v)


def simulate_twin(
    machine: Machine,
    slope: Slope,
    contact: ContactLaw,
    start: Start,
    settings: Settings,
    *,
    steps: int | None = None,
    tree: SpatialTree | None = None,
    ramp: Ramp | None = None,
    blocks: Laid | None = None,
) -> Record:
    """Walk from `start` at t = 0 through `steps` heel strikes (default: the settings') to the mid-stance after them.

    With a `ramp` there is ground on its blocks only, and the walk ends at the latest on the last of them. A fall, a
    standstill or a failure of the solver ends the walk earlier; the record's outcome and reason show it. `blocks` have
    drawn heights.
    Pass a built `tree` of the same machine to save building it again.
    """
    wanted_steps = settings.steps if steps is None else steps
    if ramp is not None:
        wanted_steps = min(wanted_steps, ramp.steps)
    machine_tree = tree or SpatialTree(machine, slope, contact)
    machine_tree.start(start.position, start.velocity, start.in_play)
    standing = list(start.in_play)
    made = Watch if ramp is None else partial(RampWatch, tree=machine_tree, ramp=ramp)
    watch = made(
        walker=machine_tree,
        fallen=FALLEN * float(machine.length[0]),
        longest_step=patience(settings.longest_step, machine.drawn_lengths[0], slope),
        steps_wanted=wanted_steps,
        in_play=standing,
        landed=standing.copy(),
        last_landed=int(not standing[0]),
        most_calls=settings.most_solver_steps,
        words=WORDS,
        blocks=blocks,
    )
    watch.lay_first()
    plan = explicit_plan(settings.tolerance, settings.largest_step, watch.limit)
    rows, evaluations, _ = solve(machine_tree, watch, plan, watch.limit)
    return Record(
        **rows, exact_acceleration=machine_tree.exact_acceleration, in_play_at_start=start.in_play,
        switches=tuple(watch.switches), blocks=tuple(watch.laid),
        machine=machine, slope=slope, contact=contact, outcome=watch.outcome,
        reason=WORDS.diverged if watch.outcome == DIVERGED else watch.message,
        heel_strikes=watch.heel_strikes, evaluations=evaluations)
