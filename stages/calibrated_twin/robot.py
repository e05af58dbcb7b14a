"""The Exudyn twin as a robot whose numbers and start are given: what its sensors would show of a run."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import gait_near
from stages.analytic.model.walker import Vector
from stages.biped.between_steps import uniform_times
from stages.biped.walk import StanceState, Walk
from stages.calibration.information.identifiability import FINE
from stages.calibration.observation.measured_run import (
    SIDES,
    STRETCHES,
    Layout,
    MeasuredRun,
    layout_of,
    usable,
)
from stages.calibration.observation.prediction import as_sensed, sample_times
from stages.calibration.parameters import Settings
from stages.campaign.virtual_sensor import low_pass
from stages.ground.contact_law import ContactLaw
from stages.imu.trial.body import FORWARD, LATERAL, UP
from stages.planar.signals import IMU
from stages.twin.machine.machine import Machine
from stages.twin.machine.projection import with_numbers_of
from stages.twin.parameters import IMU_IN_SPACE, Settings as TwinSettings
from stages.twin.walking.record import Record, sample
from stages.twin.walking.simulate import rolling_start, simulate_twin


@dataclass(frozen=True)
class TwinRobot:
    """A machine whose numbers are replaced by those of a design; `rate_hz` of the motion behind the sensors."""

    machine: Machine
    contact: ContactLaw
    twin: TwinSettings
    settings: Settings
    layout: Layout
    rate_hz: float

    def run(self, design: DesignPoint, unknowns: Vector, like: MeasuredRun) -> MeasuredRun:
        """The run that the twin makes of a design and a run's unknowns, sampled when the run `like` was.

        Raises StepFailed where the twin falls, or where it stands on the leg without sensors at first.
        """
        if like.sampling.first_leg != 0:
            raise StepFailed("the twin begins on the leg with the sensors")
        value = dict(zip(self.layout.names, unknowns, strict=True))
        record = self.walk(design, unknowns, len(like.strikes))
        twin = replace(self.twin, signals=(IMU_IN_SPACE,))
        sensed = sample(record, uniform_times(float(record.time[-1]), self.rate_hz), twin)
        began = value["mid_stance"]
        strikes = np.concatenate([[0.0], began + sensed.walk.heel_strike_time])
        motion = {"hip": (sensed.hip_imu_specific_force, sensed.hip_imu_angular_velocity),
                  "foot": (sensed.foot_imu_specific_force, sensed.foot_imu_angular_velocity)}
        taken, samples, used = sample_times(value, like.sampling), {}, {}
        for side in SIDES:
            force, rate = motion[side]
            smooth = low_pass(np.column_stack([force[:, FORWARD], force[:, UP], rate[:, LATERAL]]), self.rate_hz,
                              like.sampling.bandwidth_hz[side] * math.exp(value["bandwidth"]))
            if taken[side][-1] > sensed.walk.time[-1]:
                raise StepFailed("the twin does not get to the run's end")
            true = np.column_stack([np.interp(taken[side], sensed.walk.time, column) for column in smooth.T])
            samples[side] = as_sensed(true, value, side)
            used[side] = usable(like.sampling.of(side), strikes, began + self.settings.settling_s,
                                self.settings.before_strike_s, self.settings.after_strike_s)
        return replace(like, samples=samples, used=used, strikes=strikes[: len(like.strikes)])

    def walk(self, design: DesignPoint, unknowns: Vector, steps: int) -> Record:
        """The twin's walk from the mid-stance that `unknowns` begin with. Raises StepFailed."""
        value = dict(zip(self.layout.names, unknowns, strict=True))
        biped = design.biped
        first, rigid = biped.leg(0), biped.legs == "rigid"
        stretches, rates = (
            [0.0 if rigid else value[name + ending] for name in STRETCHES] for ending in ("", "_rate"))
        begin = StanceState(
            stance_angle=0.0, stance_length=first.leg_length + stretches[0],
            swing_angle=value["start_psi"], swing_length=biped.leg_lengths[1] + stretches[1],
            stance_rate=value["start_theta_rate"], stance_length_rate=rates[0],
            swing_rate=value["start_psi_rate"], swing_length_rate=rates[1])  # fmt: skip
        machine = with_numbers_of(self.machine, biped)
        pressed = (biped.total_mass * design.slope.gravity if rigid else
                   -first.stiffness * stretches[0] - first.damping * rates[0])  # fmt: skip
        start = rolling_start(machine, self.contact, begin, pressed)
        record = simulate_twin(machine, design.slope, self.contact, start, self.twin, steps=steps)
        if not record.completed:
            raise StepFailed(f"the twin does not walk to the end: {record.reason}")
        return record

    def settled(self, design: DesignPoint, near: Vector, steps: int, priors: Mapping[str, float]) -> Walk:
        """A walk of the twin begun at the mid-stance of the design's gait, as its sensors at hip and feet measure it.

        `near` are section coordinates of the gait of a similar design. Raises NoGait, StepFailed.
        """
        walker, point = gait_near(design, near, FINE)
        start = layout_of(walker, point.z, FINE, priors).middle
        record = self.walk(design, start, steps)
        times = uniform_times(float(record.time[-1]), self.twin.sampling_rate_hz)
        return sample(record, times, replace(self.twin, signals=(IMU,))).walk
