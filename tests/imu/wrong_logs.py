"""Families of logs that are wrong in one way: each takes a good log and a generator, and gives what a lab then has.

`WRONG` are the families named from outside and some of our own, by which the limits were chosen; `LATER` were written
and first run when the limits stood, `LAST` when `LATER` had been answered; `CLOCKS` do it to the clocks alone.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation

from stages.campaign.twin_run import TwinRun
from tests.imu.made_logs import Log, TracedRecording, device_of, made_log, on_outer_leg, replaced

#: Makes a wrong log of a good one; the walks are all of the campaign's, by number.
Family = Callable[[Log, Sequence[TwinRun], np.random.Generator], Log]
PLACES = ("hip", "foot")
TURNED = {"+": "-", "-": "+"}


def _other_way(axis: str | None) -> str:
    assert axis is not None
    return TURNED[axis[0]] + axis[1]


def _declared(log: Log, key: str, *places: str) -> Log:
    for place in places:
        log = log.on_device(place, **{key: _other_way(getattr(device_of(log, place), key))})
    return log


def forward_turned(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _declared(log, "forward_axis", *PLACES)


def forward_turned_at_one(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _declared(log, "forward_axis", PLACES[rng.integers(2)])


def up_turned(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _declared(log, "up_axis", *PLACES)


def _acceleration_turned(one: TracedRecording) -> TracedRecording:
    return replaced(one, acceleration=-one.acceleration)


def acceleration_turned(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return log.changed("both", _acceleration_turned)


def acceleration_turned_at_one(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return log.changed(PLACES[rng.integers(2)], _acceleration_turned)


def gyroscope_columns_exchanged(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    order = ([1, 0, 2], [2, 1, 0], [0, 2, 1], [1, 2, 0], [2, 0, 1])[rng.integers(5)]
    return log.changed("both", lambda one: replaced(one, angular_rate=one.angular_rate[:, order]))


def foot_gyroscope_turned(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return log.changed("foot", lambda one: replaced(one, angular_rate=-one.angular_rate))


def gyroscopes_turned(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return log.changed("both", lambda one: replaced(one, angular_rate=-one.angular_rate))


def foot_on_outer_leg(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    walked = walks[log.number]
    motions = {"hip": walked.hip, "foot": on_outer_leg(walked.foot, walked)}
    return made_log(log.number, walked, log.parameters, motions)


def _foot_late(log: Log, by: float) -> Log:
    return log.changed(
        "foot", lambda one: replaced(one, phone_stamp=one.phone_stamp + by, server_stamp=one.server_stamp + by)
    )


def foot_clock_600_ms_off(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _foot_late(log, 0.6 * rng.choice([-1, 1]))


def foot_clock_1_s_off(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _foot_late(log, 1.0 * rng.choice([-1, 1]))


def foot_clock_5_s_off(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _foot_late(log, 5.0 * rng.choice([-1, 1]))


def foot_clock_60_s_off(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _foot_late(log, 60.0 * rng.choice([-1, 1]))


def foot_of_another_run(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """Another run's foot, its stamps as they are: minutes away."""
    other = (log.number + int(rng.integers(1, len(walks)))) % len(walks)
    foreign = made_log(other, walks[other], log.parameters)
    foot = next(one for one in foreign.recordings if one.device.place == "foot")
    motions, rotations = {**log.motions, "foot": foreign.motions["foot"]}, {**log.rotations,
                                                                           "foot": foreign.rotations["foot"]}
    return dataclasses.replace(log, recordings=(log.recordings[0], foot), motions=motions, rotations=rotations)


def foot_of_another_run_on_this_ones_clock(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """Another run's foot whose stamps were made to begin with the hip's."""
    made = foot_of_another_run(log, walks, rng)
    by = made.recordings[0].phone_stamp[0] - made.recordings[1].phone_stamp[0]
    return _foot_late(made, float(by))


def gyroscope_range_halved(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    for place in PLACES:
        log = log.on_device(place, gyroscope_range_deg_s=1000.0)
    return log


def foot_gyroscope_range_halved(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return log.on_device("foot", gyroscope_range_deg_s=1000.0)


def slope_unknown(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    unknown = dataclasses.replace(log.experiment, slope_deg=None)
    made = log.changed("both", lambda one: replaced(one, experiment=unknown))
    return dataclasses.replace(made, experiment=unknown)


# Our own, by which limits were chosen.


def slope_of_another_day(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The inclination was changed by 4 degrees and not written down."""
    other = dataclasses.replace(log.experiment, slope_deg=(log.experiment.slope_deg or 0.0) + 4.0 * rng.choice([-1, 1]))
    made = log.changed("both", lambda one: replaced(one, experiment=other))
    return dataclasses.replace(made, experiment=other)


def one_axis_twice_as_strong(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """An accelerometer axis across gravity, forward, with another range than the others."""
    place = PLACES[rng.integers(2)]
    said = device_of(log, place).forward_axis
    assert said is not None
    gain = np.where(np.arange(3) == "xyz".index(said[1]), 2.0, 1.0)
    return log.changed(place, lambda one: replaced(one, acceleration=one.acceleration * gain))


def nothing_declared_and_gyroscope_columns_exchanged(
    log: Log, walks: Sequence[TwinRun], rng: np.random.Generator
) -> Log:
    for place in PLACES:
        log = log.on_device(place, forward_axis=None, up_axis=None)
    return gyroscope_columns_exchanged(log, walks, rng)


def no_stamps(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The rate is taken from the data sheet, and is 3 % off."""
    log = log.on_device("hip", rate_hz=103.0).on_device("foot", rate_hz=103.0)

    def blind(one: TracedRecording) -> TracedRecording:
        none = np.full(one.rows, np.nan)
        return replaced(one, device_stamp=none, phone_stamp=none, server_stamp=none)

    return log.changed("both", blind)


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


WRONG: tuple[Family, ...] = (
    forward_turned,
    forward_turned_at_one,
    up_turned,
    acceleration_turned,
    acceleration_turned_at_one,
    gyroscope_columns_exchanged,
    foot_gyroscope_turned,
    gyroscopes_turned,
    foot_on_outer_leg,
    foot_clock_600_ms_off,
    foot_clock_1_s_off,
    foot_clock_5_s_off,
    foot_clock_60_s_off,
    foot_of_another_run,
    foot_of_another_run_on_this_ones_clock,
    gyroscope_range_halved,
    foot_gyroscope_range_halved,
    slope_unknown,
    slope_of_another_day,
    one_axis_twice_as_strong,
    nothing_declared_and_gyroscope_columns_exchanged,
    no_stamps,
    sensors_swapped,
)


# Written when the limits stood.


def hip_on_outer_leg(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """Both sensors ride on the outer leg, which is told as the inner one."""
    walked = walks[log.number]
    motions = {"hip": on_outer_leg(walked.hip, walked), "foot": walked.foot}
    return made_log(log.number, walked, log.parameters, motions)


def left_handed_columns(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """Two axes of accelerometer and gyroscope exchanged alike: a left-handed sensor."""
    order = ([1, 0, 2], [2, 1, 0], [0, 2, 1])[rng.integers(3)]
    return log.changed(
        PLACES[rng.integers(2)],
        lambda one: replaced(one, acceleration=one.acceleration[:, order], angular_rate=one.angular_rate[:, order]),
    )


def held_off_the_normal(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The legs were held 6 degrees from where the settings say: in the sensors' frames, both sensors alike."""
    turn = Rotation.from_rotvec([0, 0, np.radians(6.0 * rng.choice([-1, 1]))]).as_matrix()
    still = log.recordings[0].true_time.min() + log.parameters.runs.rest_s - 0.1

    def held(one: TracedRecording) -> TracedRecording:
        rotation = log.rotations[one.device.place]
        resting = one.true_time < still
        turned = one.acceleration @ rotation.T @ turn.T @ rotation
        return replaced(one, acceleration=np.where(resting[:, None], turned, one.acceleration))

    return log.changed("both", held)


def stuck_values(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The gyroscope repeats its last reading through a second of the walk."""
    place = PLACES[rng.integers(2)]

    def stuck(one: TracedRecording) -> TracedRecording:
        start = float(rng.uniform(1.0, 3.5))
        inside = np.flatnonzero((one.true_time >= start) & (one.true_time < start + 1.0))
        rate = one.angular_rate.copy()
        rate[inside] = rate[inside[0]]
        return replaced(one, angular_rate=rate)

    return log.changed(place, stuck)


def accelerometer_range_narrow(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The foot's readings end at 1.2 g, though 4 g are declared."""
    full = log.parameters.sensor.accelerometer_range_g
    limit = 1.2 / full * 2 ** (log.parameters.sensor.bits - 1)
    return log.changed("foot", lambda one: replaced(one, acceleration=np.clip(one.acceleration, -limit, limit)))


def gyroscope_counts_wrap(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """Beyond 110 deg/s a count starts again at the other end of the range."""
    full = 110.0 / log.parameters.sensor.gyroscope_range_deg_s * 2 ** (log.parameters.sensor.bits - 1)
    place = PLACES[rng.integers(2)]
    return log.changed(
        place, lambda one: replaced(one, angular_rate=(one.angular_rate + full) % (2 * full) - full)
    )


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


LATER: tuple[Family, ...] = (
    hip_on_outer_leg,
    left_handed_columns,
    held_off_the_normal,
    stuck_values,
    accelerometer_range_narrow,
    gyroscope_counts_wrap,
    two_trials_in_one,
    walked_backward,
)


# Clocks.


def gyroscope_drifts(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """One gyroscope warms up: 4 deg/s more on each axis by the end, from the still stand on."""
    full = log.parameters.sensor.gyroscope_range_deg_s
    by = 4.0 / full * 2 ** (log.parameters.sensor.bits - 1)

    def drifted(one: TracedRecording) -> TracedRecording:
        share = np.clip((one.true_time + 0.5) / (one.true_time.max() + 0.5), 0.0, 1.0)
        return replaced(one, angular_rate=one.angular_rate + by * share[:, None])

    return log.changed(PLACES[rng.integers(2)], drifted)


def smoothed_by_the_logger(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """One sensor's readings are means of the last 13 rows."""

    def smoothed(one: TracedRecording) -> TracedRecording:
        def mean(values: np.ndarray) -> np.ndarray:
            return np.array([values[max(0, row - 12) : row + 1].mean(axis=0) for row in range(len(values))])

        return replaced(one, acceleration=mean(one.acceleration), angular_rate=mean(one.angular_rate))

    return log.changed(PLACES[rng.integers(2)], smoothed)


def numbered_after_the_loss(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The phone numbers the packets that arrived: a tenth was lost before, and nothing shows it."""

    def renumbered(one: TracedRecording) -> TracedRecording:
        packets = np.unique(one.packet)
        kept = packets[rng.random(len(packets)) > 0.1]
        left = one.take(np.isin(one.packet, kept))
        assert isinstance(left, TracedRecording)
        return replaced(left, packet=np.searchsorted(kept, left.packet).astype(float),
                        device_stamp=np.full(left.rows, np.nan))  # fmt: skip

    return log.changed("both", renumbered)


def gravity_taken_off(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """One sensor's export is a phone's linear acceleration: the stand's mean is taken off."""
    still = log.recordings[0].true_time.min() + log.parameters.runs.rest_s - 0.1

    def taken(one: TracedRecording) -> TracedRecording:
        return replaced(one, acceleration=one.acceleration - one.acceleration[one.true_time < still].mean(axis=0))

    return log.changed(PLACES[rng.integers(2)], taken)


def magnetometer_as_gyroscope(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The columns mapped as one gyroscope are a magnetometer's: the earth's field, turning with the leg."""
    place = PLACES[rng.integers(2)]
    motion = log.motions[place]
    turned = np.concatenate([[0.0], np.cumsum(np.diff(motion.time) * motion.angular_velocity[:-1, 2])])
    heading = rng.uniform(0, 2 * np.pi)
    north, up = 20.0 * np.cos(heading), 45.0

    def field(one: TracedRecording) -> TracedRecording:
        angle = np.interp(one.true_time, motion.time, turned)
        c, s = np.cos(angle), np.sin(angle)
        across = np.full(len(angle), 20.0 * np.sin(heading))
        on_body = np.column_stack((c * north + s * up, c * up - s * north, across))
        counts = 10.0 * (on_body @ log.rotations[place]) + rng.normal(scale=3.0, size=on_body.shape)
        return replaced(one, angular_rate=np.rint(counts))

    return log.changed(place, field)


LAST: tuple[Family, ...] = (
    gyroscope_drifts,
    smoothed_by_the_logger,
    numbered_after_the_loss,
    gravity_taken_off,
    magnetometer_as_gyroscope,
)


def _set_by(log: Log, *sizes: float) -> Log:
    """The phone's clock is set by so much [s], evenly over the run; both sensors' packets bear it."""
    starts = [one.phone_stamp.min() for one in log.recordings]
    ends = [one.phone_stamp.max() for one in log.recordings]
    when = [min(starts) + (max(ends) - min(starts)) * (i + 1) / (len(sizes) + 1) for i in range(len(sizes))]

    def put(one: TracedRecording) -> TracedRecording:
        moved = sum((size * (one.phone_stamp >= at) for size, at in zip(sizes, when)), np.zeros(one.rows))
        return replaced(one, phone_stamp=one.phone_stamp + moved, server_stamp=one.server_stamp + moved)

    return log.changed("both", put)


def sent_again(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """A tenth of the packets arrives a second time, .1 to 2 s later, in blocks."""

    def again(one: TracedRecording) -> TracedRecording:
        count = one.rows // 3
        first = rng.integers(0, count - 12, max(1, count // 100))
        rows = np.unique((first[:, None] + np.arange(10)).ravel())
        rows = (3 * rows[:, None] + np.arange(3)).ravel()
        late = np.repeat(rng.uniform(0.1, 2.0, len(first)).max(), len(rows))
        stamp = np.append(one.phone_stamp, one.phone_stamp[rows] + late)
        order = np.argsort(stamp, kind="stable")
        longer = one.take(np.append(np.arange(one.rows), rows)[order])
        return replaced(longer, phone_stamp=stamp[order], server_stamp=stamp[order])

    return log.changed("both", again)


def put_on(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _set_by(log, float(rng.uniform(0.02, 0.4)))


def set_back(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _set_by(log, -0.5)


def set_twice(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _set_by(log, *(float(size) for size in rng.uniform(-0.3, 0.3, 2)))


def no_counter(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """Phone stamps and losses, and nothing that numbers the samples."""

    def blind(one: TracedRecording) -> TracedRecording:
        none = np.full(one.rows, np.nan)
        return replaced(one, packet=none, position=none, device_stamp=none)

    return log.changed("both", blind)


def no_counter_but_device_stamps(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    def blind(one: TracedRecording) -> TracedRecording:
        none = np.full(one.rows, np.nan)
        return replaced(one, packet=none, position=none)

    return log.changed("both", blind)


def device_stamps_only(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    def blind(one: TracedRecording) -> TracedRecording:
        none = np.full(one.rows, np.nan)
        return replaced(one, packet=none, position=none, phone_stamp=none, server_stamp=none)

    return log.changed("both", blind)


def foot_of_another_run_and_device_stamps_only(
    log: Log, walks: Sequence[TwinRun], rng: np.random.Generator
) -> Log:
    return device_stamps_only(foot_of_another_run(log, walks, rng), walks, rng)


def server_stamps_only(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return log.changed("both", lambda one: replaced(one, phone_stamp=np.full(one.rows, np.nan)))


def eight_bit_counter(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    log = log.on_device("hip", counter_modulus=256).on_device("foot", counter_modulus=256)
    return log.changed("both", lambda one: replaced(one, packet=one.packet % 256))


def restarted(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The counter starts again in the middle of the walk."""

    def again(one: TracedRecording) -> TracedRecording:
        first = one.packet[one.true_time > 1.0][0]
        late = np.cumsum(one.packet == first) > 0
        return replaced(one, packet=np.where(late, (one.packet - first) % 65536, one.packet))

    return log.changed(PLACES[rng.integers(2)], again)


CLOCKS: tuple[Family, ...] = (
    sent_again,
    put_on,
    set_back,
    set_twice,
    no_counter,
    no_counter_but_device_stamps,
    device_stamps_only,
    foot_of_another_run_and_device_stamps_only,
    server_stamps_only,
    eight_bit_counter,
    restarted,
)


# What passed without a word until rules were added that are derived: not chosen on these.


def _read_otherwise(log: Log, change: Callable[[np.ndarray], np.ndarray], *places: str) -> Log:
    """Both readings of these places' sensors changed row by row, as numbers in the order of sampling."""

    def changed(one: TracedRecording) -> TracedRecording:
        order = np.argsort(one.true_time, kind="stable")
        made = {}
        for name in ("acceleration", "angular_rate"):
            values = getattr(one, name).copy()
            values[order] = np.rint(change(values[order]))
            made[name] = values
        return replaced(one, **made)

    for place in places:
        log = log.changed(place, changed)
    return log


def _gyroscopes_times(log: Log, factor: float, *places: str) -> Log:
    for place in places:
        log = log.changed(place, lambda one: replaced(one, angular_rate=np.rint(one.angular_rate * factor)))
    return log


def gyroscopes_5_percent_off(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _gyroscopes_times(log, 1 + 0.05 * rng.choice([-1, 1]), *PLACES)


def gyroscopes_10_percent_off(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _gyroscopes_times(log, 1 + 0.10 * rng.choice([-1, 1]), *PLACES)


def one_gyroscope_12_percent_off(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _gyroscopes_times(log, 1 + 0.12 * rng.choice([-1, 1]), PLACES[rng.integers(2)])


def _low_passed(cut_off_hz: float) -> Callable[[np.ndarray], np.ndarray]:
    sections = butter(2, cut_off_hz, fs=100.0, output="sos")
    return lambda values: np.asarray(sosfiltfilt(sections, values, axis=0))


def smoothed_at_5_hz(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """Both sensors' readings through a low pass in both directions."""
    return _read_otherwise(log, _low_passed(5.0), *PLACES)


def smoothed_at_10_hz(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _read_otherwise(log, _low_passed(10.0), *PLACES)


def smoothed_at_20_hz(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _read_otherwise(log, _low_passed(20.0), *PLACES)


def one_smoothed_at_10_hz(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _read_otherwise(log, _low_passed(10.0), PLACES[rng.integers(2)])


def _resampled(rate_hz: float) -> Callable[[np.ndarray], np.ndarray]:
    def there_and_back(values: np.ndarray) -> np.ndarray:
        row = np.arange(len(values)) / 100.0
        at = np.arange(0.0, row[-1] + 1 / rate_hz, 1 / rate_hz)
        return np.column_stack([np.interp(row, at, np.interp(at, row, axis)) for axis in values.T])

    return there_and_back


def resampled_by_60_hz(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The logger keeps 60 rows a second, and writes 100."""
    return _read_otherwise(log, _resampled(60.0), *PLACES)


def resampled_by_35_hz(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _read_otherwise(log, _resampled(35.0), *PLACES)


def averaged_over_3_rows(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _read_otherwise(log, lambda values: uniform_filter1d(values, 3, axis=0), *PLACES)


def _at_2_g(log: Log, change: Callable[[np.ndarray, float], np.ndarray], *places: str) -> Log:
    full = 2.0 / log.parameters.sensor.accelerometer_range_g * 2 ** (log.parameters.sensor.bits - 1)
    for place in places:
        log = log.changed(place, lambda one: replaced(one, acceleration=change(one.acceleration, full)))
    return log


def accelerometers_wrap_at_2_g(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _at_2_g(log, lambda values, full: (values + full) % (2 * full) - full, *PLACES)


def accelerometers_end_at_2_g(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _at_2_g(log, lambda values, full: np.clip(values, -full, full - 1), *PLACES)


def packets_lost_at_strikes(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The antenna is shaken: what was sampled 25 ms round a strike is lost, with its packet."""

    def lost(one: TracedRecording) -> TracedRecording:
        near = np.abs(one.true_time[:, None] - log.strike_time).min(axis=1) < 0.025
        left = one.take(~np.isin(one.packet, one.packet[near]))
        assert isinstance(left, TracedRecording)
        return left

    return log.changed("both", lost)


def set_an_hour_on(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _set_by(log, 3600.0)


def set_an_hour_back(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _set_by(log, -3600.0)


def set_a_second_on(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _set_by(log, 1.0)


def gyroscopes_follow_their_zero(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The firmware takes a running mean of 1 s off the rates: what it thinks their zero."""

    def zeroed(one: TracedRecording) -> TracedRecording:
        order = np.argsort(one.true_time, kind="stable")
        values = one.angular_rate.copy()
        level, mean = 0.01, values[order[:50]].mean(axis=0)
        for row in order:
            mean = mean + level * (one.angular_rate[row] - mean)
            values[row] = np.rint(one.angular_rate[row] - mean)
        return replaced(one, angular_rate=values)

    return log.changed("both", zeroed)


def gyroscopes_quiet_below_3_deg_s(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The firmware writes 0 for what it takes for noise."""
    least = 3.0 / log.parameters.sensor.gyroscope_range_deg_s * 2 ** (log.parameters.sensor.bits - 1)
    return log.changed("both", lambda one: replaced(
        one, angular_rate=np.where(np.abs(one.angular_rate) < least, 0.0, one.angular_rate)))  # fmt: skip


def gyroscopes_less_their_mean(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return log.changed("both", lambda one: replaced(one, angular_rate=np.rint(
        one.angular_rate - one.angular_rate.mean(axis=0))))  # fmt: skip


def slope_in_radians(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    other = dataclasses.replace(log.experiment, slope_deg=float(np.radians(log.experiment.slope_deg or 0.0)))
    made = log.changed("both", lambda one: replaced(one, experiment=other))
    return dataclasses.replace(made, experiment=other)


def _turned(log: Log, place: str, degrees: float, rng: np.random.Generator) -> Log:
    """A sensor turned on its leg in the middle of the walk, about any axis."""
    axis = rng.normal(size=3)
    turn = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis)).as_matrix()
    middle = float(np.median(log.strike_time))

    def moved(one: TracedRecording) -> TracedRecording:
        late = (one.true_time > middle)[:, None]
        return replaced(one, acceleration=np.where(late, np.rint(one.acceleration @ turn), one.acceleration),
                        angular_rate=np.where(late, np.rint(one.angular_rate @ turn), one.angular_rate))  # fmt: skip

    return log.changed(place, moved)


def foot_sensor_turned_20_degrees(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _turned(log, "foot", 20.0, rng)


def knocked(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return _turned(log, PLACES[rng.integers(2)], float(rng.uniform(5.0, 10.0)), rng)


def accelerometers_four_fifths(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return log.changed("both", lambda one: replaced(one, acceleration=np.rint(0.8 * one.acceleration)))


def one_accelerometer_four_fifths(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    return log.changed(
        PLACES[rng.integers(2)], lambda one: replaced(one, acceleration=np.rint(0.8 * one.acceleration)))


def gyroscopes_30_ms_late(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """The gyroscopes' columns are three rows behind the accelerometers'."""

    def late(one: TracedRecording) -> TracedRecording:
        order = np.argsort(one.true_time, kind="stable")
        values = one.angular_rate.copy()
        values[order[3:]] = one.angular_rate[order[:-3]]
        return replaced(one, angular_rate=values)

    return log.changed("both", late)


def spikes(log: Log, walks: Sequence[TwinRun], rng: np.random.Generator) -> Log:
    """Half a percent of the readings are any number of the range."""
    largest = 2 ** (log.parameters.sensor.bits - 1)

    def struck(values: np.ndarray) -> np.ndarray:
        return np.where(rng.random(values.shape) < 0.005, rng.uniform(-largest, largest, values.shape), values)

    return _read_otherwise(log, struck, *PLACES)


SILENT: tuple[Family, ...] = (
    gyroscopes_5_percent_off,
    gyroscopes_10_percent_off,
    one_gyroscope_12_percent_off,
    smoothed_at_5_hz,
    smoothed_at_10_hz,
    smoothed_at_20_hz,
    one_smoothed_at_10_hz,
    resampled_by_60_hz,
    resampled_by_35_hz,
    averaged_over_3_rows,
    accelerometers_wrap_at_2_g,
    accelerometers_end_at_2_g,
    packets_lost_at_strikes,
    set_an_hour_on,
    set_an_hour_back,
    set_a_second_on,
    gyroscopes_follow_their_zero,
    gyroscopes_quiet_below_3_deg_s,
    gyroscopes_less_their_mean,
    slope_in_radians,
    foot_sensor_turned_20_degrees,
    knocked,
    accelerometers_four_fifths,
    one_accelerometer_four_fifths,
    gyroscopes_30_ms_late,
    spikes,
)
