"""How long after a row of the hip `follow -` answers it, where rows come at the rate they were sensed at.

python -m benchmarks.follow_latency ROWS.csv ROBOT
python -m benchmarks.follow_latency ROWS.csv --echo

ROWS.csv has rows of hip and foot as `follow -` reads them, ROBOT is what `calibrate --into` leaves. Who writes and who
reads are processes of their own. With --echo a loop of Python answers: what the machine and its pipes take.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

#: Answers of the first second [s] do not count: what is compiled is loaded then.
SETTLING = 1.0
WRITER = """
import csv, sys, time
lines = open(sys.argv[1]).read().splitlines(True)
stamps = [float(row["device_stamp"]) for row in csv.DictReader(lines)]
begun = time.monotonic() - stamps[0]
sys.stdout.write(lines[0])
with open(sys.argv[2], "w") as sent:
    for line, stamp in zip(lines[1:], stamps):
        time.sleep(max(begun + stamp - time.monotonic(), 0.0))
        sent.write(f"{time.monotonic()}\\n")
        sys.stdout.write(line)
        sys.stdout.flush()
"""
READER = """
import sys, time
answers = [(time.monotonic(), line) for line in sys.stdin]
with open(sys.argv[1], "w") as got:
    got.writelines(f"{moment} {line}" for moment, line in answers)
"""
ECHO = """
import csv, json, sys
for row in csv.DictReader(iter(sys.stdin.readline, "")):
    if row["place"] == "hip":
        print(json.dumps({"time_s": float(row["device_stamp"])}), flush=True)
"""


def latencies(rows: Path, command: list[str], folder: Path) -> np.ndarray:
    """How long each answer took [s], after `SETTLING`."""
    sent, got = folder / "sent.txt", folder / "got.txt"
    writer = subprocess.Popen([sys.executable, "-c", WRITER, str(rows), str(sent)], stdout=subprocess.PIPE)
    follower = subprocess.Popen(command, stdin=writer.stdout, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    subprocess.run([sys.executable, "-c", READER, str(got)], stdin=follower.stdout, check=True)
    writer.wait()
    head, *lines = (line.split(",") for line in rows.read_text().splitlines())
    stamp, place = head.index("device_stamp"), head.index("place")
    hip = np.array([[float(line[stamp]), float(moment)] for line, moment in zip(lines, sent.read_text().split())
                    if line[place] == "hip"])  # fmt: skip
    answers = [(float(moment), json.loads(row)) for moment, row in
               (line.split(" ", 1) for line in got.read_text().splitlines())]  # fmt: skip
    found = np.array([[moment, row["time_s"]] for moment, row in answers if "time_s" in row])
    found = found[found[:, 0] > found[0, 0] + SETTLING]
    nearest = np.abs(hip[:, 0] - found[:, 1:]).argmin(axis=1)
    return np.asarray(found[:, 0] - hip[nearest, 1])


def main() -> None:
    """Print percentiles."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", type=Path)
    parser.add_argument("robot", nargs="?", default="")
    parser.add_argument("--echo", action="store_true", help="answer by a loop of Python")
    asked = parser.parse_args()
    command = [sys.executable, "-c", ECHO] if asked.echo else ["bipedstudy", "follow", "-", "--as", asked.robot]
    with tempfile.TemporaryDirectory() as folder:
        found = 1e3 * latencies(asked.rows, command, Path(folder))
    median, most, worst = np.quantile(found, (0.5, 0.99, 1.0))
    print(f"{len(found)} answers: median {median:.1f} ms, 99 % within {most:.1f} ms, all within {worst:.1f} ms")


if __name__ == "__main__":
    main()
