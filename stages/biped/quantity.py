"""What a number means: unit, symbol, description and bounds, kept beside the field that holds it.

Parameters and results are frozen dataclasses. Their fields are declared with `parameter` and `quantity`,
and everything that shows a number (error messages, HDF5 attributes, axis labels, tables) reads it from here.
"""

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Bound:
    """Closed or open interval a parameter must lie in; `None` means no limit on that side."""

    minimum: float | None = None
    maximum: float | None = None
    above: float | None = None
    below: float | None = None

    def holds(self, value: float) -> bool:
        """Whether `value` lies inside. NaN never does, an infinity never does."""
        return (
            value - value == 0.0
            and (self.minimum is None or value >= self.minimum)
            and (self.maximum is None or value <= self.maximum)
            and (self.above is None or value > self.above)
            and (self.below is None or value < self.below)
        )

    def __str__(self) -> str:
        limits = ((">=", self.minimum), (">", self.above), ("<=", self.maximum), ("<", self.below))
        return " and ".join(f"{sign} {limit:g}" for sign, limit in limits if limit is not None) or "any finite number"


@dataclass(frozen=True)
class Broken:
    """A rule between several values that does not hold: the key to blame, and what is allowed."""

    key: str
    allowed: str


def broken(*rules: tuple[bool, str, str]) -> Iterator[Broken]:
    """The rules that do not hold, of rows of whether one is broken, the key to blame, and what is allowed."""
    return (Broken(key, allowed) for is_broken, key, allowed in rules if is_broken)


def faults(section: Any) -> Iterator[Broken]:
    """What is wrong with an instance of a parameter class: values out of bounds or not among the choices, then rules.

    For sections made in code; those read from files are checked where they are read.
    """
    for field in dataclasses.fields(section):
        value, bound, choices = getattr(section, field.name), field.metadata["bound"], field.metadata["choices"]
        if isinstance(value, (int, float)) and not isinstance(value, bool) and not bound.holds(value):
            yield Broken(field.name, str(bound))
        words = {word for word in (value if isinstance(value, tuple) else (value,)) if isinstance(word, str)}
        if choices and not words <= set(choices):
            yield Broken(field.name, " or ".join(choices))
    if hasattr(section, "broken_rules"):
        yield from section.broken_rules()


def parameter(
    unit: str,
    description: str,
    *,
    symbol: str = "",
    bound: Bound | None = None,
    choices: tuple[str, ...] = (),
    default: Any = dataclasses.MISSING,
    file: bool = False,
    otherwise: str = "",
    closer: float | str | None = None,
) -> Any:
    """A field of a parameter dataclass. `unit` is "1" for a pure number and "-" for a word.

    The value of a `file` is a path; the stage finds the file among its inputs under the parameter's name. `otherwise`
    says what is allowed beside the choices. `closer` is what a run for the errors changes: a factor on the value, the
    most that it is (a whole number), or the word in its place.
    """
    metadata = {
        "unit": unit,
        "description": description,
        "symbol": symbol,
        "bound": bound or Bound(),
        "choices": choices,
        "file": file,
        "otherwise": otherwise,
        "closer": closer,
    }
    return dataclasses.field(metadata=metadata, default=default)


def half_widths(description: str) -> Any:
    """A field of a parameter dataclass that the engine fills: how far the values of its file may be off, by key.

    Values that are exact are not in it. See `docs/contributing.md` on a parameter.
    """
    metadata = {"unit": "-", "description": description, "symbol": "", "bound": Bound(), "choices": (),
                "half_widths": True}
    return dataclasses.field(metadata=metadata, default_factory=dict)


def count_of(number: int, what: str) -> str:
    """So many of something in words: 1 step, 2 steps."""
    return f"{number} {what}{'s' * (number != 1)}"


def written_out(number: float, digits: int = 3) -> str:
    """So many digits of a number, up to a million without a power of ten."""
    return f"{float(f'{number:.{digits}g}'):g}"


def mm(value: float) -> str:
    """A length [m] in mm, or a speed [m/s] before "/s": to two decimals, a small robot's to two digits."""
    number = 1e3 * value
    return f"{number:.2f} mm" if abs(number) >= 0.1 or not number else f"{written_out(number, 2)} mm"


#: Why what a search leaves, what is counted, and what is set has no numerical error.
LEFT, COUNTED = "it is what a solver leaves, an error itself", "it is a count, no number of the gait"
GIVEN = "it is a setting"


def quantity(
    unit: str,
    description: str,
    *,
    symbol: str = "",
    dimensions: tuple[str, ...] = (),
    default: Any = dataclasses.MISSING,
    without_error: str = "",
    unordered: str = "",
) -> Any:
    """A field of a result dataclass: what is stored, in which unit, under which symbol.

    `dimensions` names the axes of an array; fields of one class that share a name share its length. An axis without a
    name is the time, if it is the first and the class has a field `time` of its length, or else called FIELD_AXIS.
    `without_error` says why no numerical error is known of it, `unordered` what rows are whose order means nothing.
    """
    metadata = {"unit": unit, "description": description, "symbol": symbol, "dimensions": dimensions,
                "without_error": without_error, "unordered": unordered}
    return dataclasses.field(metadata=metadata, default=default)
