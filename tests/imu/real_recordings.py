"""Descriptions of the real recordings, which stay where they are."""

from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "imu"
#: How the feet's sensors sit, seen from gravity at rest and the axis of the swing: on the instep, inclined, x backward.
FEET = {"forward_axis": "-x", "up_axis": "+z"}
XSENS = {"rate_hz": 100, "accelerometer_unit": "m/s^2", "gyroscope_unit": "rad/s", "counter_modulus": 65536}
IPOL_COLUMNS = {"packet": "PacketCounter"} | {
    f"{kind[0].lower()}{axis.lower()}": f"{kind}_{axis}" for kind in ("Acc", "Gyr") for axis in "XYZ"
}
XIO_COLUMNS = {"device_stamp": "Time (s)"} | {
    f"{kind[0].lower()}{axis.lower()}": f"{kind} {axis} ({unit})"
    for kind, unit in (("Accelerometer", "g"), ("Gyroscope", "deg/s"))
    for axis in "XYZ"
}
XIO = {"accelerometer_unit": "g", "gyroscope_unit": "deg/s"}


def ipol(name: str) -> dict[str, Any]:
    return {
        "experiment": {"name": name, "origin": "measured"},
        "files": [
            {
                "file": f"ipol_{name}_{short}.txt",
                "delimiter": "tab",
                "header_rows": 1,
                "device": {"place": place, **XSENS, **(FEET if "foot" in place else {})},
                "columns": IPOL_COLUMNS,
            }
            for short, place in (("lb", "low back"), ("lf", "left foot"), ("rf", "right foot"))
        ],
    }


def xio(file: str, rate_hz: float) -> dict[str, Any]:
    return {
        "experiment": {"name": file, "origin": "measured"},
        "files": [{"file": file, "device": {"place": "other", "rate_hz": rate_hz, **XIO}, "columns": XIO_COLUMNS}],
    }
