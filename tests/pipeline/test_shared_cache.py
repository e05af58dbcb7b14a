"""One cache for many: `--cache` takes from another results folder what was computed there, and only reads it."""

from __future__ import annotations

import dataclasses
import os
import shutil

from pipeline.cache import disk
from pipeline.execution.display import Display
from pipeline.execution.executor import bring_up_to_date


def lay(folder):
    """How all lies in a folder: names, times, modes and content."""
    return {path.relative_to(folder): (path.lstat().st_mtime_ns, path.stat().st_mode, disk.read(path))
            for path in folder.rglob("*")}  # fmt: skip


def test_twenty_users_find_all_in_a_cache_that_is_only_read(done, tmp_path):
    before, lab = done.results(), tmp_path / "lab"
    shutil.move(done.root / "results", lab)
    for path in [*lab.rglob("*"), lab]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    first = lay(lab)
    for user in range(20):
        study = dataclasses.replace(done.study(), results=tmp_path / f"user{user}", cache=lab / ".cache")
        values = study.parameters(tuple(study.graph.stages))
        with disk.locked(study.results, "results", "run-all", False, print):
            outcomes = bring_up_to_date(study, values, Display())
        assert {outcome.how for outcome in outcomes} == {"restored"}
        for name, content in before.items():
            place = study.results / name
            assert place.read_bytes() == content and os.access(place, os.W_OK) and place.stat().st_nlink == 1
    again = dataclasses.replace(study, cache=None)
    assert {outcome.how for outcome in bring_up_to_date(again, values, Display())} == {"current"}
    assert lay(lab) == first
    for path in [lab, *lab.rglob("*")]:
        path.chmod(0o755)


def test_what_the_shared_cache_lacks_or_holds_damaged_is_computed_into_the_own_one(ran):
    shutil.move(ran.root / "results", ran.root / "lab")
    (ran.root / "lab/fall.h5").unlink()
    for path in (ran.root / "lab/.cache").glob("*/results/side.bin"):
        path.write_bytes(b"damaged")
    first = lay(ran.root / "lab")
    code, out, _ = ran.command("status", "--cache", "lab")
    assert code == 0 and out.count("in cache") == 4
    code, out, errors = ran.command("run-all", "--cache", "lab/.cache")
    hows = {line.split()[0]: line.split()[1] for line in out.splitlines() if line[:1].isalpha()}
    assert (code, errors) == (0, "") and hows["fall"] == hows["bounce"] == "restored" and hows["side"] == "computed"
    assert ran.command("run", "fall", "--cache", "lab", "--set", "fall.height=3")[0] == 0
    assert ran.command("run", "fall", "--cache", "lab")[1].split()[1] == "restored"
    assert lay(ran.root / "lab") == first
    code, _, errors = ran.command("run-all", "--cache", "nowhere")
    assert code == 2 and "nowhere" in errors


def test_a_shared_cache_without_results_says_so(ran):
    (ran.root / "lab").mkdir()
    code, out, errors = ran.command("run-all", "--cache", "lab")
    said = "note: lab has no stored results: what is not in results is computed\n"
    assert (code, errors, out.count(" current ")) == (0, said, 4)
