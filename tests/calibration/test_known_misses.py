"""A lab's intervals: with what the study's own runs tell of the model's error, or with the reason why not."""

import dataclasses

import numpy as np
import pytest

from pipeline.cache import artefact
from pipeline.questions.asking import Asked
from pipeline.study import Study
from stages.calibration.estimation.least_squares import TOTAL_MASS, Known
from stages.calibration.information.identifiability import first_model
from stages.calibration.intervals.model_error import ALONE, Discrepancy, judged
from stages.calibration.recordings import drawn_design, looked_for
from stages.calibration.result import Misses, Result
from tests.calibration.runs import PARAMETERS

DRAWN = drawn_design(PARAMETERS)
NAMES = first_model(DRAWN, looked_for(DRAWN), PARAMETERS).shared
VALUES = np.array([DRAWN.value(name) for name in NAMES])
WEIGHED = (Known(TOTAL_MASS, 0.986, 1e-3),)
SD = 1e-3 * VALUES


def study(count=8):
    """A calibration whose other runs miss each parameter by another share, and by more where clocks are pulled."""
    rng = np.random.default_rng(3)
    pulls = 1e-3 * rng.normal(size=count)
    shares = 0.01 * np.arange(len(NAMES)) + np.outer(pulls, np.arange(len(NAMES))) + 1e-3 * rng.normal(
        size=(count, len(NAMES)))  # fmt: skip
    misses = Misses(tuple(f"run {number:02d}" for number in range(count)), shares, *np.zeros((2, count, 0)), pulls)
    return Result(30, (), (), NAMES, tuple(DRAWN.unit(name) for name in NAMES), VALUES, ("ground.slope_deg",),
                  ("hip_clock",), (), (), misses, ())


def asked(told, names=NAMES, known=WEIGHED, design=DRAWN, pull=1e-3):
    order = [NAMES.index(name) for name in names if name in NAMES]
    return judged(names, VALUES[order], SD[order], known, design, pull, told)


def test_what_other_runs_miss_is_taken_off_and_widens_the_interval():
    told = study()
    term = Discrepancy.of(NAMES, told.misses.shares, told.misses.pulls)
    backwards = NAMES[::-1]
    found = asked((told, "results/calibration.h5"), backwards)
    assert found.values[::-1] == pytest.approx(VALUES - term.expected(VALUES, 1e-3))
    assert found.sd[::-1] == pytest.approx(np.hypot(SD, np.sqrt(np.diag(term.spread(VALUES, 1e-3)))))
    assert found.other_runs == 8
    for said in ("8 runs", "results/calibration.h5", "run 00 to run 07"):
        assert said in found.words


@pytest.mark.parametrize(("change", "said"), [
    ({"told": (None, "results/calibration.h5 is not there")}, "is not there"),
    ({"told": (study(0), "it")}, "no fits of other robots"),
    ({"told": (study(3), "it")}, "3 fits of other robots' runs, which is too few"),
    ({"told": (study(), "it"), "names": NAMES[1:]}, "design: parts"),
    ({"told": (study(), "it"), "known": ()}, "the mass is known and nothing else"),
    ({"told": (study(), "it"), "known": (*WEIGHED, Known("biped.leg_length", 0.333, 1e-4))}, "nothing else"),
    ({"told": (study(), "it"), "design": DRAWN.with_value("biped.leg_length", 0.34)}, "another leg_length"),
])  # fmt: skip
def test_where_the_studys_runs_do_not_tell_it_the_answer_says_so_and_stays_as_it_is(change, said):
    found = asked(**change)
    kept = VALUES[[NAMES.index(name) for name in change.get("names", NAMES)]]
    np.testing.assert_array_equal(found.values, kept)
    assert found.sd == pytest.approx(1e-3 * kept)
    assert found.words.startswith(ALONE)
    assert said in found.words


def test_a_question_is_given_its_stages_result_or_the_reason_why_not(repository, tmp_path):
    place = Study(repository, repository / "params", tmp_path)
    asking = Asked(place, "calibration", None, PARAMETERS, 1)
    result, why = asking.result()
    assert result is None
    assert "calibration.h5 is not there" in why
    (tmp_path / "calibration.h5").write_bytes(artefact.encode(study(), {}))
    result, file = asking.result()
    assert file.endswith("calibration.h5")
    assert result.misses.runs == study().misses.runs
    np.testing.assert_array_equal(result.misses.shares, study().misses.shares)
    assert Discrepancy.from_misses(result.names, result.misses) is not None
    (tmp_path / "calibration.h5").write_bytes(artefact.encode(dataclasses.replace(study(), misses=()), {}))
    result, why = asking.result()
    assert result is None
    assert "do not fit this version" in why
    (tmp_path / "calibration.h5").write_bytes(b"no such file")
    assert asking.result()[0] is None
