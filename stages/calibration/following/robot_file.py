"""A fitted robot as `calibrate --into` leaves it for what follows the robot: robot.json, beside its parameter files.

It has what these cannot hold: how the parameters' errors go together, how runs differ, how well the sensors fit, and
the runs' own samples, so that a fit goes on with more runs as it would have been with all of them.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.design import Biped
from stages.biped.question import WrongOption
from stages.calibration.estimation.campaign import as_plain, from_plain
from stages.calibration.estimation.least_squares import Known
from stages.calibration.estimation.run_fit import Model
from stages.calibration.observation.measured_run import Layout, MeasuredRun
from stages.ground.slope import Slope

NAME, KIND, OF_ANGLES = "robot.json", "bipedstudy fitted robot 3", "bipedstudy fitted robot of angles 1"
#: What belongs to sensors that stay on the robot, and is known better after a fit: unknowns of a run.
OF_MOUNTING = ("foot_place", "bandwidth")


@dataclass(frozen=True)
class Learned:
    """A run that a robot was fitted to: its own parameters (o,) and unknowns (k,) there, and by how much parts look
    changed in it, with the standard errors, (c, 2); (0, 2) where the robot does not walk it."""

    run: MeasuredRun
    own: Vector
    unknowns: Vector
    shifts: np.ndarray


@dataclass(frozen=True)
class FittedRobot:
    """A robot with the parameters `names` (d,) that all runs share, their `covariance` (d, d) and the spread (o,) of
    those that are each run's `own`. `mounting` (m, 2) has mean and standard error of `OF_MOUNTING`. Residuals were
    `sigmas` times the sensors' noise, `sigmas_sd` apart, and errors are `wider` for it. Heel strikes are found `late`
    [s] after the model's, on average, with a standard deviation `late_sd`.

    What `runs` runs told by themselves is the `information` (d, d), with the sensors' noise as it is; with what was
    `known` beside them, the fit is the `estimate` (d,), in which the model's error still is. It `began` with a design;
    `of_parts`: with the bill of parts. Parts look changed in the runs by `usual` amounts (mean, standard deviation
    between runs), as the model lacks something. `learned` are the runs. SI units."""

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
    information: np.ndarray
    estimate: Vector
    known: tuple[Known, ...]
    runs: int
    sigmas_sd: float
    of_parts: bool
    usual: Mapping[str, tuple[float, float]]
    began: DesignPoint
    learned: tuple[Learned, ...] = ()

    def content(self) -> bytes:
        """The file."""
        plain = {
            "kind": KIND,
            **_plain(self.design), "began_with": _plain(self.began),
            "parameters": list(self.names), "covariance": self.covariance.tolist(),
            "of_each_run": list(self.own), "of_each_run_sd": self.own_sd.tolist(),
            "mounting": dict(zip(OF_MOUNTING, self.mounting.tolist(), strict=True)),
            "residuals_in_sigmas": self.sigmas, "errors_widened": self.wider,
            "strikes_late_s": self.late, "strikes_late_sd_s": self.late_sd,
            "information": self.information.tolist(), "estimate": self.estimate.tolist(), "runs": self.runs,
            "known": [[one.name, one.value, one.sd, one.source] for one in self.known],
            "residuals_sd": self.sigmas_sd, "of_parts": self.of_parts,
            "usual_changes": {name: list(each) for name, each in self.usual.items()},
            "learned": [{"run": as_plain(one.run), "own": one.own.tolist(), "unknowns": one.unknowns.tolist(),
                         "shifts": one.shifts.tolist()} for one in self.learned],
        }  # fmt: skip
        return signed_content(plain)

    def model(self, model: Model) -> Model:
        """A model that looks for this robot's parameters, with sensors that are mounted as they were."""
        prior, middle = model.layout.prior.copy(), model.layout.middle.copy()
        for name, (mean, sd) in zip(OF_MOUNTING, self.mounting, strict=True):
            middle[model.layout.place(name)], prior[model.layout.place(name)] = mean, sd
        layout: Layout = dataclasses.replace(model.layout, prior=prior, middle=middle)
        forward, up, rate = (self.wider * noise for noise in model.noise)
        return dataclasses.replace(model, shared=self.names, own=self.own, layout=layout, noise=(forward, up, rate))

    @property
    def uncorrected(self) -> DesignPoint:
        """The robot that fits its runs best, with the model's error."""
        return self.design.with_values(dict(zip(self.names, map(float, self.estimate), strict=True)))

    def of_design(self) -> np.ndarray:
        """Covariance (d + o, d + o) of the design's parameters, those of a run last."""
        d = len(self.names)
        whole = np.zeros((d + len(self.own),) * 2)
        whole[:d, :d] = self.covariance
        whole[range(d, len(whole)), range(d, len(whole))] = self.own_sd**2
        return whole


def signed_content(plain: Mapping[str, Any]) -> bytes:
    """A file of JSON, one entry a line, with its digest."""
    lines = (f"{json.dumps(key)}: {json.dumps(value, allow_nan=False)}"
             for key, value in {**plain, "sha256": _digest(plain)}.items())  # fmt: skip
    return ("{\n" + ",\n".join(lines) + "\n}\n").encode()


def signed(folder: Path, option: str, kind: str) -> dict[str, Any]:
    """What a folder's file has, which an `option` names. Raises WrongOption where there is none of this `kind`, or one
    that was changed."""
    path = folder / NAME
    try:
        plain: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        said = plain.pop("sha256")
    except FileNotFoundError:
        raise WrongOption(
            f"{option}: {folder} has no {NAME}, which calibrate --into leaves; fit the robot again") from None
    except (OSError, ValueError, KeyError, AttributeError, TypeError):
        raise WrongOption(f"{option}: {path} is no fitted robot that calibrate --into left") from None
    if said == _digest(plain) and plain.get("kind") in (KIND, OF_ANGLES) and plain["kind"] != kind:
        raise WrongOption(f"{option}: the robot in {folder} was fitted to recordings of the other kind: angles go with "
                          "a robot of angles, sensors at hip and foot with one of those")  # fmt: skip
    if plain.get("kind") != kind or said != _digest(plain):
        raise WrongOption(f"{option}: {path} was changed, or is of another version; fit the robot again")
    return plain


def read(folder: Path, option: str = "as") -> FittedRobot:
    """The robot of a folder that an `option` names. Raises WrongOption where it has none or one that was changed."""
    plain = signed(folder, option, KIND)
    return FittedRobot(
        _design(plain), tuple(plain["parameters"]), np.array(plain["covariance"]), tuple(plain["of_each_run"]),
        np.array(plain["of_each_run_sd"]), np.array([plain["mounting"][name] for name in OF_MOUNTING]),
        plain["residuals_in_sigmas"], plain["errors_widened"],
        plain["strikes_late_s"], plain["strikes_late_sd_s"], np.array(plain["information"]),
        np.array(plain["estimate"]), tuple(Known(*one) for one in plain["known"]),
        plain["runs"], plain["residuals_sd"], plain["of_parts"],
        {name: (each[0], each[1]) for name, each in plain["usual_changes"].items()}, _design(plain["began_with"]),
        tuple(Learned(from_plain(one["run"]), np.array(one["own"]), np.array(one["unknowns"]),
                      np.array(one["shifts"]).reshape(-1, 2)) for one in plain["learned"]))  # fmt: skip


def _plain(design: DesignPoint) -> dict[str, Any]:
    return {"biped": dataclasses.asdict(design.biped), "slope": dataclasses.asdict(design.slope)}


def _design(plain: Mapping[str, Any]) -> DesignPoint:
    return DesignPoint(Biped(**plain["biped"]), Slope(**plain["slope"]))


def _digest(plain: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()
