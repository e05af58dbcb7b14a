"""`bipedstudy package FILE`: results, parameters, code's identity, environment and claims in one ZIP to cite.

The same files give the same bytes, and a stranger's package is unpacked within bounds.
"""

import contextlib
import datetime
import hashlib
import json
import os
import shlex
import stat
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import click

from pipeline import layout
from pipeline.cache import disk
from pipeline.cache.bounds import in_units
from pipeline.cache.store import SWEEPS
from pipeline.commands import options, status
from pipeline.errors import StudyError
from pipeline.graph import CLAIMS, FILE_NAME, is_inside
from pipeline.package import crate
from pipeline.package.crate import Row
from pipeline.parameters import loading, yaml_text
from pipeline.study import Study, shown

_CITATION = "CITATION.cff"
#: Authors and licence, the study's own: those of the program have no right to a lab's recordings.
_PAPERS = (_CITATION, "LICENSE", "codemeta.json")
_EPOCH = "SOURCE_DATE_EPOCH"
#: What a stranger's package may unpack to at most [bytes, files].
_LARGEST, _MOST = 8_000_000_000, 100_000
_FIRST_DAY = (1980, 1, 1, 0, 0, 0)


@click.command("package", epilog=options.examples("package"))
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@options.own_study
@click.option("--date", type=click.DateTime(["%Y-%m-%d"]),
              help="Day of publication (default: of SOURCE_DATE_EPOCH, else of the program's release).")  # fmt: skip
@options.answers_without_rows
def package(study: Study, file: Path, date: datetime.datetime | None, form: options.Form) -> None:
    """Put results, parameters, recordings, claims and licences into the new file FILE.zip, to cite and to check.

    It is an RO-Crate: ro-crate-metadata.json in it says which program made each file from which. The same results give
    the same bytes. What is not current is refused; tables of sweeps and maps stay out. Prints a citation with the
    file's digest. recompute takes the file, or its unpacked folder.
    """
    if file.suffix != ".zip":
        raise StudyError(f"{shown(file)}: its name must end in .zip")
    if file.exists() or file.is_symlink():
        raise StudyError(f"{shown(file)}: is there already, and is not replaced")
    runs, places, words = gathered(study)
    about = described(study, runs, date, places)
    files = {path: {"sha256": disk.file_digest(place), "size": place.stat().st_size, "words": words.get(path, "")}
             for path, place in sorted(places.items())}  # fmt: skip
    _zipped(disk.replaceable(file), {crate.NAME: crate.metadata(about, files, runs)}, places, files)
    digest, size = disk.file_digest(file), file.stat().st_size
    programs = "; ".join(sorted({run["program"] for run in runs}))
    who = "; ".join(map(crate.named, about["authors"]))
    citation = f"{who} ({about['published'][:4]}): {about['name']}. {programs}. RO-Crate, sha256 {digest}"
    refused = {run["stage"]: run["refusal"] for run in runs if run["refusal"]}
    made = [f"{shown(file)}: {len(files) + 1} files, {in_units(size)}, dated {about['published']}",
            *(f"without a result of {stage}, which said no: {why}" for stage, why in refused.items()),
            *(f"without {shown(table)}, which no stage made" for table in _tables(study, places)),
            f"cite it as: {citation}"]  # fmt: skip
    form.give((line for sentence in made for line in layout.folded(sentence)),
              {"file": shown(file), "sha256": digest, "bytes": size, "files": len(files) + 1, "citation": citation,
               "published": about["published"], "refused": refused})  # fmt: skip


def gathered(study: Study) -> tuple[list[Row], dict[str, Path], dict[str, str]]:
    """Every run, every file of the package by its place in it, and what some of them are. Raises `StudyError`."""
    stages = study.graph.stages
    names = tuple(name for name, stage in stages.items() if not stage.frozen or study.store.current(name))
    standing = status.Standing(study, names)
    if said := standing.sentence(names):
        raise StudyError(f"{shown(study.results)}: only results of the parameters and code at hand are packed; {said}")
    runs, settings = list[Row](), "".join(f" --set {shlex.quote(setting)}" for setting in study.settings)
    places, words = _of_parameters(study)
    places[FILE_NAME], words[FILE_NAME] = study.root / FILE_NAME, "the graph of stages: what each reads and makes"
    for name, values in study.parameters(names).items():
        stage, entry = stages[name], study.store.current(name)
        assert entry is not None
        read, recordings = [f"params/{file}.yaml" for file in stage.parameters], _recordings(study, values)
        inputs = [path for path in entry.ingredients["inputs"] if path in places]
        places |= recordings | {path: study.store.place(path) for path in entry.outs}
        words |= dict.fromkeys(recordings, "a recording")
        words[stage.artefact] = entry.summary
        about = {} if entry.refused else _made_by(study.store.place(stage.artefact))
        runs.append({
            "stage": name, "command": f"bipedstudy run {name}{settings}", "key": entry.key,
            "read": (*read, *recordings, *inputs), "made": sorted(entry.outs),
            "program": about.get("source") or study.about["source"], "versions": entry.ingredients["versions"],
            "processor": about.get("processor", ""), "refusal": entry.summary if entry.refused else "",
        })  # fmt: skip
    return runs, places, words | ({CLAIMS: "claims, measured numbers, verdicts"} if CLAIMS in places else {})


def _of_parameters(study: Study) -> tuple[dict[str, Path], dict[str, str]]:
    """Parameter files of all stages, so that a package is a study, and files left beside them; what each is."""
    listed = {file for stage in study.graph.stages.values() for file in stage.parameters}
    places = {f"params/{file}.yaml": study.params / f"{file}.yaml" for file in listed}
    left = {f"params/{file.name}": file for file in study.params.glob("[!.]*.json")}
    words = dict.fromkeys(places, "parameters with units and sources")
    return places | left, words | dict.fromkeys(left, "what a command left beside the parameters")


def _recordings(study: Study, values: Any) -> dict[str, Path]:
    """Files that a stage's parameters name. Raises `StudyError` for one that lies outside of the study."""
    found = {}
    for key, (file, name) in loading.files(values).items():
        if not is_inside(name):
            where = f"{shown(study.params)}/{file}.yaml: {key} = {json.dumps(name)}"
            raise StudyError(f"{where}: lies outside of the study, so that a package cannot hold it under this name")
        found[name] = (study.recordings or study.root) / name
    return found


def _tables(study: Study, places: Mapping[str, Path]) -> list[Path]:
    """Tables among the results that are no stage's, as those of sweeps and maps."""
    packed = {place.resolve() for place in places.values()}
    found = (*study.results.glob("[!.]*.h5"), *(study.results / SWEEPS).glob("[!.]*.h5"))
    return sorted(one for one in found if one.resolve() not in packed)


def _made_by(place: Path) -> dict[str, str]:
    """What an artefact says of its making, and in `source` of the program."""
    from pipeline.cache import artefact  # with h5py, which takes its time
    from pipeline.room import reading

    content = reading.vetted(place, shown(place))
    with artefact.opened(content, shown(place)) as file:
        return {**artefact.provenance(content, shown(place)), "source": str(file.attrs.get("source", ""))}


def described(study: Study, runs: list[Row], date: datetime.datetime | None, places: dict[str, Path]) -> Row:
    """What the package says of itself, from CITATION.cff; it, the licence and codemeta.json are added to `places`.

    Raises `StudyError` without CITATION.cff, for one without title, authors or licence, and where there is no day.
    """
    where = study.root / _CITATION
    if not where.is_file():
        raise StudyError(f"{shown(where)}: is missing; a package needs its title, license (an SPDX name), "
                         "date-released and authors, as [{name: Our lab}]")  # fmt: skip
    places |= {name: study.root / name for name in _PAPERS if (study.root / name).is_file()}
    plain: Any = yaml_text.read(where, shown(where)).plain()
    try:
        licenses, authors = plain["license"], tuple(dict(author) for author in plain["authors"])
        title, paper = str(plain["title"]).strip(), plain.get("preferred-citation")
    except (TypeError, KeyError, ValueError):
        raise StudyError(f"{shown(where)}: a package needs its title, authors and license") from None
    refused = sum(bool(run["refusal"]) for run in runs)
    without = f"; {refused} of its stages said no, and have none" if refused else ""
    return {
        "name": f"Results of {title}", "authors": authors, "paper": paper,
        "licenses": [licenses] if isinstance(licenses, str) else list(map(str, licenses)),
        "description": f"Results of {len(runs)} stages with all that they follow from{without}. See the actions in "
        "this file for what made what, and bipedstudy recompute to compute them again.",
        "published": _day(date, str(plain.get("date-released", "")), shown(where)),
    }  # fmt: skip


def _day(date: datetime.datetime | None, released: str, where: str) -> str:
    """The day of publication, never that of the clock, or two packages of the same results would differ."""
    try:
        if date is None and (epoch := os.environ.get(_EPOCH)):
            date = datetime.datetime.fromtimestamp(int(epoch), datetime.timezone.utc)
        return (date or datetime.datetime.strptime(released, "%Y-%m-%d")).date().isoformat()
    except (ValueError, OverflowError, OSError):
        raise StudyError(f"{_EPOCH} is no number of seconds, or {where} has no date-released: YYYY-MM-DD; say the "
                         "day of publication with --date") from None  # fmt: skip


def _zipped(path: Path, texts: Mapping[str, bytes], places: Mapping[str, Path], files: Mapping[str, Row]) -> None:
    """Put texts and then files, by their names in it, into a ZIP that appears at `path`, whole or not at all.

    Without compression, so that its bytes depend on no library. Raises `StudyError` for a file that has changed.
    """
    with disk.whole(path) as unfinished, zipfile.ZipFile(unfinished, "x", zipfile.ZIP_STORED) as out:
        for name, content in texts.items():
            out.writestr(_entry(name, len(content)), content)
        for name, file in files.items():
            with out.open(_entry(name, file["size"]), "w") as target:
                found = hashlib.sha256()
                for block in disk.blocks(places[name]):
                    found.update(block)
                    target.write(block)
            if found.hexdigest() != file["sha256"]:
                raise StudyError(f"{shown(places[name])}: changed while it was packed; try again")


def _entry(name: str, size: int) -> zipfile.ZipInfo:
    found = zipfile.ZipInfo(name, _FIRST_DAY)
    found.create_system, found.external_attr, found.file_size = 3, (stat.S_IFREG | 0o644) << 16, size
    return found


@contextlib.contextmanager
def unpacked(path: Path) -> Iterator[Path]:
    """A folder, or a temporary one to which the package in a file is unpacked. Raises `StudyError`."""
    if path.is_dir():
        yield path
        return
    disk.check(path, shown(path))
    with tempfile.TemporaryDirectory(prefix="bipedstudy-") as place:
        try:
            with zipfile.ZipFile(path) as package:
                entries = [entry for entry in package.infolist() if not entry.is_dir()]
                if len(entries) > _MOST or sum(entry.file_size for entry in entries) > _LARGEST:
                    raise StudyError(f"{shown(path)}: unpacks to more than {_MOST} files or {_LARGEST} bytes")
                for entry in entries:
                    if not is_inside(entry.filename):
                        raise StudyError(f"{shown(path)}: holds {entry.filename!a}, which would lie outside")
                    package.extract(entry, place)
        except (zipfile.BadZipFile, RuntimeError, NotImplementedError, EOFError, ValueError, OSError) as error:
            raise StudyError(f"{shown(path)}: is no package that can be read ({error})") from None
        yield Path(place)
