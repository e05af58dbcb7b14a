"""A fitted robot as `calibrate --into` leaves it for what follows the robot: robot.json, beside its parameter files.

It has what these cannot hold: how the parameters' errors go together, how runs differ, how well the sensors fit, and
the runs' own samples, so that a fit goes on with more runs as it would have been with all of them.
"""

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, is_dataclass, replace
from pathlib import Path
from types import UnionType
from typing import Any, ClassVar, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from stages.analytic.gait.design_point import DesignPoint, parameter_names
from stages.analytic.model.walker import Vector
from stages.biped.quantity import Broken, broken, faults
from stages.biped.question import WrongOption, refuse
from stages.calibration.estimation.least_squares import Known
from stages.calibration.estimation.run_fit import Model
from stages.calibration.information.identifiability import first_model
from stages.calibration.observation.measured_run import (
    ERRORS,
    OF_RUN,
    SIDES,
    START,
    STRETCHES,
    Layout,
    MeasuredRun,
)
from stages.calibration.parameters import Parameters

NAME, KINDS = "robot.json", ("bipedstudy fitted robot 7", "bipedstudy fitted robot of angles 2")
#: What belongs to sensors that stay on the robot, and is known better after a fit: unknowns of a run.
OF_MOUNTING = ("foot_place", "bandwidth")
#: What the model does not explain shows in so many samples, of either sensor.
IN_A_ROW = 4
#: What JSON has of plain types.
PLAIN: Mapping[Any, Any] = {float: (int, float), Any: (int, float, str)}
#: By so much an eigenvalue of a covariance may be negative, of rounding, where its variances are one.
ROUNDED = 1e-6
R = TypeVar("R", bound="Kept")


class Kept:
    """A robot as a folder keeps it: a dataclass whose file is of one of the `KINDS`."""

    KIND: ClassVar[str]

    def content(self) -> bytes:
        """The file: JSON with its kind, one entry a line, and its digest."""
        plain = {"kind": self.KIND, **asdict(self)}  # type: ignore[call-overload]
        lines = (f"{json.dumps(key)}: {_text(value)}" for key, value in {**plain, "sha256": _digest(plain)}.items())
        return ("{\n" + ",\n".join(lines) + "\n}\n").encode()

    def broken_rules(self) -> Iterator[Broken]:
        """What no fit leaves."""
        return iter(())

    @classmethod
    def read(cls: type[R], folder: Path, option: str = "as") -> R:
        """The robot of a folder that an `option` names. Raises WrongOption where it has none of this kind, or one that
        was changed."""
        path = folder / NAME
        try:
            plain: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            said, found = plain.pop("sha256") == _digest(plain), plain.pop("kind", None)
        except FileNotFoundError:
            raise WrongOption(
                f"--{option}: {folder} has no {NAME}, which calibrate --into leaves; fit the robot again") from None
        except (OSError, ValueError, KeyError, AttributeError, TypeError):
            raise WrongOption(f"--{option}: {path} is no fitted robot that calibrate --into left") from None
        refuse((said and found in KINDS and found != cls.KIND,
                f"--{option}: the robot in {folder} was fitted to recordings of the other kind: angles go with a robot "
                "of angles, sensors at hip and foot with one of those"),
               (not said or found != cls.KIND,
                f"--{option}: {path} was changed, or is of another version; fit the robot again"))
        try:
            robot: R = restored(cls, plain)
            wrong = next(robot.broken_rules(), None)
        except (KeyError, TypeError, ValueError, AttributeError):
            raise WrongOption(
                f"--{option}: {path} has not the rows and values of a fitted robot; fit it again") from None
        refuse((wrong is not None, f"--{option}: {path}: {wrong and wrong.key} must be {wrong and wrong.allowed}"))
        return robot


@dataclass(frozen=True)
class Learned:
    """A run that a robot was fitted to, with its own parameters (o,) and unknowns (k,) there."""

    run: MeasuredRun
    own: Vector
    unknowns: Vector


@dataclass(frozen=True)
class FittedRobot(Kept):
    """A robot with the parameters `names` (d,) that all runs share, their `covariance` (d, d) and the spread (o,) of
    those that are each run's `own`. `mounting` (m, 2) has mean and standard error of `OF_MOUNTING`. Residuals were
    `sigmas` times the sensors' noise, `sigmas_sd` apart, and errors are `wider` for it. Heel strikes are found `late`
    [s] after the model's, on average, with a standard deviation `late_sd`.

    The `information` of `runs` runs by themselves is (d, d), with the sensors' noise as it is; with what was
    `known` beside them, the fit is the `estimate` (d,), in which the model's error still is. It `began` with a design;
    `of_parts`: with the bill of parts. In so many runs that were `compared`, parts look changed by `usual` amounts
    (mean, standard deviation between runs, its degrees of freedom), as the model lacks something. `learned` are the
    runs. All of `IN_A_ROW` samples are `unexplained` by mean squares of that somewhere in them, and an `innovation` is
    typically so large at most, in standard deviations. SI units."""

    KIND = KINDS[0]

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
    usual: Mapping[str, tuple[float, float, float]]
    began: DesignPoint
    learned: tuple[Learned, ...] = ()
    compared: int = 1
    unexplained: float = 0.0
    innovation: float = 1.0

    def broken_rules(self) -> Iterator[Broken]:
        """What no fit leaves: a design that cannot be, lists of other lengths, errors that are none."""
        d, o, design = len(self.names), len(self.own), self.design
        for key, point in (("design", design), ("began", self.began)):
            yield from (Broken(f"{key}: {wrong.key}", wrong.allowed) for part in (point.biped, point.slope)
                        for wrong in faults(part))  # fmt: skip
        yield from broken((not {*self.names, *self.own} <= {*parameter_names()}, "names", "numbers of the design"))
        start = len(START) - 2 * len(STRETCHES) * (design.biped.legs == "rigid")
        sizes = {"covariance": (d, d), "own_sd": (o,), "mounting": (len(OF_MOUNTING), 2), "information": (d, d),
                 "estimate": (d,)}  # fmt: skip
        arrays = [(key, getattr(self, key), size) for key, size in sizes.items()]
        for one in self.learned:
            each = [getattr(one.run, key)[side] for key in ("samples", "used") for side in SIDES]
            arrays += [("learned", array, (len(one.run.sampling.of(side)), 3))
                       for side, array in zip(2 * SIDES, each, strict=True)]  # fmt: skip
            unknown = start + len(OF_RUN) + len(SIDES) * len(ERRORS)
            arrays += [("learned", one.own, (o,)), ("learned", one.unknowns, (unknown,))]
        yield from broken(*((array.shape != size, key, f"numbers of the shape {size}") for key, array, size in arrays))
        sd = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        least = min(*sd, *self.own_sd, *self.mounting[:, 1], *(one.sd for one in self.known), self.sigmas, self.wider)
        yield from broken((least <= 0.0 or min(self.late_sd, self.sigmas_sd) < 0.0, "standard errors", "> 0"),
                          (min(self.runs, self.compared) < 1, "runs", "1 or more"))  # fmt: skip
        values = np.linalg.eigvalsh(self.covariance / np.outer(sd, sd))
        yield from broken((bool(values.min() < -ROUNDED), "covariance", "that of numbers"))

    def fitted_by(self, parameters: Parameters) -> Model:
        """The model that its runs were fitted by, about the design with which the fit began: about the one found, a run
        leaves other residuals than are kept. Raises NoGait."""
        return first_model(self.began, (*self.names, *self.own), parameters)

    def model(self, model: Model) -> Model:
        """A model that looks for this robot's parameters, with sensors that are mounted as they were."""
        return replace(mounted(model, self.mounting, self.wider), shared=self.names, own=self.own)

    def read_by(self, parameters: Parameters) -> Parameters:
        """The parameters that further runs are read by: what is null in them follows the design that the robot's own
        runs were read by, also where a study has the fitted one by now. Of the bill of parts that is the study's."""
        began = self.began
        return parameters if self.of_parts else replace(parameters, biped=began.biped, slope=began.slope)

    @property
    def uncorrected(self) -> DesignPoint:
        """The robot that fits its runs best, with the model's error."""
        return self.design.with_values(dict(zip(self.names, map(float, self.estimate), strict=True)))

    @property
    def unseen(self) -> float:
        """Standard error of the mean square of residuals, one where they are noise; zero without runs."""
        readings = sum(int(one.run.used[side].sum()) for one in self.learned for side in SIDES)
        return math.sqrt(2.0 / readings) if readings else 0.0

    def of_design(self) -> np.ndarray:
        """Covariance (d + o, d + o) of the design's parameters, those of a run last."""
        d = len(self.names)
        whole = np.zeros((d + len(self.own),) * 2)
        whole[:d, :d] = self.covariance
        whole[range(d, len(whole)), range(d, len(whole))] = self.own_sd**2
        return whole


def mounted(model: Model, mounting: np.ndarray, wider: float) -> Model:
    """A model whose sensors sit where they sat, (m, 2) means and standard errors of `OF_MOUNTING`, with noise that is
    so many times `wider`."""
    prior, middle = model.layout.prior.copy(), model.layout.middle.copy()
    for name, (mean, sd) in zip(OF_MOUNTING, mounting, strict=True):
        middle[model.layout.place(name)], prior[model.layout.place(name)] = mean, sd
    layout: Layout = replace(model.layout, prior=prior, middle=middle)
    forward, up, rate = (wider * noise for noise in model.noise)
    return replace(model, layout=layout, noise=(forward, up, rate))


def plain_of(value: Any) -> Any:
    """A dataclass, with all that is in it, as JSON gives it back; `restored` makes the value of it."""
    return json.loads(_text(asdict(value)))


def restored(kind: Any, plain: Any) -> Any:
    """The value of a type of which JSON has what is `plain`. Raises KeyError, TypeError, ValueError without one."""
    inner = get_args(kind)
    if isinstance(kind, type) and is_dataclass(kind):
        hints = get_type_hints(kind)
        return kind(**{name: restored(hints[name], value) for name, value in plain.items()})
    if np.ndarray in (kind, get_origin(kind)):
        array = np.array(plain)
        if array.dtype.kind not in "bif":
            raise ValueError("no numbers")
        return array
    if get_origin(kind) is UnionType:
        return None if plain is None else restored(inner[0], plain)
    if get_origin(kind) is tuple:
        kinds = inner[:1] * len(plain) if ... in inner else inner
        return tuple(restored(one, value) for one, value in zip(kinds, plain, strict=True))
    if get_origin(kind) is Mapping:
        return {name: restored(inner[1], value) for name, value in plain.items()}
    if not isinstance(plain, PLAIN.get(kind, kind)) or isinstance(plain, bool) != (kind is bool):
        raise TypeError("no such value")
    return plain


def _text(value: Any) -> str:
    return json.dumps(value, allow_nan=False, default=np.ndarray.tolist)


def _digest(plain: Mapping[str, Any]) -> str:
    return hashlib.sha256(_text(plain).encode()).hexdigest()
