"""Gaits and walks of a design, by the constraint model."""

from __future__ import annotations

from pathlib import Path

from bipedstudy.results import Setting, parameters
from stages.analytic.gait.gait_report import GaitReport, report_gait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.biped.walk import Walk


def gait(*settings: Setting, study: str | Path | None = None) -> GaitReport:
    """The most stable gait of a design: its measures, energy audit and what it asks of the ground, in SI units.

        >>> import bipedstudy as bs
        >>> round(bs.gait("biped.hip_mass=0.4").gait.step_frequency_hz, 4)
        1.9997

    `settings` are changes of parameters as `--set` takes them, or {"biped.hip_mass": 0.4}. Raises `StudyError` for a
    value that is not allowed, `NoGait` if the design has none.
    """
    own = parameters("analytic", *settings, study=study)
    walker, point = find_gait(own.biped, own.slope, own.settings.tolerance, own.limited_friction)
    return report_gait(walker, point, own.settings.tolerance, own.friction.static_friction)


def walk(*settings: Setting, steps: int | None = None, study: str | Path | None = None) -> Walk:
    """A walk of a design in its most stable gait, from mid-stance: hip, legs, ground reaction, sensors over time.

        >>> import bipedstudy as bs
        >>> bs.walk(steps=2).hip_position.shape[1]
        2

    `settings` as for `gait`; `steps` (default: analytic.steps) is how many steps are walked.
    """
    if steps is not None:
        settings = (*settings, f"analytic.steps={steps}")
    own = parameters("analytic", *settings, study=study)
    tolerance = own.settings.tolerance
    walker, point = find_gait(own.biped, own.slope, tolerance, own.limited_friction)
    return walk_from_mid_stance(walker, point.z, own.settings.steps, tolerance, own.settings.sampling_rate_hz)[0]
