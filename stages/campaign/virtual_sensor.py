"""A synthetic inertial sensor and its radio: what a real one would report of a motion that is known exactly.

Chain: second-order low pass, sampling at the sensor's own rate and phase, rotation onto misaligned axes, gain, bias,
noise, clipping at full scale, rounding to counts. The readings go out in packets, wait for a connection, stall, get
lost, and are stamped.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfilt, sosfilt_zi
from scipy.spatial.transform import Rotation

from stages.campaign.parameters import RadioSettings, SensorSettings
from stages.campaign.result import SensorErrors
from stages.imu.sources.schema import Device, Rows
from stages.imu.trial.body import mounting

STANDARD_GRAVITY = 9.80665  # m/s^2 in one g of a sensor's data sheet


@dataclass(frozen=True)
class SensorMotion:
    """What a sensor measures on body axes forward, up, lateral, on a uniform grid.

    time (n,) [s]; specific_force (n, 3) [m/s^2], acceleration minus gravity; angular_velocity (n, 3) [rad/s].
    """

    time: np.ndarray
    specific_force: np.ndarray
    angular_velocity: np.ndarray


@dataclass(frozen=True)
class Readings:
    """Counts (n, 3) as a sensor puts them out, with the true time of each sample (n,) [s]."""

    time: np.ndarray
    acceleration: np.ndarray
    angular_rate: np.ndarray


def draw_errors(settings: SensorSettings, device: Device, rng: np.random.Generator) -> SensorErrors:
    """One sensor out of the bin: its misalignment, gains, biases and clock rate."""
    tilt = Rotation.from_rotvec(rng.normal(scale=np.deg2rad(settings.misalignment_sd_deg), size=3)).as_matrix()
    return SensorErrors(
        rotation=tilt @ mounting(device).T,
        acceleration_gain=1 + rng.normal(scale=settings.acceleration_gain_sd, size=3),
        angular_rate_gain=1 + rng.normal(scale=settings.angular_rate_gain_sd, size=3),
        acceleration_bias=rng.normal(scale=settings.acceleration_bias_sd, size=3),
        angular_rate_bias=np.deg2rad(rng.normal(scale=settings.angular_rate_bias_sd_deg_s, size=3)),
        period=1 / (settings.rate_hz * (1 + 1e-6 * rng.normal(scale=settings.rate_error_sd_ppm))),
    )


def low_pass(signal: np.ndarray, grid_rate_hz: float, bandwidth_hz: float) -> np.ndarray:
    """Second-order Butterworth low pass of a signal (n, ...) along time, at rest in its first value."""
    sections = butter(2, bandwidth_hz, fs=grid_rate_hz, output="sos")
    state = sosfilt_zi(sections).reshape(-1, 2, *([1] * (signal.ndim - 1))) * signal[0]
    return np.asarray(sosfilt(sections, signal, axis=0, zi=state)[0])


def read(motion: SensorMotion, errors: SensorErrors, settings: SensorSettings, rng: np.random.Generator) -> Readings:
    """The counts the sensor puts out over the whole motion, from a random phase of its own clock.

    What is drawn for each sample has a generator of its own: a sample more at the end changes nothing before.
    """
    grid_rate = 1 / (motion.time[1] - motion.time[0])
    phase = rng.uniform(0, errors.period)
    count = int((motion.time[-1] - motion.time[0] - phase) / errors.period) + 1
    time = motion.time[0] + phase + errors.period * np.arange(count)

    def channel(signal: np.ndarray, gain: np.ndarray, bias: np.ndarray, noise: float, full_scale: float) -> np.ndarray:
        smooth = low_pass(signal, grid_rate, settings.bandwidth_hz)
        sampled = np.column_stack([np.interp(time, motion.time, axis) for axis in smooth.T])
        value = (sampled @ errors.rotation.T) * gain + bias + noise * rng.spawn(1)[0].normal(size=sampled.shape)
        largest = 2 ** (settings.bits - 1)
        return np.asarray(np.clip(np.rint(value / full_scale * largest), -largest, largest - 1).astype(np.int64))

    force_noise, rate_noise = settings.noise
    return Readings(
        time=time,
        acceleration=channel(
            motion.specific_force,
            errors.acceleration_gain,
            errors.acceleration_bias,
            force_noise,
            settings.accelerometer_range_g * STANDARD_GRAVITY,
        ),
        angular_rate=channel(
            motion.angular_velocity,
            errors.angular_rate_gain,
            errors.angular_rate_bias,
            rate_noise,
            np.deg2rad(settings.gyroscope_range_deg_s),
        ),
    )


@dataclass(frozen=True)
class Transmitted(Rows):
    """Rows that reached the server, in the order they were stored; `row` (n,) is the reading a row came from."""

    row: np.ndarray


def transmit(
    readings: Readings, clock_start: float, nominal_rate_hz: float, settings: RadioSettings, rng: np.random.Generator
) -> Transmitted:
    """Send readings over the radio. Phone and server stamps are true time + `clock_start` [s], late by the radio.

    The device stamp is what the sensor believes: its own count of samples over its nominal rate.
    A stall holds a packet back and all that queue behind it; a lost packet leaves a hole in the packet numbers.
    Generators as in `read`.
    """
    delays, stalls, lengths, uploads, losses = rng.spawn(5)
    batch = settings.batch_size
    packets = len(readings.time) // batch
    row = np.arange(packets * batch)
    ready = readings.time[batch - 1 :: batch][:packets]
    delay = settings.latency_s + delays.exponential(settings.jitter_s, packets)
    stalled = stalls.random(packets) < settings.stall_share
    delay += np.where(stalled, lengths.exponential(settings.stall_s, packets), 0.0)
    phone = np.maximum.accumulate(_next_connection(ready, settings.connection_interval_s, rng) + delay)
    uploaded = np.ceil(phone / settings.upload_interval_s) * settings.upload_interval_s
    server = np.maximum.accumulate(uploaded + settings.latency_s + uploads.exponential(settings.jitter_s, packets))
    kept = np.repeat(losses.random(packets) >= settings.loss_share, batch)

    first = int(rng.integers(0, settings.counter_modulus))
    number = (first + np.arange(packets)) % settings.counter_modulus

    def stamp(time: np.ndarray) -> np.ndarray:
        return np.round(np.repeat(clock_start + time, batch)[kept], 3)

    return Transmitted(
        packet=np.repeat(number, batch)[kept],
        position=np.tile(np.arange(batch), packets)[kept],
        device_stamp=np.round((row[kept] + first % 1000) / nominal_rate_hz, 3),
        phone_stamp=stamp(phone),
        server_stamp=stamp(server),
        acceleration=readings.acceleration[: packets * batch][kept],
        angular_rate=readings.angular_rate[: packets * batch][kept],
        row=row[kept],
    )


def _next_connection(ready: np.ndarray, interval: float, rng: np.random.Generator) -> np.ndarray:
    """When packets that are `ready` leave, if the radio connects every `interval` [s]; at once where that is 0."""
    if interval == 0:
        return ready
    first = rng.uniform(0, interval)
    return np.ceil((ready - first) / interval) * interval + first
