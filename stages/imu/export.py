"""What a lab takes away: events, steps, curves and verdicts as plain tables, a unit in every column's name."""

from __future__ import annotations

import dataclasses
import io
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from stages.biped.walk import SENSOR_SIGNALS
from stages.drawing.csv_table import table
from stages.imu.clock.clock import packet_arrivals
from stages.imu.clock.packet_index import arrival_stamp
from stages.imu.result import Evidence, RunReport, StepTimes
from stages.imu.strikes.step_times import INNER, OUTER
from stages.imu.trial.body import FORWARD, LATERAL, UP, BodySensor
from stages.imu.trial.trial import Trial

if TYPE_CHECKING:
    from matplotlib.figure import Figure


APART = ("evidence", "times")  # tables in themselves: the one beside the runs, the other in a file of its own
UNITS = {"force": "m/s^2", "rate": "rad/s"}
Row = Sequence[object]


#: Tables of the runs that are used, by file: their columns beside the run's name.
COLUMNS = {
    "events.csv": ("time [s]", "leg [0 inner, 1 outer]", "event"),
    "times.csv": tuple(f"{field.name} [{field.metadata['unit']}]" for field in dataclasses.fields(StepTimes)),
    "hip_path.csv": ("step", "phase [1]", "along the slope [m]", "above it [m]"),
    "steps.csv": ("start [s]", "end [s]", "length [m]", "standard error [m]", "of the drawing [m]"),
    "leg.csv": ("time [s]", "angle [rad]", "standard error [rad]"),
    "strides.csv": ("stride", "phase [1]", *(f"{name} [{UNITS[name.rsplit('_', 1)[1]]}]" for name in SENSOR_SIGNALS)),
}


def exported(trials: Iterable[Trial]) -> dict[str, bytes]:
    """Files by name: runs, events, times by leg, steps, leg, hip path and strides as CSV, and the curves as npz.

    Refused runs stand in runs alone.
    """
    found = list(trials)
    used = [trial for trial in found if trial.accepted]
    rows = [(trial.experiment.name, _rows(trial)) for trial in used]
    files = {"runs.csv": table([_run_columns(), *(_run(trial.report()) for trial in found)]).encode()}
    for name, columns in COLUMNS.items():
        of_runs = ((run, *row) for run, tables in rows for row in tables[name])
        files[name] = table([("run", *columns), *of_runs]).encode()
    return files | {"curves.npz": _curves(used)}


def _rows(trial: Trial) -> dict[str, Iterable[Row]]:
    """The rows of a run by file, as `COLUMNS` has them."""
    leg = trial.leg
    lengths = (leg.step_length, leg.step_length_error, leg.step_length_drawing_error)
    return {
        "events.csv": events_of(trial),
        "times.csv": [dataclasses.astuple(leg.times)],
        "hip_path.csv": _by_phase(leg.hip_path),
        "steps.csv": zip(leg.stance_start, leg.stance_end, *lengths),
        "leg.csv": zip(leg.time, leg.angle, leg.angle_error),
        "strides.csv": _by_phase(trial.strides),
    }


def _by_phase(curves: np.ndarray) -> Iterator[Row]:
    """Number, phase and values of each point of curves (n, p, k)."""
    for number, curve in enumerate(curves):
        yield from ((number, phase, *values) for phase, values in zip(np.linspace(0, 1, len(curve)), curve))


def events_of(trial: Trial) -> list[tuple[float, int, str]]:
    """Time [s], leg and kind of every event; the inner leg's toe-offs where the foot's sensor shows them."""
    strikes, double = trial.strikes, trial.leg.times.double_stance
    found = [(float(time), int(leg), "heel strike") for time, leg in zip(strikes.time, strikes.leg)]
    if np.isfinite(double):
        found += [(float(time + double), INNER, "toe-off") for time in strikes.time[strikes.leg == OUTER]]
    return sorted(found)


def _run_columns() -> tuple[str, ...]:
    flat = [(one.name, one.metadata["unit"]) for one in dataclasses.fields(RunReport) if one.name not in APART]
    flat += [(field.name, field.metadata["unit"]) for field in dataclasses.fields(Evidence)]
    return tuple(name if unit == "-" else f"{name} [{unit}]" for name, unit in flat)


def _run(report: RunReport) -> Row:
    own = [getattr(report, field.name) for field in dataclasses.fields(report) if field.name not in APART]
    return ["; ".join(one) if isinstance(one, tuple) else one
            for one in (*own, *dataclasses.astuple(report.evidence))]  # fmt: skip


def _curves(used: Sequence[Trial]) -> bytes:
    """The strides (n, p, k) with run and signal names, and the hip's paths (m, q, 2) [m], as npz."""
    content = io.BytesIO()
    np.savez_compressed(
        content,
        signals=np.array([f"{name} [{UNITS[name.rsplit('_', 1)[1]]}]" for name in SENSOR_SIGNALS]),
        stride_run=np.array([trial.experiment.name for trial in used for _ in trial.strides]),
        strides=np.concatenate([trial.strides for trial in used]) if used else np.empty((0, 0, len(SENSOR_SIGNALS))),
        step_run=np.array([trial.experiment.name for trial in used for _ in trial.leg.hip_path]),
        hip_path_m=np.concatenate([trial.leg.hip_path for trial in used]) if used else np.empty((0, 0, 2)),
    )
    return content.getvalue()


#: Letters in a line of the picture's title.
LETTERS = 120


def picture(trial: Trial) -> Figure:
    """Panels over one time axis: lateness of the stamps, if there are any, specific force, lateral rate with landings,
    leg angle.
    """
    import matplotlib.pyplot as plt

    from stages.drawing import style

    with style.drawing():
        stamped = {place: lateness(sensor) for place, sensor in trial.sensors.items()}
        shown = any(stamped.values())
        figure, panels = plt.subplots(3 + shown, 1, sharex=True, figsize=(style.TWO_COLUMNS, 1.0 + 1.5 * (3 + shown)))
        force, rate, angle = panels[-3:]
        zero = min((float(sensor.time[0]) for sensor in trial.sensors.values()), default=0.0)
        for (place, sensor), colour in zip(trial.sensors.items(), (style.ANALYTIC, style.MULTIBODY)):
            if late := stamped[place]:
                name, at, lag = late
                panels[0].plot(at - zero, 1e3 * lag, ".", color=colour, markersize=2, label=f"{place}, {name}")
                panels[0].set_ylabel("stamp less\nsample [ms]")
            size = np.hypot(sensor.force[:, FORWARD], sensor.force[:, UP])
            force.plot(sensor.time - zero, size, color=colour, linewidth=0.8, label=place)
            rate.plot(sensor.time - zero, sensor.rate[:, LATERAL], color=colour, linewidth=0.8, label=place)
        for leg, line, name in ((0, "-", "inner"), (1, ":", "outer")):
            for number, landing in enumerate(trial.strikes.time[trial.strikes.leg == leg]):
                said = f"{name} leg lands" if number == 0 else None
                rate.axvline(landing - zero, color="0.4", linestyle=line, linewidth=0.8, label=said)
        if len(trial.leg.time):
            band = np.degrees(2 * trial.leg.angle_error)
            degrees, at = np.degrees(trial.leg.angle), trial.leg.time - zero
            angle.fill_between(at, degrees - band, degrees + band, color=style.SECOND, alpha=0.4,
                               label="two standard errors")
            angle.plot(at, degrees, color=style.SECOND, linewidth=0.8, label="leg")
        force.set_ylabel("specific\nforce [m/s²]")
        rate.set_ylabel("lateral\nrate [rad/s]")
        angle.set(ylabel="leg angle [°]", xlabel="time [s]")
        for axes in panels:
            if axes.get_legend_handles_labels()[0]:
                axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        said = "; ".join((*trial.verdict.sentences(True), *trial.verdict.sentences(False)))
        title = f"{trial.experiment.name} ({trial.experiment.origin}): {trial.verdict.outcome}"
        words = [line for text in (title, said) for line in textwrap.wrap(text, LETTERS)]
        figure.suptitle("\n".join(words), fontsize=8, x=0.02, ha="left")
    return figure


def lateness(sensor: BodySensor) -> tuple[str, np.ndarray, np.ndarray] | None:
    """Name of a sensor's stamps, times [s] of the samples that they belong to, and how late they came [s]."""
    indexed = sensor.trace.indexed
    name, stamp = arrival_stamp(indexed.recording)
    if name in ("none", "device"):
        return None
    arrival = packet_arrivals(indexed, stamp)
    taken = np.interp(np.arange(len(arrival)), np.linspace(0, len(arrival) - 1, len(sensor.time)), sensor.time)
    at = np.interp(arrival[:, 1], indexed.index, sensor.time) if indexed.resets == 0 else taken
    return name, at, arrival[:, 2] - at
