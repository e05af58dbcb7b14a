"""A run that was fitted, followed with the robot that it showed: what was known, beside the truth where that is known.
"""

from __future__ import annotations

import contextlib
import math

import numpy as np
from scipy.linalg import block_diag

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.calibration.estimation.run_fit import Model
from stages.calibration.following.follower import Follower
from stages.calibration.following.present import Instant
from stages.calibration.following.robot_file import OF_MOUNTING, mounted
from stages.calibration.following.track import follow, forecasts, lateness
from stages.calibration.observation.measured_run import MeasuredRun
from stages.calibration.parameters import Settings
from stages.calibration.recordings import FROM
from stages.calibration.result import FittedRun, Followed
from stages.campaign.result import RunTruth

#: What each run has of its own may be so far from what was fitted, in shares of it; and the sensors' mounting, with the
#: bandwidth's logarithm.
OWN, MOUNTED = 1e-3, (1e-4, 0.01)


def followed(
    design: DesignPoint, run: MeasuredRun, fit: FittedRun, model: Model, settings: Settings, truth: RunTruth | None
) -> Followed | None:
    """What was known after each sample of the hip; None where the robot cannot be followed."""
    mounting = np.array([(fit.unknowns[model.layout.place(name)], sd)
                         for name, sd in zip(OF_MOUNTING, MOUNTED, strict=True)])  # fmt: skip
    follower = Follower.of(
        model.robot(design, fit.design, fit.own), mounted(model, mounting, fit.wider),
        block_diag(fit.covariance, np.diag(np.square(OWN * fit.own))), fit.wider, settings)
    instants = list[Instant]()
    with contextlib.suppress(StepFailed):  # as far as it goes
        instants.extend(follow(follower, run))
    if not instants:
        return None
    entry = [0 if one.leg == 0 else len(one.state) // 4 for one in instants]  # theta, or psi of the leg that swings
    sign = np.where(np.array(entry) == 0, -1.0, 1.0)
    angle = sign * [one.state[place] for one, place in zip(instants, entry, strict=True)]
    error = [math.sqrt(one.covariance[place, place]) for one, place in zip(instants, entry, strict=True)]
    late, late_sd = lateness(forecasts(instants, run.strikes)[:, None])  # of one more strike of this run
    true_time, true_angle = np.zeros(0), np.zeros(0)
    if truth is not None:
        strikes = truth.heel_strike_time[FROM : FROM + len(run.strikes)]
        began = float(np.mean(strikes - run.strikes[: len(strikes)]))
        seen = (truth.leg.time > began + instants[0].time) & (truth.leg.time < began + instants[-1].time)
        true_time, true_angle = truth.leg.time[seen] - began, truth.leg.angle[seen]
    return Followed(
        fit.name, np.array([one.time for one in instants]), np.asarray(angle), np.array(error),
        np.array([one.strike for one in instants]) + late,
        np.hypot([one.strike_sd for one in instants], late_sd),
        np.array([one.step for one in instants]), run.strikes, true_time, true_angle)  # fmt: skip
