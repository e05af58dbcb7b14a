"""What a stage can be asked at the command line, declared without the command line.

Each file in a stage's folder `questions` is one question, its `QUESTION`. The engine makes a command of it, which reads
and checks the options, prints the answer as text or JSON, draws it, keeps its files, and shows progress. Such a file
must be quick to import: what computes the answer is imported when it is requested.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from difflib import get_close_matches
from numbers import Real
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeVar

from stages.biped.quantity import parameter

Given = TypeVar("Given", bound=Collection[Any])
#: Where an entry stands in the file, by its keys.
Place = Callable[..., str]


class WrongOption(ValueError):
    """An option's value is not allowed; the message is one sentence that names the option."""


def refuse(*rows: tuple[bool, str]) -> None:
    """Refuse an option for the first of the rows that holds: whether it does, and the sentence. Raises WrongOption."""
    for holds, sentence in rows:
        if holds:
            raise WrongOption(sentence)


def place_of(given: Any) -> Place:
    """Where the entries of a file's content stand in it: file, line and key; of what was not read from one the key."""
    place: Place = getattr(given, "place", lambda *keys: ".".join(map(str, keys)))
    return place


def only(
    given: Given, allowed: Collection[str], place: Place, *keys: str, wrong: str = "there is no such entry; known are"
) -> Given:
    """What is `given` at some keys. Raises WrongOption where it is no mapping, or has entries that are not `allowed`.
    """
    refuse((not isinstance(given, Mapping), f"{place(*keys)}: expected lines of the form key: value"))
    for key in given:
        if key not in allowed:
            near = get_close_matches(str(key), allowed, 1)
            hint = f"; did you mean {near[0]}?" if near else ""
            raise WrongOption(f"{place(*keys, key)}: {wrong} {', '.join(allowed)}{hint}")
    return given


def number(
    given: Any, where: str, least: float = -math.inf, most: float = math.inf, *, whole: bool = False
) -> float:  # fmt: skip
    """A number within limits. Raises WrongOption that says where it stands."""
    is_number = not isinstance(given, bool) and isinstance(given, Real) and math.isfinite(given)
    limits = f" from {least:.12g}" * math.isfinite(least) + f" to {most:.12g}" * math.isfinite(most)
    refuse((not is_number or not least <= given <= most or (whole and given % 1 != 0),
            f"{where}: {given!r}, must be a {'whole ' * whole}number{limits}"))
    return float(given)


def at_hand(reader: Callable[..., Iterator[Any]], source: Path, *given: Any) -> Iterator[Any]:
    """What a reader yields in this process: of files that the study made, or in one that is confined already."""
    return reader(source, *given)


def option(
    unit: str,
    description: str,
    *,
    default: Any = dataclasses.MISSING,
    name: str = "",
    metavar: str = "",
    positional: bool = False,
    read: Callable[[str, str], Any] | None = None,
    **allowed: Any,
) -> Any:
    """A field of an options dataclass: as `parameter`, and how it is given.

    `allowed` is its bound or choices; `name` is the option's name where the field's will not do; a `positional` one has
    none. A bool is a flag; a tuple of words may be given again and again; the option of a mapping names a YAML file
    (the value is `Described`); a positional one with a default may be left out.
    `read` makes the value of the text and of the option's name, for messages; it raises `WrongOption`.
    """
    given = {"name": name, "metavar": metavar, "positional": positional, "read": read}
    described = parameter(unit, description, **allowed).metadata
    return dataclasses.field(metadata={**described, **given}, default=default)


def interval(text: str, what: str) -> tuple[float, float]:
    """Two numbers "LOW:HIGH" with low < high; `what` names the option. Raises `WrongOption`."""
    low, _, high = text.partition(":")
    try:
        limits = float(low), float(high)
    except ValueError:
        limits = 1.0, 0.0
    if not limits[0] < limits[1] or not all(abs(value) < float("inf") for value in limits):
        raise WrongOption(f"{what}: {text!r} is not two numbers LOW:HIGH with LOW < HIGH")
    return limits


class Asking(Protocol):
    """What the engine hands to a question."""

    jobs: int

    def progress(self, fraction: float, what: str) -> None:
        """Show the fraction done (0 to 1) and a few words, where somebody looks on."""

    def note(self, text: str) -> None:
        """Say a line beside the answer."""

    def each(self, function: Callable[..., Any], arguments: Sequence[Any], *shared: Any) -> Iterator[Any]:
        """What the function answers to each argument, in their order, from a pool of processes.

        The function stands in a module and is given the stage's parameters, what is `shared`, and an argument; what it
        computes follows from these and the code alone. All but the parameters, the answers too, are what JSON knows.
        Answers are kept, so a question that is stopped goes on where it was.
        """

    def reading(self, reader: Callable[..., Iterator[Any]], source: Path, *given: Any, writes: Path | None = None
                ) -> Iterator[Any]:  # fmt: skip
        """What `reader(source, *given)` yields, which reads a file or folder from outside and fills the file `writes`.

        It runs in a process that can do nothing else. The reader stands in a module; what it is given is what JSON
        knows, what it yields are arrays of numbers as well. Raises `WrongOption`.
        """

    def lines(self) -> Iterator[str]:
        """Lines of standard input as they come; one that is too long for a row is empty."""

    def say(self, row: Mapping[str, Any]) -> None:
        """Print a row at once, a line of JSON. Raises BrokenPipeError where nobody reads it any longer."""

    def result(self, stage: str = "") -> tuple[Any, str]:
        """A stage's result, or its own, as it lies among the study's, and its file; None, and why, without one."""

    def keep(self, content: bytes) -> None:
        """Keep a proof of the study's design, made or checked in this process, beside its results."""

    def new_file(self, path: Path) -> AbstractContextManager[Path]:
        """A path to write to; what stands there at the end of the context appears as `path`, whole or not at all."""

    def new_table(
        self, path: Path | None, columns: Sequence[Column], size: int, about: Mapping[str, str]
    ) -> AbstractContextManager[Table]:
        """A table of `size` rows in a new HDF5 file, with what is said `about` it; without a path it is not kept."""


class Described(Protocol):
    """The content of a YAML file that an option of a mapping names: a plain mapping that knows its lines."""

    def place(self, *keys: Any) -> str:
        """File, line and key of the entry under these keys, one inside the other, for messages."""

    def get(self, key: str, default: Any = None) -> Any:
        """The plain value of an outermost key."""

    def __iter__(self) -> Iterator[str]:
        """The outermost keys."""


@dataclass(frozen=True)
class Column:
    """A column of a table; one with words holds their numbers."""

    name: str
    unit: str
    description: str
    words: tuple[str, ...] = ()


class Table(Protocol):
    """A table that is written block by block; the same blocks in the same order give the same file."""

    def write(self, first: int, values: Mapping[str, Any]) -> None:
        """Values (n,) of columns, by name, in the rows from `first` on."""

    def read(self, name: str, every: int = 1) -> Any:
        """A column (rows,), or each so manyth row of it."""


@dataclass(frozen=True)
class Answer:
    """An answer as text (`lines`, then `tables` of title, columns, rows), as JSON (`plain`), CSV (`rows`), and picture.

    `draw` is given what saves a figure. `files` (by name) and every parameter file, with `parameters` ("file.key")
    changed, go into the folder of --into. `remark` is said beside the answer; `no` marks an answer that is no.
    """

    lines: Sequence[str] = ()
    plain: Any = None
    tables: Sequence[tuple[str, Sequence[str], Sequence[Sequence[Any]]]] = ()
    rows: Sequence[Mapping[str, Any]] = ()
    draw: Callable[[Callable[[Any], None]], None] | None = None
    files: Mapping[str, bytes] = dataclasses.field(default_factory=dict)
    parameters: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    remark: str = ""
    no: bool = False


@dataclass(frozen=True)
class Question:
    """A question: `ask(parameters of the stage, options, asking)` gives an `Answer`.

    `key` stands for the answer in JSON where there is none; `draws` and `pool` say whether it draws and takes --jobs,
    `rows` whether its answer has rows for --csv; `leaves` says what it leaves in the folder of --into, if anything;
    `examples` are command lines for its help.
    """

    name: str
    help: str
    options: type
    ask: Callable[[Any, Any, Asking], Answer]
    key: str = ""
    draws: bool = False
    pool: bool = False
    rows: bool = False
    leaves: str = ""
    examples: tuple[str, ...] = ()
    wrong: ClassVar[type[Exception]] = WrongOption


def as_plain(record: Any) -> dict[str, Any]:
    """The fields of a result as JSON; a nested one as named values with units."""
    plain: dict[str, Any] = {}
    for field in dataclasses.fields(record):
        value = getattr(record, field.name)
        if dataclasses.is_dataclass(value):
            plain[field.name] = {
                part.name: {"value": float(getattr(value, part.name)), "unit": part.metadata["unit"]}
                for part in dataclasses.fields(value)
            }
        else:
            plain[field.name] = value.tolist() if hasattr(value, "tolist") else value
    return plain


def elasticity(value: float, width: int) -> str:
    """An elasticity in a column of that width: four decimals, fewer where it is large, a dash where it is not known."""
    digits = "-" if value != value else f"{value:+.4f}" if abs(value) < 10.0 else f"{value:+.5g}"
    return f"{digits:>{width}}"
