"""The stage of rough ground: every model is counted alike, and its intervals are those of its draws."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.parameters.loading import load
from stages.analytic.errors import NoGait
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.parameters import Parameters as Analytic
from stages.analytic.result import OTHERWISE, REACHES
from stages.analytic.run import run as analytic
from stages.ground.blocks import Blocks
from stages.rough_ground import run as stage
from stages.rough_ground.parameters import Parameters
from stages.rough_ground.result import CONSTRAINT, PENALTY, TWIN, OnHeight, Result
from stages.rough_ground.run import CHANGED, LONGEST, Inputs, counting, run
from stages.stability.blocks.passage import Counted
from stages.stability.blocks.walks import Walk
from tests.planar_start import SLOPE, TABLE_1
from tests.study import parameters_of


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


def test_every_model_walks_its_heights_over_one_step_fewer_than_the_ramp_has_sets(monkeypatch):
    """The twin the two largest alone. A block is no longer than the feet come apart."""
    parameters, walked = parameters_of("rough_ground", "rough_ground.heights=3"), []

    def counted(walk, blocks, ramp, steps, ramps):
        walked.append((walk, blocks.block_height_rms, blocks.block_length, ramp, steps, ramps))
        return Counted(ramp)

    models = {CONSTRAINT: ("c", 100, 10), PENALTY: ("p", 30, 2), TWIN: ("t", 4, 0)}
    for name, made in (("counting", counted), ("walkers", lambda *_: models), ("norms", lambda *_: ()),
                       ("front", lambda *_: ()), ("norm_of", lambda *_: (72.6, None)), ("section_of", lambda *_: None)):
        monkeypatch.setattr(stage, name, made)
    gait = SimpleNamespace(stable=True, fixed_point=None)
    inputs = Inputs(SimpleNamespace(gait=gait, limp=SimpleNamespace(feet_apart_m=np.array([0.16, 0.05]))))
    found, settings = run(parameters, inputs), parameters.settings
    least, most = (share * parameters.biped.leg_length for share in (settings.height_from, settings.height_to))
    of_each = [(model, height) for height, own in ((least, 2), ((least * most) ** 0.5, 3), (most, 3))
               for model in (CONSTRAINT, PENALTY, TWIN)[:own]]  # fmt: skip
    assert [row.model for row in found.passages] == [model for model, _ in of_each]
    assert [row.block_height_rms for row in found.passages] == pytest.approx([height for _, height in of_each])
    assert walked == [(models[row.model][0], row.block_height_rms, 0.05, 10, *models[row.model][1:])
                      for row in found.passages]  # fmt: skip
    gait.stable = False
    with pytest.raises(NoGait, match="the gait is unstable"):
        run(parameters, inputs)


def test_a_search_is_within_a_factor_of_the_masses_and_says_on_which_bounds_it_lies():
    design, shares = DesignPoint(TABLE_1, SLOPE), (1 / 1.25, 1.25)
    masses = {name: pytest.approx([share * design.value(name) for share in shares])
              for name in ("biped.hip_mass", "biped.foot_mass")}  # fmt: skip
    radius = {"biped.foot_radius": (TABLE_1.foot_radius, 0.9 * TABLE_1.leg_length)}
    assert stage.bounds_of(design, 1.25) == masses | radius
    round_feet = DesignPoint(replace(TABLE_1, foot_radius=0.95 * TABLE_1.leg_length), SLOPE)
    assert stage.bounds_of(round_feet, 1.25) == masses
    for speed, said in ((0.30001, "speed, biped.hip_mass largest"), (0.3001, "biped.hip_mass largest")):
        best = SimpleNamespace(gait=SimpleNamespace(speed_m_s=speed))
        assert stage.stops(SimpleNamespace(best=best, bounds={"biped.hip_mass": "largest"}), (0.3, 0.5)) == said


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
