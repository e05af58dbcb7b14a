"""What the report says, gathered from the results folder: only files that are as their stage made them.

The engine knows nothing of a study's subject: words come from claims.yaml and captions.yaml, pictures from
results/figures.
How long a stage took stands in the cache's manifests, never in the results.
"""

from __future__ import annotations

import base64
import dataclasses
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from pipeline.cache import disk
from pipeline.cache.fingerprint import compact
from pipeline.cache.store import Entry
from pipeline.commands.claims import Claim, Claims
from pipeline.commands.claims import read as read_claims
from pipeline.errors import StudyError
from pipeline.parameters import yaml_text
from pipeline.parameters.loading import sections
from pipeline.parameters.value import declared
from pipeline.study import Study, shown

CLAIMS, CAPTIONS, FIGURES = "results/claims.yaml", "results/captions.yaml", "results/figures"
#: Places on the page other than among the figures, as a caption names them.
PLACES = ("opens", "beside_parameters")
Row = dict[str, Any]


@dataclass(frozen=True)
class Figure:
    """A figure: its name, title and text, and either a picture as an address of data or a fragment of a page.

    `data` are files beside the page, by name and path: the figure's numbers, a picture for print, the results shown.
    `claims` are those that it shows something of; one that `opens` stands first on the page, one that is
    `beside_parameters` above their table.
    """

    name: str
    title: str
    text: str
    picture: str
    fragment: str
    claims: tuple[str, ...] = ()
    opens: bool = False
    beside_parameters: bool = False
    data: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Content:
    """Everything the page shows. `stages` and `parameters` are rows by column name, `missing` are stages without a
    result, and why.
    """

    claims: Claims
    figures: list[Figure]
    title: str
    synthetic: str
    stages: list[Row]
    parameters: dict[str, list[Row]]
    versions: dict[str, str]
    missing: dict[str, str]

    @property
    def opening(self) -> list[Figure]:
        """Figures that stand first on the page."""
        return [figure for figure in self.figures if figure.opens]

    @property
    def among_figures(self) -> list[Figure]:
        """Figures without a place of their own."""
        return [figure for figure in self.figures if not (figure.opens or figure.beside_parameters)]

    def shown_in(self, claim: str) -> list[Figure]:
        """Figures that show something of a claim."""
        return [figure for figure in self.figures if claim in figure.claims]

    def shows(self, figure: Figure) -> list[Claim]:
        """The claims that a figure names, of those that are judged here."""
        return [claim for claim in self.claims.claims if claim.id in figure.claims]


def entries(study: Study, failed: Mapping[str, str] = MappingProxyType({})) -> dict[str, Entry]:
    """The stored result of every stage, by name; one without files where it said no, has `failed`, or was never run.

    Raises `StudyError` if no stage has been computed.
    """
    found = {name: study.store.current(name) for name in study.graph.stages}
    if not any(found.values()):
        raise StudyError(
            f"{shown(study.results)} holds no result of {', '.join(found)}; make it with: bipedstudy run-all"
        )
    return {name: entry if entry is not None and name not in failed
            else Entry(name, {}, {}, failed.get(name, "not computed yet; make it with: bipedstudy run-all"), 0.0)
            for name, entry in found.items()}  # fmt: skip


def undrawn(study: Study) -> list[str]:
    """A sentence for each figure that the captions have and the results have not: its reason is its caption."""
    place = study.store.place(CAPTIONS)
    words, folder = _words(disk.read(place)), study.store.place(FIGURES)
    return [f"{caption['name']}: {caption['text']}" for caption in words.get("figures", ())
            if not any(folder.glob(f"{caption['name']}.*"))]  # fmt: skip


def gather(study: Study, made: Mapping[str, Entry], with_times: bool) -> Content:
    """Read everything. Raises `StudyError` for a file that is missing or not as its stage made it."""
    files = {path: _intact(study, entry, path) for entry in made.values() for path in entry.outs if _is_shown(path)}
    words, missing = _words(files.get(CAPTIONS)), {name: one.summary for name, one in made.items() if one.refused}
    made = {name: entry for name, entry in made.items() if not entry.refused}
    parameters: dict[str, dict[str, Any]] = {}
    versions: dict[str, str] = {}
    for entry in made.values():
        versions |= entry.ingredients["versions"]
        for file, values in entry.ingredients["parameters"].items():
            parameters.setdefault(file, {}).update(values)
    return Content(
        claims=read_claims(study) if CLAIMS in files else Claims(),
        figures=_figures(files, words, {path for entry in made.values() for path in entry.outs}),
        title=str(words.get("title", "Report")),
        synthetic=str(words.get("synthetic", "")),
        stages=[_stage(entry, with_times) for entry in made.values()],
        parameters={file: list(_parameters(study, file, values)) for file, values in sorted(parameters.items())},
        versions=dict(sorted(versions.items())),
        missing=missing,
    )


def _is_shown(path: str) -> bool:
    return path in (CLAIMS, CAPTIONS) or (path.startswith(FIGURES + "/") and path.endswith((".png", ".html")))


def _intact(study: Study, entry: Entry, path: str) -> bytes:
    content, out = disk.read(study.store.place(path)), entry.outs[path]
    if content is None or disk.digest(content) != out.sha256:
        what = "is missing" if content is None else "was edited or damaged"
        raise StudyError(f"{path} {what}; put it right with: bipedstudy run {entry.stage}")
    return content


def _words(content: bytes | None) -> dict[str, Any]:
    plain = yaml_text.parse((content or b"").decode(), CAPTIONS).plain()
    return plain if isinstance(plain, dict) else {}


def _figures(files: Mapping[str, bytes], words: Mapping[str, Any], outs: Collection[str]) -> list[Figure]:
    """Figures in the captions' order, then those without a caption by name; `outs` are all files of the results.

    One that was not drawn has its caption, which says why.
    """
    captions = {caption["name"]: caption for caption in words.get("figures", ())}
    drawn = {path.removeprefix(FIGURES + "/").rpartition(".")[0]: path for path in sorted(files) if FIGURES in path}
    order = [*captions, *(name for name in drawn if name not in captions)]
    found = []
    for name in order:
        caption, content = captions.get(name, {}), files[drawn[name]] if name in drawn else b""
        is_page = name in drawn and drawn[name].endswith(".html")
        picture = "" if is_page or name not in drawn else "data:image/png;base64," + base64.b64encode(content).decode()
        fragment = content.decode() if is_page else ""
        title, text = caption.get("title", name), caption.get("text", "")
        claims, places = tuple(caption.get("claims", ())), {key: bool(caption.get(key, False)) for key in PLACES}
        data = tuple(_data(name, caption.get("shows", ()), outs))
        found.append(Figure(name, title, text, picture, fragment, claims, data=data, **places))
    return found


def _data(name: str, shows: Collection[str], outs: Collection[str]) -> Iterator[tuple[str, str]]:
    """Files of the results that have a figure's numbers, by what they are called on the page."""
    wanted = [*((ending.upper(), f"{FIGURES}/{name}.{ending}") for ending in ("csv", "pdf")),
              *((f"{stage}.h5", f"results/{stage}.h5") for stage in shows)]  # fmt: skip
    yield from ((word, path.removeprefix("results/")) for word, path in wanted if path in outs)


def _stage(entry: Entry, with_times: bool) -> Row:
    return {
        "name": entry.stage,
        "summary": entry.summary,
        "key": entry.key,
        "seconds": f"{entry.seconds:.1f}" if with_times else "",
        "size": f"{sum(out.size for out in entry.outs.values()) / 1e6:.2f}",
        "inputs": ", ".join(sorted(path.removeprefix("results/") for path in entry.ingredients["inputs"])),
    }


def _fields(study: Study, file: str) -> dict[str, Any]:
    """The fields with a default, by key, of what the stages read in a parameter file."""
    classes = [cls for stage in study.graph.stages.values() if (cls := study.parameters_class(stage)) is not None]
    fields = (field for section in sections(classes).get(file, ()) for field, _ in declared(section).values())
    return {field.name: field for field in fields if field.default is not dataclasses.MISSING}


def _parameters(study: Study, file: str, used: Mapping[str, Any]) -> Any:
    """Rows of a parameter file: the value that was used, with the unit and the source that the file states.

    A key that the file does not state has a row if it was given another value than what it is by itself.
    """
    stated = yaml_text.read(study.params / f"{file}.yaml", f"{shown(study.params)}/{file}.yaml").plain()
    fields = _fields(study, file)
    for key, value in used.items():
        about = stated.get(key) if isinstance(stated, dict) else None
        if about is None and key in fields:
            default = fields[key].default
            if (list(default) if isinstance(default, tuple) else default) != value:
                unit, source = fields[key].metadata["unit"], "set for this run; the file does not state it"
                yield {"key": key, "value": compact(value), "unit": unit, "source": source}
            continue
        about = about if isinstance(about, dict) else {"value": about}
        changed = "value" in about and about["value"] != value
        yield {
            "key": key,
            "value": compact(value),
            "unit": about.get("unit", ""),
            "source": f"set for this run; the file says {compact(about['value'])}" if changed
            else about.get("source", ""),
        }  # fmt: skip
