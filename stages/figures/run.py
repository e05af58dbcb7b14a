"""Figures stage: the paper's figures and others, each with a caption. The folder `drawn` is their register.

Inputs: the results of the stages they show. Settings: params/comparison.yaml. Outputs: `Result`, figures,
captions.yaml.
"""

from __future__ import annotations

import gc
import importlib
import json
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stages.biped.processes import each_in_a_process
from stages.biped.progress import Progress, ignore
from stages.biped.quantity import quantity
from stages.comparison.runs.measurement import MeasurementAgreement
from stages.comparison.stride import NoEvidence
from stages.figures.drawn import NAMES, draw, figure
from stages.figures.inputs import Inputs
from stages.figures.parameters import Parameters

#: How the caption of a figure begins that could not be drawn.
NOT_DRAWN = "Not drawn: "


@dataclass(frozen=True)
class Caption:
    """What a figure shows."""

    name: str = quantity("-", "name of the figure and of its files")
    title: str = quantity("-", "title")
    text: str = quantity("-", "what it shows, with the study's own numbers")
    claims: tuple[str, ...] = quantity("-", "claims that it shows something of", default=())
    opens: bool = quantity("-", "whether a report begins with it", default=False)
    beside_parameters: bool = quantity("-", "whether a report shows it beside the parameters", default=False)
    shows: tuple[str, ...] = quantity("-", "stages whose results it shows", default=())


@dataclass(frozen=True)
class Result:
    """The captions in the order of a report, and the files."""

    captions: tuple[Caption, ...] = quantity("-", "what the figures show")
    synthetic: str = quantity("-", "what of the study is made up")
    files: dict[str, bytes] = quantity("-", "figures and captions, by path in the results folder")

    def summary(self) -> str:
        """Figures counted."""
        missing = sum(caption.text.startswith(NOT_DRAWN) for caption in self.captions)
        return f"{len(self.captions) - missing} figures" + (f", {missing} not drawn" if missing else "")


#: Title of the report.
TITLE = "A passive biped and its digital twin: report"


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Draw all figures and write their captions. All cores draw: laying out and embedding fonts takes seconds.

    The caption of one that cannot be drawn says why; the account of an error that was not foreseen is kept as its log.
    """
    names = sorted(NAMES, key=lambda name: (figure(name).PLACE, name))
    drawn = {}
    if parameters.settings.pdf:
        importlib.import_module("matplotlib.backends.backend_pdf")  # once for all processes
    for number, files_and_text in each_in_a_process(_draw, names, parameters, vars(inputs)):
        drawn[names[number]] = files_and_text
        progress(len(drawn) / len(names), f"drew {names[number]}")
    captions = tuple(_caption(name, drawn[name][1]) for name in names)
    files = {path: content for pictures, _ in drawn.values() for path, content in pictures.items()}
    made_up = synthetic(inputs.comparison.measurement if inputs.comparison else None)
    return Result(captions, made_up, {"captions.yaml": as_yaml(captions, made_up), **files})


def _draw(parameters: Parameters, results: Mapping[str, Any], name: str) -> tuple[dict[str, bytes], str]:
    gc.disable()  # this process ends with the stage: to look for garbage between figures takes a twentieth of the time
    missing: Mapping[str, str] = results.get("missing", {})
    try:
        for reason in filter(None, map(missing.get, figure(name).INPUTS)):
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
    places = getattr(about, "OPENS", False), getattr(about, "BESIDE_PARAMETERS", False)
    return Caption(name, about.TITLE, text, getattr(about, "CLAIMS", ()), *places, about.INPUTS)


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


def as_yaml(captions: Sequence[Caption], made_up: str) -> bytes:
    """Captions as YAML below the words on what is made up. JSON strings are YAML strings."""

    def quoted(text: str) -> str:
        return json.dumps(text, ensure_ascii=False)

    lines = ["# Generated by the stage figures: what the figures show.", f"title: {quoted(TITLE)}"]
    lines += [f"synthetic: {quoted(made_up)}", "figures:"]
    for one in captions:
        lines += [f"- name: {one.name}", f"  title: {quoted(one.title)}", f"  text: {quoted(one.text)}"]
        lines += [f"  claims: {json.dumps(one.claims)}", f"  opens: {json.dumps(one.opens)}"]
        lines += [f"  beside_parameters: {json.dumps(one.beside_parameters)}", f"  shows: {json.dumps(one.shows)}"]
    return ("\n".join(lines) + "\n").encode()
