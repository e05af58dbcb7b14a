"""Results as HDF5: a dataclass becomes a group, each field a dataset with units, symbol, long name and dimensions.

Beside them, in the group `closer`, is the same result as closer solver settings give it: `SAFE` times what both differ
by is the numerical error of each number, and stages that read the one read the other, so that errors are carried along.

A tuple of dataclasses becomes a table, a dataset for each column. The words are netCDF's, so that its readers
understand them (`hdf5.py`).

A result's artefact shows what it and the files beside it hold, so that they can be taken where nothing else came along
(`sealed`).

The same numbers give the same bytes on every run: no clock time, one library version, fields in order. Whether a stage
finds the same numbers to the last bit is another matter: on another processor it may not (`processor.py`).
A field `files` (path -> content) is not stored here; the pipeline writes it beside the artefact.
"""

import contextlib
import dataclasses
import io
import re
from collections.abc import Iterator, Mapping
from typing import Any, TypeVar, cast

import h5py
import numpy as np

from pipeline.cache import disk, hdf5
from pipeline.cache.differences import differences, is_of_floats
from pipeline.errors import StudyError

#: The form of artefacts: a program reads those of its own number.
_FORM, _NUMBER = "bipedstudy artefact", 3
FORMAT = f"{_FORM} {_NUMBER}"
PROVENANCE, CLOSER = "provenance", "closer"
#: The group of the files of the closer result.
_FILES = "files"
#: Attributes of a result's provenance: digest of the file that says nothing else, and of this one but for that digest.
CONTENT, _OWN = "content", "sha256"
_WITH_ZEROS, _ZEROS = "with zeros in place of these digits: ", "0" * 64
#: Attribute of a number, an array or a column: its largest error, by what closer settings give. Of a file: why its
#: numbers have none.
ERROR, _WITHOUT = "numerical_error", "without_errors"
_SHORT = 8
#: Errors are so many times what closer settings change: 98 to 99 of 100 of drawn robots lie within, 95 to 99 within two
#: times (benchmarks/stated_errors.py).
SAFE = 3.0
#: Part of the largest error beside it that a number has at least.
SHARED = 0.03
#: In a path, the number of a row.
_ROW = re.compile(r"/\d+/")
T = TypeVar("T")


def encode(result: Any, provenance: Mapping[str, str]) -> bytes:
    """The HDF5 file of a result dataclass. `provenance` becomes the attributes of the group `provenance`.

    Raises `TypeError` for what cannot be stored.
    """
    with in_memory(result) as file:
        file[PROVENANCE].attrs.update(sorted(provenance.items()))
        return image(file)


def encoded(
    result: Any, provenance: Mapping[str, str], about: Mapping[str, str] | None = None, closer: Any = None
) -> tuple[bytes, bytes]:
    """The HDF5 file of a result dataclass that says nothing else, and the one that says how it was made as well.

    The latter is sealed. `about` (title, source, license, ...) are further attributes of it. `closer` is the result at
    closer settings, or why there is none; its files are in it. If it is of fewer points there are two, the first as
    `result` is. Raises `TypeError` for what cannot be stored.
    """
    like, closer = closer if isinstance(closer, tuple) else (None, closer)
    with in_memory(result) as file:
        if isinstance(closer, str):
            file.attrs[_WITHOUT] = closer
        elif closer is not None:
            for path, error in _errors(file, closer, like).items():
                file[path].attrs[ERROR] = float(f"{error:.2g}")
            group = file.create_group(CLOSER, track_order=True)
            hdf5.write_fields(group, closer)
            if files := getattr(closer, "files", {}):
                group = group.create_group(_FILES)
                hdf5.attach(group, {path: group.create_dataset(path, data=np.frombuffer(content, np.uint8))
                                    for path, content in files.items()}, {})  # fmt: skip
        plain = image(file)
        for name, text in (about or {}).items():
            file.attrs[name] = text
        own = {CONTENT: disk.digest(plain), _OWN: _WITH_ZEROS + _ZEROS}
        file[PROVENANCE].attrs.update(sorted({**provenance, **own}.items()))
        return plain, sealed(image(file))


def sealed(content: bytes) -> bytes:
    """An artefact with the digest of all its bytes in its place, as it was if that stood there; b"" without the place.

    It shows damage and edits, not forgery: whoever writes an artefact can seal it.
    """
    head, mark, tail = content.partition(_WITH_ZEROS.encode())
    rest = tail[len(_ZEROS) :]
    digits = disk.digest(b"".join((head, mark, _ZEROS.encode(), rest))).encode()
    return b"".join((head, mark, digits, rest)) if mark else b""


def _errors(file: Any, closer: Any, like: Any = None) -> dict[str, float]:
    """Of each number its error, by what it (or that of a result `like` this) differs by from the closer result; of rows
    that this lacks, or has as they are, the largest of the others.

    Numbers of one group and unit follow from one solution: one may agree by chance, and has `SHARED` of the largest.
    What has no unit may hold several, and says nothing of others.
    """
    first = contextlib.nullcontext(file) if like is None else in_memory(like, "like")
    with first as one, in_memory(closer, CLOSER) as other:
        apart = {path: change for path, change in differences(one, other) if path in file}
    found = {path: SAFE * change for path, (change, _) in apart.items()}
    units = {path: str(file[path].attrs.get("units", "")) for path in found}
    groups = {path: (path.rpartition("/")[0] if unit else path, unit) for path, unit in units.items()}
    beside = _largest(found, groups)
    found = {path: max(error, SHARED * beside[groups[path]]) for path, error in found.items()}
    every: dict[str, Any] = {}
    file.visititems(every.__setitem__)
    columns = {path: _ROW.sub("/*/", path) for path in every}
    alike = _largest(found, columns)
    return {path: max(found.get(path, 0.0) or alike[columns[path]], apart[path][1] if path in apart else 0.0)
            for path, item in every.items() if is_of_floats(item) and columns[path] in alike}


def _largest(found: Mapping[str, float], groups: Mapping[str, T]) -> dict[T, float]:
    """The largest number of each group."""
    largest: dict[T, float] = {}
    for path, error in found.items():
        largest[groups[path]] = max(error, largest.get(groups[path], 0.0))
    return largest


@contextlib.contextmanager
def in_memory(result: Any = None, name: str = "artefact") -> Iterator[Any]:
    """A file in memory, of the form of artefacts, with a result and nothing of how it was made; or an empty one."""
    with h5py.File(
        name, "w", driver="core", backing_store=False, libver=("v110", "v110"), track_order=True
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
    """The result of class `cls` in an artefact's bytes. Raises `StudyError`; `name` is how it names the file."""
    found = _decoded(content, cls, name, "/")
    assert found is not None
    return found


def decode_closer(content: bytes, cls: type[T], name: str) -> T | None:
    """The result that closer settings gave, with its files; None where there is none. Raises `StudyError`."""
    return _decoded(content, cls, name, CLOSER)


def _decoded(content: bytes, cls: type[T], name: str, where: str) -> T | None:
    with opened(content, name) as file:
        try:
            if where not in file:
                return None
            found = hdf5.read_fields(file[where], cls)
            files = _files_of(file[where])
            return cast(T, dataclasses.replace(found, files=files) if files else found)
        except (KeyError, TypeError, ValueError, OSError, RuntimeError) as error:
            reason = error.args[0] if error.args else error
            raise StudyError(f"{name}: its fields do not fit this version of the study ({reason})") from None


def closer_files(content: bytes, name: str) -> dict[str, bytes]:
    """The files beside the result that closer settings gave; none without one. Raises `StudyError`."""
    with opened(content, name) as file:
        return _files_of(file[CLOSER]) if CLOSER in file else {}


def _files_of(group: Any) -> dict[str, bytes]:
    kept = group.get(_FILES, {})
    return {path: kept[path][()].tobytes() for path in hdf5.members_of(kept)}


def provenance(content: bytes, name: str, older: bool = False) -> dict[str, str]:
    """What the artefact says of its making: stage, key, parameters, versions, inputs; a map's table of an earlier
    program says nothing. `older` as in `tree`.
    """
    with opened(content, name, older) as file:
        return {key: str(value) for key, value in file[PROVENANCE].attrs.items()} if PROVENANCE in file else {}


def without_errors(content: bytes, name: str) -> str:
    """Why the numbers of an artefact carry no errors; nothing where they do, or where nothing is solved."""
    with opened(content, name) as file:
        return str(file.attrs.get(_WITHOUT, ""))


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

    @property
    def shown_unit(self) -> str:
        """Its unit beside a value; nothing for a number or a word."""
        return "" if self.unit in ("1", "-") else self.unit


def tree(content: bytes, name: str, older: bool = False) -> list[Field]:
    """Every field of an artefact, groups included (their shape is None), in the order of declaration.

    With `older` that of an earlier form is read as well. Raises `StudyError` for text that cannot be read.
    """
    with opened(content, name, older) as file:
        try:
            return [field for key in hdf5.members_of(file) if key not in (PROVENANCE, CLOSER)
                    for field in _branch(file[key], key)]  # fmt: skip
        except UnicodeDecodeError:
            raise StudyError(f"{name}: holds text that is not UTF-8; artefacts do not") from None


def _branch(item: Any, path: str) -> Iterator[Field]:
    unit, description, symbol, *_ = (str(item.attrs.get(key, item.attrs.get(first, "")))
                                    for key, first in hdf5.ATTRIBUTES.items())  # fmt: skip
    if isinstance(item, h5py.Group):
        yield Field(path, unit, symbol, description, None, None)
        for key in hdf5.members_of(item):
            yield from _branch(item[key], f"{path}/{key}")
    else:
        missing = item.shape is None or (not item.shape and hdf5.NONE in item.attrs)
        value = None if missing or item.size > _SHORT else hdf5.python(hdf5.read(item))
        error = float(item.attrs[ERROR]) if ERROR in item.attrs else None
        yield Field(path, unit, symbol, description, item.shape or (), value, error)


def is_older(content: bytes, name: str) -> bool:
    """Whether an artefact has an earlier form. Raises `StudyError` if it is none."""
    with opened(content, name, older=True) as file:
        return str(file.attrs["format"]) != FORMAT


def opened(content: bytes, name: str, older: bool = False) -> Any:
    """The file in an artefact's bytes; `older` takes those of earlier forms. Raises `StudyError`."""
    try:
        file = h5py.File(io.BytesIO(content), "r")
    except OSError:
        what = "is empty" if not content else "is truncated or not an HDF5 file"
        raise StudyError(f"{name}: {what}; it cannot be read as an artefact of this study") from None
    form, _, number = str(file.attrs.get("format", "")).rpartition(" ")
    known = form == _FORM and number.isdecimal() and int(number) > 0
    if known and (int(number) == _NUMBER or (older and int(number) < _NUMBER)):
        return file
    file.close()
    if known:
        how = "a newer" if int(number) > _NUMBER else "an earlier"
        raise StudyError(
            f"{name}: made by {how} version of this program (format {number}); this one reads format {_NUMBER}"
            + ("; run its stage anew" if int(number) < _NUMBER else "")
        )
    raise StudyError(f'{name}: an HDF5 file, but not an artefact of this study (its format is not "{FORMAT}")')
