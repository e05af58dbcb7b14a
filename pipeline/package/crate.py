"""The metadata of a package: RO-Crate 1.1 with the profile Process Run Crate 0.5, as plain JSON-LD.

Each run of a stage is a CreateAction: its instrument is the program, its objects are parameters and inputs, its results
are files with digests. Where a result comes from is said in terms of W3C PROV too. Nothing here is of the clock.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any
from urllib.parse import quote

NAME = "ro-crate-metadata.json"
_CRATE, _PROFILE = "https://w3id.org/ro/crate/1.1", "https://w3id.org/ro/wfrun/process/0.5"
_TERMS, _PROV = "https://w3id.org/ro/terms/workflow-run#", "http://www.w3.org/ns/prov#"
#: Terms that the crate's own context lacks.
_MORE = {"sha256": f"{_TERMS}sha256", "environment": {"@id": f"{_TERMS}environment", "@type": "@id"},
         "wasGeneratedBy": {"@id": f"{_PROV}wasGeneratedBy", "@type": "@id"}}  # fmt: skip
_STATUS = "http://schema.org/CompletedActionStatus", "http://schema.org/FailedActionStatus"
_KINDS = {"h5": "application/x-hdf5", "yaml": "application/yaml", "json": "application/json", "csv": "text/csv",
          "png": "image/png", "pdf": "application/pdf", "html": "text/html", "sqlite": "application/vnd.sqlite3",
          "cff": "application/yaml"}  # fmt: skip
#: What an artefact says of the program that made it.
_PROGRAM = re.compile(r"(?P<name>\S+)(?: (?P<version>[^\s,]+))?(?:, commit (?P<commit>\w+))?, code (?P<code>\w+)")
Row = dict[str, Any]


def metadata(about: Row, files: Mapping[str, Row], runs: Sequence[Row]) -> bytes:
    """The file that says all of this, the same bytes for the same words.

    `about` the package: name, description, authors, licenses (SPDX), paper (to cite, or None), published (a day, ISO
    8601). Of each file by its path in the package: sha256, size [bytes], and in words what it is, if that is said.

    Of each run of a stage: stage, command, key, the files that it read and made, and by the result's own words program,
    versions (distribution -> version) and processor; refusal is the reason of one that said no.
    """
    programs = {run["program"]: _program(run["program"]) for run in runs}
    known = sorted({run["processor"] for run in runs if run["made"]})
    processors = {words: f"#processor-{place}" for place, words in enumerate(known)}
    versions = sorted({pair for run in runs for pair in run["versions"].items()})
    packages = [_package(*each) for each in versions]
    maker = {path: run for run in runs for path in run["made"]}
    graph = [
        *_described(about, files, runs),
        *({**program, "softwareRequirements": _ids(packages)} for program in programs.values()), *packages,
        *({"@id": place, "@type": "PropertyValue", "name": "processor", "value": words}
          for words, place in processors.items()),
        *(_action(run, programs[run["program"]], processors.get(run["processor"], "")) for run in runs),
        *(_file(path, file, maker.get(path)) for path, file in files.items()),
    ]  # fmt: skip
    unique = {entity["@id"]: dict(_single(entity)) for entity in graph}
    whole = {"@context": [f"{_CRATE}/context", _MORE], "@graph": list(unique.values())}
    return (json.dumps(whole, indent=1, ensure_ascii=False) + "\n").encode()


def _described(about: Row, files: Iterable[str], runs: Iterable[Row]) -> Iterator[Row]:
    """The package as a whole, and what it names: authors, licences, the paper."""
    authors, licenses = list(map(_person, about["authors"])), list(map(_license, about["licenses"]))
    paper = _paper(about["paper"]) if about["paper"] else []
    yield {"@id": NAME, "@type": "CreativeWork", "conformsTo": {"@id": _CRATE}, "about": {"@id": "./"}}
    yield {
        "@id": "./", "@type": "Dataset", "name": about["name"], "description": about["description"],
        "datePublished": about["published"], "conformsTo": {"@id": _PROFILE}, "author": _firsts(authors),
        "license": _ids(licenses), "hasPart": [{"@id": quote(path)} for path in files],
        "mentions": [{"@id": f"#run-{run['stage']}"} for run in runs], "citation": _ids(paper[:1]),
    }  # fmt: skip
    yield {"@id": _PROFILE, "@type": "CreativeWork", "name": "Process Run Crate", "version": "0.5"}
    yield from (*(one for one, *_ in authors), *(place for _, *places in authors for place in places))
    yield from (*licenses, *paper)


def _single(entity: Row) -> Iterator[tuple[str, Any]]:
    """An entity's properties as RO-Crate wishes them: one value stands alone, none is left out."""
    for name, value in entity.items():
        if value != []:
            yield name, value[0] if isinstance(value, list) and len(value) == 1 else value


def _ids(entities: Iterable[Row]) -> list[Row]:
    return [{"@id": entity["@id"]} for entity in entities]


def _firsts(groups: Iterable[list[Row]]) -> list[Row]:
    return _ids(first for first, *_ in groups)


def _action(run: Row, program: Row, processor: str) -> Row:
    found = {
        "@id": f"#run-{run['stage']}", "@type": "CreateAction", "name": f"stage {run['stage']}",
        "description": run["command"], "identifier": run["key"], "instrument": {"@id": program["@id"]},
        "object": [{"@id": quote(path)} for path in run["read"]],
        "actionStatus": _STATUS[bool(run["refusal"])],
    }  # fmt: skip
    if run["refusal"]:
        return {**found, "error": run["refusal"]}
    return {**found, "result": [{"@id": quote(path)} for path in run["made"]], "environment": [{"@id": processor}]}


def _file(path: str, file: Row, run: Row | None) -> Row:
    found = {"@id": quote(path), "@type": "File", "name": path, "contentSize": str(file["size"]),
             "encodingFormat": _KINDS.get(path.rpartition(".")[2], "text/plain"), "sha256": file["sha256"]}  # fmt: skip
    if file["words"]:
        found["description"] = file["words"]
    if run is None:
        return found
    return {**found, "wasGeneratedBy": f"#run-{run['stage']}",
            "wasDerivedFrom": [{"@id": quote(each)} for each in run["read"]]}  # fmt: skip


def _program(words: str) -> Row:
    """The program by its own words, which name version, commit and digest of the code."""
    parts = _PROGRAM.fullmatch(words)
    found = parts.groupdict() if parts else {"name": words, "version": None, "commit": None, "code": "unknown"}
    named = [f"swh:1:rev:{found['commit']}"] if found["commit"] else []  # how Software Heritage names a commit of git
    return {"@id": f"#program-{found['code']}", "@type": "SoftwareApplication", "name": found["name"],
            "softwareVersion": found["version"] or "unknown", "description": words,
            "identifier": [*named, f"code {found['code']}"]}  # fmt: skip


def _package(name: str, version: str) -> Row:
    address = f"pkg:{'generic' if name == 'python' else 'pypi'}/{name}@{version}"  # a package URL, which names no host
    return {"@id": address, "@type": "SoftwareApplication", "name": name, "url": address, "softwareVersion": version}


def _license(name: str) -> Row:
    return {"@id": f"https://spdx.org/licenses/{name}", "@type": "CreativeWork", "name": name}


def named(author: Mapping[str, Any]) -> str:
    """An author as a citation names one."""
    return str(author.get("name") or ", ".join(
        str(author[key]) for key in ("family-names", "given-names") if author.get(key)))  # fmt: skip


def _person(author: Mapping[str, Any]) -> list[Row]:
    """An author of a CITATION.cff, and where one works: a person has a family name, all others are organisations."""
    found: Row = {"@id": str(author.get("orcid") or f"#{quote(named(author))}"),
                  "@type": "Person" if "family-names" in author else "Organization", "name": named(author)}  # fmt: skip
    if not author.get("affiliation"):
        return [found]
    name = str(author["affiliation"])
    place = {"@id": f"#{quote(name)}", "@type": "Organization", "name": name}
    return [{**found, "affiliation": {"@id": place["@id"]}}, place]


def _paper(paper: Mapping[str, Any]) -> list[Row]:
    """A paper, and its authors."""
    authors, title = list(map(_person, paper.get("authors") or ())), str(paper.get("title", "")).strip()
    found: Row = {"@id": f"https://doi.org/{paper['doi']}" if paper.get("doi") else f"#{quote(title)}",
                  "@type": "ScholarlyArticle", "name": title, "author": _firsts(authors)}  # fmt: skip
    dated = {"datePublished": str(paper["year"])} if paper.get("year") else {}
    return [found | dated, *(each for author in authors for each in author)]
