"""When impacts begin, and when the other leg leaves the ground: finer than a sample, from all steps together.

Strikes that were laid over each other (heel_strikes.py) are each sampled at other phases, so their samples together
show the impact many times as finely as one does. What the force does there (a blow, a jump, a bend) is fitted behind
the second-order low pass of a sensor; where it begins is the event. The corner of the low pass is found as well, one
for both legs. Where it is declared, the samples' times are already less its delay, which is given back.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.imu.strikes.heel_strikes import lowest
from stages.imu.strikes.step_times import INNER, OUTER, HeelStrikes

WINDOW_S = (-0.04, 0.04)  # around a strike
ONSETS_S = np.arange(-0.02, 0.0121, 0.0005)
LIFTS_S = np.arange(-0.02, 0.0251, 0.0005)
CORNERS = np.arange(0.15, 0.5, 0.05)  # of the low pass, in sampling rates
FEWEST_SAMPLES = 12  # of a leg, together: twice what is fitted to a force, a line, three responses and an onset
LEAST_GAIN = 0.5  # of the scatter about a straight line, that what is fitted must explain
STRIKE, LIFT = (0, 1, 2), (1, 2)  # columns of `responses`: a strike is a blow as well


@dataclass(frozen=True)
class Samples:
    """Samples of a sensor: time (n,) [s] less `taken_delay` [s] for its low pass, force (n, k) [m/s^2], and their rate.

    NaN where a force is not known.
    """

    time: np.ndarray
    force: np.ndarray
    rate_hz: float
    taken_delay: float

    def around(self, strikes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Times (m,) from the strike of all samples around each strike, and forces (m, k)."""
        known = np.isfinite(self.force).all(axis=1)
        at, sensed = self.time[known], self.force[known]
        first, last = (np.searchsorted(at, strikes + edge) for edge in WINDOW_S)
        rows = [np.arange(a, b) for a, b in zip(first, last)]
        every = np.concatenate([np.empty(0, dtype=np.int64), *rows])
        return at[every] - np.repeat(strikes, last - first), sensed[every]


def at_onsets(strikes: HeelStrikes, seen: Samples, transient: int) -> tuple[HeelStrikes, float]:
    """The strikes, all of a leg moved alike to where its impacts begin, and the corner of the low pass [Hz].

    The first `transient` strikes differ from the others: they are moved with them, and not looked at. Strikes found by
    their pulse are late by much of a slow sensor's period, so a leg whose impacts are not seen well enough moves with
    the other. The corner is NaN if neither is seen.
    """
    time, leg_of = strikes.time[transient:], strikes.leg[transient:]
    clouds = {leg: seen.around(time[leg_of == leg]) for leg in (INNER, OUTER)}
    clouds = {leg: cloud for leg, cloud in clouds.items() if len(cloud[0]) >= FEWEST_SAMPLES}
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

    Its force is the foot's along the leg: what pressed the leg's slide together lets go when the ground does.
    """
    time, force = seen.around(strikes)
    if len(time) < FEWEST_SAMPLES or not np.isfinite(corner_hz):
        return float("nan")
    cost = costs_of(time, force, corner_hz, LIFTS_S, LIFT)
    line = np.polynomial.polynomial.polyfit(time, force, 1)
    scatter = float(((force - np.vander(time, 2, increasing=True) @ line) ** 2).sum())
    left = float(np.exp(cost.min() / len(time)))
    after = lowest(cost, LIFTS_S) + seen.taken_delay
    return after if after > 0 and left < (1 - LEAST_GAIN) * scatter else float("nan")


def responses(time: np.ndarray, corner_hz: float) -> np.ndarray:
    """What a second-order Butterworth low pass makes of a blow, a jump and a bend at time 0: (..., 3), without unit.

    With k = sqrt(2) pi f and a = k t: 2 exp(-a) sin a; its integral 1 - exp(-a) (cos a + sin a); and the integral of
    that, a - 1 + exp(-a) cos a.
    """
    a = np.sqrt(2) * np.pi * corner_hz * np.maximum(time, 0.0)
    decay = np.exp(-a)
    return np.stack([2 * decay * np.sin(a), 1 - decay * (np.cos(a) + np.sin(a)), a - 1 + decay * np.cos(a)], axis=-1)


def costs_of(
    time: np.ndarray, force: np.ndarray, corner_hz: float, onsets: np.ndarray, kinds: tuple[int, ...]
) -> np.ndarray:
    """Cost (o,) of each onset: samples times the logarithm of the squares left by a straight line and the responses of
    these kinds, summed over the force's columns: twice the negative log-likelihood but for a constant."""
    line = np.broadcast_to(np.column_stack([np.ones(len(time)), time / WINDOW_S[1]]), (len(onsets), len(time), 2))
    columns = np.concatenate([line, responses(time - onsets[:, None], corner_hz)[..., list(kinds)]], axis=2)
    across, _ = np.linalg.qr(columns)
    left = force - across @ (np.swapaxes(across, 1, 2) @ force)
    return np.asarray(len(time) * np.log((left**2).sum(axis=1)).sum(axis=1))
