"""A sweep of the real analytic stage: rows are what the model says itself, a design without a gait is a row."""

import dataclasses

import h5py
import pytest

from pipeline.execution.display import Display
from pipeline.study import Study
from pipeline.sweep import spec as specs
from pipeline.sweep.sweep import Sweep

TEXT = """
stage: analytic
kind: list
set: {analytic.steps: 1}
points:
  - {ground.slope_deg: 2.0}
  - {ground.slope_deg: 3.0}
  - {ground.slope_deg: 89.0}
outputs: [gait.*]
"""


@pytest.mark.slow
def test_a_sweep_of_slopes(repository, tmp_path):
    path = tmp_path / "slopes.yaml"
    path.write_text(TEXT)
    study = Study(repository, repository / "params", tmp_path / "results")
    summary = Sweep(study, specs.read(path), Display()).run(tmp_path / "slopes.h5", 2)
    assert summary["outcomes"] == {"computed": 2, "no answer": 1}
    from stages.analytic.gait.gait_report import report_gait
    from stages.analytic.gait.gait_search import find_gait

    values = study.parameters(["analytic"])["analytic"]
    with h5py.File(tmp_path / "slopes.h5") as file:
        assert file["table/gait.period_s"].attrs["units"] == "s"
        assert "energy.work_in" not in file["table"] and file["table/reason"][2]
        for row, slope in enumerate((2.0, 3.0)):
            inclined = dataclasses.replace(values.slope, slope_deg=slope)
            walker, point = find_gait(values.biped, inclined, values.settings.tolerance, None)
            gait = report_gait(walker, point, values.settings.tolerance, values.friction.static_friction).gait
            assert file["table/gait.period_s"][row] == gait.period_s
            assert file["table/gait.floquet_multipliers.0.0"][row] == gait.floquet_multipliers[0, 0]
