"""Results as HDF5: a dataclass becomes a group, each field a dataset with units, symbol, long name and dimensions.

A tuple of dataclasses becomes a table, a dataset for each column. The words are netCDF's, so that its readers
understand them (`hdf5.py`).

The same numbers give the same bytes on every run: no clock time, one library version, fields in order. Whether a stage
finds the same numbers to the last bit is another matter: on another processor it may not (`processor.py`).
A field `files` (path -> content) is not stored here; the pipeline writes it beside the artefact.
"""

from __future__ import annotations

import contextlib
import dataclasses
import io
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

import h5py

from pipeline.cache import hdf5
from pipeline.errors import ArtefactError

#: The form of artefacts: a program reads those of its own number.
_FORM, _NUMBER = "bipedstudy artefact", 2
FORMAT = f"{_FORM} {_NUMBER}"
PROVENANCE = "provenance"
#: Attribute of a number, an array or a column: an estimate of how far it is at most from what the finest computation
#: gives.
_ERROR = "numerical_error"
_SHORT = 8
T = TypeVar("T")


def encode(result: Any, provenance: Mapping[str, str]) -> bytes:
    """The HDF5 file of a result dataclass. `provenance` becomes the attributes of the group `provenance`.

    Raises `TypeError` for what cannot be stored.
    """
    with in_memory(result) as file:
        file[PROVENANCE].attrs.update(sorted(provenance.items()))
        return image(file)


def encoded(
    result: Any, provenance: Mapping[str, str], about: Mapping[str, str] | None = None,
    errors: Mapping[str, float] | None = None,
) -> tuple[bytes, bytes]:  # fmt: skip
    """The HDF5 file of a result dataclass that says nothing else, and the one that says how it was made as well.

    `about` (title, source, license, ...) are further attributes of the latter, `errors` (by path) become attributes of
    what lies there, in its units. Raises `TypeError` for what cannot be stored.
    """
    with in_memory(result) as file:
        plain = image(file)
        for name, text in (about or {}).items():
            file.attrs[name] = text
        for path, error in (errors or {}).items():
            if isinstance(file.get(path), h5py.Dataset):
                file[path].attrs[_ERROR] = error
        file[PROVENANCE].attrs.update(sorted(provenance.items()))
        return plain, image(file)


@contextlib.contextmanager
def in_memory(result: Any = None) -> Iterator[Any]:
    """A file in memory, of the form of artefacts, with a result and nothing of how it was made; or an empty one."""
    with h5py.File(
        "artefact", "w", driver="core", backing_store=False, libver=("v110", "v110"), track_order=True
    ) as file:
        file.attrs["format"] = FORMAT
        if result is not None:
            hdf5.write_fields(file, result)
            file.create_group(PROVENANCE)
        yield file


def image(file: Any) -> bytes:
    """The bytes of a file in memory."""
    file.flush()
    return bytes(file.id.get_file_image())


def decode(content: bytes, cls: type[T], name: str) -> T:
    """The result of class `cls` in an artefact's bytes. Raises `ArtefactError`; `name` is how it names the file."""
    with opened(content, name) as file:
        try:
            return typing.cast(T, hdf5.read_fields(file, cls))
        except (KeyError, TypeError, ValueError, OSError, RuntimeError) as error:
            reason = error.args[0] if error.args else error
            raise ArtefactError(f"{name}: its fields do not fit this version of the study ({reason})") from None


def load(path: Path, cls: type[T]) -> T:
    """Read the artefact at `path` as class `cls`. Raises `ArtefactError` for a truncated or foreign file."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ArtefactError(f"{path}: cannot be read: {error.strerror}") from None
    return decode(content, cls, str(path))


def provenance(content: bytes, name: str) -> dict[str, str]:
    """What the artefact says of its making: stage, key, parameters, versions, inputs."""
    with opened(content, name) as file:
        return {key: str(value) for key, value in file[PROVENANCE].attrs.items()}


@dataclasses.dataclass(frozen=True)
class Field:
    """One line of an artefact's tree: its path, unit, symbol, description, shape, value where it is short, and the
    estimate of its largest numerical error where there is one.
    """

    path: str
    unit: str
    symbol: str
    description: str
    shape: tuple[int, ...] | None
    value: Any
    error: float | None = None


def tree(content: bytes, name: str) -> list[Field]:
    """Every field of an artefact, groups included (their shape is None), in the order of declaration.

    Raises `ArtefactError` for text that cannot be read.
    """
    with opened(content, name) as file:
        try:
            return [field for key in hdf5.members_of(file) if key != PROVENANCE
                    for field in _branch(file[key], key)]  # fmt: skip
        except UnicodeDecodeError:
            raise ArtefactError(f"{name}: holds text that is not UTF-8; artefacts do not") from None


def _branch(item: Any, path: str) -> Iterator[Field]:
    unit, description, symbol = (str(item.attrs.get(key, "")) for key in hdf5.ATTRIBUTES)
    if isinstance(item, h5py.Group):
        yield Field(path, unit, symbol, description, None, None)
        for key in hdf5.members_of(item):
            yield from _branch(item[key], f"{path}/{key}")
    else:
        missing = item.shape is None or (not item.shape and hdf5.NONE in item.attrs)
        value = None if missing or item.size > _SHORT else hdf5.python(hdf5.read(item))
        error = float(item.attrs[_ERROR]) if _ERROR in item.attrs else None
        yield Field(path, unit, symbol, description, item.shape or (), value, error)


def opened(content: bytes, name: str) -> Any:
    try:
        file = h5py.File(io.BytesIO(content), "r")
    except OSError:
        what = "is empty" if not content else "is truncated or not an HDF5 file"
        raise ArtefactError(f"{name}: {what}; it cannot be read as an artefact of this study") from None
    form, _, number = str(file.attrs.get("format", "")).rpartition(" ")
    if form == _FORM and number == str(_NUMBER):
        return file
    file.close()
    if form == _FORM and number.isdecimal() and int(number) > 0:
        how = "a newer" if int(number) > _NUMBER else "an earlier"
        raise ArtefactError(
            f"{name}: made by {how} version of this program (format {number}); this one reads format {_NUMBER}"
            + ("; run its stage anew" if int(number) < _NUMBER else "")
        )
    raise ArtefactError(f'{name}: an HDF5 file, but not an artefact of this study (its format is not "{FORMAT}")')
