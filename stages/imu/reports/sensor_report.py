"""What a recording is worth, said before it is used."""

from __future__ import annotations

from dataclasses import dataclass

from stages.biped.quantity import quantity

NOT_OBSERVABLE = -1


@dataclass(frozen=True)
class SensorReport:
    """Faults and facts of one sensor in one run."""

    run: str = quantity("-", "experiment")
    place: str = quantity("-", "place of the sensor")
    bandwidth_hz: float = quantity("Hz", "cut-off of the sensor's low pass as declared; NaN where it is not")
    rows: int = quantity("1", "rows stored")
    exact_duplicates: int = quantity("1", "rows that repeat another in every column")
    sent_again: int = quantity("1", "rows of packets that arrived a second time")
    key_duplicates: int = quantity("1", "rows that repeat the packet and position of another with other content")
    out_of_order: int = quantity("1", "rows stored after a later one")
    unusable_rows: int = quantity("1", "rows without packet number or stamp")
    lost_packets: int = quantity("1", "packets missing in the numbering; -1: loss cannot be observed without a counter")
    gaps: int = quantity("1", "holes in the sequence of samples")
    resets: int = quantity("1", "restarts of the packet counter")
    batch_size: int = quantity("1", "samples in a packet")
    smallest_batch: int = quantity("1", "fewest samples of a packet that arrived")
    largest_batch: int = quantity("1", "most samples of a packet that arrived")
    stamp: str = quantity("-", "stamp the clock was fitted to")
    rate_hz: float = quantity("Hz", "fitted sampling rate")
    rate_ppm: float = quantity("ppm", "fitted rate relative to the nominal one")
    numbered_by: str = quantity("-", "what numbers the samples: counter, device stamp or rows")
    clock_settings: int = quantity("1", "settings of the stamps' clock that were taken out")
    clock_bend_s: float = quantity("s", "wander of the sensor's clock that was followed")
    robust_ppm: float = quantity("ppm", "rate of the robust cross-check relative to the fitted one")
    jitter_before_s: float = quantity("s", "rms of the stamps about a least-squares line")
    clock_error_s: float = quantity("s", "unevenness of the floor of lateness: what the clock fitted may be off by")
    missing_values: int = quantity("1", "cells that are no number")
    dead_axes: tuple[str, ...] = quantity("-", "axes that never change")
    clipped_acceleration: int = quantity("1", "samples with an accelerometer axis at full scale")
    clipped_angular_rate: int = quantity("1", "samples with a gyroscope axis at full scale")
    acceleration_step: float = quantity("m/s^2", "quantisation step of the accelerometer")
    angular_rate_step: float = quantity("rad/s", "quantisation step of the gyroscope")
    rest_s: float = quantity("s", "length of the still stand")
    static_reading: float = quantity("1", "magnitude of the specific force at rest in the stored unit")
    static_gain: float = quantity("1", "magnitude of the specific force at rest over gravity, in the declared unit")
    acceleration_unit: str = quantity("-", "unit of acceleration the static reading implies")
    angular_rate_unit: str = quantity("-", "unit of angular rate in which a leg sweeps what it sweeps in a step")
    swing_residual_deg: float = quantity("deg", "angle of the swing axis from normal to gravity")
    swing_share: float = quantity("1", "share of the angular motion about the swing axis")
    mounting_deg: float = quantity("deg", "angle of the frame found to the declared mounting")
    accepted: bool = quantity("1", "whether the recording is used")
    reasons: tuple[str, ...] = quantity("-", "why it is not, or what to bear in mind")


