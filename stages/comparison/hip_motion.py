"""Difference of the hip's motion between the constraint model and the penalty model (figure 8)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.largest import largest_magnitudes, sampled_at
from stages.biped.quantity import quantity
from stages.biped.walk import Walk
from stages.comparison.stride import Stride


@dataclass(frozen=True)
class HipDifference:
    """Largest differences of hip position and velocity, multibody minus analytic, x and y."""

    position: np.ndarray = quantity("m", "largest hip position difference in x and y, shape (2,)")
    velocity: np.ndarray = quantity("m/s", "largest hip velocity difference in x and y, shape (2,)")


@dataclass(frozen=True)
class Overlay:
    """Two walks on their common times: differences, multibody minus analytic."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray


def overlay(analytic: Walk, multibody: Walk, duration: float) -> Overlay:
    """Difference of two walks from their common start over `duration` [s], on the analytic walk's samples."""
    end = min(duration, analytic.time[-1], multibody.time[-1])
    time = analytic.time[analytic.time <= end]
    count = len(time)

    def difference(name: str) -> np.ndarray:
        ours, theirs = getattr(analytic, name)[:count], getattr(multibody, name)
        return np.column_stack([np.interp(time, multibody.time, theirs[:, i]) - ours[:, i] for i in (0, 1)])

    return Overlay(time, difference("hip_position"), difference("hip_velocity"))


def farthest(analytic: Walk, multibody: Walk, duration: float) -> np.ndarray:
    """Largest distances of the hips in x and y [m], (2,), over `duration` [s] from the common start, with its end."""
    laid = overlay(analytic, multibody, duration)
    end = min(duration, analytic.time[-1], multibody.time[-1])
    events = [times for walk in (analytic, multibody) for times in (walk.heel_strike_time, walk.toe_off_time)]
    times = np.unique(np.append(laid.time, end))
    return largest_magnitudes(*sampled_at(laid.time, laid.position, np.concatenate(events), times))


def from_same_start(analytic: Walk, multibody: Walk, duration: float) -> HipDifference:
    """Largest differences over `duration` [s] when both start from the same mid-stance state.

    Velocities are compared at the samples, but for those between the heel strikes of the two models: there one has had
    its jump, not both.
    """
    laid = overlay(analytic, multibody, duration)
    apart = np.zeros(len(laid.time), dtype=bool)
    for pair in zip(analytic.heel_strike_time, multibody.heel_strike_time):
        apart |= (laid.time >= min(pair)) & (laid.time <= max(pair))
    return HipDifference(farthest(analytic, multibody, duration), np.abs(laid.velocity[~apart]).max(axis=0))


def between_cycles(analytic: Stride, multibody: Stride) -> HipDifference:
    """Largest differences of the settled cycles at equal phase."""
    position = np.abs(multibody.hip_position - analytic.hip_position)
    return HipDifference(position.max(axis=0), np.abs(multibody.hip_velocity - analytic.hip_velocity).max(axis=0))
