"""Files as loggers and makers' programs write them, made of one synthetic run: heads, and cells by quantity."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone

import numpy as np

G = 9.80665
#: Sample number, time [s], specific force [m/s^2] and rate [rad/s].
Table = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def quantities(table: Table) -> dict[str, Sequence[object]]:
    """What a file's cells may show of each sample."""
    number, time, force, rate = table
    first = datetime(2021, 3, 4, 10, tzinfo=timezone.utc)
    moments = [first + timedelta(seconds=float(one)) for one in time]
    return {
        "n": number, "ticks": 100 * number, "ns": 1_600_000_000_000_000_000 + 10_000_000 * number,
        "s": time, "ms": 1e3 * time, "us": 1e6 * time, "epoch_ms": 1.6e12 + 1e3 * time,
        "sec": 1_600_000_000 + number // 100, "nanosec": 10_000_000 * (number % 100),
        "iso": [one.isoformat() for one in moments],
        "date": [one.strftime("%Y-%m-%d %H:%M:%S.%f")[:-3] for one in moments],
        "a": force, "a_zyx": force[:, ::-1], "g": force / G, "mg": 1e3 * force / G, "cm/s^2": 100 * force,
        "w": rate, "w_zyx": rate[:, ::-1], "deg": np.degrees(rate), "mdps": 1e3 * np.degrees(rate), "mrad": 1e3 * rate,
    }  # fmt: skip


def names(*of: str, axes: str = "XYZ", delimiter: str = ",") -> str:
    """A line of names, of which one with a star stands for three."""
    every = [name.replace("*", axis) for name in of for axis in (axes if "*" in name else axes[:1])]
    return delimiter.join(every)


@dataclass(frozen=True)
class Export:
    """A file: its head, and the cells of each row, each a quantity with its format or what always stands there."""

    head: str
    cells: str
    delimiter: str = ","
    decimal_comma: bool = False
    encoding: str = "utf-8"

    def of(self, table: Table) -> bytes:
        shown = quantities(table)
        columns = []
        for cell in self.cells.split():
            name, _, how = cell.partition(":")
            values = np.array(shown.get(name, [name] * len(table[0]))).reshape(len(table[0]), -1).T
            columns += [[format(one, how or ("" if values.dtype.kind == "U" else ".6f")) for one in each]
                        for each in values]  # fmt: skip
        rows = [self.delimiter.join(row) for row in zip(*columns)]
        if self.decimal_comma:
            rows = [row.replace(".", ",") for row in rows]
        return ("\n".join([self.head, *rows]) + "\n").encode(self.encoding)


SINGLE = "log.csv"
XSENS = "Acquisition frequency: 100 Hz\n" + names("PacketCounter", "Acc_*", "Gyr_*", delimiter="\t") + "\tMag_X"
METAWEAR = "epoc (ms),timestamp (+0000),elapsed (s),"
SHIMMER = names("Timestamp", "Accel_LN_*_CAL", "Gyro_*_CAL", delimiter="\t")
MT_MANAGER = "// General information: \n//  MT Manager version: 2022.2.0 \n//  Update Rate: 100.0 Hz\n"
NORAXON = "Noraxon MyoMotion-Segments-Foot RT"

#: Exports that are told by their maker's names.
MAKERS: Mapping[str, Mapping[str, Export]] = {
    "Xsens DOT": {SINGLE: Export(
        "DeviceTag:,hip\nFirmwareVersion:,1.6.0\n\n" + names("PacketCounter,SampleTimeFine,Euler_X", "Acc_*", "Gyr_*"),
        "n:d us:.0f 1.0 a deg")},
    "Xsens MTw": {SINGLE: Export(XSENS, "n:.1f a w 0.1", "\t")},
    # as of 2022: ticks of 100 us, where the tracker has any
    "Xsens MTw (MT Manager)": {"MT_00B42D4F.txt": Export(
        MT_MANAGER + names("PacketCounter", "SampleTimeFine", "Year", "Acc_*", "Gyr_*", delimiter="\t"),
        "n:d ticks:d NaN a w", "\t")},
    "Shimmer": {SINGLE: Export(SHIMMER + "\nms" + 3 * "\tm/(s^2)" + 3 * "\tdeg/s", "ms:.1f a deg", "\t")},
    "phyphox": {"Raw Data.csv": Export(
        names('"Time (s)"', '"Acceleration * (m/s^2)"', '"Gyroscope * (rad/s)"', axes="xyz"), "s:.9E a:.9f w:.9f")},
    "Sensor Logger": {
        "TotalAcceleration.csv": Export("time,seconds_elapsed,z,y,x", "ns:d s:.9f a_zyx:.9f"),
        "Gyroscope.csv": Export("time,seconds_elapsed,z,y,x", "ns:d s:.9f w_zyx:.9f")},
    "MetaWear": {  # a file a sensor, stamps since 1970 in ms and written as well
        "log_acc.csv": Export(METAWEAR + names("*-axis (g)", axes="xyz"), "epoch_ms:.0f iso s:.3f g"),
        "log_gyr.csv": Export(METAWEAR + names("*-axis (deg/s)", axes="xyz"), "epoch_ms:.0f iso s:.3f deg")},
    "Axivity": {"6012345_0000000001.csv": Export(names("Time", "Accel-* (g)", "Gyro-* (d/s)"), "date g deg")},
    "Physics Toolbox": {"walk.csv": Export("time,gFx,gFy,gFz,wx,wy,wz", "s:.3f g w")},
    "ROS": {"imu.csv": Export(
        names("%time,field.header.seq,field.header.stamp,field.header.frame_id", "field.orientation.*",
              "field.orientation.w", "field.angular_velocity.*", "field.linear_acceleration.*", axes="xyz"),
        "ns:d n:d ns:d imu 0 0 0 1 w:.9f a:.9f")},
    "ROS (rostopic, bagpy)": {"imu.csv": Export(
        names("header.stamp.sec", "header.stamp.nanosec", "header.frame_id", "orientation.x", "orientation.y",
              "orientation.z", "orientation.w", "angular_velocity.*", "linear_acceleration.*", axes="xyz"),
        "sec:d nanosec:d imu 0 0 0 1 w:.9f a:.9f")},
    "Noraxon": {"trial.csv": Export(
        names("time", f"{NORAXON}-Accel Sensor A* (mG)", f"{NORAXON}-Gyroscope-* (deg/s)", axes="xyz"),
        "s:.4f mg deg")},
}  # fmt: skip
#: Layouts of nobody in particular.
LAYOUTS: Mapping[str, Mapping[str, Export]] = {
    "x-io": {SINGLE: Export(names("Time (s)", "Gyroscope * (deg/s)", "Accelerometer * (g)"), "s:.2f deg g")},
    "decimal comma": {SINGLE: Export(
        names("Zeit", "Time (s)", "Acc * (m/s²)", "Gyro * (rad/s)", delimiter=";"), "n:d s:.2f a w", ";", True)},
    "UTF-16": {SINGLE: Export(XSENS, "n:.1f a w 0.1", "\t", encoding="utf-16")},
    "nanoseconds": {SINGLE: Export(
        names("time", "seconds_elapsed", "gyro_*", "acc_*", axes="xyz"), "ns:d s:.2f w a")},
    "whole seconds": {SINGLE: Export(names("Secs", "nsecs", "acc_*", "gyro_*", axes="xyz"), "sec:d nanosec:d a w")},
    "ISO": {SINGLE: Export(names("received_at", "a*", "g*", "counter", axes="xyz"), "iso mg:.2f deg n:d")},
    "quoted": {SINGLE: Export(
        names('"Sample number"', '"Time (s)"', '"Acceleration * (m/s^2)"', '"Angular velocity * (rad/s)"', axes="xyz"),
        "n:d s:.2f a w")},
    # as data logs of ST's sensors have it: kinds by their units, thousandths of both
    "mdps": {SINGLE: Export(names("T [ms]", "A_* [mg]", axes="xyz") + "," + names("Gyr*(mdps)"), "ms:.0f mg mdps")},
    "exponents": {SINGLE: Export(
        names('"Time (s)"', '"Acc * (g)"', '"Gyro * (°/s)"', delimiter=";"), "s:.9E g:.9E deg:.9E", ";", True)},
}  # fmt: skip


def delsys(table: Table) -> bytes:
    """A column of times before each channel; muscles are read oftener, so their columns are longer."""
    sensor = "Avanti sensor 1"
    channels = names(f'X[s],"{sensor}: ACC.* 1"', f'X[s],"{sensor}: GYRO.* 1"')
    head = f'Application: EMGworks\nCollection Length (seconds): 7\nX[s],"{sensor}: EMG 1",{channels}'
    known = [",".join(f"{time:.4f},{value:.6f}" for value in (*force / G, *np.degrees(rate)))
             for _, time, force, rate in zip(*table)]  # fmt: skip
    rows = [f"{0.005 * n:.4f},0.00001,{one}" for n, one in enumerate([*known, *[11 * ","] * len(known)])]
    return "\n".join([head, *rows, ""]).encode()
