"""A fitted robot as `calibrate --into` leaves it for what follows the robot: robot.json, beside its parameter files.

It has what these cannot hold: how the parameters' errors go together, how runs differ, and how well the sensors fit.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.design import Biped
from stages.biped.question import WrongOption
from stages.calibration.estimation.run_fit import Model
from stages.calibration.observation.measured_run import Layout
from stages.ground.slope import Slope

NAME, KIND = "robot.json", "bipedstudy fitted robot 1"
#: What belongs to sensors that stay on the robot, and is known better after a fit: unknowns of a run.
OF_MOUNTING = ("foot_place", "bandwidth")
#: Two runs or more tell how a mounting differs between them; with fewer the fit's own error is taken so many times.
ONE_RUN = 2.0


@dataclass(frozen=True)
class FittedRobot:
    """A robot with the parameters `names` (d,) that all runs share, their `covariance` (d, d) and the spread (o,) of
    those that are each run's `own`. `mounting` (m, 2) has mean and standard error of `OF_MOUNTING`. Residuals were
    `sigmas` times the sensors' noise, and errors are `wider` for it. Heel strikes are found `late` [s] after the
    model's, on average, with a standard deviation `late_sd`. SI units."""

    design: DesignPoint
    names: tuple[str, ...]
    covariance: np.ndarray
    own: tuple[str, ...]
    own_sd: Vector
    mounting: np.ndarray
    sigmas: float
    wider: float
    late: float
    late_sd: float

    def content(self) -> bytes:
        """The file."""
        plain = {
            "kind": KIND,
            "biped": dataclasses.asdict(self.design.biped), "slope": dataclasses.asdict(self.design.slope),
            "parameters": list(self.names), "covariance": self.covariance.tolist(),
            "of_each_run": list(self.own), "of_each_run_sd": self.own_sd.tolist(),
            "mounting": dict(zip(OF_MOUNTING, self.mounting.tolist(), strict=True)),
            "residuals_in_sigmas": self.sigmas, "errors_widened": self.wider,
            "strikes_late_s": self.late, "strikes_late_sd_s": self.late_sd,
        }  # fmt: skip
        return json.dumps({**plain, "sha256": _digest(plain)}, indent=1, allow_nan=False).encode() + b"\n"

    def model(self, model: Model) -> Model:
        """A model that looks for this robot's parameters, with sensors that are mounted as they were."""
        prior, middle = model.layout.prior.copy(), model.layout.middle.copy()
        for name, (mean, sd) in zip(OF_MOUNTING, self.mounting, strict=True):
            middle[model.layout.place(name)], prior[model.layout.place(name)] = mean, sd
        layout: Layout = dataclasses.replace(model.layout, prior=prior, middle=middle)
        forward, up, rate = (self.wider * noise for noise in model.noise)
        return dataclasses.replace(model, shared=self.names, own=self.own, layout=layout, noise=(forward, up, rate))

    def of_design(self) -> np.ndarray:
        """Covariance (d + o, d + o) of the design's parameters, those of a run last."""
        d = len(self.names)
        whole = np.zeros((d + len(self.own),) * 2)
        whole[:d, :d] = self.covariance
        whole[range(d, len(whole)), range(d, len(whole))] = self.own_sd**2
        return whole


def mounted(unknowns: np.ndarray, variances: Sequence[np.ndarray], layout: Layout) -> np.ndarray:
    """Mean and standard error (m, 2) of the mounting in another run, of runs' unknowns (r, k) with variances (k,)."""
    rows = []
    for name in OF_MOUNTING:
        place = layout.place(name)
        values, own = unknowns[:, place], math.sqrt(float(np.mean([one[place] for one in variances])))
        spread = float(values.std(ddof=1)) if len(values) > 1 else 0.0
        rows.append([float(values.mean()), max(spread, own if len(values) > 1 else ONE_RUN * own)])
    return np.array(rows)


def read(folder: Path) -> FittedRobot:
    """The robot of a folder. Raises WrongOption where it has none or one that was changed."""
    path = folder / NAME
    try:
        plain = json.loads(path.read_text(encoding="utf-8"))
        said = plain.pop("sha256")
    except FileNotFoundError:
        raise WrongOption(f"as: {folder} has no {NAME}, which calibrate --into leaves; fit the robot again") from None
    except (OSError, ValueError, KeyError, AttributeError, TypeError):
        raise WrongOption(f"as: {path} is no fitted robot that calibrate --into left") from None
    if plain.get("kind") != KIND or said != _digest(plain):
        raise WrongOption(f"as: {path} was changed, or is of another version; fit the robot again")
    design = DesignPoint(Biped(**plain["biped"]), Slope(**plain["slope"]))
    return FittedRobot(
        design, tuple(plain["parameters"]), np.array(plain["covariance"]), tuple(plain["of_each_run"]),
        np.array(plain["of_each_run_sd"]), np.array([plain["mounting"][name] for name in OF_MOUNTING]),
        plain["residuals_in_sigmas"], plain["errors_widened"],
        plain["strikes_late_s"], plain["strikes_late_sd_s"])  # fmt: skip


def _digest(plain: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()
