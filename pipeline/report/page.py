"""The report: one page without any outside reference, made from files in the results folder as their stage made them.

The engine knows nothing of a study's subject: words come from claims.yaml and captions.yaml, pictures from
results/figures. The page is no stage's output: it holds how long stages took, which stands in the cache's manifests
and which no two runs share. Without the times the same results give the same bytes.
"""

from __future__ import annotations

import base64
import contextlib
import dataclasses
import re
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import click

from pipeline.cache import disk
from pipeline.cache.fingerprint import compact, set_for_a_run
from pipeline.cache.store import Entry
from pipeline.commands import claims, options
from pipeline.commands.claims import Claims
from pipeline.commands.status import Standing, echo
from pipeline.errors import StudyError
from pipeline.graph import CAPTIONS, CLAIMS, FIGURES, REPORT
from pipeline.parameters import yaml_text
from pipeline.parameters.loading import sections
from pipeline.parameters.value import DEFAULT_LEVEL, SUFFIX, declared
from pipeline.study import Study, shown

if TYPE_CHECKING:
    from jinja2 import Template

#: Places on the page other than among the figures, as a caption names them.
PLACES = ("opens", "beside_parameters")
_TEMPLATE = Path(__file__).with_name("page.html")
_NONE_FAILED: Mapping[str, str] = MappingProxyType({})
Row = dict[str, Any]


@click.command("report", epilog=options.examples("report"))
@options.own_study
@click.option(
    "--into", type=click.Path(dir_okay=False, path_type=Path), help="Write FILE (default: results/report.html)."
)
@click.option("--no-times", is_flag=True, help="Leave out how long stages took: the same results give the same bytes.")
@options.answers_without_rows
def report(study: Study, into: Path | None, no_times: bool, form: options.Form) -> None:
    """Write one self-contained page: claims, figures, animation, parameters, provenance. run-all does this too."""
    made, names, path = entries(study), study.graph.usual, disk.replaceable(into) if into else study.results / REPORT
    found = Standing(study, names)
    stale = {name: "; ".join(item.reasons) for name, item in found.found.items()}
    echo(f"{found.sentence(names)}; the page says so" if stale else found.doubt)
    disk.write(path, render(study, made, not no_times, stale))
    form.give([f"written: {shown(path)}"], {"written": shown(path), "not_current": stale})


def refresh(study: Study, failed: Mapping[str, str] = _NONE_FAILED) -> Path | None:
    """Write results/report.html if it does not fit the results; its path if it was written. For the end of a run, in
    which stages may have failed: (stage -> why).
    """
    content, path = render(study, entries(study, failed), True, {}), study.results / REPORT
    with contextlib.suppress(OSError):
        if disk.read(path) == content:
            return None
    disk.write(path, content)
    return path


def entries(study: Study, failed: Mapping[str, str] = _NONE_FAILED) -> dict[str, Entry]:
    """The stored result of every stage, by name; one without files where it said no, has `failed`, or was never run.

    Raises `StudyError` if no stage has been computed.
    """
    found = {name: study.store.current(name) for name in study.graph.usual}
    if not any(found.values()):
        raise StudyError(
            f"{shown(study.results)} holds no result of {', '.join(found)}; make it with: bipedstudy run-all"
        )
    return {name: entry if entry is not None and name not in failed
            else Entry(name, {}, {}, failed.get(name, "not computed yet; make it with: bipedstudy run-all"), 0.0)
            for name, entry in found.items()}  # fmt: skip


def render(study: Study, made: Mapping[str, Entry], with_times: bool, stale: Mapping[str, str]) -> bytes:
    """The page. `stale` maps stages that are not current to the reason. Raises `StudyError` for damaged results."""
    seconds = f"{sum(entry.seconds for entry in made.values()):.0f}" if with_times else ""
    return html(gather(study, made, with_times), seconds, stale)


def html(content: Row, seconds: str, stale: Mapping[str, str]) -> bytes:
    """The page of a content, as `gather` gives it; `seconds` is the time of all stages, empty to leave times out."""
    page = template(_TEMPLATE).render(content=content, with_times=bool(seconds), seconds=seconds, stale=stale,
                                      usual_level=DEFAULT_LEVEL)  # fmt: skip
    return page.encode()


@cache
def template(path: Path) -> Template:
    """The template of a page at `path`."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string(path.read_text(encoding="utf-8"))


def address(picture: bytes | None) -> str:
    """A PNG as an address of data, as a page without outside references has it; nothing where there is none."""
    return "" if picture is None else "data:image/png;base64," + base64.b64encode(picture).decode()


def pieces(picture: bytes) -> list[list[float]]:
    """Boxes of a PNG that says into which pieces a narrow page may cut it, as `gather` has them, or the whole."""
    found = re.search(rb"tEXtpieces\0([-\d. ;]*;)", picture[:4096])
    size = " ".join(str(int.from_bytes(picture[place : place + 4], "big") / 100.0) for place in (16, 20))
    whole, *rest = (found[1].decode() if found else size).strip(";").split(";")
    return [[float(number) for number in box.split()] for box in (f"0 0 {whole}", *rest)]


def undrawn(study: Study) -> list[str]:
    """A sentence for each figure that the captions have and the results have not: its reason is its caption.

    Figures of results that dvc.yaml does not give to their stage are left out on purpose.
    """
    folder = study.store.place(FIGURES)
    given = {Path(path).stem for one in study.graph.stages.values() if CAPTIONS in one.outs for path in one.inputs}
    return [f"{caption['name']}: {caption['text']}"
            for caption in _words(disk.read(study.store.place(CAPTIONS))).get("figures", ())
            if given.issuperset(caption.get("shows", ())) and not any(folder.glob(f"{caption['name']}.*"))]  # fmt: skip


def gather(study: Study, made: Mapping[str, Entry], with_times: bool) -> Row:
    """Everything the page shows. Raises `StudyError` for a file that is missing or not as its stage made it.

    `stages` and `parameters` are rows by column name, `missing` are stages without a result, and why. `about` stands
    below the title; `answers` are rows of question, answer, errors and means, for the first screen.

    `figures` are rows too: name, title and text, and either `picture`, an address of data, or `fragment` of a page;
    `pieces`, boxes of left, top, width, height: first the whole picture, then those that a narrow page shows;
    `data`, files beside the page by name and path (numbers, a picture for print, the results shown); `claims` that it
    shows something of. One that `opens` stands first on the page, one that is `beside_parameters` above their table.
    """
    files = {path: _intact(study, entry, path) for entry in made.values() for path in entry.outs
             if path in (CLAIMS, CAPTIONS) or (path.startswith(FIGURES + "/") and path.endswith((".png", ".html")))
             }  # fmt: skip
    words, missing = _words(files.get(CAPTIONS)), {name: one.summary for name, one in made.items() if one.refused}
    there = [entry for entry in made.values() if not entry.refused]
    parameters: dict[str, dict[str, Any]] = {}
    versions: dict[str, str] = {}
    for entry in there:
        versions |= entry.ingredients["versions"]
        for file, values in entry.ingredients["parameters"].items():
            parameters.setdefault(file, {}).update(values)
    return {
        "claims": claims.read(study) if CLAIMS in files else Claims(),
        "figures": list(_figures(files, words, {path for entry in there for path in entry.outs})),
        "title": str(words.get("title", "Report")).replace("{study}", study.params.parent.name),
        "about": str(words.get("about", "")),
        "answers": [*(words.get("answers") or ()), *_proven(study)],
        "claims_first": bool(words.get("claims_first", True)),
        "synthetic": str(words.get("synthetic", "")),
        "stages": [_provenance(entry, with_times) for entry in there],
        "parameters": {file: list(_parameters(study, file, values)) for file, values in sorted(parameters.items())},
        "versions": dict(sorted(versions.items())),
        "missing": missing,
    }  # fmt: skip


def _proven(study: Study) -> Iterator[Row]:
    """What a proof says of the study's design, as an answer for the first screen."""
    for words in dict.fromkeys(claims.proven(study).values()):
        answer = f"{words[0].upper()}{words[1:]}."
        yield {"question": "Is it proven?", "answer": answer, "means": "", "errors": claims.MEANS}


def _provenance(entry: Entry, with_times: bool) -> Row:
    """The row of a stage: its summary, key, time, size, and inputs."""
    return {
        "name": entry.stage, "summary": entry.summary, "key": entry.key,
        "seconds": f"{entry.seconds:.1f}" if with_times else "",
        "size": f"{sum(out.size for out in entry.outs.values()) / 1e6:.2f}",
        "inputs": ", ".join(sorted(path.removeprefix("results/") for path in entry.ingredients["inputs"])),
    }  # fmt: skip


def _intact(study: Study, entry: Entry, path: str) -> bytes:
    content = disk.read(study.store.place(path))
    if content is None or disk.digest(content) != entry.outs[path].sha256:
        what = "is missing" if content is None else "was edited or damaged"
        raise StudyError(f"{path} {what}; put it right with: bipedstudy run {entry.stage}")
    return content


def _words(content: bytes | None) -> dict[str, Any]:
    plain = yaml_text.parse((content or b"").decode(), CAPTIONS).plain()
    return plain if isinstance(plain, dict) else {}


def _figures(files: Mapping[str, bytes], words: Mapping[str, Any], outs: Collection[str]) -> Iterator[Row]:
    """Figures in the captions' order, then those without a caption by name; `outs` are all files of the results.

    One that was not drawn has its caption, which says why.
    """
    captions = {caption["name"]: caption for caption in words.get("figures", ())}
    drawn = {path.removeprefix(FIGURES + "/").rpartition(".")[0]: path for path in sorted(files) if FIGURES in path}
    for name in {**captions, **drawn}:
        caption, path = captions.get(name, {}), drawn.get(name, "")
        yield {
            "name": name, "title": caption.get("title", name), "text": caption.get("text", ""),
            "picture": address(files[path]) if path.endswith(".png") else "",
            "pieces": pieces(files[path]) if path.endswith(".png") else (),
            "fragment": files[path].decode() if path.endswith(".html") else "",
            "claims": caption.get("claims", ()), "data": list(_data(name, caption.get("shows", ()), outs)),
            **{key: bool(caption.get(key, False)) for key in PLACES},
        }  # fmt: skip


def _data(name: str, shows: Collection[str], outs: Collection[str]) -> Iterator[tuple[str, str]]:
    """Files of the results that have a figure's numbers, by what they are called on the page."""
    wanted = [*((ending.upper(), f"{FIGURES}/{name}.{ending}") for ending in ("csv", "pdf")),
              *((f"{stage}.h5", f"results/{stage}.h5") for stage in shows)]  # fmt: skip
    yield from ((word, path.removeprefix("results/")) for word, path in wanted if path in outs)


def _parameters(study: Study, file: str, used: Mapping[str, Any]) -> Iterator[Row]:
    """Rows of a parameter file: the value that was used, with the unit and the source that the file states.

    A key that the file does not state has a row if it was given another value than what it is by itself.
    """
    stated = yaml_text.read(study.params / f"{file}.yaml", f"{shown(study.params)}/{file}.yaml").plain()
    fields = {field.name: field for section in sections(study.parameters_classes().values()).get(file, ())
              for field, _ in declared(section).values() if field.default is not dataclasses.MISSING}  # fmt: skip
    for key, value in used.items():
        base = key.removesuffix(SUFFIX)
        about = stated.get(base) if isinstance(stated, dict) else None
        if about is None and key in fields:
            default = fields[key].default
            if (list(default) if isinstance(default, tuple) else default) == value:
                continue
            unit, source = fields[key].metadata["unit"], "set for this run; the file does not state it"
        else:
            about = about if isinstance(about, dict) else {"value": about}
            unit, source = about.get("unit", ""), about.get("source", "")
            if "value" in about and about["value"] != used.get(base):
                source = set_for_a_run(about["value"])
        yield {"key": key, "value": compact(value), "unit": unit, "source": source}
