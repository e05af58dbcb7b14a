"""When impacts begin, and when the other leg leaves the ground: finer than a sample, from all steps together.

Strikes that were laid over each other (heel_strikes.py) are each sampled at other phases, so their samples together
show the impact many times as finely as one does. What the force does there (a blow, a jump, a bend) is fitted behind
the second-order low pass of a sensor; where it begins is the event. The corner of the low pass is found as well, one
for both legs. Where it is declared, the samples' times are already less its delay, which is given back. What is read at
full scale was there or beyond: hard impacts show their height by nothing else.
"""

from dataclasses import dataclass

import numpy as np

from stages.imu.strikes.heel_strikes import lowest
from stages.imu.strikes.step_times import INNER, OUTER, HeelStrikes

WINDOW_S = (-0.04, 0.04)  # around a strike
ONSETS_S = np.arange(-0.02, 0.0121, 0.0005)
EARLIEST_S, LATEST_S = -0.02, 0.075  # where a lift is looked for first
COARSE_S, LIFT_S = 0.002, 0.0005  # how finely, at first and later
AFTER_S = 0.015  # that a lift is before the last of the samples at least
CORNERS = np.arange(0.15, 0.5, 0.05)  # of the low pass, in sampling rates
FEWEST_SAMPLES = 12  # of a leg, together: twice what is fitted to a force, a line, three responses and an onset
LEAST_GAIN = 0.95  # of the scatter about a straight line, that what is fitted must explain: in 84 runs 0.98 or more
AT_STRIKE = np.arange(-0.1, 0.11, 0.05)  # how far strikes may be off, in sampling periods
ROUNDS = 10  # in which it settles which samples tell: two to five; and until when a lift is looked for: two or three
UNKNOWN = 1e-9  # of what all samples show of a fitted number: it is zero where those that are left show less
STRIKE, LIFT = (0, 1, 2), (1, 2)  # columns of `responses`: a strike is a blow as well


@dataclass(frozen=True)
class Samples:
    """Samples of a sensor: time (n,) [s] less `taken_delay` [s] for its low pass, force (n, k) [m/s^2], and their rate.

    NaN where a force is not known. `beyond` (n, k) is 1 where it was this or more, -1 where this or less: clipped.
    """

    time: np.ndarray
    force: np.ndarray
    beyond: np.ndarray
    rate_hz: float
    taken_delay: float

    def around(self, strikes: np.ndarray, end: float = WINDOW_S[1]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times (m,) from the strike of all samples around each, to `end` [s], forces (m, k), and `beyond` (m, k)."""
        known = np.isfinite(self.force).all(axis=1)
        at, sensed, beyond = self.time[known], self.force[known], self.beyond[known]
        first, last = (np.searchsorted(at, strikes + edge) for edge in (WINDOW_S[0], end))
        rows = [np.arange(a, b) for a, b in zip(first, last)]
        every = np.concatenate([np.empty(0, dtype=np.int64), *rows])
        return at[every] - np.repeat(strikes, last - first), sensed[every], beyond[every]


def at_onsets(strikes: HeelStrikes, seen: Samples, transient: int) -> tuple[HeelStrikes, float]:
    """The strikes, all of a leg moved alike to where its impacts begin, and the corner of the low pass [Hz].

    The first `transient` strikes differ from the others: they are moved with them, and not looked at. Strikes found by
    their pulse are late by much of a slow sensor's period, so a leg whose impacts are not seen well enough moves with
    the other. The corner is NaN if neither is seen.
    """
    time, leg_of = strikes.time[transient:], strikes.leg[transient:]
    clouds = {leg: seen.around(time[leg_of == leg]) for leg in (INNER, OUTER)}
    clouds = {leg: cloud for leg, cloud in clouds.items() if (cloud[2] == 0).sum(axis=0).min() >= FEWEST_SAMPLES}
    costs = {leg: np.array([costs_of(*cloud, corner * seen.rate_hz, ONSETS_S, STRIKE) for corner in CORNERS])
             for leg, cloud in clouds.items()}  # fmt: skip
    if not costs:
        return strikes, float("nan")
    corner = int(np.argmin(sum(cost.min(axis=1) for cost in costs.values())))
    found = {leg: lowest(cost[corner], ONSETS_S) for leg, cost in costs.items()}
    onsets = {leg: onset for leg, onset in found.items() if np.isfinite(onset)}
    if not onsets:
        return strikes, float("nan")
    usual = float(np.mean(list(onsets.values())))
    moved = strikes.time + seen.taken_delay
    for leg in (INNER, OUTER):
        moved[strikes.leg == leg] += onsets.get(leg, usual)
    order = np.argsort(moved, kind="stable")
    return HeelStrikes(moved[order], strikes.leg[order]), float(CORNERS[corner] * seen.rate_hz)


def lift_after(strikes: np.ndarray, seen: Samples, corner_hz: float) -> float:
    """How long after the other leg's strikes (s,) [s] the sensor's foot is let go [s]; NaN where that is not seen.

    Its force is the foot's along the leg: what pressed the leg's slide together lets go when the ground does. Stiff
    legs give no slide that shows it: there the other leg's blow, at the strike, shows more. As much is looked at after
    the lift as after a strike, however long both feet stand.
    """
    if not np.isfinite(corner_hz):
        return float("nan")
    end, finely = LATEST_S + AFTER_S, COARSE_S
    for _ in range(ROUNDS):
        lifts = np.arange(EARLIEST_S, end - AFTER_S, finely)
        around = time, force, beyond = seen.around(strikes, end)
        if (beyond == 0).sum() < FEWEST_SAMPLES:
            return float("nan")
        cost = costs_of(*around, corner_hz, lifts, LIFT)
        following = WINDOW_S[1] + max(float(lifts[np.argmin(cost)]) + seen.taken_delay, 0.0)
        if finely == LIFT_S and abs(following - end) < LIFT_S:
            break
        end, finely = following, LIFT_S
    blow = costs_of(*around, corner_hz, AT_STRIKE / seen.rate_hz - seen.taken_delay, STRIKE)
    line = np.polynomial.polynomial.polyfit(time, force, 1)
    scatter = float(((force - np.vander(time, 2, increasing=True) @ line) ** 2).sum())
    left = float(np.exp(cost.min() / (beyond == 0).sum()))
    after = lowest(cost, lifts) + seen.taken_delay
    return after if after > 0 and left < (1 - LEAST_GAIN) * scatter and cost.min() < blow.min() else float("nan")


def responses(time: np.ndarray, corner_hz: float) -> np.ndarray:
    """What a second-order Butterworth low pass makes of a blow, a jump and a bend at time 0: (..., 3), without unit.

    With k = sqrt(2) pi f and a = k t: 2 exp(-a) sin a; its integral 1 - exp(-a) (cos a + sin a); and the integral of
    that, a - 1 + exp(-a) cos a.
    """
    a = np.sqrt(2) * np.pi * corner_hz * np.maximum(time, 0.0)
    decay = np.exp(-a)
    return np.stack([2 * decay * np.sin(a), 1 - decay * (np.cos(a) + np.sin(a)), a - 1 + decay * np.cos(a)], axis=-1)


def costs_of(
    time: np.ndarray, force: np.ndarray, beyond: np.ndarray, corner_hz: float, onsets: np.ndarray,
    kinds: tuple[int, ...],
) -> np.ndarray:
    """Cost (o,) of each onset: samples times the logarithm of the squares left by a straight line and the responses of
    these kinds, summed over the force's columns: twice the negative log-likelihood but for a constant.

    A clipped sample has no square if what is fitted lies beyond it (Tobin 1958, its noise being far below full scale).
    """
    line = np.broadcast_to(np.column_stack([np.ones(len(time)), time / WINDOW_S[1]]), (len(onsets), len(time), 2))
    columns = np.concatenate([line, responses(time - onsets[:, None], corner_hz)[..., list(kinds)]], axis=2)
    across, _ = np.linalg.qr(columns)
    shows, seen = np.broadcast_to(beyond == 0, (len(onsets), *force.shape)), None
    for _ in range(ROUNDS):
        if seen is not None and (shows == seen).all():
            break
        seen = shows
        normal = np.einsum("onc,onk,ond->okcd", across, seen, across) + UNKNOWN * np.eye(across.shape[2])
        sizes = np.linalg.solve(normal, np.einsum("onc,onk->okc", across, seen * force)[..., None])[..., 0]
        left = force - np.einsum("onc,okc->onk", across, sizes)
        shows = beyond * left >= 0
    squares = np.where(shows, left**2, 0.0).sum(axis=1)
    return np.asarray(((beyond == 0).sum(axis=0) * np.log(squares)).sum(axis=1))
