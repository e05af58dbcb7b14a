"""`bipedstudy show ARTEFACT`: what is inside a result."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline import completion, layout, requests
from pipeline.commands import options, status
from pipeline.errors import ArtefactError, StudyError, nearest
from pipeline.stage_modules import result_class
from pipeline.study import Study, shown

if TYPE_CHECKING:
    from pipeline.cache.artefact import Field


#: Columns before a field's value, and before what it is.
_NAMES, _VALUES = 30, 49
#: A number whose error is no larger part of it than this, which is round-off, is shown without.
_EXACT = 1e-13


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
    made_by, fields = about.get("stage", ""), artefacts.tree(content, name)
    inside = [] if where is None else _inside(fields, where, name)
    if why:
        from pipeline.commands import why as account

        account.give(study, content, name, inside[0] if inside else None, form)
        return
    if where is not None:
        _give_part(content, inside, form)
        return
    lines = [f"{name}: stage {about.get('stage', '?')}, key {about.get('key', '?')}"]
    lines += [line for text in requests.kept(study, about) for line in layout.folded(text)]
    if without := artefacts.without_errors(content, name):
        lines += layout.folded(f"its numbers carry no errors: {without}")
    form.give(
        [*lines, *map(_line, fields)],
        {"file": name, "fields": [_plain(field) for field in fields], "provenance": about, "without_errors": without},
        ({**_plain(field), "shape": _size(field.shape)} for field in fields if field.shape is not None),
        _tables(study, content, made_by, name),
    )


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
    """Raises `ArtefactError` if a group or dataset in an artefact's bytes is reached by more than one plain link.

    A file of strangers can hold links, to itself in a circle or to other files, which ours never do.
    """
    import h5py

    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            links: list[tuple[str, Any]] = []
            file.visititems_links(lambda path, link: links.append((path, link)))
            for path, link in links:
                if not isinstance(link, h5py.HardLink):
                    raise ArtefactError(f"{name}: {path} is a link to another place; artefacts have none")
            items = {h5py.h5o.get_info(file[path].id).addr for path, _ in links} | {h5py.h5o.get_info(file.id).addr}
    except (OSError, RuntimeError, KeyError, ValueError):
        return  # whoever reads it says what is wrong
    if len(items) != len(links) + 1:
        raise ArtefactError(f"{name}: its groups lie in each other; those of artefacts do not")


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
    """The content of a dataset as Python numbers, words, or lists of them: None where there is none, a word by name."""
    import h5py

    from pipeline.cache import hdf5

    value, none = hdf5.python(hdf5.read(item)), set(item.attrs.get(hdf5.NONE, ()))
    if not isinstance(value, list):
        return None if none else value
    words = {place: word for word, place in (h5py.check_enum_dtype(item.dtype) or {}).items()}
    return [None if index in none else words.get(each, each) if words else each for index, each in enumerate(value)]


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
    if len(head) <= _VALUES:
        return layout.beside(f"{head:<{_VALUES}} ", field.description)
    below = [layout.beside(" " * _VALUES + " ", field.description)] if field.description else []
    return "\n".join([*layout.folded(head, start), *below])


def _plain(field: Field) -> dict[str, Any]:
    shape = None if field.shape is None else list(field.shape)
    return {"path": field.path, "unit": field.unit, "symbol": field.symbol, "shape": shape, "value": field.value,
            "description": field.description, "numerical_error": field.error}  # fmt: skip


def _tables(study: Study, content: bytes, stage: str, name: str) -> Iterator[options.Table]:
    """The tables a result offers by its method `tables()`: (title, column names, rows)."""
    from pipeline.cache import artefact as artefacts

    if stage in study.parameters_classes() and hasattr(cls := result_class(study.package, stage), "tables"):
        yield from artefacts.decode(content, cls, name).tables()
