"""Computing a study twice: what does not repeat is named."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import pytest

from benchmarks import twice


def test_a_stage_that_does_not_repeat_is_named(toy_with_commands, monkeypatch, capsys):
    toy, said = toy_with_commands, []
    toy.edit("PACKAGE/side/run.py", "random.Random(parameters.settings.seed)", "random.SystemRandom()")
    toy.edit("PACKAGE/side/run.py", "randrange(1000)", "randrange(10**9)")
    toy.edit("PACKAGE/side/run.py", "bytes([number % 256])", "str(number).encode()")

    def run(words, stdout):
        assert words[:3] == [sys.executable, "-m", "pipeline.cli"] and stdout is sys.stderr
        code, _, errors = toy.command(*words[3:])
        said.append(errors)
        return SimpleNamespace(returncode=code)

    monkeypatch.chdir(toy.root)
    monkeypatch.setattr(twice, "subprocess", SimpleNamespace(run=run))
    monkeypatch.setattr(sys, "argv", ["twice", "hashes.txt"])
    with pytest.raises(SystemExit) as ended:
        twice.main()
    differ = ended.value.code.partition(": ")[2].split(", ")
    assert {"side.h5", "side.bin"} <= {*differ} and "fall.h5" not in differ
    assert "computing it again gave other bytes than before" in "".join(said)
    listed = (toy.root / "hashes.txt").read_text().splitlines()
    assert listed == capsys.readouterr().out.splitlines()
    assert len(listed) == 8 and all(len(line.split()[0]) == 64 for line in listed)
