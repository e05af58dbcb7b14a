"""The shipped detector of heel strikes on recordings of persons, beside a published one in the same run.

    python -m benchmarks.event_detectors [--gaitmap PYTHON]

The recordings are those of tests/imu/real_recordings.py, swings marked by hand; where a swing ends is a heel strike.
The published detector is that of Rampp et al. (2014, doi 10.1109/TBME.2014.2368211) on strides found as by Barth et al.
(2015), both as gaitmap has them (github.com/mad-lab-fau/gaitmap), run by a PYTHON in which that is installed: it needs
other versions than the study. Both get the same signals on body axes, on the clock and the index of the ingest, holes
drawn over. On the back, for which no published detector is at hand, the shipped one looks for landings of both feet.
Recall: marked strikes found within 0.15 s. Precision: strikes found that are within 0.15 s of a marked one. Errors are
those of the found ones, later positive.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from stages.imu.sources.column_map import CsvSource
from stages.imu.strikes.heel_strikes import filled
from stages.imu.strikes.step_times import INNER
from stages.imu.trial.body import FORWARD, LATERAL, UP, BodySensor, common_grid, on_grid
from stages.imu.trial.sensor import trace_sensor
from stages.imu.trial.trial import read_sensor
from stages.imu.trial.walk import strikes_of
from tests.imu.real_recordings import FOLDER, ipol
from tests.imu.stand_in import STUDY

NEAR_S = 0.15
RATE_HZ = 100.0
GAITMAP = """
import sys, numpy as np, pandas as pd
from gaitmap.event_detection import RamppEventDetection
from gaitmap.stride_segmentation import BarthDtw
from gaitmap.utils.coordinate_conversion import convert_to_fbf
given = np.load(sys.argv[1])
columns = ["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]
data = {"left_foot" if bool(given["left"]) else "right_foot": pd.DataFrame(given["signals"], columns=columns)}
body = convert_to_fbf(data, left_like="left", right_like="right")
rate = float(given["rate"])
found = BarthDtw().segment(body, sampling_rate_hz=rate)
events = RamppEventDetection().detect(data=body, stride_list=found.stride_list_, sampling_rate_hz=rate)
(table,) = events.segmented_event_list_.values()
np.save(sys.argv[2], np.sort(table["ic"].to_numpy(dtype=float)))
"""


def scored(found: np.ndarray, marked: np.ndarray) -> tuple[float, float, float, float]:
    """Recall, precision, median error and 95 % of its size, of times found and marked [s]."""
    if not len(found):
        return 0.0, 0.0, float("nan"), float("nan")
    apart = found[:, None] - marked
    nearest = apart[np.arange(len(found)), np.abs(apart).argmin(axis=1)]
    hit = np.abs(nearest) <= NEAR_S
    recall = float(np.mean(np.abs(apart).min(axis=0) <= NEAR_S))
    return recall, float(hit.mean()), float(np.median(nearest[hit])), float(np.quantile(np.abs(nearest[hit]), 0.95))


def published(python: str, sensor: BodySensor, left: bool) -> np.ndarray:
    """Initial contacts [s] by gaitmap's Barth and Rampp: axes forward, left, up; deg/s."""
    grid = common_grid({"foot": sensor}, STUDY.settings)[:: max(1, round(STUDY.settings.grid_rate_hz / RATE_HZ))]
    values = on_grid(sensor, grid, STUDY.settings)
    force, rate = (np.column_stack([filled(part[:, axis]) for axis in (FORWARD, LATERAL, UP)])
                   for part in (values[:, :3], values[:, 3:]))  # fmt: skip
    turned = np.array([1.0, -1.0, 1.0])
    signals = np.hstack((force * turned, np.degrees(rate * turned)))
    with tempfile.TemporaryDirectory() as folder:
        given, answer = Path(folder) / "given.npz", Path(folder) / "found.npy"
        np.savez(given, signals=signals, rate=RATE_HZ, left=left)
        subprocess.run([python, "-W", "ignore", "-c", GAITMAP, str(given), str(answer)], check=True)
        rows = np.load(answer)
    return np.asarray(np.interp(rows[np.isfinite(rows)], np.arange(len(grid)), grid))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gaitmap", metavar="PYTHON")
    python = parser.parse_args().gaitmap
    if not FOLDER.is_dir():
        sys.exit(f"the real recordings are not at {FOLDER.name}")
    print("| recording | detector | recall | precision | median error ms | 95 % ms |\n" + "|---" * 6 + "|")
    every: dict[str, list[tuple[float, ...]]] = {}
    for name in ("8-5", "3-3", "7-4"):
        marks = json.loads((FOLDER / f"ipol_{name}.json").read_text())
        ((_, recordings),) = CsvSource(ipol(name), FOLDER).runs()
        for recording in recordings:
            sensor, _, _ = read_sensor(trace_sensor(recording, STUDY.settings), STUDY.settings, STUDY.limits)
            side, _, part = recording.device.place.partition(" ")
            if sensor is None:
                continue
            packet = sensor.trace.indexed.recording.packet
            sides = (side,) if part == "foot" else ("left", "right")  # the back feels both feet
            ends = np.concatenate([np.array(marks[f"{one.title()}FootEvents"])[:, 1] for one in sides])
            marked = np.sort(np.interp(ends, packet, sensor.time))
            strikes, _ = strikes_of({"foot" if part == "foot" else "hip": sensor}, STUDY.settings)
            shipped = "shipped" if part == "foot" else "shipped, on the back"
            answers = {shipped: strikes.time if part != "foot" else strikes.time[strikes.leg == INNER]}
            if python and part == "foot":
                answers["Rampp, gaitmap"] = published(python, sensor, side == "left")
            for detector, found in answers.items():
                score = scored(found, marked)
                every.setdefault(detector, []).append(score)
                print(_row(f"{name}, {recording.device.place}", detector, score), flush=True)
    for detector, scores in every.items():
        print(_row("mean", detector, tuple(np.nanmean(scores, axis=0))))


def _row(what: str, detector: str, score: tuple[float, ...]) -> str:
    recall, precision, middle, most = score
    errors = f"{1e3 * middle:+.0f} | {1e3 * most:.0f}" if middle == middle else "- | -"
    return f"| {what} | {detector} | {recall:.3f} | {precision:.3f} | {errors} |"


if __name__ == "__main__":
    main()
