"""Layouts of common makers' exports: by which names they are told, and what no name in them says."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Maker:
    """An export: `signs` are patterns that each must match a name or a line above, `without` one that must match none;
    units where the file has none; `columns` patterns of names by value, where they are not told by the usual words;
    `note` what to bear in mind."""

    name: str
    signs: tuple[str, ...]
    acceleration: str
    rate: str
    columns: Mapping[str, str] = field(default_factory=dict)
    note: str = ""
    without: str = ""


MAKERS = (
    # Both write the same names; the one in deg/s, the other in rad/s. What is above the names tells them apart.
    Maker("Xsens DOT (Movella)", ("^SampleTimeFine$", "^DeviceTag|^SyncStatus|^OutputRate|(Xsens|Movella) DOT"),
          "m/s^2", "deg/s",
          {"packet": "^PacketCounter$", "device_stamp": "^SampleTimeFine$"},
          "SampleTimeFine counts us and starts anew after 2^32; FreeAcc columns have no gravity and are left out"),
    Maker("Xsens MTw (MT Manager)", ("^PacketCounter$", "^Acc_X$", "^// "), "m/s^2", "rad/s",
          {"packet": "^PacketCounter$"}, "SampleTimeFine counts ticks of 100 us and is left out"),
    Maker("Xsens MTw (MT Manager)", ("^PacketCounter$", "^Acc_X$"), "m/s^2", "rad/s", {"packet": "^PacketCounter$"},
          without="^SampleTimeFine$|^DeviceTag"),
    Maker("Delsys (EMGworks, Trigno Discover)", (r"^X ?\[s\]$|Time Series \(s\)$", r"\bACC"), "g", "deg/s", {},
          "each channel has a column of times; of several sensors the first is taken"),
    Maker("Shimmer (Consensys)", (r"Accel_(LN|WR)_X",), "m/s^2", "deg/s", {},
          "of two accelerometers the low-noise one (LN) is taken; its range is 2 g"),
    Maker("phyphox", (r"^(Acceleration|Linear Acceleration|Gyroscope) x \(",), "m/s^2", "rad/s", {},
          "export the accelerometer with g, not the linear acceleration"),
    Maker("Sensor Logger", ("^seconds_elapsed$",), "m/s^2", "rad/s", {"device_stamp": "^seconds_elapsed$"},
          "Accelerometer has no gravity: take TotalAcceleration, or AccelerometerUncalibrated"),
    Maker("MetaWear (MbientLab)", (r"^epoch? ?\(ms\)", r"^elapsed \(s\)"), "g", "deg/s",
          {"device_stamp": r"^elapsed \(s\)"}, "all its stamps are made of the sensor's ticks"),
    Maker("Axivity AX6 (OmGui)", (r"^Accel-X \(g\)", r"^Gyro-X"), "g", "deg/s", {}),
    Maker("Physics Toolbox", ("^gFx$", "^wx$"), "g", "rad/s",
          {f"a{axis}": f"^gF{axis}$" for axis in "xyz"} | {f"g{axis}": f"^w{axis}$" for axis in "xyz"}),
    Maker("Noraxon (myoRESEARCH)", ("Noraxon|MyoMotion|Ultium",), "mg", "deg/s", {},
          "of several segments the first is taken: name the others' columns in entries of their own"),
)  # fmt: skip

#: HDF5 files of APDM: groups with these arrays, a sensor each.
APDM = "APDM Opal"


def maker_of(names: Sequence[str], above: str) -> Maker | None:
    """The maker whose signs are all there; the first of several."""
    lines = above.splitlines()

    def there(pattern: str) -> bool:
        return any(re.search(pattern, text, re.I) for text in (*names, *lines))

    return next((one for one in MAKERS if all(there(sign) for sign in one.signs)
                 and not (one.without and there(one.without))), None)  # fmt: skip
