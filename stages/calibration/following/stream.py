"""Rows of a hip and a foot sensor as they come: read, brought to body axes and to one clock, and followed.

The ingest's own functions find from the first steps how the sensors sit, by a still stand before them, how their clocks
stand to each other, and the heel strikes. From then on all that is a line of numbers for each row. It is said in the
first answer; given it, a stream that was broken off is taken up again without a still stand.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.model.walker import Vector
from stages.biped.quantity import count_of
from stages.biped.question import WrongOption, refuse
from stages.calibration.estimation.least_squares import NotIdentified
from stages.calibration.following.follower import Follower
from stages.calibration.following.present import Instant
from stages.calibration.following.robot_file import plain_of
from stages.calibration.following.step import Sample
from stages.calibration.following.track import Track
from stages.calibration.observation.measured_run import SIDES
from stages.calibration.parameters import Parameters
from stages.calibration.recordings import FEWEST_STRIKES, FROM, measured
from stages.imu.sources.cells import device_from_row, recording_from_columns
from stages.imu.sources.column_map import Where, device_of, experiment_of, mapping_of, spelt
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.schema import SAMPLE_VALUES, Device, Experiment, Recording
from stages.imu.trial.body import FORWARD, LATERAL, UP, BodySensor, Frame
from stages.imu.trial.sensor import trace_sensor
from stages.imu.trial.trial import read_sensor
from stages.imu.trial.two_clocks import brought_together
from stages.imu.trial.walk import strikes_of

STAMP = "device_stamp"
READINGS = SAMPLE_VALUES[-6:]
#: The beginning of a stream is looked at each so many seconds, and given up after so many.
EACH_S, LONGEST_S = 1.0, 120.0
#: So many rows of a sensor in a row that are before its last one are a clock that was set back. A row that is as far
#: ahead waits for the next one: its stamp is wrong where that one is before it.
SET_BACK = 20
#: A row so many sampling periods after the last one shows that rows are lost, so many of one sensor alone that the
#: other is silent, and so many lines without a row that no more will come.
LOST, SILENT = 1.5, 100


@dataclass(frozen=True)
class Mounted:
    """How a sensor's rows become samples on body axes: `rotation` (3, 3) from its own, which has `bias` (3,) [rad/s],
    and its `stamp` [s] at a time of zero, after which a second is so `long`."""

    rotation: np.ndarray
    bias: Vector
    stamp: float
    long: float

    @classmethod
    def of(cls, plain: Any, where: str) -> Mounted:
        """That of `plain`. Raises SourceRefused, naming `where` it stands."""
        try:
            return cls(np.array(plain["rotation"], dtype=float).reshape(3, 3),
                       np.array(plain["bias"], dtype=float).reshape(3), float(plain["stamp"]), float(plain["long"]))
        except (KeyError, TypeError, ValueError):
            raise SourceRefused(f"{where}: needs rotation of 3 rows of 3 numbers, bias of 3, stamp and long, as the "
                                "first answer has them") from None

    def sample(self, row: Sample, scales: tuple[float, float], begin: float) -> Sample:
        """A row of `rows_of` as readings (3,) on body axes, counted from the time `begin` [s]."""
        force, rate = row.reading[:3] * scales[0], row.reading[3:] * scales[1]
        force, rate = self.rotation @ force, self.rotation @ (rate - self.bias)
        reading = np.array([force[FORWARD], force[UP], rate[LATERAL]])
        used = np.isfinite(reading)
        return Sample((row.time - self.stamp) * self.long - begin, row.side, np.where(used, reading, 0.0), used)


def rows_of(lines: Iterable[str], note: Callable[[str], None], periods: Mapping[str, float]) -> Iterator[Sample]:
    """Rows of CSV lines, the first of which names the columns in any order; what is wrong is passed over, said once.

    Readings (6,) are in the device's units, at its stamps [s]; NaN where there is none.

    `periods` [s] are the sampling periods by place. Raises WrongOption where columns are missing, StepFailed where a
    clock is set back, or no more rows come.
    """
    given, said = iter(lines), set[str]()
    names = _cells(next(given, "").removeprefix("\ufeff"))
    missing = [name for name in ("place", STAMP, *READINGS) if name not in names]
    refuse((bool(missing), f"-: the first line names the columns and lacks {', '.join(missing)}"))
    last, behind = dict.fromkeys(periods, -math.inf), {side: list[float]() for side in periods}
    before, alone, doubted = "", 0, dict[str, Sample]()

    def once(what: str, line: int) -> None:
        if what not in said:
            said.add(what)
            note(f"note: line {line}: {what}; this is said once")

    for line, row in _read(given, names, periods, once):
        side, jumped = row.side, doubted.pop(row.side, None)
        if jumped is not None and row.time < jumped.time:
            ahead = f"{jumped.time - row.time:.3g} s"
            once(f"the row of the {side} before it is stamped {ahead} later, and passed over", line)
        elif jumped is not None:
            last[side] = jumped.time
            yield jumped
        since = row.time - last[side]
        behind[side] = [*behind[side], since] if since < 0.0 else []
        if len(behind[side]) >= SET_BACK:
            raise StepFailed(f"the clock of the {side} was set back by {-min(behind[side]):.3g} s")
        if since <= 0.0:
            once(f"{'given twice' if since == 0.0 else 'later than the one after it'}, and passed over", line)
            continue
        if LOST * periods[side] < since < math.inf:
            many = 10 ** int(math.log10(since / periods[side]))
            once(f"{many} or more rows of the {side} before it are lost, or its clock was set", line)
        if since > SET_BACK * periods[side]:
            doubted[side] = row
            continue
        last[side] = row.time
        before, alone = side, alone + 1 if side == before else 1
        if alone == SILENT:
            once(f"the last {SILENT} rows are all of the {side}: the other sensor is silent", line)
        yield row
    yield from doubted.values()


def _read(
    given: Iterable[str], names: Sequence[str], sides: Collection[str], once: Callable[[str, int], None]
) -> Iterator[tuple[int, Sample]]:
    """The rows in lines of CSV, each with its line's number; what is none is passed over. Raises StepFailed where no
    more come."""
    unread, what = 0, f"of {' or '.join(sides)} with numbers"
    for line, text in enumerate(given, 2):
        row = _row(text, names, sides)
        unread = 0 if row else unread + 1
        if row:
            yield line, row
        else:
            once(f"not a row {what}, and passed over", line)
        if unread == SILENT:
            raise StepFailed(f"the last {SILENT} lines are no rows {what}")


def _row(text: str, names: Sequence[str], sides: Collection[str]) -> Sample | None:
    """The row in a line of CSV with columns of these names; None without numbers, or of none of the `sides`."""
    cells = _cells(text)
    row = dict(zip(names, cells)) if len(cells) == len(names) else {}
    side = row.get("place", "").lower()
    stamp, *readings = ((_number(row[name]) for name in (STAMP, *READINGS)) if side in sides else (None,))
    if stamp is None or None in readings or not math.isfinite(stamp):
        return None
    values = np.array(readings, dtype=float)
    return Sample(stamp, side, values, np.isfinite(values))


def _cells(text: str) -> list[str]:
    """The cells of a line of CSV, without quotes around them; none of a line that is no such."""
    try:
        return [cell.strip() for cell in next(csv.reader([text], skipinitialspace=True), [])]
    except csv.Error:
        return []


def _number(cell: str) -> float | None:
    """The number in a cell, NaN of an empty one; None of a word."""
    try:
        return float(cell) if cell else math.nan
    except ValueError:
        return None


class Stream:
    """Rows that are followed by `follower`; `about` them as `--with` has it: `experiment`, `devices`, `mounting`.

    Raises WrongOption.
    """

    def __init__(self, follower: Follower, about: Mapping[str, Any], parameters: Parameters) -> None:
        self._follower, self._parameters, self._ingest = follower, parameters, parameters.ingest
        sensor = parameters.sensor
        usual = {"rate_hz": sensor.rate_hz, "bandwidth_hz": sensor.bandwidth_hz, "accelerometer_unit": "m/s^2",
                 "gyroscope_unit": "rad/s"}  # fmt: skip
        where: Where = getattr(about, "place", spelt)
        try:
            mapping_of(about, where, {"experiment", "devices", "mounting"})
            self.experiment: Experiment = experiment_of(about.get("experiment") or {}, partial(where, "experiment"))
            self.devices: dict[str, Device] = {
                side: device_from_row({**usual, "place": side}, "campaign.yaml") for side in SIDES}
            devices = about.get("devices") or ()
            refuse((not isinstance(devices, list | tuple), f"{where('devices')}: must be a list of devices"))
            for number, one in enumerate(devices):
                beside = partial(where, "devices", number)
                device = device_of({**usual, **mapping_of(one, beside)}, beside)
                refuse((device.place not in SIDES, f"{beside('place')} is {device.place}, must be hip or foot"))
                self.devices[device.place] = device
            mounting = mapping_of(about.get("mounting") or {}, partial(where, "mounting"), {*SIDES})
            refuse((len(mounting) == 1, f"{where('mounting')}: needs both hip and foot, or neither"))
            self.mounted = {side: Mounted.of(one, where("mounting", side)) for side, one in mounting.items()}
        except (SourceRefused, WrongOption) as wrong:
            raise WrongOption(f"--with: {wrong}") from None
        self._rows: list[Sample] = []
        self._first = dict[str, float]()
        self._tried, self._why = -math.inf, "there are no rows of the hip"
        self._track: Track | None = None
        self._begin = 0.0

    def about(self) -> dict[str, Any]:
        """What is known of the rows, once they are followed, as `--with` takes it."""
        return {"experiment": plain_of(self.experiment), "devices": [*map(plain_of, self.devices.values())],
                "mounting": {side: plain_of(one) for side, one in self.mounted.items()}}

    @property
    def periods(self) -> dict[str, float]:
        """Sampling periods [s] by side."""
        return {side: 1.0 / device.rate_hz for side, device in self.devices.items()}

    def follow(self, rows: Iterable[Sample]) -> Iterator[Instant]:
        """What is known at the stamp of each row of the hip, by its clock, once it walks.

        Raises NotIdentified where it is not found to walk, StepFailed where it is lost.
        """
        for row in rows:
            if self._track is None:
                self._rows.append(row)
                yield from self._try(row.time) if row.side == SIDES[0] else ()
                if self._track is None and row.time > self._first.setdefault(row.side, row.time) + LONGEST_S:
                    raise NotIdentified(f"no walk is found in {LONGEST_S:.0f} s: {self._why}")
            else:
                yield from self._followed(row)
        if self._track is None:
            raise NotIdentified(f"the rows end before a walk is found: {self._why}")

    def _followed(self, row: Sample) -> Iterator[Instant]:
        assert self._track is not None
        mounted = self.mounted[row.side]
        for instant in self._track.take(mounted.sample(row, self._scales[row.side], self._begin)):
            yield replace(instant, time=row.time, strike=row.time + (instant.strike - instant.time) / mounted.long)

    def _try(self, stamp: float) -> Iterator[Instant]:
        """Look whether the rows so far are a walk, each second; then follow them."""
        if stamp < self._tried + EACH_S:
            return
        self._tried = stamp
        try:
            self._start()
        except (SourceRefused, StepFailed) as why:
            self._why = str(why)
            return
        rows, self._rows = self._rows, []
        for row in rows:
            yield from self._followed(row)

    def _start(self) -> None:
        """Find the mounting, unless it is known, and the last heel strikes. Raises SourceRefused, StepFailed."""
        recordings = {side: self._recording(side) for side in SIDES}
        known = {side: self._known(recordings[side]) for side in SIDES} if self.mounted else self._found(recordings)
        strikes, _ = strikes_of(known, self._ingest.settings, self._ingest.quick)
        if len(strikes.time) < FEWEST_STRIKES + FROM:
            raise StepFailed(f"there are {len(strikes.time)} heel strikes, {FEWEST_STRIKES + FROM} are needed")
        keep = slice(-FEWEST_STRIKES, None)
        run = measured("-", known, strikes.time[keep], strikes.leg[keep], self.experiment.slope_deg,
                       self._follower.design, self._follower.model.layout, self._parameters.settings,
                       self._ingest.limits.lever_arm)  # fmt: skip
        self._begin = float(strikes.time[-FEWEST_STRIKES])
        self.mounted = self.mounted or {side: _mounted(known[side], self._stamps(side)) for side in SIDES}
        self._scales = {side: (one.trace.scale.acceleration, one.trace.scale.angular_rate)
                        for side, one in known.items()}  # fmt: skip
        self._track = Track(self._follower, run, run.sampling.late[SIDES[0]])  # the low pass is behind by that

    def _recording(self, side: str) -> Recording:
        rows = [one for one in self._rows if one.side == side]
        if len(rows) < 10:
            raise StepFailed(f"of the {side} there {'is' if len(rows) == 1 else 'are'} {count_of(len(rows), 'row')}")
        table = np.full((len(rows), len(SAMPLE_VALUES)), np.nan)
        table[:, SAMPLE_VALUES.index(STAMP)] = [one.time for one in rows]
        table[:, -6:] = [one.reading for one in rows]
        return recording_from_columns(self.experiment, self.devices[side], table)

    def _found(self, recordings: Mapping[str, Recording]) -> dict[str, BodySensor]:
        """The sensors as the ingest finds them."""
        found, settings, limits = {}, self._ingest.settings, self._ingest.limits
        for side, recording in recordings.items():
            sensor, _, against = read_sensor(trace_sensor(recording, settings), settings, limits)
            why = next((one.sentence for one in against if one.refused), "no still stand: the frame cannot be found")
            if sensor is None or any(one.refused for one in against):
                raise StepFailed(why)
            found[side] = sensor
        return brought_together(found, settings, limits).sensors

    def _known(self, recording: Recording) -> BodySensor:
        """A sensor whose mounting is known."""
        mounted, trace = self.mounted[recording.device.place], trace_sensor(recording, self._ingest.settings)
        frame, turn = Frame(math.nan, math.nan, math.nan, mounted.rotation), mounted.rotation.T
        time = (self._stamps(recording.device.place) - mounted.stamp) * mounted.long
        return BodySensor(trace, frame, time, trace.specific_force @ turn, (trace.angular_rate - mounted.bias) @ turn)

    def _stamps(self, side: str) -> Vector:
        return np.array([one.time for one in self._rows if one.side == side])


def _mounted(sensor: BodySensor, stamps: Vector) -> Mounted:
    """How a sensor that was found sits, and its clock: a line through the times that its `stamps` (n,) [s] were given.
    """
    first = float(stamps[0])
    long, since = np.polyfit(stamps - first, sensor.time, 1)
    return Mounted(sensor.frame.rotation, sensor.trace.bias(), first - float(since / long), float(long))
