"""Claims on sensors and measurements. Runs that are not measured test the method; they decide nothing here."""

import math

import numpy as np

from stages.biped.quantity import mm
from stages.biped.walk import SENSOR_SIGNALS
from stages.comparison.claims.paper import ACCELEROMETER_G, GYROSCOPE_DEG_S, STANDARD_GRAVITY
from stages.comparison.claims.statement import Statement
from stages.comparison.evidence import NAN, Evidence
from stages.comparison.parameters import Settings
from stages.comparison.result import FAILS, HOLDS, HOLDS_IF, OPEN, Cause, Judgement, percent, yes_or_no

MEASURED = "measured"
RUNS = ("imu.database", "campaign.outsole", "campaign.push_sd", "campaign.tolerance_sd")
TWIN = ("twin.inertia", "twin.parts")


def made_up(origin: str) -> Cause:
    """Why runs that are not measured decide nothing."""
    why = f"the runs are {origin}, made from the twin: they test the method, they cannot confirm a model"
    return origin != MEASURED, why


def sensor_range(
    e: Evidence,
) -> tuple[float, float, float, float, float, tuple[float, float], tuple[float, float], float]:
    known = [one for one in e.results.campaign.spikes if math.isfinite(one.hip_peak)]
    peaks = tuple(one.hip_peak / STANDARD_GRAVITY for one in known)
    behind = [run.hip.peak_filtered for run in e.results.campaign.runs]
    return (
        e.twin.peak_specific_force / STANDARD_GRAVITY,
        e.twin.peak_foot_specific_force / STANDARD_GRAVITY,
        math.degrees(e.twin.peak_rate),
        e.twin.time_above_range,
        1 / e.twin.step_frequency,
        (min(peaks, default=NAN), max(peaks, default=NAN)),
        (min((one.time_above_range for one in known), default=NAN),
         max((one.time_above_range for one in known), default=NAN)),
        float(np.median(behind)) / STANDARD_GRAVITY if behind else NAN,
    )  # fmt: skip


def judge_sensor_range(
    limits: Settings,
    hip: float,
    foot: float,
    rate: float,
    above: float,
    period: float,
    spread: tuple[float, float],
    times: tuple[float, float],
    filtered: float,
) -> Judgement:
    """The twin's largest specific forces [g] and rate [deg/s], and the time [s] a step of `period` [s] above the range.

    `spread` and `times` are the least and the largest peak at the hip [g] and time above the range [s] over members of
    the contact set's family towards the rigid limit;
    `filtered` [g] is the peak at the hip behind the low pass of the campaign's sensors.
    """
    inside = above == 0 and rate <= GYROSCOPE_DEG_S
    brief = above <= limits.impact_share * period and rate <= GYROSCOPE_DEG_S
    verdict = HOLDS if inside else HOLDS_IF if brief else FAILS
    time, rest = f"{1e3 * above:.1f} ms a step", 1 - above / period
    return Judgement(
        f"{time} ({100 * above / period:.1f} %) lie above {ACCELEROMETER_G:g} g, with peaks of {hip:.0f} g at the hip "
        f"and {foot:.0f} g at the foot; the largest rate is {rate:.0f} deg/s",
        verdict,
        (
            (inside, f"no more than {max(hip, foot):.1f} g and {rate:.0f} deg/s occur"),
            (
                verdict == HOLDS_IF,
                f"outside of the impact, in {100 * rest:.1f} % of a step, all stays in range",
            ),
            (
                above > 0 and spread[1] > 2 * spread[0],
                "how high the spike is belongs to the contact set, not to the gait: "
                f"{spread[0]:.0f} to {spread[1]:.0f} g at the hip over its family, for "
                f"{1e3 * times[0]:.1f} to {1e3 * times[1]:.1f} ms a step above the range",
            ),
            (
                above > 0 and filtered <= ACCELEROMETER_G,
                f"behind a sensor's low pass it is {filtered:.1f} g at the hip (synthetic)",
            ),
            (verdict == FAILS and rate > GYROSCOPE_DEG_S, f"{rate:.0f} deg/s is beyond the range"),
            (verdict == FAILS and not brief and rate <= GYROSCOPE_DEG_S,
                  f"{time} are more than the {100 * limits.impact_share:g} % allowed to impacts"),
        ),
        f"the {time} around heel strike are not counted" if verdict == HOLDS_IF else "",
    )  # fmt: skip


def encloses(e: Evidence) -> tuple[str, int, tuple[float, ...]]:
    measured = e.measured
    shares = tuple(measured.twin[name].envelope_share for name in SENSOR_SIGNALS[:3])
    return measured.origin, measured.runs, shares


def judge_encloses(limits: Settings, origin: str, runs: int, shares: tuple[float, ...]) -> Judgement:
    """Shares of the stride (1) in which the runs' envelope holds the twin: hip forward, hip up, angular velocity."""
    real, worst = origin == MEASURED, min(shares)
    encloses = worst >= limits.enclosure_share
    return Judgement(
        f"the envelope of {runs} {origin} runs holds the twin over "
        + ", ".join(f"{100 * share:.0f} %" for share in shares)
        + " of the stride (hip forward, hip up, angular velocity)",
        yes_or_no(encloses) if real else OPEN,
        (
            made_up(origin),
            (real and encloses, f"every signal lies inside for at least {100 * worst:.0f} % of the stride"),
            (real and not encloses, f"one signal lies outside for {100 * (1 - worst):.0f} % of the stride"),
        ),
    )


def slower(e: Evidence) -> tuple[str, float, float, float, float]:
    measured = e.measured
    interval = measured.twin_frequency
    return (measured.origin, measured.step_frequency, measured.twin_step_frequency, interval.lower, interval.upper)


def judge_slower(limits: Settings, origin: str, frequency: float, twin: float, lower: float, upper: float) -> Judgement:
    """Step frequencies [Hz] of the runs and of the twin over the same steps, and the interval of their difference."""
    real, change = origin == MEASURED, frequency / twin - 1
    slower, sure = change < 0, not lower <= 0 <= upper
    interval = f"{1e3 * lower:+.1f} to {1e3 * upper:+.1f} mHz"
    return Judgement(
        f"{origin} runs {frequency:.4f} Hz, twin {twin:.4f} Hz over the same steps, {percent(change)}",
        (yes_or_no(slower) if sure else OPEN) if real else OPEN,
        (
            made_up(origin),
            (real and slower and sure, f"the whole interval of the difference is below zero: {interval}"),
            (real and not slower and sure, f"the runs are quicker: {interval}"),
            (real and not sure, f"the interval of the difference holds zero: {interval}"),
        ),
    )


def hip_path_drifts(e: Evidence) -> tuple[str, float, float, float, float, float, float, float, float]:
    legs, seen = e.ingest.leg if e.ingest is not None else None, e.measured.leg
    lengths = (NAN,) * 4
    if seen is not None:
        lengths = seen.runs.step_length, seen.step_length_error, seen.twin.step_length, seen.simple.step_length
    truth = (NAN,) * 4
    if legs is not None:
        truth = (float(np.mean(legs.way)), _rms(legs.twice), _rms(legs.step), _rms(legs.angle))
    return e.measured.origin, *truth, *lengths


def judge_hip_path_drifts(
    limits: Settings,
    origin: str,
    way: float,
    twice: float,
    once: float,
    angle: float,
    step_length: float,
    said: float,
    twin: float,
    simple: float,
) -> Judgement:
    """Errors of the hip's path against the truth of synthetic runs: rms of where two integrations of the acceleration
    put the last strike [m], over a way of `way` [m]; rms of a step's length by one integration of the rate and the foot
    that rolls, relative; rms of the leg angle [rad]. NaN where there is no truth. Then the runs' step length and that
    of twin and simple model [m], and the standard error the ingest gives a step [m]; NaN where no run has any.
    """
    known, seen = math.isfinite(twice) and math.isfinite(once), math.isfinite(step_length)
    drifts, enough = twice > limits.hip_path_share * way, once <= limits.hip_path_share
    verdict = OPEN if not known else FAILS if not drifts else HOLDS_IF if enough else HOLDS
    errors = f"the true path of the {origin} runs is not known"
    if known:
        errors = (
            f"two integrations of the acceleration of {origin} runs put the hip {mm(twice)} off after {way:.2f} m "
            f"({100 * twice / way:.0f} %); one of the rate, with the foot that rolls, has errors of {100 * once:.2f} % "
            f"of a step's length and {math.degrees(angle):.2f} degrees of the leg's angle"
        )
    lengths = (
        f". Their steps are {mm(step_length)} long, each with a standard error of {mm(said)}, "
        f"the twin's {mm(twin)}, the simple model's {mm(simple)}"
        if seen
        else ""
    )
    return Judgement(
        errors + lengths,
        verdict,
        (
            (known and drifts, "an accelerometer's bias grows with the square of time"),
            (known and not drifts, "the accelerometers' biases are too small to matter over such a walk"),
            (
                known and drifts and enough,
                "the second integration is not needed: while a foot rolls, the leg's angle shows where the hip is",
            ),
            (known and drifts and not enough, "nor does one integration do with these gyroscopes"),
            (not known, "only runs whose truth is known can show how far a path drifts"),
        ),
        "it is the acceleration that is integrated; one integration of the rate is enough"
        if verdict == HOLDS_IF
        else "",
    )


def _rms(errors: np.ndarray) -> float:
    known = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else NAN


STATEMENTS = (
    Statement(
        "sensor_range",
        "7.2",
        "To ensure that the dynamics of the biped's gait are captured by the IMU devices, the latter are set to "
        "measure accelerations up to 4 g and angular velocities up to 2000 deg/s, both at a sampling rate of 100 Hz.",
        "what the sensors measure stays inside these ranges",
        sensor_range,
        judge_sensor_range,
        (*TWIN, "ground.contact_stiffness", "ground.contact_damping", "campaign.bandwidth_hz"),
        units={"g": "hip foot spread filtered", "deg/s": "rate", "s": "above period times"},
        plain="The sensors can follow everything that happens to them in a walk.",
    ),
    Statement(
        "hip_path_drifts",
        "7.4",
        "Different measurements could also be of interest: for example, the hip position in the x and y direction of "
        "motion [...]. However, [...] the double integrations that would be needed in the hip trajectory calculation "
        "would introduce a considerable amount of accumulated error.",
        "from the sensors the hip's path comes out only with a considerable error, since it takes two integrations",
        hip_path_drifts,
        judge_hip_path_drifts,
        (*RUNS, "campaign.acceleration_bias_sd", "campaign.angular_rate_gain_sd", "imu.foot_radius"),
        units={"m": "way twice step_length said twin simple", "rad": "angle"},
        method=True,
        plain="Where the hip goes is not known well from accelerometers, because errors add up.",
    ),
    Statement(
        "measurement_encloses",
        "7.4",
        "Finally, the whole set of the experimental data envelops the simulated ones [...]",
        "the envelope of the runs holds the twin's curves over the stride",
        encloses,
        judge_encloses,
        (*RUNS, *TWIN),
        plain="The computed curves lie within the spread of what was measured.",
    ),
    Statement(
        "measurement_slower",
        "7.4",
        "[...] the lab prototype appears to walk slightly slower than the simulated models.",
        "the runs' step frequency is below the twin's over the same steps",
        slower,
        judge_slower,
        (*RUNS, *TWIN),
        units={"Hz": "frequency twin lower upper"},
        plain="The real robot steps a little more slowly than the models.",
    ),
)
