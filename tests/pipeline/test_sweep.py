"""Sweeps: points, keys, and that whatever happens to workers, no point is lost and none is there twice."""

import errno
import json
import os
import random
import signal
import time
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from pipeline.errors import StudyError
from pipeline.execution.display import Display
from pipeline.parameters.value import declared
from pipeline.sweep import pool, spec as specs
from pipeline.sweep.pool import Bench, Row
from pipeline.sweep.spec import Choice, Normal, Range
from pipeline.sweep.sweep import duration, how_far
from tests.pipeline.processes import workers

GRID = """
stage: bounce
kind: grid
vary:
  fall.steps: [2, 5, 9]
  ground.gravity: {low: 1, high: 9, steps: 3}
"""


def points_of(spec):
    return [spec.point(index) for index in range(spec.size)]


def spec_of(folder: Path, text: str) -> specs.Spec:
    (folder / "sweep.yaml").write_text(text)
    return specs.read(folder / "sweep.yaml")


def run(toy, text, *, workers=2, shows=Display):
    sweep = toy.sweep(text)
    sweep.display = shows()
    summary = sweep.run(toy.root / "table.h5", workers)
    return summary, table(toy.root / "table.h5")


def table(path):
    with h5py.File(path) as file:
        columns = {name: column[()] for name, column in file["table"].items()}
    return {name: [word.decode() for word in column] if column.dtype.kind == "S" else column
            for name, column in columns.items()}  # fmt: skip


def test_a_grid_computes_the_stage_and_what_is_above_it_and_no_point_again_until_the_code_is_edited(toy):
    first, columns = run(toy, GRID)
    assert first["outcomes"] == {"computed": 9}
    assert columns["fall.steps"].tolist() == [2, 2, 2, 5, 5, 5, 9, 9, 9]
    assert columns["ground.gravity"].tolist() == [1, 5, 9] * 3
    # bounce: way fallen in a second (Galileo) times the stiffness of ground.yaml
    assert columns["force"] == pytest.approx(0.5 * columns["ground.gravity"] * 1e5, rel=1e-12)
    with h5py.File(toy.root / "table.h5") as file:
        assert file["table/ground.gravity"].attrs["units"] == "m/s^2"
        about = {name: text for name, text in file["table/force"].attrs.items() if isinstance(text, str)}
        assert about == {"units": "N", "symbol": "F", "long_name": "peak force"}
        assert file["table/force"].dims[0][0] == file["table/row"] and file["table/row"][()].tolist() == [*range(9)]
    content = (toy.root / "table.h5").read_bytes()
    again, _ = run(toy, GRID)
    assert (first["computed_now"], again["computed_now"], again["reused"]) == (9, 0, 9)
    assert (toy.root / "table.h5").read_bytes() == content
    other, _ = run(toy, "stage: bounce\nkind: list\npoints:\n  - {ground.gravity: 5, fall.steps: 9}\n"
                        "  - {ground.gravity: 6, fall.steps: 9}\n")  # fmt: skip
    assert (other["reused"], other["computed_now"]) == (1, 1)
    toy.edit("PACKAGE/body/motion.py", "0.5 * gravity", "0.25 * gravity")
    again, columns = run(toy, GRID)
    assert again["computed_now"] == 9
    assert columns["force"] == pytest.approx(0.25 * columns["ground.gravity"] * 1e5, rel=1e-12)


def test_a_sweep_gives_what_run_gives(toy):
    _, columns = run(toy, "stage: fall\nkind: list\noutputs: [height, mass.*, sample.distance.*]\npoints:\n"
                          "  - {fall.height: 3.5, fall.parts.1.mass: 0.7}\n  - {fall.steps: 4}\n")  # fmt: skip
    toy.run("fall.height=3.5", "fall.parts.1.mass=0.7", names=("fall",))
    with h5py.File(toy.root / "results/fall.h5") as file:
        assert columns["height"][0] == file["height"][()] == 3.5
        assert columns["mass.shell"][0] == file["mass/shell"][()] == 0.7
        assert columns["fall.height"][1] == columns["height"][1] == 2.0 and columns["fall.steps"][0] == 5
        assert columns["sample.distance.4"][0] == file["sample/distance"][4] and "sample.time.4" not in columns


def test_code_edited_during_a_sweep_is_refused(toy):
    sweep = toy.sweep(GRID)
    job = sweep.chain.job(Display())
    toy.edit("PACKAGE/body/motion.py", "0.5 * gravity", "0.25 * gravity")
    sweep.chain.job = lambda display: job
    with pytest.raises(StudyError, match=r"motion\.py differs from what the sweep was started with"):
        sweep.run(toy.root / "table.h5", 1)


def test_stages_that_no_point_touches_are_computed_once_and_shared(toy):
    _, columns = run(toy, "stage: bounce\nkind: grid\nvary: {ground.contact_stiffness: [1, 2e5]}\n")
    assert (toy.root / "results/fall.h5").exists()
    assert columns["force"] == pytest.approx([4.905, 4.905 * 2e5], rel=1e-12)


@pytest.mark.parametrize("varied", ["side.seed: [3, 4, 3, 5]", "picture.title: [a, b, c, d]"])
def test_files_of_stages_above_reach_every_point(toy, varied):
    """Made with the point or before all of them, `side.bin` is there as a file, and it is the right one."""
    toy.edit("PACKAGE/picture/run.py", "    title =", "    raise ValueError(inputs.side.read_bytes()[0])\n    title =")
    _, columns = run(toy, f"stage: picture\nkind: grid\nvary: {{{varied}}}\n", workers=1)
    seeds = columns.get("side.seed", [3] * 4)
    expected = [f"ValueError: {random.Random(int(seed)).randrange(1000) % 256} (run.py:" for seed in seeds]
    assert [reason.rpartition(":")[0] + ":" for reason in columns["reason"]] == expected


def test_failures_are_rows_with_reasons(toy):
    text = """
stage: fall
kind: list
time_limit_s: 1
start_limit_s: 60
points:
  - {fall.behaviour: well}
  - {fall.behaviour: answer}
  - {fall.behaviour: raise}
  - {fall.behaviour: sleep}
  - {fall.behaviour: crash}
  - {fall.behaviour: well, fall.height: 7}
"""
    _, columns = run(toy, text, workers=1)  # so that the sleeping point is not the first of a process
    assert columns["outcome"] == ["computed", "no answer", "error", "time limit", "crash", "computed"]
    reasons = columns["reason"]
    assert reasons[1] == "nothing falls upwards" and reasons[0] == ""
    assert reasons[2].startswith("ZeroDivisionError: a pendulum without length (run.py:")
    assert reasons[3] == "took longer than 1 s"
    assert reasons[4] == "its process was ended by the system (SIGSEGV), twice"
    assert np.isnan(columns["height"][1:5]).all() and columns["height"][5] == 7
    again, _ = run(toy, text.replace("crash", "raise").replace("sleep", "raise"))
    assert (again["reused"], again["computed_now"]) == (3, 1)  # only results and reasoned refusals are kept


def test_values_that_break_a_rule_are_rows_and_illegal_limits_are_refused(toy):
    _, columns = run(toy, "stage: bounce\nkind: grid\nvary: {ground.dynamic_friction: [0.9, 1.2]}\n")
    assert columns["outcome"] == ["computed", "not allowed"]
    assert columns["reason"][1] == "dynamic_friction = 1.2 is not allowed; allowed: <= static_friction = 1.1"
    with pytest.raises(StudyError) as refused:
        run(toy, "stage: fall\nkind: grid\nvary: {ground.gravity: {low: -1, high: 9, steps: 2}, fall.steps: [1.5]}\n")
    file = toy.root / "sweep.yaml"
    assert refused.value.sentences == (
        f"{file}: ground.gravity = -1 m/s^2 is not allowed; allowed: > 0 and <= 100 m/s^2",
        f"{file}: fall.steps = 1.5 is not a whole number; allowed: >= 1",
    )


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("kind: grid", "sweep.yaml: stage is missing"),
        ("stage: fal\nkind: grid\nvary: {fall.steps: [1]}", 'there is no stage "fal"'),
        ("stage: fall\nkind: cube\nvary: {fall.steps: [1]}",
         'sweep.yaml:2: kind = "cube" is not allowed; allowed: grid'),
        ("stage: fall\nkind: grid\nvary: {fall.step: [1]}",
         'yaml: fall.step: there is no parameter "step" in fall; did you mean'),
        ("stage: fall\nkind: grid\nvary: {side.seed: [1]}", "side.seed: stage fall does not depend on this parameter"),
        ("stage: fall\nkind: grid\nvary: {fall.height: {low: 1, high: 2}}", "sweep.yaml:3: vary: fall.height: steps"),
        ("stage: fall\nkind: monte_carlo\nvary: {fall.steps: [1]}\nseed: 1", "sweep.yaml: count is missing"),
        ("stage: fall\nkind: grid\nvary: {fall.height: {low: 2, high: 1, steps: 2}}",
         "sweep.yaml:3: vary: fall.height: high = 1 is not allowed; allowed: > low = 2"),
        ("stage: fall\nkind: grid\nvary: {fall.height: {low: 1, hihg: 2, steps: 2}}",
         'sweep.yaml:3: vary: fall.height has an unknown column "hihg"; did you mean "high"?'),
        ("stage: fall\nkind: grid\nvary: {fall.height: {mean: 1, deviation: 2}}", "a distribution has no grid"),
        ("stage: fall\nkind: monte_carlo\nvary: {fall.height: {mean: 1, deviation: 0}}\nseed: 1\ncount: 2",
         "sweep.yaml:3: vary: fall.height: deviation = 0 is not allowed; allowed: > 0"),
        ("stage: fall\nkind: monte_carlo\nvary: {fall.height: {low: 0, high: 1, scale: log}}\nseed: 1\ncount: 2",
         "sweep.yaml:3: vary: fall.height: low = 0 is not allowed; allowed: > 0 where the scale is log"),
        ("stage: fall\nkind: grid\nvary: {fall.steps: []}", "sweep.yaml:3: vary: fall.steps = [] is not allowed"),
        ("stage: fall\nkind: grid\nvary: 3", "sweep.yaml:3: vary = 3 is not a table; allowed: names like"),
        ("stage: fall\nkind: grid\nvary: {fall.steps: [1]}\nseed: 1", "a sweep of kind grid has none"),
        ("stage: fall\nkind: grid\nvary: {fall.steps: [1]}\noutputs: [3]",
         "sweep.yaml:4: outputs[0] = 3 is not a word; allowed: names or patterns such as"),
        ("stage: fall\nkind: list\npoints: [{}]", "sweep.yaml:3: points: a row without values"),
        ("stage: fall\nkind: grid\nvary:\n  fall.height: {low: 1, high: 2, steps: 4000}\n"
         "  ground.gravity: {low: 1, high: 2, steps: 4000}", "16000000 points; at most 10000000 are allowed"),
        ("stage: fall\nkind: grid\nvary: {fall.steps: [1]}\ntime: 3", 'sweep.yaml:4: there is no key "time"'),
        ("stage: fall\nkind: grid\nvary: {fall.steps: [1]}\ntime_limit_s: 0",
         "sweep.yaml:4: time_limit_s = 0 s is not allowed; allowed: >= 0.01"),
        ("stage: fall\nkind: list", "points is missing"),
    ],
)  # fmt: skip
def test_a_wrong_spec_is_refused_with_a_sentence(toy, text, sentence):
    with pytest.raises(StudyError) as refused:
        run(toy, text)
    assert any(sentence in each for each in refused.value.sentences), refused.value.sentences


def test_the_end_of_the_interval_is_of_the_last_option():
    """A Latin hypercube may draw it: its shares are a whole number less one drawn, over the count."""
    assert [Choice(("a", "b", "c")).at(share) for share in (0.0, 0.34, 1.0)] == ["a", "b", "c"]


def test_a_grid_holds_its_ends_and_decades_to_the_digit():
    assert Range(low=1e4, high=1e7, steps=4, scale="log").values() == [1e4, 1e5, 1e6, 1e7]
    assert Range(low=1400.0, high=4200.0, steps=3, scale="log").values()[::2] == [1400.0, 4200.0]


DRAWN = """
stage: fall
kind: {kind}
count: 64
seed: 5
vary:
  fall.height: {{low: 1, high: 100, scale: log}}
  ground.gravity: {{low: 2, high: 4}}
  fall.steps: [1, 2, 3, 4]
"""


@pytest.mark.parametrize("kind", ["latin_hypercube", "monte_carlo"])
def test_drawn_points_repeat_with_their_seed_and_keep_to_their_limits(tmp_path, kind):
    spec = spec_of(tmp_path, DRAWN.format(kind=kind))
    points = points_of(spec)
    assert points == points_of(spec)
    assert points != points_of(spec_of(tmp_path, DRAWN.format(kind=kind).replace("seed: 5", "seed: 6")))
    heights = np.array([point["fall.height"] for point in points])
    assert heights.min() >= 1 and heights.max() <= 100
    assert {point["fall.steps"] for point in points} == {1, 2, 3, 4}
    if kind == "latin_hypercube":  # exactly one point in each of the 64 equal parts, here of the logarithm
        assert sorted((np.log(heights) / np.log(100) * 64).astype(int)) == list(range(64))
        steps = [point["fall.steps"] for point in points]
        assert [steps.count(value) for value in (1, 2, 3, 4)] == [16] * 4


def test_normal_values_have_their_mean_and_deviation(tmp_path):
    text = "stage: fall\nkind: latin_hypercube\ncount: 4000\nseed: 1\nvary: {fall.height: {mean: 5, deviation: 0.5}}\n"
    drawn = np.array([point["fall.height"] for point in points_of(spec_of(tmp_path, text))])
    assert drawn.mean() == pytest.approx(5, abs=2e-3) and drawn.std() == pytest.approx(0.5, rel=5e-3)


SLOW = f"stage: side\nkind: grid\nset: {{side.wait: 0.1}}\nvary: {{side.seed: {list(range(16))}}}\n"


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc to find the workers")
def test_points_are_handed_out_once_by_the_time_they_take_and_the_end_is_shared():
    points = pool.Chunks(range(1000), str, workers=2)
    handed = [points.take()]
    assert len(handed[0]) == 1, "nothing is known of how long one takes"
    points.took(1, 1e-3)
    handed.append(points.take())
    assert len(handed[1]) == 250, "a worker's half of its share of what is left"
    points.took(250, 250 * 0.1 - 1e-3)
    handed.append(points.take())
    assert len(handed[2]) == pytest.approx(pool._TARGET_S / 0.1, abs=1)
    points.took(1, 1e6)
    assert len(points.take()) == 1
    points.took(10**9, 0.0)
    while handed[-1]:
        handed.append(points.take())
    assert len(handed[-2]) == 1 and sum(map(len, handed)) == 999
    assert len({name for chunk in handed for name in chunk}) == 999


def test_killed_workers_lose_nothing(toy):
    first, killed, before = [], [], {*workers(os.getpid())}

    class Killing(Display):
        def points(self, done, total, sentence):  # the first two workers, one after the other
            if done == 3:
                first.extend(pid for pid in workers(os.getpid()) if pid not in before)
            if done in (3, 9) and first:
                killed.append(first.pop())
                os.kill(killed[-1], signal.SIGKILL)

    summary, columns = run(toy, SLOW, shows=Killing)
    assert len(killed) == 2 and summary["outcomes"] == {"computed": 16}
    assert columns["side.seed"].tolist() == list(range(16))
    undisturbed, right = run(toy, SLOW)
    assert undisturbed["computed_now"] == 0 and columns["number"].tolist() == right["number"].tolist()


def test_only_deaths_at_the_same_point_are_counted_together(toy, monkeypatch):
    bench = Bench(toy.sweep(SLOW).chain.job(Display()))
    #: Of each worker the points that it computes, and the one that it dies at; -1 before it begins one.
    attempts = iter([((), -1), ((), 0), ((), -1), ((0,), 1), ((), 1), ((2,), None)])

    def attempt(waiting):
        done, dies = next(attempts)
        for index in done:
            del waiting[index]
            yield index, Row("computed", "", {})
        return (-1, "") if dies is None else (dies, "dead")

    monkeypatch.setattr(bench, "_attempt", attempt)
    rows = dict(bench.work([(0, ""), (1, ""), (2, "")]))
    assert [rows[index].outcome for index in range(3)] == ["computed", "crash", "computed"]


def test_results_that_come_twice_count_once(toy, monkeypatch):
    once = pool.compute

    def twice(*arguments):
        for index, row in once(*arguments):
            yield index, row
            yield index, Row("computed", "", {"force": -1.0})

    monkeypatch.setattr(pool, "compute", twice)
    summary, columns = run(toy, GRID)
    assert summary["outcomes"] == {"computed": 9} and (columns["force"] > 0).all()
    journal = next((toy.root / "results/sweeps/.cache").glob("*.jsonl")).read_text().splitlines()
    assert len(journal) == len({json.loads(line[17:])["key"] for line in journal}) == 9


def test_results_that_are_named_as_a_sweeps_own_columns_have_their_stage_before_them(toy, monkeypatch):
    """Stage twin tells an outcome: its sweeps ended with a traceback, without a table."""
    once = pool.compute
    monkeypatch.setattr(pool, "compute", lambda *arguments: (
        (index, Row(row.outcome, row.reason, {**row.values, "outcome": "fell"})) for index, row in once(*arguments)))
    _, columns = run(toy, GRID)
    assert (set(columns["outcome"]), set(columns["bounce.outcome"])) == ({"computed"}, {"fell"})


def test_results_that_never_come_are_told(toy, monkeypatch):
    once = pool.compute
    monkeypatch.setattr(pool, "compute", lambda *arguments: list(once(*arguments))[1:])
    with pytest.raises(StudyError, match="1 points did not come back"):
        run(toy, GRID)


def test_equal_points_are_computed_once_and_are_a_row_each(toy):
    summary, columns = run(toy, "stage: side\nkind: list\npoints: [{side.seed: 4}, {side.seed: 4}, {side.seed: 4}]\n")
    assert summary["computed_now"] == 1 and len(set(columns["number"])) == 1 and len(columns["number"]) == 3


def test_a_damaged_journal_costs_only_its_damaged_lines(toy):
    _, right = run(toy, GRID)
    journal = next((toy.root / "results/sweeps/.cache").glob("*.jsonl"))
    lines = journal.read_bytes().splitlines(keepends=True)
    edited, torn = lines[0].replace(b'"force": ', b'"force": 1'), lines[-1][:-20]
    journal.write_bytes(b"".join([b"\xff\x00 nonsense\n\n", edited, *lines[1:-1], torn]))
    again, columns = run(toy, GRID)
    assert again["computed_now"] == 2
    assert columns["force"].tolist() == right["force"].tolist()
    assert run(toy, GRID)[0]["computed_now"] == 0


@pytest.mark.parametrize("every", [0.0, 100.0])
def test_a_disk_that_is_full_names_the_journal(tmp_path, monkeypatch, every):
    """It said "No space left on device", of no file."""
    journal = pool.Journal(path := tmp_path / "points.jsonl")
    journal._file = SimpleNamespace(seek=lambda *where: 0, write=len, flush=refused, close=refused)
    monkeypatch.setattr(pool, "_SYNC_EVERY_S", every)
    for fails in (lambda: journal.add("1", Row("computed", "", {})), journal.close):
        with pytest.raises(OSError) as error:
            fails()
        assert (error.value.errno, error.value.filename) == (errno.ENOSPC, str(path))


def refused():
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_how_far_a_sweep_is_said_now_and_then(capsys, monkeypatch):
    now = iter(range(0, 40, 4))
    monkeypatch.setattr("time.monotonic", lambda: next(now))
    shows = Display(quiet=False)
    for done in (1, 2, 3):
        shows.points(done, 9, how_far(done, 9, 1, 4.0 * done))
    assert capsys.readouterr().err == "3 of 9 points, 1 without result, 0.25 points/s, 24 s left\n"


@pytest.mark.parametrize(("seconds", "said"), [(42.6, "43 s"), (103, "1 min 43 s"), (11400, "3 h 10 min"),
                                               (190_000, "2 d 4 h")])  # fmt: skip
def test_times_are_said_as_people_say_them(seconds, said):
    assert duration(seconds) == said


def test_every_key_of_a_sweeps_file_stands_in_its_documentation(repository):
    text = (repository / "docs/sweeps.md").read_text()
    keys = [name for cls in (specs.Spec, Range, Normal) for name, (field, _) in declared(cls).items() if field.metadata]
    assert "time_limit_s" in keys and [key for key in keys if f"{key}:" not in text] == []


def test_the_command(toy_with_commands):
    toy = toy_with_commands
    (toy.root / "grid.yaml").write_text(GRID)
    lines = toy.says("sweep grid.yaml --jobs 1").splitlines()
    assert (lines[0], lines[-1]) == ("9 points: 9 computed; 0 were known", "table: results/sweeps/grid.h5")
    told = toy.answers("sweep grid.yaml --json", "show results/sweeps/grid.h5", "sweep none.yaml")
    (_, again, _), (code, shown, _), refused = told.values()
    assert json.loads(again)["reused"] == 9
    assert code == 0 and any(line.split()[:1] == ["force"] for line in shown.splitlines())
    assert refused == (2, "", "error: none.yaml: there is no such file\n")
    (toy.root / "tall.yaml").write_text(GRID.replace("stage: bounce", "stage: fall"))  # a stage with tables of its own
    toy.says("sweep tall.yaml --jobs 1")
    toy.says("show results/sweeps/tall.h5", "stage fall", "height")
    toy.says("sweep grid.yaml --set fall.behaviour=answer --set fall.height=1", "9 no answer", code=3)


@pytest.mark.skipif(os.name != "posix", reason="uses POSIX signals")
def test_an_interrupted_sweep_goes_on_where_it_was_and_leaves_no_file_behind(toy_with_commands, tmp_path_factory):
    toy, temporary = toy_with_commands, tmp_path_factory.mktemp("temporary")
    (toy.root / "slow.yaml").write_text(SLOW)
    process = toy.start("sweep", "slow.yaml", "--jobs", "1", environment={"TMPDIR": str(temporary)})
    journals = toy.root / "results/sweeps/.cache"
    end = time.monotonic() + 120
    while time.monotonic() < end and sum(len(p.read_bytes().splitlines()) for p in journals.glob("*.jsonl")) < 3:
        time.sleep(0.02)
    (scratch,) = temporary.glob("bipedstudy-sweep-*")
    (scratch / "left").touch()
    process.kill()
    process.communicate()
    answer = json.loads(toy.says("sweep slow.yaml --json"))
    assert not [*temporary.glob("bipedstudy-sweep-*/*")]
    assert answer["reused"] >= 3 and answer["reused"] + answer["computed_now"] == 16
    assert answer["outcomes"] == {"computed": 16}
