"""Computing a study twice: what does not repeat is named."""

from __future__ import annotations

import os
import subprocess
import sys

from tests.pipeline.toy import HOME


def test_a_stage_that_does_not_repeat_is_named(toy_with_commands):
    toy = toy_with_commands
    toy.edit("PACKAGE/side/run.py", "random.Random(parameters.settings.seed)", "random.SystemRandom()")
    toy.edit("PACKAGE/side/run.py", "randrange(1000)", "randrange(10**9)")
    toy.edit("PACKAGE/side/run.py", "bytes([number % 256])", "str(number).encode()")
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.twice", "hashes.txt"], cwd=toy.root, text=True, capture_output=True,
        env={**os.environ, "PYTHONPATH": str(HOME)},
    )  # fmt: skip
    assert done.returncode == 1, done.stderr
    differ = done.stderr.splitlines()[-1]
    assert {"side.h5", "side.bin"} <= set(differ.partition(": ")[2].split(", ")) and "fall.h5" not in differ
    assert "computing it again gave other bytes than before" in done.stderr
    listed = (toy.root / "hashes.txt").read_text().splitlines()
    assert len(listed) == 8 and all(len(line.split()[0]) == 64 for line in listed)
