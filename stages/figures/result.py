"""What the drawing hands on: captions, pictures, and the animation."""

from dataclasses import dataclass

from stages.biped.quantity import quantity

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
