"""A stand-in for the twin: planar leg kinematics with known steps, sent through the synthetic sensor and radio."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d

from pipeline.study import locate
from stages.biped.design import Biped
from stages.campaign.parameters import RadioSettings, SensorSettings
from stages.campaign.result import LegTruth, RunTruth, SensorTruth
from stages.campaign.run import database_bytes
from stages.campaign.twin_run import joined, rolling_leg, stand_and_push
from stages.campaign.virtual_sensor import (
    Readings,
    SensorErrors,
    SensorMotion,
    Transmitted,
    draw_errors,
    read,
    transmit,
)
from stages.ground.slope import Slope
from stages.imu.parameters import Reading, Settings, filter_delay
from stages.imu.result import Result
from stages.imu.run import collect, trials
from stages.imu.sources.databases import SqliteSource
from stages.imu.sources.schema import Device, Experiment

GRID = 1 / 5000
BIPED = Biped("compliant", 0.316, 0.335, 0.333, 0.083, 0.1, 2800.0, 58.35, 0.0)
SLOPE = Slope(2.0, 9.81)
SENSOR = SensorSettings(100.0, 2000.0, 40.0, 4.0, 2000.0, 16, 2.0, 0.005, 0.005, 0.02, 0.5, 1.77e-3, 0.007)
RADIO = RadioSettings(3, 65536, 0.0, 0.008, 0.015, 0.02, 0.2, 0.01, 0.25)
ROUGH_RADIO = dataclasses.replace(RADIO, stall_share=0.10, loss_share=0.05)
STUDY = locate(start=Path(__file__).parents[2]).parameters(("imu",))["imu"].read
LIMITS = STUDY.limits
SETTINGS = Settings(None, 9.81, 0.0, 0.5, 3.0, 0.3, 200.0, 1.5, 3, 6, 101, 0.8, 4.0, 0.05, 0.005, 0.3)

#: The stand-in has no outsole.
DRAWING = dataclasses.replace(STUDY.drawing, leg_length=BIPED.leg_length, foot_radius=BIPED.foot_radius, sag=0.0)
PARAMETERS = Reading(SETTINGS, LIMITS, DRAWING)


def result_of(path: Path) -> Result:
    """What the ingest makes of a database of the stand-in."""
    with SqliteSource(path) as source:
        return collect(trials(source.runs(), PARAMETERS))


def device(place: str) -> Device:
    axes = {"hip": ("+y", "-x"), "foot": ("-z", "+x")}[place]
    return Device(place, 100.0, "counts", "counts", place, 40.0, 4.0, 2000.0, 16, 3, 65536, *axes)


@dataclass(frozen=True)
class Truth:
    """What really happened in a run, and what was sent of it."""

    run: RunTruth
    sent: tuple[Transmitted, Transmitted]


def sensor_truth(place: str, errors: SensorErrors, readings: Readings, sent: Transmitted) -> SensorTruth:
    return SensorTruth(
        place=place,
        rotation=errors.rotation,
        acceleration_gain=errors.acceleration_gain,
        angular_rate_gain=errors.angular_rate_gain,
        acceleration_bias=errors.acceleration_bias,
        angular_rate_bias=errors.angular_rate_bias,
        period=errors.period,
        low_pass_delay=filter_delay(SENSOR.bandwidth_hz),
        packet=sent.packet,
        position=sent.position,
        sample_time=readings.time[sent.row],
        lost_packets=0,
        peak=math.nan,
        peak_filtered=math.nan,
        peak_sampled=math.nan,
    )


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
    r, length = BIPED.foot_radius, BIPED.leg_length
    step = 2 * (r * amplitude + (length - r) * np.sin(amplitude))
    x = number * step + r * theta + (length - r) * np.sin(theta)
    y = r + (length - r) * np.cos(theta)
    hip = gaussian_filter1d(np.stack([x, y], axis=1), 0.0015 / GRID, axis=0)
    foot = hip + (length - BIPED.foot_com) * np.stack([np.sin(phi), -np.cos(phi)], axis=1)
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


def make_run(
    seed: int, radio: RadioSettings = RADIO, steps: int = 12, period: float = 0.48, rest_s: float = 2.5
) -> tuple[Experiment, Truth]:
    rng = np.random.default_rng(seed)
    period *= 1 + 0.01 * rng.normal()
    hip, foot, strikes, leg = walking(steps, period)
    rate = hip.angular_velocity[:, 2]
    time, pushed = stand_and_push(0.0, (0.0, rate[0], (rate[1] - rate[0]) / GRID), rest_s, 0.4, GRID)
    before = rolling_leg(tuple(pushed), BIPED, SLOPE, time)
    sensors, sent = {}, []
    start = 1.6e9 + 100.0 * seed
    for place, motion, rest in zip(("hip", "foot"), (hip, foot), before):
        errors = draw_errors(SENSOR, device(place), rng)
        readings = read(joined(rest, motion), errors, SENSOR, rng)
        sent.append(transmit(readings, start, 100.0, radio, rng))
        sensors[place] = sensor_truth(place, errors, readings, sent[-1])
    truth = RunTruth(
        name=f"run {seed}",
        clock_start=start,
        slope_deg=SLOPE.slope_deg,
        stance_push=1.0,
        swing_push=1.0,
        outsole=0.0,
        robot=BIPED,
        weighed=BIPED.total_mass,
        failed_attempts=0,
        heel_strike_time=strikes,
        heel_strike_leg=(np.arange(steps) + 1) % 2,
        leg=leg,
        hip=sensors["hip"],
        foot=sensors["foot"],
    )
    return Experiment(truth.name, "synthetic", SLOPE.slope_deg), Truth(truth, (sent[0], sent[1]))


def make_database(runs: list[tuple[Experiment, Truth]]) -> bytes:
    return database_bytes([device("hip"), device("foot")], [(experiment, truth.sent) for experiment, truth in runs])
