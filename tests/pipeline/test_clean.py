"""`bipedstudy clean`: what lies in the results folder stays current, all else of the cache goes, with its size."""

from __future__ import annotations

import json

from pipeline.cache import disk
from pipeline.commands import house


def folders(toy):
    return {path.parent.name for path in (toy.root / "results/.cache").glob("*/manifest.json")}


def test_earlier_results_go_and_the_current_ones_stay(ran):
    toy = ran
    for setting in ("ground.gravity=5", "picture.extra=true"):
        assert toy.command("run-all", "--set", setting)[0] == 0
    toy.command("run-all")
    before, results, known = folders(toy), toy.results(), toy.study().store.last_keys()
    code, out, _ = toy.command("clean", "--dry-run")
    assert code == 0 and "an earlier result of fall: results/.cache/" in out and folders(toy) == before
    assert out.splitlines()[-1].endswith(f"in {len(before) - 4} places would be removed") and len(before) > 4
    told = json.loads(toy.command("clean", "--dry-run", "--json")[1])["folders"]
    assert all(item["bytes"] == house.size_of(toy.root / item["folder"]) > 0 for item in told)
    code, out, _ = toy.command("clean")
    assert code == 0 and folders(toy) == known and toy.results() == results
    assert {line.split()[1] for line in toy.command("status")[1].splitlines()} == {"current"}
    assert toy.command("clean")[1].split(maxsplit=2)[2] == "in 0 places removed\n"


def test_a_damaged_entry_goes_and_a_link_is_left(ran):
    toy = ran
    toy.command("run-all", "--set", "fall.height=3")
    toy.command("run-all")
    cache = toy.root / "results/.cache"
    earlier = min(folders(toy) - toy.study().store.last_keys())
    (cache / earlier / "manifest.json").write_text("{")
    outside = toy.root / "outside"
    outside.mkdir()
    (outside / "manifest.json").write_text("{}")
    (cache / "link").symlink_to(outside)
    code, out, _ = toy.command("clean")
    assert code == 0 and "a damaged result" in out and not (cache / earlier).exists()
    assert (outside / "manifest.json").exists()


def test_what_questions_and_sweeps_keep_goes_if_asked_for(toy_with_commands):
    toy = toy_with_commands
    (toy.root / "seeds.yaml").write_text("stage: side\nkind: grid\nvary: {side.seed: [1, 2]}\n")
    assert toy.command("sweep", "seeds.yaml")[0] == 0
    question = toy.root / "results/.cache/questions/key.jsonl"
    disk.write(question, bytes(1000))
    victim = toy.root / "victim.jsonl"
    victim.write_bytes(b"mine")
    (question.parent / "link.jsonl").symlink_to(victim)
    (sweep,) = toy.root.glob("results/sweeps/.cache/*.jsonl")
    assert toy.command("clean")[0] == 0 and question.exists() and sweep.exists()
    out = toy.command("clean", "--journals", "--dry-run")[1]
    assert "what a question keeps: results/.cache/questions/key.jsonl" in out and f"what sweeps keep: {sweep}" in (
        out.replace("results/sweeps", str(toy.root / "results/sweeps")))  # fmt: skip
    assert question.exists() and sweep.exists()
    assert toy.command("clean", "--journals")[0] == 0 and not question.exists() and not sweep.exists()
    assert victim.read_bytes() == b"mine" and (toy.root / "results/sweeps/seeds.h5").exists()
    assert "2 computed; 0 were known" in toy.command("sweep", "seeds.yaml")[1]


def test_old_machine_code_goes(toy_with_commands):
    toy = toy_with_commands
    stale = toy.root / "stale"
    disk.write(stale / "x.nbc", bytes(3_000_000))
    method = "staticmethod(lambda keep: [Path('stale').absolute()] * keep)"
    toy.path("stages/side/compiled.py").write_text(f"from pathlib import Path\nclass CODE:\n    old = {method}\n")
    code, out, _ = toy.command("clean")
    assert code == 0 and "3.0 MB  machine code of earlier sources: stale" in out and not stale.exists()


def test_a_run_says_when_it_is_worth_it(ran, monkeypatch):
    from pipeline.commands.run import _say_if_large
    from pipeline.execution.display import Display

    toy = ran
    toy.command("run-all", "--set", "fall.height=3")
    toy.command("run-all")
    said = []
    shows = Display()
    shows.note = said.append
    _say_if_large(toy.study(), shows)
    monkeypatch.setattr(house, "WORTH_A_WORD", 1000)
    _say_if_large(toy.study(), shows)
    (sentence,) = said
    assert sentence.startswith("earlier results take 0.0 MB in") and sentence.endswith("bipedstudy clean removes them")
