"""What the sensors would feel at heel strike on other ground: the spike belongs to the contact set, not to the gait."""

from __future__ import annotations

import dataclasses

import numpy as np

from stages.biped.accuracy.scales import scales_of
from stages.biped.gait import StanceState
from stages.biped.sampling_times import refined_times
from stages.campaign.parameters import Parameters
from stages.campaign.result import SetSpike
from stages.campaign.virtual_sensor import STANDARD_GRAVITY
from stages.ground.hardening import family_member
from stages.planar.signals import IMU
from stages.twin.machine.machine import build
from stages.twin.walking.events import find_events
from stages.twin.walking.signals import sample
from stages.twin.walking.simulate import rolling_start, simulate_twin

#: Members of the contact set's family towards the rigid limit, the softest first; share 1 is the set itself.
SHARES = (4.0, 2.0, 1.0, 0.5)
#: Heel strikes of each walk; the steps between them are looked at.
STRIKES = 3


def spikes(state: StanceState, normal_force: float, parameters: Parameters) -> tuple[SetSpike, ...]:
    """A short walk from the same mid-stance on each member of the family."""
    return tuple(spike(share, state, normal_force, parameters) for share in SHARES)


def spike(share: float, state: StanceState, normal_force: float, parameters: Parameters) -> SetSpike:
    """Peaks and time above range on one member."""
    law = family_member(parameters.contact, share)
    settings = parameters.twin.with_tolerance(parameters.runs.solver_tolerance)
    settings = dataclasses.replace(settings, signals=(IMU,))
    machine = build(parameters.biped, settings)
    start = rolling_start(machine, law, state, normal_force)
    record = simulate_twin(machine, parameters.slope, law, start, settings, steps=STRIKES)
    strikes = find_events(record).heel_strike_time
    if not record.completed or len(strikes) < STRIKES:
        return SetSpike(share, law.contact_stiffness, float("nan"), float("nan"), float("nan"))
    pendulum_time = scales_of(parameters.biped, parameters.slope.gravity).time
    time = refined_times(float(record.time[-1]), settings.sampling_rate_hz, strikes, pendulum_time)
    walk = sample(record, time, settings).walk
    inside = (time >= strikes[0]) & (time <= strikes[-1])
    hip, foot = (
        np.abs(force[inside]).max(axis=1) for force in (walk.hip_specific_force, walk.foot_specific_force)
    )
    above = np.maximum(hip, foot) > parameters.sensor.accelerometer_range_g * STANDARD_GRAVITY
    return SetSpike(
        share=share,
        contact_stiffness=law.contact_stiffness,
        hip_peak=float(hip.max()),
        foot_peak=float(foot.max()),
        time_above_range=float(np.trapezoid(above.astype(float), time[inside])) / (len(strikes) - 1),
    )
