"""The error of a number is by what it differs where solvers are closer: in the file, in `show`, in stages below."""

import dataclasses
import io
import json
from dataclasses import field, make_dataclass
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from pipeline.cache import artefact
from pipeline.cache.artefact import SAFE, SHARED
from pipeline.cache.differences import ROUND_OFF, closer, differences
from pipeline.execution.display import Display
from pipeline.execution.inputs import _read_whole
from pipeline.home import stage_module
from pipeline.study import Study
from stages.biped.accuracy.tolerances import CLOSER, CUSTOM
from stages.biped.quantity import quantity
from stages.comparison.claims import judge
from stages.contact_study.result import Candidates, RigidLimit
from stages.error_budget.result import Convergence
from stages.imu.trial.agreement import Agreement

ROOT = Path(__file__).resolve().parents[2]
#: The toy's settings that stand for a solver's.
GRAVITY, HEIGHT = 'parameter("m/s^2", "gravity", symbol="g",', 'parameter("m", "height",'


def closer_toy(toy):
    """A toy study whose gravity is a half larger, and whose height an eighth, where solvers are closer."""
    toy.edit("PACKAGE/fall/parameters.py", GRAVITY, f"{GRAVITY} closer=1.5,")
    toy.edit("PACKAGE/fall/parameters.py", HEIGHT, f"{HEIGHT} closer=1.125,")
    return toy


@pytest.fixture
def falling(toy):
    """For runs from this process."""
    return closer_toy(toy)


def errors(toy, stage):
    """Path -> error in a stage's artefact, and why there are none."""
    content = (toy.root / f"results/{stage}.h5").read_bytes()
    with h5py.File(toy.root / f"results/{stage}.h5") as file:
        why = file.attrs.get("without_errors", "")
    return {each.path: each.error for each in artefact.tree(content, stage) if each.error is not None}, why


def test_a_number_carries_its_error_and_hands_it_on(falling, monkeypatch):
    told = []
    monkeypatch.setattr(Display, "progress", lambda *of: told.append(of[-1]))
    falling.run(names=("bounce", "side"), jobs=1)
    assert told.count("once more, closer, for the errors of its numbers") == 2, "side has no solver"
    found, why = errors(falling, "fall")
    assert found["height"] == SAFE * 0.25 and not why
    assert found["mass/ball"] == pytest.approx(ROUND_OFF * np.spacing(0.1), rel=0.05), "no less than round-off"
    content = (falling.root / "results/fall.h5").read_bytes()
    with h5py.File(falling.root / "results/fall.h5") as file, h5py.File(falling.root / "results/bounce.h5") as below:
        distance, other = file["sample/distance"], file["closer/sample/distance"]
        np.testing.assert_allclose(other[()], 1.5 * distance[()])
        assert found["sample/distance"] == pytest.approx(SAFE * 0.5 * distance[-1], rel=0.05)
        assert below["force"].attrs["numerical_error"] == pytest.approx(SAFE * 0.5 * below["force"][()], rel=0.05)
    assert not any(each.path.startswith("closer") for each in artefact.tree(content, "fall"))
    assert errors(falling, "side") == ({}, ""), "it has no solver, and reads none's result"


def test_a_number_that_is_zero_in_both_has_no_round_off():
    """It was 64 times the least of all floats: show said 0 +- 3e-322."""
    Stance = make_dataclass("Stance", [("time", float, quantity("s", "both feet down"))])
    with h5py.File(io.BytesIO(artefact.encoded(Stance(0.0), {}, closer=Stance(0.0))[1])) as file:
        assert file["time"].attrs["numerical_error"] == 0.0


def test_claims_are_as_safe_as_artefacts():
    assert judge.SAFE == SAFE, "neither imports the other"


def test_what_the_solver_chooses_has_no_error_and_says_why():
    length = quantity("s", "a step", without_error="the solver's choice")
    Steps = make_dataclass("Steps", [("length", float, length), ("time", float, quantity("s", "its end"))])
    with h5py.File(io.BytesIO(artefact.encoded(Steps(1.0, 1.0), {}, closer=Steps(2.0, 1.5))[1])) as file:
        assert "numerical_error" not in file["length"].attrs
        assert file["length"].attrs["without_error"] == "the solver's choice"
        assert file["time"].attrs["numerical_error"] == SAFE * 0.5


@pytest.mark.parametrize(("result", "name"), [
    (RigidLimit, "most_evaluations"), (Agreement, "envelope_share"),
    (Candidates, "damping_depth"), (Candidates, "stiction_velocity"), (Convergence, "share")])
def test_what_is_counted_or_set_has_no_error_of_round_off_or_of_numbers_beside_it(result, name):
    assert result.__dataclass_fields__[name].metadata["without_error"]


def test_of_two_results_over_fewer_points_the_difference_is_the_error():
    fields = (("height", float, quantity("m", "mean")), ("each", np.ndarray, quantity("m", "all")))
    Mean = make_dataclass("Mean", fields)
    whole, few, closer = (Mean(float(np.mean(each)), np.array(each))
                          for each in ((1.0, 2.0, 6.0), (1.0, 2.0), (1.5, 3.0)))  # fmt: skip
    content = artefact.encoded(whole, {}, closer=(few, closer))[1]
    with h5py.File(io.BytesIO(content)) as file:
        assert file["height"][()] == 3.0 and file["closer/height"][()] == 2.25
        assert file["height"].attrs["numerical_error"] == pytest.approx(SAFE * 0.75, rel=0.03), "in two digits"
        assert file["each"].attrs["numerical_error"] == SAFE * 1.0


def test_show_prints_it_or_why_there_is_none(toy_with_commands):
    toy, once = closer_toy(toy_with_commands), "it is drawn once"
    path = toy.path("PACKAGE/side/run.py")
    path.write_text(f'{path.read_text()}\n\nONCE = "{once}"\n')
    toy.says("run fall side")
    assert errors(toy, "side") == ({}, once)
    fall, side, told, why = toy.shows("show fall", "show side", "show fall --json", "show side --json")
    height, ball = (next(line for line in fall.splitlines() if line.split()[:1] == [at]) for at in ("height", "ball"))
    assert " +- 8e-01 m" in height and "+-" not in ball, "its error is round-off"
    fields = {field["path"]: field for field in json.loads(told)["fields"]}
    assert fields["height"]["numerical_error"] == SAFE * 0.25
    assert f"its numbers carry no errors: {once}" in side and json.loads(why)["without_errors"] == once


def test_a_result_stands_where_closer_solvers_fail_and_says_so(falling):
    falling.edit("PACKAGE/fall/run.py", "    files = ", """    if parameters.gravity.gravity > 14:
        raise ValueError("too heavy")
    files = """)
    falling.run(names=("bounce",))
    assert errors(falling, "fall") == ({}, "at closer settings: too heavy") and errors(falling, "bounce") == ({}, "")


def test_a_stage_that_compares_reads_both(falling):
    falling.edit("PACKAGE/bounce/run.py", "    fall: Fall\n", '    fall: Fall\n    closer: "Inputs | None" = None\n')
    falling.edit("PACKAGE/bounce/run.py", "    fall = inputs.fall\n", """    if inputs.closer is not None:
        return Result(inputs.closer.fall.height - inputs.fall.height)
    fall = inputs.fall
""")
    falling.run(names=("bounce",))
    with h5py.File(falling.root / "results/bounce.h5") as file:
        assert file["force"][()] == 0.25


def test_a_stage_that_reads_files_beside_a_closed_result_has_them_of_closer_solvers(falling):
    falling.edit("dvc.yaml", "outs: [results/fall.h5]", "outs: [results/fall.h5, results/track.txt]")
    falling.edit("dvc.yaml", "results/fall.h5]\n    params:", "results/fall.h5, results/track.txt]\n    params:")
    track = '{"track.txt": str(parameters.gravity.gravity).encode()}'
    falling.edit("PACKAGE/fall/run.py", "settings.parts}, files)", f"settings.parts}}, {track})")
    falling.edit("PACKAGE/bounce/run.py", "    fall: Fall\n", "    fall: Path\n    track: Path\n")
    falling.edit("PACKAGE/bounce/run.py", "from dataclasses", "from pathlib import Path\nfrom dataclasses")
    track = "    return Result(float(inputs.track.read_text()))\n"
    falling.edit("PACKAGE/bounce/run.py", "    fall = inputs.fall\n", track)
    falling.run(names=("bounce",))
    assert errors(falling, "bounce")[0] == {"force": pytest.approx(SAFE * 0.5 * 9.81, rel=0.05)}


def test_a_stage_that_solves_nothing_is_made_again_where_something_above_is_closer(toy):
    toy.edit("PACKAGE/bounce/run.py", "def run(", """ONCE = "it solves nothing"


def again(parameters, inputs, result):
    return Result(1.0), Result(3.0)


def run(""")
    toy.run(names=("bounce",))
    assert errors(toy, "bounce") == ({}, "it solves nothing")
    closer_toy(toy).run(names=("bounce",))
    assert errors(toy, "bounce") == ({"force": SAFE * 2.0}, "")


def test_a_stage_may_take_its_closer_result_from_what_it_found(falling):
    path = falling.path("PACKAGE/fall/run.py")
    path.write_text(f"""import dataclasses

{path.read_text()}

def again(parameters, inputs, result):
    return dataclasses.replace(result, height=result.height + 0.5)
""")
    falling.run(names=("fall",))
    assert errors(falling, "fall")[0]["height"] == SAFE * 0.5


def test_every_stage_that_solves_has_closer_settings_or_says_why_not():
    study = Study(ROOT, ROOT / "params", ROOT / "results", (), requested=(("accuracy", "paper"),))
    solved = set()
    for name, parameters in study.parameters(study.graph.stages).items():
        why = getattr(stage_module("stages", name, "run"), "ONCE", "")
        assert not why or len(why) > 20
        solved |= set() if why or closer(parameters) == parameters else {name}
    once = {"extremes", "figures", "imu", "model_error", "rough_ground", "tradeoff"}
    assert solved == set(study.graph.stages) - once


def test_a_closer_result_with_files_goes_to_stages_that_read_these_too():
    """The comparison has what the ingest made of the files as they are, and so the truth that belongs to them."""
    stages = Study(ROOT, ROOT / "params", ROOT / "results", ()).graph.stages.values()
    campaign = SimpleNamespace(files={"measurements.sqlite": b"", "without_outsole.sqlite": b""})
    readers = [stage for stage in stages if "results/campaign.h5" in stage.inputs]
    assert {stage.name: _read_whole(stage, campaign) for stage in readers} == {
        "calibration": True, "calibrated_twin": True, "comparison": False, "imu": True}  # fmt: skip
    assert all(_read_whole(stage, SimpleNamespace()) for stage in readers)


@pytest.mark.parametrize("level", ["draft", "paper", "reference"])
def test_closer_settings_are_so_many_times_the_tolerances_whatever_is_requested(level):
    study = Study(ROOT, ROOT / "params", ROOT / "results", (), requested=(("accuracy", level),))
    given = study.parameters(("multibody", "twin_pushes", "campaign"))
    assert all(closer(parameters).biped == parameters.biped for parameters in given.values())
    one, other = given["multibody"].settings, closer(given["multibody"]).settings
    assert other.tolerance == pytest.approx(CLOSER * one.tolerance, rel=1e-12) and other.accuracy == CUSTOM
    assert other.rolling_step == one.rolling_step / 2 and other.largest_step == one.largest_step
    pushed = [each.twin.with_tolerance(each.settings.tolerance).tolerance
              for each in (given["twin_pushes"], closer(given["twin_pushes"]))]  # fmt: skip
    assert pushed[1] == pytest.approx(CLOSER * pushed[0], rel=1e-12)
    assert closer(given["campaign"]).runs.runs == given["campaign"].runs.runs


@pytest.mark.parametrize(("stage", "tolerance", "second"), [
    ("analytic", 1e-12, 1e-11), ("analytic", 1e-11, 1e-12), ("multibody", 1e-11, 1e-10), ("multibody", 1e-10, 1e-11)])
def test_settings_that_round_off_or_a_bound_forbids_are_looser(stage, tolerance, second):
    given = Study(ROOT, ROOT / "params", ROOT / "results").parameters((stage,))[stage]
    given = dataclasses.replace(given, settings=dataclasses.replace(given.settings, tolerance=tolerance))
    assert closer(given).settings.tolerance == second


ALONG_TIME = field(metadata={"dimensions": ("time",)})
Row = make_dataclass("Row", [("name", str), ("value", float, quantity("m", "a number")),
                             ("part", np.ndarray, quantity("m", "some"))])  # fmt: skip
Computed = make_dataclass("Computed", [("number", float), ("count", int), ("time", np.ndarray), (
    "height", np.ndarray, ALONG_TIME), ("pair", np.ndarray), ("rows", tuple[Row, ...])])  # fmt: skip
Motion = make_dataclass("Motion", [("time", np.ndarray), ("place", np.ndarray)])
Motions = make_dataclass("Motions", [("runs", tuple[Motion, ...]), ("files", dict[str, bytes])])


def computed(
    number=1.0, time=(0.0, 1.0, 2.0), height=(0.0, 5.0, 7.0), pair=(1.0, 2.0), rows=("a", "b"), values=(1.0, 2.0)
):
    made = tuple(Row(name, value, np.array([value, 2 * value])) for name, value in zip(rows, values, strict=True))
    return artefact.encode(Computed(number, len(rows), np.array(time), np.array(height), np.array(pair), made), {})


def apart(one, other):
    """The differences of two artefacts that are more than round-off."""
    with artefact.opened(one, "one") as here, artefact.opened(other, "other") as there:
        return {path: size for path, (size, _) in differences(here, there) if size > 1e-12}


def test_differences_are_the_largest_over_rows_that_both_have():
    exact = computed()
    assert apart(exact, exact) == {}
    assert apart(computed(number=1.25, pair=(1.0, 1.5)), exact) == {"number": 0.25, "pair": 0.5}
    finer = computed(time=(0.0, 0.5, 1.0, 1.5, 2.0), height=(0.0, 9.0, 5.0, 9.0, 7.5))
    assert apart(exact, finer) == {"height": 0.5}
    assert apart(computed(values=(1.5, 2.0)), exact) == {"rows/value": 0.5, "rows/part": 1.0}
    assert apart(computed(values=(np.nan, 2.125)), exact) == {"rows/value": 0.125, "rows/part": 0.25}


@pytest.mark.parametrize(("later", "height"), [(0.1, {"height": 0.5}), (0.6, {})])
def test_rows_along_a_coordinate_that_is_itself_found_are_the_same_where_it_has_moved_a_little(later, height):
    """Samples of a sensor are counted in time from a strike: not one had an error."""
    moved = computed(time=np.arange(3.0) + later, height=(0.0, 5.0, 7.5))
    assert apart(moved, computed()) == pytest.approx({"time": later, **height})


def test_rows_are_the_same_where_their_words_are():
    exact = computed()
    assert apart(computed(rows=("b", "a")), exact) == {}
    more = computed(rows=("b", "c", "a"), values=(2.5, 9.0, 1.0))
    assert apart(more, exact) == {"rows/value": 0.5, "rows/part": 1.0}
    twice = computed(rows=("b", "b", "a"), values=(2.5, 9.0, 1.0))
    assert apart(twice, exact) == {}


def test_eigenvalues_are_compared_with_the_nearest_whatever_their_ranks():
    field = dataclasses.field(metadata={"unordered": "eigenvalues"})
    kind = make_dataclass("Multipliers", [("value", np.ndarray, field)])
    one, other = ([[0.573, 0.0], [-0.571, 0.0]], [[-0.572, 0.0], [0.5725, 0.0]])
    found = apart(*(artefact.encode(kind(np.array(rows)), {}) for rows in (one, other)))
    assert found == {"value": pytest.approx(1e-3)}


def test_sizes_that_differ_are_not_compared():
    assert apart(computed(pair=(5.0, 6.0, 7.0)), computed()) == {}


def motions(*ends, **files):
    """Runs of different lengths, which lie apart."""
    return Motions(tuple(Motion(np.arange(3.0 + n), np.linspace(0.0, end, 3 + n)) for n, end in enumerate(ends)), files)


@pytest.mark.parametrize(("closer", "off"), [((1.5, 2.25), (0.5, 0.25, 0.5)), ((1.0, 2.25), (0.25, 0.25, 0.25))])
def test_rows_that_are_missing_or_equal_in_the_closer_result_have_the_largest_error_of_the_others(closer, off):
    _, told = artefact.encoded(motions(1.0, 2.0, 3.0), {}, {}, motions(*closer))
    found = [each.error for each in artefact.tree(told, "x.h5") if each.path.endswith("place")]
    assert found == [SAFE * each for each in off]
    assert artefact.decode_closer(told, Motions, "x.h5") is not None


def test_a_number_that_is_equal_by_chance_has_part_of_the_largest_error_beside_it():
    _, told = artefact.encoded(Row("a", 1.0, np.array([2.0])), {}, {}, Row("a", 1.0, np.array([2.5])))
    found = {each.path: each.error for each in artefact.tree(told, "x.h5")}
    assert found == {"name": None, "value": pytest.approx(SHARED * SAFE * 0.5, rel=0.03), "part": SAFE * 0.5}


def test_numbers_of_several_units_say_nothing_of_the_error_of_others():
    """A stiffness among a fit's numbers is 5 N/m off; its share of that was the error of correlations beside them."""
    Fit = make_dataclass("Fit", (("found", np.ndarray, quantity("-", "of several units")),
                                 ("correlations", np.ndarray, quantity("-", "of their errors"))))  # fmt: skip
    one, other = Fit(np.array([2800.0, 0.1]), np.array([0.5])), Fit(np.array([2805.0, 0.1]), np.array([0.501]))
    found = {each.path: each.error for each in artefact.tree(artefact.encoded(one, {}, {}, other)[1], "x.h5")}
    assert found == {"found": SAFE * 5.0, "correlations": pytest.approx(SAFE * 1e-3)}


def test_a_closer_result_is_handed_on_with_its_files():
    _, told = artefact.encoded(motions(1.0, log=b"usual"), {}, {}, motions(1.5, log=b"x\0y"))
    assert artefact.decode_closer(told, Motions, "x.h5").files == {"log": b"x\0y"}
    assert artefact.decode(told, Motions, "x.h5").files == {}, "who reads the result reads the files beside it"
    assert [each.error for each in artefact.tree(told, "x.h5") if each.path.endswith("place")] == [SAFE * 0.5]


def test_rows_around_an_event_count_though_the_solver_finds_it_a_little_elsewhere():
    """A force rises within samples that lie where the event does; rows at even times alone said nothing of it."""
    force = quantity("N", "a blow", dimensions=("time",))
    Blow = make_dataclass("Blow", [("time", np.ndarray, quantity("s", "when", dimensions=("time",))),
                                   ("force", np.ndarray, force)])  # fmt: skip
    even, around = np.arange(5) * 0.1, 0.15 + np.arange(4) * 1e-3
    force_of = np.array([0.0, 0.0, 5.0, 9.0, 3.0, 0.0, 0.0, 0.0, 0.0])
    order = np.argsort(np.append(even, around), kind="stable")

    def blow(shift, factor):
        return Blow(np.append(even, around + shift)[order], factor * force_of)

    def error(other):
        with h5py.File(io.BytesIO(artefact.encoded(blow(0.0, 1.0), {}, closer=other)[1])) as file:
            return file["force"].attrs["numerical_error"]

    assert error(blow(1e-9, 0.5)) == pytest.approx(SAFE * 4.5, rel=0.05)
    assert error(blow(2.5e-3, 0.5)) < 1e-12, "rows further: none of them is the same"
