"""The calibration stage: what the campaign's sensors can tell of the design.

No inputs. Settings: params/calibration.yaml and the sensors of params/campaign.yaml. Output: `Result`.
"""

from __future__ import annotations

from stages.biped.progress import Progress, ignore
from stages.calibration.information.experiments import weighed
from stages.calibration.information.identifiability import identifiability
from stages.calibration.information.plan import plan_of, planned_equations
from stages.calibration.information.words import described
from stages.calibration.parameters import Parameters
from stages.calibration.result import Result, Told


def run(parameters: Parameters, inputs: None = None, progress: Progress = ignore) -> Result:
    """Plan a run of the campaign on the design's own gait, and sense it. Raises NoGait."""
    progress(0.1, "what the sensors can tell")
    plan = plan_of(parameters)
    equations, model = planned_equations(plan, parameters)
    names = (*model.shared, *model.own)
    units = [plan.design.unit(name) for name in names]
    plain = identifiability(plan.design, equations, model, ())
    known, runs = (weighed(plan),), parameters.settings.planned_runs
    one, all_runs = (identifiability(plan.design, equations, model, known, count) for count in (1, runs))
    told = tuple(
        Told(name, units[row], float(one.values[row]), float(one.sd[row]), float(all_runs.sd[row]),
             all_runs.partners[row].name, all_runs.partners[row].correlation)
        for row, name in enumerate(names)
    )
    return Result(runs, told, tuple(described(each, names, units, plain.values) for each in plain.unseen))
