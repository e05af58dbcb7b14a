"""Why one sensor's recording is not used: its units, its clock, its frame."""

from __future__ import annotations

import math
from collections.abc import Iterator

from stages.imu.clock.indexed import BY_ROWS
from stages.imu.judgement.sensor_evidence import (
    FEWEST_ROWS,
    angular_rate_unit,
    dead_axes,
    declared_rate_unit,
    leg_sweep,
    missing_share,
    static_reading,
)
from stages.imu.judgement.verdict import Refusal
from stages.imu.parameters import Limits, Settings
from stages.imu.sources.units import agrees_with_gravity, implied_acceleration_unit
from stages.imu.trial.frames import Frame
from stages.imu.trial.sensor import SensorTrace


def refusals_of(trace: SensorTrace, frame: Frame | None, settings: Settings, limits: Limits) -> Iterator[Refusal]:
    """Every reason not to use one sensor's recording."""
    if trace.indexed.recording.rows < FEWEST_ROWS:
        yield Refusal(False, f"only {trace.indexed.recording.rows} usable rows")
        return
    yield from (Refusal(True, sentence) for sentence in _unit_refusals(trace, settings))
    yield from (Refusal(False, sentence) for sentence in _clock_refusals(trace, settings))
    if frame is not None:
        yield from (Refusal(True, sentence) for sentence in _frame_refusals(frame, limits))


def _unit_refusals(trace: SensorTrace, settings: Settings) -> Iterator[str]:
    device, dead, reading = trace.indexed.recording.device, dead_axes(trace), static_reading(trace)
    unit = implied_acceleration_unit(reading, device, settings.gravity)
    rate_unit = angular_rate_unit(trace, settings.slowest_stride_hz)
    if dead:
        yield f"dead axes: {', '.join(dead)}"
    if not math.isfinite(reading):
        yield "no specific force to compare with gravity"
    elif not agrees_with_gravity(unit, device):
        says = f"it is gravity in {unit}" if unit != "none" else "it is gravity in no known unit"
        yield f"static reading {reading:.4g} is not gravity in {device.accelerometer_unit}: {says}"
    if rate_unit not in ("unclear", declared_rate_unit(device.gyroscope_unit)):
        swept = leg_sweep(trace, settings.slowest_stride_hz)
        yield (
            f"the leg would sweep {swept:.2g} rad a step by the angular rate in {device.gyroscope_unit}: it is in "
            f"{rate_unit}"
        )


def _clock_refusals(trace: SensorTrace, settings: Settings) -> Iterator[str]:
    indexed, clock, nominal = trace.indexed, trace.clock, trace.indexed.recording.device.rate_hz
    if not abs(clock.rate_ppm) < settings.rate_tolerance * 1e6:
        yield f"rate of {clock.rate_hz:.4g} Hz is not the nominal {nominal:g} Hz"
    if clock.error > settings.clock_tolerance_s:
        yield (
            f"the clock cannot be repaired: the floor of lateness is uneven by {clock.error * 1e3:.2g} ms "
            + ("(lost samples are not numbered: store a packet counter or the sensor's own stamps)"
               if indexed.numbered_by == BY_ROWS else f"(was the clock of the {clock.stamp} stamps set?)")
        )  # fmt: skip
    share = missing_share(trace)
    if share > settings.loss_tolerance:
        yield f"{share:.0%} of the samples are lost"


def _frame_refusals(frame: Frame, limits: Limits) -> Iterator[str]:
    if frame.swing_share < limits.swing_share:
        yield (
            f"only {frame.swing_share:.0%} of the motion turns about one axis: one of a walk that is not in a plane, "
            "spikes, or gyroscope columns of different scale"
        )
    if abs(frame.swing_residual_deg) > limits.swing_residual_deg:
        yield (
            f"the swing axis lies {frame.swing_residual_deg:.0f} degrees off level: look for exchanged columns of "
            "gyroscope or accelerometer"
        )
    if frame.mounting_deg > limits.mounting_deg:
        yield (
            f"the frame found is {frame.mounting_deg:.0f} degrees from the declared mounting: look at forward_axis, "
            "up_axis, the signs of the accelerometer and the order of the gyroscope's columns"
        )
