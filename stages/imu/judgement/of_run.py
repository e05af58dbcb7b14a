"""The verdict on a run: what it holds, its clocks, its two places together, the walk, and each place."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

from stages.imu.clock.indexed import BY_ROWS
from stages.imu.judgement.rolling_stance import mean_gain
from stages.imu.judgement.sensor_evidence import flat_tops, noise_ends, static_reading, wraps
from stages.imu.judgement.verdict import (
    CLOCK,
    FORCE,
    FRAME,
    FREQUENCY,
    LAG,
    LEGS,
    LEVER,
    RATE,
    STEP_LENGTH,
    STRIKES,
    Finding,
    Refusal,
    Verdict,
)
from stages.imu.parameters import Limits, Reading, Settings
from stages.imu.reports.run_report import Evidence
from stages.imu.sources.schema import Experiment
from stages.imu.trial.frames import Frame, is_mounting_declared
from stages.imu.trial.sensor import SensorTrace

BOTH = ("hip", "foot")
IN_RADIANS = math.radians(10.0)  # no ramp is so gentle that is not level, and none so steep is walked down


def verdict_on(
    experiment: Experiment,
    sensors: Mapping[str, tuple[SensorTrace, Frame]],
    left_out: Iterable[Refusal],
    overlap: float,
    lag_at_edge: bool,
    other_lag: float,
    strikes: int,
    frequency: float,
    evidence: Evidence,
    parameters: Reading,
) -> Verdict:
    """The verdict on a run; `sensors` are those that are used, `left_out` says of each other one why it is not."""
    if not sensors:
        why = "; ".join(["no usable sensor at hip or foot", *(one.sentence for one in left_out)])
        return Verdict((_refuse(why),))
    settings, limits = parameters.settings, parameters.limits
    own_clocks = len(sensors) == 2 and all(trace.clock.stamp == "device" for trace, _ in sensors.values())
    found = [
        *_on_what_is_there(experiment, sensors, left_out),
        *_on_clocks(sensors),
        *_on_two_places(overlap, own_clocks, lag_at_edge, other_lag, experiment.slope_deg or 0.0, evidence,
                        settings, limits),
        *_on_the_walk(strikes, frequency, evidence, parameters),
        *_on_each_place(sensors, evidence, settings, limits),
    ]
    return Verdict(tuple(found))


def _refuse(sentence: str) -> Finding:
    return Finding(True, (), sentence)


def _remark(sentence: str, *about: str) -> Finding:
    return Finding(False, about, sentence)


def _of(places: Iterable[str], *what: str) -> tuple[str, ...]:
    """The names of these quantities at these places."""
    return tuple(f"{place} {one}" for place in places for one in what)


def _on_what_is_there(
    experiment: Experiment, sensors: Mapping[str, tuple[SensorTrace, Frame]], left_out: Iterable[Refusal]
) -> Iterator[Finding]:
    for one in left_out:
        yield _refuse(one.sentence) if one.meaning else _remark(one.sentence)
    if len(sensors) == 1:
        (place,) = sensors
        yield _remark(
            f"only the {place}'s sensor: nothing confirms that it is this run's, which leg it rides on, its "
            "frame, or the scale of its rate",
            LEGS, STRIKES, FREQUENCY, f"{place} {RATE}", f"{place} {FRAME}",
        )  # fmt: skip
    if experiment.slope_deg is None:
        sentence = "slope_deg is unknown and taken as 0: forces and frames are turned by as much"
        yield _remark(sentence, *_of(sensors, FRAME, FORCE))
    for place, (trace, _) in sensors.items():
        if not is_mounting_declared(trace.indexed.recording.device):
            yield _remark(
                f"the {place}'s mounting is not declared: which way is forward was read off the swing",
                LEGS, f"{place} {FRAME}",
            )  # fmt: skip


def _on_clocks(sensors: Mapping[str, tuple[SensorTrace, Frame]]) -> Iterator[Finding]:
    for place, (trace, _) in sensors.items():
        clock, indexed = trace.clock, trace.indexed
        if clock.stamp == "none":
            yield _remark(f"the {place} has no stamps: its rate is the nominal one", CLOCK, FREQUENCY, STRIKES)
        elif clock.stamp == "device":
            yield _remark(
                f"the {place} is dated by its own clock: nothing tells how fast that runs", CLOCK, FREQUENCY, STRIKES
            )
        elif indexed.numbered_by == BY_ROWS:
            yield _remark(
                f"the {place}'s samples are not numbered: a lost one cannot be seen", CLOCK, FREQUENCY, STRIKES
            )
        if len(clock.settings):
            by = ", ".join(f"{size * 1e3:+.0f}" for size in clock.settings)
            yield _remark(f"the clock behind the {place}'s stamps was set by {by} ms, which is taken out", CLOCK)
        if clock.bend > 0:
            yield _remark(f"the {place}'s clock wandered by {clock.bend * 1e3:.0f} ms, which is followed", CLOCK)


def _on_two_places(
    overlap: float, own_clocks: bool, lag_at_edge: bool, other_lag: float, slope_deg: float,
    evidence: Evidence, settings: Settings, limits: Limits,
) -> Iterator[Finding]:
    if own_clocks:
        yield _remark(
            "hip and foot are dated by clocks of their own: they were brought together by their motion alone",
            LAG, CLOCK,
        )  # fmt: skip
    if not math.isnan(other_lag):
        yield _remark(
            f"moved by {other_lag:+.2f} s the foot would turn with the hip as well as where it was put: record the "
            "still stand and the push with both sensors", LAG, LEVER,
        )  # fmt: skip
    if overlap < limits.smallest_overlap:
        yield _refuse(
            f"hip and foot share only {overlap:.0%} of their time: logs of different runs, or clocks that were not set"
        )
    elif overlap < limits.usual_overlap:
        yield _remark(
            f"hip and foot share {overlap:.0%} of their time: what one saw alone is not confirmed", STRIKES, FREQUENCY
        )
    if lag_at_edge:
        yield _refuse("the foot's lag lies beyond half a step: its clock differs, or it rides on the other leg")
    if evidence.agreement < limits.smallest_agreement:
        yield _refuse(
            f"hip and foot do not turn as one (R2 {evidence.agreement:.3f} after the lag): another leg, another run, "
            "clocks further apart than half a step, or a gyroscope turned round"
        )
    lever_arm = evidence.lever_arm
    if lever_arm < 0:
        yield _refuse(f"hip and foot are swapped: the foot sensor would sit {-lever_arm:.2f} m above the hip sensor")
    if lag_at_edge or evidence.agreement < limits.smallest_agreement or lever_arm < 0:
        return  # the rest would speak of the same
    if abs(evidence.rate_lag) > settings.clock_tolerance_s:
        yield _remark(
            f"the gyroscopes show the leg's motion {1e3 * evidence.rate_lag:+.0f} ms after the accelerometers: one of "
            "columns that lag, a filter on the rates, or a zero that firmware follows",
            *_of(BOTH, RATE, FRAME), LEVER,
        )  # fmt: skip
        return
    if evidence.agreement < limits.usual_agreement:
        yield _remark(
            f"hip and foot turn less alike than on one leg (R2 {evidence.agreement:.4f}): logs of different runs, a "
            "sensor that is loose or smoothed, or a clock that was set",
            LAG, LEVER, STRIKES, FREQUENCY,
            *_of(BOTH, RATE, FORCE, FRAME),
        )  # fmt: skip
    if abs(math.log(max(abs(evidence.rate_ratio), 1e-9))) > math.log1p(limits.rate_scale_tolerance):
        yield _refuse(
            f"the foot turns {evidence.rate_ratio:.2f} times as fast as the hip: look at gyroscope_range_deg_s and "
            "gyroscope_unit"
        )
    elif abs(evidence.rate_ratio - 1) > limits.rate_tolerance_of_places:
        yield _remark(
            f"the foot turns {evidence.rate_ratio:.2f} times as fast as the hip", *_of(BOTH, RATE)
        )
    if abs(lever_arm / limits.lever_arm - 1) > limits.lever_arm_tolerance:
        yield _remark(
            f"by the signals the sensors are {lever_arm:.3f} m apart, by the drawing {limits.lever_arm:.3f} m",
            LEVER, *_of(BOTH, RATE, FORCE),
        )  # fmt: skip
    if abs(math.log(max(evidence.forward_gain, 1e-9))) > math.log1p(limits.forward_gain_tolerance):
        yield _remark(
            f"beside the leg's turning the foot feels {evidence.forward_gain:.2f} times as much forward as the hip: "
            "one of an accelerometer's axis or gain, or a sensor that turned on its leg",
            *_of(BOTH, FRAME, FORCE), LEVER,
        )  # fmt: skip
    degrees = math.degrees(slope_deg)
    if 0 < slope_deg < IN_RADIANS and abs(evidence.lever_direction_deg + degrees - slope_deg) < abs(
        evidence.lever_direction_deg
    ):
        yield _remark(
            f"slope_deg of {slope_deg:.3g} seems to be in radians: {degrees:.2f} degrees are nearer to what is felt",
            *_of(BOTH, FRAME, FORCE),
        )  # fmt: skip
    elif abs(evidence.lever_direction_deg) > limits.lever_direction_deg:
        yield _remark(
            f"the line from hip to foot lies {evidence.lever_direction_deg:+.1f} degrees off the leg: look at "
            "slope_deg, rest_leg_angle_deg and the accelerometers' axes",
            *_of(BOTH, FRAME, FORCE), LEVER,
        )  # fmt: skip


def _on_the_walk(strikes: int, frequency: float, evidence: Evidence, parameters: Reading) -> Iterator[Finding]:
    settings, limits = parameters.settings, parameters.limits
    if strikes < settings.fewest_steps:
        yield _refuse(f"only {strikes} heel strikes")
        return
    if not settings.slowest_step_hz <= frequency <= settings.fastest_step_hz:
        yield _refuse(
            f"{frequency:.4g} steps a second are not between {settings.slowest_step_hz:g} and "
            f"{settings.fastest_step_hz:g}"
        )
    if evidence.third_moment < -limits.third_moment:
        yield _refuse(
            "the leg would swing backward faster than it rolls forward: forward_axis points backward, or a gyroscope "
            "is turned round"
        )
    elif abs(evidence.third_moment) <= limits.third_moment:
        yield _remark("the swing does not tell which way is forward", LEGS)
    if evidence.spacing > limits.spacing or evidence.alternating < 1:
        yield _remark(
            f"steps are spaced unevenly (one departs by {evidence.spacing:.0%} of the median) or a leg lands twice",
            STRIKES, LEGS, FREQUENCY,
        )  # fmt: skip
    gain, error = mean_gain(evidence, parameters.drawing)
    # The two are alike where both accelerometers are right, as the gyroscopes are on one leg.
    one, other = evidence.hip_gain, evidence.foot_gain / (abs(evidence.rate_ratio) or math.nan)
    unlike = 3 * math.hypot(limits.rate_gain_tolerance, evidence.hip_gain_error, evidence.foot_gain_error)
    read = (f"the gyroscopes read {gain:.2f} times what gravity turns by while the leg stands: one of their gain, "
            "range or unit, or the accelerometers' gain forward")  # fmt: skip
    if abs(other / one - 1) > unlike:
        place, felt = ("hip", 1 / one) if abs(math.log(one)) > abs(math.log(other)) else ("foot", 1 / other)
        yield _remark(
            f"while the leg stands the {place} feels forward {felt:.2f} times what gravity gives that turns by its "
            "rate, the other place what it should: an axis of its accelerometer", *_of((place,), FORCE, FRAME), LEVER,
        )  # fmt: skip
    elif abs(math.log(max(gain, 1e-9))) > math.log1p(limits.rate_scale_tolerance):
        yield _refuse(read)
    elif abs(gain - 1) > max(limits.rate_gain_tolerance, 3 * error):
        yield _remark(read, *_of(BOTH, RATE))
    if evidence.hidden_strikes > limits.hidden_strikes:
        yield _remark(
            f"{evidence.hidden_strikes:.0%} of the heel strikes lie in holes of the recording: they are placed by what "
            "is left of them", STRIKES, FREQUENCY,
        )  # fmt: skip
    if abs(evidence.strike_symmetry_deg) > limits.strike_symmetry_deg:
        yield _remark(
            f"the leg lands unevenly about the slope's normal, by {evidence.strike_symmetry_deg:+.1f} degrees: look at "
            "rest_leg_angle_deg, and whether it stood still as is said",
            *_of(BOTH, FRAME, FORCE),
        )  # fmt: skip


def _on_each_place(
    sensors: Mapping[str, tuple[SensorTrace, Frame]], evidence: Evidence, settings: Settings, limits: Limits
) -> Iterator[Finding]:
    for place, (trace, _) in sensors.items():
        if getattr(evidence, f"{place}_turning") < limits.turning:
            yield _refuse(
                f"the {place}'s gyroscope turns against gravity: columns exchanged or signs turned in gyroscope or "
                "accelerometer"
            )
        arm = getattr(evidence, f"{place}_arm")
        if abs(arm - 1) > limits.leg_length_tolerance:
            yield _remark(
                f"by the {place}'s signals the leg that stands is {arm:.2f} times as long as by the drawing: look at "
                "leg_length", LEVER, STEP_LENGTH,
            )  # fmt: skip
        turned, drifted = getattr(evidence, f"{place}_axis_deg"), getattr(evidence, f"{place}_pitch_deg")
        moved = {f"its swing axis by {turned:.1f}": turned, f"gravity beside its rate by {drifted:.1f}": drifted}
        if any(angle > limits.turned_deg for angle in moved.values()):
            yield _remark(
                f"within the walk turned on the {place}'s sensor, in degrees, "
                f"{' and '.join(what for what, angle in moved.items() if angle > limits.turned_deg)}: one of a sensor "
                "that turned on its leg, a gyroscope whose zero drifts, or a walk that leaves its plane",
                *_of((place,), FRAME, FORCE, RATE),
            )  # fmt: skip
        if noise_ends(trace):
            yield _remark(
                f"the noise of the {place} at rest ends below its bandwidth: one of readings that were smoothed, "
                "averaged or resampled, or a low pass below bandwidth_hz",
                STRIKES, FREQUENCY, *_of((place,), FORCE, RATE),
            )  # fmt: skip
        at_rest = static_reading(trace) * trace.scale.acceleration / settings.gravity
        walking, off = getattr(evidence, f"{place}_gravity"), getattr(evidence, f"{place}_gravity_deg")
        if max(abs(at_rest - 1), abs(walking - 1)) > limits.gravity_tolerance:
            yield _remark(
                f"the {place} feels {at_rest:.3f} of gravity at rest and {walking:.3f} over whole strides: one "
                "of its gain, a bias, or blows that are in holes or beyond full scale", f"{place} {FORCE}",
            )  # fmt: skip
        if abs(off) > limits.gravity_direction_deg:
            yield _remark(
                f"over whole strides the {place} feels gravity {off:+.1f} degrees from where it stood at rest: "
                "one of its rate, an axis of its accelerometer, or holes", *_of((place,), FORCE, RATE, FRAME),
            )  # fmt: skip
        rows = max(1, len(trace.time))
        for what, clipped in ((FORCE, trace.clipped_acceleration), (RATE, trace.clipped_angular_rate)):
            if clipped > limits.clipped_share * rows:
                yield _remark(f"{clipped / rows:.0%} of the {place}'s samples are at full scale", f"{place} {what}")
        raw = trace.indexed.recording
        for what, values, full, scale, unit in (
            (FORCE, raw.acceleration, trace.scale.acceleration_full_scale, trace.scale.acceleration, "m/s^2"),
            (RATE, raw.angular_rate, trace.scale.angular_rate_full_scale, trace.scale.angular_rate, "rad/s"),
        ):
            if over := wraps(values):
                yield _remark(
                    f"readings of the {place} leap {over} times from one end of their range to the other: counts that "
                    "begin again beyond their full scale, as another sensor's of this range may",
                    *_of(sensors, what), f"{place} {FRAME}", STRIKES, FREQUENCY,
                )  # fmt: skip
            count, at = flat_tops(values, full)
            if count:
                yield _remark(
                    f"{count} samples of the {place} end at {at * scale:.3g} {unit}: its full scale is there, not "
                    "where its range says", f"{place} {what}",
                )  # fmt: skip
        if trace.indexed.unusable_rows > limits.unusable_share * rows:
            yield _remark(
                f"{trace.indexed.unusable_rows} rows of the {place} have no packet number or stamp", CLOCK, STRIKES
            )
