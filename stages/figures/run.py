"""Figures stage: the paper's figures and others, each with a caption. The folder `drawn` is their register.

Inputs: the results of the stages they show. Settings: params/comparison.yaml. Outputs: `Result`, figures,
captions.yaml.
"""

from __future__ import annotations

from stages.biped.processes import each_in_a_process
from stages.biped.progress import Progress, ignore
from stages.figures import captions
from stages.figures.drawing import NAMES, Drawing, draw, inputs_of
from stages.figures.inputs import Inputs
from stages.figures.parameters import Parameters
from stages.figures.result import Result

__all__ = ["Inputs", "run"]
Order = tuple[str, Parameters, dict[str, object]]


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Draw all figures and write their captions. All cores draw: laying out and embedding fonts takes seconds."""
    orders = [(name, parameters, {key: getattr(inputs, key) for key in inputs_of(name)}) for name in NAMES]
    drawings = []
    for number, drawing in each_in_a_process(_draw, orders):
        drawings.append(drawing)
        progress(len(drawings) / len(orders), f"drew {NAMES[number]}")
    drawings.sort(key=lambda drawing: (drawing.place, drawing.caption.name))
    shown = tuple(drawing.caption for drawing in drawings)
    made_up = captions.synthetic(inputs.comparison.measurement)
    files = {path: content for drawing in drawings for path, content in drawing.files.items()}
    return Result(shown, made_up, {"captions.yaml": captions.as_yaml(shown, made_up), **files})


def _draw(order: Order) -> Drawing:
    return draw(*order)
