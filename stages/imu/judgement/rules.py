"""Where a trial's evidence becomes a verdict: accepted, accepted with remarks, or refused.

A rule is a row: when it holds, what it says, and the quantities that are then not to be trusted. It holds one piece of
evidence against its limit (`params/imu.yaml`, with the source of each) and says in a sentence where to look. Of rules
joined by `or` the first that holds speaks. A refusal needs no list of quantities. What cannot be known from the
recording is a remark as well: it is said, not guessed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from stages.imu.clock.packet_index import BY_DEVICE_STAMP, BY_ROWS
from stages.imu.judgement.evidence import mean_gain
from stages.imu.judgement.sensor_evidence import (
    FEWEST_ROWS,
    declared_rate_unit,
    flat_tops,
    leg_sweep,
    missing_share,
    noise_ends,
    slower_rows,
    wraps,
)
from stages.imu.judgement.verdict import (
    CLOCK,
    FORCE,
    FRAME,
    FREQUENCY,
    LAG,
    LEG_ANGLE,
    LEGS,
    LEVER,
    RATE,
    STEP_LENGTH,
    STRIKES,
    Finding,
    Rule,
    Verdict,
    refusal,
    remark,
)
from stages.imu.parameters import Limits, Parameters, Settings
from stages.imu.result import Evidence, SensorReport
from stages.imu.sources.units import declared_acceleration_unit
from stages.imu.strikes.heel_strikes import FEWEST_SEEN
from stages.imu.strikes.step_times import FEWEST_USED, INNER, OUTER
from stages.imu.trial.body import PLACES, BodySensor, is_mounting_declared
from stages.imu.trial.sensor import SensorTrace
from stages.imu.trial.two_clocks import have_own_clocks

if TYPE_CHECKING:
    from stages.imu.trial.trial import Trial

FEW_WRONG = 3  # readings, beside which no force is so often wrong that strikes are
IN_RADIANS = math.radians(10.0)  # no ramp is so gentle that is not level, and none so steep is walked down


def _of(places: Iterable[str], *what: str) -> tuple[str, ...]:
    """The names of these quantities at these places."""
    return tuple(f"{place} {one}" for place in places for one in what)


def against_sensor(
    trace: SensorTrace, report: SensorReport, settings: Settings, limits: Limits
) -> tuple[Finding, ...]:
    """Every reason not to use one sensor's recording: its units, its clock, its frame.

    A refusal says that it is read otherwise than it was meant: then the run's other sensor, described by the same hand,
    is not to be believed alone.
    """
    indexed, device, unit = trace.indexed, trace.indexed.recording.device, report.acceleration_unit
    if indexed.recording.rows < FEWEST_ROWS:
        return (Finding(False, (), f"only {indexed.recording.rows} usable rows"),)
    if report.dead_axes:
        said = f"dead axes: {', '.join(report.dead_axes)}: look for columns of one value; a broken sensor is left out"
        return (Finding(True, (), said),)
    says = f"it is gravity in {unit}" if unit != "none" else "it is gravity in no known unit"
    share, swept = missing_share(trace), leg_sweep(trace, settings.slowest_stride_hz)
    hole = np.diff(indexed.index).max(initial=0) / device.rate_hz
    look = (
        "(lost samples are not numbered: store a packet counter or the sensor's own stamps)"
        if indexed.numbered_by == BY_ROWS else f"(was the clock of the {report.stamp} stamps set"
        + ", or do the sensor's own jitter where samples are lost" * (indexed.numbered_by == BY_DEVICE_STAMP) + "?)"
    )  # fmt: skip
    rules = (
        refusal(not math.isfinite(report.static_reading), "no specific force to compare with gravity")
        or refusal(
            unit != declared_acceleration_unit(device),
            f"static reading {report.static_reading:.4g} is not gravity in {device.accelerometer_unit}: {says}",
        ),
        refusal(
            report.angular_rate_unit not in ("unclear", declared_rate_unit(device.gyroscope_unit)),
            f"the leg would sweep {swept:.2g} rad a step by the angular rate in {device.gyroscope_unit}: it is in "
            f"{report.angular_rate_unit}",
        ),
        remark(
            not abs(report.rate_ppm) < settings.rate_tolerance * 1e6,
            f"rate of {report.rate_hz:.4g} Hz is not the nominal {device.rate_hz:g} Hz"
            + " (are these rows of several sensors? Each needs a file of its own)" * (report.rate_hz > device.rate_hz),
        ),
        remark(
            report.clock_error_s > settings.clock_tolerance_s,
            "the clock cannot be repaired: the smallest delays of its samples differ by "
            f"{report.clock_error_s * 1e3:.2g} ms {look}",
        ),
        remark(
            indexed.resets > 0 and report.stamp == "device" and indexed.numbered_by == BY_DEVICE_STAMP,
            "the sensor's stamps begin anew within the recording, and no other stamp shows how long it paused: give "
            "each part a run of its own",
        )
        or remark(
            (slow := slower_rows(indexed)) >= FEWEST_ROWS,
            f"{slow} rows, one after the other, come at a lower rate than the others: record at one rate, or leave "
            "rows out until it is one",
        )
        or remark(
            share > settings.loss_tolerance,
            f"{share:.0%} of the samples are lost, up to {hole:.4g} s in a row (was the sensor's clock set?)",
        ),
        refusal(
            report.swing_share < limits.swing_share,
            f"only {report.swing_share:.0%} of the motion turns about one axis: one of a walk that is not in a plane, "
            "spikes, or gyroscope columns of different scale",
        ),
        refusal(
            abs(report.swing_residual_deg) > limits.swing_residual_deg,
            f"the swing axis lies {report.swing_residual_deg:.0f} degrees off level: look for exchanged columns of "
            "gyroscope or accelerometer",
        ),
        refusal(
            report.mounting_deg > limits.mounting_deg,
            f"the frame found is {report.mounting_deg:.0f} degrees from the declared mounting: look at forward_axis, "
            "up_axis, the signs of the accelerometer and the order of the gyroscope's columns",
        ),
    )
    return tuple(one for one in rules if one)


def verdict_on(trial: Trial, left_out: Iterable[Finding], parameters: Parameters) -> Verdict:
    """The verdict on a run; `left_out` says of each sensor that is not used why it is not."""
    sensors = trial.sensors
    if not sensors:
        why = "; ".join(["no usable sensor at hip or foot", *(one.sentence for one in left_out)])
        return Verdict((Finding(True, (), why),))
    rules = (
        *left_out,
        *_on_what_is_there(trial),
        *(rule for place, sensor in sensors.items() for rule in _on_a_clock(place, sensor)),
        *_on_two_places(trial, parameters),
        *_on_the_walk(trial, parameters),
        *(rule for place in sensors for rule in _on_a_place(place, trial, parameters)),
    )
    return Verdict(tuple(one for one in rules if one))


def _on_what_is_there(trial: Trial) -> tuple[Rule, ...]:
    first, *others = trial.sensors
    return (
        remark(
            not others,
            f"only the {first}'s sensor: nothing confirms that it is this run's, which leg it rides on, its "
            "frame, or the scale of its rate" + "; when the outer leg lands it does not show" * (first == "foot"),
            LEGS, STRIKES, FREQUENCY, f"{first} {RATE}", f"{first} {FRAME}",
        ),
        remark(
            trial.experiment.slope_deg is None,
            "slope_deg is unknown and taken as 0: forces and frames are turned by as much",
            *_of(trial.sensors, FRAME),
        ),
        *(
            remark(
                not is_mounting_declared(sensor.trace.indexed.recording.device),
                f"the {place}'s mounting is not declared: which way is forward was read off the swing",
                LEGS, f"{place} {FRAME}",
            )
            for place, sensor in trial.sensors.items()
        ),
    )  # fmt: skip


def _on_a_clock(place: str, sensor: BodySensor) -> tuple[Rule, ...]:
    clock, by_rows = sensor.trace.clock, sensor.trace.indexed.numbered_by == BY_ROWS
    by, dated = ", ".join(f"{size * 1e3:+.0f}" for size in clock.settings), (CLOCK, FREQUENCY, STRIKES)
    return (
        remark(clock.stamp == "none", f"the {place} has no stamps: its rate is the nominal one", *dated)
        or remark(
            clock.stamp == "device", f"the {place} is dated by its own clock: nothing shows how fast that runs", *dated
        )
        or remark(by_rows, f"the {place}'s samples are not numbered: a lost one cannot be noticed", *dated),
        remark(
            len(clock.settings) > 0,
            f"the clock behind the {place}'s stamps was set by {by} ms, which is taken out", CLOCK,
        ),
        remark(
            clock.clock_bend_s > 0,
            f"the {place}'s clock wandered by {clock.clock_bend_s * 1e3:.0f} ms, which is followed", CLOCK,
        ),
    )  # fmt: skip


def _on_two_places(trial: Trial, parameters: Parameters) -> tuple[Rule, ...]:
    evidence, limits = trial.evidence, parameters.limits
    together, overlap = trial.together, trial.overlap
    apart = (
        refusal(
            together.at_edge,
            "the foot's lag lies beyond half a step: its clock differs, or it rides on the other leg",
        ),
        refusal(
            evidence.agreement < limits.smallest_agreement,
            f"hip and foot do not turn as one (R2 {evidence.agreement:.3f} after the lag): another leg, another run, "
            "clocks further apart than half a step, or a gyroscope turned round",
        ),
        refusal(
            evidence.lever_arm < 0,
            f"hip and foot are swapped: the foot sensor would sit {-evidence.lever_arm:.2f} m above the hip sensor",
        ),
    )
    late = remark(
        abs(evidence.rate_lag) > parameters.settings.clock_tolerance_s,
        f"the gyroscopes show the leg's motion {1e3 * evidence.rate_lag:+.0f} ms after the accelerometers: one of "
        "columns that lag, a filter on the rates, or a zero that firmware follows",
        *_of(PLACES, RATE, FRAME), LEVER,
    )  # fmt: skip
    return (
        remark(
            have_own_clocks(trial.sensors),
            "hip and foot are dated by clocks of their own: they were brought together by their motion alone",
            LAG, CLOCK,
        ),
        remark(
            not math.isnan(together.other_lag),
            f"moved by {together.other_lag:+.2f} s the foot would turn with the hip as well as where it was put: "
            "record the still stand and the push with both sensors", LAG, LEVER,
        ),
        refusal(
            overlap < limits.smallest_overlap,
            f"hip and foot share only {overlap:.0%} of their time: logs of different runs, or clocks that were not set",
        ) or remark(
            overlap < limits.usual_overlap,
            f"hip and foot share {overlap:.0%} of their time: what one saw alone is not confirmed", STRIKES, FREQUENCY,
        ),
        *(apart if any(apart) else (late,) if late else _on_one_leg(evidence, trial.experiment.slope_deg, limits)),
    )  # fmt: skip


def _on_one_leg(evidence: Evidence, slope: float | None, limits: Limits) -> tuple[Rule, ...]:
    """How two places that turn as one differ."""
    slope_deg, ratio, off = slope or 0.0, evidence.rate_ratio, abs(evidence.lever_direction_deg)
    degrees = math.degrees(slope_deg)
    return (
        remark(
            evidence.agreement < limits.usual_agreement,
            f"hip and foot turn less alike than on one leg (R2 {evidence.agreement:.4f}): logs of different runs, a "
            "sensor that is loose or smoothed, or a clock that was set",
            LAG, LEVER, STRIKES, FREQUENCY, *_of(PLACES, RATE, FORCE, FRAME),
        ),
        refusal(
            _beyond(abs(ratio), limits.rate_scale_tolerance),
            f"the foot turns {ratio:.2f} times as fast as the hip: look at gyroscope_range_deg_s and gyroscope_unit",
        ) or remark(
            abs(ratio - 1) > limits.rate_tolerance_of_places,
            f"the foot turns {ratio:.2f} times as fast as the hip", *_of(PLACES, RATE),
        ),
        remark(
            abs(evidence.lever_arm / limits.lever_arm - 1) > limits.lever_arm_tolerance,
            f"by the signals the sensors are {evidence.lever_arm:.3f} m apart, nominally {limits.lever_arm:.3f} m",
            LEVER, *_of(PLACES, RATE, FORCE),
        ),
        remark(
            _beyond(evidence.forward_gain, limits.forward_gain_tolerance),
            f"beside the leg's turning the foot measures {evidence.forward_gain:.2f} times the hip's forward part: "
            "one of an accelerometer's axis or gain, or a sensor that turned on its leg",
            *_of(PLACES, FRAME), LEVER,
        ),
        remark(
            0 < slope_deg < IN_RADIANS and abs(evidence.lever_direction_deg + degrees - slope_deg) < off,
            f"slope_deg of {slope_deg:.3g} seems to be in radians: {degrees:.2f} degrees agree better with gravity",
            *_of(PLACES, FRAME),
        ) or remark(
            off > limits.lever_direction_deg,
            f"the line from hip to foot lies {evidence.lever_direction_deg:+.1f} degrees off the leg: look at "
            "slope_deg, rest_leg_angle_deg and the accelerometers' axes",
            *_of(PLACES, FRAME), LEVER,
        ),
    )  # fmt: skip


def _beyond(ratio: float, tolerance: float) -> bool:
    """Whether a ratio is further from 1 than the tolerance, up or down; a NaN is not."""
    return abs(math.log(max(ratio, 1e-9))) > math.log1p(tolerance)


def _on_the_walk(trial: Trial, parameters: Parameters) -> tuple[Rule, ...]:
    settings, limits, evidence = parameters.settings, parameters.limits, trial.evidence
    count, frequency = len(trial.strikes.time), trial.frequency[0]
    of_leg = [int((trial.strikes.leg == leg).sum()) for leg in (INNER, OUTER)]
    if count < settings.fewest_steps:
        return (refusal(True, f"only {count} heel strikes, {settings.fewest_steps} are needed (imu.fewest_steps)"),)
    if min(of_leg) < FEWEST_SEEN:
        return (refusal(True, f"of one leg only {min(of_leg)} heel strikes are seen, {FEWEST_SEEN} are needed: the "
                        "others lie in holes, or the other leg seems to land twice"),)  # fmt: skip
    if count < (fewest := settings.skipped_steps + FEWEST_USED):
        return (refusal(True, f"only {count} heel strikes, {fewest} are needed for a frequency (imu.skipped_steps)"),)
    if not math.isfinite(frequency):
        return (refusal(True, "no step frequency is found: no two steps are alike, or the hip has too long holes"),)
    return (
        refusal(
            not settings.slowest_step_hz <= frequency <= settings.fastest_step_hz,
            f"{frequency:.4g} steps a second are not between {settings.slowest_step_hz:g} and "
            f"{settings.fastest_step_hz:g}",
        ),
        refusal(
            evidence.third_moment < -limits.third_moment,
            "the leg would swing backward faster than it rolls forward: forward_axis points backward, or a gyroscope "
            "is turned round",
        ) or remark(
            abs(evidence.third_moment) <= limits.third_moment, "the swing does not show which way is forward", LEGS
        ),
        remark(
            evidence.spacing > limits.spacing or evidence.alternating < 1,
            f"steps are spaced unevenly (one departs by {evidence.spacing:.0%} of the median) or a leg lands twice",
            STRIKES, LEGS, FREQUENCY, LEG_ANGLE,
        ),
        _on_gains(evidence, parameters),
        remark(
            evidence.hidden_strikes > limits.hidden_strikes,
            f"{evidence.hidden_strikes:.0%} of the heel strikes lie in holes of the recording: they are placed by what "
            "is left of them", STRIKES, FREQUENCY, LEG_ANGLE,  # what hides a strike hides how the rate jumps there
        ),
        remark(
            abs(evidence.strike_symmetry_deg) > limits.strike_symmetry_deg,
            f"the leg lands unevenly about the slope's normal, by {evidence.strike_symmetry_deg:+.1f} degrees: look at "
            "rest_leg_angle_deg, and whether it stood still as is said",
            *_of(PLACES, FRAME),
        ),
    )  # fmt: skip


def _on_gains(evidence: Evidence, parameters: Parameters) -> Rule:
    """What gravity's turning says: of both places alike of the gyroscopes, of one alone of its accelerometer."""
    limits = parameters.limits
    gain, error = mean_gain(evidence, parameters.drawing)
    # The two are alike where both accelerometers are right, as the gyroscopes are on one leg.
    one, other = evidence.hip_gain, evidence.foot_gain / (abs(evidence.rate_ratio) or math.nan)
    unlike = 3 * math.hypot(limits.rate_gain_tolerance, evidence.hip_gain_error, evidence.foot_gain_error)
    read = (f"the gyroscopes read {gain:.2f} times what gravity turns by while the leg stands: one of their gain, "
            "range or unit, or the accelerometers' gain forward")  # fmt: skip
    place, sensed = ("hip", 1 / one) if abs(math.log(one)) > abs(math.log(other)) else ("foot", 1 / other)
    return (
        remark(
            abs(other / one - 1) > unlike,
            f"while the leg stands the {place} reads forward {sensed:.2f} times what gravity gives that turns by its "
            "rate, the other place what it should: an axis of its accelerometer",
            *_of((place,), FORCE, FRAME), LEVER,
        )
        or refusal(_beyond(gain, limits.rate_scale_tolerance), read)
        or remark(abs(gain - 1) > max(limits.rate_gain_tolerance, 3 * error), read, *_of(PLACES, RATE))
    )  # fmt: skip


def _on_a_place(place: str, trial: Trial, parameters: Parameters) -> tuple[Rule, ...]:
    limits, trace, found = parameters.limits, trial.sensors[place].trace, trial.evidence.at(place)
    moved = (("its swing axis", found["axis_deg"]), ("gravity beside its rate", found["pitch_deg"]))
    turned = " and ".join(f"{what} by {angle:.1f}" for what, angle in moved if angle > limits.turned_deg)
    at_rest = trace.static_reading() * trace.scale.acceleration / parameters.settings.gravity
    rows, unusable = max(1, len(trace.time)), trace.indexed.unusable_rows
    raw, scale = trace.indexed.recording, trace.scale
    kinds = (
        (FORCE, raw.acceleration, scale.acceleration_full_scale, scale.acceleration, "m/s^2"),
        (RATE, raw.angular_rate, scale.angular_rate_full_scale, scale.angular_rate, "rad/s"),
    )
    return (
        refusal(
            found["turning"] < limits.turning,
            f"the {place}'s gyroscope turns against gravity: columns exchanged or signs turned in gyroscope or "
            "accelerometer",
        ),
        remark(
            abs(found["arm"] - 1) > limits.leg_length_tolerance,
            f"by the {place}'s signals it is {found['arm']:.2f} times as high above the sole as it should be: look at "
            + ("leg_length" if place == "hip" else "lever_arm, or leg_length"), LEVER, STEP_LENGTH,
        ),
        remark(
            bool(turned),
            f"within the walk turned on the {place}'s sensor, in degrees, {turned}: one of a sensor that turned on its "
            "leg, a gyroscope whose zero drifts, or a walk that leaves its plane",
            *_of((place,), FRAME, RATE),
        ),
        remark(
            noise_ends(trace),
            f"the noise of the {place} at rest ends below its bandwidth: one of readings that were smoothed, "
            "averaged or resampled, or a low pass below bandwidth_hz",
            STRIKES, FREQUENCY, *_of((place,), FORCE, RATE),
        ),
        remark(
            max(abs(at_rest - 1), abs(found["gravity"] - 1)) > limits.gravity_tolerance,
            f"the {place} measures {at_rest:.3f} of gravity at rest and {found['gravity']:.3f} over whole strides: one "
            "of its gain, a bias, or blows that are in holes or beyond full scale", f"{place} {FORCE}",
        ),
        remark(
            abs(found["gravity_deg"]) > limits.gravity_direction_deg,
            f"over whole strides the {place} measures gravity {found['gravity_deg']:+.1f} degrees from where it was "
            "at rest: one of its rate, an axis of its accelerometer, or holes", *_of((place,), FORCE, RATE, FRAME),
        ),
        *(
            remark(
                clipped > limits.clipped_share * rows,
                f"{clipped / rows:.0%} of the {place}'s samples are at full scale", f"{place} {what}",
            )
            for what, clipped in ((FORCE, trace.clipped_acceleration), (RATE, trace.clipped_angular_rate))
        ),
        remark(
            trace.wrong > 0,
            f"{trace.wrong} readings of the {place} are wrong and left out: a rate that leaps away for one sample, or "
            "a force beyond twice full scale; other forces may be wrong as well",
            f"{place} {FORCE}", *(STRIKES, FREQUENCY) * (trace.wrong > FEW_WRONG),
        ),
        *(rule for kind in kinds for rule in _on_readings(place, trial.sensors, *kind)),
        remark(
            unusable > limits.unusable_share * rows,
            f"{unusable} rows of the {place} have no packet number, position or stamp that can be", CLOCK, STRIKES,
        ),
    )  # fmt: skip


def _on_readings(
    place: str, places: Iterable[str], what: str, raw: np.ndarray, full_scale: float, size: float, unit: str
) -> tuple[Rule, ...]:
    """What the stored readings (n, 3) of a place show of their range; one of them is `size` [unit]."""
    over, (count, at) = wraps(raw, full_scale), flat_tops(raw, full_scale)
    return (
        remark(
            over > 0,
            f"readings of the {place} leap {over} times from one end of their range to the other: counts that "
            "begin again beyond their full scale, as another sensor's of this range may",
            *_of(places, what), f"{place} {FRAME}", STRIKES, FREQUENCY,
        ),
        remark(
            count > 0,
            f"{count} samples of the {place} end at {at * size:.3g} {unit}: its full scale is there, "
            + ("not where its range says" if np.isfinite(full_scale) else "and no range is declared"),
            f"{place} {what}",
        ),
    )  # fmt: skip
