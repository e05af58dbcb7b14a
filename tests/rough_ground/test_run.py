"""The stage of rough ground: every model is counted alike, and its intervals are those of its draws."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.parameters.loading import load
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.parameters import Parameters as Analytic
from stages.analytic.result import OTHERWISE, REACHES
from stages.analytic.run import run as analytic
from stages.ground.blocks import Blocks
from stages.rough_ground import run as stage
from stages.rough_ground.parameters import Parameters
from stages.rough_ground.result import CONSTRAINT, PENALTY, TWIN, OnHeight, Result
from stages.rough_ground.run import CHANGED, LONGEST, Inputs, counting, run
from stages.stability.blocks.walks import Walk
from tests.planar_start import SLOPE, TABLE_1


def test_walks_are_counted_to_the_last_step_and_over_the_ramp():
    """A walker that falls in every fifth step: the last walk is cut short, and no walk passes ten steps; two could not
    have, with eight steps left or three."""
    made = []

    def walk(blocks, number, most):
        made.append((number, most))
        return Walk(min(4, most), OTHERWISE if most > 4 else REACHES)

    counted = counting(walk, Blocks(1e-3), 10, 23, 3)
    assert [most for _, most in made] == [23, 18, 13, 8, 3, 10, 10, 10] and len({number for number, _ in made}) == 8
    assert (counted.steps, counted.falls, counted.passed, counted.stopped) == (23, 4, 0, 6)
    assert counted.passage().steps_to_fall == 23 / 4


def test_steps_to_a_fall_are_said_with_their_interval_and_of_each_model():
    """One fall in 4000 steps tells little, and the constraint model walks where others do not."""
    row = {"steps_to_fall": 4000.0, "steps_low": 717.9, "steps_high": 157989.0, "method": "counted", "falls": 1,
           "walked": 4000, "ramp_steps": 10, "ramp_chance": 1.0, "ramp_low": 0.9, "ramp_high": 1.0,
           "block_height_rms": 2.5e-4}  # fmt: skip
    rows = (OnHeight(**row, model=CONSTRAINT), OnHeight(**row | {"falls": 0, "walked": 500}, model=PENALTY))
    assert Result(rows, (), 72.6).summary() == (
        "on blocks of 0.25 mm: constraint model, 4000 steps to a fall (718 to 158000); penalty contact, no fall in 500 "
        "steps; gait sensitivity norm 72.6 s/m")


def test_a_gait_is_searched_from_that_of_a_design_that_is_near(monkeypatch):
    """What stands for a gait here is the design that it is of."""
    strides = []

    def searched(changed, there, *_):
        here = np.array([changed.value(name) for name in CHANGED])
        strides.append(np.abs(np.log(here / there)).max())
        return here

    monkeypatch.setattr(DesignPoint, "walker", lambda design: design)
    monkeypatch.setattr(stage, "fixed_point", lambda *of: SimpleNamespace(z=searched(*of)))
    monkeypatch.setattr(stage, "norm_of", lambda *of: (0.0, searched(*of)))
    design = DesignPoint(TABLE_1, SLOPE)
    own = np.array([design.value(name) for name in CHANGED])
    rows = list(stage.norms(design, own, SimpleNamespace(designs=5, share_to=1.25)))
    assert [row.share for row in rows] == pytest.approx([*1.25 ** np.linspace(-1.0, 1.0, 5)] * len(CHANGED))
    assert 0.0 < max(strides) <= LONGEST


@pytest.mark.slow
def test_models_agree_on_high_blocks(repository):
    known = [Parameters, Analytic]
    given = load(repository / "params", [], {"rough_ground": Parameters, "analytic": Analytic}, known)
    own = replace(given["rough_ground"].settings, height_from=1.8e-3, height_to=3e-3, heights=2, steps=1500,
                  penalty_steps=300, twin_steps=4, ramps=100, designs=5, speed_shares=(0.25,))  # fmt: skip
    found = run(replace(given["rough_ground"], settings=own), Inputs(analytic(given["analytic"])))
    for one, other in zip(found.of(CONSTRAINT), found.of(PENALTY), strict=True):
        assert one.steps_low < other.steps_high and other.steps_low < one.steps_high
        assert one.ramp_low < other.ramp_high and other.ramp_low < one.ramp_high
    assert len(found.of(TWIN)) == 2 and found.of(CONSTRAINT)[0].steps_to_fall > found.of(CONSTRAINT)[1].steps_to_fall
    norms = {(row.parameter, row.share): row.sensitivity_norm for row in found.norms}
    assert norms["biped.foot_radius", 1.25] < found.sensitivity_norm < norms["biped.foot_radius", 0.8]
    assert norms["biped.foot_radius", 1.0] == pytest.approx(found.sensitivity_norm, rel=1e-9)
    assert np.isnan(norms["biped.foot_com", 0.8]) and 72 < norms["biped.hip_mass", 1.25] < 76
    [reached], given = found.front, found.of(CONSTRAINT)[0]
    assert reached.steps_low > given.steps_high and reached.sensitivity_norm < 0.5 * found.sensitivity_norm
    assert reached.met and "speed" in reached.stopped_by
