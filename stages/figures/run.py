"""Figures stage: the paper's figures and others, each with a caption. The folder `drawn` is their register.

Inputs: the results of the stages they show. Settings: params/comparison.yaml. Outputs: `Result`, figures,
captions.yaml.
"""

import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stages.biped.processes import Progress, each_in_a_process, ignore
from stages.comparison.measurement import MeasurementAgreement
from stages.comparison.stride import NoEvidence
from stages.comparison.tables import as_yaml
from stages.figures.drawn import NAMES, draw, figure
from stages.figures.entry import Inputs
from stages.figures.first_screen import answers, title
from stages.figures.parameters import Parameters
from stages.figures.result import NOT_DRAWN, Caption, Result

#: Why the stage is not run once more at closer settings of solvers.
ONCE = "it draws what the other stages computed"


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Draw all figures and write their captions. All cores draw: laying out and embedding fonts takes seconds.

    The caption of one that cannot be drawn says why; the account of an error that was not foreseen is kept as its log.
    """
    names = sorted(NAMES, key=lambda name: (figure(name).place, name))
    drawn = {}
    for number, files_and_text in each_in_a_process(_draw, names, parameters, vars(inputs)):
        drawn[names[number]] = files_and_text
        progress(len(drawn) / len(names), f"drew {names[number]}")
    captions = tuple(_caption(name, drawn[name][1]) for name in names)
    files = {path: content for pictures, _ in drawn.values() for path, content in pictures.items()}
    made_up = synthetic(inputs.comparison.measurement if inputs.comparison else None)
    words = {**title(inputs.comparison), "synthetic": made_up, "answers": [one._asdict() for one in answers(inputs)],
             "figures": [vars(caption) for caption in captions]}  # fmt: skip
    return Result(captions, made_up, {"captions.yaml": as_yaml("what the figures show", words), **files})


def _draw(parameters: Parameters, results: Mapping[str, Any], name: str) -> tuple[dict[str, bytes], str]:
    missing: Mapping[str, str] = results.get("missing", {})
    try:
        about = figure(name)
        for reason in filter(None, (missing.get(key) for key in about.inputs if key not in about.without)):
            raise NoEvidence(reason)
        return draw(name, parameters, results)
    except Exception as error:
        if type(error).__module__.startswith("stages."):
            return {}, f"{NOT_DRAWN}{' '.join(str(error).split())}."
        at = traceback.extract_tb(error.__traceback__)[-1]
        words = f"unexpected {type(error).__name__} in {Path(at.filename).name}:{at.lineno}: {error}"
        return {f"figures/{name}.log": traceback.format_exc().encode()}, f"{NOT_DRAWN}{' '.join(words.split())}."


def _caption(name: str, text: str) -> Caption:
    about = figure(name)
    claims = () if text.startswith(NOT_DRAWN) else about.claims
    return Caption(name, about.title, text, claims, about.opens, about.beside_parameters, about.inputs)


def synthetic(measured: MeasurementAgreement | None) -> str:
    """What of the study is made up, in words; nothing without measurements."""
    if measured is None:
        return ""
    if measured.origin == "measured":
        return "Nothing is synthetic: the runs come from a measurement database."
    return (
        f"The {measured.runs} runs of the measurement are {measured.origin}: walks of the twin through a model of the "
        "sensors, with random pushes, slopes, outsoles and build tolerances. They test the ingest and cannot confirm "
        "the model; the claims they touch stay open, but for those that a calibration decides as a method. Figure 16 "
        "is marked."
    )
