"""A stand-in for the twin: planar leg kinematics with known steps, sent through the synthetic sensor and radio."""

import dataclasses
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.stats import norm

from pipeline.study import locate
from stages.campaign import run as campaign
from stages.campaign.parameters import RadioSettings, SensorSettings
from stages.campaign.result import LegTruth, RunTruth
from stages.campaign.run import database_bytes, sensed_run
from stages.campaign.twin_run import TwinRun, Variation, joined, rolling_leg, stand_and_push
from stages.campaign.virtual_sensor import SensorMotion, Transmitted
from stages.imu.parameters import Settings
from stages.imu.result import Result
from stages.imu.run import collect, trials
from stages.imu.sources.databases import SqliteSource
from stages.imu.sources.schema import Device, Experiment
from stages.twin.machine.machine import Build
from tests.study import ROOT, SLOPE, TABLE_1

GRID, PUSH_S, REBOUND_S = 1 / 5000, 0.4, 0.06
SENSOR = SensorSettings(100.0, 2000.0, 40.0, 4.0, 2000.0, 16, 2.0, 0.005, 0.005, 0.02, 0.5, 1.77e-3, 0.007)
RADIO = RadioSettings(3, 65536, 0.0, 0.008, 0.015, 0.02, 0.2, 0.01, 0.25)
ROUGH_RADIO = dataclasses.replace(RADIO, stall_share=0.10, loss_share=0.05)
EVERY = locate(start=ROOT).parameters(("imu", "campaign"))
STUDY = EVERY["imu"]
LIMITS = STUDY.limits
SETTINGS = Settings(None, 9.81, 0.0, 0.5, 3.0, 0.3, 200.0, 1.5, 3, 6, 101, 0.8, 4.0, 0.05, 0.005, 0.3)

#: The stand-in has no outsole.
DRAWING = dataclasses.replace(STUDY.drawing, leg_length=TABLE_1.leg_length, foot_radius=TABLE_1.foot_radius, sag=0.0)
PARAMETERS = dataclasses.replace(STUDY, settings=SETTINGS, drawing=DRAWING)

#: The study's campaign with this robot, and these sensors and radio.
CAMPAIGN = dataclasses.replace(EVERY["campaign"], biped=TABLE_1, slope=SLOPE, given_sensor=SENSOR, radio=RADIO)


def result_of(path: Path) -> Result:
    """What the ingest makes of a database of the stand-in."""
    with SqliteSource(path) as source:
        return collect(trials(source.runs(), PARAMETERS))


def device(place: str, sensor: SensorSettings = SENSOR) -> Device:
    return campaign.device(place, dataclasses.replace(CAMPAIGN, given_sensor=sensor))


def walking(
    steps: int, period: float, amplitude: float = 0.24
) -> tuple[SensorMotion, SensorMotion, np.ndarray, LegTruth]:
    """Inner leg standing and swinging in turn from mid-stance at t = 0; strikes (s,), the outer leg's first.

    The other leg leaves the ground when one lands.
    """
    strikes = (np.arange(steps) + 0.5) * period
    time = np.arange(0, strikes[-1] + 0.4 * period, GRID)
    wide = np.arange(-200, len(time) + 200) * GRID
    number = np.floor(wide / period + 0.5).astype(int)
    phase = wide / period + 0.5 - number
    theta = amplitude * (2 * phase - 1 + 0.16 * np.sin(2 * np.pi * phase))  # standing leg, hip ahead positive
    psi = amplitude * (2 * phase - 1 - 0.28 * np.sin(2 * np.pi * phase))  # swinging leg, foot ahead positive
    phi = gaussian_filter1d(np.where(number % 2 == 0, -theta, psi), 0.0015 / GRID)
    r, length = TABLE_1.foot_radius, TABLE_1.leg_length
    step = 2 * (r * amplitude + (length - r) * np.sin(amplitude))
    x = number * step + r * theta + (length - r) * np.sin(theta)
    y = r + (length - r) * np.cos(theta)
    hip = gaussian_filter1d(np.stack([x, y], axis=1), 0.0015 / GRID, axis=0)
    foot = hip + (length - TABLE_1.foot_com) * np.stack([np.sin(phi), -np.cos(phi)], axis=1)
    forward, up = np.stack([np.cos(phi), np.sin(phi)], axis=1), np.stack([-np.sin(phi), np.cos(phi)], axis=1)
    rate = np.gradient(phi, GRID)
    inside = slice(200, 200 + len(time))

    def felt(position: np.ndarray) -> SensorMotion:
        force = np.gradient(np.gradient(position, GRID, axis=0), GRID, axis=0) - np.array(SLOPE.gravity_vector)
        zero = np.zeros(len(rate))
        on_body = np.stack([(force * forward).sum(axis=1), (force * up).sum(axis=1), zero], axis=1)
        turning = np.stack([zero, zero, rate], axis=1)
        return SensorMotion(time, on_body[inside], turning[inside])

    at_strikes = np.column_stack([np.interp(strikes, time, axis[inside]) for axis in hip.T])
    off = np.arange(steps) % 2
    return felt(hip), felt(foot), strikes, LegTruth(time, phi[inside], at_strikes, strikes, off)


def walked(steps: int, period: float, rest_s: float, variation: Variation) -> TwinRun:
    """Such a walk with a still stand and a push before it."""
    hip, foot, strikes, leg = walking(steps, period)
    rate = hip.angular_velocity[:, 2]
    time, pushed = stand_and_push(0.0, (0.0, rate[0], (rate[1] - rate[0]) / GRID), rest_s, PUSH_S, GRID)
    before = rolling_leg(tuple(pushed), TABLE_1, SLOPE, time)
    legs = (np.arange(steps) + 1) % 2
    return TwinRun(joined(before[0], hip), joined(before[1], foot), strikes, legs, leg, variation, 1)


#: An experiment, what really happened in it, and what was sent of it.
Run = tuple[Experiment, RunTruth, tuple[Transmitted, ...]]


def struck(motion: SensorMotion, strikes: np.ndarray, change: float) -> SensorMotion:
    """With blows of a millisecond along the leg that change its speed at each strike [m/s], and once more, by four
    fifths of it, when the leg has rebounded."""
    since = motion.time[:, None] - strikes
    blows = (norm.pdf(since, 0.0, 1e-3) + 0.8 * norm.pdf(since, REBOUND_S, 1e-3)).sum(axis=1, keepdims=True)
    return dataclasses.replace(motion, specific_force=motion.specific_force + change * blows * [0.3, 1.0, 0.0])


def make_run(
    seed: int, radio: RadioSettings = RADIO, steps: int = 12, period: float = 0.48, rest_s: float = 2.5,
    blow: float = 0.0, sensor: SensorSettings = SENSOR,
) -> Run:  # fmt: skip
    """A run of its own period that is as planned but for what sensors and radio do, with blows [m/s] at the strikes."""
    period *= 1 + 0.01 * np.random.default_rng(seed).normal()
    plain = Variation(1.0, 1.0, SLOPE.slope_deg, SLOPE.slope_deg, 0.0, Build())
    walk = walked(steps, period, rest_s, plain)
    walk = dataclasses.replace(
        walk, **{side: struck(getattr(walk, side), walk.heel_strike_time, blow) for side in ("hip", "foot")})
    return sensed_run(seed, walk, dataclasses.replace(CAMPAIGN, radio=radio, given_sensor=sensor))


def make_database(runs: list[Run], sensor: SensorSettings = SENSOR) -> bytes:
    devices = [device(place, sensor) for place in ("hip", "foot")]
    return database_bytes(devices, [(experiment, sent) for experiment, _, sent in runs])
