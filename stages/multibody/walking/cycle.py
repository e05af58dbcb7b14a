"""The gait of a multibody model: its cycle, solved for, its derivative by finite differences, and whether the walk has
settled on it.
"""

from math import nan

import numpy as np

from stages.biped.accuracy.scales import scales_of
from stages.biped.design import Biped
from stages.biped.walk import Walk
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import static_penetration
from stages.ground.slope import Slope
from stages.multibody.parameters import Parameters, Settings
from stages.multibody.result import Cycle
from stages.multibody.walking.walk import build, simulate
from stages.planar.limit_cycle import by_differences, fixed_point, gait_near, nearer
from stages.planar.run import LimitCycle, PlanarState, Run
from stages.planar.sampling import find_events, peaks
from stages.planar.section import NoLimitCycle, SectionStep, mid_stance_after, section_scales, section_state
from stages.planar.signals import GROUND_REACTION

DIFFERENCE = 1e-4
#: Numbers that lift the standing foot, hip y and its leg's length, and the share of its depth that they may change by,
#: usually and at most.
LIFTING, SHARE_OF_DEPTH, MOST_OF_DEPTH = [0, 2], 0.4, 0.8


class SectionWalker:
    """A built model that takes steps from mid-stance to mid-stance, and counts them.

    `difference` is the step of its finite differences, in `section_scales`; none lifts the standing foot by more than a
    `share_of_depth`. A cycle is one step, or two where the legs differ: leg 0 stands at its start and its end.
    """

    def __init__(
        self, biped: Biped, slope: Slope, contact: ContactLaw, state: PlanarState, settings: Settings,
        difference: float, share_of_depth: float = SHARE_OF_DEPTH,
    ) -> None:
        self.model = biped, slope, contact
        self.start, self.settings = state, settings
        sunk = static_penetration(contact, biped.weighed_mass * slope.gravity)
        self.scales = section_scales(biped, slope)
        self.differences = difference * self.scales
        self.differences[LIFTING] = np.minimum(self.differences[LIFTING], share_of_depth * sunk)
        self.machine = build(biped, slope, contact, settings, signals=())
        self.steps_a_cycle = biped.steps_a_cycle
        self.steps_walked = 0

    @property
    def tolerance(self) -> float:
        """Tolerance of the solver."""
        return self.settings.tolerance

    def walk(self, start: PlanarState, steps: int) -> SectionStep:
        """Walk from a mid-stance to the one after `steps` steps. Raises NoLimitCycle."""
        self.steps_walked += steps
        return mid_stance_after(
            simulate(*self.model, start, self.settings, steps=steps, assembly=self.machine)
        )

    def step(self, numbers: np.ndarray) -> SectionStep:
        """One cycle from section numbers (10,). Raises NoLimitCycle."""
        return self.walk(section_state(numbers, self.start), self.steps_a_cycle)

    def derivative(self, numbers: np.ndarray, after: SectionStep | None = None) -> np.ndarray:
        """Derivative (10, 10) of the cycle, by central differences, or by forward ones if the step itself is known."""
        return by_differences(self.step, numbers, self.differences, after)


#: Steps at the end of a walk that show what it does.
LAST_STEPS = 4
#: A walk has settled when the last step's period and length are this close to the cycle's.
SETTLED_WITHIN = 0.01
#: One whose last periods differ by less than this, in pendulum times, ends near it.
NEARLY_SETTLED = 2.7e-3
#: Forward and central differences, in the section's scales, of steps at a tolerance of `USUAL`. Multipliers are then
#: within .003 and .0003: smaller ones leave more of the steps' noise, larger ones more of the map's bend, which central
#: ones have only in second order. At another tolerance they are larger by a root of it, where both errors grow alike;
#: so looser steps show the bend's too.
USUAL, FORWARD, CENTRAL = 1e-7, 5e-4, 2e-3


def solve(
    model: Parameters, state: PlanarState, walked: Run, walk: Walk
) -> tuple[Cycle, LimitCycle | None, str]:
    """The cycle near a mid-stance, its fixed point, and why the walk from there has not settled on it ("" if it has).

    Where no cycle is found, measures of the walk's last steps, and no fixed point.
    """
    found: LimitCycle | None = None
    try:
        near = period_change(walk) < NEARLY_SETTLED * scales_of(model.biped, model.slope.gravity).time
        found = search(model, state, walked if near else None)
        cycle, failure = solved_cycle(model, state, found, walk), ""
    except NoLimitCycle as error:
        found, failure = None, str(error)
        cycle = walked_cycle(walked, walk, model.contact, model.biped.foot_radii)
    return cycle, found, unsettled(walked, walk, cycle, failure, model.biped.steps_a_cycle)


def search(model: Parameters, state: PlanarState, walked: Run | None = None) -> LimitCycle:
    """The gait near a mid-stance, at the coarse tolerance, with its multipliers: by central differences, unless what
    is requested is coarser still. Then the end of a walk from there that has nearly settled is where it is looked for.

    Raises NoLimitCycle.
    """
    coarse, central = model.at(model.settings.coarse), model.settings.tolerance <= model.settings.coarse
    if not central and walked is not None and walked.completed and model.biped.alike:
        state = mid_stance_after(walked).state
    larger = (coarse.settings.tolerance / USUAL) ** (1 / 3 if central else 1 / 2)
    difference, share = larger * (CENTRAL if central else FORWARD), min(larger * SHARE_OF_DEPTH, MOST_OF_DEPTH)
    walker = SectionWalker(model.biped, model.slope, model.contact, state, coarse.settings, difference, share)
    return gait_near(walker, state, central=central)


def solved_cycle(model: Parameters, state: PlanarState, found: LimitCycle, walk: Walk) -> Cycle:
    """Measures of the gait that was `found`, at the model's tolerance where that is finer. Raises NoLimitCycle."""
    settings = model.at(min(model.settings.tolerance, model.settings.coarse)).settings
    walker = SectionWalker(model.biped, model.slope, model.contact, state, settings, CENTRAL)
    point = fixed_point(walker, found.section_state, found.monodromy_matrix)
    point = nearer(walker, point, found.monodromy_matrix)
    machine = build(model.biped, model.slope, model.contact, settings,
                    signals=[name for name in settings.signals if name == GROUND_REACTION])
    start = section_state(point.numbers, state)
    steps = walker.steps_a_cycle
    run = simulate(model.biped, model.slope, model.contact, start, settings, steps=steps, assembly=machine)
    events = find_events(run.trajectory, model.biped.foot_radii)
    ends = min(steps, len(events.toe_off_time))
    both_down = events.toe_off_time[:ends] - events.heel_strike_time[:ends]
    period, length = point.step.period, point.step.step_length
    force, depth = peaks(run.trajectory, model.contact, model.biped.foot_radii, 0.0, point.step.duration).max(axis=1)
    return Cycle(
        solved=True,
        period_s=period,
        step_frequency_hz=1.0 / period,
        step_length_m=length,
        speed_m_s=length / period,
        double_stance_s=float(both_down.mean()) if ends == steps else nan,
        peak_normal_force=float(force),
        largest_penetration=float(depth),
        floquet_multipliers=found.floquet_multipliers,
        steps=steps,
        residual=point.residual,
        period_change=period_change(walk),
    )


def walked_cycle(walked: Run, walk: Walk, contact: ContactLaw, radii: tuple[float, float]) -> Cycle:
    """Measures over the last four whole steps of a walk, or fewer if there are no more."""
    strikes = walk.heel_strike_time
    count = min(LAST_STEPS, len(strikes) - 1)
    none = np.zeros((0, 2))
    if count < 1:
        return Cycle(False, nan, nan, nan, nan, nan, nan, nan, none, 1, nan, nan)
    last = strikes[-1 - count :]
    hip = walked.trajectory.at(last)[0][:, 0]
    period, length = float(last[-1] - last[0]) / count, float(hip[-1] - hip[0]) / count
    force, depth = peaks(walked.trajectory, contact, radii, float(last[0]), float(last[-1])).max(axis=1)
    return Cycle(
        solved=False,
        period_s=period,
        step_frequency_hz=1.0 / period,
        step_length_m=length,
        speed_m_s=length / period,
        double_stance_s=walk.double_stance(last),
        peak_normal_force=float(force),
        largest_penetration=float(depth),
        floquet_multipliers=none,
        steps=1,
        residual=nan,
        period_change=period_change(walk),
    )


def period_change(walk: Walk) -> float:
    """Largest difference between the periods of the walk's last steps [s]; NaN without two of them."""
    periods = np.diff(walk.heel_strike_time[-1 - LAST_STEPS :])
    return float(np.ptp(periods)) if len(periods) else nan


def unsettled(walked: Run, walk: Walk, cycle: Cycle, failure: str, steps: int = 1) -> str:
    """Why a walk has not settled on a cycle of so many steps, "" if it has. `failure`: why no fixed point was found."""
    if not cycle.solved:
        return f"no fixed point of its step was found ({failure})"
    if cycle.largest_multiplier >= 1.0:
        return f"its gait is unstable, largest multiplier {cycle.largest_multiplier:.3f} in magnitude"
    if not walked.completed:
        return f"its gait is stable, but the walk ended early: {walked.message or walked.outcome}"
    strikes = walk.heel_strike_time
    if len(strikes) <= steps:
        return "its gait is stable, but the walk has no whole step that could show it"
    ends = strikes[[-1 - steps, -1]]
    hip = walked.trajectory.at(ends)[0][:, 0]
    last = np.array([ends[1] - ends[0], hip[1] - hip[0]]) / steps
    away = float(np.abs(last / [cycle.period_s, cycle.step_length_m] - 1.0).max())
    if away > SETTLED_WITHIN:
        return f"its gait is stable, but after {len(strikes)} steps the last one still differs by {100 * away:.1f} %"
    return ""
