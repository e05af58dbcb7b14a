"""Families of logs that are wrong in one way: each takes a good log and a generator, and gives what a lab then has.

`WRONG` are the families named from outside and some of our own, by which the limits were chosen; `LATER` were written
and first run when the limits stood, `LAST` when `LATER` had been answered; `CLOCKS` do it to the clocks alone. `SILENT`
passed without a word until rules were added that are derived: not chosen on these.
"""

import dataclasses
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation

from stages.campaign.twin_run import TwinRun
from tests.imu.made_logs import Log, TracedRecording, made_log, on_outer_leg, replaced

#: Makes a wrong log of a good one; the walks are all of the campaign's, by number.
Family = Callable[[Log, Sequence[TwinRun], np.random.Generator], Log]
PLACES = ("hip", "foot")
TURNED = {"+": "-", "-": "+"}
READINGS, ARRIVALS = ("acceleration", "angular_rate"), ("phone_stamp", "server_stamp")


def of(where: str, change: Callable[..., TracedRecording], *arguments: object, **named: object) -> Family:
    """The recordings of a place ("both": of all, "either": of one that is drawn) changed by a function of this file."""

    def family(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
        place = PLACES[rng.integers(2)] if where == "either" else where
        return log.changed(place, lambda one: change(one, log, rng, *arguments, **named))

    return family


def together(*families: Family) -> Family:
    """One after the other."""

    def family(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
        for each in families:
            log = each(log, walks, rng)
        return log

    return family


def drawn(log: Log) -> np.random.Generator:
    """A generator of the log's own, for what is the same of both its sensors."""
    return np.random.default_rng(log.number)


def counts(log: Log, signal: str, size: float) -> float:
    """So many counts are a reading of this size [g or deg/s]."""
    full = {"acceleration": "accelerometer_range_g", "angular_rate": "gyroscope_range_deg_s"}[signal]
    return size / getattr(log.parameters.sensor, full) * 2 ** (log.parameters.sensor.bits - 1)


def stood(one: TracedRecording, log: Log) -> np.ndarray:
    """Which rows (n,) are of the still stand."""
    return one.true_time < log.recordings[0].true_time.min() + log.parameters.runs.rest_s - 0.1


# What is said of the sensors and of the slope.


def declared(one: TracedRecording, log: Log, rng: np.random.Generator, *turned: str, **said: object) -> TracedRecording:
    """Other words about the sensor, and these axes the other way."""
    axes = {key: getattr(one.device, key) for key in turned}
    other = {key: TURNED[axis[0]] + axis[1] for key, axis in axes.items()}
    return replaced(one, device=dataclasses.replace(one.device, **said, **other))


def slope(change: Callable[[float, np.random.Generator], float | None]) -> Family:
    """Another inclination is written down [deg]."""

    def family(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
        other = dataclasses.replace(log.experiment, slope_deg=change(log.experiment.slope_deg or 0.0, rng))
        made = log.changed("both", lambda one: replaced(one, experiment=other))
        return dataclasses.replace(made, experiment=other)

    return family


def sensors_swapped(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The two places were named the wrong way round; each device is described as the one that sat there."""
    hip, foot = log.recordings
    moved = (replaced(foot, device=dataclasses.replace(foot.device, place="hip")),
             replaced(hip, device=dataclasses.replace(hip.device, place="foot")))  # fmt: skip
    return dataclasses.replace(
        log, recordings=moved,
        motions={"hip": log.motions["foot"], "foot": log.motions["hip"]},
        rotations={"hip": log.rotations["foot"], "foot": log.rotations["hip"]},
    )  # fmt: skip


# Whose motion it is.


def on_other_leg(place: str) -> Family:
    """One sensor rides on the outer leg, which is told as the inner one."""

    def family(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
        walked = walks[log.number]
        own = {"hip": walked.hip, "foot": walked.foot}
        return made_log(log.number, walked, log.parameters, own | {place: on_outer_leg(own[place], walked)})

    return family


def foot_of_another_run(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """Another run's foot, its stamps as they are: minutes away."""
    other = (log.number + int(rng.integers(1, len(walks)))) % len(walks)
    foreign = made_log(other, walks[other], log.parameters)
    foot = next(one for one in foreign.recordings if one.device.place == "foot")
    motions, rotations = {**log.motions, "foot": foreign.motions["foot"]}, {**log.rotations,
                                                                           "foot": foreign.rotations["foot"]}
    return dataclasses.replace(log, recordings=(log.recordings[0], foot), motions=motions, rotations=rotations)


def two_trials_in_one(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The hip's log goes on into the next run, the foot's does not."""
    after = (log.number + 1) % len(walks)
    other = made_log(after, walks[after], log.parameters).recordings[0]
    mine = log.recordings[0]
    by = mine.phone_stamp[-1] + 1.0 - other.phone_stamp[0]
    joined = {
        name: np.concatenate((getattr(mine, name), getattr(other, name) + shift))
        for name, shift in (
            ("packet", mine.packet[-1] + 33 - other.packet[0]), ("position", 0), ("device_stamp", np.nan),
            ("phone_stamp", by), ("server_stamp", by), ("acceleration", 0), ("angular_rate", 0),
            ("true_time", by - mine.phone_stamp[0] + mine.true_time[0] + other.phone_stamp[0] - other.true_time[0]),
        )
    }  # fmt: skip
    return dataclasses.replace(log, recordings=(replaced(mine, **joined), log.recordings[1]))


def walked_backward(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """Both sensors turned about the leg by half a turn, and declared as they usually sit."""
    half = np.diag([-1.0, 1.0, -1.0])

    def turned(one: TracedRecording) -> TracedRecording:
        rotation = log.rotations[one.device.place]
        on_sensor = rotation.T @ half @ rotation
        return replaced(one, acceleration=one.acceleration @ on_sensor.T, angular_rate=one.angular_rate @ on_sensor.T)

    rotations = {place: half @ rotation for place, rotation in log.rotations.items()}
    return dataclasses.replace(log.changed("both", turned), rotations=rotations)


# What is read.


def scaled(one: TracedRecording, log: Log, rng: np.random.Generator, signal: str, *factors: float) -> TracedRecording:
    """A signal times one of these factors."""
    return replaced(one, **{signal: np.rint(drawn(log).choice(factors) * getattr(one, signal))})


def exchanged(
    one: TracedRecording, log: Log, rng: np.random.Generator, signals: Sequence[str], *orders: Sequence[int]
) -> TracedRecording:
    """The columns of each of these signals in one of these orders."""
    order = orders[drawn(log).integers(len(orders))]
    return replaced(one, **{signal: getattr(one, signal)[:, order] for signal in signals})


def one_axis_twice_as_strong(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    """An accelerometer axis across gravity, forward, with another range than the others."""
    gain = np.where(np.arange(3) == "xyz".index(str(one.device.forward_axis)[1]), 2.0, 1.0)
    return replaced(one, acceleration=one.acceleration * gain)


def held_off_the_normal(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    """The legs were held 6 degrees from where the settings say: in the sensors' frames, both sensors alike."""
    turn = Rotation.from_rotvec([0, 0, np.radians(6.0 * drawn(log).choice([-1, 1]))]).as_matrix()
    rotation = log.rotations[one.device.place]
    turned = one.acceleration @ rotation.T @ turn.T @ rotation
    return replaced(one, acceleration=np.where(stood(one, log)[:, None], turned, one.acceleration))


def stuck_values(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    """The gyroscope repeats its last reading through a second of the walk."""
    since = one.true_time - rng.uniform(1.0, 3.5)
    inside = np.flatnonzero((since >= 0.0) & (since < 1.0))
    rate = one.angular_rate.copy()
    rate[inside] = rate[inside[0]]
    return replaced(one, angular_rate=rate)


def ending_at(one: TracedRecording, log: Log, rng: np.random.Generator, signal: str, size: float) -> TracedRecording:
    """Readings end at this size, though more is declared."""
    full = counts(log, signal, size)
    return replaced(one, **{signal: np.clip(getattr(one, signal), -full, full - 1)})


def wrapping_at(one: TracedRecording, log: Log, rng: np.random.Generator, signal: str, size: float) -> TracedRecording:
    """Beyond this size a count starts again at the other end of the range."""
    full = counts(log, signal, size)
    return replaced(one, **{signal: (getattr(one, signal) + full) % (2 * full) - full})


def gyroscope_drifts(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    """One gyroscope warms up: 4 deg/s more on each axis by the end, from the still stand on."""
    share = np.clip((one.true_time + 0.5) / (one.true_time.max() + 0.5), 0.0, 1.0)
    return replaced(one, angular_rate=one.angular_rate + counts(log, "angular_rate", 4.0) * share[:, None])


def gravity_taken_off(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    """One sensor's export is a phone's linear acceleration: the stand's mean is taken off."""
    return replaced(one, acceleration=one.acceleration - one.acceleration[stood(one, log)].mean(axis=0))


def magnetometer_as_gyroscope(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    """The columns mapped as one gyroscope are a magnetometer's: the earth's field, turning with the leg."""
    motion = log.motions[one.device.place]
    turned = np.concatenate([[0.0], np.cumsum(np.diff(motion.time) * motion.angular_velocity[:-1, 2])])
    heading = rng.uniform(0, 2 * np.pi)
    north, up = 20.0 * np.cos(heading), 45.0
    angle = np.interp(one.true_time, motion.time, turned)
    c, s = np.cos(angle), np.sin(angle)
    across = np.full(len(angle), 20.0 * np.sin(heading))
    on_body = np.column_stack((c * north + s * up, c * up - s * north, across))
    field = 10.0 * (on_body @ log.rotations[one.device.place]) + rng.normal(scale=3.0, size=on_body.shape)
    return replaced(one, angular_rate=np.rint(field))


def knocked(
    one: TracedRecording, log: Log, rng: np.random.Generator, least_deg: float, most_deg: float
) -> TracedRecording:
    """The sensor turns on its leg in the middle of the walk, about any axis."""
    degrees, axis = rng.uniform(least_deg, most_deg), rng.normal(size=3)
    turn = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis)).as_matrix()
    late = (one.true_time > np.median(log.strike_time))[:, None]
    values = {name: getattr(one, name) for name in READINGS}
    return replaced(one, **{name: np.where(late, np.rint(value @ turn), value) for name, value in values.items()})


def gyroscopes_quiet_below_3_deg_s(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    """The firmware writes 0 for what it takes for noise."""
    loud = np.abs(one.angular_rate) >= counts(log, "angular_rate", 3.0)
    return replaced(one, angular_rate=np.where(loud, one.angular_rate, 0.0))


# What a logger or a sensor makes of rows, as numbers in the order of sampling.


def filtered(
    one: TracedRecording, log: Log, rng: np.random.Generator, signals: Sequence[str],
    change: Callable[..., np.ndarray], *arguments: object,
) -> TracedRecording:  # fmt: skip
    """These signals changed row by row."""
    order = np.argsort(one.true_time, kind="stable")
    made = {name: getattr(one, name).copy() for name in signals}
    for values in made.values():
        values[order] = np.rint(change(values[order], *arguments))
    return replaced(one, **made)


def low_passed(values: np.ndarray, cut_off_hz: float) -> np.ndarray:
    """A low pass in both directions."""
    return np.asarray(sosfiltfilt(butter(2, cut_off_hz, fs=100.0, output="sos"), values, axis=0))


def resampled(values: np.ndarray, rate_hz: float) -> np.ndarray:
    """The logger keeps so many rows a second, and writes 100."""
    row = np.arange(len(values)) / 100.0
    at = np.arange(0.0, row[-1] + 1 / rate_hz, 1 / rate_hz)
    return np.column_stack([np.interp(row, at, np.interp(at, row, axis)) for axis in values.T])


def means_of_the_last(values: np.ndarray, rows: int) -> np.ndarray:
    return np.array([values[max(0, row + 1 - rows) : row + 1].mean(axis=0) for row in range(len(values))])


def less_a_running_mean(values: np.ndarray) -> np.ndarray:
    """The firmware takes a running mean of 1 s off: what it thinks the zero."""
    made, mean = values.copy(), values[:50].mean(axis=0)
    for row, value in enumerate(values):
        mean = mean + 0.01 * (value - mean)
        made[row] = value - mean
    return made


def less_the_mean(values: np.ndarray) -> np.ndarray:
    return values - values.mean(axis=0)


def three_rows_late(values: np.ndarray) -> np.ndarray:
    return np.concatenate((values[:3], values[:-3]))


def spikes(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    """Half a percent of the readings are any number of the range."""
    largest = 2 ** (log.parameters.sensor.bits - 1)

    def struck(values: np.ndarray) -> np.ndarray:
        return np.where(rng.random(values.shape) < 0.005, rng.uniform(-largest, largest, values.shape), values)

    return filtered(one, log, rng, READINGS, struck)


# Clocks, counters and packets.


def unknown(one: TracedRecording, log: Log, rng: np.random.Generator, *names: str, **said: object) -> TracedRecording:
    """Numbers or stamps that are not there, and other words about the sensor."""
    return replaced(declared(one, log, rng, **said), **dict.fromkeys(names, np.full(one.rows, np.nan)))


def later(one: TracedRecording, by: np.ndarray | float) -> TracedRecording:
    return replaced(one, **{name: getattr(one, name) + by for name in ARRIVALS})


def clock_off(one: TracedRecording, log: Log, rng: np.random.Generator, by: float) -> TracedRecording:
    """Before or after the other's by so much [s]."""
    return later(one, by * drawn(log).choice([-1, 1]))


def begun_with_the_hip(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    return later(one, log.recordings[0].phone_stamp[0] - one.phone_stamp[0])


def set_by(
    one: TracedRecording, log: Log, rng: np.random.Generator, *sizes: tuple[float, float]
) -> TracedRecording:
    """The phone's clock is set by sizes between two each [s], evenly over the run; both sensors' packets bear it."""
    generator = drawn(log)
    start = min(each.phone_stamp.min() for each in log.recordings)
    end = max(each.phone_stamp.max() for each in log.recordings)
    when = np.linspace(start, end, len(sizes) + 2)[1:-1]
    moved = np.array([generator.uniform(*ends) for ends in sizes])
    return later(one, (one.phone_stamp[:, None] >= when) @ moved)


def sent_again(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    """A tenth of the packets arrives a second time, .1 to 2 s later, in blocks."""
    count = one.rows // 3
    first = rng.integers(0, count - 12, max(1, count // 100))
    rows = np.unique((first[:, None] + np.arange(10)).ravel())
    rows = (3 * rows[:, None] + np.arange(3)).ravel()
    late = np.repeat(rng.uniform(0.1, 2.0, len(first)).max(), len(rows))
    stamp = np.append(one.phone_stamp, one.phone_stamp[rows] + late)
    order = np.argsort(stamp, kind="stable")
    longer = one.take(np.append(np.arange(one.rows), rows)[order])
    return replaced(longer, phone_stamp=stamp[order], server_stamp=stamp[order])


def numbered_after_the_loss(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    """The phone numbers the packets that arrived: a tenth was lost before, and nothing shows it."""
    packets = np.unique(one.packet)
    kept = packets[rng.random(len(packets)) > 0.1]
    left = one.take(np.isin(one.packet, kept))
    return replaced(left, packet=np.searchsorted(kept, left.packet).astype(float),
                    device_stamp=np.full(left.rows, np.nan))  # fmt: skip


def packets_lost_at_strikes(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    """The antenna is shaken: what was sampled 25 ms round a strike is lost, with its packet."""
    near = np.abs(one.true_time[:, None] - log.strike_time).min(axis=1) < 0.025
    return one.take(~np.isin(one.packet, one.packet[near]))


def eight_bit_counter(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    return replaced(declared(one, log, rng, counter_modulus=256), packet=one.packet % 256)


def restarted(one: TracedRecording, log: Log, rng: np.random.Generator) -> TracedRecording:
    """The counter starts again in the middle of the walk."""
    first = one.packet[one.true_time > 1.0][0]
    late = np.cumsum(one.packet == first) > 0
    return replaced(one, packet=np.where(late, (one.packet - first) % 65536, one.packet))


GYROSCOPE_COLUMNS_EXCHANGED = of(
    "both", exchanged, ["angular_rate"], [1, 0, 2], [2, 1, 0], [0, 2, 1], [1, 2, 0], [2, 0, 1])
DEVICE_STAMPS_ONLY = of("both", unknown, "packet", "position", *ARRIVALS)

WRONG: Mapping[str, Family] = {
    "forward_turned": of("both", declared, "forward_axis"),
    "forward_turned_at_one": of("either", declared, "forward_axis"),
    "up_turned": of("both", declared, "up_axis"),
    "acceleration_turned": of("both", scaled, "acceleration", -1.0),
    "acceleration_turned_at_one": of("either", scaled, "acceleration", -1.0),
    "gyroscope_columns_exchanged": GYROSCOPE_COLUMNS_EXCHANGED,
    "foot_gyroscope_turned": of("foot", scaled, "angular_rate", -1.0),
    "gyroscopes_turned": of("both", scaled, "angular_rate", -1.0),
    "foot_on_outer_leg": on_other_leg("foot"),
    "foot_clock_600_ms_off": of("foot", clock_off, 0.6),
    "foot_clock_1_s_off": of("foot", clock_off, 1.0),
    "foot_clock_5_s_off": of("foot", clock_off, 5.0),
    "foot_clock_60_s_off": of("foot", clock_off, 60.0),
    "foot_of_another_run": foot_of_another_run,
    "foot_of_another_run_on_this_ones_clock": together(foot_of_another_run, of("foot", begun_with_the_hip)),
    "gyroscope_range_halved": of("both", declared, gyroscope_range_deg_s=1000.0),
    "foot_gyroscope_range_halved": of("foot", declared, gyroscope_range_deg_s=1000.0),
    "slope_unknown": slope(lambda written, rng: None),
    "slope_of_another_day": slope(lambda written, rng: written + 4.0 * rng.choice([-1, 1])),
    "one_axis_twice_as_strong": of("either", one_axis_twice_as_strong),
    "nothing_declared_and_gyroscope_columns_exchanged": together(
        of("both", declared, forward_axis=None, up_axis=None), GYROSCOPE_COLUMNS_EXCHANGED),
    "no_stamps": of("both", unknown, "device_stamp", *ARRIVALS, rate_hz=103.0),  # of the data sheet, 3 % off
    "sensors_swapped": sensors_swapped,
}  # fmt: skip
LATER: Mapping[str, Family] = {
    "hip_on_outer_leg": on_other_leg("hip"),
    "left_handed_columns": of("either", exchanged, READINGS, [1, 0, 2], [2, 1, 0], [0, 2, 1]),
    "held_off_the_normal": of("both", held_off_the_normal),
    "stuck_values": of("either", stuck_values),
    "accelerometer_range_narrow": of("foot", ending_at, "acceleration", 1.2),
    "gyroscope_counts_wrap": of("either", wrapping_at, "angular_rate", 110.0),
    "two_trials_in_one": two_trials_in_one,
    "walked_backward": walked_backward,
}
LAST: Mapping[str, Family] = {
    "gyroscope_drifts": of("either", gyroscope_drifts),
    "smoothed_by_the_logger": of("either", filtered, READINGS, means_of_the_last, 13),
    "numbered_after_the_loss": of("both", numbered_after_the_loss),
    "gravity_taken_off": of("either", gravity_taken_off),
    "magnetometer_as_gyroscope": of("either", magnetometer_as_gyroscope),
}
CLOCKS: Mapping[str, Family] = {
    "sent_again": of("both", sent_again),
    "put_on": of("both", set_by, (0.02, 0.4)),
    "set_back": of("both", set_by, (-0.5, -0.5)),
    "set_twice": of("both", set_by, (-0.3, 0.3), (-0.3, 0.3)),
    "no_counter": of("both", unknown, "packet", "position", "device_stamp"),
    "no_counter_but_device_stamps": of("both", unknown, "packet", "position"),
    "device_stamps_only": DEVICE_STAMPS_ONLY,
    "foot_of_another_run_and_device_stamps_only": together(foot_of_another_run, DEVICE_STAMPS_ONLY),
    "server_stamps_only": of("both", unknown, "phone_stamp"),
    "eight_bit_counter": of("both", eight_bit_counter),
    "restarted": of("either", restarted),
}
SILENT: Mapping[str, Family] = {
    "gyroscopes_5_percent_off": of("both", scaled, "angular_rate", 0.95, 1.05),
    "gyroscopes_10_percent_off": of("both", scaled, "angular_rate", 0.90, 1.10),
    "one_gyroscope_12_percent_off": of("either", scaled, "angular_rate", 0.88, 1.12),
    "smoothed_at_5_hz": of("both", filtered, READINGS, low_passed, 5.0),
    "smoothed_at_10_hz": of("both", filtered, READINGS, low_passed, 10.0),
    "smoothed_at_20_hz": of("both", filtered, READINGS, low_passed, 20.0),
    "one_smoothed_at_10_hz": of("either", filtered, READINGS, low_passed, 10.0),
    "resampled_by_60_hz": of("both", filtered, READINGS, resampled, 60.0),
    "resampled_by_35_hz": of("both", filtered, READINGS, resampled, 35.0),
    "averaged_over_3_rows": of("both", filtered, READINGS, uniform_filter1d, 3, 0),
    "accelerometers_wrap_at_2_g": of("both", wrapping_at, "acceleration", 2.0),
    "accelerometers_end_at_2_g": of("both", ending_at, "acceleration", 2.0),
    "packets_lost_at_strikes": of("both", packets_lost_at_strikes),
    "set_an_hour_on": of("both", set_by, (3600.0, 3600.0)),
    "set_an_hour_back": of("both", set_by, (-3600.0, -3600.0)),
    "set_a_second_on": of("both", set_by, (1.0, 1.0)),
    "gyroscopes_follow_their_zero": of("both", filtered, ["angular_rate"], less_a_running_mean),
    "gyroscopes_quiet_below_3_deg_s": of("both", gyroscopes_quiet_below_3_deg_s),
    "gyroscopes_less_their_mean": of("both", filtered, ["angular_rate"], less_the_mean),
    "slope_in_radians": slope(lambda written, rng: float(np.radians(written))),
    "foot_sensor_turned_20_degrees": of("foot", knocked, 20.0, 20.0),
    "knocked": of("either", knocked, 5.0, 10.0),
    "accelerometers_four_fifths": of("both", scaled, "acceleration", 0.8),
    "one_accelerometer_four_fifths": of("either", scaled, "acceleration", 0.8),
    "gyroscopes_30_ms_late": of("both", filtered, ["angular_rate"], three_rows_late),
    "spikes": of("both", spikes),
}
