"""A synthetic radio link: readings go out in packets, wait for a connection, stall, get lost, and are stamped."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.campaign.parameters import RadioSettings
from stages.campaign.virtual_sensor import Readings


@dataclass(frozen=True)
class Transmitted:
    """Rows that reached the server, in the order they were stored.

    packet, position (n,); device, phone and server stamps (n,) [s]; counts (n, 3); `row` (n,) is the reading a row
    came from.
    """

    packet: np.ndarray
    position: np.ndarray
    device_stamp: np.ndarray
    phone_stamp: np.ndarray
    server_stamp: np.ndarray
    acceleration: np.ndarray
    angular_rate: np.ndarray
    row: np.ndarray


def transmit(
    readings: Readings, clock_start: float, nominal_rate_hz: float, settings: RadioSettings, rng: np.random.Generator
) -> Transmitted:
    """Send readings over the radio. Phone and server stamps are true time + `clock_start` [s], late by the radio.

    The device stamp is what the sensor believes: its own count of samples over its nominal rate.
    A stall holds a packet back and all that queue behind it; a lost packet leaves a hole in the packet numbers.
    """
    batch = settings.batch_size
    packets = len(readings.time) // batch
    row = np.arange(packets * batch)
    ready = readings.time[batch - 1 :: batch][:packets]
    delay = settings.latency_s + rng.exponential(settings.jitter_s, packets)
    stalled = rng.random(packets) < settings.stall_share
    delay += np.where(stalled, rng.exponential(settings.stall_s, packets), 0.0)
    phone = np.maximum.accumulate(_next_connection(ready, settings.connection_interval_s, rng) + delay)
    uploaded = np.ceil(phone / settings.upload_interval_s) * settings.upload_interval_s
    server = np.maximum.accumulate(uploaded + settings.latency_s + rng.exponential(settings.jitter_s, packets))
    kept = np.repeat(rng.random(packets) >= settings.loss_share, batch)

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
