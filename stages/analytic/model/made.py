"""Modules of which only the text's maker is in the tree: equations that sympy derives at their first use, and functions
that name each number of a kind of walker, written out for each: machine code knows no loop over names.

Their text is kept where machine code is kept. Two processes that need it at once both make it, as on two processors
neither would be sooner by waiting; each leaves it whole, and the same.
"""

import sys
from collections.abc import Callable, Mapping
from functools import partial
from types import ModuleType
from typing import Any, get_args

from stages.analytic.compiled import FOLDER, ByKind
from stages.analytic.errors import NotDerived
from stages.analytic.model.kinds import Detailed, Plain, exchange
from stages.biped.machine_code import Kept, sympy_version

DERIVING = "deriving the equations of motion, some 5 s, once after an install or an edit"
#: The folder's name has the version, as text that came with the program serves where there is no sympy.
EQUATIONS = Kept(f"equations-{sympy_version()}", FOLDER / "model", by=f"sympy {sympy_version()}")


class Made(ModuleType):
    """A module whose `text` is made, and run with what is `given`, when something of it is first requested."""

    def __init__(self, name: str, text: Callable[[], str], **given: Any) -> None:
        super().__init__(name)
        vars(self).update(given)
        self._text: Callable[[], str] | None = text
        sys.modules[name] = self  # machine code that is loaded names the modules it is of

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or self._text is None:
            raise AttributeError(f"{self.__name__} has no {name}")
        exec(compile(self._text(), self.__name__, "exec", dont_inherit=True), vars(self))
        self._text = None
        return getattr(self, name)


class OfSets(ByKind):
    """The function `name` of each set of equations; `sets` has their modules by the kinds that they are for.

    Only the sets of the kinds that are requested are made. The type of the last argument decides.
    """

    def __init__(self, name: str, sets: Mapping[Any, Any]) -> None:
        self.name, self.choices, self.chosen, self.place = name, sets, {}, -1

    def of(self, kind: type) -> Any:
        """The function for a kind of walker."""
        return getattr(super().of(kind), self.name)


def derived(kept: Kept, name: str, maker: Callable[[str], Callable[[], str]]) -> str:
    """The text of a module of equations. Raises NotDerived where it is to be made and sympy is missing."""

    def made() -> str:
        try:
            make = maker(name)
        except ImportError as missing:
            raise NotDerived(f"the equations of motion cannot be derived without sympy ({missing}): install it, or a "
                             "wheel that brings them") from None  # fmt: skip
        print(f"note: {DERIVING}: {name.replace('_', ' ')}", file=sys.stderr, flush=True)
        return make()

    return kept.text(f"{name}.txt", made)


def by_sympy(name: str) -> Callable[[], str]:
    """What makes the text of one of this package's modules of equations."""
    from stages.analytic.model.generate import SOURCES

    return SOURCES[name]


def sets(what: str) -> dict[Any, Any]:
    """`what` there is of the equations of each set, as modules: terms, or derivatives of these."""
    return {kinds: Made(f"{__name__}.{name}_{what}", partial(derived, EQUATIONS, f"{name}_{what}", by_sympy))
            for kinds, name in ((Plain, "plain"), (Detailed, "detailed"))}  # fmt: skip


#: Detailed kinds, those of stiff legs before what they are made of; and all kinds, stiff or not.
EXCHANGED: list[Any] = [each for kind in get_args(Detailed) for each in (*kind.__subclasses__(), kind)]
ROWS: tuple[Any, ...] = get_args(Plain | Detailed)


def written_out() -> str:
    """exchanged_KIND(p): the walker with its legs exchanged; row_KIND(p, a, row): a row of `a` (n, fields) as one."""
    lines = ["import numpy as np", "", "from stages.analytic.compiled import compiled",
             "from stages.analytic.model.kinds import *"]
    for kind in EXCHANGED:
        order, hinge = exchange(kind._fields)
        values = [f"p.{kind._fields[place]}" for place in order]
        values[hinge] = f"-{values[hinge]}"
        lines += function(f"exchanged_{kind.__name__}", f"p: {kind.__name__}", kind, values)
    for kind in ROWS:
        lines += function(f"row_{kind.__name__}", f"p: {kind.__name__}, a: np.ndarray, row: int", kind,
                          [f"a[row, {place}]" for place in range(len(kind._fields))])
    return "\n".join(lines)


def function(name: str, arguments: str, kind: Any, values: list[str]) -> list[str]:
    """Source of a function that gives a walker of a kind."""
    return ["", "", "@compiled", f"def {name}({arguments}) -> {kind.__name__}:",
            f"    return {kind.__name__}({', '.join(values)})"]  # fmt: skip


WRITTEN = Made(f"{__name__}.written", written_out)


def of_each(called: str, kinds: list[Any] | tuple[Any, ...]) -> dict[Any, Any]:
    """The functions of kinds that are called `called` with the kind's name."""
    return {kind: getattr(WRITTEN, f"{called}_{kind.__name__}") for kind in kinds}
