"""What is not known of a run and of its sensors beside the design, with what is believed before a fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.analytic.model.walker import Vector, Walker

#: Section coordinates by their names, and the entries of the SI state's scales that they go by.
START = {3: (("start_theta", 0), ("start_theta_rate", 2), ("start_psi_rate", 3)),
         5: (("start_theta", 0), ("start_L_1", 1), ("start_L_2", 3), ("start_theta_rate", 4), ("start_L_1_rate", 5))}
SIDES = ("hip", "foot")
#: Of each sensor, in this order.
ERRORS = ("clock", "tilt", "forward_gain", "up_gain", "rate_gain", "forward_bias", "up_bias", "rate_bias")
UNITS = {"clock": "1", "tilt": "rad", "forward_gain": "1", "up_gain": "1", "rate_gain": "1", "forward_bias": "m/s^2",
         "up_bias": "m/s^2", "rate_bias": "rad/s"}


@dataclass(frozen=True)
class Beliefs:
    """Standard deviations of a sensor's errors before the fit, about zero; infinite for one that nothing is known of.

    `clock` relative error of the sampling rate; `tilt` [rad] of the mounting in the plane of walking; gains relative;
    biases [m/s^2] and [rad/s]; `foot_lag` [s] what the foot's times are off against the hip's; `strike` [s] the time of
    the first heel strike. Legs are `length` [m] and `length_rate` [m/s] from the gait's just after it: springs forget
    them before the first sample that counts.
    """

    clock: float
    tilt: float
    acceleration_gain: float
    rate_gain: float
    acceleration_bias: float
    rate_bias: float
    foot_lag: float
    strike: float
    length: float
    length_rate: float

    def of(self, error: str) -> float:
        """That of one of `ERRORS`."""
        kinds = {"forward_gain": self.acceleration_gain, "up_gain": self.acceleration_gain,
                 "forward_bias": self.acceleration_bias, "up_bias": self.acceleration_bias}
        return kinds[error] if error in kinds else float(getattr(self, error))


@dataclass(frozen=True)
class Layout:
    """Names, units and beliefs (standard deviations about `middle`) of a run's unknowns, in order, shape (k,) each.

    `sizes` (k,): changes that are neither large nor small, for numerics. The first `free` are the start's.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    middle: Vector
    believed: Vector
    sizes: Vector
    free: int

    def place(self, name: str) -> int:
        """Where an unknown stands. Raises ValueError."""
        return self.names.index(name)


def layout_of(walker: Walker, z: Vector, beliefs: Beliefs) -> Layout:
    """The unknowns of a run of a walker whose gait has the section coordinates `z` (j,)."""
    scales, free = walker.scales(), len(z)
    names, units, believed, sizes = [], [], [], []
    for name, entry in START[free]:
        names.append(name)
        units.append(_unit(name))
        of_leg = beliefs.length_rate if name.endswith("rate") else beliefs.length
        believed.append(of_leg if "_L_" in name else np.inf)
        sizes.append(0.01 * scales[entry])
    for name, sd in (("time_offset", beliefs.strike), ("foot_lag", beliefs.foot_lag)):
        names.append(name)
        units.append("s")
        believed.append(sd)
        sizes.append(1e-3)
    usual = {"clock": 1e-3, "tilt": 0.01, "forward_bias": 0.05, "up_bias": 0.05, "rate_bias": 0.01}
    for side in SIDES:
        for error in ERRORS:
            names.append(f"{side}_{error}")
            units.append(UNITS[error])
            believed.append(beliefs.of(error))
            sizes.append(usual.get(error, 0.01))
    middle = np.zeros(len(names))
    middle[:free] = z * start_scales(walker, free)
    return Layout(tuple(names), tuple(units), middle, np.array(believed), np.array(sizes), free)


def start_scales(walker: Walker, free: int) -> Vector:
    """SI value of one dimensionless unit of each section coordinate, (free,)."""
    scales = walker.scales()
    return np.array([scales[entry] for _, entry in START[free]])


def _unit(name: str) -> str:
    if "theta" in name or "psi" in name:
        return "rad/s" if name.endswith("rate") else "rad"
    return "m/s" if name.endswith("rate") else "m"
