"""Difference of the hip's motion between the constraint model and the penalty model (figure 8)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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


def largest(position: np.ndarray, velocity: np.ndarray) -> HipDifference:
    """Largest magnitudes of differences (n, 2)."""
    return HipDifference(np.abs(position).max(axis=0), np.abs(velocity).max(axis=0))


def from_same_start(analytic: Walk, multibody: Walk, duration: float) -> HipDifference:
    """Largest differences over `duration` [s] when both start from the same mid-stance state.

    Velocities are not compared between the heel strikes of the two models: there one has had its jump, not both.
    """
    laid = overlay(analytic, multibody, duration)
    apart = np.zeros(len(laid.time), dtype=bool)
    for pair in zip(analytic.heel_strike_time, multibody.heel_strike_time):
        apart |= (laid.time >= min(pair)) & (laid.time <= max(pair))
    return largest(laid.position, laid.velocity[~apart])


def between_cycles(analytic: Stride, multibody: Stride) -> HipDifference:
    """Largest differences of the settled cycles at equal phase."""
    return largest(multibody.hip_position - analytic.hip_position, multibody.hip_velocity - analytic.hip_velocity)
