"""`bipedstudy clean`: what lies in the results folder stays current, all else of the cache goes, with its size."""

import json
import os
import shutil
import time

import pytest

from pipeline.cache import bounds, disk
from pipeline.cache.bounds import Bounds, beyond
from pipeline.commands import house
from pipeline.commands.run import _say_if_large
from pipeline.errors import StudyError
from pipeline.execution.display import Display


def folders(toy):
    return {path.parent.name for path in (toy.root / "results/.cache").glob("*/manifest.json")}


def edited(toy, *heights):
    """The keys of `fall` at these heights, one after another; the last is current."""
    for height in heights:
        toy.run(f"fall.height={height}", names=("fall",))
        yield toy.study().store.current("fall").key


def going(toy, **of):
    """Keys of what is beyond these bounds."""
    return {one.folder.name for one in beyond(toy.study().store, Bounds(**of))}


def test_earlier_results_go_and_the_current_ones_stay(ran, tmp_path_factory):
    """A damaged one goes as well, and what a link names is left; then cache.yaml holds its bound after a run."""
    toy, cache, outside = ran, ran.root / "results/.cache", tmp_path_factory.mktemp("outside")
    first = toy.study().store.current("fall").key
    for height in (3, 4):
        toy.says(f"run fall --set fall.height={height}")
    before, results, known = folders(toy), toy.results(), toy.study().store.last_keys()
    (second,) = before - known - {first}
    toy.says("clean --keep 2 --dry-run", f"an earlier result of fall: results/.cache/{first}", "in 1 places would be")
    assert folders(toy) == before
    toy.says("clean --keep 2", "in 1 places removed")
    (cache / second / "manifest.json").write_text("{")
    (outside / "manifest.json").write_text("{}")
    (cache / "link").symlink_to(outside)
    (item,) = json.loads(toy.says("clean --dry-run --json"))["folders"]
    assert item["bytes"] == bounds.size_of(cache / second) and folders(toy) == {*known, second, "link"}
    toy.says("clean", "a damaged result", "in 1 places removed")
    assert folders(toy) == {*known, "link"} and toy.results() == results and (outside / "manifest.json").exists()
    (toy.root / "cache.yaml").write_text("max_size: 1 B\n")
    toy.says("run fall --set fall.height=5", "are gone, as cache.yaml has it", "stay, though they take")


def test_what_questions_sweeps_and_machine_code_keep_goes_if_asked_for(toy_with_commands):
    toy, results = toy_with_commands, toy_with_commands.root / "results"
    asked = {"what a question keeps": results / ".cache/questions/key.jsonl",
             "what sweeps keep": results / "sweeps/.cache/key.jsonl",
             "3.0 MB machine code of earlier sources": toy.root / "stale/x.nbc"}  # fmt: skip
    for path in (victim := toy.root / "victim.jsonl", table := results / "sweeps/table.h5", *asked.values()):
        disk.write(path, bytes(3_000_000))
    (results / ".cache/questions/link.jsonl").symlink_to(victim)
    method = "staticmethod(lambda keep, own: [Path('stale').absolute()] * keep * own)"
    toy.path("stages/side/compiled.py").write_text(f"from pathlib import Path\nclass CODE:\n    old = {method}\n")
    words = "clean --journals --machine-code"
    for typed in ("clean", f"{words} --older-than 1h"):
        toy.says(typed, "in 0 places removed")
    toy.says(f"{words} --dry-run", *asked)
    assert all(path.exists() for path in asked.values())
    toy.says(words, "in 3 places removed")
    assert not any(path.exists() for path in asked.values()) and victim.exists() and table.exists()


def test_the_newest_those_of_some_days_and_those_of_some_size_stay(done):
    cache, zero = done.root / "results/.cache", done.study().store.current("fall").key
    first, second, third = edited(done, 3, 4, 5)
    assert going(done) == {zero, first, second} and going(done, keep=2) == {zero, first}
    for key in (first, third):
        os.utime(cache / key / "manifest.json", (0, time.time() - 3 * 86400))
    assert going(done, older_than=2 * 86400.0) == {first}
    list(edited(done, 6))
    assert third not in going(done, older_than=2 * 86400.0), "a result ages from when another took its place"
    (cache / second / "ballast").write_bytes(bytes(3_000_000))
    assert {first, second} <= going(done, max_size=2e6), "what is older than what is too large goes as well"


def test_edits_stay_within_a_bound(done):
    said, sizes = [], []
    one = bounds.size_of(done.root / "results/.cache" / done.study().store.current("fall").key)
    current = sum(stored.size for stored in bounds.stored(done.study().store))
    for _ in edited(done, *range(3, 9)):
        bounds.hold(done.study().store, Bounds(max_size=current + 2.5 * one), said.append)
        sizes.append(sum(stored.size for stored in bounds.stored(done.study().store)))
    assert max(sizes) <= current + 2.5 * one < max(sizes) + one and "are gone, as cache.yaml has it" in said[-1]


def test_a_run_says_when_it_is_worth_it(done, monkeypatch):
    list(edited(done, 3))
    said, shows = [], Display()
    shows.note = said.append
    for worth in (house.WORTH_A_WORD, 1000):
        monkeypatch.setattr(house, "WORTH_A_WORD", worth)
        _say_if_large(done.study(), shows)
    (sentence,) = said
    assert sentence.startswith("earlier results take 0.0 MB in") and "bipedstudy clean removes them, and" in sentence


def test_a_result_that_another_branch_uses_stays(done):
    """Both work in one results folder, and one of them has a stage that the other has not."""
    graph = (done.root / "dvc.yaml").read_text()
    (done.root / "dvc.yaml").write_text(graph.partition("  picture:")[0])
    shutil.rmtree(done.path("PACKAGE/picture"))
    assert going(done) == set()


@pytest.mark.parametrize("text, sentence", [
    ("max_size: 500", "cache.yaml: max_size = 500 is not allowed; allowed: a number and one of B, kB, MB, GB, TB"),
    ("older_than: 3 a", "cache.yaml: older_than = 3 a is not allowed; allowed: a number and one of min, h, d, w"),
    ("keep: 0", "cache.yaml: keep = 0 is not allowed; allowed: a whole number from 1"),
    ("keep: true", "cache.yaml: keep = True is not allowed; allowed: a whole number from 1"),
    ("size: 1GB", 'cache.yaml:1: there is no key "size" (keys: keep, older_than, max_size)'),
    ("500MB", "cache.yaml: expected lines of the form key: value"),
])  # fmt: skip
def test_a_bound_that_is_none_is_one_sentence(tmp_path, text, sentence):
    (tmp_path / "cache.yaml").write_text(text)
    with pytest.raises(StudyError) as refused:
        bounds.read(tmp_path)
    assert str(refused.value).startswith(sentence)


def test_commands_refuse_a_bound_before_anything_is_computed(toy_with_commands):
    toy = toy_with_commands
    (toy.root / "cache.yaml").write_text("keep: 0")
    toy.says("run fall", "error: cache.yaml: keep = 0 is not allowed; allowed: a", code=2)
    assert not (toy.root / "results/fall.h5").exists()
