"""A picture of what was read of a run, what was repaired, and what was found."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stages.imu.clock.clock import packet_arrivals
from stages.imu.clock.indexed import arrival_stamp
from stages.imu.trial.places import FORWARD, LATERAL, UP
from stages.imu.trial.trial import Trial

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = {"hip": "C0", "foot": "C1"}


def picture(trial: Trial) -> Figure:
    """Four panels over one time axis: lateness of the stamps, specific force, lateral rate with landings, leg angle."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 9), layout="constrained")
    late, force, rate, angle = figure.subplots(4, 1, sharex=True)
    zero = min((float(sensor.time[0]) for sensor in trial.sensors.values()), default=0.0)
    for place, sensor in trial.sensors.items():
        colour = COLOURS[place]
        name, stamp = arrival_stamp(sensor.trace.indexed.recording)
        if name not in ("none", "device"):
            indexed = sensor.trace.indexed
            arrival = packet_arrivals(indexed, stamp)
            taken = np.interp(np.arange(len(arrival)), np.linspace(0, len(arrival) - 1, len(sensor.time)), sensor.time)
            at = np.interp(arrival[:, 1], indexed.index, sensor.time) if indexed.resets == 0 else taken
            late.plot(at - zero, 1e3 * (arrival[:, 2] - at), ".", color=colour, markersize=2, label=f"{place}, {name}")
        size = np.hypot(sensor.force[:, FORWARD], sensor.force[:, UP])
        force.plot(sensor.time - zero, size, color=colour, linewidth=0.8, label=place)
        rate.plot(sensor.time - zero, sensor.rate[:, LATERAL], color=colour, linewidth=0.8, label=place)
    for leg, style, name in ((0, "-", "inner"), (1, ":", "outer")):
        for number, landing in enumerate(trial.strikes.time[trial.strikes.leg == leg]):
            said = f"{name} leg lands" if number == 0 else None
            rate.axvline(landing - zero, color="0.4", linestyle=style, linewidth=0.8, label=said)
    if len(trial.leg.time):
        band = np.degrees(2 * trial.leg.angle_error)
        degrees, at = np.degrees(trial.leg.angle), trial.leg.time - zero
        angle.fill_between(at, degrees - band, degrees + band, color="C2", alpha=0.4, label="two standard errors")
        angle.plot(at, degrees, color="C2", linewidth=0.8, label="leg")
    late.set_ylabel("stamp less sample [ms]")
    force.set_ylabel("specific force [m/s²]")
    rate.set_ylabel("lateral rate [rad/s]")
    angle.set_ylabel("leg angle [deg]")
    angle.set_xlabel("time [s]")
    for axes in (late, force, rate, angle):
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="upper left", fontsize="small", ncols=4)
    said = "; ".join((*trial.verdict.sentences(True), *trial.verdict.sentences(False)))
    title = f"{trial.experiment.name} ({trial.experiment.origin}): {trial.verdict.outcome}"
    figure.suptitle(title + (f"\n{said[:160]}" if said else ""), fontsize="medium")
    return figure
