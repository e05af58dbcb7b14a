"""`bipedstudy show ARTEFACT`: what is inside a result and, with `--why`, what it follows from."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline import completion, layout
from pipeline.cache.fingerprint import INGREDIENTS, compact, set_for_a_run
from pipeline.commands import options, status
from pipeline.errors import StudyError, nearest
from pipeline.graph import beneath
from pipeline.home import result_class
from pipeline.parameters import yaml_text
from pipeline.study import Study, shown

if TYPE_CHECKING:
    from pipeline.cache.artefact import Field

Row = dict[str, Any]
#: Columns before a field's value, and before what it is.
_NAMES, _VALUES = 30, 49
#: A number whose error is no larger part of it than this, which is round-off, is shown without.
_EXACT = 1e-13
_WIDTH = " half-width"


@click.command("show", epilog=options.examples("show"))
@click.argument("artefact", shell_complete=completion.stages_or_files)
@click.argument("where", required=False, metavar="[PATH]")
@options.own_study
@click.option("--why", is_flag=True, help="Print what it follows from: stages, parameters, inputs, code, versions.")
@options.answers
def show(study: Study, artefact: str, where: str | None, why: bool, form: options.Form) -> None:
    """Print the fields of ARTEFACT, a stage's name or a file, with units, shapes and values, and its tables.

    With PATH (as group.field, or as stage.group.field in place of ARTEFACT) only what stands there: a number with all
    its digits, an array or a table in full. With --why how it came about: the stage, its parameters with file and line,
    what it read, its code and the versions of packages. The same follows for each result that it read, down to a
    recording.
    """
    from pipeline.cache import artefact as artefacts
    from pipeline.room import reading

    stage, _, inside_it = artefact.partition(".")
    if where is None and inside_it and stage in study.graph.stages and not Path(artefact).exists():
        artefact, where = stage, inside_it
    path = _path(study, artefact)
    name = shown(path)
    content = reading.vetted(path, name)
    check_links(content, name)
    about = artefacts.provenance(content, name)
    status.say(study, *(each for each, stage in study.graph.stages.items()
                          if path.resolve() == study.store.place(stage.artefact).resolve()))  # fmt: skip
    fields = artefacts.tree(content, name)
    inside = [] if where is None else _inside(fields, where, name)
    if why:
        _give_account(study, content, name, inside[0] if inside else None, form)
        return
    if where is not None:
        _give_part(content, inside, form)
        return
    lines = layout.folded(f"{name}: {_made_by(about)}")
    lines += [line for text in options.verifications(study, about) for line in layout.folded(text)]
    if without := artefacts.without_errors(content, name):
        lines += layout.folded(f"its numbers carry no errors: {without}")
    form.give(
        [*lines, *map(_line, fields)],
        {"file": name, "fields": [_plain(field) for field in fields], "provenance": about, "without_errors": without},
        ({**_plain(field), "shape": _size(field.shape)} for field in fields if field.shape is not None),
        _tables(study, content, about, name),
    )


def _made_by(about: Mapping[str, str]) -> str:
    named = ", ".join(f"{word} {about[word]}" for word in ("stage", "question", "key") if word in about)
    return named or "it does not say what made it"


def _inside(fields: list[Field], where: str, name: str) -> list[Field]:
    """The field at a path, or a group and the fields below it, the one at the path first; raises `StudyError`."""
    chosen = where.replace(".", "/").strip("/")
    inside = [field for field in fields if field.path == chosen or field.path.startswith(f"{chosen}/")]
    if not inside:
        known = {field.path: field.path.replace("/", ".") for field in fields}
        alike = [known[path] for path in known if path.rpartition("/")[2] == chosen.rpartition("/")[2]]
        hint = f"; did you mean {alike[0]}?" if alike else nearest(chosen.replace("/", "."), known.values())
        raise StudyError(f'{name}: there is no "{where}"{hint}')
    return inside


def _path(study: Study, name: str) -> Path:
    if name in study.graph.stages:
        return study.there(study.graph.stages[name].artefact)
    path = Path(name)
    if not path.exists():
        stages = ", ".join(study.graph.stages)
        raise StudyError(f'"{name}" is neither a stage ({stages}) nor a file{nearest(name, study.graph.stages)}')
    return path


def check_links(content: bytes, name: str) -> None:
    """Raises `StudyError` if a group or dataset in an artefact's bytes is reached by more than one plain link.

    A file of strangers can hold links, to itself in a circle or to other files, which ours never do.
    """
    import h5py

    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            links: dict[str, Any] = {}
            file.visititems_links(links.__setitem__)
            for path, link in links.items():
                if not isinstance(link, h5py.HardLink):
                    raise StudyError(f"{name}: {path} is a link to another place; artefacts have none")
            items = {h5py.h5o.get_info(file[path].id).addr for path in links} | {h5py.h5o.get_info(file.id).addr}
    except (OSError, RuntimeError, KeyError, ValueError):
        return  # whoever reads it says what is wrong
    if len(items) != len(links) + 1:
        raise StudyError(f"{name}: its groups lie in each other; those of artefacts do not")


def _give_part(content: bytes, fields: list[Field], form: options.Form) -> None:
    """Give what stands at the path of the first of `fields`: a value alone, rows of a table, or the fields below."""
    import h5py

    field, chosen = fields[0], fields[0].path
    with h5py.File(io.BytesIO(content), "r") as file:
        value = _whole(file[chosen])
    rows, plain = _rows(value), value if field.shape is None else {**_plain(field), "value": value}
    alone = value if field.shape is None else {field.path.rpartition("/")[2]: value}
    tables = _as_table(field, fields, rows) if field.shape is None and rows else []
    below = [] if tables else [_line(each, chosen.count("/")) for each in fields]
    lines = below if field.shape is None else _in_full(field, value)
    form.give(lines, plain, [alone] if rows is None else rows, tables)


def _in_full(field: Field, value: Any) -> Iterator[str]:
    """The lines of a value alone, with all its digits: a row of an array each, or one with its unit."""
    if isinstance(value, list):
        yield from (" ".join(map(str, part)) if isinstance(part, list) else str(part) for part in value)
    else:
        yield f"{str(value).lower() if isinstance(value, bool) else value} {field.shown_unit}".rstrip()


def _as_table(field: Field, fields: list[Field], rows: list[dict[str, Any]]) -> list[options.Table]:
    """The table of a group's rows, with units in its heads; none where a row has groups or arrays in it."""
    if any(isinstance(cell, (dict, list)) for row in rows for cell in row.values()):
        return []
    units = {each.path.rpartition("/")[2]: each.shown_unit for each in fields}
    heads = [f"{name} [{units[name]}]" if units.get(name) else name for name in rows[0]]
    return [(f"{field.path}: {field.description}".rstrip(": "), heads, [list(row.values()) for row in rows])]


def _whole(item: Any) -> Any:
    """A group as a mapping, a dataset as Python numbers and words."""
    if hasattr(item, "items"):
        from pipeline.cache import hdf5

        return {key: _whole(item[key]) for key in hdf5.members_of(item)}
    return None if item.shape is None else plain_values(item)


def plain_values(item: Any) -> Any:
    """The content of a dataset as Python numbers, words, or lists of them: None where there is none."""
    from pipeline.cache import hdf5

    value, none = hdf5.python(hdf5.read(item)), set(item.attrs.get(hdf5.NONE, ()))
    if not isinstance(value, list):
        return None if none else value
    return [None if index in none else each for index, each in enumerate(value)]


def _rows(value: Any) -> list[dict[str, Any]] | None:
    """The rows of a table, which is a mapping of numbered rows or of columns of one length, or of an array."""
    if isinstance(value, dict) and value:
        parts = list(value.values())
        if all(isinstance(part, dict) for part in parts) and all(name.isdecimal() for name in value):
            return parts
        if all(isinstance(part, list) and len(part) == len(parts[0]) for part in parts if isinstance(parts[0], list)):
            columns = zip(*parts) if isinstance(parts[0], list) else ()
            return [dict(zip(value, row)) for row in columns] or None
    if isinstance(value, list):
        return [{"value": part} for part in value]
    return None


def _size(shape: tuple[int, ...] | None) -> str:
    return " x ".join(map(str, shape or ()))


def _line(field: Field, above: int = 0) -> str:
    """A field: its name, indented by its depth, its value, and what it is, folded."""
    depth = field.path.count("/") - above
    name = "  " * (depth + 1) + field.path.rsplit("/", 1)[-1]
    if field.shape is None:
        return layout.beside(f"{name:<{_NAMES}} ", field.description)
    exact = isinstance(field.value, float) and field.error is not None and field.error <= _EXACT * abs(field.value)
    near, unit = "" if field.error is None or exact else f" +- {field.error:.0e}", f" {field.shown_unit}".rstrip()
    value = f"array {_size(field.shape)}" if field.value is None else layout.short(field.value)
    start = max(_NAMES, len(name)) + 1
    head = f"{name:<{start}}" + ("none" if field.value is None and field.shape == () else f"{value}{near}{unit}")
    column = min(_VALUES, layout.width() - _NAMES)
    if len(head) <= column:
        return layout.beside(f"{head:<{column}} ", field.description)
    below = [layout.beside(" " * column + " ", field.description)] if field.description else []
    return "\n".join([*layout.folded(head, start), *below])


def _plain(field: Field) -> dict[str, Any]:
    shape = None if field.shape is None else list(field.shape)
    return {"path": field.path, "unit": field.unit, "symbol": field.symbol, "shape": shape, "value": field.value,
            "description": field.description, "numerical_error": field.error}  # fmt: skip


def _tables(study: Study, content: bytes, about: Mapping[str, str], name: str) -> Iterator[options.Table]:
    """The tables a result offers by its method `tables()`: (title, column names, rows); of other tables none."""
    from pipeline.cache import artefact as artefacts

    stage = about.get("stage", "") if INGREDIENTS in about else ""
    if stage in study.parameters_classes() and hasattr(cls := result_class(study.package, stage), "tables"):
        yield from artefacts.decode(content, cls, name).tables()


def _give_account(study: Study, content: bytes, name: str, field: Field | None, form: options.Form) -> None:
    """Tell how an artefact, or a field of it, came about: as text, as JSON with all code, or parameters as rows.

    All of it is what artefacts say of their own making; lines are those where a parameter file states a value today.
    """
    from pipeline.cache import artefact as artefacts

    made = list(chain(study, {"stage": "?", **artefacts.provenance(content, name)}, name))
    head = [name] if field is None else list(_of_field(field, artefacts.tree(content, name), name))
    form.give(
        [*head, *(line for place, one in enumerate(made) for line in _stage_lines(one, made[:place]))],
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
                waiting.append((study.provenance(place), shown(place)))
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
                      set_for_a_run(plain.get("value"))}  # fmt: skip
        yield found


def _of_field(field: Field, tree: list[Field], name: str) -> Iterator[str]:
    """A field with its value and error, and the words beside it that distinguish rows, as the name of a run."""
    error = "" if field.error is None else f" +- {field.error:.1g}"
    value = "" if field.value is None else f" = {layout.short(field.value)}{error} {field.shown_unit}".rstrip()
    yield from layout.folded(f"{name}: {field.path.replace('/', '.')}{value}: {field.description}")
    for one in tree:
        group = one.path.rpartition("/")[0]
        if group and isinstance(one.value, str) and field.path.startswith(f"{group}/"):
            yield from layout.folded(f"  {one.path.replace('/', '.')}: {one.value}", 4)


def _stage_lines(one: Row, before: list[Row]) -> Iterator[str]:
    """A stage in words; parameters that one of those `before` used as well are only counted."""
    fresh = [each for each in one["parameters"] if not any(each in other["parameters"] for other in before)]
    above = len(one["parameters"]) - len(fresh)
    yield from ("", *layout.folded(f"stage {one['stage']}, {one['artefact']}, key {one['key']}", 4))
    yield f"  parameters: {len(fresh)}" + (f", and {above} that are listed above" if above else "")
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
