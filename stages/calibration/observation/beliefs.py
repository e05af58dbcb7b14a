"""What is believed of a run and its sensors before a fit: quick to import, as parameters say it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Beliefs:
    """Standard deviations of a sensor's errors before the fit, about zero; infinite for one that nothing is known of.

    `clock` relative error of the sampling rate; `tilt` [rad] of the mounting in the plane of walking; gains relative;
    biases [m/s^2] and [rad/s]; `foot_lag` [s] what the foot's times are off against the hip's; `mid_stance` [s] the
    time from the first heel strike to mid-stance. There legs are stretched by `length` [m] and at `length_rate` [m/s]
    otherwise than in the gait. `place` [m]: of the foot sensor along the leg; `bandwidth` relative.
    """

    clock: float
    tilt: float
    acceleration_gain: float
    rate_gain: float
    acceleration_bias: float
    rate_bias: float
    foot_lag: float
    mid_stance: float
    length: float
    length_rate: float
    place: float
    bandwidth: float

    def of(self, error: str) -> float:
        """That of one of the sensor errors (`unknowns.ERRORS`)."""
        kinds = {"forward_gain": self.acceleration_gain, "up_gain": self.acceleration_gain,
                 "forward_bias": self.acceleration_bias, "up_bias": self.acceleration_bias}
        return kinds[error] if error in kinds else float(getattr(self, error))
