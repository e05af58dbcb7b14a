"""The study's blind fit: the drawing it begins from, what it looks for, and how it is cut."""

import dataclasses
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from stages.calibration.blind_score import model_of
from stages.calibration.estimation.run_fit import run_equations
from stages.calibration.intervals.model_error import widening
from stages.calibration.recordings import WITH_OUTSOLE, drawn_design, first_steps, looked_for, sources, table_value
from tests.calibration.runs import DESIGN, PARAMETERS, drawn


@pytest.mark.parametrize("legs", ["compliant", "rigid"])
def test_the_drawing_is_what_the_bill_of_parts_makes_seen_from_the_side(legs):
    """With legs that differ in length by each run: rigid ones too, of which a tenth of a millimetre shows as well."""
    plain = dataclasses.replace(PARAMETERS, biped=dataclasses.replace(PARAMETERS.biped, legs=legs, leg_inertia=0.0))
    design = drawn_design(plain)
    biped = design.biped
    assert biped.hip_mass == 0.0
    counted = [table_value(biped, f"biped.{name}") for name in ("hip_mass", "foot_com")]
    assert counted == pytest.approx([0.316, 0.1], abs=5e-5)
    assert min(biped.frame_inertia, biped.leg_inertia) > 0
    assert biped.other_leg_length == biped.leg_length
    names = {*looked_for(design)}
    assert not {"biped.hip_mass", "biped.frame_com", "biped.frame_inertia", "biped.leg_inertia",
                "ground.gravity"} & names  # fmt: skip
    assert {"biped.frame_mass", "biped.leg_length", "biped.other_leg_length", "ground.slope_deg"} <= names


def test_a_biped_that_says_its_details_is_taken_as_it_is():
    detailed = dataclasses.replace(PARAMETERS.biped, frame_mass=0.05, frame_com=0.03)
    biped = drawn_design(dataclasses.replace(PARAMETERS, biped=detailed)).biped
    assert dataclasses.replace(biped, other_leg_length=None) == detailed


def test_a_robot_that_has_no_runs_is_not_looked_for():
    one = SimpleNamespace(name="run 1", weighed=0.5)
    paths = Path("with.sqlite"), Path("without.sqlite")
    both, bare = (SimpleNamespace(runs=(one,), bare=bare) for bare in ((one,), ()))
    assert [source for _, source, _ in sources(*paths, both, None)] == [*paths]
    assert sources(*paths, bare, None) == [(WITH_OUTSOLE, paths[0], {"run 1": 0.5})]


@pytest.fixture(scope="module")
def run():
    return drawn(1001).runs[0]


def test_a_run_is_cut_at_a_heel_strike(run):
    cut = first_steps(run, 5)
    assert (len(cut.strikes), len(first_steps(run, 1).strikes)) == (6, 4)  # fewer cannot be used
    assert cut.duration <= cut.strikes[-1] < run.duration and first_steps(run, 99) is run
    assert len(cut.samples["hip"]) == len(cut.sampling.hip) == len(cut.used["hip"])


def test_intervals_widen_by_size_and_by_neighbours_that_hang_together(run):
    run = first_steps(run, 5)
    _, model = model_of(PARAMETERS)
    at = run_equations(DESIGN, np.array([2.0]), model.layout.middle, run, model)
    rng = np.random.default_rng(1)
    noise = {side: np.where(np.isfinite(one), rng.normal(size=one.shape), np.nan) for side, one in at.residuals.items()}
    white = dataclasses.replace(at, residuals=noise, chi2=sum(float(np.nansum(one**2)) for one in noise.values()))
    smooth = {side: np.repeat(one[::5], 5, axis=0)[: len(one)] for side, one in noise.items()}
    rough = dataclasses.replace(at, residuals=smooth, chi2=4.0 * white.count)
    (size, wider), (larger, widest) = widening([white]), widening([rough])
    assert (size, larger) == (pytest.approx(1.0, abs=0.05), pytest.approx(2.0))
    assert wider < 1.5 and 3.0 < widest < 8.0
