"""`bipedstudy clean`: what lies in the results folder stays current, all else of the cache goes, with its size."""

import json
import os
import shutil
import time

import pytest

from pipeline.cache import bounds, disk
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
    assert all(item["bytes"] == bounds.size_of(toy.root / item["folder"]) > 0 for item in told)
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


def test_old_machine_code_goes_if_asked_for(toy_with_commands):
    toy = toy_with_commands
    stale = toy.root / "stale"
    disk.write(stale / "x.nbc", bytes(3_000_000))
    method = "staticmethod(lambda keep, own: [Path('stale').absolute()] * keep * own)"
    toy.path("stages/side/compiled.py").write_text(f"from pathlib import Path\nclass CODE:\n    old = {method}\n")
    assert toy.command("clean")[0] == 0 and stale.exists()
    assert toy.command("clean", "--machine-code", "--older-than", "1h")[0] == 0 and stale.exists()
    code, out, _ = toy.command("clean", "--machine-code")
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
    assert sentence.startswith("earlier results take 0.0 MB in") and "bipedstudy clean removes them, and" in sentence


def edited(toy, *heights):
    """The keys of `fall` at these heights, one after another; the last is current."""
    keys = []
    for height in heights:
        assert toy.command("run", "fall", "--set", f"fall.height={height}")[0] == 0
        keys.append(toy.study().store.current("fall").key)
    return keys


def test_the_newest_results_of_each_stage_stay(ran):
    keys = edited(ran, 3, 4, 5)
    code, out, _ = ran.command("clean", "--keep", "2", "--dry-run")
    assert code == 0 and out.splitlines()[-1].endswith("in 2 places would be removed") and folders(ran) >= {*keys}
    assert f"an earlier result of fall: results/.cache/{keys[0]}" in out
    assert ran.command("clean", "--keep", "2")[0] == 0
    assert folders(ran) & {*keys} == {*keys[1:]} and folders(ran) >= ran.study().store.last_keys()


def test_a_result_ages_from_when_another_took_its_place(ran):
    first, second, third = edited(ran, 3, 4, 5)
    cache = ran.root / "results/.cache"
    for key in (first, third):
        os.utime(cache / key / "manifest.json", (0, time.time() - 3 * 86400))
    assert ran.command("clean", "--older-than", "2d")[0] == 0
    assert folders(ran) & {first, second, third} == {second, third}
    edited(ran, 6)
    assert ran.command("clean", "--older-than", "2d")[0] == 0 and third in folders(ran)


def test_the_oldest_go_until_a_size_holds(ran):
    keys = edited(ran, 3, 4, 5)
    cache = ran.root / "results/.cache"
    (cache / keys[1] / "ballast").write_bytes(bytes(3_000_000))
    assert ran.command("clean", "--max-size", "2 MB")[0] == 0
    assert folders(ran) == ran.study().store.last_keys(), "what is older than what is too large goes as well"
    (cache / keys[2] / "ballast").write_bytes(bytes(3_000_000))
    assert ran.command("clean", "--max-size", "2MB")[0] == 0 and keys[2] in folders(ran)


def test_edits_stay_within_a_bound(toy_with_commands):
    toy = toy_with_commands
    edited(toy, 2)
    one = bounds.size_of(toy.root / "results/.cache" / toy.study().store.current("fall").key)
    (toy.root / "cache.yaml").write_text(f"max_size: {3.5 * one / 1e3:.3f} kB\n")
    sizes = []
    for height in range(3, 13):
        code, _, errors = toy.command("run", "fall", "--set", f"fall.height={height}")
        assert code == 0, errors
        sizes.append(sum(bounds.size_of(found.folder) for found in bounds.stored(toy.study().store)))
    assert max(sizes) <= 3.5 * one < max(sizes) + one and "are gone, as cache.yaml has it" in errors
    (toy.root / "cache.yaml").write_text("max_size: 1 B\n")
    code, _, errors = toy.command("run", "fall", "--set", "fall.height=12")
    assert code == 0 and "the current results stay, though they take" in errors
    assert folders(toy) == toy.study().store.last_keys()


def test_a_result_that_another_branch_uses_stays(ran):
    """Both work in one results folder, and one of them has a stage that the other has not."""
    (key,) = {ran.study().store.current("picture").key}
    graph = (ran.root / "dvc.yaml").read_text()
    (ran.root / "dvc.yaml").write_text(graph.partition("  picture:")[0])
    shutil.rmtree(ran.root / "stages/picture")
    assert ran.command("clean")[0] == 0 and key in folders(ran)


@pytest.mark.parametrize("text, sentence", [
    ("max_size: 500", "cache.yaml: max_size = 500 is not allowed; allowed: a number and one of B, kB, MB, GB, TB"),
    ("older_than: 3 a", "cache.yaml: older_than = 3 a is not allowed; allowed: a number and one of min, h, d, w"),
    ("keep: 0", "cache.yaml: keep = 0 is not allowed; allowed: a whole number from 1"),
    ("keep: true", "cache.yaml: keep = True is not allowed; allowed: a whole number from 1"),
    ("size: 1GB", 'cache.yaml:1: there is no key "size" (keys: keep, older_than, max_size)'),
    ("500MB", "cache.yaml: expected lines of the form key: value"),
])  # fmt: skip
def test_a_bound_that_is_none_is_one_sentence_before_anything_is_computed(toy_with_commands, text, sentence):
    toy = toy_with_commands
    (toy.root / "cache.yaml").write_text(text)
    code, _, errors = toy.command("run", "fall")
    assert code == 2 and errors.startswith(f"error: {sentence}") and not (toy.root / "results/fall.h5").exists()


def test_a_bound_on_the_command_line_is_refused_by_its_name(toy_with_commands):
    code, _, errors = toy_with_commands.command("clean", "--older-than", "soon")
    assert code == 2 and errors.startswith("error: --older-than = soon is not allowed; allowed: a number and one")
