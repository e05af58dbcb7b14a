"""`bipedstudy show --why`: what a number follows from, stage by stage, down to what was recorded.

All of it is what artefacts say of their own making; lines are those where a parameter file states a value today.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from pipeline import layout
from pipeline.cache import artefact as artefacts
from pipeline.cache import disk
from pipeline.cache.fingerprint import INGREDIENTS, compact
from pipeline.commands.options import Form
from pipeline.graph import beneath
from pipeline.parameters import yaml_text
from pipeline.study import Study, shown

Row = dict[str, Any]
_WIDTH = " half-width"


def give(study: Study, content: bytes, name: str, field: artefacts.Field | None, form: Form) -> None:
    """Tell how an artefact, or a field of it, came about: as text, as JSON with all code, or parameters as rows."""
    made = list(chain(study, {"stage": "?", **artefacts.provenance(content, name)}, name))
    head = [name] if field is None else list(_of_field(field, artefacts.tree(content, name), name))
    form.give(
        [*head, *(line for place, one in enumerate(made) for line in _lines(one, made[:place]))],
        {"file": name, "field": field and field.path, "made": made},
        ({"stage": one["stage"], **each} for one in made for each in one["parameters"]),
    )


def chain(study: Study, about: Mapping[str, str], name: str) -> Iterator[Row]:
    """How the artefact that says `about` itself was made, then those that it read, each once, the nearest first."""
    waiting, known = [(about, name)], {about["stage"]}
    for about, name in waiting:
        parameters = list(_parameters(study, about.get("parameters", "")))
        inputs = [_input(study, line, parameters) for line in about.get("inputs", "").splitlines()]
        for maker in (one["made_by"] for one in inputs if one["made_by"] and one["made_by"] not in known):
            known.add(maker)
            place = study.store.place(study.graph.stages[maker].artefact)
            if place.exists():
                waiting.append((artefacts.provenance(disk.content(place, shown(place)), shown(place)), shown(place)))
        yield {"stage": about["stage"], "artefact": name, "key": about.get("key", "?"), "parameters": parameters,
               "inputs": inputs, "code": json.loads(about.get(INGREDIENTS, "{}")).get("code", {}),
               "versions": about.get("versions", "").splitlines(), "processor": about.get("processor", "")}  # fmt: skip


def _input(study: Study, line: str, parameters: list[Row]) -> Row:
    """What an artefact read, by its line of path and SHA-256: a stage's result, or a file that a parameter names."""
    path, _, sha256 = line.rpartition(" ")
    makers = (one.name for one in study.graph.stages.values() if any(beneath(out, [path]) for out in one.outs))
    maker, last = next(makers, ""), None
    if maker:
        last, said = study.store.current(maker), f"made by stage {maker}"
        if last is not None and last.contents(path).get(path) != sha256:
            said += "; another one lies there now"
    else:
        named = [one for one in parameters if one["name"].endswith(f".{path}")]
        said = "".join(f"the file {one['value']} ({one['place']}), " for one in named) + "which no stage makes"
    return {"path": path, "made_by": maker, "is": said, "sha256": sha256}


def _parameters(study: Study, text: str) -> Iterator[Row]:
    """Each value of an artefact's lines `file.key = value`, with the line of the file that states it (of a table
    the row's), or no place."""
    files: dict[str, Mapping[str, yaml_text.Node]] = {}
    for line in text.splitlines():
        name, _, value = line.partition(" = ")
        file, key, *row = name.removesuffix(_WIDTH).split(".")
        path, where = study.params / f"{file}.yaml", f"{shown(study.params)}/{file}.yaml"
        if file not in files:
            files[file] = yaml_text.read(path, where).value if path.exists() else {}
        found = {"name": name, "value": value, "unit": "", "place": "", "source": ""}
        if node := files[file].get(key):
            plain = node.plain() if isinstance(node.value, dict) else {"value": node.plain()}
            stated = compact(plain.get("value"))
            same = row or name.endswith(_WIDTH) or stated in (value, f"({value.count(',') + 1} entries)")
            rows = node.value["rows"].value if row and "rows" in plain else []
            line_of = rows[int(row[0])] if row and row[0].isdigit() and int(row[0]) < len(rows) else node
            found |= {"unit": str(plain.get("unit", "")).replace("-", ""), "place": f"{where}:{line_of.line}",
                      "source": str(plain.get("source", "")) if same else
                      f"set for this run; the file says {stated}"}  # fmt: skip
        yield found


def _of_field(field: artefacts.Field, tree: list[artefacts.Field], name: str) -> Iterator[str]:
    """A field with its value and error, and the words beside it that tell rows apart, as the name of a run."""
    error = "" if field.error is None else f" +- {field.error:.1g}"
    value = "" if field.value is None else f" = {layout.short(field.value)}{error} {field.shown_unit}".rstrip()
    yield from layout.folded(f"{name}: {field.path.replace('/', '.')}{value}: {field.description}")
    for one in tree:
        group = one.path.rpartition("/")[0]
        if group and isinstance(one.value, str) and field.path.startswith(f"{group}/"):
            yield from layout.folded(f"  {one.path.replace('/', '.')}: {one.value}", 4)


def _lines(one: Row, before: list[Row]) -> Iterator[str]:
    """A stage in words; parameters that one of those `before` used as well are only counted."""
    fresh = [each for each in one["parameters"] if not any(each in other["parameters"] for other in before)]
    above = len(one["parameters"]) - len(fresh)
    yield from ("", *layout.folded(f"stage {one['stage']}, {one['artefact']}, key {one['key']}", 4))
    yield f"  parameters: {len(fresh)}" + (f", and {above} that are told above" if above else "")
    for each in (each for each in fresh if each["place"]):
        head = f"    {each['name']} = {each['value']} {each['unit']}".rstrip()
        yield layout.beside(f"{head:<44} ", each["place"] + (f" ({each['source']})" if each["source"] else ""))
    if rest := [f"{each['name']} = {each['value']}" for each in fresh if not each["place"]]:
        yield from layout.folded(f"    stated by no file: {', '.join(rest)}", 6)
    own = [file for file in one["code"] if file.endswith(f"{one['stage']}/run.py")]
    for said in (
        *(f"reads {each['path']}, {each['is']}, SHA-256 {each['sha256'][:16]}" for each in one["inputs"]),
        f"code: {', '.join(own)} and {len(one['code']) - len(own)} files that it imports",
        f"versions: {', '.join(one['versions'])}; {one['processor']}",
    ):
        yield from layout.folded(f"  {said}", 4)
